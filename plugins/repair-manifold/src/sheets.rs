//! Sheets: a mesh whose every half-edge has at most one twin, and whose every vertex is met by one fan of triangles.
//!
//! Where more than two triangles meet at an edge they are paired around it, each with the one on the other side of the solid wedge
//! between them (Guéziec et al. 2001, "Cutting and stitching"): bodies that touch along an edge come apart there. A vertex where
//! several fans meet becomes several vertices at the same place. No place changes.

use crate::edges::{Edges, Use, origin};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::half_edges::{OPEN, next};
use glam::DVec3;

/// A mesh in sheets.
pub struct Sheets {
    /// Each vertex belongs to one fan.
    pub mesh: TriangleMesh,
    /// The half-edge that runs the other way along the same edge, by half-edge; [`OPEN`] where there is none.
    pub twins: Vec<u32>,
}

impl Sheets {
    /// Cuts a mesh into sheets.
    pub fn of(mesh: &TriangleMesh) -> Sheets {
        let mut twins = vec![OPEN; 3 * mesh.triangles.len()];
        for ([lower, upper], uses) in Edges::of(mesh).iter() {
            for (one, other) in pair(mesh, [lower, upper], uses) {
                twins[one as usize] = other;
                twins[other as usize] = one;
            }
        }
        Sheets { mesh: split_fans(mesh, &twins), twins }
    }

    /// Whether nothing is open.
    pub fn is_closed(&self) -> bool {
        !self.twins.contains(&OPEN)
    }

    /// Triangles connected over twins, in the order of their first triangles.
    pub fn shells(&self) -> Vec<Vec<u32>> {
        let mut seen = vec![false; self.mesh.triangles.len()];
        let mut shells = Vec::new();
        for first in 0..seen.len() as u32 {
            if !std::mem::replace(&mut seen[first as usize], true) {
                let mut shell = vec![first];
                let mut k = 0;
                while let Some(&triangle) = shell.get(k) {
                    k += 1;
                    for twin in (0..3).map(|side| self.twins[(3 * triangle + side) as usize]) {
                        if twin != OPEN && !std::mem::replace(&mut seen[twin as usize / 3], true) {
                            shell.push(twin / 3);
                        }
                    }
                }
                shells.push(shell);
            }
        }
        shells
    }
}

/// For each of so many triangles the number of the shell that it belongs to.
pub fn shell_of_each(shells: &[Vec<u32>], triangles: usize) -> Vec<u32> {
    let mut numbers = vec![0; triangles];
    for (number, shell) in (0..).zip(shells) {
        shell.iter().for_each(|&t| numbers[t as usize] = number);
    }
    numbers
}

/// Twins among the half-edges along one edge.
fn pair(mesh: &TriangleMesh, ends: [u32; 2], uses: &[Use]) -> Vec<(u32, u32)> {
    match uses {
        [one, other] if one.forward != other.forward => vec![(one.half_edge, other.half_edge)],
        [] | [_] | [_, _] => Vec::new(),
        crowd => pair_around(&around(mesh, ends, crowd)),
    }
}

