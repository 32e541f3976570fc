//! What a solid of the print is for, and what it is printed with.
//!
//! Four materials play five roles (Tone 2020, "Structure of printed optical fiber"): cladding and filler are both support.

use serde::{Deserialize, Serialize};

/// The part a solid plays. Inner roles come first; the order is that of the print tools.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Guides the light.
    Core,
    /// Keeps the light in the core.
    Cladding,
    /// Keeps stray light from the other fibres.
    Black,
    /// Diffuses the light at the surface and hides the marker.
    Skin,
    /// All the rest of the object.
    Filler,
}

/// What a role is printed with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// The maker's name of the material.
    pub name: &'static str,
    /// Colour on screen, sRGB with alpha, 0–255.
    pub colour_srgba: [u8; 4],
    /// Refractive index, where light matters.
    pub refractive_index: Option<f64>,
}

impl Role {
    /// All roles, inner first.
    pub const ALL: [Role; 5] = [Role::Core, Role::Cladding, Role::Black, Role::Skin, Role::Filler];

    /// The role's name in files and metrics.
    pub fn name(self) -> &'static str {
        match self {
            Role::Core => "core",
            Role::Cladding => "cladding",
            Role::Black => "black",
            Role::Skin => "skin",
            Role::Filler => "filler",
        }
    }

    /// The paper's material for the role (Stratasys Objet260 Connex3).
    pub fn material(self) -> Material {
        match self {
            Role::Core => material("VeroClear RGD810", [205, 235, 255, 110], Some(1.47)),
            Role::Cladding => material("SUP706 cladding", [250, 225, 150, 150], Some(1.43)),
            Role::Black => material("TangoBlack FLX973", [25, 25, 28, 255], None),
            Role::Skin => material("VeroPureWhite RGD837", [250, 250, 250, 255], None),
            Role::Filler => material("SUP706 filler", [225, 205, 165, 255], None),
        }
    }
}

fn material(name: &'static str, colour_srgba: [u8; 4], refractive_index: Option<f64>) -> Material {
    Material { name, colour_srgba, refractive_index }
}

/// Radii of a fibre's layers, mm from its axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayerRadii {
    /// Outer radius of the core.
    pub core: f64,
    /// Outer radius of the cladding.
    pub cladding: f64,
    /// Outer radius of the black layer, and so of the fibre.
    pub black: f64,
}

impl LayerRadii {
    /// Core Ø 1.75 mm, cladding and black 0.5 mm each: outer Ø 3.75 mm.
    pub const TONE_2020: LayerRadii = LayerRadii { core: 0.875, cladding: 1.375, black: 1.875 };
}

impl Default for LayerRadii {
    fn default() -> Self {
        LayerRadii::TONE_2020
    }
}

/// Thickness of the white skin, mm (Tone 2020).
pub const SKIN_THICKNESS_MM: f64 = 0.4;
