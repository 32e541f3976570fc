//! `solids.json`: the index of a folder of closed solids, one PLY file each.

use super::document;
use crate::id::{LedId, PatternId};
use crate::material::Role;
use serde::{Deserialize, Serialize};

/// Name of the index inside a tree of solids.
pub const INDEX_FILE: &str = "solids.json";

/// All solids of an object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Solids {
    /// `"fibar.solids/1"`.
    pub format: String,
    /// Thickness asked of the skin, mm.
    pub skin_mm: f64,
    /// The solids: by role, then by LED.
    pub solids: Vec<Solid>,
}

/// One closed solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Solid {
    /// The part it plays.
    pub role: Role,
    /// LED whose fibres it belongs to; none for skin and filler.
    pub led: Option<LedId>,
    /// Pattern that it carries; none for skin and filler.
    pub pattern: Option<PatternId>,
    /// The user's name for the part of the object that it is a piece of; only skin and filler are divided by parts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// Colour of that part: red, green, blue (sRGB) and opacity from 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colour: Option<[f64; 4]>,
    /// Its PLY file, beside the index.
    pub file: String,
    /// Enclosed volume, mm³, as its maker computed it.
    pub volume_mm3: f64,
}

impl Solids {
    /// A document of the current format.
    pub fn new(skin_mm: f64, solids: Vec<Solid>) -> Self {
        Solids { format: "fibar.solids/1".into(), skin_mm, solids }
    }
}

impl Solid {
    /// A name for people and slicers: `core-led0`, `skin`, `tower / skin`.
    pub fn name(&self) -> String {
        match (self.led, &self.part) {
            (Some(led), _) => format!("{}-led{led}", self.role.name()),
            (None, Some(part)) => format!("{part} / {}", self.role.name()),
            (None, None) => self.role.name().to_string(),
        }
    }
}

document!(Solids, "fibar.solids/1", |s| {
    for (k, solid) in s.solids.iter().enumerate() {
        let plain = solid.file.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_.".contains(&b));
        if !plain || solid.file.is_empty() || solid.file.starts_with('.') {
            return Err(format!("solids[{k}].file must be a plain file name, is \"{}\"", solid.file));
        }
        if s.solids[..k].iter().any(|o| o.file == solid.file) {
            return Err(format!("solids[{k}].file \"{}\" is named twice", solid.file));
        }
    }
    Ok(())
});
