//! Around which corners the triangles lie side by side like the slices of a cake: those do not cross each other (a local form of the
//! test of Volino and Magnenat-Thalmann 1994).

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use rayon::prelude::*;

/// More than the rounding of a product of three differences, relative to what they are at most.
pub const ROUNDING: f64 = 1e-14;

/// For each vertex whether its triangles are certainly one closed fan that is seen from somewhere without folds: projected along some
/// direction they lie around the vertex once, side by side. Then none of them passes through another; strict in spite of rounding.
pub fn even_fans(mesh: &TriangleMesh) -> Vec<bool> {
    let around = Around::of(mesh);
    (0..mesh.vertices.len())
        .into_par_iter()
        .with_min_len(1024)
        .map(|v| is_even(mesh, v, around.vertex(v)))
        .collect()
}

/// The half-edges that start from each vertex.
struct Around {
    starts: Vec<u32>,
    half_edges: Vec<u32>,
}

impl Around {
    fn of(mesh: &TriangleMesh) -> Around {
        let mut starts = vec![0u32; mesh.vertices.len() + 2];
        mesh.triangles.iter().flatten().for_each(|&v| starts[v as usize + 2] += 1);
        (2..starts.len()).for_each(|k| starts[k] += starts[k - 1]);
        let mut half_edges = vec![0; 3 * mesh.triangles.len()];
        for (half_edge, &v) in (0..).zip(mesh.triangles.iter().flatten()) {
            let next = &mut starts[v as usize + 1];
            half_edges[*next as usize] = half_edge;
            *next += 1;
        }
        Around { starts, half_edges }
    }

    fn vertex(&self, v: usize) -> &[u32] {
        &self.half_edges[self.starts[v] as usize..self.starts[v + 1] as usize]
    }
}

/// More triangles around a vertex are not looked at.
const MOST: usize = 16;

/// What a triangle spans at one of its corners.
#[derive(Clone, Copy, Default)]
struct Wedge {
    vertices: [u32; 2],
    sides: [DVec3; 2],
}

fn is_even(mesh: &TriangleMesh, vertex: usize, half_edges: &[u32]) -> bool {
    let mut room = [Wedge::default(); MOST];
    let Some(wedges) = room.get_mut(..half_edges.len()).filter(|wedges| !wedges.is_empty()) else {
        return false;
    };
    for (wedge, &half_edge) in wedges.iter_mut().zip(half_edges) {
        let (triangle, k) = (mesh.triangles[half_edge as usize / 3], half_edge as usize % 3);
        wedge.vertices = [triangle[(k + 1) % 3], triangle[(k + 2) % 3]];
        wedge.sides = wedge.vertices.map(|v| mesh.vertices[v as usize] - mesh.vertices[vertex]);
    }
    let axis =
        wedges.iter().map(|wedge| wedge.sides[0].cross(wedge.sides[1])).fold(DVec3::ZERO, |a, b| a + b);
    is_closed(wedges) && lie_around_once(axis, wedges)
}

/// Whether each wedge ends where exactly one begins.
fn is_closed(wedges: &[Wedge]) -> bool {
    let begin_at = |v: u32| wedges.iter().filter(|wedge| wedge.vertices[0] == v).count();
    wedges.iter().all(|wedge| begin_at(wedge.vertices[1]) == 1)
}

/// Whether all turn the same way about an axis, and only the first of them holds the middle of the first: as they are closed they go
/// around as often as they pass over a direction.
fn lie_around_once(axis: DVec3, wedges: &[Wedge]) -> bool {
    let middle = wedges[0].sides[0] + wedges[0].sides[1];
    let turns = |[from, to]: [DVec3; 2]| sign(axis, from, to);
    let is_passed = |wedge: &Wedge| match [turns([wedge.sides[0], middle]), turns([middle, wedge.sides[1]])] {
        [Some(true), Some(true)] => Some(true),
        [Some(false), _] | [_, Some(false)] => Some(false),
        _ => None,
    };
    wedges.iter().all(|wedge| turns(wedge.sides) == Some(true))
        && is_passed(&wedges[0]) == Some(true)
        && wedges[1..].iter().all(|wedge| is_passed(wedge) == Some(false))
}

/// Whether `axis · (a × b)` is positive; `None` if rounding leaves it open.
fn sign(axis: DVec3, a: DVec3, b: DVec3) -> Option<bool> {
    let volume = axis.dot(a.cross(b));
    let most = axis.abs().max_element() * a.abs().max_element() * b.abs().max_element();
    (volume.abs() > ROUNDING * most + f64::MIN_POSITIVE).then_some(volume > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fan about the origin through points on a ring, which are given by turns and heights.
    #[track_caller]
    fn check(ring: &[(f64, f64)], closed: bool, expected: bool) {
        let point = |&(turn, height): &(f64, f64)| {
            let (sine, cosine) = libm::sincos(std::f64::consts::TAU * turn);
            DVec3::new(cosine, sine, height)
        };
        let vertices: Vec<DVec3> = std::iter::once(DVec3::ZERO).chain(ring.iter().map(point)).collect();
        let count = ring.len() as u32;
        let last = if closed { count } else { count - 1 };
        let triangles = (0..last).map(|k| [0, 1 + k, 1 + (k + 1) % count]).collect();
        assert_eq!(even_fans(&TriangleMesh { vertices, triangles })[0], expected, "{ring:?}");
    }

    #[test]
    fn only_fans_that_go_around_once_are_even() {
        let flat = |turns: &[f64]| turns.iter().map(|&turn| (turn, 0.0)).collect::<Vec<_>>();
        check(&flat(&[0.0, 0.3, 0.6]), true, true);
        check(&flat(&[0.0, 0.3, 0.6]), false, false);
        check(&[(0.0, 0.3), (0.25, -0.3), (0.5, 0.3), (0.75, -0.3)], true, true);
        check(&[(0.0, 9.0), (0.25, 9.0), (0.5, 9.0), (0.75, 9.0)], true, true);
        // Twice around, and a fold: three steps forward, one back.
        check(&flat(&[0.0, 0.3, 0.7, 1.1, 1.4, 1.7]), true, false);
        check(&flat(&[0.0, 0.3, 0.5, 0.4, 0.8]), true, false);
        // Half a turn in one step is in doubt.
        check(&flat(&[0.0, 0.5, 0.75]), true, false);
        check(&flat(&(0..20).map(|k| f64::from(k) / 20.0).collect::<Vec<_>>()), true, false);
    }
}
