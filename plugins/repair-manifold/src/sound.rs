//! A short way for large meshes that need no repair: it proves that, and then Manifold has nothing to add.
//!
//! Sound means: every edge has two triangles that run along it in opposite directions, every vertex one fan of triangles, all of it is
//! one shell that encloses something, and no triangle passes through another. That is what Manifold asks of a mesh, and more.

use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::crossings::crossings;

/// Smaller meshes take the long way, which costs them little, and come out in Manifold's order.
pub const WORTHWHILE: usize = 200_000;

/// Whether a mesh without two vertices at one place is sound.
pub fn is_sound(mesh: &TriangleMesh) -> bool {
    is_one_surface(mesh) && crossings(mesh).is_empty()
}

/// Whether a mesh is one closed, oriented surface without pinches or folded triangles.
fn is_one_surface(mesh: &TriangleMesh) -> bool {
    twins(mesh).is_some_and(|twins| {
        !has_folded(&twins) && is_connected(&twins) && count_fans(&twins) == mesh.vertices.len()
    })
}

/// The half-edge `3·triangle + k` that runs the other way along the same edge, for each; `None` unless each has exactly one.
fn twins(mesh: &TriangleMesh) -> Option<Vec<u32>> {
    // Half-edges in buckets by the vertex that they start from.
    let mut starts = vec![0u32; mesh.vertices.len() + 1];
    mesh.triangles.iter().flatten().for_each(|&v| starts[v as usize] += 1);
    let mut sum = 0;
    starts.iter_mut().for_each(|start| sum += std::mem::replace(start, sum));
    let mut ends = starts.clone();
    let mut leaving = vec![(0u32, 0u32); 3 * mesh.triangles.len()];
    for (half_edge, [from, to]) in crate::edges::half_edges(mesh).enumerate() {
        let end = &mut ends[from as usize];
        leaving[*end as usize] = (to, half_edge as u32);
        *end += 1;
    }
    let all_from = |v: u32| &leaving[starts[v as usize] as usize..starts[v as usize + 1] as usize];
    let back = |[from, to]: [u32; 2]| {
        let mut found = all_from(to).iter().filter(|(end, _)| *end == from);
        let twice = all_from(from).iter().filter(|(end, _)| *end == to).count() > 1;
        found
            .next()
            .filter(|_| !twice && from != to && found.next().is_none())
            .map(|(_, half_edge)| *half_edge)
    };
    let mut twins = Vec::with_capacity(leaving.len());
    for &[a, b, c] in &mesh.triangles {
        for side in [[a, b], [b, c], [c, a]] {
            twins.push(back(side)?);
        }
    }
    Some(twins)
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

/// How many fans of triangles there are around vertices; a pinched vertex has several.
fn count_fans(twins: &[u32]) -> usize {
    let mut seen = vec![false; twins.len()];
    let mut fans = 0;
    for first in 0..twins.len() as u32 {
        let mut corner = first;
        fans += usize::from(!seen[first as usize]);
        while !std::mem::replace(&mut seen[corner as usize], true) {
            corner = crate::edges::next(twins[corner as usize]);
        }
    }
    fans
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{ball, inverted, moved, octahedron, together};
    use crate::orientation::turn;
    use crate::weld::with_shared_places;

    #[test]
    fn only_one_closed_surface_is_sound() {
        let check = |mesh: &TriangleMesh, expected: bool| {
            assert_eq!(is_one_surface(&with_shared_places(mesh)), expected, "{mesh:?}");
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
        let with = |more: &[[u32; 3]]| broken(&|mesh| mesh.triangles.extend(more));
        check(&with(&[[0, 1, 1]]), false);
        check(&with(&[[0, 0, 0]]), false);
        let [a, b, c] = octahedron(1.0).triangles[0];
        check(&with(&[[b, c, a]]), false);
        check(&with(&[[a, c, b]]), false);
        check(&with(&[[a, b, c], [a, c, b]]), false);
    }
}
