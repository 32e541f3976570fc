//! Convex solids that hold all that lies less than a given depth behind some triangles.
//!
//! Each triangle gets the hull of itself and of what lies behind its corners. That is one point along the normal of each triangle
//! around a corner that is convex or nearly flat; behind any other, a polyhedral ball. Neighbouring hulls overlap, so that rounding leaves no gaps.

use crate::ball::ball_corners;
use crate::miter::unit_normal;
use crate::{Solid, SolidError};
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use rayon::prelude::*;

/// Normals further than this from their mean need a ball: 1/cos 20° is just less than a ball's 1.071.
const SHARP_COSINE: f64 = 0.939_692_620_785_908_4;
/// Sine of the angle by which rounding may lift a neighbour above a face.
const FLAT: f64 = 1e-12;
/// 42 corners, which stand off the true ball by 7 %.
const BALL_FREQUENCY: usize = 2;

/// A solid behind each of some triangles of a closed surface, in their order.
pub fn solids_behind(mesh: &TriangleMesh, triangles: &[usize], depth: f64) -> Result<Vec<Solid>, SolidError> {
    let corners = Corners::new(mesh, triangles, depth)?;
    triangles.par_iter().map(|&triangle| corners.hull_behind(mesh, triangle)).collect()
}

/// What lies behind each vertex of some triangles, as offsets from it.
struct Corners {
    offsets: Vec<Vec<DVec3>>,
}

impl Corners {
    fn new(mesh: &TriangleMesh, some: &[usize], depth: f64) -> Result<Corners, SolidError> {
        let ball: Vec<DVec3> = ball_corners(BALL_FREQUENCY)?.into_iter().map(|v| v * depth).collect();
        let around = triangles_around(mesh, some);
        let offsets = around.iter().zip(&mesh.vertices).map(|(triangles, vertex)| {
            let normals: Vec<DVec3> = triangles.iter().map(|&t| unit_normal(mesh.corners(t))).collect();
            let ring = triangles.iter().flat_map(|&t| mesh.corners(t)).map(|corner| corner - *vertex);
            offsets_behind(&normals, ring, depth, &ball)
        });
        Ok(Corners { offsets: offsets.collect() })
    }

    fn hull_behind(&self, mesh: &TriangleMesh, triangle: usize) -> Result<Solid, SolidError> {
        let mut points = Vec::new();
        for v in mesh.triangles[triangle] {
            let place = mesh.vertices[v as usize];
            points.push(place);
            points.extend(self.offsets[v as usize].iter().map(|offset| place + *offset));
        }
        Solid::hull(&points)
    }
}

/// All triangles around each corner of some; around other vertices, none.
fn triangles_around(mesh: &TriangleMesh, some: &[usize]) -> Vec<Vec<usize>> {
    let mut is_needed = vec![false; mesh.vertices.len()];
    some.iter().flat_map(|&t| mesh.triangles[t]).for_each(|v| is_needed[v as usize] = true);
    let mut around = vec![Vec::new(); mesh.vertices.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        triangle.iter().filter(|v| is_needed[**v as usize]).for_each(|v| around[*v as usize].push(t));
    }
    around
}

/// Offsets whose hull with the origin holds the sector of the ball of radius `depth` behind a corner with these normals,
/// `ring` being the corners around it as seen from it.
///
/// Normals within the angle ψ of their mean span a spherical polygon; its flat hull is at least `r·cos ψ` away, so that
/// points at `r = depth / cos ψ` reach far enough. A convex corner has nothing behind it that is not behind its
/// triangles, so that it needs neither more depth nor a ball.
fn offsets_behind(
    normals: &[DVec3],
    mut ring: impl Iterator<Item = DVec3>,
    depth: f64,
    ball: &[DVec3],
) -> Vec<DVec3> {
    let along = |reach: f64| normals.iter().map(|normal| -*normal * reach).collect();
    let is_sound = normals.iter().all(|normal| *normal != DVec3::ZERO);
    if is_sound
        && ring.all(|corner| normals.iter().all(|normal| normal.dot(corner) <= FLAT * corner.length()))
    {
        return along(depth);
    }
    let mean = normals.iter().sum::<DVec3>().normalize_or_zero();
    let cosine = normals.iter().map(|normal| normal.dot(mean)).fold(1.0, f64::min);
    if is_sound && cosine >= SHARP_COSINE { along(depth / cosine) } else { ball.to_vec() }
}
