//! Which triangle lies across each side of each triangle of a closed surface.

use fibar_core::artefact::mesh::TriangleMesh;
use rayon::prelude::*;

/// The neighbours of all triangles.
pub struct Twins(Vec<[u32; 3]>);

impl Twins {
    /// Of a mesh each of whose sides is one of another triangle, run through the other way.
    pub fn of(mesh: &TriangleMesh) -> Twins {
        let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * mesh.triangles.len());
        for (t, triangle) in (0..).zip(&mesh.triangles) {
            sides.extend(sides_of(*triangle).map(|side| (side, t)));
        }
        sides.par_sort_unstable();
        let across = |[a, b]: [u32; 2]| {
            let found = sides.binary_search_by_key(&[b, a], |(side, _)| *side);
            sides[found.expect("a solid's surface is closed")].1
        };
        Twins(mesh.triangles.par_iter().map(|triangle| sides_of(*triangle).map(across)).collect())
    }

    /// The triangle across a side: 0 from the first to the second corner, 1 from there to the third, 2 back.
    pub fn across(&self, triangle: usize, side: usize) -> usize {
        self.0[triangle][side] as usize
    }
}

/// The sides of a triangle, from corner to corner.
pub fn sides_of([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}
