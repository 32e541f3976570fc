//! `source-mesh`: reads a triangle mesh from a file and brings it to mm, +Z up.
//!
//! It reads and places; it mends nothing. Welding, orientation and closedness are `repair-manifold`'s work.

mod placement;


use fibar_core::artefact::mesh::TriangleMesh;
use fibar_plugin::{Description, Direction, InputFile, Job, Stage, StageError, serve};
use placement::{Placement, Unit};
use fibar_formats::ReadError;
use std::path::Path;

fn main() -> std::process::ExitCode {
    serve::<SourceMesh>()
}

struct SourceMesh;

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// The file: OBJ, STL (ASCII or binary) or PLY (ASCII or binary).
    path: InputFile,
    /// Length that a 1 in the file stands for.
    units: Unit,
    /// Factor applied to the file's coordinates, before `fit_mm`.
    #[schemars(range(min = 1e-6, max = 1e6))]
    scale: f64,
    /// Axis of the file that points up; it becomes +Z.
    up: Direction,
    /// Turn about the new +Z, counter-clockwise seen from above.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "deg"))]
    turn_deg: f64,
    /// Box along x, y, z that the object is scaled evenly to touch from inside. Without it, the size stays.
    #[schemars(extend("unit" = "mm"))]
    fit_mm: Option<[f64; 3]>,
}

impl Default for Params {
    fn default() -> Self {
        Params {
            path: InputFile::default(),
            units: Unit::Mm,
            scale: 1.0,
            up: Direction::PlusZ,
            turn_deg: 0.0,
            fit_mm: None,
        }
    }
}

impl Stage for SourceMesh {
    type Params = Params;

    fn describe() -> Description {
        Description::new("source-mesh", "Reads a triangle mesh from a file and brings it to mm, +Z up.")
            .version(env!("CARGO_PKG_VERSION"))
            .output("mesh", "mesh", "The mesh as read, placed and scaled, mm.")
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        check(&params)?;
        job.progress(0.0, "reading")?;
        let mesh = read(params.path.path())?;
        job.progress(0.7, "placing")?;
        let placed = place(mesh, &params)?;
        job.metric("source.triangles", placed.triangles.len() as f64, "1");
        job.write("mesh", "mesh.ply", &placed.to_ply())
    }
}

fn check(params: &Params) -> Result<(), StageError> {
    let positive = |value: f64| value.is_finite() && value > 0.0;
    if params.path.path().as_os_str().is_empty() {
        return Err(StageError::user("no file is named").param("/path").hint("path = \"objects/NAME.obj\""));
    }
    if !positive(params.scale) {
        return Err(StageError::user(format!("scale must be above 0, is {}", params.scale)).param("/scale"));
    }
    match params.fit_mm.iter().flatten().position(|&side| !positive(side)) {
        Some(k) => Err(StageError::user("a side of fit_mm must be above 0").param(format!("/fit_mm/{k}"))),
        None => Ok(()),
    }
}

fn read(path: &Path) -> Result<TriangleMesh, StageError> {
    let blame = |message: String| StageError::input(message).param("/path");
    let bytes = std::fs::read(path).map_err(|error| blame(format!("cannot read the file: {error}")))?;
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    fibar_formats::read_mesh(&bytes, extension).map_err(|error| {
        let hint = error.hint();
        let ReadError { place, message, .. } = error;
        blame(format!("{place}{message}")).hint(hint)
    })
}

fn place(mesh: TriangleMesh, params: &Params) -> Result<TriangleMesh, StageError> {
    let placement = Placement {
        mm_per_unit: params.units.mm() * params.scale,
        up: params.up,
        turn_deg: params.turn_deg,
        fit_mm: params.fit_mm.map(glam::DVec3::from_array),
    };
    placement.apply(mesh).map_err(|message| StageError::input(message).param("/path"))
}
