//! `source-build123d`: runs a build123d script, or reads STEP or BREP, and tessellates its solids.
//!
//! The CAD kernel lives in a Python process of its own (`python/`), which can hang, crash or be killed without harm. Here
//! is what surrounds it: its environment, its clock, and the checks of what it leaves behind.

mod child;
mod environment;
mod group;
mod kernel;
mod listener;
mod manifest;
mod params;
mod parts;
mod solid;

use fibar_plugin::{Description, Job, Stage, StageError, serve};
use kernel::Kernel;
use manifest::Shape;
use params::Params;
use std::process::ExitCode;

fn main() -> ExitCode {
    if std::env::args().nth(1).is_some_and(|word| word == "--set-up") {
        return set_up_by_hand();
    }
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
            .program("python3")
            .memory_mb(2048)
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        params.check()?;
        job.progress(0.0, "environment")?;
        let python = environment::ensure(job)?;
        job.progress(0.1, "build123d")?;
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

/// `source-build123d --set-up`: makes the environment now, with the caller's own settings for pip and proxies.
fn set_up_by_hand() -> ExitCode {
    match environment::ensure(&mut listener::Terminal) {
        Ok(python) => {
            println!("{}", python.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(4)
        }
    }
}
