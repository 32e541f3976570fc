//! Triangle meshes as binary little-endian PLY with f64 coordinates, mm.
//!
//! This is the exchange form between stages, written and read without loss. It is not a reader of the PLY files people
//! have: that is `source-mesh`'s work. Closedness and orientation are promises of the types `body` and `solids`, kept by
//! the stages that make them and checked by the verifiers, not here.

use super::{ArtefactError, places};
use glam::DVec3;
use std::collections::HashMap;

/// Vertices and counter-clockwise triangles that index them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Positions, mm.
    pub vertices: Vec<DVec3>,
    /// Indices of corners, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

const FORMAT: &str = "PLY mesh";
const VERTEX_BYTES: usize = 24;
const TRIANGLE_BYTES: usize = 13;

impl TriangleMesh {
    /// The three corners of a triangle, mm.
    #[inline]
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize])
    }

    /// Least and greatest coordinates, mm; `None` without vertices.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let first = *self.vertices.first()?;
        Some(self.vertices.iter().fold((first, first), |(lo, hi), v| (lo.min(*v), hi.max(*v))))
    }

    /// Signed volume of some triangles by the divergence theorem, mm³: Σ a · (b × c) / 6.
    pub fn volume_of(&self, triangles: std::ops::Range<usize>) -> f64 {
        let of = |k: usize| {
            let [a, b, c] = self.corners(k);
            a.dot(b.cross(c)) / 6.0
        };
        triangles.map(of).sum()
    }

    /// The same triangles; corners of exactly equal coordinates are one vertex, in the order of their first use. A soup of
    /// triangles shrinks to a third; nothing is snapped or left out.
    pub fn indexed(&self) -> TriangleMesh {
        let first = places::first_at_place(&self.vertices);
        self.renumbered(&self.triangles, |v| first[v as usize])
    }

    /// Some triangles that index the vertices of this mesh, with those vertices alone that they need, in the order of their first use.
    pub fn part(&self, triangles: &[[u32; 3]]) -> TriangleMesh {
        self.renumbered(triangles, |v| v)
    }

    /// Triangles with another vertex for each, numbered in the order of their first use.
    fn renumbered(&self, triangles: &[[u32; 3]], instead: impl Fn(u32) -> u32) -> TriangleMesh {
        let mut numbers = vec![u32::MAX; self.vertices.len()];
        let mut vertices = Vec::with_capacity(self.vertices.len().min(triangles.len() / 2 + 2));
        let mut number = |v: u32| {
            let v = instead(v) as usize;
            if numbers[v] == u32::MAX {
                numbers[v] = vertices.len() as u32;
                vertices.push(self.vertices[v]);
            }
            numbers[v]
        };
        let triangles = triangles.iter().map(|t| t.map(&mut number)).collect();
        TriangleMesh { vertices, triangles }
    }

    /// The same with corners of exactly equal coordinates shared, in the order of their first use; triangles that collapse are
    /// left out. Nothing is snapped.
    pub fn welded(&self) -> TriangleMesh {
        let mut welded = TriangleMesh::default();
        let mut known: HashMap<[u64; 3], u32> = HashMap::with_capacity(self.vertices.len());
        for triangle in &self.triangles {
            let corners = triangle.map(|v| {
                // −0 and 0 are the same place.
                let corner = self.vertices[v as usize] + DVec3::ZERO;
                let next = welded.vertices.len() as u32;
                *known.entry(corner.to_array().map(f64::to_bits)).or_insert_with(|| {
                    welded.vertices.push(corner);
                    next
                })
            });
            if corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0] {
                welded.triangles.push(corners);
            }
        }
        welded
    }

    /// Writes the mesh.
    pub fn to_ply(&self) -> Vec<u8> {
        let header = header(self.vertices.len(), self.triangles.len());
        let size = header.len() + self.vertices.len() * VERTEX_BYTES + self.triangles.len() * TRIANGLE_BYTES;
        let mut bytes = vec![0; size];
        let (head, body) = bytes.split_at_mut(header.len());
        head.copy_from_slice(header.as_bytes());
        let (vertices, triangles) = body.split_at_mut(self.vertices.len() * VERTEX_BYTES);
        for (slot, vertex) in vertices.as_chunks_mut::<VERTEX_BYTES>().0.iter_mut().zip(&self.vertices) {
            slot.as_chunks_mut().0.copy_from_slice(&vertex.to_array().map(f64::to_le_bytes));
        }
        for (slot, triangle) in triangles.as_chunks_mut::<TRIANGLE_BYTES>().0.iter_mut().zip(&self.triangles)
        {
            slot[0] = 3;
            slot[1..].as_chunks_mut().0.copy_from_slice(&triangle.map(u32::to_le_bytes));
        }
        bytes
    }

    /// Reads what [`to_ply`](Self::to_ply) writes, and nothing else: finite coordinates, indices in range.
    pub fn from_ply(bytes: &[u8]) -> Result<TriangleMesh, ArtefactError> {
        let (vertex_count, triangle_count, body) = split_header(bytes)?;
        let expected = vertex_count
            .checked_mul(VERTEX_BYTES)
            .zip(triangle_count.checked_mul(TRIANGLE_BYTES))
            .and_then(|(a, b)| a.checked_add(b));
        if expected != Some(body.len()) {
            let counts = format!("{vertex_count} vertices and {triangle_count} triangles");
            return Err(promise(format!("{counts} do not fill the {} bytes after the header", body.len())));
        }
        let (vertices, triangles) = body.split_at(vertex_count * VERTEX_BYTES);
        let mesh = TriangleMesh {
            vertices: read_vertices(vertices)?,
            triangles: read_triangles(triangles, vertex_count)?,
        };
        Ok(mesh)
    }
}

