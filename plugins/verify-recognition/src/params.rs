//! The parameters of the stage.

use fibar_track::camera::Camera;

/// The views, the camera, and what is asked of the object.
#[derive(Clone, Debug, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Views, each from a random direction, distance and roll.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub views: u32,
    /// Views come from at least this far above the horizon of the base.
    #[schemars(range(min = -90.0, max = 89.0), extend("unit" = "deg"))]
    pub lowest_view_deg: f64,
    /// Least distance of the camera from the middle of the body.
    #[schemars(range(min = 10.0, max = 100_000.0), extend("unit" = "mm"))]
    pub nearest_mm: f64,
    /// Greatest distance.
    #[schemars(range(min = 10.0, max = 100_000.0), extend("unit" = "mm"))]
    pub farthest_mm: f64,
    /// The camera aims at a random point of a ball of this radius about the middle of the body.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("unit" = "mm"))]
    pub aim_mm: f64,
    /// Focal length of the camera.
    #[schemars(range(min = 10.0, max = 100_000.0), extend("unit" = "px"))]
    pub focal_px: f64,
    /// Width of the image.
    #[schemars(range(min = 16, max = 20_000), extend("unit" = "px"))]
    pub width_px: u32,
    /// Height of the image.
    #[schemars(range(min = 16, max = 20_000), extend("unit" = "px"))]
    pub height_px: u32,
    /// Standard deviation of a blob's centre, in each direction.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "px"))]
    pub noise_px: f64,
    /// Share of the blobs whose bits are misread as those of another pattern.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub misread_share: f64,
    /// A marker is seen only within this angle of its normal.
    #[schemars(range(min = 1.0, max = 90.0), extend("unit" = "deg"))]
    pub emission_limit_deg: f64,
    /// How far off the surface rays start.
    #[schemars(range(min = 0.0001, max = 10.0), extend("unit" = "mm"))]
    pub lift_mm: f64,
    /// A pose is right when its orientation is off by at most this …
    #[schemars(range(min = 0.01, max = 180.0), extend("unit" = "deg"))]
    pub pose_turn_deg: f64,
    /// … and the middle of the body by at most this share of its distance.
    #[schemars(range(min = 0.0001, max = 1.0), extend("unit" = "1"))]
    pub pose_shift_share: f64,
    /// Rule `recognise.names`: share of visible markers that our recogniser names rightly, none missing.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub min_rate_missing_00: f64,
    /// Rule `recognise.names_missing`: the same with 30 % of the visible markers missing.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub min_rate_missing_30: f64,
    /// Rule `recognise.views`: share of views with at least six visible markers that are not in one plane.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub min_views_6_share: f64,
    /// Rule `recognise.mseq`: share of views with a visible m-sequence marker.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub min_views_mseq_share: f64,
    /// Rule `recognise.two_mseq`: share of views with two.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub min_views_two_mseq_share: f64,
}

impl Default for Params {
    fn default() -> Params {
        Params {
            views: 10_000,
            lowest_view_deg: 0.0,
            nearest_mm: 600.0,
            farthest_mm: 1400.0,
            aim_mm: 40.0,
            focal_px: 1100.0,
            width_px: 720,
            height_px: 540,
            noise_px: 0.3,
            misread_share: 0.0,
            emission_limit_deg: 60.0,
            lift_mm: 0.02,
            pose_turn_deg: 3.0,
            pose_shift_share: 0.02,
            min_rate_missing_00: 0.999,
            min_rate_missing_30: 0.995,
            min_views_6_share: 0.99,
            min_views_mseq_share: 1.0,
            min_views_two_mseq_share: 0.95,
        }
    }
}

impl Params {
    /// The camera.
    pub fn camera(&self) -> Camera {
        Camera::centred(self.focal_px, f64::from(self.width_px), f64::from(self.height_px))
    }

    /// The limit of emission, rad.
    pub fn emission_rad(&self) -> f64 {
        self.emission_limit_deg.to_radians()
    }
}
