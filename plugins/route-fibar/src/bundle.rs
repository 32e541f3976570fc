//! The bundle: all fibres of an object as chains of control points, equally many each.

use crate::ends::Ends;
use fibar_core::PatternId;
use fibar_core::artefact::routes::Fibre;
use fibar_core::material::LayerRadii;
use fibar_geometry::curve::clamped_uniform_knots;
use glam::DVec3;

/// Degree of the curves (the paper says NURBS, not which).
const DEGREE: usize = 3;

/// Control points at either end that never move.
pub const FIXED: usize = 2;

/// All fibres.
#[derive(Clone, Debug, PartialEq)]
pub struct Bundle {
    /// Where each fibre starts and ends, in order of fibre.
    pub ends: Vec<Ends>,
    /// Control points, fibre after fibre, mm.
    pub points: Vec<DVec3>,
    /// Control points of a fibre.
    pub count: usize,
}

impl Bundle {
    /// Four control points a fibre: LED, above the LED, below the marker, marker (Tone 2020, "Initial routing").
    pub fn of_ends(ends: Vec<Ends>) -> Bundle {
        let points = ends.iter().flat_map(Ends::control_points).collect();
        Bundle { ends, points, count: 2 * FIXED }
    }

    /// The control points of each fibre, from LED to marker.
    pub fn chains(&self) -> impl Iterator<Item = &[DVec3]> {
        self.points.chunks(self.count)
    }

    /// What the fibre of a control point carries.
    pub fn pattern(&self, point: usize) -> PatternId {
        self.ends[point / self.count].pattern
    }

    /// A new control point halfway between any two neighbours, save within the end pieces.
    pub fn with_midpoints(&self) -> Bundle {
        let count = 2 * self.count - 3;
        let points: Vec<DVec3> = self.chains().flat_map(insert_midpoints).collect();
        Bundle { ends: self.ends.clone(), points, count }
    }

    /// The fibres as cubic curves of equal knot spans, all weights 1.
    pub fn to_fibres(&self, radii_mm: LayerRadii) -> Vec<Fibre> {
        let fibre = |(id, (ends, points)): (u32, (&Ends, &[DVec3]))| Fibre {
            id,
            marker: ends.marker,
            led: ends.led,
            pattern: ends.pattern,
            degree: DEGREE,
            knots: clamped_uniform_knots(DEGREE, points.len()),
            points: points.to_vec(),
            weights: vec![1.0; points.len()],
            radii_mm,
        };
        (1..).zip(self.ends.iter().zip(self.chains())).map(fibre).collect()
    }
}

fn insert_midpoints(chain: &[DVec3]) -> Vec<DVec3> {
    let last = chain.len() - FIXED;
    let follow = |k: usize| {
        let inner = (FIXED - 1..last).contains(&k);
        std::iter::once(chain[k]).chain(inner.then(|| chain[k].midpoint(chain[k + 1])))
    };
    (0..chain.len()).flat_map(follow).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_rounds_make_35_points_and_keep_the_ends() {
        let line = [0.0, 2.5, 10.5, 13.0].map(|z| DVec3::Z * z);
        let mut bundle = Bundle { ends: vec![], points: [line, line].concat(), count: 4 };
        for count in [5, 7, 11, 19, 35] {
            bundle = bundle.with_midpoints();
            assert_eq!((bundle.count, bundle.points.len()), (count, 2 * count));
            for chain in bundle.chains() {
                assert_eq!(chain[..2], line[..2]);
                assert_eq!(chain[count - 2..], line[2..]);
                assert!(chain.is_sorted_by(|a, b| a.z < b.z), "{chain:?}");
            }
        }
    }
}