/// The uses of an edge in the order of their triangles around it, counter-clockwise seen from its upper end.
fn around(mesh: &TriangleMesh, [lower, upper]: [u32; 2], uses: &[Use]) -> Vec<Use> {
    let place = |v: u32| mesh.vertices[v as usize];
    let axis = (place(upper) - place(lower)).normalize_or_zero();
    let right = axis.any_orthonormal_vector();
    let up = axis.cross(right);
    let angle = |along: &Use| {
        let tip: DVec3 = place(origin(mesh, next(next(along.half_edge)))) - place(lower);
        libm::atan2(tip.dot(up), tip.dot(right))
    };
    let mut sorted: Vec<(f64, Use)> = uses.iter().map(|along| (angle(along), *along)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    sorted.into_iter().map(|(_, along)| along).collect()
}

/// Matches like brackets, around the circle. A triangle that runs forward along the edge has the solid on its clockwise side, one
/// that runs backward on its counter-clockwise side: backward opens a wedge of solid, forward closes it.
fn pair_around(circle: &[Use]) -> Vec<(u32, u32)> {
    let (mut open, mut pairs): (Vec<u32>, Vec<(u32, u32)>) = (Vec::new(), Vec::new());
    let mut closed = vec![false; circle.len()];
    // Twice around, so that a wedge may reach over the start.
    for k in 0..2 * circle.len() {
        let (second, along) = (k >= circle.len(), circle[k % circle.len()]);
        match along.forward {
            false if !second => open.push(along.half_edge),
            true if !closed[k % circle.len()] => {
                if let Some(start) = open.pop() {
                    closed[k % circle.len()] = true;
                    pairs.push((start, along.half_edge));
                }
            }
            _ => {}
        }
    }
    pairs
}

/// Gives every fan of triangles a vertex of its own.
fn split_fans(mesh: &TriangleMesh, twins: &[u32]) -> TriangleMesh {
    let mut vertices = Vec::with_capacity(mesh.vertices.len());
    let mut numbers = vec![u32::MAX; twins.len()];
    for corner in 0..twins.len() as u32 {
        if numbers[corner as usize] == u32::MAX {
            let number = vertices.len() as u32;
            vertices.push(mesh.vertices[origin(mesh, corner) as usize]);
            mark_fan(corner, twins, |corner| {
                std::mem::replace(&mut numbers[corner as usize], number) == u32::MAX
            });
        }
    }
    let triangles = numbers.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    TriangleMesh { vertices, triangles }
}

/// Visits the corners of a fan, first one way around its vertex, then, if that ended at a rim, the other.
fn mark_fan(corner: u32, twins: &[u32], mut mark: impl FnMut(u32) -> bool) {
    let mut at = corner;
    while mark(at) {
        match twins[next(next(at)) as usize] {
            OPEN => break,
            twin => at = twin,
        }
    }
    let mut at = corner;
    loop {
        match twins[at as usize] {
            OPEN => break,
            twin => at = next(twin),
        }
        if !mark(at) {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{block, octahedron, together};
    use crate::weld::weld;

    /// Number of vertices, shells and open half-edges.
    fn check(mesh: &TriangleMesh, expected: [usize; 3]) {
        let sheets = Sheets::of(mesh);
        let open = sheets.twins.iter().filter(|&&twin| twin == OPEN).count();
        assert_eq!([sheets.mesh.vertices.len(), sheets.shells().len(), open], expected);
        for (half_edge, &twin) in sheets.twins.iter().enumerate().filter(|(_, twin)| **twin != OPEN) {
            let half_edge = half_edge as u32;
            assert_eq!(origin(&sheets.mesh, half_edge), origin(&sheets.mesh, next(twin)));
        }
    }

    #[test]
    fn bodies_that_touch_come_apart() {
        let cube = |x: f64, y: f64, z: f64| block([x, y, z], [x + 1.0, y + 1.0, z + 1.0]);
        check(&octahedron(1.0), [6, 1, 0]);
        let at_an_edge = weld(&together(&[cube(0.0, 0.0, 0.0), cube(1.0, 1.0, 0.0)])).mesh;
        assert_eq!(at_an_edge.vertices.len(), 14);
        check(&at_an_edge, [16, 2, 0]);
        let at_a_corner = weld(&together(&[cube(0.0, 0.0, 0.0), cube(1.0, 1.0, 1.0)])).mesh;
        assert_eq!(at_a_corner.vertices.len(), 15);
        check(&at_a_corner, [16, 2, 0]);
    }

    #[test]
    fn rims_stay_open() {
        let mut mesh = octahedron(1.0);
        mesh.triangles.remove(3);
        check(&mesh, [6, 1, 3]);
        let mut bow_tie = octahedron(1.0);
        bow_tie.triangles.retain(|t| *t != [0, 1, 2] && *t != [3, 4, 2]);
        check(&bow_tie, [7, 1, 6]);
    }
}
