//! Why a file could not be read, and where.

use crate::threemf::Rule;
use std::fmt;

/// An error at a place of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadError {
    /// The part of a package, the object of a scene: what `place` counts in, where that is not the file itself.
    pub part: Option<Box<str>>,
    /// Where.
    pub place: Place,
    /// What.
    pub message: Box<str>,
    /// The rule of the 3MF core specification that is broken.
    pub rule: Option<Rule>,
    hint: Option<Box<str>>,
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line, counted from 1.
    Line(u64),
    /// A byte, counted from 0.
    Byte(u64),
}

impl ReadError {
    /// An error without a hint of its own.
    pub fn new(place: Place, message: impl Into<String>) -> ReadError {
        ReadError { part: None, place, message: message.into().into(), rule: None, hint: None }
    }

    /// The same, with what to try.
    pub fn try_this(mut self, hint: impl Into<String>) -> ReadError {
        self.hint = Some(hint.into().into());
        self
    }

    /// The same, inside a part of the file.
    pub fn inside(mut self, part: impl Into<String>) -> ReadError {
        self.part = Some(part.into().into());
        self
    }

    /// The same, because it breaks a rule.
    pub fn breaking(mut self, rule: Rule) -> ReadError {
        self.rule = Some(rule);
        self
    }

    /// What to try.
    pub fn hint(&self) -> &str {
        let general = "the file is damaged or of another format than its name says; export it again";
        let breach =
            "the program that wrote the file broke the 3MF specification; export it again, or as STL";
        self.hint.as_deref().unwrap_or(if self.rule.is_some() { breach } else { general })
    }
}

impl std::error::Error for ReadError {}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(part) = &self.part {
            write!(f, "{part}: ")?;
        }
        write!(f, "{}{}", self.place, self.message)?;
        match self.rule {
            Some(rule) => write!(f, " ({rule})"),
            None => Ok(()),
        }
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
