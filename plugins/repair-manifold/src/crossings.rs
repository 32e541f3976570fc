//! Where a surface passes through itself, with exact predicates (Shewchuk 1997).
//!
//! Two triangles cross if a side of one passes strictly through the inside of the other. Triangles that touch, share corners or lie
//! in one plane do not.

use crate::pairs::near_pairs;
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
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
    let pairs = near_pairs(mesh);
    let found = pairs.par_iter().filter_map(|&triangles| {
        let place = crossing_point(mesh, triangles.map(|t| t as usize))?;
        Some(Crossing { triangles, place })
    });
    let mut found: Vec<Crossing> = found.collect();
    found.sort_unstable_by_key(|crossing| crossing.triangles);
    found
}

/// False if the plane of one of two triangles has the other strictly on one side.
pub fn may_touch(mesh: &TriangleMesh, [one, other]: [u32; 2]) -> bool {
    let [first, second] = [one, other].map(|t| mesh.corners(t as usize));
    let is_beside = |[a, b, c]: [DVec3; 3], points: [DVec3; 3]| {
        let heights = points.map(|point| volume(a, b, c, point));
        heights.iter().all(|&height| height > 0.0) || heights.iter().all(|&height| height < 0.0)
    };
    !is_beside(first, second) && !is_beside(second, first)
}

/// Where a side of one passes through the other. A side that starts or ends at a corner of the other only touches it there.
fn crossing_point(mesh: &TriangleMesh, [one, other]: [usize; 2]) -> Option<DVec3> {
    let [first, second] = [mesh.triangles[one], mesh.triangles[other]];
    let through = |from: [u32; 3], into: [u32; 3]| {
        let [a, b, c] = from;
        let apart = from.map(|v| !into.contains(&v));
        let sides =
            [([a, b], apart[0] && apart[1]), ([b, c], apart[1] && apart[2]), ([c, a], apart[2] && apart[0])];
        let place = |v: u32| mesh.vertices[v as usize];
        let mut apart = sides.into_iter().filter(|(_, apart)| *apart);
        apart.find_map(|(ends, _)| passes_through(ends.map(place), into.map(place)))
    };
    through(first, second).or_else(|| through(second, first))
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
