//! Neighbours that agree on what is outside.
//!
//! Triangles are joined over edges that exactly two of them share. A patch that agrees with itself keeps its orientation;
//! one that does not is turned to the side that most of its triangles are on. What encloses what is judged later, by `nesting`.

use crate::edges::{Edges, Use};
use fibar_core::artefact::mesh::TriangleMesh;

/// Turns triangles so that neighbours agree; returns how many were turned.
pub fn orient(mesh: &mut TriangleMesh) -> usize {
    let patches = patches(mesh, &Edges::of(mesh));
    patches.iter().map(|patch| turn_minority(mesh, patch)).sum()
}

/// Triangles joined with each other, each with whether it must turn to agree with the first of its patch.
pub type Patch = Vec<(u32, bool)>;

fn turn_minority(mesh: &mut TriangleMesh, patch: &Patch) -> usize {
    let disagreeing = patch.iter().filter(|(_, turned)| *turned).count();
    let minority = 2 * disagreeing <= patch.len();
    let turned = patch.iter().filter(|(_, turned)| *turned == minority && disagreeing > 0);
    turned.map(|&(t, _)| turn(&mut mesh.triangles[t as usize])).count()
}

/// Swaps what is inside and outside of a triangle.
pub fn turn(triangle: &mut [u32; 3]) {
    triangle.swap(1, 2);
}

/// The patches of a mesh, in the order of their first triangles.
pub fn patches(mesh: &TriangleMesh, edges: &Edges) -> Vec<Patch> {
    let neighbours = neighbours(mesh, edges);
    let mut seen = vec![false; mesh.triangles.len()];
    let mut patches = Vec::new();
    for first in 0..mesh.triangles.len() as u32 {
        if !std::mem::replace(&mut seen[first as usize], true) {
            let mut patch = vec![(first, false)];
            let mut next = 0;
            while let Some(&(triangle, turned)) = patch.get(next) {
                next += 1;
                for (other, disagrees) in neighbours[triangle as usize].into_iter().flatten() {
                    if !std::mem::replace(&mut seen[other as usize], true) {
                        patch.push((other, turned != disagrees));
                    }
                }
            }
            patches.push(patch);
        }
    }
    patches
}

/// For each side of each triangle the one that shares it alone, and whether the two run along it in the same direction.
fn neighbours(mesh: &TriangleMesh, edges: &Edges) -> Vec<[Option<(u32, bool)>; 3]> {
    let mut neighbours = vec![[None; 3]; mesh.triangles.len()];
    for (_, uses) in edges.iter() {
        if let [one, other] = uses {
            let disagree = one.forward == other.forward;
            let mut join = |a: &Use, b: &Use| {
                neighbours[a.half_edge as usize / 3][a.half_edge as usize % 3] =
                    Some((b.half_edge / 3, disagree));
            };
            join(one, other);
            join(other, one);
        }
    }
    neighbours
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::octahedron;

    #[test]
    fn the_minority_is_turned() {
        for mask in 0..256u32 {
            let mut mesh = octahedron(1.0);
            (0..8).filter(|k| mask >> k & 1 == 1).for_each(|k| turn(&mut mesh.triangles[k]));
            let flipped = orient(&mut mesh);
            assert_eq!(flipped as u32, mask.count_ones().min(8 - mask.count_ones()), "mask {mask:b}");
            let inside_out = mask.count_ones() > 4 || (mask.count_ones() == 4 && mask & 1 == 1);
            let mut expected = octahedron(1.0);
            if inside_out {
                expected.triangles.iter_mut().for_each(turn);
            }
            assert_eq!(mesh, expected, "mask {mask:b}");
        }
    }
}
