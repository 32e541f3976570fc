//! `clearance.gap`: outer surface to outer surface, between fibres of different patterns.
//!
//! The outer surface is the sweep of a ball of the outer radius along the exact axis, which holds the printed tube with
//! its flat ends; so the gap is the distance of the axes less both radii, negative where they overlap.

use crate::judgement::{Judgement, Rule};
use crate::strand::Strand;
use fibar_core::artefact::verdict::Place;
use rayon::prelude::*;

/// Measures every pair.
pub fn judge(strands: &[Strand], at_least: f64) -> Option<Judgement> {
    let places = gaps(strands);
    let colliding = places.iter().filter(|place| place.value < 0.0).count();
    let rule = Rule {
        name: "clearance.gap",
        metric: "clearance.min_gap_mm",
        at_least,
        subject: "gap between the outer surfaces of fibres of different patterns",
    };
    let mut judgement = rule.judge(places)?;
    judgement.metrics.push(("clearance.colliding_pairs", colliding as f64, "1"));
    Some(judgement)
}

fn gaps(strands: &[Strand]) -> Vec<Place> {
    let pairs: Vec<(&Strand, &Strand)> = strands
        .iter()
        .enumerate()
        .flat_map(|(k, a)| strands[k + 1..].iter().map(move |b| (a, b)))
        .filter(|(a, b)| a.pattern != b.pattern)
        .collect();
    pairs.par_iter().filter_map(|(a, b)| gap(a, b)).collect()
}

fn gap(a: &Strand, b: &Strand) -> Option<Place> {
    let axes = a.capsules.nearest(&b.capsules, f64::INFINITY)?;
    Some(Place {
        position: axes.near.midpoint(axes.far),
        value: axes.distance - a.radius - b.radius,
        what: format!("fibres {} (pattern {}) and {} (pattern {})", a.id, a.pattern, b.id, b.pattern),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strand::tests::strand;
    use glam::DVec3;

    /// Two straight fibres along x and along y, their axes `height` mm apart.
    fn crossing(height: f64, patterns: [u32; 2]) -> Vec<Strand> {
        let along = |d: DVec3, z: f64| vec![-d * 20.0 + DVec3::Z * z, d * 20.0 + DVec3::Z * z];
        vec![strand(1, patterns[0], along(DVec3::X, 0.0)), strand(2, patterns[1], along(DVec3::Y, height))]
    }

    #[track_caller]
    fn check(height: f64, gap_mm: f64, colliding: f64) {
        let judgement = judge(&crossing(height, [1, 2]), 0.5).unwrap();
        assert!((judgement.finding.value - gap_mm).abs() < 1e-9, "{:?}", judgement.finding);
        assert_eq!(judgement.finding.holds, gap_mm >= 0.5);
        assert_eq!(judgement.metrics[1].1, colliding);
    }

    #[test]
    fn crossing_fibres() {
        check(10.0, 6.25, 0.0);
        check(4.0, 0.25, 0.0);
        check(3.75, 0.0, 0.0);
        check(3.0, -0.75, 1.0);
        check(0.0, -3.75, 1.0);
    }

    #[test]
    fn fibres_of_one_pattern_may_touch() {
        assert!(judge(&crossing(0.0, [3, 3]), 0.5).is_none());
    }
}
