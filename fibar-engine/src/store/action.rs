//! Finished actions: what a run gave, under the key of everything that went into it.

use super::Store;
use crate::plan::Manifest;
use crate::{Digest, Result};
use fibar_core::protocol::{Metric, Violation};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

const ACTION_FORMAT: &str = "fibar.action/1";

/// What a run gave. Hits reproduce all of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Action {
    format: String,
    /// Everything that went into the key.
    pub manifest: Manifest,
    /// By port.
    pub outputs: BTreeMap<String, Output>,
    /// In the order they were reported.
    pub metrics: Vec<Metric>,
    /// In the order they were reported.
    pub violations: Vec<Violation>,
    /// How long the run took, s; for estimates and `timings.json` only.
    pub seconds: f64,
}

/// One output of an action.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// The name it was written under.
    pub name: String,
    /// Of the bytes, or of the listing of a tree.
    pub digest: Digest,
    /// Bytes; all files of a tree together.
    pub size: u64,
    /// A folder rather than a file.
    pub tree: bool,
}

impl Action {
    /// A finished action.
    pub fn new(manifest: Manifest, outputs: BTreeMap<String, Output>, seconds: f64) -> Action {
        let format = ACTION_FORMAT.into();
        Action { format, manifest, outputs, metrics: Vec::new(), violations: Vec::new(), seconds }
    }
}

impl Store {
    fn action_path(&self, key: &Digest) -> PathBuf {
        self.root().join("actions").join(key.to_string())
    }

    /// A finished action whose outputs are all there. Anything unreadable is a miss.
    pub fn find_action(&self, key: &Digest) -> Option<Action> {
        let action: Action = serde_json::from_slice(&std::fs::read(self.action_path(key)).ok()?).ok()?;
        let complete = |output: &Output| match output.tree {
            true => self.has_tree(&output.digest),
            false => self.has_blob(&output.digest, output.size),
        };
        let ours = action.format == ACTION_FORMAT && action.manifest.key() == *key;
        (ours && action.outputs.values().all(complete)).then_some(action)
    }

    /// Makes a finished action visible, after its outputs.
    pub fn publish_action(&self, key: &Digest, action: &Action) -> Result<()> {
        let bytes = serde_json::to_vec(action).expect("an action is plain data");
        self.publish_bytes(&self.action_path(key), &bytes)
    }
}
