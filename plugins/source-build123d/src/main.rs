//! `source-build123d`: runs a build123d script, or reads STEP or BREP, and tessellates its solids.
//!
//! The CAD kernel lives in a Python process of its own (`python/`), which can hang, crash or be killed without harm. Here
//! is what surrounds it: its clock, and the checks of what it leaves behind. Its environment is the host's work.

mod child;
mod group;
mod kernel;
mod manifest;
mod params;
mod solid;

use fibar_core::artefact::Document;
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use kernel::Kernel;
use manifest::Shape;
use params::Params;
use std::process::ExitCode;

/// The lock file of the environment, which the build script puts beside the executable.
const REQUIREMENTS: &str = "source-build123d.requirements.txt";

fn main() -> ExitCode {
    serve::<SourceBuild123d>()
}

struct SourceBuild123d;

impl Stage for SourceBuild123d {
    type Params = Params;

    fn describe() -> Description {
        let summary = "Runs a build123d script, or reads STEP or BREP, and tessellates its solids.";
        Description::new("source-build123d", summary)
            .version(env!("CARGO_PKG_VERSION"))
            .output("mesh", "mesh", "All solids as one mesh, each welded by exact coordinates, mm, +Z up.")
            .published(
                "parts",
                "parts",
                "parts.json",
                "Names and colours of the solids, with their triangles.",
            )
            .python_environment(REQUIREMENTS, [3, 11], [3, 14])
            .memory_mb(2048)
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        params.check()?;
        let python = job.python()?.to_path_buf();
        job.progress(0.0, "build123d")?;
        let shape = Kernel { python, params: &params }.run(job)?;
        if let Some(unit) = &shape.unit {
            job.log("info", &format!("the file is in {unit}s"));
        }
        job.progress(0.8, "welding")?;
        let (mesh, parts) = solid::join(shape, job)?;
        job.metric("source.triangles", mesh.triangles.len() as f64, "1");
        job.write("mesh", "mesh.ply", &mesh.to_ply())?;
        job.write("parts", "parts.json", &parts.to_json())
    }
}
