//! The shortest distance between two surfaces.

use fibar_ruler::bvh::Bvh;
use fibar_ruler::contact::{Contact, Triangle};
use glam::DVec3;
use rayon::prelude::*;

/// The thinnest place of a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// Distance between its sides, mm.
    pub thickness: f64,
    /// Halfway between them, mm.
    pub place: DVec3,
}

/// Walls that are thicker than this everywhere are not measured, mm.
const THICKEST_MM: f64 = 20.0;
/// Triangles that one thread takes at a time; fixed, so that the answer does not depend on the threads.
const CHUNK: usize = 2048;

/// A place must be thinner than the thinnest so far by this to be looked at, mm.
const TOLERANCE_MM: f64 = 1e-3;

/// The least distance from any triangle of one side to any of the other. Distances of triangles are exact, so the wall is
/// that thin at its place, and nowhere thinner by more than [`TOLERANCE_MM`]. None if there is nothing within
/// [`THICKEST_MM`].
pub fn thinnest(side: &[Triangle], other: &Bvh) -> Option<Wall> {
    let nearest_of = |chunk: &[Triangle]| {
        let shorter = |best: Option<Contact>, t: &Triangle| {
            let below = best.map_or(THICKEST_MM, |contact| contact.distance - TOLERANCE_MM);
            other.nearest(t, below).or(best)
        };
        chunk.iter().fold(None, shorter)
    };
    let contacts: Vec<Option<Contact>> = side.par_chunks(CHUNK).map(nearest_of).collect();
    let best = contacts.into_iter().flatten().min_by(|a, b| a.distance.total_cmp(&b.distance))?;
    Some(Wall { thickness: best.distance, place: best.near.midpoint(best.far) })
}
