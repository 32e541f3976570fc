//! Rays against a triangle mesh by a wide BVH: is a segment clear, how far does a ray reach.
//!
//! Rays are traced in f32 (1e-5 mm at 100 mm from the origin); a caller who starts on the surface moves the start off it
//! along the normal by a length of his own choice, there is no hidden epsilon here. A ray through the very edge between two
//! triangles may slip through: sample several where one is not enough. Distances to a surface are in `distance`.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::ray::{Ray, RayHit};
use obvhs::rt_triangle::RtTriangle;
use std::time::Duration;

/// A mesh prepared for rays; shared freely among threads.
pub struct RayScene {
    /// `None` for a mesh without triangles, which nothing hits.
    tree: Option<CwBvh>,
    /// In the tree's own order.
    triangles: Vec<RtTriangle>,
}

impl RayScene {
    /// Prepares a mesh. Both sides of a triangle stop a ray.
    pub fn new(mesh: &TriangleMesh) -> RayScene {
        let corner = |v: u32| mesh.vertices[v as usize].as_vec3a();
        let triangle = |t: &[u32; 3]| RtTriangle::new(corner(t[0]), corner(t[1]), corner(t[2]));
        let given: Vec<RtTriangle> = mesh.triangles.iter().map(triangle).collect();
        if given.is_empty() {
            return RayScene { tree: None, triangles: given };
        }
        let tree = build_cwbvh(&given, BvhBuildParams::medium_build(), &mut Duration::default());
        let triangles = tree.primitive_indices.iter().map(|&i| given[i as usize]).collect();
        RayScene { tree: Some(tree), triangles }
    }

    /// Whether no triangle meets the segment between two points, mm.
    pub fn is_clear(&self, from: DVec3, to: DVec3) -> bool {
        let (arm, length) = (to - from).normalize_and_length();
        let Some(tree) = self.tree.as_ref().filter(|_| length > 0.0) else { return true };
        let ray = ray(from, arm, length);
        tree.ray_traverse_miss(ray, |ray, k| self.triangles[k].intersect(ray))
    }

    /// Distance from a point to the first triangle along a unit vector, mm; `limit` if there is none before.
    pub fn reach(&self, from: DVec3, direction: DVec3, limit: f64) -> f64 {
        let Some(tree) = &self.tree else { return limit };
        let ray = ray(from, direction, limit);
        let mut hit = RayHit::none();
        let found = tree.ray_traverse(ray, &mut hit, |ray, k| self.triangles[k].intersect(ray));
        if found { f64::from(hit.t).min(limit) } else { limit }
    }
}

/// The library's ray. Adding zero turns −0 into +0: with −0 it takes the wrong octant and misses what it should hit.
fn ray(from: DVec3, direction: DVec3, length: f64) -> Ray {
    Ray::new(from.as_vec3a(), direction.as_vec3a() + Vec3A::ZERO, 0.0, length as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewsphere::{Polyhedron, geodesic_directions};

    /// The cube of side 2 around the origin.
    fn cube() -> TriangleMesh {
        let sign = |k: u32, bit: u32| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let vertices = (0..8).map(|k| DVec3::new(sign(k, 0), sign(k, 1), sign(k, 2))).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        TriangleMesh { vertices, triangles }
    }

    #[test]
    fn a_cube_stands_in_the_way() {
        let scene = RayScene::new(&cube());
        let check = |from: [f64; 3], to: [f64; 3], clear: bool| {
            assert_eq!(scene.is_clear(from.into(), to.into()), clear, "{from:?} → {to:?}");
            assert_eq!(scene.is_clear(to.into(), from.into()), clear, "{to:?} → {from:?}");
        };
        check([5.0, 0.1, 0.2], [-5.0, 0.1, 0.2], false);
        check([5.0, 0.1, 0.2], [1.001, 0.1, 0.2], true);
        check([5.0, 0.1, 0.2], [0.999, 0.1, 0.2], false);
        check([5.0, 1.1, 0.2], [-5.0, 1.1, 0.2], true);
        check([0.5, 0.1, 0.2], [-0.5, 0.1, 0.3], true);
        check([0.5, 0.1, 0.2], [0.5, 0.1, 0.2], true);
    }

    #[test]
    fn reach_ends_at_the_first_wall_or_the_limit() {
        let scene = RayScene::new(&cube());
        let check = |from: [f64; 3], limit: f64, expected: f64| {
            let found = scene.reach(from.into(), DVec3::X, limit);
            assert!((found - expected).abs() < 1e-6, "{from:?}: {found}");
        };
        check([0.25, 0.1, 0.2], 9.0, 0.75);
        check([0.25, 0.1, 0.2], 0.5, 0.5);
        check([-4.0, 0.1, 0.2], 9.0, 3.0);
        check([4.0, 0.1, 0.2], 9.0, 9.0);
    }

    #[test]
    fn negative_zeros_in_a_direction_hit_too() {
        let scene = RayScene::new(&cube());
        for axis in [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z] {
            let negative = axis.map(|x| if x == 0.0 { -0.0 } else { x });
            assert_eq!(
                scene.reach(DVec3::new(0.1, 0.2, 0.3) * (1.0 - axis.abs()), negative, 9.0),
                1.0,
                "{axis}"
            );
        }
    }

    #[test]
    fn every_triangle_of_a_sphere_is_found() {
        let mesh = crate::viewsphere::geodesic_mesh(Polyhedron::Icosahedron, 8);
        let scene = RayScene::new(&mesh);
        for direction in geodesic_directions(Polyhedron::PentakisDodecahedron, 5) {
            let reach = scene.reach(DVec3::new(1e-3, 2e-3, 3e-3), direction, 2.0);
            assert!((0.98..1.01).contains(&reach), "{direction}: {reach}");
        }
    }

    #[test]
    fn nothing_blocks_nothing() {
        let scene = RayScene::new(&TriangleMesh::default());
        assert!(scene.is_clear(DVec3::ZERO, DVec3::X));
        assert_eq!(scene.reach(DVec3::ZERO, DVec3::X, 3.0), 3.0);
    }
}
