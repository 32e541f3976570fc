//! Names of the user's parts: none gets lost in silence.

use crate::part::Part;
use fibar_core::artefact::parts::Parts;
use fibar_plugin::StageError;

/// Every named part must have a solid of its name.
pub fn check(parts: &Parts, solids: &[Part]) -> Result<(), StageError> {
    let is_kept = |label: &str| solids.iter().any(|solid| solid.label.as_deref() == Some(label));
    let lost = parts.parts.iter().find(|part| !part.label.is_empty() && !is_kept(&part.label));
    let Some(part) = lost else { return Ok(()) };
    let message =
        format!("the name of the part \"{}\" is on none of the solids and would be lost", part.label);
    let hint = "wire `mesh` and `parts` to the stage that makes the solids; a part that lies inside others has no solid of \
                its own; or set lose_names = true";
    Err(StageError::input(message).param("/lose_names").hint(hint))
}

/// A text as the value of an XML attribute.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // XML 1.0 knows no other control characters, and an attribute no line ends.
            _ if character.is_control() => escaped.push(' '),
            _ => escaped.push(character),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::tests::tetrahedron;
    use fibar_core::artefact::parts::Part as Named;
    use fibar_core::material::Role;

    #[test]
    fn a_lost_name_is_told() {
        let named = |label: &str| Named {
            label: label.into(),
            colour: None,
            first_triangle: 0,
            triangles: 1,
            volume_mm3: 1.0,
            open_edges: None,
        };
        let roof = Part { label: Some("roof".into()), ..tetrahedron(Role::Skin) };
        let solids = [tetrahedron(Role::Core), roof];
        assert!(check(&Parts::new(vec![named("roof"), named("")]), &solids).is_ok());
        let error = check(&Parts::new(vec![named("roof"), named("door")]), &solids).unwrap_err();
        assert!(error.to_string().contains("\"door\""), "{error}");
    }

    #[test]
    fn names_are_safe_in_xml() {
        assert_eq!(escape("a<b> & \"c\"\n\u{0}é"), "a&lt;b&gt; &amp; &quot;c&quot;  é");
    }
}
