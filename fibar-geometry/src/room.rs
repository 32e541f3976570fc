//! The room for axes of fibres: how far from the skin and from the LEDs' holes a place lies, sampled and exactly.
//!
//! *Slack* is what is left of the distance to the body's surface after the fibre's outer radius, the skin and the wall, or of the
//! distance to a hole after the outer radius and the wall, whichever is less; negative where an axis must not run. Near its
//! ends a fibre has to come through: there slack does not count.

use crate::curve::Curve;
use crate::distance::{DistanceGrid, GridOptions, Lattice, Surface};
use fibar_core::artefact::sockets::{Hole, Sockets};
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
    holes: Vec<Cylinder>,
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
        let holes: Vec<Cylinder> =
            sockets.sockets.iter().map(|s| Cylinder::of(s.position, s.axis, &sockets.hole)).collect();
        let inset = keeping.radius + keeping.skin + keeping.wall;
        let beside = keeping.radius + keeping.wall;
        let slack = |n: usize| {
            let body = -grid.samples()[n] - inset;
            holes.iter().fold(body, |least, hole| least.min(hole.distance(lattice.place(n)) - beside))
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
        self.holes.iter().fold(body.min(enough), |least, hole| least.min(hole.distance(place) - beside))
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

/// The hole of an LED.
#[derive(Clone, Copy, Debug)]
struct Cylinder {
    tip: DVec3,
    axis: DVec3,
    radius: f64,
    depth: f64,
}

impl Cylinder {
    fn of(tip: DVec3, axis: DVec3, hole: &Hole) -> Cylinder {
        Cylinder { tip, axis, radius: 0.5 * hole.diameter_mm, depth: hole.depth_mm }
    }

    /// Distance, mm; 0 inside.
    fn distance(&self, place: DVec3) -> f64 {
        let from_tip = place - self.tip;
        let height = from_tip.dot(self.axis);
        let beside = ((from_tip - height * self.axis).length() - self.radius).max(0.0);
        let beyond = height.max(-height - self.depth).max(0.0);
        libm::hypot(beside, beyond)
    }
}
