//! Sides by sight: where patches meet at an edge and do not agree on what is outside, rays tell.
//!
//! A ray that leaves the object crosses its surface an odd number of times if it started inside.

use crate::edges::Edges;
use crate::orientation::{Patch, patches, turn};
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use std::collections::BTreeSet;

/// Turns patches at crowded edges where not as many triangles run forward as backward; returns how many triangles.
pub fn turn_by_sight(mesh: &mut TriangleMesh) -> usize {
    let edges = Edges::of(mesh);
    let patches = patches(mesh, &edges);
    let doubtful = doubtful(mesh, &edges, &patches);
    let inside_out = doubtful.into_iter().filter(|&patch| is_inside_out(mesh, &patches[patch]));
    let turned: Vec<u32> = inside_out.flat_map(|patch| patches[patch].iter().map(|(t, _)| *t)).collect();
    turned.iter().for_each(|&t| turn(&mut mesh.triangles[t as usize]));
    turned.len()
}

/// Numbers of the patches at edges that do not add up.
fn doubtful(mesh: &TriangleMesh, edges: &Edges, patches: &[Patch]) -> BTreeSet<usize> {
    let mut patch_of = vec![0; mesh.triangles.len()];
    for (number, patch) in patches.iter().enumerate() {
        patch.iter().for_each(|&(t, _)| patch_of[t as usize] = number);
    }
    let unbalanced = edges.iter().filter(|(_, uses)| {
        let forward = uses.iter().filter(|along| along.forward).count();
        uses.len() > 2 && 2 * forward != uses.len()
    });
    unbalanced.flat_map(|(_, uses)| uses.iter().map(|along| patch_of[along.half_edge as usize / 3])).collect()
}

/// Looks from both sides of the largest triangle of a patch.
fn is_inside_out(mesh: &TriangleMesh, patch: &Patch) -> bool {
    let cross = |t: u32| {
        let [a, b, c] = mesh.corners(t as usize);
        (b - a).cross(c - a)
    };
    let largest = patch
        .iter()
        .map(|(t, _)| *t)
        .max_by(|&a, &b| cross(a).length_squared().total_cmp(&cross(b).length_squared()).then(b.cmp(&a)));
    let largest = largest.expect("a patch has triangles");
    let normal = cross(largest).normalize_or_zero();
    let middle = mesh.corners(largest as usize).iter().sum::<DVec3>() / 3.0;
    let inside = |side: f64| {
        directions(normal * side).filter(|&d| crossings(mesh, middle, d, largest) % 2 == 1).count()
    };
    let majority = |count: usize| 2 * count > DIRECTIONS;
    majority(inside(1.0)) && !majority(inside(-1.0))
}

const DIRECTIONS: usize = 9;

/// Directions around a normal that are parallel to no edge that people draw.
fn directions(normal: DVec3) -> impl Iterator<Item = DVec3> {
    let (right, up) = normal.any_orthonormal_pair();
    (0..DIRECTIONS).map(move |k| {
        let turn = 0.37 + 2.399_963 * k as f64; // the golden angle
        let lean = 0.13 + 0.07 * k as f64;
        normal + lean * (libm::cos(turn) * right + libm::sin(turn) * up)
    })
}

/// How many triangles but one a ray crosses (Möller & Trumbore 1997).
fn crossings(mesh: &TriangleMesh, from: DVec3, direction: DVec3, except: u32) -> usize {
    let hits = |t: &usize| {
        let [a, b, c] = mesh.corners(*t);
        let (p, q) = (b - a, c - a);
        let normal = direction.cross(q);
        let scale = p.dot(normal);
        let arm = from - a;
        let u = arm.dot(normal) / scale;
        let v = direction.dot(arm.cross(p)) / scale;
        let distance = q.dot(arm.cross(p)) / scale;
        u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0
    };
    (0..mesh.triangles.len()).filter(|&t| t as u32 != except).filter(hits).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{block, together};
    use crate::weld::weld;

    /// Two boxes on top of each other, each with a face of its own between them; with the sides of one turned, they are turned back.
    fn check(turned: &[usize]) {
        let mut sound = together(&[block([0.0; 3], [1.0; 3]), block([0.0, 0.0, 1.0], [1.0, 1.0, 2.0])]);
        // The other diagonal, so that the two faces are not the same triangles back to back.
        sound.triangles[10..12].copy_from_slice(&[[4, 5, 6], [5, 7, 6]]);
        let sound = weld(&sound).mesh;
        let mut mesh = sound.clone();
        turned.iter().for_each(|&t| turn(&mut mesh.triangles[t]));
        assert_eq!(turn_by_sight(&mut mesh), turned.len());
        assert_eq!(mesh, sound);
    }

    #[test]
    fn patches_are_turned_back() {
        check(&[]);
        check(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
        check(&[12, 13, 14, 15, 16, 17, 18, 19, 22, 23]);
    }
}
