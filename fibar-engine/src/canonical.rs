//! One spelling for one JSON value: keys sorted, no spaces, so that equal values hash equally.

use serde_json::Value;
use std::collections::BTreeMap;

/// The value with sorted keys, whatever map type `serde_json` was built with.
pub fn to_string(value: &Value) -> String {
    let mut out = String::new();
    write(value, &mut out);
    out
}

fn write(value: &Value, out: &mut String) {
    match value {
        Value::Object(map) => {
            let sorted: BTreeMap<_, _> = map.iter().collect();
            write_all('{', '}', sorted.into_iter(), out, |(key, value), out| {
                out.push_str(&Value::from(key.as_str()).to_string());
                out.push(':');
                write(value, out);
            });
        }
        Value::Array(items) => write_all('[', ']', items.iter(), out, write),
        leaf => out.push_str(&leaf.to_string()),
    }
}

fn write_all<T>(
    open: char,
    close: char,
    items: impl Iterator<Item = T>,
    out: &mut String,
    write_one: impl Fn(T, &mut String),
) {
    out.push(open);
    for (i, item) in items.enumerate() {
        if i > 0 {
            out.push(',');
        }
        write_one(item, out);
    }
    out.push(close);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_sorted_at_every_depth() {
        let value = serde_json::json!({"b": [{"z": 1, "a": 2.0}], "a": "\"\n"});
        assert_eq!(to_string(&value), r#"{"a":"\"\n","b":[{"a":2.0,"z":1}]}"#);
    }
}
