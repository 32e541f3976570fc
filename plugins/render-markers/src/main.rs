//! `render-markers`: a picture of the markers on the object, coloured by the code that they blink.
//!
//! Four corners and the top, orthographic; small grey balls are places that were candidates and carry no marker. The m-sequence has
//! the first colour: from every side some of it should show.

use fibar_core::artefact::Document;
use fibar_core::artefact::constellation::Constellation;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::sites::Sites;
use fibar_picture::colour::{Colour, hue};
use fibar_picture::legend::LINE_PX;
use fibar_picture::text::{Anchor, Letters};
use fibar_picture::{Canvas, Drawing, View};
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use glam::{DVec2, DVec3};

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// Side of each of the six panels.
    #[schemars(range(min = 64, max = 4096), extend("unit" = "px"))]
    panel_px: u32,
    /// Diameter of a marker in the picture.
    #[schemars(range(min = 0.1, max = 100.0), extend("unit" = "mm"))]
    marker_mm: f64,
}

impl Default for Params {
    fn default() -> Params {
        Params { panel_px: 480, marker_mm: 5.0 }
    }
}

struct RenderMarkers;

impl Stage for RenderMarkers {
    type Params = Params;

    fn describe() -> Description {
        Description::new("render-markers", "Picture of the markers on the object, coloured by code.")
            .version(env!("CARGO_PKG_VERSION"))
            .input("body", "body", "The object.")
            .input("constellation", "constellation", "The markers.")
            .optional_input("sites", "sites", "Places that were candidates.")
            .published("picture", "picture", "markers.png", "Five views, markers coloured by code.")
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let body = TriangleMesh::from_ply(&job.read("body")?)?;
        let constellation = Constellation::from_json(&job.read("constellation")?)?;
        let sites = job.read_optional("sites")?.map(|bytes| Sites::from_json(&bytes)).transpose()?;
        let bounds = body.bounds().ok_or_else(|| StageError::input("the body is empty: nothing to draw"))?;
        let scene = Scene { body: &body, bounds, constellation: &constellation, sites: sites.as_ref() };
        job.write("picture", "markers.png", &scene.draw(&params).to_png())
    }
}

fn main() -> std::process::ExitCode {
    serve::<RenderMarkers>()
}

/// What is drawn.
struct Scene<'a> {
    body: &'a TriangleMesh,
    bounds: (DVec3, DVec3),
    constellation: &'a Constellation,
    sites: Option<&'a Sites>,
}

/// What each panel shows, and where its camera looks: obliquely, so that steps and recesses show.
const PANELS: [(&str, DVec3); 5] = [
    ("from -x -y", DVec3::new(1.0, 1.0, -0.6)),
    ("from +x -y", DVec3::new(-1.0, 1.0, -0.6)),
    ("from above", DVec3::NEG_Z),
    ("from +x +y", DVec3::new(-1.0, -1.0, -0.6)),
    ("from -x +y", DVec3::new(1.0, -1.0, -0.6)),
];
const STONE: Colour = [0.86, 0.87, 0.88];
const CANDIDATE: Colour = [0.55, 0.57, 0.60];

