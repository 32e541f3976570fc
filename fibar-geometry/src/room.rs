//! The room for axes of fibres: how far from the skin, the LEDs' holes and other cavities a place lies, sampled and exactly.
//!
//! *Slack* is what is left of the distance to the body's surface after the fibre's outer radius, the skin and the wall, or of the
//! distance to a hole after the outer radius and the wall, whichever is less; negative where an axis must not run. Near its
//! ends a fibre has to come through: there slack does not count.

use crate::curve::Curve;
use crate::distance::{DistanceGrid, GridOptions, Lattice, Surface};
use fibar_core::artefact::sockets::{Cavity, Section, Sockets};
use glam::DVec3;
use rayon::prelude::*;

/// What an axis keeps away from things, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keeping {
    /// Outer radius of the fibre.
    pub radius: f64,
    /// Thickness of the skin.
    pub skin: f64,
    /// Between the fibre and the skin's inner side, or an LED's hole.
    pub wall: f64,
}

/// How finely the room is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoomOptions {
    /// Between samples, mm.
    pub spacing: f64,
    /// Distances from the surface beyond this are not told apart, mm.
    pub band: f64,
}

/// The room of one body.
pub struct Room {
    surface: Surface,
    keeping: Keeping,
    holes: Vec<Cavity>,
    lattice: Lattice,
    slack: Vec<f64>,
}

/// Straight pieces at the ends of a fibre, mm, by which the exempt ends are counted.
pub const END_LEG_MM: f64 = 2.5;

impl Room {
    /// Samples the room, on all threads of the current pool.
    pub fn new(surface: Surface, sockets: &Sockets, keeping: Keeping, options: RoomOptions) -> Room {
        let RoomOptions { spacing, band } = options;
        let grid = DistanceGrid::sample(&surface, GridOptions { spacing, margin: 2.0, band });
        let lattice = *grid.lattice();
        let holes = all_holes(sockets);
        let inset = keeping.radius + keeping.skin + keeping.wall;
        let beside = keeping.radius + keeping.wall;
        let slack = |n: usize| {
            let body = -grid.samples()[n] - inset;
            holes.iter().fold(body, |least, hole| least.min(distance(hole, lattice.place(n)) - beside))
        };
        let slack = (0..lattice.len()).into_par_iter().map(slack).collect();
        Room { surface, keeping, holes, lattice, slack }
    }

    /// Slack, mm, and its gradient, between samples. As off as [`DistanceGrid`] is.
    pub fn slack(&self, place: DVec3) -> (f64, DVec3) {
        self.lattice.interpolate_linear(&self.slack, place)
    }

    /// Where the samples are.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Slack at a sample, mm.
    pub fn sample(&self, number: usize) -> f64 {
        self.slack[number]
    }

    /// What is kept away.
    pub fn keeping(&self) -> Keeping {
        self.keeping
    }

    /// The surface of the body.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Arc from the LED within which slack does not count, mm: the leg.
    pub fn exempt_start(&self) -> f64 {
        END_LEG_MM
    }

    /// Arc before the marker within which slack does not count, mm: the leg, the fibre's radius and the skin.
    pub fn exempt_end(&self) -> f64 {
        END_LEG_MM + self.keeping.radius + self.keeping.skin
    }

    /// Slack without sampling, mm, or `enough` if it is more.
    pub fn exact_slack(&self, place: DVec3, enough: f64) -> f64 {
        let Keeping { radius, skin, wall } = self.keeping;
        let inset = radius + skin + wall;
        // Far inside, the sampled sign serves: the band is wider than its error.
        let sampled = self.slack(place).0;
        let reach = (enough + inset).max(1e-3);
        let body = match self.surface.closest_within(place, reach) {
            Some(closest) => -closest.signed_distance - inset,
            None if sampled > -inset => enough,
            None => -reach - inset,
        };
        let beside = radius + wall;
        self.holes.iter().fold(body.min(enough), |least, hole| least.min(distance(hole, place) - beside))
    }

    /// The least slack along a curve, its ends excepted, to `tolerance` mm: never more than the true one; and its parameter.
    pub fn least_slack(&self, curve: &Curve, tolerance: f64) -> (f64, f64) {
        let stretch = Stretch::of(curve, self.exempt_start(), self.exempt_end());
        stretch.parts().fold((f64::INFINITY, 0.0), |least, (a, b)| {
            let ends = (curve.point(a), curve.point(b));
            lesser(least, self.least_between(curve, (a, b), ends, tolerance, least.0))
        })
    }

    /// The slack falls by no more than 1 mm per mm, so the middle of a short piece bounds what lies beside it.
    fn least_between(
        &self,
        curve: &Curve,
        (a, b): (f64, f64),
        ends: (DVec3, DVec3),
        tolerance: f64,
        known: f64,
    ) -> (f64, f64) {
        const BEND: f64 = 1.02; // an arc is this much longer than its chord where pieces are short
        const TOLD_APART: f64 = 1.0;
        let reach = BEND * ends.0.distance(ends.1);
        let half = 0.5 * (a + b);
        let middle = curve.point(half);
        let bound = self.exact_slack(middle, TOLD_APART + reach) - 0.5 * reach;
        if bound >= known.min(TOLD_APART) || reach < tolerance {
            return (bound, half);
        }
        let left = self.least_between(curve, (a, half), (ends.0, middle), tolerance, known);
        lesser(left, self.least_between(curve, (half, b), (middle, ends.1), tolerance, known.min(left.0)))
    }
}

