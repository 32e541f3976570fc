//! `sweep-solids`: one closed solid per role and LED, which together fill the object and nowhere overlap.
//!
//! ```text
//! body = sockets ∪ skin ∪ filler ∪ core₁ ∪ cladding₁ ∪ black₁ ∪ core₂ …          (disjoint)
//! ```
//!
//! Fibres are swept in `layers.rs` and shared out in `partition.rs`. It does not judge: whether walls and gaps are as
//! they should be is the verifiers' business.

mod partition;

mod layers;
mod regions;
mod socket;

mod output;

use fibar_core::artefact::Document;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::routes::Routes;
use fibar_core::artefact::sockets::Sockets;
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use fibar_solid::{Grid, InsetOptions, Solid, SolidError, inset};
use layers::{LedTubes, sweep_all};
use partition::{Partition, Room};
use regions::Regions;

fn main() -> std::process::ExitCode {
    serve::<SweepSolids>()
}

struct SweepSolids;

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// Thickness of the white skin under the surface (Tone 2020: 0.4 mm); nowhere less, on curved places up to 7 % more.
    #[schemars(range(min = 0.05, max = 20.0), extend("unit" = "mm"))]
    skin_mm: f64,
    /// How far a facet may be from the round tube, and a tube from the curve.
    #[schemars(range(min = 0.002, max = 0.3), extend("unit" = "mm"))]
    chord_error_mm: f64,
    /// Detail of the skin's inner side that may be dropped; the skin is that much thicker.
    #[schemars(range(min = 0.0, max = 0.1), extend("unit" = "mm"))]
    simplify_mm: f64,
}

impl Default for Params {
    fn default() -> Self {
        Params { skin_mm: 0.4, chord_error_mm: 0.02, simplify_mm: 0.005 }
    }
}

impl Stage for SweepSolids {
    type Params = Params;

    fn describe() -> Description {
        Description::new(
            "sweep-solids",
            "One closed solid per role and LED: core, cladding, black, skin, filler.",
        )
        .version(env!("CARGO_PKG_VERSION"))
        .input("body", "body", "The closed body, mm.")
        .input("sockets", "sockets", "The LED sockets to cut out.")
        .input("routes", "routes", "The fibres, from LED to marker.")
        .optional_input("mesh", "mesh", "The mesh that the parts belong to.")
        .optional_input(
            "parts",
            "parts",
            "Named parts: skin and filler are divided by them, and keep their names.",
        )
        .output("solids", "solids", "A PLY file per solid, and their index.")
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let body = TriangleMesh::from_ply(&job.read("body")?)?;
        let sockets = Sockets::from_json(&job.read("sockets")?)?;
        let routes = Routes::from_json(&job.read("routes")?)?;
        let grid = Grid::exact_in_f32(extent(&body));
        let regions = Regions::read(job, &body)?;
        let body =
            Solid::from_mesh(&body).map_err(|error| StageError::input(format!("the body: {error}")))?;

        job.progress(0.02, "skin")?;
        let room = make_room(body, &sockets, &params)?;
        job.progress(0.2, "fibres")?;
        let tubes = sweep_all(&routes, &sockets, params.chord_error_mm)?;
        report_bends(&tubes, job);
        job.progress(0.5, "sharing out")?;
        let partition = Partition::of(&room, &tubes, &regions)?;
        report_collisions(&partition, job);
        job.progress(0.9, "writing")?;
        output::write(partition, params.skin_mm, grid, job)
    }
}

fn extent(body: &TriangleMesh) -> f64 {
    body.vertices.iter().map(|v| v.abs().max_element()).fold(0.0, f64::max)
}

fn make_room(body: Solid, sockets: &Sockets, params: &Params) -> Result<Room, StageError> {
    let options = InsetOptions { thickness: params.skin_mm, simplify: params.simplify_mm };
    let inside = inset(&body, options).map_err(internal)?;
    if inside.is_empty() {
        return Err(StageError::user(format!("a skin of {} mm leaves no inside", params.skin_mm))
            .param("/skin_mm")
            .hint("use a thinner skin or a larger object"));
    }
    let holes = socket::holes(sockets, params.chord_error_mm).map_err(internal)?;
    Room::new(body, inside, holes).map_err(internal)
}

fn report_bends(tubes: &[LedTubes], job: &mut Job) {
    let joints: usize = tubes.iter().map(|led| led.elbows).sum();
    job.metric("sweep.elbows", joints as f64, "1");
    if joints > 0 {
        let message = "bends tighter than the fibre's own radius are filled with elbows";
        job.log("warn", &format!("{message} ({joints} of them)"));
    }
}

fn report_collisions(partition: &Partition, job: &mut Job) {
    let total = partition.collisions.iter().fold(0.0, |sum, c| sum + c.volume_mm3);
    job.metric("sweep.collisions", partition.collisions.len() as f64, "1");
    job.metric("sweep.collision_volume_mm3", total, "mm3");
    for c in &partition.collisions {
        let place = format!("({:.1}, {:.1}, {:.1})", c.place_mm.x, c.place_mm.y, c.place_mm.z);
        let message = format!(
            "fibres of patterns {} and {} overlap by {:.4} mm³ around {place} mm; pattern {} keeps the place",
            c.winner, c.loser, c.volume_mm3, c.winner
        );
        job.log("warn", &message);
    }
}

fn internal(error: SolidError) -> StageError {
    StageError::internal(error.to_string())
}
