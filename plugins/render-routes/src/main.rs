//! `render-routes`: pictures of the fibres inside the pale shape of the object.
//!
//! Upper row: coloured by LED, from the front and from the side. Lower row: coloured by what light loses there, in dB per cm
//! of fibre by the monotone law; dark is a straight fibre, yellow the costliest bend of all. Orthographic, drawn from
//! `routes.json` alone, so that a routing can be looked at before any solid is made.

mod fibres;

use fibar_core::artefact::Document;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::routes::Routes;
use fibar_core::light::LightLaw;
use fibar_geometry::optics::Absorption;
use fibar_picture::colour::hue;
use fibar_picture::legend::LINE_PX;
use fibar_picture::{Canvas, Drawing, View};
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use fibres::{LossScale, Tube};
use glam::DVec3;

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// Side of each of the four panels.
    #[schemars(range(min = 64, max = 4096), extend("unit" = "px"))]
    panel_px: u32,
    /// Absorption of a straight fibre.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1/mm"))]
    c1_per_mm: f64,
    /// Further absorption of a bend as its radius goes to 0.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "1/mm"))]
    c2_per_mm: f64,
    /// Decay of the bend's part with its radius.
    #[schemars(range(min = 0.0001, max = 10.0), extend("unit" = "1/mm"))]
    c3_per_mm: f64,
}

impl Default for Params {
    fn default() -> Params {
        let LightLaw { c1_per_mm, c2_per_mm, c3_per_mm, .. } = LightLaw::TONE_2020;
        Params { panel_px: 720, c1_per_mm, c2_per_mm, c3_per_mm }
    }
}

struct RenderRoutes;

impl Stage for RenderRoutes {
    type Params = Params;

    fn describe() -> Description {
        Description::new("render-routes", "Pictures of the fibres inside the object: by LED, and by loss.")
            .version(env!("CARGO_PKG_VERSION"))
            .input("body", "body", "The object.")
            .input("routes", "routes", "The fibres.")
            .published("picture", "picture", "routes.png", "Four panels: by LED and by loss, two sides.")
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let body = TriangleMesh::from_ply(&job.read("body")?)?;
        let routes = Routes::from_json(&job.read("routes")?)?;
        let bounds = body.bounds().ok_or_else(|| StageError::input("the body is empty: nothing to draw"))?;
        let tubes: Result<Vec<Tube>, StageError> = routes.fibres.iter().map(Tube::of).collect();
        let Params { panel_px, c1_per_mm, c2_per_mm, c3_per_mm } = params;
        let law = LightLaw { c1_per_mm, c2_per_mm, c3_per_mm, ..LightLaw::TONE_2020 };
        let scale = LossScale::of(Absorption::monotone(law), law);
        let canvas = draw(&tubes?, &body, bounds, &scale, panel_px as usize, job)?;
        job.write("picture", "routes.png", &canvas.to_png())
    }
}

fn main() -> std::process::ExitCode {
    serve::<RenderRoutes>()
}

fn draw(
    tubes: &[Tube],
    body: &TriangleMesh,
    bounds: (DVec3, DVec3),
    scale: &LossScale,
    side: usize,
    job: &mut Job,
) -> Result<Canvas, StageError> {
    let mut canvas = Canvas::new(2 * side, 2 * (side + LINE_PX));
    for (column, toward) in [DVec3::Y, DVec3::NEG_X].into_iter().enumerate() {
        job.progress(column as f64 / 2.0, "drawing")?;
        // Drawn twice as large and halved: smooth rims.
        let view = View::new(toward, bounds, 2 * side);
        let (mut by_led, mut by_loss) = (Drawing::new(view), Drawing::new(view));
        for tube in tubes {
            tube.draw(&mut by_led, |_| hue(tube.led.0 as usize));
            tube.draw(&mut by_loss, |curvature| scale.colour(curvature));
        }
        for (row, mut drawing) in [by_led, by_loss].into_iter().enumerate() {
            drawing.ghost(body);
            canvas.paste(&drawing.into_canvas().halved(), [column * side, row * (side + LINE_PX)]);
        }
    }
    write_legends(&mut canvas, tubes, scale, side);
    Ok(canvas)
}

fn write_legends(canvas: &mut Canvas, tubes: &[Tube], scale: &LossScale, side: usize) {
    let mut leds: Vec<u32> = tubes.iter().map(|tube| tube.led.0).collect();
    leds.sort_unstable();
    leds.dedup();
    let names: Vec<String> = leds.iter().map(|led| format!("LED {led}")).collect();
    let entries: Vec<_> =
        names.iter().map(String::as_str).zip(leds.iter().map(|led| hue(*led as usize))).collect();
    canvas.swatches(&entries, [10, side]);
    let [least, most] = scale.captions();
    canvas.scale_bar([&least, &most], [10, 2 * side + LINE_PX]);
}
