//! `verdict-….json`: what a verifier found, rule by rule.

use super::document;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// The findings of one verifier.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Verdict {
    /// `"fibar.verdict/1"`.
    pub format: String,
    /// Which verifier.
    pub verifier: String,
    /// One finding per rule, in the verifier's own order.
    pub findings: Vec<Finding>,
}

/// One rule and how it stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Finding {
    /// Name of the rule, `clearance.gap` say.
    pub rule: String,
    /// Whether it holds.
    pub holds: bool,
    /// The measured value.
    pub value: f64,
    /// Its unit: `mm`, `mm3`, `1`.
    pub unit: String,
    /// The bound that it is held against, if any.
    pub bound: Option<f64>,
    /// The finding in words.
    pub message: String,
    /// Where, in order of badness, mm.
    pub places: Vec<Place>,
}

/// A point that shows a finding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// The point, mm.
    pub position: DVec3,
    /// The value there, in the finding's unit.
    pub value: f64,
    /// What is there: "fibres 3 and 17".
    pub what: String,
}

impl Verdict {
    /// A document of the current format.
    pub fn new(verifier: &str, findings: Vec<Finding>) -> Self {
        Verdict { format: "fibar.verdict/1".into(), verifier: verifier.into(), findings }
    }
}

document!(Verdict, "fibar.verdict/1", |v| {
    let broken = v.findings.iter().find(|f| !f.value.is_finite());
    broken.map_or(Ok(()), |f| Err(format!("finding \"{}\" has a value that is not finite", f.rule)))
});
