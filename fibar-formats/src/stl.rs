//! STL, ASCII and binary. Each triangle brings its own corners; sharing them again is the repair's work.

use crate::error::{Place, ReadError};
use crate::words::Words;
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// Bytes before the first triangle: a title of 80 and the count.
const HEADER: usize = 84;
/// A triangle: normal, three corners, two bytes of attributes.
const RECORD: usize = 50;

/// Reads either kind. A title of `solid` proves nothing; a size that fits the count proves a binary file.
pub fn read(bytes: &[u8]) -> Result<TriangleMesh, ReadError> {
    let fits = declared_size(bytes) == Some(bytes.len() as u64);
    let head = &bytes[..bytes.len().min(1024)];
    let is_text =
        bytes.starts_with(b"solid") && head.iter().all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace());
    if !fits && is_text { read_ascii(bytes) } else { read_binary(bytes) }
}

fn declared_size(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    let count = u32::from_le_bytes(count.try_into().expect("four bytes were taken"));
    Some(HEADER as u64 + u64::from(count) * RECORD as u64)
}

fn read_binary(bytes: &[u8]) -> Result<TriangleMesh, ReadError> {
    let length = bytes.len() as u64;
    let end = Place::Byte(bytes.len());
    let size = declared_size(bytes)
        .ok_or_else(|| ReadError::new(end, "the file ends within the header of 84 bytes"))?;
    let count = (size - HEADER as u64) / RECORD as u64;
    if size > length {
        return Err(ReadError::new(end, format!("the file ends, but {count} triangles need {size} bytes")));
    }
    if size < length {
        let place = Place::Byte(size as usize);
        return Err(ReadError::new(place, format!("{} bytes follow the {count} triangles", length - size)));
    }
    let mut mesh = TriangleMesh::default();
    for (k, record) in bytes[HEADER..].chunks_exact(RECORD).enumerate() {
        let corners = read_record(record);
        if !corners.iter().all(|v| v.is_finite()) {
            return Err(ReadError::new(Place::Byte(HEADER + k * RECORD), "a corner is not finite"));
        }
        push_triangle(&mut mesh, corners);
    }
    Ok(mesh)
}

fn read_record(record: &[u8]) -> [DVec3; 3] {
    let number = |at: usize| {
        f64::from(f32::from_le_bytes(record[at..at + 4].try_into().expect("four bytes were taken")))
    };
    [12, 24, 36].map(|at| DVec3::new(number(at), number(at + 4), number(at + 8)))
}

fn read_ascii(bytes: &[u8]) -> Result<TriangleMesh, ReadError> {
    let mut mesh = TriangleMesh::default();
    let mut words = Words::new(bytes, 1);
    while !words.is_at_end() {
        words.expect("solid")?;
        words.skip_line();
        read_facets(&mut mesh, &mut words)?;
        words.skip_line();
    }
    Ok(mesh)
}

/// Facets up to and with `endsolid`.
fn read_facets(mesh: &mut TriangleMesh, words: &mut Words) -> Result<(), ReadError> {
    loop {
        match words.next()? {
            word if word.eq_ignore_ascii_case("endsolid") => return Ok(()),
            word if word.eq_ignore_ascii_case("facet") => push_triangle(mesh, read_facet(words)?),
            word => return Err(words.error(format!("`{word}` where `facet` or `endsolid` should be"))),
        }
    }
}

/// From after `facet` to `endfacet`. The normal is passed over: the order of the corners says the same.
fn read_facet(words: &mut Words) -> Result<[DVec3; 3], ReadError> {
    words.expect("normal")?;
    (0..3).try_for_each(|_| words.next().map(drop))?;
    words.expect("outer")?;
    words.expect("loop")?;
    let mut corners = [DVec3::ZERO; 3];
    for corner in &mut corners {
        words.expect("vertex")?;
        *corner = DVec3::new(words.number()?, words.number()?, words.number()?);
    }
    words.expect("endloop")?;
    words.expect("endfacet")?;
    Ok(corners)
}

fn push_triangle(mesh: &mut TriangleMesh, corners: [DVec3; 3]) {
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend(corners);
    mesh.triangles.push([first, first + 1, first + 2]);
}
