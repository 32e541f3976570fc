//! `clearance.wall`: from a fibre's outer surface to the skin's inner side, away from the ends.
//!
//! "Away from the ends" is the part of the exact curve from the end of the LED's straight leg to where, along the arc, the
//! marker's straight leg and the fibre's outer radius and the skin remain: closer to its marker a fibre must come through
//! the skin's inner side. The wall is the axis's distance to the body's surface less radius and skin; where the axis
//! leaves the body it is negative by more than both.

use crate::Params;
use crate::judgement::{self, Judgement};
use crate::strand::{Strand, enclose};
use fibar_core::artefact::verdict::Place;
use fibar_ruler::capsules::CapsuleTree;
use fibar_ruler::surface::ClosedSurface;
use glam::DVec3;
use rayon::prelude::*;

/// What counts as away from the ends, and how much wall is asked.
pub struct Rule {
    at_least: f64,
    skin: f64,
    leg: f64,
}

impl Rule {
    /// The rule as the parameters set it.
    pub fn of(params: &Params) -> Rule {
        Rule { at_least: params.min_wall_mm, skin: params.skin_mm, leg: params.end_leg_mm }
    }
}

/// Measures every fibre.
pub fn judge(strands: &[Strand], body: &ClosedSurface, rule: &Rule) -> Option<Judgement> {
    let places = strands.par_iter().filter_map(|strand| wall(strand, body, rule)).collect();
    let held = judgement::Rule {
        name: "clearance.wall",
        metric: "clearance.min_wall_mm",
        at_least: rule.at_least,
        subject: "wall from a fibre's outer surface to the skin's inner side, away from the ends",
    };
    held.judge(places)
}

/// The thinnest wall of one fibre; none if it has no part away from its ends.
fn wall(strand: &Strand, body: &ClosedSurface, rule: &Rule) -> Option<Place> {
    let middle = strand.curve.trimmed(rule.leg, rule.leg + strand.radius + rule.skin)?;
    let capsules = enclose(&middle);
    let (depth, position) = deepest_outside(&capsules, body).or_else(|| {
        let contact = capsules.nearest_on_mesh(body.bvh(), f64::INFINITY)?;
        Some((contact.distance, contact.near))
    })?;
    Some(Place { position, value: depth - strand.radius - rule.skin, what: format!("fibre {}", strand.id) })
}

/// Where the axis is furthest outside the body, among the ends of the finest capsules; their chords are short and the
/// distance changes no faster than the place, but this value alone is no bound.
fn deepest_outside(capsules: &CapsuleTree, body: &ClosedSurface) -> Option<(f64, DVec3)> {
    let points = capsules.leaves().flat_map(|leaf| [leaf.chord.0, leaf.chord.1]);
    let outside = points.map(|point| (body.depth(point), point)).filter(|(depth, _)| *depth < 0.0);
    outside.min_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strand::tests::{cube, strand};

    const RULE: Rule = Rule { at_least: 0.0, skin: 0.4, leg: 2.5 };

    /// A straight fibre along y through a cube of 40 mm centred on the z axis, at height `z`.
    #[track_caller]
    fn check(z: f64, wall_mm: f64) {
        let body = ClosedSurface::of(&cube(40.0));
        let fibre = strand(1, 1, vec![DVec3::new(0.0, -10.0, z), DVec3::new(0.0, 10.0, z)]);
        let found = wall(&fibre, &body, &RULE).unwrap();
        assert!((found.value - wall_mm).abs() < 1e-9, "{found:?} instead of {wall_mm}");
    }

    #[test]
    fn walls_of_a_fibre_in_a_cube() {
        check(30.0, 10.0 - 2.275);
        check(5.0, 5.0 - 2.275);
        check(1.0, 1.0 - 2.275);
        check(0.0, -2.275);
        check(-1.0, -1.0 - 2.275);
    }

    #[test]
    fn ends_do_not_count() {
        let body = ClosedSurface::of(&cube(40.0));
        let up = |from: f64, to: f64| strand(1, 1, vec![DVec3::Z * from, DVec3::Z * to]);
        let found = wall(&up(10.0, 40.0), &body, &RULE).unwrap();
        assert!((found.value - 2.5).abs() < 1e-6, "{found:?}");
        assert!(wall(&up(34.0, 40.0), &body, &RULE).is_none(), "nothing is away from the ends");
    }
}
