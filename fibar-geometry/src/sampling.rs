//! Area-weighted points of a surface, with normals: the same spread over a coarse and a fine mesh of one shape.
//!
//! The surface is cut into as many strata of equal area as there are samples. Strata follow a space-filling order of the
//! triangles (Morton order of their centroids), so that neither the order nor the size of triangles matters and samples are
//! spread in space; inside triangles a low-discrepancy sequence places them.

mod normals;

pub use normals::corner_normals;

use fibar_core::artefact::mesh::TriangleMesh;
use glam::{DVec2, DVec3};
use rand::RngExt;

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSample {
    /// Place, mm.
    pub position: DVec3,
    /// Smooth outward unit normal, from [`corner_normals`].
    pub normal: DVec3,
    /// Outward unit normal of the triangle itself, for moving off the surface.
    pub face_normal: DVec3,
    /// The triangle it lies in.
    pub triangle: u32,
}

/// `count` samples of equal area each, in Morton order of their triangles; none of a mesh without area.
///
/// `crease_rad` is the angle between faces beyond which an edge is sharp, see [`corner_normals`].
pub fn sample_surface(
    mesh: &TriangleMesh,
    count: usize,
    crease_rad: f64,
    rng: &mut impl rand::Rng,
) -> Vec<SurfaceSample> {
    let order = morton_order(mesh);
    let cumulated = cumulate_areas(mesh, &order);
    let total = cumulated.last().copied().unwrap_or(0.0);
    if !(total > 0.0 && total.is_finite()) {
        return Vec::new();
    }
    let corners = corner_normals(mesh, crease_rad);
    let offset = DVec2::new(rng.random(), rng.random());
    let sample = |k: usize, jitter: f64| {
        let area = (k as f64 + jitter) / count as f64 * total;
        // Beyond the last by rounding only; a triangle without area is never the first to exceed anything.
        let place = cumulated.partition_point(|&sum| sum <= area).min(order.len() - 1);
        sample_triangle(mesh, &corners, order[place], plastic_point(k, offset))
    };
    (0..count).map(|k| sample(k, rng.random())).collect()
}

/// Area of a mesh, mm².
pub fn surface_area(mesh: &TriangleMesh) -> f64 {
    (0..mesh.triangles.len()).map(|t| face_vector(mesh.corners(t)).length() / 2.0).sum()
}

/// The sample at a point of the unit square, folded onto the triangle.
fn sample_triangle(
    mesh: &TriangleMesh,
    corners: &[[DVec3; 3]],
    triangle: u32,
    square: DVec2,
) -> SurfaceSample {
    let DVec2 { x: u, y: v } = if square.x + square.y > 1.0 { DVec2::ONE - square } else { square };
    let mix = |[a, b, c]: [DVec3; 3]| a * (1.0 - u - v) + b * u + c * v;
    let face_normal = face_vector(mesh.corners(triangle as usize)).normalize_or(DVec3::Z);
    SurfaceSample {
        position: mix(mesh.corners(triangle as usize)),
        normal: mix(corners[triangle as usize]).normalize_or(face_normal),
        face_normal,
        triangle,
    }
}

/// Point `k` of Roberts' R2 sequence (powers of the plastic number), shifted: any run of it is evenly spread.
fn plastic_point(k: usize, offset: DVec2) -> DVec2 {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let step = DVec2::new(1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC));
    let point = offset + step * k as f64;
    point - point.floor()
}

/// Twice the area times the outward normal.
fn face_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Running sum of the triangles' areas in the given order, mm².
fn cumulate_areas(mesh: &TriangleMesh, order: &[u32]) -> Vec<f64> {
    let add = |sum: &mut f64, &t: &u32| {
        *sum += face_vector(mesh.corners(t as usize)).length() / 2.0;
        Some(*sum)
    };
    order.iter().scan(0.0, add).collect()
}

