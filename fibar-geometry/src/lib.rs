//! Pure geometry: curves, frames, meshes, distance, rays, sampling and the optics of a bent fibre.
//!
//! No file, clock, process or C++ here. Every result depends on its arguments alone, to the bit and for any thread count.
//! Lengths mm, angles rad.

pub mod curve;
pub mod frame;

pub mod minimise;
pub mod optics;

pub mod alone;
pub mod bound;
pub mod course;
pub mod passage;
pub mod pieces;
pub mod room;

mod company;
pub mod crossings;
pub mod deviation;
pub mod distance;
pub mod half_edges;
mod outline;
pub mod overlaps;
mod patches;
pub mod rays;
pub mod sampling;
pub mod segments;
pub mod viewsphere;
