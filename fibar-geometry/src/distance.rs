//! Distance to a closed surface: exact by a tree of boxes, or sampled on a lattice for inner loops.
//!
//! Signed distance is negative inside. The exact queries are parry's, with its pseudo-normals for the sign (Bærentzen &
//! Aanæs, "Signed distance computation using the angle weighted pseudonormal", 2005). Whether the mesh *is* closed is not
//! examined here: `repair-manifold` keeps that promise.

mod grid;
mod lattice;
mod near;

pub use grid::{DistanceGrid, GridOptions};
pub use lattice::Lattice;

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use parry3d_f64::math::Vector;
use parry3d_f64::query::{PointQuery, PointQueryWithLocation};
use parry3d_f64::shape::{TriMesh, TriMeshFlags};

/// Distance of a point to a triangle, mm (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
pub fn distance_to_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let (ab, ac) = (b - a, c - a);
    let along = |corner: DVec3| (ab.dot(point - corner), ac.dot(point - corner));
    let ((a1, a2), (b1, b2), (c1, c2)) = (along(a), along(b), along(c));
    if a1 <= 0.0 && a2 <= 0.0 {
        return point.distance(a);
    }
    if b1 >= 0.0 && b2 <= b1 {
        return point.distance(b);
    }
    if c2 >= 0.0 && c1 <= c2 {
        return point.distance(c);
    }
    let (beyond_a, beyond_b, beyond_c) = (b1 * c2 - c1 * b2, c1 * a2 - a1 * c2, a1 * b2 - b1 * a2);
    if beyond_c <= 0.0 && a1 >= 0.0 && b1 <= 0.0 {
        return point.distance(a + ab * (a1 / (a1 - b1)));
    }
    if beyond_b <= 0.0 && a2 >= 0.0 && c2 <= 0.0 {
        return point.distance(a + ac * (a2 / (a2 - c2)));
    }
    if beyond_a <= 0.0 && b2 - b1 >= 0.0 && c1 - c2 >= 0.0 {
        let (from_b, from_c) = (b2 - b1, c1 - c2);
        return point.distance(b + (c - b) * (from_b / (from_b + from_c)));
    }
    let all = beyond_a + beyond_b + beyond_c;
    point.distance(a + ab * (beyond_b / all) + ac * (beyond_c / all))
}

/// A closed, outward-oriented surface that answers distance queries.
pub struct Surface {
    mesh: TriMesh,
}

/// The point of a surface next to a query point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// On the surface, mm.
    pub point: DVec3,
    /// Distance from the query point, mm; negative when that lies inside.
    pub signed_distance: f64,
}

/// Why a mesh has no distance.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SurfaceError {
    /// Nothing to be distant from.
    #[error("the mesh has no triangle")]
    Empty,
    /// parry refused the mesh.
    #[error("the mesh cannot be searched: {0}")]
    Refused(String),
}

impl Surface {
    /// Builds the search tree.
    pub fn new(mesh: &TriangleMesh) -> Result<Surface, SurfaceError> {
        Surface::with_flags(mesh, TriMeshFlags::ORIENTED)
    }

    /// For distances without a sign, which come positive: quicker to build, and open meshes will do.
    pub fn unsigned(mesh: &TriangleMesh) -> Result<Surface, SurfaceError> {
        Surface::with_flags(mesh, TriMeshFlags::empty())
    }

    fn with_flags(mesh: &TriangleMesh, flags: TriMeshFlags) -> Result<Surface, SurfaceError> {
        if mesh.triangles.is_empty() {
            return Err(SurfaceError::Empty);
        }
        let vertices = mesh.vertices.iter().map(|v| to_parry(*v)).collect();
        TriMesh::with_flags(vertices, mesh.triangles.clone(), flags)
            .map(|mesh| Surface { mesh })
            .map_err(|e| SurfaceError::Refused(e.to_string()))
    }

    /// The closest point of the surface to a finite point.
    pub fn closest(&self, point: DVec3) -> Closest {
        let everywhere = f64::MAX;
        let nothing = Closest { point, signed_distance: f64::NAN };
        self.closest_within(point, everywhere).unwrap_or(nothing)
    }

    /// The same, or `None` when it is further than `reach` mm; the smaller the reach, the faster the answer.
    pub fn closest_within(&self, point: DVec3, reach: f64) -> Option<Closest> {
        let found = self.mesh.project_local_point_with_max_dist(to_parry(point), false, reach)?;
        let on_surface = from_parry(found.point);
        let distance = point.distance(on_surface);
        Some(Closest {
            point: on_surface,
            signed_distance: if found.is_inside { -distance } else { distance },
        })
    }

    /// Distance of the nearest triangle to a finite point, mm, and its number.
    pub fn nearest(&self, point: DVec3) -> (f64, u32) {
        self.nearest_within(point, f64::MAX).unwrap_or((f64::INFINITY, 0))
    }

