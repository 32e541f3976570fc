//! `assign-covering`: which site becomes a marker, and which code it blinks, so that every camera can name what it sees.
//!
//! Along the data: rays tell which camera sees which site (`sightlines`); markers and m-sequences are chosen so that every camera sees
//! enough of both, bright enough where it is known what light can come (`light`, `coverage`, `places`); then, with the places fixed, codes are chosen so that markers of one code do not look alike
//! at any roll, also when some are missing (`rings`, `codes`); what the paper's lookup needs is written down (`table`). The paper's
//! way is `assign-genetic`, with the same ports.

mod sightlines;

mod clashes;
mod coverage;
mod light;
mod places;
mod regions;

mod codes;
mod rings;

mod table;

mod annealing;
mod params;

use annealing::best_of_starts;
use clashes::Clashes;
use codes::{Codes, Lit, M_SEQUENCE};
use coverage::{Coverage, SiteLight};
use fibar_core::artefact::Document;
use fibar_core::artefact::bounds::Bounds;
use fibar_core::artefact::constellation::{Constellation, Marker, Pattern};
use fibar_core::artefact::courses::Courses;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::sites::Sites;
use fibar_core::artefact::sockets::Sockets;
use fibar_core::code_set::codes_for;
use fibar_core::images::Images;
use fibar_core::{MarkerId, PatternId};
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use light::Light;
use params::Params;
use places::{Choice, Crowd, Terms};
use regions::Regions;
use rings::{Rings, sites_of};
use sightlines::Sightlines;

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
        .optional_input(
            "bounds",
            "bounds",
            "What light each LED could bring to each site: then that weighs too.",
        )
        .optional_input(
            "courses",
            "courses",
            "By which curves: then fibres are kept out of each other's way, too.",
        )
        .published(
            "constellation",
            "constellation",
            "constellation.json",
            "Markers, codes and the lookup table.",
        )
        .seeded()
        .memory_mb(500) // what pairs of courses cost each other is kept
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        regions::check(&params.regions, params.markers)?;
        let body = TriangleMesh::from_ply(&job.read("body")?)?;
        let sites = seen_sites(&Sites::from_json(&job.read("sites")?)?)?;
        let sockets = Sockets::from_json(&job.read("sockets")?)?;
        let patterns = codes_for(&sockets, params.code_plan())?;
        let bounds = job.read_optional("bounds")?.map(|bytes| Bounds::from_json(&bytes)).transpose()?;
        let seen = sites.sites.len();
        let sites = bounds.as_ref().map_or(Ok(sites.clone()), |bounds| reached_sites(&sites, bounds))?;
        if sites.sites.len() < seen {
            let dark = seen - sites.sites.len();
            job.log("warn", &format!("no LED reaches {dark} of {seen} candidate places: they are left out"));
        }
        let light = bounds.map(|b| Light::new(&b, &sockets, &sites, params.reach_mm)).transpose()?;
        let courses = job.read_optional("courses")?.map(|bytes| Courses::from_json(&bytes)).transpose()?;
        let clashes = courses.map(|c| Clashes::new(&c, &sockets, &sites)).transpose()?;
        let task = Task {
            sites: &sites,
            light: light.as_ref(),
            clashes: clashes.as_ref(),
            codes: patterns.len() as u8,
            params: &params,
        };
        let seed = job.seed();
        job.progress(0.02, "sightlines")?;
        let lines = Sightlines::cast(&body, &sites, &params);
        job.progress(0.1, "places")?;
        let crowd = Crowd::new(&sites, params.spacing_mm);
        let choice = task.choose_places(&lines, &crowd, seed)?;
        job.progress(0.6, "codes")?;
        let chosen = Chosen::new(&choice, &task, seed);
        report(&choice, &chosen, sites.sites.len(), job);
        let constellation = chosen.into_constellation(patterns, &params);
        job.write("constellation", "constellation.json", &constellation.to_json())
    }
}

/// The sites without those that no view sees.
fn seen_sites(sites: &Sites) -> Result<Sites, StageError> {
    let mut seen: Vec<usize> = sites.views.iter().flat_map(|v| &v.visible).map(|&k| k as usize).collect();
    seen.sort_unstable();
    seen.dedup();
    if seen.len() >= POSE_NEEDS {
        return Ok(sites_of(sites, &seen));
    }
    let message = format!(
        "only {} of {} candidate places are seen by any of {} viewpoints; a pose needs {POSE_NEEDS} markers",
        seen.len(),
        sites.sites.len(),
        sites.views.len()
    );
    let hint = "in place-visibility make spacing_mm smaller or emission_limit_deg larger";
    Err(StageError::input(message).hint(hint).place_mm(sites.centre.to_array()))
}

