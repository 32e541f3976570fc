//! The header of a PLY file: which elements with which properties follow, and how numbers are written.

use super::numbers::{Kind, Numbers};
use crate::error::{Place, ReadError};

/// A table of the file.
pub struct Element {
    /// `vertex`, `face` or another.
    pub name: String,
    /// Number of rows.
    pub count: u32,
    /// Columns.
    pub properties: Vec<Property>,
    /// Line of the header that declares it.
    pub line: usize,
}

/// A column.
pub struct Property {
    /// Its name.
    pub name: String,
    /// One number or a list of them.
    pub shape: Shape,
}

/// What a column holds in each row.
pub enum Shape {
    /// One number.
    Scalar(Kind),
    /// A count, then as many items.
    List {
        /// How the count is written.
        count: Kind,
        /// How an item is written.
        item: Kind,
    },
}

/// Reads the header; returns the elements and what follows.
pub fn read(bytes: &[u8]) -> Result<(Vec<Element>, Numbers<'_>), ReadError> {
    let mut lines = Lines { bytes, at: 0, line: 0 };
    if lines.next()?.trim() != "ply" {
        return Err(lines.error("a PLY file starts with `ply`"));
    }
    let mut format = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        let words: Vec<&str> = lines.next()?.split_ascii_whitespace().collect();
        match words[..] {
            ["end_header"] => break,
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, "1.0"] => format = Some(name),
            ["element", name, count] => elements.push(read_element(name, count, &lines)?),
            ["property", ref rest @ ..] => {
                let property = read_property(rest, &lines)?;
                let element = elements.last_mut();
                element
                    .ok_or_else(|| lines.error("a property before any element"))?
                    .properties
                    .push(property);
            }
            _ => return Err(lines.error(format!("`{}` has no place in a PLY header", words.join(" ")))),
        }
    }
    let rest = &bytes[lines.at..];
    let numbers = match format {
        Some("ascii") => Numbers::text(rest, lines.line + 1),
        Some("binary_little_endian") => Numbers::little_endian(bytes, lines.at),
        Some("binary_big_endian") => Numbers::big_endian(bytes, lines.at),
        _ => return Err(lines.error("the header names no format that is known: ascii or binary, 1.0")),
    };
    Ok((elements, numbers))
}

fn read_element(name: &str, count: &str, lines: &Lines) -> Result<Element, ReadError> {
    let count = count.parse().map_err(|_| lines.error(format!("`{count}` is not a count below 2³²")))?;
    Ok(Element { name: name.into(), count, properties: Vec::new(), line: lines.line })
}

/// The words after `property`.
fn read_property(words: &[&str], lines: &Lines) -> Result<Property, ReadError> {
    let kind =
        |name: &str| Kind::named(name).ok_or_else(|| lines.error(format!("`{name}` is not a PLY type")));
    match *words {
        ["list", count, item, name] => {
            let shape = Shape::List { count: kind(count)?, item: kind(item)? };
            Ok(Property { name: name.into(), shape })
        }
        [scalar, name] => Ok(Property { name: name.into(), shape: Shape::Scalar(kind(scalar)?) }),
        _ => Err(lines.error("a property has a type and a name, or `list`, two types and a name")),
    }
}

/// The lines of the header.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Result<&'a str, ReadError> {
        let rest = &self.bytes[self.at..];
        self.line += 1;
        let length = rest.iter().position(|&b| b == b'\n');
        let length = length.ok_or_else(|| self.error("the file ends before `end_header`"))?;
        self.at += length + 1;
        std::str::from_utf8(&rest[..length]).map_err(|_| self.error("this is not text"))
    }

    fn error(&self, message: impl Into<String>) -> ReadError {
        ReadError::new(Place::Line(self.line), message)
    }
}
