//! A router run by itself on what a build made for it: its processor time, and what it says when fibres do not fit.

use crate::cpu;
use fibar_tests::executables;
use serde_json::{Value, json};
use std::path::Path;
use std::process::{Command, Output};

/// Ports of a router and the files that a build publishes for them.
const INPUTS: [(&str, &str); 3] =
    [("body", "body.ply"), ("sockets", "sockets.json"), ("constellation", "constellation.json")];

/// Words that a router is given beside its defaults: parameter and value.
pub type Words<'a> = &'a [(&'a str, &'a str)];

/// Runs a router on one thread; processor seconds, and its reason if it refuses.
pub fn run(
    plugin: &str,
    words: Words,
    built: &Path,
    out: &Path,
) -> Result<(Option<f64>, Option<String>), String> {
    let _ = std::fs::remove_dir_all(out);
    std::fs::create_dir_all(out).map_err(|e| e.to_string())?;
    let port = |(port, file): (&str, &str)| (port.to_owned(), json!([{ "path": built.join(file) }]));
    let inputs: serde_json::Map<String, Value> = INPUTS.map(port).into_iter().collect();
    let params: serde_json::Map<String, Value> =
        words.iter().map(|(key, value)| ((*key).to_owned(), json!(value))).collect();
    let request = json!({ "params": params, "inputs": inputs, "out_dir": out, "seed": 0, "threads": 1 });
    let path = out.with_extension("request.json");
    std::fs::write(&path, request.to_string()).map_err(|e| e.to_string())?;
    let before = cpu::children_seconds();
    let output = Command::new(executables().join(plugin)).arg("--request").arg(&path).output();
    let output = output.map_err(|e| format!("{plugin}: {e}"))?;
    let seconds = before.zip(cpu::children_seconds()).map(|(before, after)| after - before);
    Ok((seconds, refusal(&output)))
}

/// The message of a run that ended badly.
fn refusal(output: &Output) -> Option<String> {
    if output.status.success() {
        return None;
    }
    let text = String::from_utf8_lossy(&output.stdout);
    let mut messages = text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let message =
        messages.rfind(|m| m["type"] == "error").and_then(|m| Some(m["message"].as_str()?.to_owned()));
    Some(message.unwrap_or_else(|| "it ended without a word".into()))
}
