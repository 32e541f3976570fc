//! Where a surface passes through itself, with exact predicates (Shewchuk 1997).
//!
//! Two triangles cross if a side of one passes strictly through the inside of the other. Triangles that touch, share corners or lie
//! in one plane do not.

use crate::company::in_company;
use crate::half_edges::twins;
use crate::overlaps::{LooseBox, overlaps_of_groups};
use crate::patches::patches;
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use robust::{Coord3D, orient3d};

/// Two triangles that cross, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Their numbers, the lower first.
    pub triangles: [u32; 2],
    /// A point of the crossing, mm.
    pub place: DVec3,
}

/// All crossings of a mesh whose triangles share corners by index, by the triangles' numbers.
pub fn crossings(mesh: &TriangleMesh) -> Vec<Crossing> {
    crossings_with(mesh, &twins(mesh))
}

/// The same, of a mesh whose [`twins`] are known.
pub fn crossings_with(mesh: &TriangleMesh, twins: &[u32]) -> Vec<Crossing> {
    crossings_between(mesh, &patches(mesh, twins))
}

/// Crossings of triangles of different groups, or of none ([`LOOSE`](crate::overlaps::LOOSE)). Groups are numbered from 0.
pub fn crossings_between(mesh: &TriangleMesh, groups: &[u32]) -> Vec<Crossing> {
    let mut found = near_pairs(mesh, groups, |pair| {
        if are_apart(mesh, pair.map(|t| t as usize)) { None } else { crossing(mesh, pair) }
    });
    found.sort_unstable_by_key(|crossing| crossing.triangles);
    found
}

/// Pairs of triangles of different groups that no plane of either keeps apart: all that touch are among them. In order.
pub fn contacts(mesh: &TriangleMesh, groups: &[u32]) -> Vec<[u32; 2]> {
    let is_beside = |plane: u32, other: u32| {
        let [a, b, c] = mesh.corners(plane as usize);
        let heights = mesh.corners(other as usize).map(|point| volume(a, b, c, point));
        heights.iter().all(|&height| height > 0.0) || heights.iter().all(|&height| height < 0.0)
    };
    let touch = |[one, other]: [u32; 2]| !is_beside(one, other) && !is_beside(other, one);
    let mut found = near_pairs(mesh, groups, |pair| touch(pair).then_some(pair));
    found.sort_unstable();
    found
}

/// Calls `visit` with any two triangles that are of different groups, or of none, and whose boxes meet; the lower number first.
fn near_pairs<T: Send>(
    mesh: &TriangleMesh,
    groups: &[u32],
    visit: impl Fn([u32; 2]) -> Option<T> + Sync,
) -> Vec<T> {
    let near = in_company(mesh, groups);
    let boxes: Vec<LooseBox> = near.iter().map(|&t| LooseBox::around(mesh.corners(t as usize))).collect();
    let groups: Vec<u32> = near.iter().map(|&t| groups[t as usize]).collect();
    overlaps_of_groups(&boxes, &groups, |pair| {
        let [one, other] = pair.map(|k| near[k as usize]);
        visit([one.min(other), one.max(other)])
    })
}

fn crossing(mesh: &TriangleMesh, triangles: [u32; 2]) -> Option<Crossing> {
    crossing_point(mesh, triangles.map(|t| t as usize)).map(|place| Crossing { triangles, place })
}

/// More than the rounding of a product of three differences, relative to what they are at most.
const ROUNDING: f64 = 1e-14;

/// Whether two triangles certainly do not cross: they share a side, or a plane parts them: an upright one along a side, or that of
/// either, where corners that they share lie in it. Strict in spite of rounding.
fn are_apart(mesh: &TriangleMesh, [one, other]: [usize; 2]) -> bool {
    let [a, b] = [one, other].map(|t| mesh.triangles[t]);
    let is_shared = |v: u32| (v == b[0]) | (v == b[1]) | (v == b[2]);
    match a.into_iter().filter(|&v| is_shared(v)).count() {
        0 if is_parted_beside(mesh, [one, other]) => return true,
        0 | 1 => {}
        _ => return true,
    }
    lies_beside(mesh, one, other) || lies_beside(mesh, other, one)
}

/// Whether a plane that is upright on one of two triangles, along a side of it, parts them.
fn is_parted_beside(mesh: &TriangleMesh, [one, other]: [usize; 2]) -> bool {
    let [ours, theirs] = [one, other].map(|t| mesh.corners(t));
    let [a, b, c] = ours;
    let normal = (b - a).cross(c - a);
    [[a, b], [b, c], [c, a]].into_iter().any(|[from, to]| {
        let inward = normal.cross(to - from);
        let heights = |corners: [DVec3; 3]| corners.map(|corner| inward.dot(corner - from));
        let far = |corners: [DVec3; 3]| {
            corners.iter().fold(DVec3::ZERO, |far, &corner| far.max((corner - from).abs())).max_element()
        };
        let doubt = ROUNDING * inward.abs().max_element() * far(ours).max(far(theirs)) + f64::MIN_POSITIVE;
        let lowest = heights(ours).into_iter().fold(f64::INFINITY, f64::min);
        let highest = heights(theirs).into_iter().fold(f64::NEG_INFINITY, f64::max);
        lowest - highest > 2.0 * doubt
    })
}

fn lies_beside(mesh: &TriangleMesh, one: usize, plane: usize) -> bool {
    let [a, b, c] = mesh.corners(plane);
    let (u, v) = (b - a, c - a);
    let normal = u.cross(v);
    let most = u.abs().max_element() * v.abs().max_element();
    let free = mesh.triangles[one].iter().filter(|w| !mesh.triangles[plane].contains(w));
    let mut sides = free.map(|&w| {
        let way = mesh.vertices[w as usize] - a;
        let height = normal.dot(way);
        let doubt = ROUNDING * most * way.abs().max_element() + f64::MIN_POSITIVE;
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

    #[test]
    fn crumpled_sheets_cross_where_every_pair_says_so() {
        use rand::RngExt;
        use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
        const COUNT: u32 = 24;
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for noise in [0.1, 0.4, 0.6, 0.8] {
            let mut place = |v: u32| {
                let (x, y) = (f64::from(v % (COUNT + 1)), f64::from(v / (COUNT + 1)));
                // Rolled up, one and a half times around.
                let (sine, cosine) = libm::sincos(0.4 * x);
                let shake = DVec3::from([0; 3].map(|_| rng.random_range(-noise..noise)));
                DVec3::new((4.0 + 0.02 * x) * cosine, (4.0 + 0.02 * x) * sine, y) + shake
            };
            let vertices: Vec<DVec3> = (0..(COUNT + 1) * (COUNT + 1)).map(&mut place).collect();
            let cells = (0..COUNT * COUNT).map(|c| c % COUNT + c / COUNT * (COUNT + 1));
            let triangles =
                cells.flat_map(|v| [[v, v + 1, v + COUNT + 2], [v, v + COUNT + 2, v + COUNT + 1]]);
            let mesh = TriangleMesh { vertices, triangles: triangles.collect() };
            let count = mesh.triangles.len() as u32;
            let pairs = (0..count).flat_map(|t| (t + 1..count).map(move |other| [t, other]));
            let all: Vec<Crossing> = pairs.filter_map(|pair| crossing(&mesh, pair)).collect();
            assert_eq!(all.is_empty(), noise < 0.2);
            assert_eq!(crossings(&mesh), all, "{noise}");
        }
    }
}
