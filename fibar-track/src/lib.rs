//! The camera's side: which marker is which blob, and where the object is.

pub mod camera;
pub mod consensus;
mod judge;
pub mod lookup;
mod matrix6;
pub mod model;
pub mod p3p;
pub mod pose;
pub mod recogniser;
pub mod refinement;
#[cfg(test)]
mod synthetic;
mod triples;
pub mod twin;
