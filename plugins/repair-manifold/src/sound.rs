//! A short way for meshes that need no repair: it proves that, and then Manifold has nothing to add.
//!
//! Sound means: every edge has two triangles that run along it in opposite directions, every vertex one fan of triangles, all of it is
//! one shell that encloses something, and no triangle passes through another. That is what Manifold asks of a mesh, and more.

use crate::edges::origin;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::crossings::crossings_with;
use fibar_geometry::half_edges::{OPEN, next, twins};

/// Whether a mesh without two vertices at one place is sound.
pub fn is_sound(mesh: &TriangleMesh) -> bool {
    let twins = twins(mesh);
    is_one_surface(mesh, &twins) && crossings_with(mesh, &twins).is_empty()
}

/// Whether a mesh is one closed, oriented surface without pinches or folded triangles.
fn is_one_surface(mesh: &TriangleMesh, twins: &[u32]) -> bool {
    !twins.contains(&OPEN) && !has_folded(twins) && is_connected(twins) && are_single_fans(mesh, twins)
}

/// Whether two triangles stand back to back.
fn has_folded(twins: &[u32]) -> bool {
    twins.chunks_exact(3).any(|t| t[0] / 3 == t[1] / 3 || t[1] / 3 == t[2] / 3)
}

fn is_connected(twins: &[u32]) -> bool {
    let mut seen = vec![false; twins.len() / 3];
    let mut stack: Vec<u32> = seen.first().map(|_| 0).into_iter().collect();
    let mut count = stack.len();
    seen.iter_mut().take(1).for_each(|first| *first = true);
    while let Some(triangle) = stack.pop() {
        for twin in &twins[3 * triangle as usize..3 * triangle as usize + 3] {
            if !std::mem::replace(&mut seen[*twin as usize / 3], true) {
                count += 1;
                stack.push(twin / 3);
            }
        }
    }
    count == seen.len()
}

/// Whether there is one fan of triangles around each vertex, which leads to every neighbour once: a pinched vertex has several fans,
/// and where more than two triangles meet at an edge a fan passes it twice.
fn are_single_fans(mesh: &TriangleMesh, twins: &[u32]) -> bool {
    let mut seen = vec![false; twins.len()];
    let mut reached_by = vec![OPEN; mesh.vertices.len()];
    let mut fans = 0;
    for first in 0..twins.len() as u32 {
        let mut corner = first;
        fans += usize::from(!seen[first as usize]);
        while !std::mem::replace(&mut seen[corner as usize], true) {
            let neighbour = origin(mesh, next(corner)) as usize;
            if std::mem::replace(&mut reached_by[neighbour], first) == first {
                return false;
            }
            corner = next(twins[corner as usize]);
        }
    }
    fans == mesh.vertices.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{ball, block, inverted, moved, octahedron, together};
    use crate::orientation::turn;

    #[test]
    fn only_one_closed_surface_is_sound() {
        let check = |mesh: &TriangleMesh, expected: bool| {
            let mesh = mesh.indexed();
            assert_eq!(is_one_surface(&mesh, &twins(&mesh)), expected, "{mesh:?}");
        };
        check(&ball(10.0, 8), true);
        check(&inverted(octahedron(1.0)), true);
        check(&together(&[octahedron(1.0), moved(octahedron(1.0), [9.0, 0.0, 0.0])]), false);
        check(&together(&[octahedron(1.0), moved(octahedron(1.0), [2.0, 0.0, 0.0])]), false);
        let broken = |break_it: &dyn Fn(&mut TriangleMesh)| {
            let mut mesh = octahedron(1.0);
            break_it(&mut mesh);
            mesh
        };
        check(&broken(&|mesh| mesh.triangles.truncate(7)), false);
        check(&broken(&|mesh| turn(&mut mesh.triangles[3])), false);
        check(&broken(&|mesh| mesh.triangles[3] = mesh.triangles[2]), false);
        // Two boxes that touch along an edge, and along all four edges of a face.
        let cube = |x: f64, y: f64| block([x, y, 0.0], [x + 1.0, y + 1.0, 1.0]);
        check(&together(&[cube(0.0, 0.0), cube(1.0, 1.0)]), false);
        check(&together(&[cube(0.0, 0.0), cube(1.0, 0.0)]), false);
        let with = |more: &[[u32; 3]]| broken(&|mesh| mesh.triangles.extend(more));
        check(&with(&[[0, 1, 1]]), false);
        check(&with(&[[0, 0, 0]]), false);
        let [a, b, c] = octahedron(1.0).triangles[0];
        check(&with(&[[b, c, a]]), false);
        check(&with(&[[a, c, b]]), false);
        check(&with(&[[a, b, c], [a, c, b]]), false);
    }
}
