//! A mesh ready to be drawn: the glTF frame, single precision, a normal for each vertex.
//!
//! `gltf_from_body`: (x, y, z) mm with +Z up becomes (x, z, −y) · 0.001 m with +Y up.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// Positions and normals in the glTF frame, and triangles that index them.
pub struct ShadedMesh {
    /// Positions, m.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Indices of corners, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl ShadedMesh {
    /// Smooth where neighbouring triangles' normals have a dot product of at least `crease_cosine`, sharp elsewhere.
    pub fn of(mesh: &TriangleMesh, crease_cosine: f64) -> ShadedMesh {
        let faces: Vec<Face> = (0..mesh.triangles.len()).map(|t| Face::of(mesh.corners(t))).collect();
        let fans = Fans::of(mesh);
        let mut shaded = ShadedMesh {
            positions: Vec::with_capacity(mesh.vertices.len()),
            normals: Vec::with_capacity(mesh.vertices.len()),
            triangles: vec![[0; 3]; mesh.triangles.len()],
        };
        for (v, vertex) in mesh.vertices.iter().enumerate() {
            let first = shaded.positions.len();
            for &(t, k) in fans.around(v) {
                let normal = smooth_normal(fans.around(v), &faces, t, crease_cosine);
                shaded.triangles[t as usize][k as usize] = shaded.vertex(first, *vertex, normal);
            }
        }
        shaded
    }

    /// The index of this position and normal, which may already stand among the vertices from `first` on.
    fn vertex(&mut self, first: usize, position: DVec3, normal: [f32; 3]) -> u32 {
        let known = self.normals[first..].iter().position(|n| *n == normal);
        let index = known.map_or(self.normals.len(), |k| first + k);
        if known.is_none() {
            self.positions.push(turned(position * 1e-3));
            self.normals.push(normal);
        }
        index as u32
    }
}

/// A triangle's unit normal and the angles at its corners.
struct Face {
    normal: DVec3,
    angles: [f64; 3],
}

impl Face {
    fn of(corners: [DVec3; 3]) -> Face {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        let angle = |k: usize| {
            let [here, next, last] = [k, (k + 1) % 3, (k + 2) % 3].map(|j| corners[j]);
            let (a, b) = (next - here, last - here);
            libm::atan2(a.cross(b).length(), a.dot(b))
        };
        Face { normal, angles: [angle(0), angle(1), angle(2)] }
    }
}

/// For each vertex the triangles around it, and which of their corners it is.
struct Fans {
    starts: Vec<usize>,
    corners: Vec<(u32, u8)>,
}

impl Fans {
    fn of(mesh: &TriangleMesh) -> Fans {
        let mut starts = vec![0; mesh.vertices.len() + 1];
        for v in mesh.triangles.iter().flatten() {
            starts[*v as usize + 1] += 1;
        }
        for v in 0..mesh.vertices.len() {
            starts[v + 1] += starts[v];
        }
        let mut next = starts.clone();
        let mut corners = vec![(0, 0); mesh.triangles.len() * 3];
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            for (k, v) in triangle.iter().enumerate() {
                corners[next[*v as usize]] = (t as u32, k as u8);
                next[*v as usize] += 1;
            }
        }
        Fans { starts, corners }
    }

    fn around(&self, vertex: usize) -> &[(u32, u8)] {
        &self.corners[self.starts[vertex]..self.starts[vertex + 1]]
    }
}

/// Mean normal, weighted by angle, of the triangles around a vertex that face about the same way as `triangle`.
fn smooth_normal(fan: &[(u32, u8)], faces: &[Face], triangle: u32, crease_cosine: f64) -> [f32; 3] {
    let own = faces[triangle as usize].normal;
    let sum = fan.iter().fold(DVec3::ZERO, |sum, &(t, k)| {
        let face = &faces[t as usize];
        if face.normal.dot(own) >= crease_cosine { sum + face.normal * face.angles[k as usize] } else { sum }
    });
    // A triangle without area has no normal; which one it gets is not to be seen.
    turned(sum.try_normalize().unwrap_or(DVec3::Z))
}

/// +Z up to +Y up.
fn turned(v: DVec3) -> [f32; 3] {
    [v.x, v.z, -v.y].map(|x| x as f32 + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ridge of two triangles that meet at `angle_deg` along the y axis.
    fn ridge(angle_deg: f64) -> TriangleMesh {
        let (sin, cos) = (libm::sin(angle_deg.to_radians()), libm::cos(angle_deg.to_radians()));
        let vertices = vec![DVec3::ZERO, DVec3::Y, DVec3::NEG_X, DVec3::new(cos, 0.0, -sin)];
        TriangleMesh { vertices, triangles: vec![[0, 1, 2], [1, 0, 3]] }
    }

    #[track_caller]
    fn check(angle_deg: f64, vertex_count: usize) {
        let shaded = ShadedMesh::of(&ridge(angle_deg), libm::cos(40f64.to_radians()));
        assert_eq!(shaded.positions.len(), vertex_count);
        let lengths = shaded.normals.iter().map(|n| n.iter().map(|x| x * x).sum::<f32>());
        assert!(lengths.into_iter().all(|square| (square - 1.0).abs() < 1e-6));
    }

    #[test]
    fn edges_are_sharp_beyond_the_crease() {
        check(0.0, 4);
        check(39.0, 4);
        check(41.0, 6);
        check(90.0, 6);
    }

    #[test]
    fn up_is_y_and_millimetres_are_metres() {
        let mesh = TriangleMesh { vertices: vec![DVec3::new(1.0, 2.0, 3.0); 3], triangles: vec![[0, 1, 2]] };
        assert_eq!(ShadedMesh::of(&mesh, 0.5).positions[0], [0.001, 0.003, -0.002]);
    }
}
