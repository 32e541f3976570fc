//! The key of an action: the hash of everything that can change its outputs, and of nothing else.

use super::PlannedStage;
use crate::{Digest, canonical};
use fibar_core::protocol::PROTOCOL_VERSION;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The digests of the artefacts on each input port.
pub type InputDigests = BTreeMap<String, Vec<Digest>>;

/// Everything that goes into a key. Stored with the action, so that a later miss can name the field that changed. No
/// time, no absolute path, no thread count.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// The protocol the run speaks.
    pub protocol: u32,
    /// Architecture and system: floats and libraries may differ between them.
    pub platform: String,
    /// The name of the plugin.
    pub plugin: String,
    /// The bytes of the plugin.
    pub plugin_digest: Digest,
    /// Complete parameters; a file is `{"file": digest, "extension": …}`.
    pub params: Value,
    /// For seeded stages.
    pub seed: Option<u64>,
    /// By port.
    pub inputs: InputDigests,
}

impl Manifest {
    /// The manifest of a stage with these inputs.
    pub fn of(stage: &PlannedStage, inputs: InputDigests) -> Manifest {
        let mut params = stage.params.clone();
        for file in &stage.files {
            if let Some(slot) = params.pointer_mut(&file.pointer) {
                *slot = json!({"file": file.digest, "extension": file.extension});
            }
        }
        Manifest {
            protocol: PROTOCOL_VERSION,
            platform: format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS),
            plugin: stage.plugin.name.clone(),
            plugin_digest: stage.plugin.digest,
            params,
            seed: stage.seed,
            inputs,
        }
    }

    /// The key.
    pub fn key(&self) -> Digest {
        let value = serde_json::to_value(self).expect("a manifest is plain data");
        Digest::of(canonical::to_string(&value).as_bytes())
    }
}
