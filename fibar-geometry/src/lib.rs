//! Pure geometry: curves, frames, meshes, distance, rays, sampling and the optics of a bent fibre.
//!
//! No file, clock, process or C++ here. Every result depends on its arguments alone, to the bit and for any thread count.
//! Lengths mm, angles rad.

pub mod curve;
pub mod frame;

pub mod optics;

pub mod distance;
pub mod rays;
pub mod sampling;
pub mod viewsphere;
