//! How far the axes of different patterns really are apart: bounds from below on the exact curves.
//!
//! Curves are cut into chords from which they stray by no more than a known little ([`Piece::stray`]).

use fibar_geometry::pieces::Piece;
use fibar_geometry::segments::approach;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// A course as chords.
pub struct Chords {
    pattern: u32,
    chords: Vec<Chord>,
    balls: Vec<Ball>,
}

/// A straight piece and how far the curve may be from it, mm.
#[derive(Clone, Copy)]
struct Chord {
    ends: [DVec3; 2],
    stray: f64,
}

/// A ball around some chords in a row and the curve along them.
struct Ball {
    centre: DVec3,
    radius: f64,
    chords: Range<usize>,
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

/// Chords in a row that share a ball.
const ROW: usize = 8;

impl Chords {
    /// Cuts a course.
    pub fn of(pattern: u32, pieces: &[Piece]) -> Chords {
        let mut chords = vec![];
        pieces.iter().for_each(|piece| cut(piece, &mut chords));
        let firsts = (0..chords.len()).step_by(ROW);
        let balls = firsts.map(|first| Ball::around(&chords, first..(first + ROW).min(chords.len())));
        Chords { pattern, balls: balls.collect(), chords }
    }
}

fn cut(piece: &Piece, chords: &mut Vec<Chord>) {
    const MOST_STRAY_MM: f64 = 0.004;
    const LONGEST_MM: f64 = 3.0;
    let [a, .., b] = piece.points;
    let stray = piece.stray();
    if stray <= MOST_STRAY_MM && a.distance_squared(b) <= LONGEST_MM * LONGEST_MM {
        chords.push(Chord { ends: [a, b], stray });
    } else {
        piece.halves().iter().for_each(|half| cut(half, chords));
    }
}

impl Ball {
    fn around(all: &[Chord], chords: Range<usize>) -> Ball {
        let ends = || all[chords.clone()].iter().flat_map(|chord| chord.ends);
        let (low, high) =
            ends().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let centre = low.midpoint(high);
        let radius = ends().fold(0.0, |most: f64, p| most.max(p.distance_squared(centre))).sqrt();
        let stray = all[chords.clone()].iter().fold(0.0, |most: f64, chord| most.max(chord.stray));
        Ball { centre, radius: radius + stray, chords }
    }
}

/// The pairs of different patterns whose axes are less than `apart` mm apart, of those that are asked for, in order.
pub fn contacts(strands: &[Chords], apart: f64, asked: impl Fn([usize; 2]) -> bool + Sync) -> Vec<Contact> {
    let of = |a: usize| {
        let others = (0..a).filter(|&b| strands[a].pattern != strands[b].pattern && asked([b, a]));
        others.filter_map(|b| contact([b, a], strands, apart)).collect::<Vec<Contact>>()
    };
    (0..strands.len()).into_par_iter().map(of).collect::<Vec<_>>().concat()
}

fn contact([a, b]: [usize; 2], strands: &[Chords], apart: f64) -> Option<Contact> {
    let (one, other) = (&strands[a], &strands[b]);
    let mut found: Option<Contact> = None;
    for ball in &one.balls {
        for other_ball in &other.balls {
            let limit = apart + ball.radius + other_ball.radius;
            if ball.centre.distance_squared(other_ball.centre) > limit * limit {
                continue;
            }
            for p in &one.chords[ball.chords.clone()] {
                for q in &other.chords[other_ball.chords.clone()] {
                    let approach = approach(p.ends, q.ends);
                    let distance = approach.arm.length() - p.stray - q.stray;
                    if distance < found.map_or(apart, |f| f.distance) {
                        let place = p.ends[0].lerp(p.ends[1], approach.s);
                        found = Some(Contact { strands: [a, b], distance, place });
                    }
                }
            }
        }
    }
    found
}
