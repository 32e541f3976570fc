//! One chain built as far as its routes, and what the verifiers say of them.

use super::router::{self, Words};
use crate::recipe::Recipe;
use fibar_tests::{checkout, executables};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What came out of a chain.
pub struct Measured {
    metrics: Value,
    /// Processor seconds of the router alone, one thread.
    pub seconds: Option<f64>,
    /// Why it routed nothing.
    pub refusal: Option<String>,
}

/// Columns: head, metric, digits after the point.
pub type Column = (&'static str, &'static str, usize);

/// Builds what routing and its measures need of a recipe, in the checkout's store: chains share what they
/// have in common, and a second bench runs nothing again but the router, for its time.
pub fn measure(name: &str, recipe: Recipe, words: Words) -> Result<Measured, String> {
    let router = recipe.router().to_owned();
    let worded =
        |recipe: Recipe, (key, value): &(&str, &str)| recipe.set(&router, key, &format!("{value:?}"));
    let recipe = words.iter().fold(recipe.for_routing(), worded);
    let inputs = build(&format!("{name}-inputs"), recipe.clone().before_route())?;
    let alone = folder().join("alone").join(name);
    let (seconds, refusal) = router::run(&router, words, &inputs, &alone)?;
    if refusal.is_some() {
        return Ok(Measured { metrics: Value::Null, seconds, refusal });
    }
    let built = build(name, recipe)?;
    let same = std::fs::read(built.join("routes.json")).ok() == std::fs::read(alone.join("routes.json")).ok();
    if !same {
        return Err("the router by itself wrote other routes than in the build".into());
    }
    Ok(Measured { metrics: json(&built.join("metrics.json"))?, seconds, refusal })
}

fn folder() -> PathBuf {
    checkout().join("target/bench-routing")
}

/// Builds a recipe and returns its build folder.
fn build(name: &str, recipe: Recipe) -> Result<PathBuf, String> {
    let (folder, path) = (folder(), folder().join(format!("{name}.toml")));
    std::fs::create_dir_all(&folder).map_err(|e| e.to_string())?;
    std::fs::write(&path, recipe.named(name).text()).map_err(|e| e.to_string())?;
    let mut command = Command::new(executables().join("fibar"));
    command.current_dir(&folder).env("FIBAR_STORE", checkout().join("target/store")).arg("build").arg(&path);
    let output = command.output().map_err(|e| e.to_string())?;
    // Exit code 1 is a broken rule: measured all the same.
    match output.status.code() {
        Some(0 | 1) => Ok(folder.join("build").join(name)),
        _ => Err(complaint(&String::from_utf8_lossy(&output.stderr))),
    }
}

/// The first error of a log.
fn complaint(log: &str) -> String {
    let line = log.lines().find(|line| line.starts_with("error")).or(log.lines().last());
    line.unwrap_or("it ended without a word").to_owned()
}

fn json(path: &Path) -> Result<Value, String> {
    let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    serde_json::from_slice(&bytes).map_err(|e| format!("{}: {e}", path.display()))
}

impl Measured {
    /// A metric of the build.
    pub fn value(&self, metric: &str) -> Option<f64> {
        self.metrics[metric]["value"].as_f64()
    }

    /// A metric as a table shows it.
    pub fn cell(&self, metric: &str, digits: usize) -> String {
        text(self.value(metric), digits)
    }
}

/// A number as a table shows it.
pub fn text(value: Option<f64>, digits: usize) -> String {
    value.map_or("–".into(), |value| format!("{value:.digits$}"))
}

/// The heads of a table whose first columns are given.
pub fn print_heads(first: &[&str], columns: &[Column]) {
    let heads: Vec<&str> = first.iter().copied().chain(columns.iter().map(|(head, _, _)| *head)).collect();
    println!("| {} |", heads.join(" | "));
    println!("|{}", " --- |".repeat(heads.len()));
}

/// A row: its name, processor seconds, and metrics or the reason why there are none.
pub fn print_row(name: &str, outcome: &Result<Measured, String>, columns: &[Column]) {
    let measured = match outcome {
        Ok(measured) => measured,
        Err(reason) => return println!("| {name} | – | not measured: {reason} |"),
    };
    let seconds = text(measured.seconds, 2);
    if let Some(refusal) = &measured.refusal {
        return println!("| {name} | {seconds} | not routed: {refusal} |");
    }
    let cells: Vec<String> =
        columns.iter().map(|(_, metric, digits)| measured.cell(metric, *digits)).collect();
    println!("| {name} | {seconds} | {} |", cells.join(" | "));
}
