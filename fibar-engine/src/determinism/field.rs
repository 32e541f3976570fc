//! What a byte of an artefact belongs to, for the forms that can be told from their first bytes.

use serde_json::Value;

/// The field that a byte belongs to, if the form is known, and what is there in both versions.
pub(super) fn around(first: &[u8], second: &[u8], byte: usize) -> (Option<String>, [String; 2]) {
    if let (Ok(a), Ok(b)) = (serde_json::from_slice(first), serde_json::from_slice(second))
        && let Some((pointer, a, b)) = json_difference("", &a, &b)
    {
        return (Some(if pointer.is_empty() { "/".into() } else { pointer }), [a, b]);
    }
    (ply_field(first, byte), [excerpt(first, byte), excerpt(second, byte)])
}

/// The first place where two JSON values differ.
fn json_difference(path: &str, a: &Value, b: &Value) -> Option<(String, String, String)> {
    let short = |value: &Value| value.to_string().chars().take(60).collect::<String>();
    match (a, b) {
        _ if a == b => None,
        (Value::Object(x), Value::Object(y)) if x.keys().eq(y.keys()) => {
            x.iter().find_map(|(key, a)| json_difference(&format!("{path}/{key}"), a, &y[key]))
        }
        (Value::Array(x), Value::Array(y)) if x.len() == y.len() => {
            let mut pairs = x.iter().zip(y).enumerate();
            pairs.find_map(|(i, (a, b))| json_difference(&format!("{path}/{i}"), a, b))
        }
        _ => Some((path.into(), short(a), short(b))),
    }
}

/// Name, count, and properties with their sizes; 0 for a list.
type Element<'a> = (&'a str, usize, Vec<(&'a str, usize)>);

/// `vertex 17, y` of a binary PLY file whose elements have no lists before the byte; `face data` after that.
fn ply_field(bytes: &[u8], byte: usize) -> Option<String> {
    let end = b"end_header\n";
    let start = bytes.windows(end.len()).position(|window| window == end)? + end.len();
    let header = std::str::from_utf8(&bytes[..start]).ok().filter(|text| text.starts_with("ply"))?;
    let Some(mut offset) = byte.checked_sub(start) else { return Some("header".into()) };
    let mut elements: Vec<Element<'_>> = Vec::new();
    for words in header.lines().map(|line| line.split(' ').collect::<Vec<_>>()) {
        match words.as_slice() {
            ["element", name, count] => elements.push((name, count.parse().ok()?, Vec::new())),
            ["property", "list", ..] => elements.last_mut()?.2.push(("list", 0)),
            ["property", kind, name] => elements.last_mut()?.2.push((name, size_of_kind(kind)?)),
            _ => {}
        }
    }
    for (name, count, properties) in elements {
        let size: usize = properties.iter().map(|(_, size)| size).sum();
        if properties.iter().any(|(_, size)| *size == 0) || size == 0 {
            return Some(format!("{name} data"));
        }
        if offset < count * size {
            let (index, mut rest) = (offset / size, offset % size);
            for (property, size) in properties {
                if rest < size {
                    return Some(format!("{name} {index}, {property}"));
                }
                rest -= size;
            }
        }
        offset = offset.checked_sub(count * size)?;
    }
    None
}

fn size_of_kind(kind: &str) -> Option<usize> {
    match kind {
        "char" | "uchar" | "int8" | "uint8" => Some(1),
        "short" | "ushort" | "int16" | "uint16" => Some(2),
        "int" | "uint" | "float" | "int32" | "uint32" | "float32" => Some(4),
        "double" | "float64" => Some(8),
        _ => None,
    }
}

/// Text if it is text, else hexadecimal.
fn excerpt(bytes: &[u8], byte: usize) -> String {
    let window = &bytes[byte.min(bytes.len())..(byte + 16).min(bytes.len())];
    match std::str::from_utf8(window) {
        Ok(text) if !text.contains(char::is_control) => format!("{text:?}"),
        _ => window.iter().map(|b| format!("{b:02x}")).collect::<Vec<_>>().join(" "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(first: &[u8], second: &[u8], expected: Option<&str>) {
        let byte = first.iter().zip(second).take_while(|(a, b)| a == b).count();
        assert_eq!(around(first, second, byte).0.as_deref(), expected);
    }

    #[test]
    fn the_field_of_a_difference_is_named() {
        check(br#"{"a":[1,{"b":2}]}"#, br#"{"a":[1,{"b":3}]}"#, Some("/a/1/b"));
        check(br#"{"a":[1]}"#, br#"{"a":[1,2]}"#, Some("/a"));
        check(b"1", b"2", Some("/"));
        check(b"plain", b"plane", None);
        let head =
            b"ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty double x\nproperty float y\n\
                     element face 1\nproperty list uchar int vertex_indices\nend_header\n";
        let ply = |at: usize| {
            let mut bytes = head.to_vec();
            bytes.extend([0; 37]);
            bytes[head.len() + at] = 1;
            bytes
        };
        check(&ply(0), &ply(36), Some("vertex 0, x"));
        check(&ply(23), &ply(36), Some("vertex 1, y"));
        check(&ply(24), &ply(36), Some("face data"));
    }
}
