//! Recipe values against a plugin's JSON Schema: complete, canonical parameters, or findings at the recipe's places.
//!
//! The part of JSON Schema that parameters need: types, enums, ranges, lengths, properties, defaults, `anyOf`/`oneOf`,
//! local `$ref`. A schema keyword beyond these does not check anything here; the plugin still may.

mod shape;

use crate::recipe::{Entry, Node, NodeValue};
use fibar_core::diagnostic::{Diagnostic, Place, did_you_mean};
use serde_json::{Map, Value, json};
use shape::{accepts, canonical, describe_type, is_file, range_text, resolve, resolve_keeping_default};
use std::sync::LazyLock;

/// What checking parameters brings.
#[derive(Debug, Default)]
pub struct Checked {
    /// Complete parameters; a file parameter is `null` here and listed in `files`.
    pub params: Value,
    /// The files that parameters name.
    pub files: Vec<FileParam>,
    /// Mistakes.
    pub findings: Vec<Diagnostic>,
}

/// A parameter that names a file.
#[derive(Debug, Clone)]
pub struct FileParam {
    /// JSON pointer into the parameters.
    pub pointer: String,
    /// The text as written.
    pub node: Node,
}

/// Checks the parameters of one stage. `stage` is where a missing key is reported.
pub fn check(schema: &Value, entries: &[Entry], stage: &Place) -> Checked {
    let mut checker = Checker { root: schema, files: Vec::new(), findings: Vec::new() };
    let params = checker.object(schema, entries, stage, "");
    Checked { params, files: checker.files, findings: checker.findings }
}

struct Checker<'a> {
    root: &'a Value,
    files: Vec<FileParam>,
    findings: Vec<Diagnostic>,
}

impl<'a> Checker<'a> {
    fn object(&mut self, schema: &'a Value, entries: &[Entry], place: &Place, pointer: &str) -> Value {
        static NONE: LazyLock<Map<String, Value>> = LazyLock::new(Map::new);
        let properties = schema["properties"].as_object().unwrap_or(&NONE);
        let mut out = Map::new();
        for entry in entries {
            let pointer = format!("{pointer}/{}", entry.key);
            match properties.get(&entry.key) {
                Some(property) => {
                    let value = self.value(resolve(self.root, property), &entry.value, &pointer);
                    out.insert(entry.key.clone(), value);
                }
                None if schema["additionalProperties"].is_object() => {
                    let property = resolve(self.root, &schema["additionalProperties"]);
                    out.insert(entry.key.clone(), self.value(property, &entry.value, &pointer));
                }
                None => self.findings.push(unknown_key(entry, properties)),
            }
        }
        for (key, property) in properties.iter().filter(|(key, _)| !entries.iter().any(|e| e.key == **key)) {
            self.absent(schema, key, resolve_keeping_default(self.root, property), place, &mut out);
        }
        Value::Object(out)
    }

    /// A key that the recipe does not give: its default, nothing, or a finding.
    fn absent(
        &mut self,
        schema: &Value,
        key: &str,
        property: Value,
        place: &Place,
        out: &mut Map<String, Value>,
    ) {
        let required = schema["required"].as_array().is_some_and(|r| r.iter().any(|name| name == key));
        let default = &property["default"];
        let must_be_named = is_file(&property) && default.as_str() == Some("");
        if must_be_named || (required && default.is_null()) {
            let doc = property["description"].as_str().unwrap_or("").lines().next().unwrap_or("");
            let mut finding = Diagnostic::error(format!("the stage needs `{key}`"));
            finding.place = Some(place.clone());
            self.findings.push(if doc.is_empty() { finding } else { finding.note(doc) });
        } else if !default.is_null() && !is_file(&property) {
            out.insert(key.into(), canonical(default, &property));
        }
    }

    fn value(&mut self, schema: &'a Value, node: &Node, pointer: &str) -> Value {
        if let Some(alternatives) = schema["anyOf"].as_array().or(schema["oneOf"].as_array()) {
            return self.alternatives(alternatives, node, pointer);
        }
        if let Some(choices) = schema["enum"].as_array() {
            return self.choice(choices, node);
        }
        if let Some(constant) = schema.get("const") {
            return self.choice(std::slice::from_ref(constant), node);
        }
        match &node.value {
            NodeValue::Table(entries) if accepts(schema, "object") => {
                self.object(schema, entries, &node.place(), pointer)
            }
            NodeValue::Array(items) if accepts(schema, "array") => self.array(schema, items, node, pointer),
            NodeValue::Bool(value) if accepts(schema, "boolean") => json!(value),
            NodeValue::String(text) if accepts(schema, "string") => self.text(schema, text, node, pointer),
            NodeValue::Integer(value) if accepts(schema, "integer") => {
                self.check_range(schema, *value as f64, node);
                json!(value)
            }
            NodeValue::Integer(value) if accepts(schema, "number") => {
                self.number(schema, *value as f64, node)
            }
            NodeValue::Float(value) if accepts(schema, "number") => self.number(schema, *value, node),
            _ => {
                let wanted = describe_type(schema);
                self.findings.push(node.error(format!("expected {wanted}, got {}", node.kind())));
                Value::Null
            }
        }
    }

