//! The law of light in a printed fibre: its constants, not its integration.
//!
//! Tone 2020, eqs. for `T_f`, `a` and `d_cam`: absorption `a(r) = c1 + c2·exp(−c3·r)` per mm for a bend of radius `r` mm,
//! and `d_cam = c5·exp(−½∫a ds)`. The data behind the fit end at r = 20 mm; everything below is extrapolated. Routers and
//! verifiers integrate the law each with code of their own. [`LedBeam`] says how an LED shines into the fibres under it.

use serde::{Deserialize, Serialize};

/// Coefficients of the law, from one material, camera and LED.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightLaw {
    /// Absorption of a straight fibre, per mm.
    pub c1_per_mm: f64,
    /// Further absorption of a bend as its radius goes to 0, per mm.
    pub c2_per_mm: f64,
    /// Decay of the bend's part with its radius, per mm.
    pub c3_per_mm: f64,
    /// Distance at which the camera would still see a lossless fibre, mm.
    pub c5_mm: f64,
}

/// Smallest bend radius among the 33 calibration prints, mm.
pub const CALIBRATED_RADIUS_MM: f64 = 20.0;

/// Residual standard error of the calibration's `d_cam`, mm.
pub const CALIBRATION_ERROR_MM: f64 = 281.2;

impl LightLaw {
    /// RGD810 core in SUP706 cladding, OSI3CA5111A at 850 nm, XIMEA MQ003MG camera (Tone 2020, "Light throughput").
    pub const TONE_2020: LightLaw =
        LightLaw { c1_per_mm: 2.214e-2, c2_per_mm: 7.478e-1, c3_per_mm: 9.584e-2, c5_mm: 6.224e3 };
}

impl Default for LightLaw {
    fn default() -> Self {
        LightLaw::TONE_2020
    }
}

/// The beam of an LED, and which of it a core takes: what decides how fibres of one LED share its light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LedBeam {
    /// Radius of the LED's dome, mm: nothing shines beside it.
    pub dome_radius_mm: f64,
    /// Angle off the axis at which the intensity has fallen to one half, degrees.
    pub half_angle_deg: f64,
    /// Sine of the widest angle in air that a core still guides: `√(n_core² − n_cladding²)`.
    pub numerical_aperture: f64,
}

impl LedBeam {
    /// OSI3CA5111A in its 5 mm package, RGD810 (1.47) in SUP706 (1.43). The paper names the LED but not its beam: 15° between
    /// half intensities is what the maker's 5111A family is sold with.
    pub const TONE_2020: LedBeam =
        LedBeam { dome_radius_mm: 2.5, half_angle_deg: 7.5, numerical_aperture: 0.3406 };
}

impl Default for LedBeam {
    fn default() -> Self {
        LedBeam::TONE_2020
    }
}
