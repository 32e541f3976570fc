//! STL, ASCII and binary. Each triangle brings its own corners; sharing them again is the repair's work.

use crate::builder::MeshBuilder;
use crate::error::{Place, ReadError};
use crate::stream::Stream;
use crate::words::Words;
use glam::DVec3;

/// Bytes before the first triangle: a title of 80 and the count.
const HEADER: usize = 84;
/// A triangle: normal, three corners, two bytes of attributes.
const RECORD: usize = 50;

/// Reads either kind. A title of `solid` proves nothing; a size that fits the count proves a binary file.
pub fn read(mut stream: Stream, mesh: &mut MeshBuilder) -> Result<(), ReadError> {
    let length = stream.remaining();
    let window = stream.peek(1024)?;
    let head = &window[..window.len().min(1024)];
    let fits = declared_size(head) == Some(length);
    let is_text =
        head.starts_with(b"solid") && head.iter().all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace());
    if !fits && is_text { read_ascii(Words::new(stream, 1), mesh) } else { read_binary(stream, mesh) }
}

fn declared_size(head: &[u8]) -> Option<u64> {
    let count = head.get(HEADER - 4..HEADER)?;
    let count = u32::from_le_bytes(count.try_into().expect("four bytes were taken"));
    Some(HEADER as u64 + u64::from(count) * RECORD as u64)
}

fn read_binary(mut stream: Stream, mesh: &mut MeshBuilder) -> Result<(), ReadError> {
    let length = stream.remaining();
    let end = Place::Byte(length);
    let size = declared_size(stream.peek(HEADER)?)
        .ok_or_else(|| ReadError::new(end, "the file ends within the header of 84 bytes"))?;
    let count = (size - HEADER as u64) / RECORD as u64;
    if size > length {
        let message = format!("the file ends, but {count} triangles need {size} bytes");
        return Err(ReadError::new(end, message));
    }
    if size < length {
        let place = Place::Byte(size);
        return Err(ReadError::new(place, format!("{} bytes follow the {count} triangles", length - size)));
    }
    mesh.announce_triangles(count, Place::Byte(80))?;
    stream.skip(HEADER);
    for k in 0..count {
        let corners = read_record(stream.take(RECORD)?);
        mesh.push_loose(corners, Place::Byte(HEADER as u64 + k * RECORD as u64))?;
    }
    Ok(())
}

fn read_record(record: &[u8]) -> [DVec3; 3] {
    let number = |at: usize| {
        f64::from(f32::from_le_bytes(record[at..at + 4].try_into().expect("four bytes were taken")))
    };
    [12, 24, 36].map(|at| DVec3::new(number(at), number(at + 4), number(at + 8)))
}

fn read_ascii(mut words: Words, mesh: &mut MeshBuilder) -> Result<(), ReadError> {
    while !words.is_at_end()? {
        words.expect("solid")?;
        words.skip_line()?;
        while read_facet(mesh, &mut words)? {}
        words.skip_line()?;
    }
    Ok(())
}

/// A facet; false at `endsolid`. The normal is passed over: the order of the corners says the same.
fn read_facet(mesh: &mut MeshBuilder, words: &mut Words) -> Result<bool, ReadError> {
    let word = words.next()?;
    if word.text.eq_ignore_ascii_case("endsolid") {
        return Ok(false);
    }
    if !word.text.eq_ignore_ascii_case("facet") {
        return Err(word.error(format!("`{}` where `facet` or `endsolid` should be", word.shown())));
    }
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
    mesh.push_loose(corners, words.place())?;
    Ok(true)
}
