//! `render-cutaway`: a picture of the finished object, cut open and seen through.
//!
//! Upper row: the object cut by a plane, from the front and from the side. What the plane passes through is painted by
//! role; through the filler one sees the fibres behind the plane, coloured by LED. Lower row: all fibres inside the
//! object's outline, from the same two sides. Orthographic, drawn from the finished solids alone.

mod panel;

use fibar_core::artefact::Document;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::solids::{INDEX_FILE, Solid, Solids};
use fibar_picture::{Canvas, View};
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use glam::DVec3;
use panel::Panel;

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// Side of each of the four panels.
    #[schemars(range(min = 64, max = 4096), extend("unit" = "px"))]
    panel_px: u32,
    /// Where the cutting plane lies between the near (0) and the far side (1) of the object.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    cut: f64,
}

impl Default for Params {
    fn default() -> Params {
        Params { panel_px: 720, cut: 0.5 }
    }
}

/// A solid with its mesh.
pub struct Part {
    solid: Solid,
    mesh: TriangleMesh,
}

struct RenderCutaway;

impl Stage for RenderCutaway {
    type Params = Params;

    fn describe() -> Description {
        Description::new("render-cutaway", "A picture of the finished object, cut open and seen through.")
            .version(env!("CARGO_PKG_VERSION"))
            .input("solids", "solids", "The finished solids.")
            .published("picture", "picture", "cutaway.png", "Four panels: cut open, and fibres by LED.")
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let parts = read_parts(job)?;
        let bounds =
            bounds(&parts).ok_or_else(|| StageError::input("the solids are empty: nothing to draw"))?;
        let side = params.panel_px as usize;
        let mut canvas = Canvas::new(2 * side, 2 * side);
        for (column, toward) in [DVec3::Y, DVec3::NEG_X].into_iter().enumerate() {
            let view = View::new(toward, bounds, side);
            job.progress(column as f64 / 2.0, "drawing")?;
            canvas.paste(&Panel::cut_open(&parts, &view, params.cut), [column * side, 0]);
            canvas.paste(&Panel::seen_through(&parts, &view), [column * side, side]);
        }
        job.write("picture", "cutaway.png", &canvas.to_png())
    }
}

fn main() -> std::process::ExitCode {
    serve::<RenderCutaway>()
}

fn read_parts(job: &Job) -> Result<Vec<Part>, StageError> {
    let folder = job.input_path("solids")?;
    let index = Solids::from_json(&std::fs::read(folder.join(INDEX_FILE))?)?;
    let read = |solid: Solid| {
        let mesh = TriangleMesh::from_ply(&std::fs::read(folder.join(&solid.file))?)?;
        Ok(Part { solid, mesh })
    };
    index.solids.into_iter().map(read).collect()
}

fn bounds(parts: &[Part]) -> Option<(DVec3, DVec3)> {
    let all = parts.iter().filter_map(|part| part.mesh.bounds());
    all.reduce(|(lo, hi), (lo2, hi2)| (lo.min(lo2), hi.max(hi2)))
}