    /// The same, or `None` when it is further than `reach` mm.
    pub fn nearest_within(&self, point: DVec3, reach: f64) -> Option<(f64, u32)> {
        let found =
            self.mesh.project_local_point_and_get_location_with_max_dist(to_parry(point), false, reach);
        found.map(|(found, (triangle, _))| (point.distance(from_parry(found.point)), triangle))
    }

    /// The nearest point of the surface to a finite point.
    pub fn foot(&self, point: DVec3) -> DVec3 {
        from_parry(self.mesh.project_local_point(to_parry(point), false).point)
    }

    /// How many triangles it has.
    pub fn triangle_count(&self) -> u32 {
        self.mesh.num_triangles() as u32
    }

    /// The corners of a triangle, mm.
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        let triangle = self.mesh.triangle(triangle);
        [triangle.a, triangle.b, triangle.c].map(from_parry)
    }

    /// Distance of a point to one triangle of the surface, mm.
    pub fn distance_to_triangle(&self, point: DVec3, triangle: u32) -> f64 {
        distance_to_triangle(point, self.corners(triangle))
    }

    /// Distance to the surface, mm, negative inside.
    pub fn signed_distance(&self, point: DVec3) -> f64 {
        self.closest(point).signed_distance
    }

    /// Least and greatest coordinates, mm.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let bounds = self.mesh.local_aabb();
        (from_parry(bounds.mins), from_parry(bounds.maxs))
    }
}

/// parry has a glam of its own version.
fn to_parry(v: DVec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn from_parry(v: Vector) -> DVec3 {
    DVec3::new(v.x, v.y, v.z)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The cube from −`half` to `half` mm, closed, outward.
    pub(crate) fn cube(half: f64) -> TriangleMesh {
        let sign = |k: usize, bit: usize| if k >> bit & 1 == 1 { half } else { -half };
        let vertices = (0..8).map(|k| DVec3::new(sign(k, 0), sign(k, 1), sign(k, 2))).collect();
        let quads: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        TriangleMesh { vertices, triangles }
    }

    /// Signed distance to that cube in closed form.
    pub(crate) fn distance_to_cube(half: f64, p: DVec3) -> f64 {
        let q = p.abs() - DVec3::splat(half);
        q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
    }

    #[test]
    fn distance_to_a_cube_is_its_closed_form() {
        let surface = Surface::new(&cube(10.0)).unwrap();
        let check = |x, y, z| {
            let p = DVec3::new(x, y, z);
            let closest = surface.closest(p);
            assert!((closest.signed_distance - distance_to_cube(10.0, p)).abs() < 1e-12, "{p}: {closest:?}");
            assert!((closest.point.distance(p) - closest.signed_distance.abs()).abs() < 1e-12);
            assert!(distance_to_cube(10.0, closest.point).abs() < 1e-12, "{p}: not on the cube");
        };
        check(0.0, 0.0, 0.0); // centre
        check(9.0, 1.0, 2.0); // inside, near a face
        check(9.5, 9.4, 9.3); // inside, near a corner
        check(12.0, 0.3, 0.1); // outside a face
        check(12.0, 13.0, 0.1); // outside an edge
        check(-12.0, 13.0, 14.0); // outside a corner
        check(10.0, 10.0, 10.0); // on a corner
    }

    #[test]
    fn a_reach_bounds_the_answer() {
        let surface = Surface::new(&cube(10.0)).unwrap();
        assert_eq!(surface.closest_within(DVec3::ZERO, 9.9), None);
        assert!(surface.closest_within(DVec3::ZERO, 10.1).is_some());
        assert_eq!(surface.bounds(), (DVec3::splat(-10.0), DVec3::splat(10.0)));
    }

    #[test]
    fn distance_to_a_triangle_is_the_least_of_many() {
        let corners = [DVec3::ZERO, DVec3::new(4.0, 1.0, 0.0), DVec3::new(1.0, 3.0, 0.5)];
        let flat = [DVec3::ZERO, DVec3::X, DVec3::X * 3.0];
        for k in 0..1000 {
            let at = |n: u32| f64::from(k * n % 97) / 97.0 * 8.0 - 3.0;
            let point = DVec3::new(at(31), at(57), at(73));
            for [a, b, c] in [corners, flat] {
                let shares =
                    (0..=60).flat_map(|i| (0..=60 - i).map(move |j| [i, j].map(|n| f64::from(n) / 60.0)));
                let sampled = shares.map(|[u, v]| point.distance(a + (b - a) * u + (c - a) * v));
                let least = sampled.fold(f64::INFINITY, f64::min);
                let found = distance_to_triangle(point, [a, b, c]);
                assert!(found <= least + 1e-12 && found >= least - 0.05, "{point}: {found}, {least}");
            }
        }
    }

    #[test]
    fn no_triangle_no_distance() {
        assert_eq!(Surface::new(&TriangleMesh::default()).err(), Some(SurfaceError::Empty));
    }
}
