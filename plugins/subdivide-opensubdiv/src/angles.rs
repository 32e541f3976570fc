//! Which edges and vertices stay sharp, by angle.
//!
//! An edge is a crease where the normals of its two triangles differ by more than a given angle (Hoppe et al. 1994, §4; DeRose,
//! Kass, Truong 1998). A vertex on exactly two sharp lines (creases, rims, edges of three and more triangles) is a corner where they
//! turn by more than another angle; where three meet, OpenSubdiv holds the vertex anyway, and where one ends it is a dart.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// An edge and the triangles on it.
pub struct Edge {
    /// Its ends, the lower index first.
    pub ends: [u32; 2],
    /// Its triangles, and whether they run along it from its first end to its second.
    pub sides: Vec<(usize, bool)>,
}

/// What stays sharp.
#[derive(Debug, Default, PartialEq)]
pub struct Sharp {
    /// Ends of creases.
    pub creases: Vec<[u32; 2]>,
    /// Vertices that stay where they are.
    pub corners: Vec<u32>,
}

/// All edges, by their ends.
pub fn edges(mesh: &TriangleMesh) -> Vec<Edge> {
    let mut sides: Vec<([u32; 2], usize, bool)> = Vec::with_capacity(mesh.triangles.len() * 3);
    for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        sides.extend([(a, b), (b, c), (c, a)].map(|(from, to)| ([from.min(to), from.max(to)], t, from < to)));
    }
    sides.sort_unstable();
    let edge = |group: &[([u32; 2], usize, bool)]| Edge {
        ends: group[0].0,
        sides: group.iter().map(|&(_, t, along)| (t, along)).collect(),
    };
    sides.chunk_by(|a, b| a.0 == b.0).map(edge).collect()
}

/// Creases and corners of a mesh; angles in rad.
pub fn sharp(mesh: &TriangleMesh, crease: f64, corner: f64) -> Sharp {
    let (mut creases, mut lines) = (Vec::new(), vec![Vec::new(); mesh.vertices.len()]);
    for edge in edges(mesh) {
        let is_crease = matches!(edge.sides[..], [one, other] if bend(mesh, one, other) > crease);
        if is_crease {
            creases.push(edge.ends);
        }
        if is_crease || edge.sides.len() != 2 {
            let [a, b] = edge.ends;
            lines[a as usize].push(b);
            lines[b as usize].push(a);
        }
    }
    let turns = |v: usize, from: u32, to: u32| {
        let [from, here, to] = [from as usize, v, to as usize].map(|k| mesh.vertices[k]);
        angle(here - from, to - here) > corner
    };
    let is_corner = |v: &usize| matches!(lines[*v][..], [from, to] if turns(*v, from, to));
    let corners = (0..mesh.vertices.len()).filter(is_corner).map(|v| v as u32).collect();
    Sharp { creases, corners }
}

/// Angle between the normals of two triangles at an edge, as if they agreed about inside and outside.
fn bend(mesh: &TriangleMesh, (one, along): (usize, bool), (other, also_along): (usize, bool)) -> f64 {
    let normal = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        (b - a).cross(c - a)
    };
    let turned = if along == also_along { -1.0 } else { 1.0 };
    angle(normal(one), normal(other) * turned)
}

/// Angle between two directions, from 0 to π; 0 if one of them is none.
fn angle(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}
