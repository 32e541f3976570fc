//! The room for axes of fibres: how far from the skin, the LEDs' holes and other cavities a place lies, sampled and exactly.
//!
//! *Slack* is what is left of the distance to the body's surface after the fibre's outer radius, the skin and the wall, or of the
//! distance to a hole after the outer radius and the wall, whichever is less; negative where an axis must not run. Near its
//! ends a fibre has to come through: there slack does not count.

use crate::distance::{DistanceGrid, GridOptions, Lattice, Surface};
use crate::pieces::Piece;
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
    /// Distances beyond this may be a little too large; see [`GridOptions::exact`].
    pub exact: f64,
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
        let RoomOptions { spacing, band, exact } = options;
        let grid = DistanceGrid::sample(&surface, GridOptions { spacing, margin: 2.0, band, exact });
        let lattice = *grid.lattice();
        let holes = all_holes(sockets);
        let inset = keeping.radius + keeping.skin + keeping.wall;
        let beside = keeping.radius + keeping.wall;
        let slack = |n: usize| {
            let body = -grid.samples()[n] - inset;
            let place = lattice.place(n);
            let near = holes.iter().filter(|hole| may_be_within(hole, body + beside, place));
            near.fold(body, |least, hole| least.min(distance(hole, place) - beside))
        };
        let slack = (0..lattice.len()).into_par_iter().map(slack).collect();
        Room { surface, keeping, holes, lattice, slack }
    }

    /// Slack, mm, and its gradient, between samples. As off as [`DistanceGrid`] is.
    pub fn slack(&self, place: DVec3) -> (f64, DVec3) {
        self.lattice.interpolate_linear(&self.slack, place)
    }

    /// Whether the sampled slack is certainly `least` mm or more; much quicker than asking for it.
    pub fn surely_has(&self, place: DVec3, least: f64) -> bool {
        self.lattice.surely_reaches(&self.slack, place, least)
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

    /// The least slack along a course, its ends excepted, to `tolerance` mm: never more than the true one; and its parameter.
    pub fn least_slack(&self, pieces: &[Piece], tolerance: f64) -> (f64, f64) {
        let inner = without_ends(pieces, self.exempt_start(), self.exempt_end());
        let from = (f64::INFINITY, 0.0);
        inner.iter().fold(from, |least, piece| lesser(least, self.least_on(piece, tolerance, least.0)))
    }

    /// The slack falls by no more than 1 mm per mm, so the middle of a short piece bounds what lies in its control polygon.
    fn least_on(&self, piece: &Piece, tolerance: f64, known: f64) -> (f64, f64) {
        const TOLD_APART: f64 = 1.0;
        let middle = piece.point(0.5);
        let reach = piece.points.iter().fold(0.0, |most: f64, p| most.max(p.distance_squared(middle))).sqrt();
        let place = 0.5 * (piece.domain[0] + piece.domain[1]);
        let bound = self.exact_slack(middle, TOLD_APART + reach) - reach;
        if bound >= known.min(TOLD_APART) || 2.0 * reach < tolerance {
            return (bound, place);
        }
        let [first, second] = piece.halves();
        let first = self.least_on(&first, tolerance, known);
        lesser(first, self.least_on(&second, tolerance, known.min(first.0)))
    }
}

/// The one with less slack.
fn lesser(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    if b.0 < a.0 { b } else { a }
}

/// What lies between two arcs from the ends, mm; arcs are counted in eighths of a piece.
fn without_ends(pieces: &[Piece], from_start: f64, from_end: f64) -> Vec<Piece> {
    let start = reached(pieces.iter().copied(), from_start);
    let end = reached(pieces.iter().rev().map(Piece::reversed), from_end);
    let (Some((first, from)), Some((last, to))) = (start, end) else { return vec![] };
    let (last, to) = (pieces.len() - 1 - last, 1.0 - to);
    let part = |k: usize| {
        let from = if k == first { from } else { 0.0 };
        let to = if k == last { to } else { 1.0 };
        (from < to).then(|| pieces[k].between(from, to))
    };
    (first..last + 1).filter_map(part).collect()
}

/// The piece in which an arc from the start ends, and where in it; none if all pieces are shorter.
fn reached(pieces: impl Iterator<Item = Piece>, arc: f64) -> Option<(usize, f64)> {
    const PARTS: u32 = 8;
    let mut walked = 0.0;
    for (number, piece) in pieces.enumerate() {
        let mut here = piece.points[0];
        for k in 1..=PARTS {
            let t = f64::from(k) / f64::from(PARTS);
            let next = piece.point(t);
            let step = here.distance(next);
            if walked + step > arc {
                let share = (arc - walked) / step;
                return Some((number, (f64::from(k - 1) + share) / f64::from(PARTS)));
            }
            walked += step;
            here = next;
        }
    }
    None
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

/// Whether a cavity might be within a distance of a place, mm: a ball around it is.
fn may_be_within(cavity: &Cavity, distance: f64, place: DVec3) -> bool {
    let half = match cavity.section {
        Section::Circle { diameter_mm } => 0.5 * diameter_mm,
        Section::Rectangle { width_mm, length_mm } => 0.5 * libm::hypot(width_mm, length_mm),
    };
    let reach = distance + cavity.depth_mm + half;
    reach > 0.0 && place.distance_squared(cavity.position) < reach * reach
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
