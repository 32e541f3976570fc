//! Patterns of LED places around their centre.

use crate::params::{Layout, Params};
use glam::DVec2;

/// Places of the LEDs relative to the centre LED, mm; the first is zero.
pub fn offsets(params: &Params) -> Vec<DVec2> {
    let around = match params.layout {
        Layout::Hexagon => hexagon(params.pitch_mm, params.rotation_deg.to_radians()),
    };
    std::iter::once(DVec2::ZERO).chain(around).take(params.count as usize).collect()
}

/// Corners counter-clockwise; each is as far from its neighbours as from the centre.
fn hexagon(pitch: f64, rotation: f64) -> [DVec2; 6] {
    std::array::from_fn(|k| {
        let angle = rotation + k as f64 * std::f64::consts::FRAC_PI_3;
        DVec2::new(libm::cos(angle), libm::sin(angle)) * pitch
    })
}
