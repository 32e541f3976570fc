//! Where a surface passes through itself, with exact predicates (Shewchuk 1997).
//!
//! Two triangles cross if a side of one passes strictly through the inside of the other. Triangles that touch, share corners or lie
//! in one plane do not.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use rayon::prelude::*;
use robust::{Coord3D, orient3d};

/// Two triangles that cross, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Their numbers, the lower first.
    pub triangles: [u32; 2],
    /// A point of the crossing, mm.
    pub place: DVec3,
}

/// All crossings of a mesh, by the triangles' numbers.
pub fn crossings(mesh: &TriangleMesh) -> Vec<Crossing> {
    let boxes: Vec<Aabb> = (0..mesh.triangles.len()).map(|t| loose_box(&mesh.corners(t))).collect();
    if boxes.is_empty() {
        return Vec::new();
    }
    let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
    let with_later = |t: usize| {
        let mut near: Vec<u32> = tree.intersect_aabb(&boxes[t]).filter(|&other| other > t as u32).collect();
        near.sort_unstable();
        let at = |other| crossing_point(mesh, [t, other as usize]);
        let found = near
            .into_iter()
            .filter_map(|other| at(other).map(|place| Crossing { triangles: [t as u32, other], place }));
        found.collect::<Vec<_>>()
    };
    let found: Vec<Vec<Crossing>> = (0..boxes.len()).into_par_iter().map(with_later).collect();
    found.into_iter().flatten().collect()
}

/// A triangle's box, wide enough for the tree's single precision.
fn loose_box(corners: &[DVec3; 3]) -> Aabb {
    const ROUNDING: f64 = 1e-6;
    let low = corners[0].min(corners[1]).min(corners[2]);
    let high = corners[0].max(corners[1]).max(corners[2]);
    let margin = ROUNDING * low.abs().max(high.abs()).max_element();
    Aabb::new((low - margin).to_array().into(), (high + margin).to_array().into())
}

/// Where a side of one passes through the other. A side that starts or ends at a corner of the other only touches it there.
fn crossing_point(mesh: &TriangleMesh, [one, other]: [usize; 2]) -> Option<DVec3> {
    let through = |from: usize, into: usize| {
        let [a, b, c] = mesh.triangles[from];
        let apart = |v: u32| !mesh.triangles[into].contains(&v);
        let sides = [[a, b], [b, c], [c, a]].into_iter().filter(|side| side.iter().all(|&v| apart(v)));
        let mut ends = sides.map(|side| side.map(|v| mesh.vertices[v as usize]));
        ends.find_map(|ends| passes_through(ends, mesh.corners(into)))
    };
    through(one, other).or_else(|| through(other, one))
}

fn passes_through([from, to]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let (above, below) = (volume(a, b, c, from), volume(a, b, c, to));
    if !(above > 0.0 && below < 0.0 || above < 0.0 && below > 0.0) {
        return None;
    }
    let around = [volume(from, to, a, b), volume(from, to, b, c), volume(from, to, c, a)];
    let inside = around.iter().all(|&v| v > 0.0) || around.iter().all(|&v| v < 0.0);
    inside.then(|| from + (to - from) * (above / (above - below)))
}

/// Six times the volume of a tetrahedron, with the right sign.
fn volume(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let coord = |v: DVec3| Coord3D { x: v.x, y: v.y, z: v.z };
    orient3d(coord(a), coord(b), coord(c), coord(d))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{ball, block, moved, octahedron, together};

    fn check(mesh: &TriangleMesh, expected: bool) {
        assert_eq!(!crossings(mesh).is_empty(), expected);
    }

    #[test]
    fn touching_is_not_crossing() {
        check(&TriangleMesh::default(), false);
        check(&ball(10.0, 8), false);
        let cube = |x: f64| block([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
        check(&together(&[cube(0.0), cube(1.0)]), false);
        check(&together(&[octahedron(1.0), moved(octahedron(1.0), [2.0, 0.0, 0.0])]), false);
        check(&together(&[octahedron(1.0), moved(octahedron(1.0), [1.999, 0.0001, 0.0002])]), true);
        check(&together(&[ball(10.0, 8), moved(ball(10.0, 8), [5.0, 3.0, 1.0])]), true);
    }

    #[test]
    fn places_lie_on_both() {
        let mesh = together(&[ball(10.0, 8), moved(ball(10.0, 8), [5.0, 3.0, 1.0])]);
        for crossing in crossings(&mesh) {
            let [one, other] = [DVec3::ZERO, DVec3::new(5.0, 3.0, 1.0)].map(|c| crossing.place.distance(c));
            assert!((9.0..=10.0).contains(&one) && (9.0..=10.0).contains(&other), "{one} {other}");
        }
    }
}
