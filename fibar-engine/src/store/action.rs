//! Finished actions: what a run gave, under the key of everything that went into it.

use super::Store;
use crate::plan::Manifest;
use crate::{Digest, Result};
use fibar_core::protocol::{Metric, Violation};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

const ACTION_FORMAT: &str = "fibar.action/1";

/// An action file begins with the digest of the rest in hexadecimal.
const CHECKSUM_LENGTH: usize = 64;

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
    pub(super) fn action_path(&self, key: &Digest) -> PathBuf {
        self.root().join("actions").join(key.to_string())
    }

    /// A finished action whose outputs are all there. Anything unreadable is a miss.
    pub fn find_action(&self, key: &Digest) -> Option<Action> {
        let action = self.read_action(key)?;
        let complete = action.outputs.values().all(|output| self.has_output(output));
        if complete {
            self.touch_action(key);
        }
        complete.then_some(action)
    }

    /// A finished action, whether or not its outputs are still there.
    pub fn read_action(&self, key: &Digest) -> Option<Action> {
        let bytes = std::fs::read(self.action_path(key)).ok()?;
        let (checksum, json) = bytes.split_at_checked(CHECKSUM_LENGTH)?;
        let json = json.strip_prefix(b"\n")?;
        let action: Action = serde_json::from_slice(json)
            .ok()
            .filter(|_| checksum == Digest::of(json).to_string().as_bytes())?;
        (action.format == ACTION_FORMAT && action.manifest.key() == *key).then_some(action)
    }

    /// Whether an output is still there, in full.
    pub fn has_output(&self, output: &Output) -> bool {
        match output.tree {
            true => self.has_tree(&output.digest),
            false => self.has_blob(&output.digest, output.size),
        }
    }

    /// Makes a finished action visible, after its outputs.
    pub fn publish_action(&self, key: &Digest, action: &Action) -> Result<()> {
        let json = serde_json::to_string(action).expect("an action is plain data");
        let text = format!("{}\n{json}", Digest::of(json.as_bytes()));
        self.publish_bytes(&self.action_path(key), text.as_bytes())
    }
}
