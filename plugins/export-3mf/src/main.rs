//! The solids as a 3MF package: to the letter of the specification, or as PrusaSlicer wants it.
//!
//! Both are written here from scratch, because the writers on the registry make base materials that the reference
//! implementation rejects. `tests/peers/check_lib3mf.py` and `check_prusa.py` hold the results against other people's
//! readers. docs/export.md tells the two profiles apart.

mod material_list;
mod model;
mod names;
mod package;
mod part;
mod precision;
mod slicer_config;

use fibar_core::artefact::Document;
use fibar_core::artefact::parts::Parts;
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use part::Part;

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// Whom the file is for: `spec` keeps one object per solid with base materials, `prusa` merges them into one mesh with
    /// a volume and an extruder for each, which is what PrusaSlicer reads.
    profile: Profile,
    /// Where the middle of the object stands on the bed, x and y.
    #[schemars(extend("unit" = "mm"))]
    bed_position_mm: [f64; 2],
    /// Names of the user's parts may get lost; otherwise that is an error.
    lose_names: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
enum Profile {
    Spec,
    Prusa,
}

impl Default for Params {
    fn default() -> Params {
        Params { profile: Profile::Spec, bed_position_mm: [125.0, 105.0], lose_names: false }
    }
}

impl Profile {
    fn file(self) -> &'static str {
        match self {
            Profile::Spec => "object.3mf",
            Profile::Prusa => "object-prusa.3mf",
        }
    }
}

struct Export3mf;

impl Stage for Export3mf {
    type Params = Params;

    fn describe() -> Description {
        Description::new("export-3mf", "Writes the solids as one 3MF file for multi-material printing.")
            .version(env!("CARGO_PKG_VERSION"))
            .input("solids", "solids", "The closed solids.")
            .optional_input("parts", "parts", "The user's parts, whose names must all be on solids.")
            .published("3mf", "3mf", "object.3mf", "The package; object-prusa.3mf for the profile `prusa`.")
            .memory_mb(2048)
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let parts = part::read_all(&job.input_path("solids")?)?;
        if let Some(named) = job.read_optional("parts")?.filter(|_| !params.lose_names) {
            names::check(&Parts::from_json(&named)?, &parts)?;
        }
        job.progress(0.2, "model")?;
        let placement = place(&parts, params.bed_position_mm);
        let mut files = vec![match params.profile {
            Profile::Spec => model::of_components(&parts, placement),
            Profile::Prusa => model::of_volumes(&parts, placement),
        }];
        if params.profile == Profile::Prusa {
            files.push(slicer_config::of(&parts));
        }
        job.progress(0.5, "packing")?;
        let bytes = package::pack(&files)?;
        let triangles: usize = parts.iter().map(|part| part.mesh.triangles.len()).sum();
        job.log("info", &format!("{} solids, {triangles} triangles, {} bytes", parts.len(), bytes.len()));
        job.write("3mf", params.profile.file(), &bytes)
    }
}

/// The shift that puts the middle of all parts at a place of the bed and their lowest point on it, mm.
fn place(parts: &[Part], [x, y]: [f64; 2]) -> [f64; 3] {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for vertex in parts.iter().flat_map(|part| &part.mesh.vertices) {
        for axis in 0..3 {
            low[axis] = low[axis].min(vertex[axis]);
            high[axis] = high[axis].max(vertex[axis]);
        }
    }
    let middle = |axis: usize| 0.5 * (f64::from(low[axis]) + f64::from(high[axis]));
    let tenths = |shift: f64| (shift * 10.0).round() / 10.0 + 0.0;
    [tenths(x - middle(0)), tenths(y - middle(1)), -f64::from(low[2]) + 0.0]
}

fn main() -> std::process::ExitCode {
    serve::<Export3mf>()
}
