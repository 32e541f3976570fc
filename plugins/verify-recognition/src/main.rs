//! `verify-recognition`: how many markers a camera names rightly, and how often it finds the pose.
//!
//! It drives `fibar-track`, the very code of the tracker, on views of its own: random directions, distances, aims and rolls that no
//! lookup table was made from; visibility by its own rays; blobs with noise; markers missing at random. Decoding of bits
//! is taken to have worked: a blob comes with its pattern.

#[cfg(test)]
mod fixture;
mod listing;
mod occlusion;
mod params;
mod picture;
mod scene;
mod tally;
#[cfg(test)]
mod tests;
mod trial;
mod verdict;
mod views;

use fibar_core::artefact::Document;
use fibar_core::artefact::constellation::Constellation;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use fibar_track::model::Model;
use occlusion::Occluder;
use params::Params;
use rayon::prelude::*;
use scene::Scene;
use tally::Tally;
use trial::Bench;

struct VerifyRecognition;

impl Stage for VerifyRecognition {
    type Params = Params;

    fn describe() -> Description {
        Description::new(
            "verify-recognition",
            "Measures how many markers cameras name rightly, and how often they find the pose, on held-out views.",
        )
        .version(env!("CARGO_PKG_VERSION"))
        .input("body", "body", "What hides markers.")
        .input("constellation", "constellation", "The markers and the lookup table.")
        .published("verdict", "verdict", "verdict-verify-recognition.json", "Rates, coverage, the worst view.")
        .published("picture", "picture", "recognition.png", "Recognition over the viewing sphere, and the worst view.")
        .published("views", "table", "recognition-views.csv", "Every view: names, pose, errors, predicted deviations.")
        .seeded()
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let body = TriangleMesh::from_ply(&job.read("body")?)?;
        let constellation = Constellation::from_json(&job.read("constellation")?)?;
        check(&params, &constellation)?;
        let (low, high) = body.bounds().ok_or_else(|| StageError::input("the body is empty"))?;
        let occluder = Occluder::of(&body);
        let scene = Scene { constellation: &constellation, occluder: &occluder, middle: (low + high) / 2.0 };
        let model = Model::new(&constellation, params.emission_rad());
        let bench = Bench { scene, model: &model, params: &params, seed: job.seed() };
        let tally = try_views(&bench, &mut |fraction| job.progress(0.95 * fraction, "views"))?;
        report(&tally, &bench, job)
    }
}

fn main() -> std::process::ExitCode {
    serve::<VerifyRecognition>()
}

fn check(params: &Params, constellation: &Constellation) -> Result<(), StageError> {
    if params.farthest_mm < params.nearest_mm {
        return Err(StageError::user("the farthest distance is less than the nearest").param("/farthest_mm"));
    }
    if constellation.markers.is_empty() {
        return Err(StageError::input("the constellation has no marker")
            .hint("what did the assignment drop, and why?"));
    }
    Ok(())
}

/// Tries all views, a portion at a time; their order is that of their numbers.
fn try_views(
    bench: &Bench,
    progress: &mut dyn FnMut(f64) -> Result<(), StageError>,
) -> Result<Tally, StageError> {
    const PORTION: u64 = 500;
    let views = u64::from(bench.params.views);
    let mut reports = Vec::with_capacity(views as usize);
    for first in (0..views).step_by(PORTION as usize) {
        progress(first as f64 / views as f64)?;
        let portion = first..(first + PORTION).min(views);
        reports.par_extend(portion.into_par_iter().map(|number| bench.try_view(number)));
    }
    Ok(Tally { reports })
}

fn report(tally: &Tally, bench: &Bench, job: &mut Job) -> Result<(), StageError> {
    for (name, value, unit) in tally.metrics() {
        job.metric(&name, value, unit);
    }
    let worst = &tally.reports[tally.worst()];
    let share = worst.trials[0].ours as f64 / worst.trials[0].blobs.max(1) as f64;
    job.metric_at("recognise.worst_view_rate", share, "1", worst.viewpoint.eye.to_array());
    let verdict = verdict::verdict(tally, bench.params);
    for broken in verdict.findings.iter().filter(|f| !f.holds) {
        job.violation(verdict::violation(broken));
    }
    job.write("verdict", "verdict-verify-recognition.json", &verdict.to_json())?;
    job.write("views", "recognition-views.csv", listing::list(tally).as_bytes())?;
    job.write("picture", "recognition.png", &picture::draw(tally, &bench.scene, bench.params))
}
