//! Faces become a solid: equal corners are welded, orientation and closedness are checked.
//!
//! The kernel cuts an edge once for both of its faces, so that neighbours agree to the last bit and no tolerance is needed.
//! What stays open is told and passed on: closing it, or refusing it, is `repair-manifold`'s work.

use crate::Shape;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::parts::{Part, Parts};
use fibar_plugin::{Job, StageError};

/// All solids as one mesh; corners are shared within a solid, never between two.
pub fn join(shape: Shape, job: &mut Job) -> Result<(TriangleMesh, Parts), StageError> {
    let (mut whole, mut parts) = (TriangleMesh::default(), Vec::new());
    for solid in shape.solids {
        let name = name(&solid.label, parts.len());
        let mut mesh = solid.mesh.welded();
        let signed_volume = mesh.volume_of(0..mesh.triangles.len());
        if signed_volume < 0.0 {
            job.log("warn", &format!("{name} is inside out; turned round"));
            mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        parts.push(Part {
            label: solid.label,
            colour: solid.colour,
            first_triangle: whole.triangles.len(),
            triangles: mesh.triangles.len(),
            volume_mm3: signed_volume.abs(),
            open_edges: Some(count_open_edges(&mesh, &name, job)),
        });
        append(&mut whole, mesh)?;
    }
    job.metric("source.solids", parts.len() as f64, "1");
    job.metric("source.open_edges", parts.iter().map(|part| part.open_edges.unwrap_or(0) as f64).sum(), "1");
    Ok((whole, Parts::new(parts)))
}

/// How many edges are open; the first is told.
fn count_open_edges(mesh: &TriangleMesh, name: &str, job: &mut Job) -> usize {
    let open = open_edges(mesh);
    if let Some(&(a, b)) = open.first() {
        let place = (mesh.vertices[a as usize] + mesh.vertices[b as usize]) / 2.0;
        let count = open.len();
        job.log(
            "warn",
            &format!("{name} is not watertight: {count} open edges, the first near {place:.2} mm"),
        );
    }
    open.len()
}

fn name(label: &str, number: usize) -> String {
    if label.is_empty() { format!("solid {}", number + 1) } else { format!("solid {} ({label})", number + 1) }
}

/// Directed edges whose opposite does not occur exactly as often, or that occur more than once; sorted.
fn open_edges(mesh: &TriangleMesh) -> Vec<(u32, u32)> {
    let mut edges: Vec<(u32, u32)> =
        mesh.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
    edges.sort_unstable();
    let count = |edge: &(u32, u32)| {
        let first = edges.partition_point(|other| other < edge);
        edges[first..].iter().take_while(|other| *other == edge).count()
    };
    edges.iter().filter(|edge| count(edge) != 1 || count(&(edge.1, edge.0)) != 1).copied().collect()
}

fn append(whole: &mut TriangleMesh, mesh: TriangleMesh) -> Result<(), StageError> {
    let too_many =
        || StageError::input("the shape has more than 4 billion corners").hint("a coarser chord_error_mm");
    let offset = u32::try_from(whole.vertices.len()).map_err(|_| too_many())?;
    u32::try_from(whole.vertices.len() + mesh.vertices.len()).map_err(|_| too_many())?;
    whole.vertices.extend(mesh.vertices);
    whole.triangles.extend(mesh.triangles.into_iter().map(|triangle| triangle.map(|v| v + offset)));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A cube of side 2 around the origin, every triangle with corners of its own.
    fn loose_cube() -> TriangleMesh {
        let corner =
            |k: u32| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)) * 2.0 - 1.0;
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        let vertices: Vec<DVec3> = triangles.flatten().map(corner).collect();
        let triangles = (0..vertices.len() as u32 / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        TriangleMesh { vertices, triangles }
    }

    #[test]
    fn loose_faces_become_a_watertight_solid() {
        let cube = loose_cube().welded();
        assert_eq!((cube.vertices.len(), cube.triangles.len()), (8, 12));
        assert_eq!(cube.volume_of(0..12), 8.0);
        assert_eq!(open_edges(&cube), []);
    }

    #[test]
    fn holes_and_flipped_faces_are_open() {
        let check = |break_it: fn(&mut TriangleMesh), open: usize| {
            let mut cube = loose_cube().welded();
            break_it(&mut cube);
            assert_eq!(open_edges(&cube).len(), open);
        };
        check(|_| {}, 0);
        check(|cube| cube.triangles.truncate(11), 3);
        check(|cube| cube.triangles[5].swap(0, 1), 6);
        check(|cube| cube.triangles.push(cube.triangles[0]), 9);
    }

    #[test]
    fn minus_zero_is_zero_and_slivers_vanish() {
        let vertices =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, -0.0]].map(DVec3::from).to_vec();
        let mesh = TriangleMesh { vertices, triangles: vec![[0, 1, 2], [3, 2, 1], [0, 3, 1]] }.welded();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 1]]);
    }
}
