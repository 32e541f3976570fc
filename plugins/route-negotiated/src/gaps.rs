//! How far the axes of different patterns really are apart: bounds from below on the exact curves.
//!
//! Curves are cut into chords so short that the curve, whose bend is limited, strays from them by a known little.

use fibar_geometry::curve::Curve;
use fibar_geometry::segments::approach;
use glam::DVec3;
use rayon::prelude::*;

/// A curve as chords.
pub struct Chords {
    pattern: u32,
    places: Vec<DVec3>,
    /// How far the curve may be from its chords, mm.
    stray: f64,
}

/// Two strands that come closer than asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Which strands.
    pub strands: [usize; 2],
    /// Distance of their axes, mm; no more than the true one.
    pub distance: f64,
    /// Where on the first.
    pub place: DVec3,
}

/// Chords to a span of the curve.
const CHORDS_A_SPAN: usize = 12;
/// Chords in a row that share a ball.
const ROW: usize = 12;

impl Chords {
    /// Cuts a curve.
    pub fn of(pattern: u32, curve: &Curve) -> Chords {
        let (first, last) = curve.domain();
        let spans = curve.breaks().len() - 1;
        let count = spans * CHORDS_A_SPAN;
        let jet = |k: usize| curve.jet(first + (last - first) * k as f64 / count as f64);
        let jets: Vec<_> = (0..=count).map(jet).collect();
        let curvature = jets.iter().fold(0.0f64, |most, jet| most.max(jet.curvature()));
        let longest = jets.windows(2).fold(0.0f64, |l, w| l.max(w[0].position.distance(w[1].position)));
        // An arc of length h strays h²κ/8 from its chord; the curvature between the places is within a fifth of theirs.
        let stray = 1.2 * curvature * longest * longest / 8.0;
        Chords { pattern, places: jets.iter().map(|jet| jet.position).collect(), stray }
    }
}

/// All pairs of different patterns whose axes are less than `apart` mm apart, in order.
pub fn contacts(strands: &[Chords], apart: f64) -> Vec<Contact> {
    let balls: Vec<Vec<(DVec3, f64)>> = strands.iter().map(balls).collect();
    let of = |a: usize| {
        let others = (0..a).filter(|&b| strands[a].pattern != strands[b].pattern);
        others.filter_map(|b| contact([b, a], strands, &balls, apart)).collect::<Vec<Contact>>()
    };
    (0..strands.len()).into_par_iter().map(of).collect::<Vec<_>>().concat()
}

fn contact(
    [a, b]: [usize; 2],
    strands: &[Chords],
    balls: &[Vec<(DVec3, f64)>],
    apart: f64,
) -> Option<Contact> {
    let stray = strands[a].stray + strands[b].stray;
    let mut found: Option<Contact> = None;
    for (k, (centre, radius)) in balls[a].iter().enumerate() {
        for (l, (other, other_radius)) in balls[b].iter().enumerate() {
            let limit = apart + stray + radius + other_radius;
            if centre.distance_squared(*other) > limit * limit {
                continue;
            }
            for p in row(&strands[a], k) {
                for q in row(&strands[b], l) {
                    let approach = approach([p[0], p[1]], [q[0], q[1]]);
                    let distance = approach.arm.length() - stray;
                    if distance < found.map_or(apart, |f| f.distance) {
                        let place = p[0].lerp(p[1], approach.s);
                        found = Some(Contact { strands: [a, b], distance, place });
                    }
                }
            }
        }
    }
    found
}

fn row(strand: &Chords, k: usize) -> std::slice::Windows<'_, DVec3> {
    let last = strand.places.len() - 1;
    strand.places[k * ROW..=(k * ROW + ROW).min(last)].windows(2)
}

fn balls(strand: &Chords) -> Vec<(DVec3, f64)> {
    let ball = |first: usize| {
        let end = (first + ROW).min(strand.places.len() - 1);
        let covered = &strand.places[first..=end];
        let centre = covered.iter().copied().sum::<DVec3>() / covered.len() as f64;
        (centre, covered.iter().fold(0.0, |r: f64, p| r.max(p.distance(centre))))
    };
    (0..strand.places.len() - 1).step_by(ROW).map(ball).collect()
}
