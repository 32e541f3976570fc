//! The parameters of the stage.

use crate::reach::Views;
use fibar_core::light::{LedBeam, LightLaw};

/// The law, the LED, the views, and what is asked of the fibres.
#[derive(Clone, Debug, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// A fibre seen from less far than this breaks the rule `light.reach`; 0 judges nothing.
    #[schemars(range(min = 0.0, max = 100000.0), extend("unit" = "mm"))]
    pub min_d_cam_mm: f64,
    /// Absorption of a straight fibre.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1/mm"))]
    pub c1_per_mm: f64,
    /// Further absorption of a bend as its radius goes to 0.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "1/mm"))]
    pub c2_per_mm: f64,
    /// Decay of the bend's part with its radius.
    #[schemars(range(min = 0.0001, max = 10.0), extend("unit" = "1/mm"))]
    pub c3_per_mm: f64,
    /// Distance at which camera and LED would still see a lossless fibre.
    #[schemars(range(min = 1.0, max = 1000000.0), extend("unit" = "mm"))]
    pub c5_mm: f64,
    /// Standard error of a single d_cam about the law in its calibration.
    #[schemars(range(min = 0.0, max = 100000.0), extend("unit" = "mm"))]
    pub standard_error_mm: f64,
    /// Sine of the widest angle in air that a core guides: √(n_core² − n_cladding²).
    #[schemars(range(min = 0.01, max = 1.5), extend("unit" = "1"))]
    pub numerical_aperture: f64,
    /// Radius of the LED's dome; nothing shines beside it.
    #[schemars(range(min = 0.1, max = 50.0), extend("unit" = "mm"))]
    pub dome_radius_mm: f64,
    /// Angle off the LED's axis at which its intensity is one half.
    #[schemars(range(min = 0.5, max = 85.0), extend("unit" = "deg"))]
    pub half_angle_deg: f64,
    /// Views that `light.track_range_mm` is found from.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub views: u32,
    /// Views come from at least this far above the horizon of the base.
    #[schemars(range(min = -89.0, max = 89.0), extend("unit" = "deg"))]
    pub lowest_view_deg: f64,
    /// A marker is seen only within this angle of its normal.
    #[schemars(range(min = 1.0, max = 90.0), extend("unit" = "deg"))]
    pub emission_limit_deg: f64,
}

impl Default for Params {
    fn default() -> Params {
        let LightLaw { c1_per_mm, c2_per_mm, c3_per_mm, c5_mm } = LightLaw::TONE_2020;
        let LedBeam { dome_radius_mm, half_angle_deg, numerical_aperture } = LedBeam::TONE_2020;
        Params {
            min_d_cam_mm: 0.0,
            c1_per_mm,
            c2_per_mm,
            c3_per_mm,
            c5_mm,
            standard_error_mm: fibar_core::light::CALIBRATION_ERROR_MM,
            numerical_aperture,
            dome_radius_mm,
            half_angle_deg,
            views: 10_000,
            lowest_view_deg: 0.0,
            emission_limit_deg: 60.0,
        }
    }
}

impl Params {
    /// The law of light.
    pub fn law(&self) -> LightLaw {
        let Params { c1_per_mm, c2_per_mm, c3_per_mm, c5_mm, .. } = *self;
        LightLaw { c1_per_mm, c2_per_mm, c3_per_mm, c5_mm }
    }

    /// The LED's beam.
    pub fn led(&self) -> LedBeam {
        let Params { dome_radius_mm, half_angle_deg, numerical_aperture, .. } = *self;
        LedBeam { dome_radius_mm, half_angle_deg, numerical_aperture }
    }

    /// The views.
    pub fn views(&self, seed: u64) -> Views {
        Views {
            count: self.views,
            lowest: self.lowest_view_deg.to_radians(),
            emission: self.emission_limit_deg.to_radians(),
            seed,
        }
    }
}
