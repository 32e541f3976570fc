//! The law of light in a printed fibre: its constants, not its integration.
//!
//! Tone 2020, eqs. for `T_f`, `a` and `d_cam`: absorption `a(r) = c1 + c2·exp(−c3·r)` per mm for a bend of radius `r` mm,
//! and `d_cam = c5·exp(−½∫a ds)`. The data behind the fit end at r = 20 mm; everything below is extrapolated. Routers and
//! verifiers integrate the law each with code of their own.

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
