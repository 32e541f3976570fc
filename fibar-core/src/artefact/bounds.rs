//! `bounds.json`: how much light each LED could bring to each place, were its fibre alone in the object.
//!
//! Light is that of one fibre of its own: what fibres of one LED take from each other is left out. All fibres end at right
//! angles to the surface (within `arrival_tilt_deg`), keep `wall_mm` from the skin and bend no tighter than
//! `min_bend_radius_mm`.

use super::{check_finite, check_unit, document};
use crate::id::LedId;
use crate::light::LightLaw;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Bounds of every pair of an LED and a target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// `"fibar.bounds/1"`.
    pub format: String,
    /// The law of light, continued monotonically below its costliest radius.
    pub law: LightLaw,
    /// Least bend radius of a fibre's axis, mm.
    pub min_bend_radius_mm: f64,
    /// Least distance from a fibre's outer surface to the skin's inner side, mm.
    pub wall_mm: f64,
    /// How far a fibre may arrive off the normal, degrees.
    pub arrival_tilt_deg: f64,
    /// The LEDs, in the order of the lists below.
    pub leds: Vec<LedId>,
    /// The places, in the order of the sites or markers that they were made for.
    pub targets: Vec<Target>,
}

/// What each LED could bring to one place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// On the outer surface, mm; exactly as in the sites or markers.
    pub position: DVec3,
    /// Outward unit normal.
    pub normal: DVec3,
    /// No fibre of this LED exceeds this d_cam, mm; 0 where the walls leave it no way.
    pub certified_mm: Vec<f64>,
    /// d_cam of the best curve known, mm; 0 where none is known.
    pub best_mm: Vec<f64>,
}

impl Bounds {
    /// The target at exactly this place.
    pub fn target_at(&self, position: DVec3) -> Option<&Target> {
        self.targets.iter().find(|target| target.position == position)
    }
}

document!(Bounds, "fibar.bounds/1", |b| {
    let settings = [b.min_bend_radius_mm, b.wall_mm, b.arrival_tilt_deg];
    if !settings.iter().all(|s| s.is_finite() && *s >= 0.0) {
        return Err(format!("radius, wall and tilt must be finite and not negative, are {settings:?}"));
    }
    b.targets
        .iter()
        .enumerate()
        .try_for_each(|(k, t)| check_target(t, b.leds.len()).map_err(|what| format!("targets[{k}]: {what}")))
});

fn check_target(target: &Target, leds: usize) -> Result<(), String> {
    check_finite("position", target.position)?;
    check_unit("normal", target.normal)?;
    if target.certified_mm.len() != leds || target.best_mm.len() != leds {
        return Err(format!("needs one certified_mm and one best_mm for each of {leds} LEDs"));
    }
    let pairs = std::iter::zip(&target.best_mm, &target.certified_mm);
    if !pairs.clone().all(|(best, certified)| *best >= 0.0 && certified.is_finite()) {
        return Err("distances must be finite and not negative".into());
    }
    match pairs.enumerate().find(|(_, (best, certified))| best > certified) {
        Some((led, (best, certified))) => {
            Err(format!("LED number {led}: best_mm {best} exceeds certified_mm {certified}"))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::artefact::Document;

    fn bounds(certified_mm: Vec<f64>, best_mm: Vec<f64>) -> Bounds {
        Bounds {
            format: Bounds::FORMAT.into(),
            law: LightLaw::TONE_2020,
            min_bend_radius_mm: 12.0,
            wall_mm: 0.0,
            arrival_tilt_deg: 0.0,
            leds: vec![LedId(0), LedId(1)],
            targets: vec![Target { position: DVec3::X, normal: DVec3::Z, certified_mm, best_mm }],
        }
    }

    #[test]
    fn a_document_survives_the_file() {
        let written = bounds(vec![900.0, 0.0], vec![850.5, 0.0]);
        let read = Bounds::from_json(&written.to_json()).unwrap();
        assert_eq!(read, written);
        assert_eq!(read.target_at(DVec3::X), Some(&written.targets[0]));
        assert_eq!(read.target_at(DVec3::Y), None);
    }

    #[test]
    fn broken_promises_are_named() {
        let check = |bounds: Bounds, says: &str| {
            let error = Bounds::from_json(&bounds.to_json()).unwrap_err().to_string();
            assert!(error.contains(says), "{error:?} does not say {says:?}");
        };
        check(bounds(vec![900.0], vec![850.0, 1.0]), "for each of 2 LEDs");
        check(bounds(vec![900.0, 5.0], vec![850.0, 6.0]), "LED number 1: best_mm 6 exceeds certified_mm 5");
        check(bounds(vec![900.0, 5.0], vec![850.0, -6.0]), "not negative");
        check(Bounds { wall_mm: -1.0, ..bounds(vec![1.0; 2], vec![1.0; 2]) }, "not negative");
    }
}
