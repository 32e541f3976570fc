//! A closed surface: distance to it, and on which side a point lies.

use crate::bvh::Bvh;
use crate::contact::{Feature, Triangle, nearest_on_triangle};
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// A closed, outward-oriented mesh, ready for signed distances.
#[derive(Clone, Debug)]
pub struct ClosedSurface {
    bvh: Bvh,
    triangles: Vec<Triangle>,
    corners: Vec<[u32; 3]>,
    vertex_normals: Vec<DVec3>,
    /// One per edge of each triangle: the sum of the unit normals on both its sides.
    edge_normals: Vec<[DVec3; 3]>,
}

impl ClosedSurface {
    /// Prepares a mesh that is closed and oriented outwards.
    pub fn of(mesh: &TriangleMesh) -> ClosedSurface {
        let triangles: Vec<Triangle> = (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect();
        ClosedSurface {
            bvh: Bvh::of(&triangles),
            vertex_normals: vertex_normals(mesh, &triangles),
            edge_normals: edge_normals(mesh, &triangles),
            corners: mesh.triangles.clone(),
            triangles,
        }
    }

    /// The triangles, to be searched.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Distance to the surface, mm, negative outside, by the angle-weighted normal of the nearest feature
    /// (Bærentzen and Aanæs 2005).
    pub fn depth(&self, point: DVec3) -> f64 {
        let hit = self.bvh.nearest_hit(&point, f64::INFINITY);
        let Some(hit) = hit else { return f64::NEG_INFINITY };
        let outwards = point - hit.contact.far;
        let inside = self.normal_at(point, hit.triangle as usize).dot(outwards) < 0.0;
        if inside { hit.contact.distance } else { -hit.contact.distance }
    }

    /// Outward unit normal of the nearest feature; zero for an empty mesh.
    pub fn outward(&self, point: DVec3) -> DVec3 {
        let hit = self.bvh.nearest_hit(&point, f64::INFINITY);
        hit.map_or(DVec3::ZERO, |hit| self.normal_at(point, hit.triangle as usize).normalize_or_zero())
    }

    /// Outward normal of the feature of `triangle` nearest to `point`.
    fn normal_at(&self, point: DVec3, triangle: usize) -> DVec3 {
        let corners = &self.triangles[triangle];
        match nearest_on_triangle(point, corners).1 {
            Feature::Face => face_normal(corners),
            Feature::Edge(k) => self.edge_normals[triangle][k],
            Feature::Corner(k) => self.vertex_normals[self.corners[triangle][k] as usize],
        }
    }
}

fn face_normal([a, b, c]: &Triangle) -> DVec3 {
    (*b - *a).cross(*c - *a).normalize_or_zero()
}

fn vertex_normals(mesh: &TriangleMesh, triangles: &[Triangle]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; mesh.vertices.len()];
    for (corners, triangle) in mesh.triangles.iter().zip(triangles) {
        let normal = face_normal(triangle);
        for k in 0..3 {
            let [here, next, last] = [k, (k + 1) % 3, (k + 2) % 3].map(|j| triangle[j]);
            normals[corners[k] as usize] += normal * crate::bezier::angle_between(next - here, last - here);
        }
    }
    normals
}

fn edge_normals(mesh: &TriangleMesh, triangles: &[Triangle]) -> Vec<[DVec3; 3]> {
    let key = |t: usize, k: usize| {
        let [a, b] = [k, (k + 1) % 3].map(|j| mesh.triangles[t][j]);
        (a.min(b), a.max(b))
    };
    let mut sides: Vec<(usize, usize)> =
        (0..triangles.len()).flat_map(|t| (0..3).map(move |k| (t, k))).collect();
    sides.sort_unstable_by_key(|&(t, k)| (key(t, k), t, k));
    let mut normals = vec![[DVec3::ZERO; 3]; triangles.len()];
    for edge in sides.chunk_by(|&(t, k), &(u, j)| key(t, k) == key(u, j)) {
        let sum: DVec3 = edge.iter().map(|&(t, _)| face_normal(&triangles[t])).sum();
        edge.iter().for_each(|&(t, k)| normals[t][k] = sum);
    }
    normals
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

    /// A tetrahedron with one very sharp edge, where naive signs fail.
    fn blade() -> TriangleMesh {
        let vertices = vec![
            DVec3::new(0.0, 0.0, 0.0),
            DVec3::new(10.0, 0.0, 0.0),
            DVec3::new(5.0, 8.0, 0.05),
            DVec3::new(5.0, 8.0, -0.05),
        ];
        TriangleMesh { vertices, triangles: vec![[0, 1, 2], [1, 0, 3], [1, 3, 2], [0, 2, 3]] }
    }

    #[test]
    fn signs_agree_with_the_planes_of_a_convex_body() {
        let mesh = blade();
        let surface = ClosedSurface::of(&mesh);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut inside_count = 0;
        for _ in 0..4000 {
            let point = DVec3::new(
                rng.random_range(-1.0..11.0),
                rng.random_range(-1.0..9.0),
                rng.random_range(-0.06..0.06),
            );
            let inside = (0..4).all(|t| {
                let corners = mesh.corners(t);
                face_normal(&corners).dot(point - corners[0]) < 0.0
            });
            inside_count += usize::from(inside);
            assert_eq!(surface.depth(point) > 0.0, inside, "{point}");
        }
        assert!(inside_count > 300);
    }
}