impl Scene<'_> {
    /// Two rows of three panels, the sixth for the legend.
    fn draw(&self, params: &Params) -> Canvas {
        let side = params.panel_px as usize;
        let mut canvas = Canvas::new(3 * side, 2 * side);
        for (k, (name, toward)) in PANELS.into_iter().enumerate() {
            let corner = [k % 3 * side, k / 3 * side];
            // Drawn twice as large and halved: smooth rims.
            let mut drawing = Drawing::new(View::new(toward.normalize(), self.bounds, 2 * side));
            self.draw_panel(&mut drawing, params.marker_mm / 2.0);
            canvas.paste(&drawing.into_canvas().halved(), corner);
            let at = DVec2::new(corner[0] as f64 + 10.0, corner[1] as f64 + 14.0);
            canvas.text(name, at, Anchor::Left, Letters::Small);
        }
        self.write_legend(&mut canvas, [2 * side + 30, side + 40]);
        canvas
    }

    fn draw_panel(&self, drawing: &mut Drawing, radius: f64) {
        drawing.mesh(self.body, |_| STONE);
        for site in self.sites.into_iter().flat_map(|sites| &sites.sites) {
            drawing.ball(site.position, radius * 0.3, CANDIDATE);
        }
        for marker in &self.constellation.markers {
            drawing.ball(marker.position, radius, colour_of(marker.pattern.0));
        }
    }

    fn write_legend(&self, canvas: &mut Canvas, [left, top]: [usize; 2]) {
        let mut line = |row: usize, colour: Colour, text: &str| {
            canvas.swatches(&[(text, colour)], [left, top + row * (LINE_PX + 4)]);
        };
        for (row, pattern) in self.constellation.patterns.iter().enumerate() {
            let count = self.constellation.markers.iter().filter(|m| m.pattern == pattern.id).count();
            let bits: String = pattern.bits.iter().map(|&b| if b { '1' } else { '0' }).collect();
            line(row, colour_of(pattern.id.0), &format!("code {}: {bits}, {count} markers", pattern.id));
        }
        if let Some(sites) = self.sites {
            let rest = sites.sites.len().saturating_sub(self.constellation.markers.len());
            let text = format!("{rest} candidates without a marker");
            line(self.constellation.patterns.len(), CANDIDATE, &text);
        }
    }
}

/// The hue of a code's LED.
fn colour_of(pattern: u32) -> Colour {
    hue(pattern.saturating_sub(1) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::artefact::constellation::{Marker, Pattern};
    use fibar_core::{MarkerId, PatternId};

    /// A tetrahedron of 60 mm with a marker on its corner towards +x.
    fn picture(pattern: u32) -> Canvas {
        let vertices = vec![DVec3::ZERO, DVec3::X * 60.0, DVec3::Y * 60.0, DVec3::Z * 60.0];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let body = TriangleMesh { vertices, triangles };
        let marker = Marker {
            id: MarkerId(1),
            position: DVec3::X * 60.0,
            normal: DVec3::X,
            pattern: PatternId(pattern),
            neighbours: vec![],
        };
        let code = |id| Pattern { id: PatternId(id), bits: vec![true, false] };
        let constellation = Constellation::new(350.0, vec![code(1), code(2)], vec![marker]);
        let bounds = (DVec3::ZERO, DVec3::splat(60.0));
        let scene = Scene { body: &body, bounds, constellation: &constellation, sites: None };
        scene.draw(&Params { panel_px: 120, marker_mm: 20.0 })
    }

    /// How many pixels of a panel have about the hue of a pattern.
    fn coloured(canvas: &Canvas, panel: usize, pattern: u32) -> usize {
        let wanted = colour_of(pattern);
        let near = |c: Colour| {
            let brightness = c.iter().sum::<f64>() / wanted.iter().sum::<f64>();
            std::iter::zip(c, wanted).all(|(a, b)| (a - b * brightness).abs() < 0.04)
        };
        let pixels = (0..120).flat_map(|y| (0..120).map(move |x| (panel % 3 * 120 + x, panel / 3 * 120 + y)));
        pixels.filter(|&(x, y)| near(canvas.at(x, y))).count()
    }

    #[test]
    fn a_marker_has_the_colour_of_its_code_where_it_shows() {
        let (first, second) = (picture(1), picture(2));
        // From +x -y (panel 1) the ball is in front; its disc of 20 mm has several hundred px.
        assert!(coloured(&first, 1, 1) > 300, "{}", coloured(&first, 1, 1));
        assert!(coloured(&second, 1, 2) > 300);
        assert!(coloured(&second, 1, 1) < coloured(&first, 1, 1) / 10);
    }
}
