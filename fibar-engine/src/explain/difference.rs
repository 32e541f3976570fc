//! The fields in which two keys differ.

use crate::plan::Manifest;
use serde_json::Value;

/// A field that differs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// JSON pointer into the manifest without its leading slash.
    pub field: String,
    /// Empty where there is none.
    pub old: String,
    /// Empty where there is none.
    pub new: String,
}

/// Every field that differs, sorted; an input port is one field.
pub fn differences(old: &Manifest, new: &Manifest) -> Vec<Difference> {
    let json = |manifest: &Manifest| serde_json::to_value(manifest).expect("a manifest is plain data");
    let mut found = Vec::new();
    compare("", &json(old), &json(new), &mut found);
    found
}

fn compare(path: &str, old: &Value, new: &Value, found: &mut Vec<Difference>) {
    match (old, new) {
        _ if old == new => {}
        (Value::Object(a), Value::Object(b)) if !is_file(old) && !is_file(new) => {
            let mut keys: Vec<&String> = a.keys().chain(b.keys()).collect();
            keys.sort();
            keys.dedup();
            for key in keys {
                let path = if path.is_empty() { key.clone() } else { format!("{path}/{key}") };
                compare(&path, a.get(key).unwrap_or(&Value::Null), b.get(key).unwrap_or(&Value::Null), found);
            }
        }
        _ => found.push(Difference { field: path.into(), old: shown(old), new: shown(new) }),
    }
}

/// `{"file": digest, "extension": …}` is one value.
fn is_file(value: &Value) -> bool {
    value["file"].is_string() && value["extension"].is_string()
}

fn shown(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) if is_digest(text) => text[..12].to_owned(),
        Value::Object(_) if is_file(value) => format!("a file {}", shown(&value["file"])),
        Value::Array(items) if items.iter().all(|i| i.as_str().is_some_and(is_digest)) => {
            items.iter().map(shown).collect::<Vec<_>>().join(", ")
        }
        other => other.to_string(),
    }
}

fn is_digest(text: &str) -> bool {
    text.parse::<crate::Digest>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[track_caller]
    fn check(old: Value, new: Value, expected: &[(&str, &str, &str)]) {
        let mut found = Vec::new();
        compare("", &old, &new, &mut found);
        let found: Vec<_> =
            found.iter().map(|d| (d.field.as_str(), d.old.as_str(), d.new.as_str())).collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn every_changed_field_is_named_and_no_other() {
        let digest = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
        check(json!({"a": {"b": 1, "c": [1]}}), json!({"a": {"b": 2, "c": [1]}}), &[("a/b", "1", "2")]);
        check(json!({"a": 1}), json!({"b": "x"}), &[("a", "1", ""), ("b", "", "\"x\"")]);
        check(json!({"in": [digest]}), json!({"in": []}), &[("in", "e3b0c44298fc", "")]);
        let file = json!({"file": digest, "extension": "obj"});
        check(json!({"p": null}), json!({"p": file}), &[("p", "", "a file e3b0c44298fc")]);
    }
}