/// The one with less slack.
fn lesser(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    if b.0 < a.0 { b } else { a }
}

/// The part of a curve between two arcs from its ends, cut into short pieces.
struct Stretch {
    stops: Vec<f64>,
}

impl Stretch {
    fn of(curve: &Curve, from_start: f64, from_end: f64) -> Stretch {
        const PIECES_A_SPAN: usize = 8;
        let breaks = curve.breaks();
        let stops: Vec<f64> = breaks
            .windows(2)
            .flat_map(|w| {
                (0..PIECES_A_SPAN).map(move |k| w[0] + (w[1] - w[0]) * k as f64 / PIECES_A_SPAN as f64)
            })
            .chain(breaks.last().copied())
            .collect();
        let mut arcs = vec![0.0];
        for w in stops.windows(2) {
            let piece = curve.point(w[0]).distance(curve.point(w[1]));
            arcs.push(arcs[arcs.len() - 1] + piece);
        }
        let (from, to) = (from_start, arcs[arcs.len() - 1] - from_end);
        let inner = (0..stops.len()).filter(|&k| from < arcs[k] && arcs[k] < to).map(|k| stops[k]);
        let at = |arc: f64| {
            let k = arcs.partition_point(|a| *a < arc).clamp(1, arcs.len() - 1);
            let share = (arc - arcs[k - 1]) / (arcs[k] - arcs[k - 1]).max(1e-12);
            stops[k - 1] + share * (stops[k] - stops[k - 1])
        };
        let stops = match from < to {
            true => std::iter::once(at(from)).chain(inner).chain(std::iter::once(at(to))).collect(),
            false => vec![],
        };
        Stretch { stops }
    }

    fn parts(&self) -> impl Iterator<Item = (f64, f64)> {
        self.stops.windows(2).map(|w| (w[0], w[1]))
    }
}

/// The holes of the LEDs as cavities, and the cavities.
fn all_holes(sockets: &Sockets) -> Vec<Cavity> {
    let hole = |socket: &fibar_core::artefact::sockets::Socket| Cavity {
        name: format!("LED {}", socket.led),
        position: socket.position,
        axis: socket.axis,
        across: socket.axis.any_orthonormal_vector(),
        section: Section::Circle { diameter_mm: sockets.hole.diameter_mm },
        depth_mm: sockets.hole.depth_mm,
    };
    sockets.sockets.iter().map(hole).chain(sockets.cavities.iter().cloned()).collect()
}

/// Distance to a cavity, mm; 0 inside.
fn distance(cavity: &Cavity, place: DVec3) -> f64 {
    let from_ceiling = place - cavity.position;
    let height = from_ceiling.dot(cavity.axis);
    let flat = from_ceiling - height * cavity.axis;
    let beside = match cavity.section {
        Section::Circle { diameter_mm } => (flat.length() - 0.5 * diameter_mm).max(0.0),
        Section::Rectangle { width_mm, length_mm } => {
            let (u, v) = (flat.dot(cavity.across), flat.dot(cavity.axis.cross(cavity.across)));
            libm::hypot((u.abs() - 0.5 * width_mm).max(0.0), (v.abs() - 0.5 * length_mm).max(0.0))
        }
    };
    libm::hypot(beside, height.max(-height - cavity.depth_mm).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_keep_away_from_cavities_as_from_holes() {
        let board = Cavity {
            name: "board".into(),
            position: DVec3::new(5.0, 0.0, 6.0),
            axis: DVec3::Z,
            across: DVec3::Y,
            section: Section::Rectangle { width_mm: 20.0, length_mm: 10.0 },
            depth_mm: 6.0,
        };
        let cell = Cavity { section: Section::Circle { diameter_mm: 10.0 }, ..board.clone() };
        let check = |cavity: &Cavity, place: [f64; 3], expected: f64| {
            let found = distance(cavity, DVec3::from(place));
            assert!((found - expected).abs() < 1e-12, "{place:?}: {found}, not {expected}");
        };
        check(&board, [5.0, 9.9, 3.0], 0.0);
        check(&board, [5.0, 13.0, 3.0], 3.0);
        check(&board, [13.0, 0.0, 3.0], 3.0);
        check(&board, [13.0, 14.0, 3.0], 5.0);
        check(&board, [0.0, 0.0, 8.5], 2.5);
        check(&board, [0.0, 0.0, -2.0], 2.0);
        check(&cell, [5.0, 8.0, 3.0], 3.0);
        check(&cell, [5.0, 8.0, 10.0], 5.0);
    }
}
