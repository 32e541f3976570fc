//! The picture of the stage: `s(p)` on the object.
//!
//! Every sample is a dot on the surface: dark blue where few cameras see it, yellow where most see it head-on, grey where no
//! marker may sit. Small black balls are the candidates.

use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::sites::Sites;
use fibar_geometry::sampling::{SurfaceSample, surface_area};
use fibar_picture::colour::{Colour, INK, scale};
use fibar_picture::legend::LINE_PX;
use fibar_picture::{Canvas, Drawing, View};
use glam::DVec3;

const FORBIDDEN: Colour = [0.72, 0.73, 0.75];
const PANEL_PX: usize = 480;
/// Radius of a candidate, mm.
const CANDIDATE: f64 = 0.9;

/// Two corners and the top of the object.
const LOOKS: [DVec3; 3] = [DVec3::new(1.0, 1.0, -0.6), DVec3::new(-1.0, -1.0, -0.6), DVec3::NEG_Z];

/// Three views of the rated samples.
pub fn draw(body: &TriangleMesh, samples: &[SurfaceSample], suitability: &[f64], sites: &Sites) -> Vec<u8> {
    let rated = || suitability.iter().copied().filter(|&s| s > 0.0);
    let (least, most) = (rated().fold(f64::INFINITY, f64::min), rated().fold(0.0, f64::max));
    let colour = |s: f64| if s > 0.0 { scale((s - least) / (most - least).max(1e-9)) } else { FORBIDDEN };
    let bounds = body.bounds().unwrap_or((DVec3::ZERO, DVec3::ZERO));
    // Dots a little wider than the square that a sample stands for leave no gaps.
    let dot = 0.8 * (surface_area(body) / samples.len().max(1) as f64).sqrt();
    let mut canvas = Canvas::new(3 * PANEL_PX, PANEL_PX + LINE_PX);
    for (k, toward) in LOOKS.into_iter().enumerate() {
        let mut drawing = Drawing::new(View::new(toward.normalize(), bounds, 2 * PANEL_PX));
        for (sample, &s) in samples.iter().zip(suitability) {
            // Sunk, so that the dots make a surface and not a skin of pearls.
            drawing.ball(sample.position - sample.normal * (0.7 * dot), dot, colour(s));
        }
        sites.sites.iter().for_each(|site| drawing.ball(site.position, CANDIDATE, INK));
        canvas.paste(&drawing.into_canvas().halved(), [k * PANEL_PX, 0]);
    }
    let [low, high] = [format!("s(p) = {least:.0} rad"), format!("{most:.0} rad")];
    let right = canvas.scale_bar([&low, &high], [10, PANEL_PX]);
    let count = format!("{} candidates", sites.sites.len());
    canvas.swatches(&[("no marker may sit here", FORBIDDEN), (&count, INK)], [right, PANEL_PX]);
    canvas.to_png()
}
