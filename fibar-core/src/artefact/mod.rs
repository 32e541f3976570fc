//! Artefact types: what passes from stage to stage, each with a reader that refuses what breaks its promises.
//!
//! Readers take bytes and writers give bytes; files are the caller's. JSON artefacts carry `format`, `"fibar.routes/1"`
//! say, and unknown keys are errors. All lengths mm, all places in the body's frame: base at z = 0, +Z up.

pub mod bounds;
pub mod constellation;
pub mod courses;
pub mod mesh;
pub mod parts;
pub mod places;
pub mod routes;
pub mod sites;
pub mod sockets;
pub mod solids;
pub mod verdict;

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Why bytes are not the artefact they claim to be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ArtefactError {
    /// Not JSON of the artefact's shape.
    #[error("not a {format} document: {message}")]
    Shape {
        /// The format expected.
        format: &'static str,
        /// What the parser saw, with line and column.
        message: String,
    },
    /// Well-formed, but breaks a promise of its type.
    #[error("{format}: {message}")]
    Promise {
        /// The format read.
        format: &'static str,
        /// Which promise, and where.
        message: String,
    },
}

/// A JSON artefact: its format name and the promises beyond its shape.
pub trait Document: Serialize + DeserializeOwned {
    /// Name and number of the format.
    const FORMAT: &'static str;

    /// The `format` field as read.
    fn format(&self) -> &str;

    /// The promises that the shape alone cannot make; the message of the first one broken.
    fn check(&self) -> Result<(), String>;

    /// Reads and checks a document.
    fn from_json(bytes: &[u8]) -> Result<Self, ArtefactError> {
        let shape =
            |e: serde_json::Error| ArtefactError::Shape { format: Self::FORMAT, message: e.to_string() };
        let document: Self = serde_json::from_slice(bytes).map_err(shape)?;
        let promise = |message| ArtefactError::Promise { format: Self::FORMAT, message };
        if document.format() != Self::FORMAT {
            return Err(promise(format!("the file says format \"{}\"", document.format())));
        }
        document.check().map_err(promise)?;
        Ok(document)
    }

    /// Writes the document, indented, fields in their declared order, one final newline.
    fn to_json(&self) -> Vec<u8> {
        let mut bytes =
            serde_json::to_vec_pretty(self).expect("artefact types hold no map with non-string keys");
        bytes.push(b'\n');
        bytes
    }
}

/// Implements the two fixed parts of [`Document`].
macro_rules! document {
    ($type:ty, $format:literal, $check:expr) => {
        impl crate::artefact::Document for $type {
            const FORMAT: &'static str = $format;
            fn format(&self) -> &str {
                &self.format
            }
            fn check(&self) -> Result<(), String> {
                let check: fn(&Self) -> Result<(), String> = $check;
                check(self)
            }
        }
    };
}
use document;

/// Finite coordinates, or a message naming `what`.
fn check_finite(what: &str, v: glam::DVec3) -> Result<(), String> {
    if v.is_finite() { Ok(()) } else { Err(format!("{what} has a coordinate that is not finite: {v}")) }
}

/// A unit vector to 1e-6, or a message naming `what`.
fn check_unit(what: &str, v: glam::DVec3) -> Result<(), String> {
    if (v.length() - 1.0).abs() < 1e-6 {
        Ok(())
    } else {
        Err(format!("{what} must be a unit vector, has length {}", v.length()))
    }
}
