//! Which triangles are nearer to a surface than they may be.

use crate::miter::unit_normal;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::distance::distance_to_triangle;
use fibar_geometry::overlaps::{LooseBox, overlaps};
use fibar_geometry::segments::approach;
use glam::DVec3;

/// The numbers, ascending, of the triangles that are nearer than `least` mm to a triangle of the surface, among those pairs (of the
/// surface, of the triangles) that count. None may pass through the surface.
pub fn nearer(
    surface: &TriangleMesh,
    triangles: &[[DVec3; 3]],
    least: f64,
    counts: impl Fn(usize, usize) -> bool + Sync,
) -> Vec<usize> {
    let count = surface.triangles.len();
    let ours = (0..count).map(|t| LooseBox::around(surface.corners(t)));
    let theirs = triangles.iter().map(|&[a, b, c]| {
        let (low, high) = (a.min(b).min(c) - least, a.max(b).max(c) + least);
        LooseBox::around([low, high, low])
    });
    let boxes: Vec<LooseBox> = ours.chain(theirs).collect();
    let mut near = overlaps(&boxes, |[one, other]| {
        let [outer, within] = [one.min(other) as usize, one.max(other) as usize];
        if outer >= count || within < count || !counts(outer, within - count) {
            return None;
        }
        is_nearer(surface.corners(outer), triangles[within - count], least).then(|| within - count)
    });
    near.sort_unstable();
    near.dedup();
    near
}

/// Whether two triangles that do not cross are nearer to each other than that.
fn is_nearer(one: [DVec3; 3], other: [DVec3; 3], least: f64) -> bool {
    if is_parted(one, other, least) || is_parted(other, one, least) {
        return false;
    }
    let sides = |[a, b, c]: [DVec3; 3]| [[a, b], [b, c], [c, a]];
    let (ours, theirs) = (sides(one), sides(other));
    one.iter().any(|&corner| distance_to_triangle(corner, other) < least)
        || other.iter().any(|&corner| distance_to_triangle(corner, one) < least)
        || ours.iter().any(|&p| theirs.iter().any(|&q| approach(p, q).arm.length() < least))
}

/// Whether the second lies beyond `least` on one side of the plane of the first.
fn is_parted(plane: [DVec3; 3], other: [DVec3; 3], least: f64) -> bool {
    let normal = unit_normal(plane);
    let heights = other.map(|corner| normal.dot(corner - plane[0]));
    heights.iter().all(|&h| h >= least) || heights.iter().all(|&h| h <= -least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_of_two_triangles() {
        let flat = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
        let surface = TriangleMesh { vertices: flat.into(), triangles: vec![[0, 1, 2]] };
        let check = |other: [[f64; 3]; 3], distance: f64| {
            let other = other.map(DVec3::from);
            let found = |least: f64| nearer(&surface, &[other], least, |_, _| true);
            assert_eq!(found(distance * (1.0 - 1e-12)), [] as [usize; 0], "{other:?}");
            assert_eq!(found(distance * (1.0 + 1e-12)), [0], "{other:?}");
        };
        check([[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, 4.0, 1.0]], 1.0);
        check([[1.0, 1.0, 0.5], [1.0, 1.0, 9.0], [1.0, 2.0, 9.0]], 0.5);
        check([[1.0, 1.0, -2.0], [9.0, 9.0, -3.0], [-1.0, 9.0, -3.0]], 2.0);
        check([[-3.0, 1.0, -1.0], [-3.0, 1.0, 1.0], [-5.0, 1.0, 0.0]], 3.0);
        check([[3.0, 3.0, -1.0], [3.0, 3.0, 1.0], [9.0, 9.0, 0.0]], 2f64.sqrt());
    }
}