/// The sites without those that no LED reaches.
fn reached_sites(sites: &Sites, bounds: &Bounds) -> Result<Sites, StageError> {
    let is_dark =
        |position| bounds.target_at(position).is_some_and(|t| t.best_mm.iter().all(|mm| *mm == 0.0));
    let (dark, reached): (Vec<usize>, Vec<usize>) =
        (0..sites.sites.len()).partition(|&k| is_dark(sites.sites[k].position));
    if reached.len() >= POSE_NEEDS {
        return Ok(sites_of(sites, &reached));
    }
    let message = format!(
        "only {} of {} candidate places can be reached by any LED; a pose needs {POSE_NEEDS} markers",
        reached.len(),
        sites.sites.len()
    );
    let error = StageError::input(message).hint(
        "move the sockets, scale the body up, or lower min_bend_radius_mm and wall_mm of bound-light and of the router",
    );
    let place = dark.first().map(|&k| sites.sites[k].position);
    Err(place.map_or(error.clone(), |place| error.place_mm(place.to_array())))
}

/// What is to be done.
struct Task<'a> {
    sites: &'a Sites,
    light: Option<&'a Light>,
    clashes: Option<&'a Clashes>,
    codes: u8,
    params: &'a Params,
}

impl<'t> Task<'t> {
    /// The best places of all starts, with an m-sequence in sight from everywhere.
    fn choose_places<'a>(
        &self,
        lines: &'a Sightlines,
        crowd: &'a Crowd,
        seed: u64,
    ) -> Result<Choice<'a>, StageError>
    where
        't: 'a,
    {
        let Task { sites, params, .. } = *self;
        let room = sites.sites.len();
        let wanted = params.markers.map_or(room, |m| m as usize);
        let fair_share = wanted.min(room).div_ceil(usize::from(self.codes));
        let light = self.site_light(fair_share as f64);
        // Without light one code stands for all companions.
        let codes = if light.is_some() { self.codes } else { self.codes.min(M_SEQUENCE + 1) };
        let blank = Coverage::blank(lines, sites, params.missing_share, fair_share, light);
        let regions = Regions::new(&params.regions, sites);
        let terms = Terms { crowd, codes, clashes: self.clashes(), wanted, regions };
        let first = Choice::greedy(blank, terms);
        check_count(first.markers.len(), room, params)?;
        let anneal = |rng| first.clone().anneal(params.place_moves, rng);
        let best = best_of_starts(params.starts, seed, anneal, Choice::cost).unwrap_or(first);
        best.check_regions()?;
        check_blind(&best.coverage, lines, sites, params)?;
        Ok(best)
    }

    /// Whose fibres are in each other's way, and how much that weighs; only with light.
    fn clashes(&self) -> Option<(&'t Clashes, f64)> {
        let weight =
            if self.light.is_some() { self.params.light_weight * self.params.clash_weight } else { 0.0 };
        self.clashes.filter(|_| weight > 0.0).map(|clashes| (clashes, weight))
    }

    /// What each site falls short of, with as many markers on each LED as is fair.
    fn site_light(&self, crowd: f64) -> Option<SiteLight> {
        let light = self.light.filter(|_| self.params.light_weight > 0.0)?;
        let shortage = |k| (M_SEQUENCE..=self.codes).map(|code| light.shortage(k, code, crowd)).collect();
        let shortage = (0..self.sites.sites.len()).map(shortage).collect();
        Some(SiteLight { shortage, weight: self.params.light_weight })
    }
}

fn check_count(found: usize, room: usize, params: &Params) -> Result<(), StageError> {
    let wanted = params.markers.map_or(POSE_NEEDS, |m| m as usize);
    if found >= wanted {
        return Ok(());
    }
    let message = format!(
        "{wanted} markers are wanted, but only {found} of {room} candidate places are {} mm apart",
        params.spacing_mm
    );
    let param = if params.spacing_mm > 0.0 { "/spacing_mm" } else { "/markers" };
    Err(StageError::user(message)
        .param(param)
        .hint("make spacing_mm smaller here or in place-visibility, or ask for fewer markers"))
}

