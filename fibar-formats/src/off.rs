//! OFF: the variants with normals, colours and texture (`NOFF`, `COFF`, `STOFF` and together); text only.
//!
//! A line is a vertex or a face. What follows the coordinates or the corners is colour or the like, and passed over.

use crate::builder::MeshBuilder;
use crate::error::{Place, ReadError};
use crate::stream::Stream;
use crate::words::{parse_number, shown};
use glam::DVec3;

/// Reads an OFF file.
pub fn read(stream: Stream, mesh: &mut MeshBuilder) -> Result<(), ReadError> {
    let mut lines = Lines { stream, text: String::new(), line: 0 };
    let [vertices, faces] = read_counts(&mut lines)?;
    lines.check_count(vertices + faces)?;
    mesh.announce_triangles(faces, lines.place())?;
    for _ in 0..vertices {
        lines.next()?;
        mesh.push_vertex(read_vertex(&lines)?, lines.place())?;
    }
    let mut corners = Vec::new();
    for _ in 0..faces {
        lines.next()?;
        read_corners(&lines, &mut corners)?;
        mesh.push_polygon(&corners, lines.place())?;
    }
    match lines.read_on()? {
        true => Err(lines.error("more lines than the header announces")),
        false => Ok(()),
    }
}

/// The keyword, then the numbers of vertices, faces and edges: on a line of their own, or right after the keyword.
fn read_counts(lines: &mut Lines) -> Result<[u64; 2], ReadError> {
    lines.next()?;
    let at = lines.text.find("OFF").map(|at| at + 3);
    let (keyword, rest) = lines.text.split_at(at.unwrap_or(0));
    let rest = rest.trim().to_string();
    match keyword {
        "OFF" | "COFF" | "NOFF" | "CNOFF" | "STOFF" | "STCOFF" | "STNOFF" | "STCNOFF" => {}
        "" => return Err(lines.error("an OFF file starts with `OFF`")),
        other => {
            let message = format!("`{}` is a variant of OFF that is not known here", shown(other));
            return Err(lines.error(message).try_this("export it as plain OFF, or as STL, OBJ or PLY"));
        }
    }
    if rest.starts_with("BINARY") {
        let hint = "export it as text, or as binary STL or PLY";
        return Err(lines.error("binary OFF is not known here").try_this(hint));
    }
    if rest.is_empty() {
        lines.next()?;
    } else {
        lines.text = rest;
    }
    let mut counts = lines.text.split_ascii_whitespace().map(|word| word.parse::<u32>().ok().map(u64::from));
    match [counts.next().flatten(), counts.next().flatten()] {
        [Some(vertices), Some(faces)] => Ok([vertices, faces]),
        _ => Err(lines.error("here must be the numbers of vertices, faces and edges")),
    }
}

fn read_vertex(lines: &Lines) -> Result<DVec3, ReadError> {
    let mut words = lines.text.split_ascii_whitespace();
    let mut next = || {
        let word = words.next().ok_or_else(|| lines.error("a vertex has 3 coordinates"))?;
        parse_number(word, lines.place())
    };
    Ok(DVec3::new(next()?, next()?, next()?))
}

/// A count, then as many corners.
fn read_corners(lines: &Lines, corners: &mut Vec<i64>) -> Result<(), ReadError> {
    let mut words = lines.text.split_ascii_whitespace();
    let mut next = || words.next().and_then(|word| word.parse::<u32>().ok());
    let bad = || lines.error(format!("`{}` is not a count and as many corners", shown(&lines.text)));
    let count = next().ok_or_else(bad)?;
    corners.clear();
    for _ in 0..count {
        corners.push(i64::from(next().ok_or_else(bad)?));
    }
    Ok(())
}

/// Lines that say something.
struct Lines<'a> {
    stream: Stream<'a>,
    /// The line, without comment and blanks around it.
    text: String,
    line: u64,
}

impl Lines<'_> {
    /// Moves to the next line; an error where the file ends.
    fn next(&mut self) -> Result<(), ReadError> {
        match self.read_on()? {
            true => Ok(()),
            false => Err(self.error("the file ends too early")),
        }
    }

    /// Moves to the next line; false where the file ends.
    fn read_on(&mut self) -> Result<bool, ReadError> {
        while let Some(raw) = self.stream.line()? {
            self.line += 1;
            let text = raw.split(|&b| b == b'#').next().unwrap_or_default();
            let text = std::str::from_utf8(text)
                .map_err(|_| ReadError::new(Place::Line(self.line), "this is not text"))?;
            let text = text.trim();
            if !text.is_empty() {
                self.text.clear();
                self.text.push_str(text);
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// A line takes six bytes at least; a count that the file cannot hold is refused before anything is read.
    fn check_count(&self, lines: u64) -> Result<(), ReadError> {
        let needed = (lines * 6).saturating_sub(1);
        if needed <= self.stream.remaining() {
            return Ok(());
        }
        let message = format!("{lines} lines need {needed} bytes, {} are there", self.stream.remaining());
        Err(self.error(message).try_this("the file is cut short; copy or export it again"))
    }

    fn place(&self) -> Place {
        Place::Line(self.line)
    }

    fn error(&self, message: impl Into<String>) -> ReadError {
        ReadError::new(self.place(), message)
    }
}
