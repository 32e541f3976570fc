//! `--set stage.key=value`: values of a recipe replaced from the command line.

use super::{Entry, Node, NodeValue, Source};
use fibar_core::diagnostic::{Diagnostic, SourceText, did_you_mean};
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

/// One replaced value.
#[derive(Debug, Clone)]
pub struct Override {
    /// Id of the stage.
    pub stage: String,
    /// Key in its table; dots lead into tables.
    pub key: Vec<String>,
    /// The value, a TOML value or else a text; its source is the command line.
    pub value: Node,
}

impl FromStr for Override {
    type Err = String;

    fn from_str(text: &str) -> Result<Override, String> {
        let usage = || format!("{text:?} is not of the form stage.key=value");
        let (target, value) = text.split_once('=').ok_or_else(usage)?;
        let (stage, key) = target.trim().split_once('.').ok_or_else(usage)?;
        if stage.is_empty() || key.split('.').any(str::is_empty) {
            return Err(usage());
        }
        let source = SourceText::new(format!("--set {}", target.trim()), value.trim());
        let source = Arc::new(Source { text: source, folder: PathBuf::new() });
        let key = key.split('.').map(str::to_owned).collect();
        Ok(Override { stage: stage.into(), key, value: Node::parse_value(&source) })
    }
}

impl fmt::Display for Override {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = &self.value.source.text.text[self.value.range.clone()];
        write!(f, "{}.{}={value}", self.stage, self.key.join("."))
    }
}

/// Replaces the value in the table of its stage, given the ids of all stages.
pub(super) fn apply(stages: &mut [(String, Node)], change: &Override) -> Option<Diagnostic> {
    match stages.iter_mut().find(|(id, _)| *id == change.stage) {
        Some((_, table)) => {
            set(table, &change.key, &change.value);
            None
        }
        None => {
            let finding = change.value.error(format!("the recipe has no stage `{}`", change.stage));
            let ids = stages.iter().map(|(id, _)| id.as_str());
            Some(match did_you_mean(&change.stage, ids) {
                Some(id) => finding.hint(format!("did you mean `{id}`?")),
                None => finding,
            })
        }
    }
}

fn set(table: &mut Node, key: &[String], value: &Node) {
    let Some((first, rest)) = key.split_first() else { return };
    if !matches!(table.value, NodeValue::Table(_)) {
        table.value = NodeValue::Table(Vec::new());
    }
    let NodeValue::Table(entries) = &mut table.value else { return };
    let at = entries.iter().position(|e| e.key == *first).unwrap_or_else(|| {
        let mut fresh = value.clone();
        fresh.value = NodeValue::Table(Vec::new());
        entries.push(Entry { key: first.clone(), key_range: 0..0, value: fresh });
        entries.len() - 1
    });
    if rest.is_empty() {
        entries[at].key_range = value.range.clone();
        entries[at].value = value.clone();
    } else {
        set(&mut entries[at].value, rest, value);
    }
}
