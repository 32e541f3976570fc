//! Walls and flaps: patches that make an edge odd, and bound nothing.
//!
//! Around an edge of a closed surface inside and outside alternate, so an even number of triangles meets there. Where three or
//! five do, one too many has come in: a wall between two rooms of one object, a flap hanging on it. The smallest patch at
//! such an edge is taken away, until no such edge is left. (Edges of one triangle are holes, and not meant here.)

use crate::edges::Edges;
use crate::orientation::patches;
use crate::volume::area_of;
use fibar_core::artefact::mesh::TriangleMesh;

/// Takes walls and flaps away; returns how many triangles they had.
pub fn remove(mesh: &mut TriangleMesh) -> usize {
    let before = mesh.triangles.len();
    while let Some(patch) = smallest_at_an_odd_edge(mesh) {
        let mut number = 0..;
        mesh.triangles.retain(|_| number.next().is_some_and(|t| patch.binary_search(&t).is_err()));
    }
    before - mesh.triangles.len()
}

/// The triangles, in order, of the smallest patch that meets an edge of three, five, … triangles.
fn smallest_at_an_odd_edge(mesh: &TriangleMesh) -> Option<Vec<u32>> {
    let edges = Edges::of(mesh);
    if !edges.iter().any(|(_, uses)| is_odd(uses.len())) {
        return None;
    }
    let mut patches: Vec<Vec<u32>> =
        patches(mesh, &edges).into_iter().map(|patch| patch.into_iter().map(|(t, _)| t).collect()).collect();
    patches.iter_mut().for_each(|patch| patch.sort_unstable());
    let mut patch_of = vec![0; mesh.triangles.len()];
    for (number, patch) in patches.iter().enumerate() {
        patch.iter().for_each(|&t| patch_of[t as usize] = number);
    }
    let odd = edges.iter().filter(|(_, uses)| is_odd(uses.len()));
    let mut there: Vec<usize> =
        odd.flat_map(|(_, uses)| uses.iter().map(|along| patch_of[along.half_edge as usize / 3])).collect();
    there.sort_unstable();
    there.dedup();
    let area = |&patch: &usize| area_of(mesh, patches[patch].iter().copied());
    let smallest = there.into_iter().min_by(|a, b| area(a).total_cmp(&area(b)));
    smallest.map(|patch| patches.swap_remove(patch))
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
    }
}
