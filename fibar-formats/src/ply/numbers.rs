//! The numbers of a PLY file, whichever way they are written.

use super::header::{Property, Shape};
use crate::error::{Place, ReadError};
use crate::stream::Stream;
use crate::words::Words;

/// How a number is written in a binary file.
#[derive(Clone, Copy)]
pub enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

/// Numbers with their places in the file.
pub enum Numbers<'a> {
    /// Words.
    Text(Words<'a>),
    /// Bytes of either order.
    Binary {
        /// Where they come from.
        stream: Stream<'a>,
        /// Most significant byte first.
        is_big_endian: bool,
    },
}

impl Kind {
    /// The type of that name, old or new style.
    pub fn named(name: &str) -> Option<Kind> {
        match name {
            "char" | "int8" => Some(Kind::I8),
            "uchar" | "uint8" => Some(Kind::U8),
            "short" | "int16" => Some(Kind::I16),
            "ushort" | "uint16" => Some(Kind::U16),
            "int" | "int32" => Some(Kind::I32),
            "uint" | "uint32" => Some(Kind::U32),
            "float" | "float32" => Some(Kind::F32),
            "double" | "float64" => Some(Kind::F64),
            _ => None,
        }
    }

    fn size(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::F64 => 8,
        }
    }

    /// The value of `size` bytes, most significant last.
    fn value(self, b: [u8; 8]) -> f64 {
        match self {
            Kind::I8 => f64::from(b[0] as i8),
            Kind::U8 => f64::from(b[0]),
            Kind::I16 => f64::from(i16::from_le_bytes([b[0], b[1]])),
            Kind::U16 => f64::from(u16::from_le_bytes([b[0], b[1]])),
            Kind::I32 => f64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Kind::U32 => f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Kind::F32 => f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Kind::F64 => f64::from_le_bytes(b),
        }
    }
}

impl Numbers<'_> {
    /// The next number.
    pub fn next(&mut self, kind: Kind) -> Result<f64, ReadError> {
        match self {
            Numbers::Text(words) => words.number(),
            Numbers::Binary { stream, is_big_endian } => {
                let size = kind.size();
                let mut value = [0; 8];
                value[..size].copy_from_slice(stream.take(size)?);
                if *is_big_endian {
                    value[..size].reverse();
                }
                Ok(kind.value(value))
            }
        }
    }

    /// The length of a list of `item`, which the rest of the file must be able to hold.
    pub fn length(&mut self, count: Kind, item: Kind) -> Result<u64, ReadError> {
        let length = self.next(count)?;
        let room = self.remaining() / self.least_size(item) + self.spare_bytes();
        if length >= 0.0 && length.fract() == 0.0 && length <= room as f64 {
            return Ok(length as u64);
        }
        Err(ReadError::new(self.place(), format!("a list of {length} does not fit the rest of the file")))
    }

    /// Least number of bytes that a value of the property takes.
    pub fn least_bytes(&self, property: &Property) -> u64 {
        match property.shape {
            Shape::Scalar(kind) | Shape::List { count: kind, .. } => self.least_size(kind),
        }
    }

    /// A number in text takes a digit and a blank.
    fn least_size(&self, kind: Kind) -> u64 {
        match self {
            Numbers::Text(_) => 2,
            Numbers::Binary { .. } => kind.size() as u64,
        }
    }

    /// The blank that the last number of a text can do without.
    pub fn spare_bytes(&self) -> u64 {
        u64::from(matches!(self, Numbers::Text(_)))
    }

    /// Bytes not read yet.
    pub fn remaining(&self) -> u64 {
        match self {
            Numbers::Text(words) => words.remaining(),
            Numbers::Binary { stream, .. } => stream.remaining(),
        }
    }

    /// Whether all is read, white space aside.
    pub fn is_at_end(&mut self) -> Result<bool, ReadError> {
        match self {
            Numbers::Text(words) => words.is_at_end(),
            Numbers::Binary { stream, .. } => Ok(stream.peek(1)?.is_empty()),
        }
    }

    /// Where the next number is.
    pub fn place(&self) -> Place {
        match self {
            Numbers::Text(words) => words.place(),
            Numbers::Binary { stream, .. } => Place::Byte(stream.offset()),
        }
    }
}
