//! A pinhole camera: from its frame to pixels and back. Lens distortion is undone before blobs come here.

use glam::{DVec2, DVec3};

/// A camera without distortion: x right, y down, z forward; square pixels, pixel coordinates from the upper left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Focal length, px.
    pub focal_px: f64,
    /// Where the optical axis meets the image, px.
    pub centre_px: DVec2,
    /// Width and height of the image, px.
    pub size_px: DVec2,
}

impl Camera {
    /// A camera whose axis meets the middle of its image.
    pub fn centred(focal_px: f64, width_px: f64, height_px: f64) -> Camera {
        let size_px = DVec2::new(width_px, height_px);
        Camera { focal_px, centre_px: size_px / 2.0, size_px }
    }

    /// Pixel of a point in the camera's frame, mm; of no use for points that are not in front.
    pub fn project(&self, point: DVec3) -> DVec2 {
        self.centre_px + point.truncate() * (self.focal_px / point.z)
    }

    /// Unit vector from the camera's centre through a pixel.
    pub fn bearing(&self, pixel: DVec2) -> DVec3 {
        ((pixel - self.centre_px) / self.focal_px).extend(1.0).normalize()
    }

    /// Whether a pixel lies in the image.
    pub fn sees(&self, pixel: DVec2) -> bool {
        pixel.cmpge(DVec2::ZERO).all() && pixel.cmplt(self.size_px).all()
    }
}
