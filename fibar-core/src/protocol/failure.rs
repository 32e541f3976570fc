//! How a stage says that it cannot do its work.

use serde::{Deserialize, Serialize};

/// The end of a run that failed: what, where, and what to try.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Failure {
    /// Whose fault it is.
    pub kind: FailureKind,
    /// What is wrong, in the user's units.
    pub message: String,
    /// What to try.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hint: Option<String>,
    /// JSON pointer to the parameter at fault, e.g. `/spacing_mm`; the host turns it into a line of the recipe.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub param: Option<String>,
    /// The place at fault, in the body's frame, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place_mm: Option<[f64; 3]>,
}

/// Whose fault a [`Failure`] is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureKind {
    /// A parameter asks for something impossible.
    User,
    /// An input artefact or file breaks its promises or cannot be worked with.
    Input,
    /// The stage is at fault.
    Internal,
    /// Memory, disk or time ran out.
    Resource,
    /// The host asked to stop.
    Cancelled,
}

impl Failure {
    /// A failure with nothing but its kind and message.
    pub fn new(kind: FailureKind, message: impl Into<String>) -> Failure {
        Failure { kind, message: message.into(), hint: None, param: None, place_mm: None }
    }
}
