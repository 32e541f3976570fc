//! The tests, and what is run beside them: benches and soaks.

use crate::checkout::{self, Checkout, Failure};
use crate::{peers, plugins, tidy};
use std::path::PathBuf;
use std::process::Command;

/// All tests of the workspace; `--full` adds the slow ones, a further word filters by name.
pub fn run(checkout: &Checkout, words: &[&str]) -> Result<(), Failure> {
    let full = words.contains(&"--full");
    let filters: Vec<&str> = words.iter().copied().filter(|w| *w != "--full").collect();
    if filters.is_empty() {
        tidy::check_architecture(checkout)?;
    }
    let peers = peers::ensure(checkout)?;
    plugins::compile_all(checkout)?;
    let mut tests = cargo_test(checkout);
    tests.arg("--no-fail-fast").env("FIBAR_PEERS", peers);
    if full {
        peers::ensure_menders(checkout)?;
        tests.env("FIBAR_TEST_FULL", "1");
    }
    checkout::run(tests.arg("--").args(filters))
}

/// Compiles everything and runs nothing.
pub fn set_up(checkout: &Checkout) -> Result<(), Failure> {
    plugins::compile_all(checkout)?;
    checkout::run(cargo_test(checkout).arg("--no-run"))
}

fn cargo_test(checkout: &Checkout) -> Command {
    let mut tests = checkout.cargo(&["test", "--release", "--workspace", "--exclude", "xtask"]);
    tests.env("FIBAR_BIN", executables(checkout));
    tests
}

/// Where the tests find the program, the plugins and the stages of `fibar-engine/examples`.
fn executables(checkout: &Checkout) -> PathBuf {
    checkout.target().join("release")
}

/// The benches: ratios to peers, printed as a table.
pub fn bench(checkout: &Checkout, words: &[&str]) -> Result<(), Failure> {
    if words.is_empty() || words.iter().any(|word| *word == "meshes" || word.starts_with("repair")) {
        peers::ensure_menders(checkout)?;
    }
    plugins::compile_all(checkout)?;
    let mut benches =
        checkout.cargo(&["run", "--release", "--quiet", "--package", "fibar-tests", "--bin", "bench", "--"]);
    checkout::run(benches.args(words).env("FIBAR_BIN", executables(checkout)))
}

/// The long form of the kill and concurrency tests, one after the other.
pub fn soak(checkout: &Checkout) -> Result<(), Failure> {
    plugins::compile_all(checkout)?;
    let mut tests = cargo_test(checkout);
    tests.args(["--test", "engine", "--", "--nocapture", "--test-threads=1", "soak"]);
    checkout::run(tests.env("FIBAR_SOAK", "1"))
}
