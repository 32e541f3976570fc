//! `source-mesh`: reads a triangle mesh from a file and brings it to mm, +Z up.
//!
//! It reads and places; it mends nothing. Welding, orientation and closedness are `repair-manifold`'s work.

mod parts;
mod placement;
mod size;

use fibar_core::artefact::Document;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_formats::{Limits, MeshFile, ReadError};
use fibar_plugin::{Description, Direction, InputFile, Job, Stage, StageError, serve};
use placement::{Placement, Unit};
use std::fs::File;

fn main() -> std::process::ExitCode {
    serve::<SourceMesh>()
}

struct SourceMesh;

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// The file: STL, OBJ, PLY, OFF, 3MF, GLB, or glTF with embedded buffers.
    path: InputFile,
    /// Length that a 1 in the file stands for. Without it: what the file says (3MF, glTF), else mm, if that is a plausible size.
    units: Option<Unit>,
    /// Factor applied to the file's coordinates, before `fit_mm`.
    #[schemars(range(min = 1e-6, max = 1e6))]
    scale: f64,
    /// Axis of the file that points up; it becomes +Z. glTF is turned from its own +Y up before.
    up: Direction,
    /// Turn about the new +Z, counter-clockwise seen from above.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "deg"))]
    turn_deg: f64,
    /// Box along x, y, z that the object is scaled evenly to touch from inside. Without it, the size stays.
    #[schemars(extend("unit" = "mm"))]
    fit_mm: Option<[f64; 3]>,
    /// Longest side that is plausible, least and greatest; beyond it, units were probably mixed up. Not asked where
    /// `units` or `fit_mm` is given.
    #[schemars(extend("unit" = "mm"))]
    size_mm: [f64; 2],
    /// Most triangles to read; a million take about 0.2 GB.
    #[schemars(range(min = 1, max = 200_000_000))]
    max_triangles: u64,
    /// What becomes of a 3MF that breaks rules which do no harm here or which `repair-manifold` can mend: `refuse` it, or `mend`.
    broken_3mf: Broken,
}

/// What becomes of a 3MF that breaks rules.
#[derive(Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
enum Broken {
    Refuse,
    Mend,
}

impl Default for Params {
    fn default() -> Self {
        Params {
            path: InputFile::default(),
            units: None,
            scale: 1.0,
            up: Direction::PlusZ,
            turn_deg: 0.0,
            fit_mm: None,
            size_mm: [5.0, 1000.0],
            max_triangles: Limits::default().triangles,
            broken_3mf: Broken::Refuse,
        }
    }
}

impl Params {
    fn extension(&self) -> &str {
        self.path.path().extension().and_then(|e| e.to_str()).unwrap_or_default()
    }

    fn is_stl(&self) -> bool {
        self.extension().eq_ignore_ascii_case("stl")
    }
}

impl Stage for SourceMesh {
    type Params = Params;

    fn describe() -> Description {
        Description::new("source-mesh", "Reads a triangle mesh from a file and brings it to mm, +Z up.")
            .version(env!("CARGO_PKG_VERSION"))
            .output("mesh", "mesh", "The mesh as read, placed and scaled, mm.")
            .published(
                "parts",
                "parts",
                "parts.json",
                "Names and colours of the file's objects, with their triangles.",
            )
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        check(&params)?;
        job.progress(0.0, "reading")?;
        let file = read(&params)?;
        file.notes.iter().for_each(|note| job.log("warn", note));
        let file = share_corners(file, &params, job);
        job.progress(0.7, "placing")?;
        let mut parts = parts::of(&file);
        let placed = place(file, &params)?;
        parts::measure(&mut parts, &placed);
        job.metric("source.triangles", placed.triangles.len() as f64, "1");
        job.write("mesh", "mesh.ply", &placed.to_ply())?;
        job.write("parts", "parts.json", &parts.to_json())
    }
}

/// Where a format knows no shared corners, equal ones are the same corner: in an STL they were read so, in others all stand alone.
fn share_corners(mut file: MeshFile, params: &Params, job: &mut Job) -> MeshFile {
    let corners = 3 * file.mesh.triangles.len();
    if file.mesh.vertices.len() == corners {
        file.mesh = file.mesh.indexed();
    } else if !params.is_stl() {
        return file;
    }
    let counts = format!("{corners} corners stand at {} places", file.mesh.vertices.len());
    job.log("info", &format!("{counts}: equal ones are shared, as the file cannot say so itself"));
    file
}

fn check(params: &Params) -> Result<(), StageError> {
    let positive = |value: f64| value.is_finite() && value > 0.0;
    if params.path.path().as_os_str().is_empty() {
        return Err(StageError::user("no file is named").param("/path").hint("path = \"objects/NAME.obj\""));
    }
    if !positive(params.scale) {
        return Err(StageError::user(format!("scale must be above 0, is {}", params.scale)).param("/scale"));
    }
    let [smallest, largest] = params.size_mm;
    if !(smallest >= 0.0 && largest.is_finite() && smallest < largest) {
        let message = format!("size_mm must be least and greatest, is [{smallest}, {largest}]");
        return Err(StageError::user(message).param("/size_mm"));
    }
    match params.fit_mm.iter().flatten().position(|&side| !positive(side)) {
        Some(k) => Err(StageError::user("a side of fit_mm must be above 0").param(format!("/fit_mm/{k}"))),
        None => Ok(()),
    }
}

fn read(params: &Params) -> Result<MeshFile, StageError> {
    let blame = |message: String| StageError::input(message).param("/path");
    let path = params.path.path();
    let file = File::open(path).map_err(|error| blame(format!("cannot read the file: {error}")))?;
    let limits = Limits {
        triangles: params.max_triangles,
        mends_3mf: params.broken_3mf == Broken::Mend,
        shares_corners: true,
    };
    fibar_formats::read(file, params.extension(), &limits)
        .map_err(|error: ReadError| blame(error.to_string()).hint(error.hint()))
}

fn place(file: MeshFile, params: &Params) -> Result<TriangleMesh, StageError> {
    if params.units.is_none() && params.fit_mm.is_none() {
        size::check(&file, params)?;
    }
    let unit = params.units.map(Unit::mm).or(file.mm_per_unit).unwrap_or(1.0);
    let placement = Placement {
        mm_per_unit: unit * params.scale,
        up: params.up,
        turn_deg: params.turn_deg,
        fit_mm: params.fit_mm.map(glam::DVec3::from_array),
    };
    placement.apply(file.mesh).map_err(|message| StageError::input(message).param("/path"))
}
