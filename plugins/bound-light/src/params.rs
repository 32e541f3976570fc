//! Parameters of the stage.

use fibar_core::light::LightLaw;
use fibar_core::material::{LayerRadii, SKIN_THICKNESS_MM};
use fibar_plugin::StageError;
use schemars::JsonSchema;

/// Parameters of `bound-light`.
#[derive(Clone, Debug, serde::Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// How hard to look for the best curve of a pair.
    pub effort: Effort,
    /// Least bend radius of a fibre's axis.
    #[schemars(range(min = 1.0, max = 1000.0), extend("unit" = "mm"))]
    pub min_bend_radius_mm: f64,
    /// Least distance from a fibre's outer surface to the skin's inner side, or to the hole of an LED.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm"))]
    pub wall_mm: f64,
    /// How far a fibre may arrive off the normal.
    #[schemars(range(min = 0.0, max = 60.0), extend("unit" = "deg"))]
    pub arrival_tilt_deg: f64,
    /// Within this of the LED's axis a fibre may start.
    #[schemars(range(min = 0.0, max = 20.0), extend("unit" = "mm"))]
    pub mouth_radius_mm: f64,
    /// Thickness of the skin under the outer surface.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "mm"))]
    pub skin_mm: f64,
    /// Outer radius of a fibre.
    #[schemars(range(min = 0.01, max = 50.0), extend("unit" = "mm"))]
    pub fibre_radius_mm: f64,

    /// Between samples of the room.
    #[schemars(range(min = 0.2, max = 10.0), extend("unit" = "mm"))]
    pub grid_mm: f64,
    /// Between the places that ways are looked for over.
    #[schemars(range(min = 0.5, max = 20.0), extend("unit" = "mm"))]
    pub search_mm: f64,

    /// Absorption of a straight fibre, c1.
    #[schemars(range(min = 0.0), extend("unit" = "1/mm"))]
    pub c1_per_mm: f64,
    /// Further absorption of the tightest bend, c2.
    #[schemars(range(min = 0.0), extend("unit" = "1/mm"))]
    pub c2_per_mm: f64,
    /// Decay of the bend's absorption with its radius, c3.
    #[schemars(range(min = 0.0), extend("unit" = "1/mm"))]
    pub c3_per_mm: f64,
    /// Distance from which the camera would see a lossless fibre, c5.
    #[schemars(range(min = 0.0), extend("unit" = "mm"))]
    pub c5_mm: f64,
}

/// How hard to look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// One start, improved briefly: a per cent or two below normal.
    Quick,
    /// The two most promising starts.
    Normal,
    /// All starts, to the end.
    Thorough,
}

impl Default for Params {
    fn default() -> Params {
        let light = LightLaw::TONE_2020;
        Params {
            effort: Effort::Normal,
            min_bend_radius_mm: 12.0,
            wall_mm: 0.0,
            arrival_tilt_deg: 20.0,
            mouth_radius_mm: 1.625,
            skin_mm: SKIN_THICKNESS_MM,
            fibre_radius_mm: LayerRadii::TONE_2020.black,
            grid_mm: 1.5,
            search_mm: 3.0,
            c1_per_mm: light.c1_per_mm,
            c2_per_mm: light.c2_per_mm,
            c3_per_mm: light.c3_per_mm,
            c5_mm: light.c5_mm,
        }
    }
}

impl Params {
    /// What the ranges of single parameters cannot say.
    pub fn check(&self) -> Result<(), StageError> {
        let constants = [self.c1_per_mm, self.c2_per_mm, self.c3_per_mm, self.c5_mm];
        if constants.iter().all(|c| c.is_finite()) {
            return Ok(());
        }
        Err(StageError::user("the constants of the law of light must be finite").param("/c1_per_mm"))
    }

    /// The law of light.
    pub fn light(&self) -> LightLaw {
        let Params { c1_per_mm, c2_per_mm, c3_per_mm, c5_mm, .. } = *self;
        LightLaw { c1_per_mm, c2_per_mm, c3_per_mm, c5_mm }
    }
}
