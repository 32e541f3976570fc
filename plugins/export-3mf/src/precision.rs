//! Coordinates as readers of 3MF keep them: in single precision, no two different vertices made equal.
//!
//! lib3mf and the slicers store f32, whose steps are 7.6e-6 mm beyond 64 mm and 1.5e-5 mm beyond 128 mm. Rounding here
//! rather than there means that the file's decimals are read back exactly, and that two vertices that would fall
//! together can be kept apart: the later one moves to the nearest free neighbour, a step or two away.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use std::collections::BTreeSet;

/// A mesh in single precision.
pub struct SingleMesh {
    /// Positions, mm.
    pub vertices: Vec<[f32; 3]>,
    /// Indices of corners, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// A position that can be ordered.
type Bits = [u32; 3];

impl SingleMesh {
    /// Rounds a mesh. Vertices that were equal before stay so.
    pub fn of(mesh: &TriangleMesh) -> SingleMesh {
        let mut vertices: Vec<[f32; 3]> = mesh.vertices.iter().map(|v| round(*v)).collect();
        keep_apart(&mesh.vertices, &mut vertices);
        SingleMesh { vertices, triangles: mesh.triangles.clone() }
    }
}

fn round(v: DVec3) -> [f32; 3] {
    // Adding zero turns −0 into 0.
    v.to_array().map(|x| x as f32 + 0.0)
}

fn bits(v: [f32; 3]) -> Bits {
    v.map(f32::to_bits)
}

fn keep_apart(exact: &[DVec3], rounded: &mut [[f32; 3]]) {
    let mut order: Vec<u32> = (0..rounded.len() as u32).collect();
    order.sort_unstable_by_key(|&v| (bits(rounded[v as usize]), v));
    let groups = order.chunk_by(|&a, &b| rounded[a as usize] == rounded[b as usize]);
    let crowded: Vec<Vec<u32>> = groups.filter(|g| differ(g, exact)).map(<[u32]>::to_vec).collect();
    if crowded.is_empty() {
        return;
    }
    let mut taken: BTreeSet<Bits> = rounded.iter().map(|v| bits(*v)).collect();
    for group in crowded {
        spread(&group, exact, rounded, &mut taken);
    }
}

fn differ(group: &[u32], exact: &[DVec3]) -> bool {
    group.iter().any(|&v| exact[v as usize] != exact[group[0] as usize])
}

/// Gives every vertex of a group that differs from those before it a place of its own.
fn spread(group: &[u32], exact: &[DVec3], rounded: &mut [[f32; 3]], taken: &mut BTreeSet<Bits>) {
    let mut placed: Vec<(DVec3, [f32; 3])> = Vec::new();
    for &v in group {
        let target = exact[v as usize];
        let place = match placed.iter().find(|(other, _)| *other == target) {
            Some((_, place)) => *place,
            None if placed.is_empty() => rounded[v as usize],
            None => nearest_free(target, rounded[v as usize], taken),
        };
        taken.insert(bits(place));
        placed.push((target, place));
        rounded[v as usize] = place;
    }
}

/// The free neighbour of `start` on the grid of single precision that is nearest to `target`.
fn nearest_free(target: DVec3, start: [f32; 3], taken: &BTreeSet<Bits>) -> [f32; 3] {
    let neighbours = (1..).map(|reach| neighbours(start, reach));
    let nearest = |candidates: Vec<[f32; 3]>| {
        let free = candidates.into_iter().filter(|c| !taken.contains(&bits(*c)));
        let distance = |c: &[f32; 3]| DVec3::from_array(c.map(f64::from)).distance_squared(target);
        free.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    neighbours.filter_map(nearest).next().expect("the grid has more places than the mesh has vertices")
}

fn neighbours(start: [f32; 3], reach: i32) -> Vec<[f32; 3]> {
    let steps = || -reach..=reach;
    let place = |i, j, k| [step(start[0], i), step(start[1], j), step(start[2], k)];
    steps().flat_map(|i| steps().flat_map(move |j| steps().map(move |k| place(i, j, k)))).collect()
}

/// A number some steps of single precision away; around zero in steps of a thousandth of a nanometre, which a print and
/// a decimal fraction of sane length can hold.
fn step(x: f32, count: i32) -> f32 {
    const LEAST: f32 = 1e-9;
    let one = if x.abs() < LEAST * 1e6 { LEAST } else { x.abs().next_up() - x.abs() };
    x + count as f32 * one + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(exact: &[[f64; 3]]) -> Vec<[f32; 3]> {
        let vertices: Vec<DVec3> = exact.iter().map(|v| DVec3::from_array(*v)).collect();
        let rounded = SingleMesh::of(&TriangleMesh { vertices, triangles: vec![] }).vertices;
        for (k, v) in exact.iter().enumerate() {
            for (j, other) in exact.iter().enumerate() {
                assert_eq!(
                    v == other,
                    rounded[k] == rounded[j],
                    "{v:?} and {other:?} became {:?}",
                    rounded[k]
                );
            }
            for axis in 0..3 {
                assert!(
                    (f64::from(rounded[k][axis]) - v[axis]).abs() < 5e-5,
                    "{v:?} became {:?}",
                    rounded[k]
                );
            }
        }
        rounded
    }

    #[test]
    fn what_differs_stays_different() {
        check(&[
            [100.0, 1.0, 0.0],
            [100.000_001, 1.0, 0.0],
            [100.0, 1.000_000_01, 0.0],
            [99.999_999, 1.0, 0.0],
        ]);
        check(&[[0.0; 3], [1e-300, 0.0, 0.0], [-1e-300, 0.0, 0.0]]);
        let crowd: Vec<[f64; 3]> = (0..100).map(|k| [150.0 + f64::from(k) * 1e-9, 0.1, -70.0]).collect();
        check(&crowd);
    }

    #[test]
    fn what_was_equal_stays_equal() {
        let rounded = check(&[
            [1.0, 2.0, 3.0],
            [1.0, 2.0, 3.0],
            [100.0, 0.3, 0.0],
            [100.000_001, 0.3, 0.0],
            [100.0, 0.3, 0.0],
        ]);
        assert_eq!(rounded[2], [100.0, 0.3, 0.0]);
        assert_eq!(
            SingleMesh::of(&TriangleMesh { vertices: vec![-DVec3::ZERO], triangles: vec![] }).vertices,
            [[0.0; 3]]
        );
    }
}
