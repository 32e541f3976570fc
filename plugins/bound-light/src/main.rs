//! `bound-light`: how much light each LED could bring to each place, were its fibre alone in the object.
//!
//! For every pair of an LED and a target [`pairs`] finds the best course known and a bound that none can exceed. Routers
//! and verifiers measure themselves by both; a hopeless pair is known before anything is routed. docs/bound-light.md tells how.

mod pairs;
mod params;

use fibar_core::LedId;
use fibar_core::artefact::Document;
use fibar_core::artefact::bounds::{Bounds, Target};
use fibar_core::artefact::constellation::Constellation;
use fibar_core::artefact::courses::{Courses, Reached};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::sites::Sites;
use fibar_core::artefact::sockets::Sockets;
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use glam::DVec3;
use params::Params;

struct BoundLight;

impl Stage for BoundLight {
    type Params = Params;

    fn describe() -> Description {
        Description::new("bound-light", "Bounds the light that each LED can bring to each place.")
            .version(env!("CARGO_PKG_VERSION"))
            .input("body", "body", "The closed body, mm.")
            .input("sockets", "sockets", "Where the LEDs sit.")
            .optional_input("sites", "sites", "The places, unless there is a constellation.")
            .optional_input("constellation", "constellation", "The places: its markers.")
            .published("bounds", "bounds", "bounds.json", "What each LED could bring to each place.")
            .output("courses", "courses", "The best curve known of every pair.")
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let body = TriangleMesh::from_ply(&job.read("body")?)?;
        let sockets = Sockets::from_json(&job.read("sockets")?)?;
        let Places { spots, file } = Places::read(job)?;
        params.check()?;
        let (targets, reached): (Vec<Target>, Vec<Reached>) =
            pairs::bound(&body, &sockets, &spots, &params, job)?.into_iter().unzip();
        report_metrics(&targets, job);
        let leds: Vec<LedId> = sockets.sockets.iter().map(|s| s.led).collect();
        let courses = Courses::new(leds.clone(), reached);
        let bounds = Bounds {
            format: Bounds::FORMAT.into(),
            law: params.light(),
            min_bend_radius_mm: params.min_bend_radius_mm,
            wall_mm: params.wall_mm,
            arrival_tilt_deg: params.arrival_tilt_deg,
            leds,
            targets,
        };
        job.write("courses", "courses.json", &courses.to_json())?;
        job.write("bounds", file, &bounds.to_json())
    }
}

/// What is bounded: places with their normals, and the file for it, as a recipe may have both.
struct Places {
    spots: Vec<(DVec3, DVec3)>,
    file: &'static str,
}

impl Places {
    /// Markers if there are any, else sites.
    fn read(job: &Job) -> Result<Places, StageError> {
        if let Some(bytes) = job.read_optional("constellation")? {
            let markers = Constellation::from_json(&bytes)?.markers;
            let spots = markers.iter().map(|m| (m.position, m.normal)).collect();
            return Ok(Places { spots, file: "bounds-of-markers.json" });
        }
        let Some(bytes) = job.read_optional("sites")? else {
            let message = "there are no places to bound: neither sites nor a constellation";
            return Err(StageError::user(message).hint("put the stage behind place-visibility or assign-…"));
        };
        let sites = Sites::from_json(&bytes)?.sites;
        Ok(Places { spots: sites.iter().map(|s| (s.position, s.normal)).collect(), file: "bounds.json" })
    }
}

fn report_metrics(targets: &[Target], job: &mut Job) {
    let best_of = |t: &Target| t.best_mm.iter().copied().fold(0.0, f64::max);
    let count = targets.len().max(1) as f64;
    let mean = targets.iter().fold(0.0, |sum, t| sum + best_of(t)) / count;
    let pairs = targets.iter().flat_map(|t| t.best_mm.iter().zip(&t.certified_mm));
    let (best, certified) = pairs.fold((0.0, 0.0), |sum, (b, c)| (sum.0 + b, sum.1 + c));
    let dark = targets.iter().filter(|t| best_of(t) == 0.0).count();
    let hopeless = targets.iter().flat_map(|t| &t.certified_mm).filter(|c| **c == 0.0).count();
    job.metric("bound.hopeless_pairs", hopeless as f64, "1");
    job.metric("bound.targets", targets.len() as f64, "1");
    job.metric("bound.targets_without_light", dark as f64, "1");
    job.metric("bound.mean_best_led_mm", mean, "mm");
    job.metric("bound.best_of_certified_share", best / f64::max(certified, 1e-9), "1");
}

fn main() -> std::process::ExitCode {
    serve::<BoundLight>()
}
