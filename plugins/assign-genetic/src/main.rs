//! `assign-genetic`: which site becomes a marker, and which code it blinks (Tone 2020, "Marker placement").
//!
//! Along the data: sites are projected into the images of all viewpoints (`fibar_core::images`), neighbours in them are found by
//! Delaunay triangulation (`topology`), an assignment is judged by the paper's objective (`objective`) and improved by a
//! genetic algorithm (`genetic`). What a code is, who is a neighbour and how a name is looked up is defined in
//! `fibar-core`; the evaluation here gives the same answers sooner, which its tests check against those definitions.

mod genetic;
mod lists;
mod objective;
mod params;
mod reading;
mod topology;

use fibar_core::artefact::Document;
use fibar_core::artefact::constellation::{Constellation, Marker, Pattern};
use fibar_core::artefact::sites::Sites;
use fibar_core::artefact::sockets::Sockets;
use fibar_core::code_set::codes_for;
use fibar_core::images::Images;
use fibar_core::{MarkerId, PatternId};
use fibar_picture::Chart;
use fibar_picture::colour::hue;
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use genetic::Found;
use glam::DVec2;
use objective::Evaluated;
use params::Params;

/// A pose needs as many markers.
const POSE_NEEDS: usize = 4;

struct AssignGenetic;

impl Stage for AssignGenetic {
    type Params = Params;

    fn describe() -> Description {
        Description::new(
            "assign-genetic",
            "Assigns a blink code to each marker so that neighbours tell its name.",
        )
        .version(env!("CARGO_PKG_VERSION"))
        .input("sites", "sites", "Candidate places, and what every viewpoint sees of them.")
        .input("sockets", "sockets", "The LEDs: one code each.")
        .published(
            "constellation",
            "constellation",
            "constellation.json",
            "Markers, codes and the lookup table.",
        )
        .published("picture", "picture", "objective.png", "The best objective after each iteration.")
        .seeded()
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let sites = Sites::from_json(&job.read("sites")?)?;
        let codes = codes_for(&Sockets::from_json(&job.read("sockets")?)?, params.code_plan())?;
        let images = take_images(&sites)?;
        let seed = job.seed();
        let found = genetic::search(&images, codes.len() as u8, &params, seed, |iterations, objective| {
            let done = iterations as f64 / (iterations as f64 + f64::from(params.stop_after));
            job.progress(done, &format!("objective {objective:.0}"))
        })?;
        report(&found, &images, job);
        let constellation = name_markers(&found.best, &images, codes, params.bit_rate_hz)?;
        job.write("picture", "objective.png", &draw_history(&found.history))?;
        job.write("constellation", "constellation.json", &constellation.to_json())
    }
}

/// The images of all viewpoints, with enough in them for a pose.
fn take_images(sites: &Sites) -> Result<Images, StageError> {
    let images = Images::new(sites);
    let count = images.sites.len();
    if count < POSE_NEEDS {
        let message = format!(
            "only {count} of {} candidate places are seen by any of {} viewpoints; a pose needs {POSE_NEEDS} markers",
            sites.sites.len(),
            sites.views.len()
        );
        let hint = "in place-visibility make spacing_mm smaller or emission_limit_deg larger";
        return Err(StageError::input(message).hint(hint).place_mm(sites.centre.to_array()));
    }
    Ok(images)
}

/// The constellation of the sites that carry a marker, in order of site.
fn name_markers(
    best: &Evaluated,
    images: &Images,
    codes: Vec<Pattern>,
    bit_rate_hz: f64,
) -> Result<Constellation, StageError> {
    let pattern = |gene: u8| PatternId(u32::from(gene));
    let kept = (0..best.genes.len()).filter(|&k| best.genes[k] != 0);
    let marker = |(id, k): (u32, usize)| Marker {
        id: MarkerId(id),
        position: images.sites[k].position,
        normal: images.sites[k].normal,
        pattern: pattern(best.genes[k]),
        neighbours: best
            .table_entry(k)
            .map(|s| s.iter().map(|&g| pattern(g)).collect())
            .into_iter()
            .collect(),
    };
    let markers: Vec<Marker> = (1..).zip(kept).map(marker).collect();
    if markers.len() < POSE_NEEDS {
        let message =
            format!("the objective keeps only {} markers; a pose needs {POSE_NEEDS}", markers.len());
        return Err(StageError::user(message).param("/k1").hint("a smaller k1 costs wrong names less"));
    }
    Ok(Constellation::new(bit_rate_hz, codes, markers))
}

/// The best objective after each iteration, as a PNG.
fn draw_history(history: &[f64]) -> Vec<u8> {
    let points = (0..).zip(history).map(|(k, &objective)| DVec2::new(f64::from(k), objective));
    let chart = Chart {
        title: "assign-genetic",
        x: "iteration",
        y: "best objective",
        curves: vec![("best objective", hue(0), points.collect())],
    };
    chart.draw(900, 520).to_png()
}

fn report(found: &Found, images: &Images, job: &mut Job) {
    let best = &found.best;
    let markers = best.genes.iter().filter(|&&g| g != 0).count();
    let tallies = best.tallies(images);
    let views = tallies.len() as f64;
    let right: u32 = tallies.iter().map(|t| t.right).sum();
    let wrong: u32 = tallies.iter().map(|t| t.wrong).sum();
    let with_m_sequence = tallies.iter().filter(|t| t.m_sequence > 0).count() as f64;
    job.metric("place.markers", markers as f64, "1");
    job.metric("assign.objective", best.objective, "1");
    job.metric("assign.iterations", (found.history.len() - 1) as f64, "1");
    job.metric("assign.dropped", (best.genes.len() - markers) as f64, "1");
    job.metric("assign.named_share", f64::from(right) / f64::from((right + wrong).max(1)), "1");
    job.metric("assign.views_mseq_share", with_m_sequence / views, "1");
}

fn main() -> std::process::ExitCode {
    serve::<AssignGenetic>()
}

#[cfg(test)]
mod tests;
