//! An orthographic view: from the body's frame to pixels and depth.

use glam::{DVec2, DVec3};

/// Share of the picture's side that the object fills.
const FILL: f64 = 0.92;

/// A camera at infinity, with +Z up in the picture unless it looks along Z, when +Y is.
#[derive(Clone, Copy, Debug)]
pub struct View {
    right: DVec3,
    up: DVec3,
    toward: DVec3,
    centre: DVec3,
    /// Scale of the picture.
    pub pixels_per_mm: f64,
    /// Side of the square picture, px.
    pub side: usize,
    /// Least and greatest depth of the object's box, mm.
    pub depths: (f64, f64),
}

impl View {
    /// A view along the unit vector `toward`, from the camera to the object, fitted to the object's box.
    pub fn new(toward: DVec3, (low, high): (DVec3, DVec3), side: usize) -> View {
        let pole = if toward.z.abs() > 0.999 { DVec3::Y } else { DVec3::Z };
        let right = toward.cross(pole).normalize();
        let up = right.cross(toward);
        // Half the extent of a box along a unit vector.
        let reach = |axis: DVec3| (high - low).dot(axis.abs()) / 2.0;
        let widest = 2.0 * reach(right).max(reach(up));
        let pixels_per_mm = FILL * side as f64 / widest.max(f64::MIN_POSITIVE);
        let centre = (low + high) / 2.0;
        View { right, up, toward, centre, pixels_per_mm, side, depths: (-reach(toward), reach(toward)) }
    }

    /// Pixel coordinates (x right, y down) and depth in mm, growing away from the viewer.
    pub fn project(&self, point: DVec3) -> DVec3 {
        let arm = point - self.centre;
        let pixel = DVec2::new(arm.dot(self.right), -arm.dot(self.up)) * self.pixels_per_mm;
        (pixel + self.side as f64 / 2.0).extend(arm.dot(self.toward))
    }

    /// How much a face of this unit normal is turned to the viewer or away from them, 0 to 1.
    pub fn facing(&self, normal: DVec3) -> f64 {
        normal.dot(self.toward).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: (DVec3, DVec3) = (DVec3::new(-5.0, -5.0, 0.0), DVec3::new(5.0, 5.0, 10.0));

    fn check(toward: DVec3, point: [f64; 3], expected: [f64; 3]) {
        let seen = View::new(toward, BOX, 100).project(DVec3::from(point));
        assert!((seen - DVec3::from(expected)).length() < 1e-9, "{point:?} seen at {seen}");
    }

    #[test]
    fn front_side_and_top() {
        check(DVec3::Y, [5.0, -5.0, 10.0], [96.0, 4.0, -5.0]);
        check(DVec3::NEG_X, [0.0, 5.0, 0.0], [96.0, 96.0, 0.0]);
        check(DVec3::NEG_Z, [5.0, 5.0, 10.0], [96.0, 4.0, -5.0]);
        check(DVec3::Z, [5.0, 5.0, 0.0], [4.0, 4.0, -5.0]);
    }
}
