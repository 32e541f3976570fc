//! Smooth normals at the corners of triangles, sharp edges kept.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// A unit normal for every corner of every triangle: the mean of the faces around the vertex, weighted by their angle
/// there (Thürmer and Wüthrich 1998), over the faces within `crease_rad` of the corner's own.
///
/// Angle weights make the normal of a vertex independent of how its surroundings are cut into triangles; taking it from
/// faces alone would print the facets of a coarse mesh into every quantity that depends on direction. The crease keeps
/// the flat faces of a box flat up to their edges. A triangle without area takes its vertices' normals from the others.
pub fn corner_normals(mesh: &TriangleMesh, crease_rad: f64) -> Vec<[DVec3; 3]> {
    let cosine = libm::cos(crease_rad);
    let normals: Vec<DVec3> = (0..mesh.triangles.len()).map(|t| face_normal(mesh.corners(t))).collect();
    let around = corners_of_vertices(mesh);
    let smooth = |triangle: usize, corner: usize| {
        let own = normals[triangle];
        let flat = |other: DVec3| own == DVec3::ZERO || own.dot(other) >= cosine;
        let vertex = mesh.triangles[triangle][corner] as usize;
        let near = around[vertex].iter().filter(|(t, _)| flat(normals[*t as usize]));
        near.map(|&(t, angle)| normals[t as usize] * angle).sum::<DVec3>().normalize_or(own)
    };
    (0..mesh.triangles.len()).map(|t| [0, 1, 2].map(|corner| smooth(t, corner))).collect()
}

/// For every vertex, the triangles that have a corner there and the angle of that corner, rad.
fn corners_of_vertices(mesh: &TriangleMesh) -> Vec<Vec<(u32, f64)>> {
    let mut around = vec![Vec::new(); mesh.vertices.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let places = mesh.corners(t);
        for k in 0..3 {
            let (one, other) = (places[(k + 1) % 3] - places[k], places[(k + 2) % 3] - places[k]);
            let angle = libm::atan2(one.cross(other).length(), one.dot(other));
            around[triangle[k] as usize].push((t as u32, angle));
        }
    }
    around
}

/// Unit normal, zero for a triangle without area.
fn face_normal(corners: [DVec3; 3]) -> DVec3 {
    super::face_vector(corners).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares that share the edge x = 0 and meet there at an angle; the right one cut into a fan at the origin.
    fn folded(angle: f64) -> TriangleMesh {
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let vertices = vec![
            DVec3::ZERO,
            DVec3::Y,
            DVec3::new(-1.0, 0.0, 0.0),
            DVec3::new(-1.0, 1.0, 0.0),
            DVec3::new(cos, 0.0, -sin),
            DVec3::new(cos, 0.1, -sin),
            DVec3::new(cos, 1.0, -sin),
        ];
        TriangleMesh { vertices, triangles: vec![[0, 1, 3], [0, 3, 2], [0, 4, 5], [0, 5, 6], [0, 6, 1]] }
    }

    #[test]
    fn gentle_folds_are_smoothed_evenly_sharp_ones_kept() {
        let check = |angle: f64, tilt: f64| {
            let normal = corner_normals(&folded(angle), 0.7)[0][0];
            let expected = DVec3::new(libm::sin(tilt), 0.0, libm::cos(tilt));
            assert!(normal.distance(expected) < 1e-12, "fold {angle}: {normal}");
        };
        check(0.0, 0.0);
        check(0.4, 0.2);
        check(0.69, 0.345);
        check(0.71, 0.0);
    }
}
