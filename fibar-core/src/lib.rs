//! The vocabulary of fibar: what a code, a marker, a fibre and an artefact *are*.
//!
//! Every other room speaks these words. Nothing here opens a file, reads a clock or starts a process; artefact types are
//! read from bytes and written to bytes. Units: mm, rad, s, f64, right-handed, +Z up.

pub mod artefact;

pub mod adjacency;
pub mod code;
pub mod code_design;
pub mod code_separation;
pub mod code_set;
pub mod decoding;
pub mod diagnostic;
pub mod id;
pub mod images;
pub mod levenshtein;
pub mod light;
pub mod material;
pub mod protocol;
pub mod recognition;

pub use id::{LedId, MarkerId, PatternId};
