//! What a piece of JSON Schema says: types, ranges, references, the spelling of its defaults.

use fibar_core::protocol::FILE_FORMAT;
use serde_json::{Value, json};

pub(super) fn is_file(schema: &Value) -> bool {
    schema["format"] == FILE_FORMAT
}

pub(super) fn accepts(schema: &Value, kind: &str) -> bool {
    match &schema["type"] {
        Value::String(own) => own == kind,
        Value::Array(own) => own.iter().any(|k| k == kind),
        _ => true,
    }
}

pub(super) fn describe_type(schema: &Value) -> String {
    let name = |kind: &str| match kind {
        "number" => "a number",
        "integer" => "a whole number",
        "string" => "a text",
        "boolean" => "true or false",
        "array" => "a list",
        "object" => "a table",
        _ => "another value",
    };
    let unit = schema["unit"].as_str().filter(|u| *u != "1").map_or(String::new(), |u| format!(" ({u})"));
    let kinds: Vec<&str> = match &schema["type"] {
        Value::String(own) => vec![name(own)],
        Value::Array(own) => {
            own.iter().filter_map(Value::as_str).filter(|k| *k != "null").map(name).collect()
        }
        _ => vec!["another value"],
    };
    kinds.join(" or ") + &unit
}

pub(super) fn range_text(schema: &Value, unit: &str) -> String {
    let bound = |key: &str, text: &str| schema[key].as_f64().map(|value| format!("{text} {value}{unit}"));
    let bounds = [
        bound("minimum", "from"),
        bound("exclusiveMinimum", "above"),
        bound("maximum", "to"),
        bound("exclusiveMaximum", "below"),
    ];
    bounds.into_iter().flatten().collect::<Vec<_>>().join(" ")
}

/// Follows `$ref` inside the schema.
pub(super) fn resolve<'a>(root: &'a Value, schema: &'a Value) -> &'a Value {
    let mut schema = schema;
    for _ in 0..16 {
        match schema["$ref"].as_str().and_then(|r| r.strip_prefix('#')).and_then(|p| root.pointer(p)) {
            Some(target) => schema = target,
            None => break,
        }
    }
    schema
}

/// The property behind a `$ref`, with the default and description that stand beside the reference.
pub(super) fn resolve_keeping_default(root: &Value, property: &Value) -> Value {
    let mut resolved = resolve(root, property).clone();
    if let (Some(into), Some(beside)) = (resolved.as_object_mut(), property.as_object()) {
        into.extend(beside.iter().filter(|(k, _)| *k != "$ref").map(|(k, v)| (k.clone(), v.clone())));
    }
    resolved
}

/// Defaults in the spelling that written values get: numbers that are not integers as floats.
pub(super) fn canonical(value: &Value, schema: &Value) -> Value {
    let wants_float =
        accepts(schema, "number") && !accepts(schema, "integer") && schema["type"] != Value::Null;
    match value {
        Value::Number(number) if wants_float => number.as_f64().map_or(Value::Null, |x| json!(x + 0.0)),
        Value::Array(items) => items.iter().map(|item| canonical(item, &schema["items"])).collect(),
        other => other.clone(),
    }
}