/// Triangles along a Morton curve of 2^21 cells a side through the bounding box.
fn morton_order(mesh: &TriangleMesh) -> Vec<u32> {
    let Some((low, high)) = mesh.bounds() else { return Vec::new() };
    let cells = f64::from((1 << 21) - 1) / (high - low).max_element().max(f64::MIN_POSITIVE);
    let code = |t: &u32| {
        let centroid = mesh.corners(*t as usize).into_iter().sum::<DVec3>() / 3.0;
        let cell = ((centroid - low) * cells).to_array().map(|c| spread_bits(c as u64));
        cell[0] | cell[1] << 1 | cell[2] << 2
    };
    let mut order: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    order.sort_by_cached_key(code);
    order
}

/// Moves bit `k` of a 21-bit number to bit `3 k`.
fn spread_bits(number: u64) -> u64 {
    (0..21).fold(0, |spread, k| spread | (number >> k & 1) << (3 * k))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewsphere::{Polyhedron, geodesic_mesh};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    const CREASE: f64 = 0.7;

    fn sample(mesh: &TriangleMesh, count: usize) -> Vec<SurfaceSample> {
        sample_surface(mesh, count, CREASE, &mut ChaCha8Rng::seed_from_u64(5))
    }

    /// A unit square in the plane z = 0, its left half cut much finer than its right half.
    fn uneven_square(fine: u32) -> TriangleMesh {
        let mut mesh = TriangleMesh::default();
        let mut quad = |x: [f64; 2], y: [f64; 2]| {
            let first = mesh.vertices.len() as u32;
            let corners = [(0, 0), (1, 0), (1, 1), (0, 1)];
            mesh.vertices.extend(corners.map(|(i, j)| DVec3::new(x[i], y[j], 0.0)));
            mesh.triangles.push([first, first + 1, first + 2]);
            mesh.triangles.push([first, first + 2, first + 3]);
        };
        let cell = 0.5 / f64::from(fine);
        for i in 0..fine {
            for j in 0..2 * fine {
                let (x, y) = (f64::from(i) * cell, f64::from(j) * cell);
                quad([x, x + cell], [y, y + cell]);
            }
        }
        quad([0.5, 1.0], [0.0, 1.0]);
        mesh
    }

    #[test]
    fn density_ignores_the_triangulation() {
        for fine in [1, 2, 9, 30] {
            let samples = sample(&uneven_square(fine), 4000);
            for column in 0..8 {
                let inside = |s: &&SurfaceSample| (s.position.x * 8.0) as usize == column;
                let share = samples.iter().filter(inside).count() as f64 / 500.0;
                assert!((share - 1.0).abs() < 0.1, "fine {fine}, column {column}: {share}");
            }
        }
    }

    #[test]
    fn order_of_triangles_does_not_matter() {
        let mesh = geodesic_mesh(Polyhedron::Icosahedron, 6);
        let mut turned = mesh.clone();
        turned.triangles.reverse();
        let places = |m: &TriangleMesh| sample(m, 500).iter().map(|s| s.position).collect::<Vec<_>>();
        assert_eq!(places(&mesh), places(&turned));
    }

    #[test]
    fn samples_lie_in_their_triangles_with_outward_normals() {
        let mesh = geodesic_mesh(Polyhedron::PentakisDodecahedron, 4);
        for s in sample(&mesh, 1000) {
            let corner = mesh.corners(s.triangle as usize)[0];
            assert!((s.position - corner).dot(s.face_normal).abs() < 1e-12);
            assert!(s.normal.dot(s.position.normalize()) > 0.9999, "{s:?}");
        }
    }

    #[test]
    fn no_area_no_samples() {
        let line = TriangleMesh { vertices: vec![DVec3::ZERO, DVec3::X], triangles: vec![[0, 1, 1]] };
        assert_eq!(sample(&line, 10), []);
        assert_eq!(sample(&TriangleMesh::default(), 10), []);
    }
}
