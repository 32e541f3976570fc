//! `courses.json`: the best curve known of every pair of an LED and a place, were its fibre alone in the object.
//!
//! They belong to a [`Bounds`](super::bounds::Bounds) of the same run, whose `best_mm` is their light: who chooses which LED feeds which place
//! can see by them whose fibres would be in each other's way. Places are rounded to [`GRAIN_MM`], so no curve here proves anything.

use super::{check_finite, document};
use crate::id::LedId;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// What coordinates are rounded to, mm.
pub const GRAIN_MM: f64 = 0.01;

/// The best courses of every pair.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Courses {
    /// `"fibar.courses/1"`.
    pub format: String,
    /// The LEDs, in the order of the lists below.
    pub leds: Vec<LedId>,
    /// The places, in the order of the sites or markers that they were made for.
    pub targets: Vec<Reached>,
}

/// How each LED reaches one place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reached {
    /// On the outer surface, mm; exactly as in the sites or markers.
    pub position: DVec3,
    /// By LED: control points of a clamped cubic of equal knot spans, from its tip to the place, mm; none where no curve is known.
    pub curves: Vec<Vec<[f64; 3]>>,
}

impl Courses {
    /// A document of the current format.
    pub fn new(leds: Vec<LedId>, targets: Vec<Reached>) -> Courses {
        Courses { format: Self::format_name(), leds, targets }
    }

    /// How each LED reaches exactly this place.
    pub fn target_at(&self, position: DVec3) -> Option<&Reached> {
        self.targets.iter().find(|target| target.position == position)
    }

    fn format_name() -> String {
        <Courses as super::Document>::FORMAT.into()
    }
}

/// A point as it is written.
pub fn rounded(point: DVec3) -> [f64; 3] {
    // Dividing by a whole number gives the shortest decimals.
    point.to_array().map(|x| (x / GRAIN_MM).round() / (1.0 / GRAIN_MM).round())
}

document!(Courses, "fibar.courses/1", |c| {
    c.targets.iter().enumerate().try_for_each(|(k, target)| {
        check_target(target, c.leds.len()).map_err(|what| format!("targets[{k}]: {what}"))
    })
});

fn check_target(target: &Reached, leds: usize) -> Result<(), String> {
    check_finite("position", target.position)?;
    if target.curves.len() != leds {
        return Err(format!("needs a curve for each of {leds} LEDs, has {}", target.curves.len()));
    }
    for (led, points) in target.curves.iter().enumerate() {
        if (1..4).contains(&points.len()) {
            return Err(format!("LED number {led}: a cubic of {} points", points.len()));
        }
        points.iter().try_for_each(|p| check_finite(&format!("LED number {led}"), DVec3::from(*p)))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::artefact::Document;

    fn courses(curves: Vec<Vec<[f64; 3]>>) -> Courses {
        Courses::new(vec![LedId(0), LedId(1)], vec![Reached { position: DVec3::X, curves }])
    }

    #[test]
    fn a_document_survives_the_file() {
        let point = rounded(DVec3::new(0.123456, -7.0, 12.339_999));
        assert_eq!(point, [0.12, -7.0, 12.34]);
        let written = courses(vec![vec![point; 4], vec![]]);
        let read = Courses::from_json(&written.to_json()).unwrap();
        assert_eq!(read, written);
        assert_eq!(read.target_at(DVec3::X), Some(&written.targets[0]));
    }

    #[test]
    fn broken_promises_are_named() {
        let check = |courses: Courses, says: &str| {
            let error = Courses::from_json(&courses.to_json()).unwrap_err().to_string();
            assert!(error.contains(says), "{error:?} does not say {says:?}");
        };
        check(courses(vec![vec![]]), "for each of 2 LEDs, has 1");
        check(courses(vec![vec![], vec![[0.0; 3]]]), "targets[0]: LED number 1: a cubic of 1 points");
        let other = Courses { format: "fibar.courses/2".into(), ..courses(vec![vec![], vec![]]) };
        check(other, "fibar.courses/2");
    }
}
