//! Vertices at the very same place become one, and a triangle stands only once. No distance is involved: near is not equal.

use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::places::first_at_place;

/// A mesh whose vertices are all at different places and used, with what was dropped.
pub struct Welded {
    /// The mesh, in the order of the old one.
    pub mesh: TriangleMesh,
    /// Triangles dropped because two of their corners were the same vertex.
    pub degenerate: usize,
    /// Triangles dropped because they stood twice, or back to back with another.
    pub duplicate: usize,
}

/// Welds by exact coordinates.
pub fn weld(mesh: &TriangleMesh) -> Welded {
    let renamed = first_at_place(&mesh.vertices);
    let renamed = |triangle: &[u32; 3]| triangle.map(|v| renamed[v as usize]);
    let triangles: Vec<[u32; 3]> =
        mesh.triangles.iter().map(renamed).filter(|&triangle| !is_degenerate(triangle)).collect();
    let degenerate = mesh.triangles.len() - triangles.len();
    let single = without_duplicates(&triangles);
    let duplicate = triangles.len() - single.len();
    Welded { mesh: mesh.part(&single), degenerate, duplicate }
}

/// Whether a triangle has a corner twice.
pub fn is_degenerate([a, b, c]: [u32; 3]) -> bool {
    a == b || b == c || c == a
}

/// Keeps one of equal triangles, and none of a pair that stands back to back: together they enclose nothing.
fn without_duplicates(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let sorted = |[a, b, c]: [u32; 3]| {
        let mut corners = [a, b, c];
        corners.sort_unstable();
        corners
    };
    let mut order: Vec<([u32; 3], u32)> = triangles.iter().map(|&t| sorted(t)).zip(0..).collect();
    order.sort_unstable();
    let mut keep = vec![true; triangles.len()];
    for same in order.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() > 1) {
        same.iter().for_each(|&(_, t)| keep[t as usize] = false);
        let is_even = |&&(corners, t): &&([u32; 3], u32)| is_rotation(triangles[t as usize], corners);
        let even: Vec<_> = same.iter().filter(is_even).collect();
        let odd: Vec<_> = same.iter().filter(|entry| !is_even(entry)).collect();
        let kept = if even.len() > odd.len() { even.first() } else { odd.first() };
        if let Some((_, t)) = kept.filter(|_| even.len() != odd.len()) {
            keep[*t as usize] = true;
        }
    }
    triangles.iter().zip(keep).filter(|(_, keep)| *keep).map(|(t, _)| *t).collect()
}

fn is_rotation([a, b, c]: [u32; 3], other: [u32; 3]) -> bool {
    [[a, b, c], [b, c, a], [c, a, b]].contains(&other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn equal_places_become_one_vertex() {
        let (o, x, y) = (DVec3::ZERO, DVec3::X, DVec3::Y);
        let near = DVec3::new(1e-300, 0.0, 0.0);
        let mesh = TriangleMesh {
            vertices: vec![o, x, y, -o, y, x, near, DVec3::ONE],
            triangles: vec![[0, 1, 2], [0, 3, 1], [0, 6, 1]],
        };
        let welded = weld(&mesh);
        assert_eq!(welded.mesh.vertices, [o, x, y, near], "the unused vertex is gone, the near one stays");
        assert_eq!(welded.mesh.triangles, [[0, 1, 2], [0, 3, 1]]);
        assert_eq!((welded.degenerate, welded.duplicate), (1, 0));
    }

    #[test]
    fn a_triangle_stands_once_and_back_to_back_not_at_all() {
        let check = |triangles: &[[u32; 3]], expected: &[[u32; 3]]| {
            assert_eq!(without_duplicates(triangles), expected, "{triangles:?}");
        };
        check(&[[0, 1, 2], [1, 2, 0]], &[[0, 1, 2]]);
        check(&[[0, 2, 1], [2, 1, 0], [5, 6, 7]], &[[0, 2, 1], [5, 6, 7]]);
        check(&[[0, 1, 2], [0, 2, 1], [5, 6, 7]], &[[5, 6, 7]]);
        check(&[[0, 1, 2], [0, 2, 1], [2, 0, 1]], &[[0, 1, 2]]);
    }
}
