//! The numbers of a PLY file, whichever way they are written.

use super::header::{Property, Shape};
use crate::error::{Place, ReadError};
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

/// A stream of numbers with its place in the file.
pub enum Numbers<'a> {
    /// Words.
    Text(Words<'a>),
    /// Bytes of either order.
    Binary { bytes: &'a [u8], at: usize, is_big_endian: bool },
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

impl<'a> Numbers<'a> {
    /// Numbers as words; the first line of `text` is line `line` of the file.
    pub fn text(text: &'a [u8], line: usize) -> Numbers<'a> {
        Numbers::Text(Words::new(text, line))
    }

    /// Numbers from byte `at` on, least significant byte first.
    pub fn little_endian(bytes: &'a [u8], at: usize) -> Numbers<'a> {
        Numbers::Binary { bytes, at, is_big_endian: false }
    }

    /// Numbers from byte `at` on, most significant byte first.
    pub fn big_endian(bytes: &'a [u8], at: usize) -> Numbers<'a> {
        Numbers::Binary { bytes, at, is_big_endian: true }
    }

    /// The next number.
    pub fn next(&mut self, kind: Kind) -> Result<f64, ReadError> {
        match self {
            Numbers::Text(words) => words.number(),
            Numbers::Binary { bytes, at, is_big_endian } => {
                let size = kind.size();
                let Some(taken) = bytes.get(*at..*at + size) else {
                    return Err(ReadError::new(Place::Byte(bytes.len()), "the file ends too early"));
                };
                let mut value = [0; 8];
                value[..size].copy_from_slice(taken);
                if *is_big_endian {
                    value[..size].reverse();
                }
                *at += size;
                Ok(kind.value(value))
            }
        }
    }

    /// Least number of bytes that a value of the property takes.
    pub fn least_bytes(&self, property: &Property) -> u64 {
        let kind = match property.shape {
            Shape::Scalar(kind) => kind,
            Shape::List { count, .. } => count,
        };
        match self {
            Numbers::Text(_) => 1,
            Numbers::Binary { .. } => kind.size() as u64,
        }
    }

    /// Bytes not read yet, white space at the end aside.
    pub fn remaining(&self) -> usize {
        match self {
            Numbers::Text(words) => words.remaining(),
            Numbers::Binary { bytes, at, .. } => bytes.len() - *at,
        }
    }

    /// Where the stream is.
    pub fn place(&self) -> Place {
        match self {
            Numbers::Text(words) => words.place(),
            Numbers::Binary { at, .. } => Place::Byte(*at),
        }
    }
}
