//! Where a surface passes through itself, with exact predicates (Shewchuk 1997).
//!
//! Two triangles cross if a side of one passes strictly through the inside of the other. Triangles that touch, share corners or lie
//! in one plane do not.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use parry3d_f64::bounding_volume::{Aabb, BoundingVolume};
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

/// Triangles that look for others together: neighbours, once they are in the order of the tree.
const TROOP: usize = 8;

/// All crossings of a mesh whose triangles share corners by index, by the triangles' numbers.
pub fn crossings(mesh: &TriangleMesh) -> Vec<Crossing> {
    let boxes: Vec<Aabb> =
        (0..mesh.triangles.len()).into_par_iter().map(|t| loose_box(&mesh.corners(t))).collect();
    if boxes.is_empty() {
        return Vec::new();
    }
    let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
    let order: Vec<u32> = tree.leaves(|_| true).collect();
    let of_troop = |troop: &[u32]| {
        let around = troop.iter().map(|&t| boxes[t as usize]).reduce(|a, b| a.merged(&b)).expect("a troop");
        let near: Vec<u32> = tree.intersect_aabb(&around).collect();
        let later =
            |&t: &u32| near.iter().copied().filter(move |&other| other > t).map(move |other| [t, other]);
        let pairs = troop.iter().flat_map(later);
        let close = pairs.filter(|[t, other]| boxes[*t as usize].intersects(&boxes[*other as usize]));
        let in_doubt = |pair: &[u32; 2]| !are_apart(mesh, pair.map(|t| t as usize));
        close.filter(in_doubt).filter_map(|pair| crossing(mesh, pair)).collect::<Vec<_>>()
    };
    let found: Vec<Vec<Crossing>> = order.par_chunks(TROOP).map(of_troop).collect();
    let mut found: Vec<Crossing> = found.into_iter().flatten().collect();
    found.sort_unstable_by_key(|crossing| crossing.triangles);
    found
}

fn crossing(mesh: &TriangleMesh, triangles: [u32; 2]) -> Option<Crossing> {
    crossing_point(mesh, triangles.map(|t| t as usize)).map(|place| Crossing { triangles, place })
}

/// Whether two triangles certainly do not cross: they share a side, or one lies on one side of the other's plane, where corners
/// that they share lie in it. Strict in spite of rounding.
fn are_apart(mesh: &TriangleMesh, [one, other]: [usize; 2]) -> bool {
    let shared = mesh.triangles[one].iter().filter(|v| mesh.triangles[other].contains(v)).count();
    shared >= 2 || lies_beside(mesh, one, other) || lies_beside(mesh, other, one)
}

fn lies_beside(mesh: &TriangleMesh, one: usize, plane: usize) -> bool {
    /// More than the rounding of a product of three differences, relative to what they are at most.
    const ROUNDING: f64 = 1e-14;
    let [a, b, c] = mesh.corners(plane);
    let (u, v) = (b - a, c - a);
    let normal = u.cross(v);
    let most = u.abs().max_element() * v.abs().max_element();
    let free = mesh.triangles[one].iter().filter(|w| !mesh.triangles[plane].contains(w));
    let mut sides = free.map(|&w| {
        let way = mesh.vertices[w as usize] - a;
        let height = normal.dot(way);
        let doubt = ROUNDING * most * way.abs().max_element();
        if height > doubt {
            1
        } else if height < -doubt {
            -1
        } else {
            0
        }
    });
    let first = sides.next().unwrap_or(0);
    first != 0 && sides.all(|side| side == first)
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

    fn tetrahedron(at: [f64; 3]) -> TriangleMesh {
        let vertices = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|v| v + DVec3::from(at));
        TriangleMesh {
            vertices: vertices.into(),
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        }
    }

    #[test]
    fn touching_is_not_crossing() {
        let check = |at: [f64; 3], expected: bool| {
            let (mut mesh, other) = (tetrahedron([0.0; 3]), tetrahedron(at));
            mesh.vertices.extend(other.vertices);
            mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + 4)));
            let found = crossings(&mesh);
            assert_eq!(!found.is_empty(), expected, "{at:?}");
            assert!(found.iter().all(|crossing| crossing.triangles[0] < 4 && crossing.triangles[1] >= 4));
        };
        check([1.0, 0.0, 0.0], false);
        check([0.0, 0.0, 1.0], false);
        check([0.999, 0.0001, 0.0001], true);
        check([0.2, 0.2, 0.2], true);
        check([1e-300, 0.3, 2.0], false);
        assert!(crossings(&TriangleMesh::default()).is_empty());
    }

    #[test]
    fn what_is_passed_over_does_not_cross() {
        use rand::RngExt;
        use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for round in 0..40 {
            // On a coarse lattice many corners lie in planes of others.
            let step: f64 = if round % 2 == 0 { 1.0 } else { 1e-3 };
            let mut place =
                || DVec3::from([0; 3].map(|_| (rng.random_range(0.0..4.0f64) / step).round() * step));
            let vertices: Vec<DVec3> = (0..60).map(|_| place()).collect();
            let triangles: Vec<[u32; 3]> = (0..80).map(|_| [0; 3].map(|_| rng.random_range(0..60))).collect();
            let mesh = TriangleMesh { vertices, triangles };
            let pairs = (0..80u32).flat_map(|t| (t + 1..80).map(move |other| [t, other]));
            let all: Vec<Crossing> = pairs.filter_map(|pair| crossing(&mesh, pair)).collect();
            assert_eq!(crossings(&mesh), all);
            assert!(all.len() > 20);
        }
    }
}