fn header(vertices: usize, triangles: usize) -> String {
    format!(
        "ply\nformat binary_little_endian 1.0\ncomment fibar.mesh/1, mm\nelement vertex {vertices}\n\
         property double x\nproperty double y\nproperty double z\nelement face {triangles}\n\
         property list uchar int vertex_indices\nend_header\n"
    )
}

/// Counts of vertices and triangles, and the bytes after the header.
fn split_header(bytes: &[u8]) -> Result<(usize, usize, &[u8]), ArtefactError> {
    let shape = |message: &str| ArtefactError::Shape { format: FORMAT, message: message.to_string() };
    const END: &[u8] = b"end_header\n";
    let head = &bytes[..bytes.len().min(512)];
    let end = head
        .windows(END.len())
        .position(|w| w == END)
        .ok_or_else(|| shape("no end_header in the first 512 bytes"))?;
    let (text, body) = bytes.split_at(end + END.len());
    let text = std::str::from_utf8(text).map_err(|_| shape("the header is not text"))?;
    let count = |key: &str| {
        let line = text.lines().find_map(|l| l.strip_prefix(key));
        line.and_then(|n| n.parse().ok()).ok_or_else(|| shape(&format!("no \"{key}N\" line")))
    };
    let (vertices, triangles) = (count("element vertex ")?, count("element face ")?);
    if text != header(vertices, triangles) {
        return Err(shape("the header is not the one of fibar.mesh/1 (f64 vertices, int triangles)"));
    }
    Ok((vertices, triangles, body))
}

fn read_vertices(bytes: &[u8]) -> Result<Vec<DVec3>, ArtefactError> {
    let vertex = |b: &[u8; VERTEX_BYTES]| {
        let coordinates = b.as_chunks().0;
        DVec3::from([0, 1, 2].map(|k| f64::from_le_bytes(coordinates[k])))
    };
    let vertices: Vec<DVec3> = bytes.as_chunks().0.iter().map(vertex).collect();
    match vertices.iter().position(|v| !v.is_finite()) {
        Some(k) => Err(promise(format!("vertex {k} is not finite"))),
        None => Ok(vertices),
    }
}

fn read_triangles(bytes: &[u8], vertex_count: usize) -> Result<Vec<[u32; 3]>, ArtefactError> {
    let faces = bytes.as_chunks::<TRIANGLE_BYTES>().0;
    let triangle = |b: &[u8; TRIANGLE_BYTES]| {
        let indices = b[1..].as_chunks().0;
        [0, 1, 2].map(|k| u32::from_le_bytes(indices[k]))
    };
    let is_known =
        |b: &[u8; TRIANGLE_BYTES]| b[0] == 3 && triangle(b).iter().all(|&v| (v as usize) < vertex_count);
    match faces.iter().position(|face| !is_known(face)) {
        Some(k) => Err(promise(format!("face {k} is not a triangle of known vertices"))),
        None => Ok(faces.iter().map(triangle).collect()),
    }
}

fn promise(message: String) -> ArtefactError {
    ArtefactError::Promise { format: FORMAT, message }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> TriangleMesh {
        TriangleMesh {
            vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.1, 0.2, 1e-300)],
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        }
    }

    #[test]
    fn what_is_written_is_read_back_to_the_bit() {
        let mesh = tetrahedron();
        assert_eq!(TriangleMesh::from_ply(&mesh.to_ply()), Ok(mesh));
        assert_eq!(TriangleMesh::from_ply(&TriangleMesh::default().to_ply()), Ok(TriangleMesh::default()));
    }

    #[test]
    fn a_soup_gets_shared_corners() {
        let mesh = tetrahedron();
        let corners = (0..4).flat_map(|t| mesh.corners(t));
        let soup = TriangleMesh {
            vertices: corners.map(|v| if v == DVec3::ZERO { -v } else { v }).collect(),
            triangles: (0..4).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        };
        let indexed = soup.indexed();
        assert_eq!(indexed.triangles, [[0, 1, 2], [0, 2, 3], [2, 1, 3], [1, 0, 3]]);
        assert_eq!(indexed.vertices, [0, 2, 1, 3].map(|v| mesh.vertices[v]));
    }

    #[test]
    fn broken_bytes_are_refused() {
        let good = tetrahedron().to_ply();
        let check = |bytes: &[u8], says: &str| {
            let error = TriangleMesh::from_ply(bytes).unwrap_err().to_string();
            assert!(error.contains(says), "{error:?} does not say {says:?}");
        };
        check(b"", "no end_header");
        check(&good[..good.len() - 1], "do not fill");
        let text = String::from_utf8_lossy(&good[..120]).replace("vertex 4", "vertex 99999999999999999999");
        check(&[text.as_bytes(), &good[120..]].concat(), "element vertex");
        let mut index = good.clone();
        *index.last_mut().unwrap() = 9;
        check(&index, "face 3");
        let at = good.len() - 4 * TRIANGLE_BYTES - 8;
        let mut nan = good;
        nan[at..at + 8].copy_from_slice(&f64::NAN.to_le_bytes());
        check(&nan, "vertex 3 is not finite");
    }
}
