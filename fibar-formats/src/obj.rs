//! Wavefront OBJ: `v` and `f` lines. Texture, normals, groups and materials are passed over; curved surfaces are refused.

use crate::builder::MeshBuilder;
use crate::error::{Place, ReadError};
use crate::stream::Stream;
use crate::words::{parse_number, shown};
use glam::DVec3;

/// Keywords that say nothing about triangles.
const PASSED_OVER: [&[u8]; 18] = [
    b"vt",
    b"vn",
    b"vp",
    b"g",
    b"o",
    b"s",
    b"mg",
    b"l",
    b"p",
    b"usemtl",
    b"mtllib",
    b"usemap",
    b"maplib",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
];

/// Reads an OBJ file.
pub fn read(mut stream: Stream, mesh: &mut MeshBuilder) -> Result<(), ReadError> {
    let (mut text, mut corners) = (Vec::new(), Vec::new());
    let mut line = 1;
    loop {
        let lines = logical_line(&mut stream, &mut text)?;
        if lines == 0 {
            return Ok(());
        }
        read_line(mesh, &text, &mut corners, Place::Line(line))?;
        line += lines;
    }
}

/// The next line without comment, those ending in `\` joined with what follows. Returns how many lines it took.
fn logical_line(stream: &mut Stream, text: &mut Vec<u8>) -> Result<u64, ReadError> {
    text.clear();
    let mut lines = 0;
    while let Some(raw) = stream.line()? {
        lines += 1;
        let line = raw.split(|&b| b == b'#').next().unwrap_or_default().trim_ascii_end();
        match line.strip_suffix(b"\\") {
            Some(start) => text.extend_from_slice(start),
            None => {
                text.extend_from_slice(line);
                break;
            }
        }
    }
    Ok(lines)
}

fn read_line(
    mesh: &mut MeshBuilder,
    text: &[u8],
    corners: &mut Vec<i64>,
    place: Place,
) -> Result<(), ReadError> {
    let text = text.trim_ascii_start();
    let length = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    let (keyword, rest) = text.split_at(length);
    if keyword.is_empty() || PASSED_OVER.contains(&keyword) {
        return Ok(());
    }
    if keyword != b"v" && keyword != b"f" {
        let keyword = shown(&String::from_utf8_lossy(keyword));
        let message = format!("`{keyword}` is not an OBJ keyword that holds triangles");
        return Err(ReadError::new(place, message));
    }
    let rest = std::str::from_utf8(rest).map_err(|_| ReadError::new(place, "this is not text"))?;
    let words = rest.split_ascii_whitespace();
    if keyword == b"v" {
        return mesh.push_vertex(read_vertex(words, place)?, place);
    }
    corners.clear();
    words
        .map(|word| corner(word, mesh.vertex_count(), place))
        .try_for_each(|k| k.map(|k| corners.push(k)))?;
    mesh.push_polygon(corners, place)
}

/// Three coordinates; a weight or a colour after them is passed over.
fn read_vertex<'a>(words: impl Iterator<Item = &'a str>, place: Place) -> Result<DVec3, ReadError> {
    let (mut numbers, mut count) = ([0.0; 3], 0);
    for word in words.take(3) {
        numbers[count] = parse_number(word, place)?;
        count += 1;
    }
    if count < 3 {
        return Err(ReadError::new(place, format!("a vertex has 3 coordinates, this one {count}")));
    }
    Ok(DVec3::from_array(numbers))
}

/// `1`, `1/1/1`, `-3`: only the first number of a corner matters; counted from 1, or back from the latest vertex.
fn corner(word: &str, count: usize, place: Place) -> Result<i64, ReadError> {
    let number = word.split('/').next().unwrap_or_default();
    let count = count as i64;
    match number.parse::<i64>() {
        Ok(number) if number > count || number == 0 || number < -count => {
            Err(ReadError::new(place, format!("vertex {number} does not exist, there are {count} so far")))
        }
        Ok(number) if number < 0 => Ok(count + number),
        Ok(number) => Ok(number - 1),
        Err(_) => Err(ReadError::new(place, format!("`{}` is not a corner of a face", shown(word)))),
    }
}
