//! Vertices at the very same place become one. No distance is involved: near is not equal.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use std::collections::BTreeMap;

/// A mesh whose vertices are all at different places and used.
pub struct Welded {
    /// The mesh, in the order of the old one.
    pub mesh: TriangleMesh,
    /// Triangles dropped because two of their corners were the same vertex.
    pub degenerate: usize,
}

/// Welds by exact coordinates.
pub fn weld(mesh: TriangleMesh) -> Welded {
    let mut numbers: BTreeMap<[u64; 3], u32> = BTreeMap::new();
    let mut vertices = Vec::new();
    let mut number_of = |v: DVec3| {
        *numbers.entry(key(v)).or_insert_with(|| {
            vertices.push(v);
            vertices.len() as u32 - 1
        })
    };
    let mut triangles = Vec::with_capacity(mesh.triangles.len());
    for triangle in &mesh.triangles {
        let places = triangle.map(|v| mesh.vertices[v as usize]);
        let [a, b, c] = places.map(key);
        if a != b && b != c && c != a {
            triangles.push(places.map(&mut number_of));
        }
    }
    let degenerate = mesh.triangles.len() - triangles.len();
    Welded { mesh: TriangleMesh { vertices, triangles }, degenerate }
}

/// The bits of a place; −0 counts as 0.
fn key(v: DVec3) -> [u64; 3] {
    v.to_array().map(|x| (x + 0.0).to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_places_become_one_vertex() {
        let (o, x, y) = (DVec3::ZERO, DVec3::X, DVec3::Y);
        let near = DVec3::new(1e-300, 0.0, 0.0);
        let mesh = TriangleMesh {
            vertices: vec![o, x, y, -o, y, x, near, DVec3::ONE],
            triangles: vec![[0, 1, 2], [3, 4, 5], [0, 3, 1], [0, 6, 1]],
        };
        let welded = weld(mesh);
        assert_eq!(welded.mesh.vertices, [o, x, y, near], "the unused vertex is gone, the near one stays");
        assert_eq!(welded.mesh.triangles, [[0, 1, 2], [0, 2, 1], [0, 3, 1]]);
        assert_eq!(welded.degenerate, 1);
    }
}
