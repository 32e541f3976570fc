//! The header of a PLY file: which elements with which properties follow, and how numbers are written.

use super::numbers::{Kind, Numbers};
use crate::error::{Place, ReadError};
use crate::stream::Stream;
use crate::words::{Words, shown};

/// A table of the file.
pub struct Element {
    /// `vertex`, `face` or another.
    pub name: String,
    /// Number of rows.
    pub count: u32,
    /// Columns.
    pub properties: Vec<Property>,
    /// Line of the header that declares it.
    pub line: u64,
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

/// Reads the header; returns the elements and the numbers that follow.
pub fn read(stream: Stream) -> Result<(Vec<Element>, Numbers), ReadError> {
    let mut lines = Lines { stream, line: 0 };
    if lines.next()?.trim() != "ply" {
        return Err(lines.error("a PLY file starts with `ply`"));
    }
    let (mut format, mut elements) = (String::new(), Vec::new());
    loop {
        let text = lines.next()?;
        match text.split_ascii_whitespace().collect::<Vec<_>>()[..] {
            ["end_header"] => break,
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, "1.0"] => format = name.to_string(),
            ["element", name, count] => elements.push(read_element(name, count, &lines)?),
            ["property", ref rest @ ..] => push_property(&mut elements, rest, &lines)?,
            _ => return Err(lines.error(format!("`{}` has no place in a PLY header", shown(&text)))),
        }
    }
    let binary = |stream, is_big_endian| Numbers::Binary { stream, is_big_endian };
    let numbers = match format.as_str() {
        "ascii" => Numbers::Text(Words::new(lines.stream, lines.line + 1)),
        "binary_little_endian" => binary(lines.stream, false),
        "binary_big_endian" => binary(lines.stream, true),
        _ => return Err(lines.error("the header names no format that is known: ascii or binary, 1.0")),
    };
    Ok((elements, numbers))
}

fn read_element(name: &str, count: &str, lines: &Lines) -> Result<Element, ReadError> {
    let count = count.parse().map_err(|_| lines.error(format!("`{count}` is not a count below 2³²")))?;
    Ok(Element { name: name.into(), count, properties: Vec::new(), line: lines.line })
}

/// The words after `property`, which belong to the latest element.
fn push_property(elements: &mut [Element], words: &[&str], lines: &Lines) -> Result<(), ReadError> {
    let unknown = |name: &str| lines.error(format!("`{}` is not a PLY type", shown(name)));
    let kind = |name: &str| Kind::named(name).ok_or_else(|| unknown(name));
    let (name, shape) = match *words {
        ["list", count, item, name] => (name, Shape::List { count: kind(count)?, item: kind(item)? }),
        [scalar, name] => (name, Shape::Scalar(kind(scalar)?)),
        _ => return Err(lines.error("a property has a type and a name, or `list`, two types and a name")),
    };
    let element = elements.last_mut().ok_or_else(|| lines.error("a property before any element"))?;
    element.properties.push(Property { name: name.into(), shape });
    Ok(())
}

/// The lines of the header.
struct Lines<'a> {
    stream: Stream<'a>,
    line: u64,
}

impl Lines<'_> {
    fn next(&mut self) -> Result<String, ReadError> {
        self.line += 1;
        let place = Place::Line(self.line);
        let line = self.stream.line()?;
        let line = line.ok_or_else(|| ReadError::new(place, "the file ends before `end_header`"))?;
        let text = std::str::from_utf8(line).map_err(|_| ReadError::new(place, "this is not text"))?;
        Ok(text.to_string())
    }

    fn error(&self, message: impl Into<String>) -> ReadError {
        ReadError::new(Place::Line(self.line), message)
    }
}