    fn text(&mut self, schema: &Value, text: &str, node: &Node, pointer: &str) -> Value {
        if is_file(schema) {
            self.files.push(FileParam { pointer: pointer.into(), node: node.clone() });
            return Value::Null;
        }
        let length = text.chars().count() as u64;
        if schema["minLength"].as_u64().is_some_and(|min| length < min) {
            self.findings.push(node.error("the text is too short"));
        }
        json!(text)
    }

    fn number(&mut self, schema: &Value, value: f64, node: &Node) -> Value {
        if !value.is_finite() {
            self.findings.push(node.error("expected a finite number"));
            return Value::Null;
        }
        self.check_range(schema, value, node);
        // One key for 0.0 and -0.0.
        json!(value + 0.0)
    }

    fn check_range(&mut self, schema: &Value, value: f64, node: &Node) {
        let bound = |key: &str| schema[key].as_f64();
        let broken = bound("minimum").is_some_and(|min| value < min)
            || bound("maximum").is_some_and(|max| value > max)
            || bound("exclusiveMinimum").is_some_and(|min| value <= min)
            || bound("exclusiveMaximum").is_some_and(|max| value >= max);
        if broken {
            let unit =
                schema["unit"].as_str().filter(|u| *u != "1").map_or(String::new(), |u| format!(" {u}"));
            let finding = node.error(format!("{value}{unit} is out of range"));
            self.findings.push(finding.note(format!("allowed: {}", range_text(schema, &unit))));
        }
    }

    fn array(&mut self, schema: &'a Value, items: &[Node], node: &Node, pointer: &str) -> Value {
        let (min, max) = (schema["minItems"].as_u64(), schema["maxItems"].as_u64());
        let count = items.len() as u64;
        if min.is_some_and(|min| count < min) || max.is_some_and(|max| count > max) {
            let wanted = match (min, max) {
                (Some(min), Some(max)) if min == max => format!("{min}"),
                (Some(min), Some(max)) => format!("{min} to {max}"),
                (Some(min), None) => format!("at least {min}"),
                (None, max) => format!("at most {}", max.unwrap_or_default()),
            };
            self.findings.push(node.error(format!("expected {wanted} values, got {count}")));
        }
        let fallback = resolve(self.root, &schema["items"]);
        let item_schema = |i: usize| schema["prefixItems"].get(i).map_or(fallback, |s| resolve(self.root, s));
        let schemas: Vec<&'a Value> = (0..items.len()).map(item_schema).collect();
        let values = items.iter().zip(schemas).enumerate();
        values.map(|(i, (item, schema))| self.value(schema, item, &format!("{pointer}/{i}"))).collect()
    }

    /// The first alternative that fits; otherwise what the nearest one complains about.
    fn alternatives(&mut self, alternatives: &'a [Value], node: &Node, pointer: &str) -> Value {
        let alternatives: Vec<&'a Value> = alternatives.iter().map(|a| resolve(self.root, a)).collect();
        let constants: Option<Vec<Value>> = alternatives.iter().map(|a| a.get("const").cloned()).collect();
        if let Some(constants) = constants {
            return self.choice(&constants, node);
        }
        let mut nearest: Option<Vec<Diagnostic>> = None;
        for alternative in alternatives.into_iter().filter(|a| a["type"] != "null") {
            let mut trial = Checker { root: self.root, files: Vec::new(), findings: Vec::new() };
            let value = trial.value(alternative, node, pointer);
            if trial.findings.is_empty() {
                self.files.append(&mut trial.files);
                return value;
            }
            if nearest.as_ref().is_none_or(|n| trial.findings.len() < n.len()) {
                nearest = Some(trial.findings);
            }
        }
        self.findings.extend(nearest.unwrap_or_default());
        Value::Null
    }

    fn choice(&mut self, choices: &[Value], node: &Node) -> Value {
        let written = match &node.value {
            NodeValue::String(text) => json!(text),
            NodeValue::Integer(value) => json!(value),
            NodeValue::Bool(value) => json!(value),
            _ => Value::Null,
        };
        if let Some(choice) = choices.iter().find(|c| **c == written && !c.is_null()) {
            return choice.clone();
        }
        let shown: Vec<String> = choices.iter().filter(|c| !c.is_null()).map(Value::to_string).collect();
        let finding = node.error(format!("expected one of {}", shown.join(", ")));
        let guess =
            node.as_str().and_then(|word| did_you_mean(word, choices.iter().filter_map(Value::as_str)));
        self.findings.push(match guess {
            Some(guess) => finding.hint(format!("did you mean \"{guess}\"?")),
            None => finding,
        });
        Value::Null
    }
}

fn unknown_key(entry: &Entry, properties: &Map<String, Value>) -> Diagnostic {
    let finding = entry.key_error(format!("unknown key `{}`", entry.key));
    let known = || properties.keys().map(String::as_str).chain(crate::recipe::STAGE_KEYS);
    match did_you_mean(&entry.key, known()) {
        Some(key) => finding.hint(format!("did you mean `{key}`?")),
        None => finding.hint(format!("known keys: {}", known().collect::<Vec<_>>().join(", "))),
    }
}

#[cfg(test)]
mod tests;
