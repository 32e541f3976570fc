//! Where a line along x goes through a triangle.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::{DVec2, Vec3Swizzles};

/// Where the line through `(y, z)` along +X meets a triangle, and whether it goes in there.
pub fn pierce(mesh: &TriangleMesh, triangle: u32, line: DVec2) -> Option<(f64, bool)> {
    let indices = mesh.triangles[triangle as usize];
    let corners = indices.map(|v| mesh.vertices[v as usize]);
    let side = |k: usize| {
        let (j, l) = ((k + 1) % 3, (k + 2) % 3);
        side_of_edge((indices[j], corners[j].yz()), (indices[l], corners[l].yz()), line)
    };
    let (a, b, c) = (side(0), side(1), side(2));
    if a.is_sign_positive() != b.is_sign_positive() || b.is_sign_positive() != c.is_sign_positive() {
        return None;
    }
    let sum = a + b + c;
    let x = if sum == 0.0 {
        corners[0].x
    } else {
        (a * corners[0].x + b * corners[1].x + c * corners[2].x) / sum
    };
    // Counter-clockwise in (y, z) seen from +X: the outside is towards +X, so the line goes out.
    Some((x, a.is_sign_negative()))
}

/// Twice the area from an edge to a point, positive to its left; computed alike from both ends, with the sign as the only
/// difference, so that the two triangles of an edge never both claim a line or both miss it.
fn side_of_edge(from: (u32, DVec2), to: (u32, DVec2), point: DVec2) -> f64 {
    let (first, second) = if from.0 < to.0 { (from.1, to.1) } else { (to.1, from.1) };
    // Adding zero turns −0 into 0.
    let area = (second - first).perp_dot(point - first) + 0.0;
    if from.0 < to.0 { area } else { -area }
}
