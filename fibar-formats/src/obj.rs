//! Wavefront OBJ: `v` and `f` lines. Texture, normals, groups and materials are passed over; curved surfaces are refused.

use crate::error::{Place, ReadError};
use crate::polygon::push_fan;
use crate::words::parse_number;
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// Keywords that say nothing about triangles.
const PASSED_OVER: [&str; 18] = [
    "vt",
    "vn",
    "vp",
    "g",
    "o",
    "s",
    "mg",
    "l",
    "p",
    "usemtl",
    "mtllib",
    "usemap",
    "maplib",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "shadow_obj",
];

/// Reads an OBJ file.
pub fn read(bytes: &[u8]) -> Result<TriangleMesh, ReadError> {
    let mut mesh = TriangleMesh::default();
    for (line, text) in logical_lines(bytes)? {
        read_line(&mut mesh, &text, Place::Line(line))?;
    }
    Ok(mesh)
}

/// Lines without comments, those ending in `\` joined with the next; each with the number of its first line.
fn logical_lines(bytes: &[u8]) -> Result<Vec<(usize, String)>, ReadError> {
    let mut lines: Vec<(usize, String)> = Vec::new();
    let mut continued = false;
    for (k, raw) in bytes.split(|&b| b == b'\n').enumerate() {
        let text = raw.split(|&b| b == b'#').next().unwrap_or_default();
        let text = std::str::from_utf8(text)
            .map_err(|_| ReadError::new(Place::Line(k + 1), "this is not text"))?
            .trim_end();
        let (content, continues) = match text.strip_suffix('\\') {
            Some(content) => (content, true),
            None => (text, false),
        };
        match lines.last_mut().filter(|_| continued) {
            Some((_, line)) => line.push_str(content),
            None => lines.push((k + 1, content.to_string())),
        }
        continued = continues;
    }
    Ok(lines)
}

fn read_line(mesh: &mut TriangleMesh, text: &str, place: Place) -> Result<(), ReadError> {
    let mut words = text.split_ascii_whitespace();
    match words.next() {
        None => Ok(()),
        Some("v") => read_vertex(words, place).map(|vertex| mesh.vertices.push(vertex)),
        Some("f") => read_face(mesh, words, place),
        Some(word) if PASSED_OVER.contains(&word) => Ok(()),
        Some(word) => {
            Err(ReadError::new(place, format!("`{word}` is not an OBJ keyword that holds triangles")))
        }
    }
}

fn read_vertex<'a>(words: impl Iterator<Item = &'a str>, place: Place) -> Result<DVec3, ReadError> {
    let numbers = words.take(3).map(|word| parse_number(word, place)).collect::<Result<Vec<f64>, _>>()?;
    match numbers[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err(ReadError::new(place, format!("a vertex has 3 coordinates, this one {}", numbers.len()))),
    }
}

/// `f 1 2 3`, `f 1/1/1 …`, `f -3 -2 -1`: only the first number of a corner matters.
fn read_face<'a>(
    mesh: &mut TriangleMesh,
    words: impl Iterator<Item = &'a str>,
    place: Place,
) -> Result<(), ReadError> {
    let count = mesh.vertices.len() as i64;
    let corner = |word: &str| {
        let number = word.split('/').next().unwrap_or_default();
        match number.parse::<i64>() {
            Ok(number) if number > count || number == 0 || number < -count => Err(ReadError::new(
                place,
                format!("vertex {number} does not exist, there are {count} so far"),
            )),
            Ok(number) if number < 0 => Ok(count + number),
            Ok(number) => Ok(number - 1),
            Err(_) => Err(ReadError::new(place, format!("`{word}` is not a corner of a face"))),
        }
    };
    let corners = words.map(corner).collect::<Result<Vec<i64>, _>>()?;
    push_fan(&mut mesh.triangles, &corners, mesh.vertices.len(), place)
}
