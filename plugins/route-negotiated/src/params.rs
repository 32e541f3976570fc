//! Parameters of the stage.

use fibar_core::light::LightLaw;
use fibar_core::material::{LayerRadii, SKIN_THICKNESS_MM};
use fibar_geometry::alone::AloneOptions;
use fibar_geometry::room::Keeping;
use fibar_plugin::{InputFile, StageError};
use schemars::JsonSchema;

/// Parameters of `route-negotiated`; `docs/route-negotiated.md` says why they are as they are.
#[derive(Clone, Debug, serde::Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// How hard to try.
    pub effort: Effort,
    /// What to do with markers whose fibres do not fit.
    pub on_misfit: OnMisfit,
    /// `routes.json` of an earlier build (a copy of it): fibres that still lead from their LED to their marker and keep all limits stay as
    /// they are there, only the others are routed. Where that does not fit, or costs much light, those in the way are, too.
    pub warm_start: Option<InputFile>,

    /// Least distance between the outer surfaces of fibres of different patterns.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm"))]
    pub clearance_mm: f64,
    /// Least distance from a fibre's outer surface to the skin's inner side, or to the hole of another LED.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm"))]
    pub wall_mm: f64,
    /// Least bend radius of a fibre's axis.
    #[schemars(range(min = 1.0, max = 1000.0), extend("unit" = "mm"))]
    pub min_bend_radius_mm: f64,
    /// How far a fibre may arrive off the marker's normal.
    #[schemars(range(min = 0.0, max = 60.0), extend("unit" = "deg"))]
    pub arrival_tilt_deg: f64,
    /// Within this of the LED's axis fibres start, side by side.
    #[schemars(range(min = 0.0, max = 20.0), extend("unit" = "mm"))]
    pub mouth_radius_mm: f64,
    /// Thickness of the skin under the outer surface.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "mm"))]
    pub skin_mm: f64,
    /// A marker further than this from the surface is refused.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "mm"))]
    pub marker_tolerance_mm: f64,

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

    /// Radius of the core.
    #[schemars(range(min = 0.01), extend("unit" = "mm"))]
    pub core_radius_mm: f64,
    /// With `on_misfit = "thin"` no core gets thinner than this: as much as the printer still makes, and the light allows.
    #[schemars(range(min = 0.01), extend("unit" = "mm"))]
    pub least_core_radius_mm: f64,
    /// Radius of the cladding.
    #[schemars(range(min = 0.01), extend("unit" = "mm"))]
    pub cladding_radius_mm: f64,
    /// Radius of the black layer.
    #[schemars(range(min = 0.01), extend("unit" = "mm"))]
    pub black_radius_mm: f64,
}

/// How hard to try.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// For a first look: a few per cent less light.
    Quick,
    /// The default.
    Normal,
    /// Every start of every fibre, improved to the end.
    Thorough,
}

/// What to do with markers whose fibres do not fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum OnMisfit {
    /// An error that says where they do not fit, and what would.
    Refuse,
    /// Leave out as few markers as needed; the log names them.
    Drop,
    /// Make all fibres as much thinner as needed: the core gives way, cladding and black stay as thick as they are. The log and
    /// `routes.json` say how thick they are.
    Thin,
}

impl Default for Params {
    fn default() -> Params {
        let light = LightLaw::TONE_2020;
        let radii = LayerRadii::TONE_2020;
        Params {
            effort: Effort::Normal,
            on_misfit: OnMisfit::Refuse,
            warm_start: None,
            clearance_mm: 0.1,
            wall_mm: 0.05,
            min_bend_radius_mm: 12.0,
            arrival_tilt_deg: 20.0,
            mouth_radius_mm: 1.625,
            skin_mm: SKIN_THICKNESS_MM,
            marker_tolerance_mm: 0.5,
            grid_mm: 1.5,
            search_mm: 3.0,
            c1_per_mm: light.c1_per_mm,
            c2_per_mm: light.c2_per_mm,
            c3_per_mm: light.c3_per_mm,
            c5_mm: light.c5_mm,
            core_radius_mm: radii.core,
            least_core_radius_mm: 0.25,
            cladding_radius_mm: radii.cladding,
            black_radius_mm: radii.black,
        }
    }
}

impl Params {
    /// What the ranges of single parameters cannot say.
    pub fn check(&self) -> Result<(), StageError> {
        let LayerRadii { core, cladding, black } = self.radii();
        if !(core < cladding && cladding < black) {
            let radii = format!("core {core}, cladding {cladding}, black {black} mm");
            return Err(StageError::user(format!("the layers' radii must grow outwards: {radii}"))
                .hint("each layer is 0.5 mm or more outside the one before")
                .param(if core < cladding { "/black_radius_mm" } else { "/cladding_radius_mm" }));
        }
        let constants = [self.c1_per_mm, self.c2_per_mm, self.c3_per_mm, self.c5_mm];
        if !constants.iter().all(|c| c.is_finite()) {
            return Err(
                StageError::user("the constants of the law of light must be finite").param("/c1_per_mm")
            );
        }
        Ok(())
    }

    /// The law of light.
    pub fn light(&self) -> LightLaw {
        let Params { c1_per_mm, c2_per_mm, c3_per_mm, c5_mm, .. } = *self;
        LightLaw { c1_per_mm, c2_per_mm, c3_per_mm, c5_mm }
    }

    /// Radii of the layers.
    pub fn radii(&self) -> LayerRadii {
        LayerRadii {
            core: self.core_radius_mm,
            cladding: self.cladding_radius_mm,
            black: self.black_radius_mm,
        }
    }

    /// The same with fibres of another outer diameter, mm; walls stay as thick as they are.
    pub fn of_diameter(&self, diameter: f64) -> Params {
        let less = self.black_radius_mm - 0.5 * diameter;
        Params {
            core_radius_mm: self.core_radius_mm - less,
            cladding_radius_mm: self.cladding_radius_mm - less,
            black_radius_mm: 0.5 * diameter,
            ..self.clone()
        }
    }

    /// Outer diameter of the fibres, mm.
    pub fn diameter(&self) -> f64 {
        2.0 * self.black_radius_mm
    }

    /// The least that it may be made, mm.
    pub fn least_diameter(&self) -> f64 {
        2.0 * (self.black_radius_mm - self.core_radius_mm
            + self.least_core_radius_mm.min(self.core_radius_mm))
    }

    /// What axes keep away from the skin and the holes.
    pub fn keeping(&self) -> Keeping {
        Keeping { radius: self.black_radius_mm, skin: self.skin_mm, wall: self.wall_mm }
    }

    /// Distance that axes of different patterns keep, mm.
    pub fn apart(&self) -> f64 {
        2.0 * self.black_radius_mm + self.clearance_mm
    }

    /// How hard single fibres are improved, and of how many starts.
    pub fn alone(&self) -> (usize, AloneOptions) {
        match self.effort {
            Effort::Quick => (1, AloneOptions { span: 9.0, iterations: 60, rounds: 6, least_gain: 1e-5 }),
            Effort::Normal => (1, AloneOptions { span: 7.5, iterations: 100, rounds: 6, least_gain: 1e-5 }),
            Effort::Thorough => {
                (usize::MAX, AloneOptions { span: 6.0, iterations: 400, rounds: 8, least_gain: 1e-5 })
            }
        }
    }
}
