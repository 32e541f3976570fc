//! What a build came to, for whoever asked for it.

use crate::Digest;
use crate::build::{Finished, Outcome};
use crate::plan::Plan;
use fibar_core::protocol::Violation;
use std::fmt::Write;
use std::path::PathBuf;

/// What a build came to.
#[derive(Debug, Clone)]
pub struct BuildReport {
    /// The object.
    pub name: String,
    /// Its build folder.
    pub folder: PathBuf,
    /// In the order of the plan.
    pub stages: Vec<StageReport>,
    /// Sorted by name.
    pub files: Vec<PublishedFile>,
    /// In the order of the plan.
    pub violations: Vec<FoundViolation>,
    /// Wall time, s.
    pub total: f64,
    /// The chain of stages that takes longest to make, by id.
    pub critical_path: Vec<String>,
    /// How long that is, s: more cores make a first build no faster.
    pub critical_path_seconds: f64,
}

/// What a stage came to.
#[derive(Debug, Clone)]
pub struct StageReport {
    /// Its id.
    pub id: String,
    /// Its plugin.
    pub plugin: String,
    /// How it came to its result.
    pub outcome: Outcome,
    /// Time in this build, s.
    pub seconds: f64,
    /// Time its making took, whenever that was, s.
    pub made_in: f64,
}

/// A file or folder in the build folder.
#[derive(Debug, Clone)]
pub struct PublishedFile {
    /// Its name.
    pub name: String,
    /// Of its bytes or listing.
    pub digest: Digest,
    /// In bytes.
    pub size: u64,
    /// A folder.
    pub tree: bool,
}

/// A broken rule.
#[derive(Debug, Clone)]
pub struct FoundViolation {
    /// The stage that found it.
    pub stage: String,
    /// What it found.
    pub violation: Violation,
    /// The recipe allows it.
    pub allowed: bool,
}

impl BuildReport {
    /// Whether every broken rule is allowed.
    pub fn is_verified(&self) -> bool {
        self.violations.iter().all(|v| v.allowed)
    }

    /// How many stages ran.
    pub fn executed(&self) -> usize {
        self.stages.iter().filter(|s| s.outcome == Outcome::Executed).count()
    }
}

pub(super) fn stages(plan: &Plan, finished: &[Finished]) -> Vec<StageReport> {
    let report = |(stage, finished): (&crate::plan::PlannedStage, &Finished)| StageReport {
        id: stage.id.clone(),
        plugin: stage.plugin.name.clone(),
        outcome: finished.outcome,
        seconds: finished.seconds,
        made_in: finished.action.seconds,
    };
    plan.stages.iter().zip(finished).map(report).collect()
}

/// The text of the file UNVERIFIED.
pub(super) fn unverified_text(broken: &[&FoundViolation]) -> String {
    let mut text = String::from("The files beside this one break these rules:\n\n");
    for FoundViolation { stage, violation, .. } in broken {
        let _ = write!(text, "{} ({stage}): {}", violation.rule, violation.message);
        if let Some([x, y, z]) = violation.place_mm {
            let _ = write!(text, " at ({x:.3}, {y:.3}, {z:.3}) mm");
        }
        text.push('\n');
    }
    text
}
