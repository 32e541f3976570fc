//! Balls as polyhedra that hold the true ball.

use crate::{Solid, SolidError};
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// Corners of a geodesic polyhedron around the ball of radius 1 about the origin: every facet is at distance 1 or more.
///
/// Each edge of an icosahedron is cut into `frequency` parts, so that there are 10·frequency² + 2 corners. They stand
/// off the ball by at most 0.3/frequency²: 7 % for 2, 1.2 % for 5.
pub fn ball_corners(frequency: usize) -> Result<Vec<DVec3>, SolidError> {
    let directions = geodesic_directions(&icosahedron()?, frequency.max(1));
    let polyhedron = Solid::hull(&directions)?.to_mesh()?;
    let inradius =
        (0..polyhedron.triangles.len()).map(|t| facet_distance(&polyhedron, t)).fold(1.0, f64::min);
    Ok(directions.into_iter().map(|direction| direction / inradius).collect())
}

/// Least frequency whose corners stand off a ball of `radius` by at most `chord_error`, mm.
pub fn ball_frequency(radius: f64, chord_error: f64) -> usize {
    (0.3 * radius / chord_error).sqrt().ceil().clamp(1.0, 16.0) as usize
}

fn icosahedron() -> Result<TriangleMesh, SolidError> {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let rectangle = |(a, b): (f64, f64)| {
        let (a, b) = (a, b * golden);
        [DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]
    };
    let corners: Vec<DVec3> = signs.into_iter().flat_map(rectangle).collect();
    Solid::hull(&corners)?.to_mesh()
}

/// Points of a grid on every face, pushed out to the unit sphere; those on shared edges once.
fn geodesic_directions(icosahedron: &TriangleMesh, frequency: usize) -> Vec<DVec3> {
    let mut directions: Vec<DVec3> = Vec::new();
    for face in 0..icosahedron.triangles.len() {
        let [a, b, c] = icosahedron.corners(face);
        for i in 0..=frequency {
            for j in 0..=frequency - i {
                let point = a * i as f64 + b * j as f64 + c * (frequency - i - j) as f64;
                let direction = point.normalize();
                if !directions.iter().any(|known| known.distance_squared(direction) < 1e-12) {
                    directions.push(direction);
                }
            }
        }
    }
    directions
}

fn facet_distance(mesh: &TriangleMesh, triangle: usize) -> f64 {
    let [a, b, c] = mesh.corners(triangle);
    (b - a).cross(c - a).normalize().dot(a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_touch_the_ball_from_outside() {
        let check = |frequency: usize, corners: usize, ratio: f64| {
            let ball = ball_corners(frequency).unwrap();
            assert_eq!(ball.len(), corners);
            let mesh = Solid::hull(&ball).unwrap().to_mesh().unwrap();
            let nearest =
                (0..mesh.triangles.len()).map(|t| facet_distance(&mesh, t)).fold(f64::MAX, f64::min);
            assert!((nearest - 1.0).abs() < 1e-12, "frequency {frequency}: {nearest}");
            let farthest = ball.iter().map(|v| v.length()).fold(0.0, f64::max);
            assert!(farthest < ratio, "frequency {frequency}: {farthest}");
        };
        check(1, 12, 1.26);
        check(2, 42, 1.071);
        check(5, 252, 1.012);
    }

    #[test]
    fn frequency_meets_the_chord_error() {
        for (radius, chord_error) in [(1.0, 0.3), (1.9, 0.02), (1.9, 0.05), (0.9, 0.005)] {
            let ball = ball_corners(ball_frequency(radius, chord_error)).unwrap();
            let standoff = ball.iter().map(|v| v.length() * radius - radius).fold(0.0, f64::max);
            assert!(standoff <= chord_error, "{radius} {chord_error}: {standoff}");
        }
    }
}
