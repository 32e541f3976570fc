//! The camera's side: which marker is which blob, and where the object is.
//!
//! Blobs come with decoded patterns; names and a pose with covariance go out. Everything here is a pure function of its
//! arguments, seeds included; no camera, clock or thread is touched. Frames and blinking in time are not here yet.
//!
//! ```
//! use fibar_core::artefact::{Document, constellation::Constellation};
//! use fibar_core::PatternId;
//! use fibar_track::camera::Camera;
//! use fibar_track::model::{Blob, Model};
//! use fibar_track::recogniser::{RecogniserOptions, recognise};
//!
//! let constellation = br#"{
//!   "format": "fibar.constellation/1", "bit_rate_hz": 350.0,
//!   "patterns": [{ "id": 1, "bits": "100011110101100" }, { "id": 2, "bits": "001" }],
//!   "markers": [
//!     { "id": 1, "position": [0, 0, 40], "normal": [0, 0, 1], "pattern": 1, "neighbours": [] },
//!     { "id": 2, "position": [30, 0, 0], "normal": [0, 0, 1], "pattern": 2, "neighbours": [] },
//!     { "id": 3, "position": [0, 30, 0], "normal": [0, 0, 1], "pattern": 2, "neighbours": [] },
//!     { "id": 4, "position": [-40, 10, 5], "normal": [0, 0, 1], "pattern": 2, "neighbours": [] }
//!   ]
//! }"#;
//! let model = Model::new(&Constellation::from_json(constellation).unwrap(), 60_f64.to_radians());
//! let camera = Camera::centred(1000.0, 720.0, 540.0);
//! // The camera hangs 500 mm above the origin and looks down, image x along object x.
//! let blob = |x, y, pattern| Blob { at: (x, y).into(), pattern: PatternId(pattern) };
//! let blobs = [blob(360.0, 270.0, 1), blob(420.0, 270.0, 2), blob(360.0, 210.0, 2), blob(360.0 - 4e4 / 495.0, 270.0 - 1e4 / 495.0, 2)];
//! let found = recognise(&model, &camera, &blobs, &RecogniserOptions::default());
//! assert_eq!(found.names, [Some(0), Some(1), Some(2), Some(3)]);
//! assert!((found.estimate.unwrap().pose.centre().z - 500.0).abs() < 1e-3);
//! ```

pub mod model;
pub mod recogniser;

pub mod lookup;

pub mod camera;
pub mod consensus;
mod judge;
mod matrix6;
pub mod p3p;
pub mod pose;
pub mod refinement;
#[cfg(test)]
mod synthetic;
mod triples;
pub mod twin;
