//! The tests, and what is run beside them: benches and soaks.

use crate::checkout::{self, Checkout, Failure};
use crate::{manifold, peers, plugins, tidy};

/// All tests of the workspace; `--full` adds the slow ones, a further word filters by name.
pub fn run(checkout: &Checkout, words: &[&str]) -> Result<(), Failure> {
    let full = words.contains(&"--full");
    let filters: Vec<&str> = words.iter().copied().filter(|w| *w != "--full").collect();
    let peers = peers::ensure(checkout)?;
    manifold::ensure(&checkout.root)?;
    checkout::run(&mut checkout.cargo(&["build", "--release", "--workspace", "--exclude", "xtask"]))?;
    let mut tests =
        checkout.cargo(&["test", "--release", "--workspace", "--exclude", "xtask", "--no-fail-fast"]);
    tests.env("FIBAR_PEERS", peers).env("FIBAR_BIN", checkout.target().join("release"));
    if filters.is_empty() {
        tidy::check_architecture(checkout)?;
    }
    if full {
        tests.env("FIBAR_TEST_FULL", "1");
    }
    checkout::run(tests.arg("--").args(filters))
}

/// The benches: ratios to peers, printed as a table.
pub fn bench(checkout: &Checkout, words: &[&str]) -> Result<(), Failure> {
    plugins::compile_all(checkout)?;
    let mut benches =
        checkout.cargo(&["run", "--release", "--quiet", "--package", "fibar-tests", "--bin", "bench", "--"]);
    checkout::run(benches.args(words).env("FIBAR_BIN", checkout.target().join("release")))
}

/// The long form of the kill and concurrency tests.
pub fn soak(checkout: &Checkout) -> Result<(), Failure> {
    let mut tests =
        checkout.cargo(&["test", "--release", "--package", "fibar-tests", "--", "--nocapture", "soak"]);
    plugins::compile_all(checkout)?;
    checkout::run(tests.env("FIBAR_SOAK", "1").env("FIBAR_BIN", checkout.target().join("release")))
}
