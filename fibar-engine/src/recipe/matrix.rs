//! `[matrix]`: variants of a recipe, one for every combination of the listed values.
//!
//! ```toml
//! [matrix]
//! "route.use" = ["route-fibar", "route-negotiated"]
//! "place-visibility.spacing_mm" = [10, 12]
//! ```

use super::{Node, NodeValue, Override};
use fibar_core::diagnostic::Diagnostic;

/// More combinations than this are a mistake.
const MAX_VARIANTS: usize = 100_000;

/// Names of build folders longer than this are numbered instead.
const MAX_NAME: usize = 100;

/// Whether the matrix of a recipe counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Matrix {
    /// The recipe as it is written.
    #[default]
    Ignore,
    /// One plan per combination of values.
    Expand,
}

/// One combination.
#[derive(Debug, Clone, Default)]
pub(super) struct Variant {
    /// Follows the name of the object, after an `@`; empty for the recipe itself.
    pub name: String,
    /// The values it sets.
    pub changes: Vec<Override>,
}

/// All combinations, the last axis fastest; or the recipe itself if there is no matrix.
pub(super) fn variants(root: &Node, findings: &mut Vec<Diagnostic>) -> Vec<Variant> {
    let Some(table) = root.get("matrix") else { return vec![Variant::default()] };
    if !matches!(table.value, NodeValue::Table(_)) {
        findings.push(table.error("[matrix] lists values per `stage.key`"));
    }
    let mut variants = vec![Variant::default()];
    for entry in table.entries() {
        let Some((stage, key)) = entry.key.split_once('.').filter(|(s, k)| !s.is_empty() && !k.is_empty())
        else {
            let finding = entry.key_error(format!("`{}` is not of the form \"stage.key\"", entry.key));
            findings.push(finding.hint("\"route.use\" = [\"route-fibar\", \"route-tree\"]"));
            continue;
        };
        let NodeValue::Array(values) = &entry.value.value else {
            findings.push(entry.value.error("the matrix lists the values of a key: [..]"));
            continue;
        };
        if values.is_empty() || variants.len() * values.len() > MAX_VARIANTS {
            findings.push(entry.value.error(format!("expected 1 to {MAX_VARIANTS} variants in all")));
            continue;
        }
        let change = |value: &Node| Override {
            stage: stage.to_owned(),
            key: key.split('.').map(str::to_owned).collect(),
            value: value.clone(),
        };
        let with = |variant: &Variant, value: &Node| {
            let name = format!("{key}={}", plain(&value.source.text.text[value.range.clone()]));
            let name = if variant.name.is_empty() { name } else { format!("{},{name}", variant.name) };
            let changes = variant.changes.iter().cloned().chain([change(value)]).collect();
            Variant { name, changes }
        };
        variants = variants.iter().flat_map(|v| values.iter().map(|value| with(v, value))).collect();
    }
    number_unclear_names(&mut variants);
    variants
}

/// A value as part of a file name.
fn plain(text: &str) -> String {
    let kept = |c: char| if c.is_ascii_alphanumeric() || "-_.+".contains(c) { c } else { '_' };
    text.trim_matches(['"', '\'']).chars().map(kept).collect()
}

fn number_unclear_names(variants: &mut [Variant]) {
    let distinct: std::collections::BTreeSet<&str> = variants.iter().map(|v| v.name.as_str()).collect();
    if distinct.len() < variants.len() || variants.iter().any(|v| v.name.len() > MAX_NAME) {
        let width = variants.len().to_string().len();
        for (i, variant) in variants.iter_mut().enumerate() {
            variant.name = format!("{:0width$}", i + 1);
        }
    }
}