fn check_blind(
    coverage: &Coverage,
    lines: &Sightlines,
    sites: &Sites,
    params: &Params,
) -> Result<(), StageError> {
    let (blind, all) = (coverage.blind_directions(), lines.watch.len());
    if blind.len() as f64 <= params.max_blind_share * all as f64 {
        return Ok(());
    }
    let sites_there = |k: &usize| lines.watched_by.iter().any(|seen| seen.contains(&(*k as u32)));
    let hopeless = blind.iter().filter(|k| !sites_there(k)).count();
    let message = format!(
        "no m-sequence marker is surely in sight from {} of {all} directions; from {hopeless} of them no candidate place is",
        blind.len()
    );
    let hint = "smaller spacing_mm in place-visibility gives more places, a higher lowest_view_deg here asks for fewer views; \
                max_blind_share allows some";
    let camera = sites.centre + lines.watch[blind[0]] * params.farthest_mm;
    Err(StageError::input(message).hint(hint).place_mm(camera.to_array()))
}

/// Markers with their images and codes.
struct Chosen {
    sites: Sites,
    images: Images,
    genes: Vec<u8>,
    confusion: f64,
    /// Mean loss `∫a ds` by clashes.
    clash_loss: f64,
}

impl Chosen {
    /// The best codes of all starts for the markers that were chosen.
    fn new(choice: &Choice, task: &Task, seed: u64) -> Chosen {
        let Task { params, codes: patterns, .. } = *task;
        let mut markers = choice.markers.clone();
        markers.sort_unstable();
        let m_sequence: Vec<bool> = markers.iter().map(|&k| choice.coverage.blinks_m_sequence(k)).collect();
        let sites = sites_of(task.sites, &markers);
        let light = task.light.map(|light| light.of(&markers));
        let images = Images::new(&sites);
        let rings = Rings::collect(&images, params.missing_share, seed);
        let seen_from = rings.seen_from();
        let chosen = markers.iter().filter_map(|&k| choice.coverage.carried(k));
        let has_light = light.is_some() && params.light_weight > 0.0;
        let genes = if has_light { chosen.collect() } else { codes::in_turn(&m_sequence, patterns) };
        let light = light.as_ref().map(|light| (light, params.light_weight));
        let lit = Lit { light, clashes: task.clashes(), sites: &markers };
        let first = Codes::new(&rings, &seen_from, genes, patterns, lit);
        let anneal = |rng| first.clone().anneal(params.code_moves, rng);
        let best = best_of_starts(params.starts, seed, anneal, Codes::cost).unwrap_or(first.clone());
        let (genes, confusion) = (best.genes.clone(), best.confusion());
        let clash_loss = best.clash_loss() / markers.len().max(1) as f64;
        Chosen { sites, images, genes, confusion, clash_loss }
    }

    fn into_constellation(self, patterns: Vec<Pattern>, params: &Params) -> Constellation {
        let table = table::sequences(&self.images, &self.genes, params.sequences as usize);
        let marker = |(k, neighbours): (usize, Vec<Vec<PatternId>>)| Marker {
            id: MarkerId(k as u32 + 1),
            position: self.sites.sites[k].position,
            normal: self.sites.sites[k].normal,
            pattern: PatternId(u32::from(self.genes[k])),
            neighbours,
        };
        let markers = table.into_iter().enumerate().map(marker).collect();
        Constellation::new(params.bit_rate_hz, patterns, markers)
    }
}

fn report(choice: &Choice, chosen: &Chosen, candidates: usize, job: &mut Job) {
    let markers = chosen.genes.len();
    let m_sequences = chosen.genes.iter().filter(|&&g| g == M_SEQUENCE).count();
    job.metric("place.markers", markers as f64, "1");
    job.metric("assign.dropped", (candidates - markers) as f64, "1");
    job.metric("assign.coverage_cost", choice.coverage.cost(), "1");
    job.metric("assign.shortage", choice.coverage.mean_shortage(), "1");
    job.metric("assign.confusion", chosen.confusion, "1");
    job.metric("assign.clash_loss", chosen.clash_loss, "1");
    job.metric("assign.m_sequences", m_sequences as f64, "1");
    job.metric("assign.blind_directions", choice.coverage.blind_directions().len() as f64, "1");
}

fn main() -> std::process::ExitCode {
    serve::<AssignCovering>()
}

#[cfg(test)]
mod tests;
