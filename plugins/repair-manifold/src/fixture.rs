//! Small sound meshes that tests break.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// Eight faces around the origin; corners at `size` on the axes. Volume 4/3 · size³.
pub fn octahedron(size: f64) -> TriangleMesh {
    let vertices = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    let triangles =
        vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    TriangleMesh { vertices: vertices.map(|v| v * size).to_vec(), triangles }
}

/// A box between two corners, two triangles a face.
pub fn block(low: [f64; 3], high: [f64; 3]) -> TriangleMesh {
    let corner = |k: usize| DVec3::from_array(std::array::from_fn(|axis| [low, high][k >> axis & 1][axis]));
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh { vertices: (0..8).map(corner).collect(), triangles }
}

/// A ball around the origin: a cube's grid blown up; `steps` cells along an edge.
pub fn ball(radius: f64, steps: u32) -> TriangleMesh {
    let at = |k: u32| (2.0 * f64::from(k) - f64::from(steps)) / f64::from(steps);
    let mut soup = TriangleMesh::default();
    for (normal, right) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().zip([DVec3::Y, DVec3::Z, DVec3::X]) {
        for side in [1.0, -1.0] {
            for (i, j) in (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
                let up = normal.cross(right) * side;
                let place = |i, j| (normal * side + right * at(i) + up * at(j)).normalize() * radius;
                let first = soup.vertices.len() as u32;
                soup.vertices.extend([place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)]);
                soup.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|v| v + first)));
            }
        }
    }
    crate::weld::weld(&soup).mesh
}

/// Several meshes as one, sharing no vertex.
pub fn together(meshes: &[TriangleMesh]) -> TriangleMesh {
    let mut all = TriangleMesh::default();
    for mesh in meshes {
        let first = all.vertices.len() as u32;
        all.vertices.extend(&mesh.vertices);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    all
}

/// The same mesh moved, mm.
pub fn moved(mut mesh: TriangleMesh, by: [f64; 3]) -> TriangleMesh {
    mesh.vertices.iter_mut().for_each(|v| *v += DVec3::from(by));
    mesh
}

/// The same mesh inside out.
pub fn inverted(mut mesh: TriangleMesh) -> TriangleMesh {
    mesh.triangles.iter_mut().for_each(crate::orientation::turn);
    mesh
}
