//! What a recipe file says, before any plugin was asked whether it makes sense.
//!
//! The only reader of recipe TOML. Every mistake is collected; none stops the reading.

mod include;
mod matrix;
mod node;
mod overrides;
mod read;

pub use matrix::Matrix;
pub use node::{Entry, Node, NodeValue, Source};
pub use overrides::Override;

use std::path::{Path, PathBuf};

/// The recipe format this engine reads.
pub const RECIPE_FORMAT: i64 = 1;

/// The keys of a stage that belong to the recipe; all others are parameters of its plugin.
pub const STAGE_KEYS: [&str; 5] = ["use", "id", "from", "seed", "allow"];

/// An object and the stages that make it.
#[derive(Debug)]
pub struct Recipe {
    /// The file, as the user named it.
    pub path: PathBuf,
    /// The name of the object and of its build folder, with that of the variant.
    pub name: String,
    /// The texts it was read from: the file, then what it includes.
    pub sources: Vec<std::sync::Arc<Source>>,
    /// Values replaced from outside, `stage.key=value`.
    pub changes: Vec<String>,
    /// In the order of the file.
    pub stages: Vec<RecipeStage>,
}

/// A stage as the recipe states it.
#[derive(Debug)]
pub struct RecipeStage {
    /// Unique in the recipe.
    pub id: String,
    /// The plugin.
    pub plugin: String,
    /// The whole table of the stage, for places.
    pub node: Node,
    /// Where `use` has its value.
    pub use_node: Node,
    /// How inputs are wired by hand.
    pub from: From,
    /// For seeded stages.
    pub seed: Option<(u64, Node)>,
    /// Verification rules that may be broken.
    pub allow: Vec<String>,
    /// Everything else, for the plugin.
    pub params: Vec<Entry>,
}

/// The `from` of a stage.
#[derive(Debug, Default)]
pub enum From {
    /// Inputs take the nearest earlier output of their type.
    #[default]
    Nearest,
    /// `from = "stage"`: outputs of that stage wherever a type fits, else the nearest.
    Stage(Node),
    /// `from = { port = "stage" }` or `"stage.port"`.
    Ports(Vec<Entry>),
}

/// What was read and everything that was wrong with it.
pub struct Reading {
    /// The recipe, as far as it could be understood: once, or once per variant of its matrix.
    pub recipes: Vec<Recipe>,
    /// Mistakes, in no particular order.
    pub findings: Vec<fibar_core::diagnostic::Diagnostic>,
}

impl Recipe {
    /// Reads a recipe file, replaced values included.
    pub fn read(path: &Path, overrides: &[Override], matrix: Matrix) -> crate::Result<Reading> {
        read::read(path, overrides, matrix)
    }
}
