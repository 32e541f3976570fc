//! A value of a recipe that knows where it was written.

use fibar_core::diagnostic::{Diagnostic, Place, SourceText};
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;
use toml::de::{DeTable, DeValue};

/// A text with the folder that relative paths in it start from.
#[derive(Debug)]
pub struct Source {
    /// The text.
    pub text: Arc<SourceText>,
    /// The folder of the file.
    pub folder: PathBuf,
}

/// A value with its place.
#[derive(Debug, Clone)]
pub struct Node {
    /// What was written.
    pub value: NodeValue,
    /// By whom.
    pub source: Arc<Source>,
    /// Where: bytes of the source.
    pub range: Range<usize>,
}

/// The kinds of values a recipe has.
#[derive(Debug, Clone)]
pub enum NodeValue {
    /// `true` or `false`.
    Bool(bool),
    /// A whole number.
    Integer(i64),
    /// Any other number.
    Float(f64),
    /// A text.
    String(String),
    /// A list.
    Array(Vec<Node>),
    /// Keys and values, in the order they were written.
    Table(Vec<Entry>),
    /// A date; no parameter takes one.
    Date,
}

/// A key with its value.
#[derive(Debug, Clone)]
pub struct Entry {
    /// The key.
    pub key: String,
    /// Where the key stands in the source of its value.
    pub key_range: Range<usize>,
    /// The value.
    pub value: Node,
}

impl Node {
    /// Reads a whole file; every syntax error becomes a finding.
    pub fn parse_file(source: &Arc<Source>) -> (Node, Vec<Diagnostic>) {
        let (table, errors) = DeTable::parse_recoverable(&source.text.text);
        let finding = |e: &toml::de::Error| {
            let range = e.span().unwrap_or(0..0);
            Diagnostic::error(e.message().to_owned()).at(&source.text, range)
        };
        let mut findings: Vec<Diagnostic> = errors.iter().map(finding).collect();
        let range = table.span();
        let value = table_value(table.get_ref(), source, &mut findings);
        (Node { value, source: Arc::clone(source), range }, findings)
    }

    /// Reads one value, e.g. from the command line; what is no TOML value is a text.
    pub fn parse_value(source: &Arc<Source>) -> Node {
        let text = &source.text.text;
        let (value, range) = match DeValue::parse(text) {
            Ok(value) => (node_value(value.get_ref(), source, &mut Vec::new()), value.span()),
            Err(_) => (NodeValue::String(text.clone()), 0..text.len()),
        };
        Node { value, source: Arc::clone(source), range }
    }

    /// Where it was written.
    pub fn place(&self) -> Place {
        Place { source: Arc::clone(&self.source.text), range: self.range.clone() }
    }

    /// An error about this value.
    pub fn error(&self, message: impl Into<String>) -> Diagnostic {
        Diagnostic::error(message).at(&self.source.text, self.range.clone())
    }

    /// The entries of a table, none for anything else.
    pub fn entries(&self) -> &[Entry] {
        match &self.value {
            NodeValue::Table(entries) => entries,
            _ => &[],
        }
    }

    /// The value of a key of a table.
    pub fn get(&self, key: &str) -> Option<&Node> {
        self.entries().iter().find(|e| e.key == key).map(|e| &e.value)
    }

    /// The text, if it is one.
    pub fn as_str(&self) -> Option<&str> {
        match &self.value {
            NodeValue::String(text) => Some(text),
            _ => None,
        }
    }

    /// What kind of value it is, for messages.
    pub fn kind(&self) -> &'static str {
        match self.value {
            NodeValue::Bool(_) => "true/false",
            NodeValue::Integer(_) => "a whole number",
            NodeValue::Float(_) => "a number",
            NodeValue::String(_) => "a text",
            NodeValue::Array(_) => "a list",
            NodeValue::Table(_) => "a table",
            NodeValue::Date => "a date",
        }
    }

    /// The value a JSON pointer leads to, or the nearest one on the way that exists.
    pub fn follow(&self, pointer: &str) -> &Node {
        let mut node = self;
        for step in pointer.split('/').skip(1) {
            let next = match &node.value {
                NodeValue::Array(items) => step.parse::<usize>().ok().and_then(|i| items.get(i)),
                _ => node.get(step),
            };
            match next {
                Some(next) => node = next,
                None => break,
            }
        }
        node
    }
}

impl Entry {
    /// An error about the key.
    pub fn key_error(&self, message: impl Into<String>) -> Diagnostic {
        Diagnostic::error(message).at(&self.value.source.text, self.key_range.clone())
    }
}

fn table_value(table: &DeTable<'_>, source: &Arc<Source>, findings: &mut Vec<Diagnostic>) -> NodeValue {
    let entry = |(key, value): (&toml::Spanned<toml::de::DeString<'_>>, &toml::Spanned<DeValue<'_>>)| Entry {
        key: key.get_ref().to_string(),
        key_range: key.span(),
        value: Node {
            value: node_value(value.get_ref(), source, findings),
            source: Arc::clone(source),
            range: value.span(),
        },
    };
    let mut entries: Vec<Entry> = table.iter().map(entry).collect();
    entries.sort_by_key(|e| e.key_range.start);
    NodeValue::Table(entries)
}

fn node_value(value: &DeValue<'_>, source: &Arc<Source>, findings: &mut Vec<Diagnostic>) -> NodeValue {
    match value {
        DeValue::Boolean(value) => NodeValue::Bool(*value),
        DeValue::Integer(value) => match i64::from_str_radix(value.as_str(), value.radix()) {
            Ok(value) => NodeValue::Integer(value),
            Err(_) => {
                let message = format!("{} does not fit a whole number of 64 bits", value.as_str());
                findings.push(Diagnostic::error(message));
                NodeValue::Integer(0)
            }
        },
        DeValue::Float(value) => NodeValue::Float(value.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::String(text) => NodeValue::String(text.to_string()),
        DeValue::Datetime(_) => NodeValue::Date,
        DeValue::Array(items) => NodeValue::Array(
            items
                .iter()
                .map(|item| Node {
                    value: node_value(item.get_ref(), source, findings),
                    source: Arc::clone(source),
                    range: item.span(),
                })
                .collect(),
        ),
        DeValue::Table(table) => table_value(table, source, findings),
    }
}
