//! The one command of a checkout: `cargo xtask build | verify | test | bench | tidy`.
//!
//! It fetches what the registries have to give (pinned by hash), compiles what a recipe names, and hands over to the
//! `fibar` program. It knows no recipe format and no artefact, and depends on nothing of ours.

mod checkout;
mod features;
mod manifold;
mod opensubdiv;
mod peers;
mod plugins;
mod test;
mod tidy;

use checkout::{Checkout, Failure};
use std::process::ExitCode;

const HELP: &str = "\
The one command of a checkout of fibar.

  cargo xtask build RECIPE...         compile what the recipes name, build them, print what came out and where
  cargo xtask verify RECIPE...        the same, then fail on any collision, thin wall or other broken rule
  cargo xtask fibar ARGUMENTS...      any other command of the program: plan, explain, cache, plugin, ...
  cargo xtask test [--full] [FILTER]  set up what the tests need and run them all (--full: the slow ones too)
  cargo xtask bench [NAME]            ratios to peers, measured in one run
  cargo xtask soak                    the long form of the kill and concurrency tests
  cargo xtask tidy [--fix]            formatting, lints, and ARCHITECTURE.md against the real crates
  cargo xtask setup                   fetch and compile everything, run nothing

Options after a RECIPE go to the program: see `cargo xtask fibar build --help`.
Artefacts are kept in target/store and reused; what people open lands in build/NAME/.
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match run(&words) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Exit(code)) => ExitCode::from(code),
        Err(Failure::Message(message)) => {
            eprintln!("xtask: {message}");
            ExitCode::from(2)
        }
    }
}

fn run(words: &[&str]) -> Result<(), Failure> {
    let checkout = Checkout::find()?;
    match words {
        [] | ["help" | "--help" | "-h", ..] => {
            print!("{HELP}");
            Ok(())
        }
        [command @ ("build" | "verify"), rest @ ..] => plugins::run_recipes(&checkout, command, rest),
        ["fibar", rest @ ..] => plugins::run_program(&checkout, rest),
        ["test", rest @ ..] => test::run(&checkout, rest),
        ["bench", rest @ ..] => test::bench(&checkout, rest),
        ["soak"] => test::soak(&checkout),
        ["tidy"] => tidy::check(&checkout),
        ["tidy", "--fix"] => tidy::fix(&checkout),
        ["setup"] => test::set_up(&checkout),
        [other, ..] => Err(Failure::Message(format!("no such task: {other}\n\n{HELP}"))),
    }
}
