//! An orthographic view: from the body's frame to pixels and depth.

use glam::DVec3;

/// A camera at infinity with +Z up in the picture.
pub struct View {
    right: DVec3,
    toward: DVec3,
    centre: DVec3,
    pixels_per_mm: f64,
    /// Side of the square picture, px.
    pub side: usize,
    /// Least and greatest depth of the object, mm.
    pub depths: (f64, f64),
}

impl View {
    /// A view along the horizontal unit vector `toward`, fitted to the bounds.
    pub fn new(toward: DVec3, (lo, hi): (DVec3, DVec3), side: usize) -> View {
        let right = toward.cross(DVec3::Z);
        let size = hi - lo;
        let widest = size.dot(right.abs()).max(size.z);
        let centre = (lo + hi) / 2.0;
        let reach = size.dot(toward.abs()) / 2.0;
        let pixels_per_mm = 0.92 * side as f64 / widest.max(f64::MIN_POSITIVE);
        View { right, toward, centre, pixels_per_mm, side, depths: (-reach, reach) }
    }

    /// Pixel coordinates (x right, y down) and depth in mm, growing away from the viewer.
    pub fn project(&self, point: DVec3) -> DVec3 {
        let arm = point - self.centre;
        let middle = self.side as f64 / 2.0;
        let (x, y) = (arm.dot(self.right) * self.pixels_per_mm, arm.z * self.pixels_per_mm);
        DVec3::new(middle + x, middle - y, arm.dot(self.toward))
    }

    /// How much a face of this unit normal is turned to the viewer, 0 to 1.
    pub fn facing(&self, normal: DVec3) -> f64 {
        normal.dot(self.toward).abs()
    }
}
