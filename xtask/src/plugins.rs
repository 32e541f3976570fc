//! From the recipes named to the plugins compiled, and on to the program.

use crate::checkout::{Checkout, Failure, run, run_quietly};
use crate::{manifold, opensubdiv};
use std::collections::BTreeSet;
use std::process::Command;

/// `fibar build` or `fibar verify`, after compiling the plugins that the recipes name and no others.
pub fn run_recipes(checkout: &Checkout, command: &str, words: &[&str]) -> Result<(), Failure> {
    let recipes: Vec<&str> = words.iter().copied().filter(|w| w.ends_with(".toml")).collect();
    if recipes.is_empty() {
        return Err(Failure::Message(format!("which recipe? Try: cargo xtask {command} recipes/bunny.toml")));
    }
    compile(checkout, &BTreeSet::from(["fibar".to_string()]))?;
    let named = named_plugins(checkout, &recipes)?;
    // A name that is no folder of ours may be somebody's own plugin: the program finds it or says what it looked for.
    let ours =
        named.into_iter().filter(|name| checkout.path("plugins").join(name).join("Cargo.toml").exists());
    compile(checkout, &ours.collect())?;
    run(program(checkout).arg(command).args(words))
}

/// The program with any arguments; plugins as they were last compiled.
pub fn run_program(checkout: &Checkout, words: &[&str]) -> Result<(), Failure> {
    compile(checkout, &BTreeSet::from(["fibar".to_string()]))?;
    run(program(checkout).args(words))
}

/// The program, all plugins, and the stages that only tests run.
pub fn compile_all(checkout: &Checkout) -> Result<(), Failure> {
    ensure_libraries(checkout)?;
    let everything = ["build", "--release", "--workspace", "--exclude", "xtask", "--bins", "--examples"];
    run(&mut checkout.cargo(&everything))
}

/// What is compiled in and is not the Rust registry's to give.
pub fn ensure_libraries(checkout: &Checkout) -> Result<(), Failure> {
    manifold::ensure(&checkout.root)?;
    Ok(opensubdiv::ensure(&checkout.root)?)
}

/// The program, with this checkout's plugins and store.
pub fn program(checkout: &Checkout) -> Command {
    let mut command = Command::new(checkout.executable("fibar"));
    if std::env::var_os("FIBAR_STORE").is_none() {
        command.env("FIBAR_STORE", checkout.target().join("store"));
    }
    command
}

/// Which plugins the recipes name, by the program's own reading of them.
fn named_plugins(checkout: &Checkout, recipes: &[&str]) -> Result<BTreeSet<String>, Failure> {
    let mut command = program(checkout);
    command.args(["plugin", "required"]).args(recipes);
    let names = run_quietly(&mut command).map_err(|_| Failure::Exit(2));
    // Its message was swallowed with its output: let it speak.
    let names = names.or_else(|failure| run(&mut command).and(Err(failure)))?;
    Ok(names.lines().map(str::to_string).collect())
}

fn compile(checkout: &Checkout, packages: &BTreeSet<String>) -> Result<(), Failure> {
    if packages.is_empty() {
        return Ok(());
    }
    if packages.iter().any(|name| uses(checkout, name, "fibar-solid")) {
        manifold::ensure(&checkout.root)?;
    }
    if packages.iter().any(|name| uses(checkout, name, "opensubdiv-petite")) {
        opensubdiv::ensure(&checkout.root)?;
    }
    let mut command = checkout.cargo(&["build", "--release"]);
    packages.iter().for_each(|name| {
        command.args(["--package", name]);
    });
    run(&mut command)
}

fn uses(checkout: &Checkout, package: &str, dependency: &str) -> bool {
    let manifest = checkout.path("plugins").join(package).join("Cargo.toml");
    std::fs::read_to_string(manifest).is_ok_and(|text| text.lines().any(|l| l.starts_with(dependency)))
}
