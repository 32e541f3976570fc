//! Enclosed volume and area of a surface.

use fibar_core::artefact::mesh::TriangleMesh;

/// Volume enclosed by a closed mesh, mm³; negative when it is inside out.
pub fn signed_volume(mesh: &TriangleMesh) -> f64 {
    signed_volume_of(mesh, 0..mesh.triangles.len() as u32)
}

/// Volume enclosed by some triangles, mm³. For an open set it depends on the origin, here the middle of the mesh's box.
pub fn signed_volume_of(mesh: &TriangleMesh, triangles: impl IntoIterator<Item = u32>) -> f64 {
    let (low, high) = mesh.bounds().unwrap_or_default();
    let middle = (low + high) / 2.0;
    let tetrahedron = |t: u32| {
        let [a, b, c] = mesh.corners(t as usize).map(|corner| corner - middle);
        a.dot(b.cross(c)) / 6.0
    };
    triangles.into_iter().map(tetrahedron).sum()
}

/// Area of some triangles, mm².
pub fn area_of(mesh: &TriangleMesh, triangles: impl IntoIterator<Item = u32>) -> f64 {
    let area = |t: u32| {
        let [a, b, c] = mesh.corners(t as usize);
        (b - a).cross(c - a).length() / 2.0
    };
    triangles.into_iter().map(area).sum()
}
