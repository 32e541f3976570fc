//! What `PLUGIN --help` says, made from the description alone.

use fibar_core::protocol::{Arity, Description, STDIO_FLAG};
use serde_json::Value;
use std::fmt::Write;

/// The help of a plugin: what it does, ports, parameters, and a request to run it by hand.
pub(crate) fn text(description: &Description) -> String {
    let mut out = format!("{} {}\n{}\n", description.name, description.version, description.summary);
    ports(&mut out, description);
    parameters(&mut out, &description.params);
    let _ = write!(
        out,
        "\nA stage of fibar. In a recipe:\n\n  [[stage]]\n  use = \"{}\"\n\nBy hand, with a request in a file:\n\n  \
         {} --request request.json     run once; reports as JSON Lines\n\nrequest.json:\n  {}\n\n\
         Others: --describe (ports and parameters as JSON), --version, {STDIO_FLAG} (speak the protocol).",
        description.name,
        description.name,
        example_request(description)
    );
    out
}

fn ports(out: &mut String, description: &Description) {
    if !description.inputs.is_empty() {
        out.push_str("\nInputs:\n");
    }
    for port in &description.inputs {
        let arity = match port.arity {
            Arity::One => "",
            Arity::Optional => " (optional)",
            Arity::Many => " (all)",
        };
        let _ = writeln!(out, "  {:<16} {}{arity}: {}", port.name, port.kind, port.doc);
    }
    if !description.outputs.is_empty() {
        out.push_str("\nOutputs:\n");
    }
    for port in &description.outputs {
        let file = port.publish.as_ref().map_or(String::new(), |f| format!(" → {f}"));
        let _ = writeln!(out, "  {:<16} {}{file}: {}", port.name, port.kind, port.doc);
    }
}

fn parameters(out: &mut String, schema: &Value) {
    let Some(properties) = schema["properties"].as_object().filter(|p| !p.is_empty()) else { return };
    out.push_str("\nParameters:\n");
    for (name, property) in properties {
        let doc = property["description"].as_str().unwrap_or("").replace('\n', " ");
        let _ = writeln!(out, "  {name:<24} {doc}");
        let facts = facts(property);
        if !facts.is_empty() {
            let _ = writeln!(out, "  {:<24} [{facts}]", "");
        }
    }
}

/// Default, unit, range and choices of a parameter, where it has them.
fn facts(property: &Value) -> String {
    let mut facts = Vec::new();
    let mut fact = |label: &str, key: &str| {
        if let Some(value) = property.get(key).filter(|v| !v.is_null() && v.as_str() != Some("")) {
            facts.push(format!("{label}{}", value.to_string().trim_matches('"')));
        }
    };
    fact("default ", "default");
    fact("", "unit");
    fact("from ", "minimum");
    fact("to ", "maximum");
    fact("above ", "exclusiveMinimum");
    fact("below ", "exclusiveMaximum");
    fact("one of ", "enum");
    facts.join(", ")
}

fn example_request(description: &Description) -> String {
    let inputs = description.inputs.iter().map(|p| format!("\"{}\": [{{\"path\": \"…\"}}]", p.name));
    let inputs = inputs.collect::<Vec<_>>().join(", ");
    format!(
        "{{\"params\": {{}}, \"inputs\": {{{inputs}}}, \"out_dir\": \"out\", \"seed\": 1, \"threads\": 2}}"
    )
}
