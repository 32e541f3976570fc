//! `assign-covering`: which site becomes a marker, and which code it blinks, so that every camera can name what it sees.
//!
//! Along the data: rays tell which camera sees which site (`sightlines`); markers and m-sequences are chosen so that every camera sees
//! enough of both (`coverage`, `places`); then, with the places fixed, codes are chosen so that markers of one code do not look alike
//! at any roll, also when some are missing (`rings`, `codes`). The paper's way is `assign-genetic`, with the same ports.

mod annealing;
mod codes;
mod coverage;
mod params;
mod places;
mod rings;
mod sightlines;

use codes::{Codes, M_SEQUENCE};
use coverage::{Blink, Coverage};
use fibar_core::artefact::Document;
use fibar_core::artefact::constellation::{Constellation, Marker, Pattern};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::sites::Sites;
use fibar_core::artefact::sockets::Sockets;
use fibar_core::code_set::codes_for;
use fibar_core::images::Images;
use fibar_core::{MarkerId, PatternId};
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use params::Params;
use places::{Choice, Crowd};
use rayon::prelude::*;
use rings::Rings;
use sightlines::Sightlines;
use std::collections::BTreeMap;

/// A pose needs as many markers.
const POSE_NEEDS: usize = 4;

struct AssignCovering;

impl Stage for AssignCovering {
    type Params = Params;

    fn describe() -> Description {
        Description::new(
            "assign-covering",
            "Chooses markers and codes so that every camera can name what it sees.",
        )
        .version(env!("CARGO_PKG_VERSION"))
        .input("body", "body", "What hides markers.")
        .input("sites", "sites", "Candidate places; their views make the lookup table.")
        .input("sockets", "sockets", "The LEDs: one code each.")
        .published(
            "constellation",
            "constellation",
            "constellation.json",
            "Markers, codes and the lookup table.",
        )
        .seeded()
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let body = TriangleMesh::from_ply(&job.read("body")?)?;
        let sites = Sites::from_json(&job.read("sites")?)?;
        let patterns = codes_for(&Sockets::from_json(&job.read("sockets")?)?, params.code_plan())?;
        let seed = job.seed();
        job.progress(0.02, "sightlines")?;
        let lines = Sightlines::cast(&body, &sites, &params);
        job.progress(0.1, "places")?;
        let choice = choose_places(&lines, &sites, patterns.len(), &params, seed)?;
        job.progress(0.6, "codes")?;
        let chosen = choose_codes(&choice, &sites, patterns.len() as u8, &params, seed);
        report(&choice, &chosen, &sites, job);
        let constellation = name_markers(&chosen, patterns, &params);
        job.write("constellation", "constellation.json", &constellation.to_json())
    }
}

/// The best of all starts.
fn choose_places<'a>(
    lines: &'a Sightlines,
    sites: &Sites,
    patterns: usize,
    params: &Params,
    seed: u64,
) -> Result<Choice<'a>, StageError> {
    let crowd: &Crowd = Box::leak(Box::new(Crowd::new(sites, params.spacing_mm)));
    let wanted = params.markers.map_or(sites.sites.len(), |m| m as usize);
    let fair = wanted.div_ceil(patterns);
    let first = Choice::greedy(Coverage::blank(lines, sites, params.missing_share, fair), crowd, wanted);
    let starts = (0..params.starts).into_par_iter();
    let found: Vec<Choice> = starts.map(|start| first.clone().anneal(params, seed, start)).collect();
    let cheapest = |a: Choice<'a>, b: Choice<'a>| if b.coverage.cost() < a.coverage.cost() { b } else { a };
    Ok(found.into_iter().reduce(cheapest).unwrap_or(first))
}

/// Markers with their images and codes.
struct Chosen {
    sites: Sites,
    images: Images,
    genes: Vec<u8>,
    confusion: f64,
}

fn choose_codes(choice: &Choice, sites: &Sites, patterns: u8, params: &Params, seed: u64) -> Chosen {
    let mut markers = choice.markers.clone();
    markers.sort_unstable();
    let m: Vec<bool> =
        markers.iter().map(|&k| choice.coverage.carried(k) == Some(Blink::MSequence)).collect();
    let sites = rings::sites_of(sites, &markers);
    let images = Images::new(&sites);
    let rings = Rings::collect(&images, params.missing_share, seed);
    let seen_from = rings.seen_from();
    let first = Codes::new(&rings, &seen_from, codes::in_turn(&m, patterns), patterns);
    let starts = (0..params.starts).into_par_iter();
    let found: Vec<Codes> = starts.map(|start| first.clone().anneal(params, seed, start)).collect();
    let cheapest = |a: Codes, b: Codes| -> bool { b.cost() < a.cost() };
    let mut best = first.clone();
    for codes in found {
        if cheapest(best.clone(), codes.clone()) {
            best = codes;
        }
    }
    let (genes, confusion) = (best.genes.clone(), best.confusion());
    Chosen { sites, images, genes, confusion }
}

fn name_markers(chosen: &Chosen, patterns: Vec<Pattern>, params: &Params) -> Constellation {
    let mut seen = vec![BTreeMap::<Vec<PatternId>, usize>::new(); chosen.sites.sites.len()];
    for image in &chosen.images.views {
        let all: Vec<usize> = (0..image.sites.len()).collect();
        for (marker, ring) in rings::neighbours(image, &all) {
            let sequence = ring.iter().map(|&m| PatternId(u32::from(chosen.genes[m]))).collect();
            *seen[marker].entry(sequence).or_default() += 1;
        }
    }
    let marker = |k: usize| {
        let mut counted: Vec<(&Vec<PatternId>, &usize)> = seen[k].iter().collect();
        counted.sort_by(|a, b| b.1.cmp(a.1).then_with(|| a.0.cmp(b.0)));
        Marker {
            id: MarkerId(k as u32 + 1),
            position: chosen.sites.sites[k].position,
            normal: chosen.sites.sites[k].normal,
            pattern: PatternId(u32::from(chosen.genes[k])),
            neighbours: counted.iter().take(params.sequences as usize).map(|(s, _)| (*s).clone()).collect(),
        }
    };
    Constellation::new(params.bit_rate_hz, patterns, (0..chosen.genes.len()).map(marker).collect())
}

fn report(choice: &Choice, chosen: &Chosen, sites: &Sites, job: &mut Job) {
    job.metric("place.markers", chosen.genes.len() as f64, "1");
    job.metric("assign.dropped", (sites.sites.len() - chosen.genes.len()) as f64, "1");
    job.metric("assign.coverage_cost", choice.coverage.cost(), "1");
    job.metric("assign.confusion", chosen.confusion, "1");
    job.metric("assign.m_sequences", chosen.genes.iter().filter(|&&g| g == M_SEQUENCE).count() as f64, "1");
    job.metric("assign.blind_directions", choice.coverage.blind_directions().len() as f64, "1");
}

fn main() -> std::process::ExitCode {
    serve::<AssignCovering>()
}
