//! Recipe values against a schema: what is filled in, what is found.

use super::*;
use crate::recipe::Source;
use expect_test::{Expect, expect};
use fibar_core::diagnostic::SourceText;
use std::sync::Arc;

fn schema() -> Value {
    json!({
        "type": "object",
        "additionalProperties": false,
        "required": ["scheme"],
        "properties": {
            "scheme": {"type": "string", "enum": ["loop", "catmark"]},
            "spacing_mm": {"type": "number", "default": 12, "minimum": 1.0, "maximum": 200.0, "unit": "mm"},
            "levels": {"type": "integer", "default": 2, "exclusiveMinimum": 0},
            "fit_mm": {"type": ["array", "null"], "items": {"type": "number"}, "minItems": 3, "maxItems": 3},
            "path": {"type": "string", "format": "fibar-file"},
            "solver": {"$ref": "#/$defs/Solver", "default": {"k": 1.0}},
            "mode": {"anyOf": [{"oneOf": [{"const": "fast"}, {"const": "exact"}]}, {"type": "null"}]}
        },
        "$defs": {"Solver": {"type": "object", "properties": {"k": {"type": "number", "default": 1}}}}
    })
}

#[track_caller]
fn check_params(toml: &str, expected: Expect) {
    let source = Arc::new(Source { text: SourceText::new("r.toml", toml), folder: "".into() });
    let (node, findings) = Node::parse_file(&source);
    assert!(findings.is_empty(), "{findings:?}");
    let schema = schema();
    let checked = check(&schema, node.entries(), &node.place());
    let mut lines: Vec<String> = checked.findings.iter().map(Diagnostic::render).collect();
    if lines.is_empty() {
        lines.push(crate::canonical::to_string(&checked.params));
    }
    lines.extend(checked.files.iter().map(|f| format!("{} = {:?}", f.pointer, f.node.as_str())));
    expected.assert_eq(&lines.join("\n"));
}

#[test]
fn defaults_are_filled_and_spelled_one_way() {
    check_params(
        "scheme = 'loop'",
        expect![[r#"{"levels":2,"scheme":"loop","solver":{"k":1.0},"spacing_mm":12.0}"#]],
    );
    check_params(
        "scheme = 'loop'\nspacing_mm = 12\nlevels = 2\nsolver.k = 1",
        expect![[r#"{"levels":2,"scheme":"loop","solver":{"k":1.0},"spacing_mm":12.0}"#]],
    );
    check_params(
        "scheme = 'loop'\nsolver = {}",
        expect![[r#"{"levels":2,"scheme":"loop","solver":{"k":1.0},"spacing_mm":12.0}"#]],
    );
    check_params(
        "scheme = 'loop'\nfit_mm = [1, 2.5, -0.0]\nmode = 'fast'\npath = 'a.obj'",
        expect![[r#"
            {"fit_mm":[1.0,2.5,0.0],"levels":2,"mode":"fast","path":null,"scheme":"loop","solver":{"k":1.0},"spacing_mm":12.0}
            /path = Some("a.obj")"#]],
    );
}

#[test]
fn every_mistake_is_found_at_its_place() {
    check_params(
        "schem = 1\nspacing_mm = 0.5\nlevels = 1.5\nfit_mm = [1, 'x']\nmode = 'fas'\nsolver.q = 1",
        expect![[r#"
            error: unknown key `schem`
             --> r.toml:1:1
              |
            1 | schem = 1
              | ^^^^^
              try: did you mean `scheme`?
            error: 0.5 mm is out of range
             --> r.toml:2:14
              |
            2 | spacing_mm = 0.5
              |              ^^^
              note: allowed: from 1 mm to 200 mm
            error: expected a whole number, got a number
             --> r.toml:3:10
              |
            3 | levels = 1.5
              |          ^^^
            error: expected 3 values, got 2
             --> r.toml:4:10
              |
            4 | fit_mm = [1, 'x']
              |          ^^^^^^^^
            error: expected a number, got a text
             --> r.toml:4:14
              |
            4 | fit_mm = [1, 'x']
              |              ^^^
            error: expected one of "fast", "exact"
             --> r.toml:5:8
              |
            5 | mode = 'fas'
              |        ^^^^^
              try: did you mean "fast"?
            error: unknown key `q`
             --> r.toml:6:8
              |
            6 | solver.q = 1
              |        ^
              try: did you mean `k`?
            error: the stage needs `scheme`
             --> r.toml:1:1
              |
            1 | schem = 1
              | ^"#]],
    );
}
