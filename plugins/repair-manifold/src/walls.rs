//! Walls and flaps: patches that make an edge odd, and bound nothing.
//!
//! Around an edge of a closed surface inside and outside alternate, so an even number of triangles meets there. Where three or
//! five do, one too many has come in: a wall between two rooms of one object, a flap hanging on it. The smallest patch that
//! meets such an edge once is taken away, until no such edge is left. (Edges of one triangle are holes, and not meant here.) A patch
//! that is a good part of the whole surface stays: what is odd about it is left to the pairing in `sheets`.

use crate::edges::{Edges, Use};
use crate::orientation::patches;
use crate::volume::area_of;
use fibar_core::artefact::mesh::TriangleMesh;

/// A wall is no more than this share of the surface.
const LARGEST: f64 = 0.3;

/// Takes walls and flaps away; returns how many triangles they had.
pub fn remove(mesh: &mut TriangleMesh) -> usize {
    let before = mesh.triangles.len();
    loop {
        let gone = at_odd_edges(mesh);
        if gone.is_empty() {
            return before - mesh.triangles.len();
        }
        let mut gone = gone.into_iter();
        mesh.triangles.retain(|_| !gone.next().expect("one for each triangle"));
    }
}

/// For each triangle whether it goes, the smallest patches first; empty if all stay.
fn at_odd_edges(mesh: &TriangleMesh) -> Vec<bool> {
    let edges = Edges::of(mesh);
    if !edges.iter().any(|(_, uses)| is_odd(uses.len())) {
        return Vec::new();
    }
    let patches = patches(mesh, &edges);
    let mut patch_of = vec![0; mesh.triangles.len()];
    for (number, patch) in patches.iter().enumerate() {
        patch.iter().for_each(|&(t, _)| patch_of[t as usize] = number);
    }
    // Patches by crowded edge, and crowded edges by patch.
    let patch = |along: &Use| patch_of[along.half_edge as usize / 3];
    let crowded = edges.iter().filter(|(_, uses)| uses.len() > 2);
    let mut meetings: Vec<Vec<usize>> = crowded.map(|(_, uses)| uses.iter().map(patch).collect()).collect();
    let mut edges_of = vec![Vec::new(); patches.len()];
    for (edge, there) in meetings.iter().enumerate() {
        there.iter().for_each(|&patch| edges_of[patch].push(edge));
    }
    let areas: Vec<f64> = patches.iter().map(|patch| area_of(mesh, patch.iter().map(|(t, _)| *t))).collect();
    let whole: f64 = areas.iter().sum();
    let mut order: Vec<usize> =
        (0..patches.len()).filter(|&p| !edges_of[p].is_empty() && areas[p] <= LARGEST * whole).collect();
    order.sort_by(|&a, &b| areas[a].total_cmp(&areas[b]).then(a.cmp(&b)));
    let mut gone = vec![false; mesh.triangles.len()];
    for candidate in order {
        let makes_odd = |edge: &&usize| {
            let there = &meetings[**edge];
            is_odd(there.len()) && there.iter().filter(|&&patch| patch == candidate).count() == 1
        };
        if edges_of[candidate].iter().any(|edge| makes_odd(&edge)) {
            patches[candidate].iter().for_each(|&(t, _)| gone[t as usize] = true);
            edges_of[candidate].iter().for_each(|&edge| meetings[edge].retain(|&patch| patch != candidate));
        }
    }
    if gone.contains(&true) { gone } else { Vec::new() }
}

fn is_odd(uses: usize) -> bool {
    uses > 2 && uses % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{block, octahedron, together};
    use crate::sheets::Sheets;
    use crate::volume::signed_volume;
    use crate::weld::weld;
    use glam::DVec3;

    /// So many triangles go, and the rest is closed and encloses this volume.
    fn check(mut mesh: TriangleMesh, removed: usize, volume: f64) {
        assert_eq!(remove(&mut mesh), removed);
        crate::orientation::orient(&mut mesh);
        assert!(Sheets::of(&mesh).is_closed());
        assert!((signed_volume(&mesh) - volume).abs() < 1e-12, "{}", signed_volume(&mesh));
    }

    #[test]
    fn walls_and_flaps_go() {
        check(octahedron(1.0), 0, 4.0 / 3.0);
        let mut walled = together(&[block([0.0; 3], [1.0; 3]), block([1.0, 0.0, 0.0], [2.0, 1.0, 1.0])]);
        walled.triangles.drain(12..14); // the second box's face x = 1
        check(weld(&walled).mesh, 2, 2.0);
        let mut flapped = octahedron(1.0);
        flapped.vertices.push(DVec3::new(2.0, 2.0, 0.1));
        flapped.triangles.push([0, 1, 6]);
        check(flapped, 1, 4.0 / 3.0);
        let sheet = |z: f64| TriangleMesh {
            vertices: vec![DVec3::ZERO, DVec3::X, DVec3::new(0.5, 1.0, z)],
            triangles: vec![[0, 1, 2]],
        };
        let mut book = weld(&together(&[sheet(0.0), sheet(0.1), sheet(-0.1)])).mesh;
        assert_eq!(remove(&mut book), 0, "no page of three is too many");
    }
}
