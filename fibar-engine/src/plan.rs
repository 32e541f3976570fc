//! From recipe to plan: every stage with its plugin, complete parameters and wires, or all mistakes at once.

mod key;
mod load;
mod schema;
mod wire;

pub use key::{InputDigests, Manifest};
pub use wire::{Wire, WireSource};

use crate::plugin::{Plugin, PluginPath};
use crate::recipe::{Matrix, Node, Override};
use crate::{Digest, Result, Store};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What to build: a recipe that makes sense, ready to run.
#[derive(Debug)]
pub struct Plan {
    /// The recipe file, as the user named it.
    pub recipe: PathBuf,
    /// The name of the object and its build folder.
    pub name: String,
    /// The texts it was read from: the recipe, then what it includes.
    pub sources: Vec<PlanSource>,
    /// Values replaced from outside, `stage.key=value`: by a variant of the matrix, then from the command line.
    pub changes: Vec<String>,
    /// In an order in which every stage comes after the stages it takes inputs from.
    pub stages: Vec<PlannedStage>,
}

/// A text that a plan was read from.
#[derive(Debug, Clone)]
pub struct PlanSource {
    /// The name of the file, without folders.
    pub name: String,
    /// Of its bytes.
    pub digest: Digest,
}

/// What planning needs to know beside the recipe.
#[derive(Clone, Copy)]
pub struct PlanOptions<'a> {
    /// Where plugins are found.
    pub plugins: &'a PluginPath,
    /// Where descriptions and digests are kept.
    pub store: &'a Store,
    /// Values replaced from the command line.
    pub overrides: &'a [Override],
    /// Whether `[matrix]` counts.
    pub matrix: Matrix,
}

/// A stage that is ready to run once its inputs are there.
#[derive(Debug)]
pub struct PlannedStage {
    /// Unique in the plan.
    pub id: String,
    /// What runs.
    pub plugin: Arc<Plugin>,
    /// Complete parameters; files are still `null`.
    pub params: Value,
    /// Files that parameters name.
    pub files: Vec<FileInput>,
    /// For seeded stages.
    pub seed: Option<u64>,
    /// Verification rules that may be broken.
    pub allow: Vec<String>,
    /// One per input port, in the order of the description.
    pub wires: Vec<Wire>,
    /// The table of the recipe, for places.
    pub node: Node,
    /// Where `use` has its value.
    pub use_node: Node,
}

/// A file named by a parameter.
#[derive(Debug, Clone)]
pub struct FileInput {
    /// JSON pointer into the parameters.
    pub pointer: String,
    /// Where the file is.
    pub path: PathBuf,
    /// Of its bytes when the plan was made.
    pub digest: Digest,
    /// The lower-case extension of its name, which the copy keeps; may be empty.
    pub extension: String,
}

impl Plan {
    /// Plans a recipe, or every variant of its matrix, without running any stage.
    pub fn make(recipe: &Path, options: &PlanOptions<'_>) -> Result<Vec<Plan>> {
        load::load(recipe, options)
    }

    /// The stage with an id.
    pub fn stage(&self, id: &str) -> Option<&PlannedStage> {
        self.stages.iter().find(|stage| stage.id == id)
    }
}
