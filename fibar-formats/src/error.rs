//! Why a file could not be read, and where.

use std::fmt;

/// An error at a place of the file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{place}{message}")]
pub struct ReadError {
    /// Where.
    pub place: Place,
    /// What.
    pub message: String,
    hint: Option<&'static str>,
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line, counted from 1.
    Line(usize),
    /// A byte, counted from 0.
    Byte(usize),
}

impl ReadError {
    /// An error without a hint of its own.
    pub fn new(place: Place, message: impl Into<String>) -> ReadError {
        ReadError { place, message: message.into(), hint: None }
    }

    /// The same, with what to try.
    pub fn try_this(mut self, hint: &'static str) -> ReadError {
        self.hint = Some(hint);
        self
    }

    /// What to try.
    pub fn hint(&self) -> &'static str {
        self.hint.unwrap_or("the file is damaged or of another format than its name says; export it again")
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::File => Ok(()),
            Place::Line(line) => write!(f, "line {line}: "),
            Place::Byte(byte) => write!(f, "byte {byte}: "),
        }
    }
}
