//! Distance of places from a surface.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;

/// Greatest distance of places from a surface, mm; infinite if there is no surface.
pub fn farthest(places: impl Iterator<Item = DVec3>, surface: &TriangleMesh) -> f64 {
    let vertices = surface.vertices.iter().map(|v| Vector::new(v.x, v.y, v.z)).collect();
    let Ok(surface) = TriMesh::new(vertices, surface.triangles.clone()) else { return f64::INFINITY };
    let distance =
        |place: DVec3| surface.distance_to_local_point(Vector::new(place.x, place.y, place.z), false);
    places.map(distance).fold(0.0, f64::max)
}
