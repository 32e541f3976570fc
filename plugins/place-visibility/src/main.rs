//! `place-visibility`: candidate places for markers (Tone 2020, "Marker placement").
//!
//! Along the data: the surface is sampled evenly, places where no fibre can arrive are struck out, every other one gets
//! its suitability `s(p)` from rays to viewpoints all around, local maxima of `s` become candidates, and what each
//! viewpoint sees of them is written down for the assignment of codes. Which candidate becomes a marker is decided there.

mod candidates;
mod cells;
mod keepout;
mod params;
mod parts;
mod picture;
mod suitability;
mod surface;

use candidates::select_candidates;
use fibar_core::artefact::Document;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::parts::Parts;
use fibar_core::artefact::sites::{Site, Sites};
use fibar_core::artefact::sockets::Sockets;
use fibar_geometry::distance::Surface;
use fibar_geometry::rays::RayScene;
use fibar_geometry::sampling::{SurfaceSample, sample_surface, surface_area};
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use glam::DVec3;
use keepout::{KeepOut, Solid};
use params::Params;
use parts::ForbiddenParts;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use suitability::Outlook;

struct PlaceVisibility;

impl Stage for PlaceVisibility {
    type Params = Params;

    fn describe() -> Description {
        Description::new("place-visibility", "Finds places for markers that cameras all around see well.")
            .version(env!("CARGO_PKG_VERSION"))
            .input("body", "body", "The closed body, base at z = 0, mm.")
            .input(
                "sockets",
                "sockets",
                "The LEDs: no marker sits so low that its fibre would have to turn back.",
            )
            .optional_input("mesh", "mesh", "What the parts are parts of.")
            .optional_input("parts", "parts", "Parts of the source, some of which may be kept free.")
            .output("sites", "sites", "Candidate places, and what every viewpoint sees of them.")
            .published("picture", "picture", "visibility.png", "s(p) on the object, and the candidates.")
            .seeded()
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let body = TriangleMesh::from_ply(&job.read("body")?)?;
        let sockets = Sockets::from_json(&job.read("sockets")?)?;
        let parts = find_parts(&body, &params, job)?;
        let seed = job.seed();
        let placed = place(&body, &sockets, parts, &params, seed, &mut |fraction, phase| {
            job.progress(fraction, phase)
        })?;
        let Placed { sites, samples, suitability } = placed;
        report(&sites, job);
        job.write("sites", "sites.json", &sites.to_json())?;
        job.write("picture", "visibility.png", &picture::draw(&body, &samples, &suitability, &sites))
    }
}

fn find_parts(body: &TriangleMesh, params: &Params, job: &Job) -> Result<ForbiddenParts, StageError> {
    let (Some(mesh), Some(parts)) = (job.read_optional("mesh")?, job.read_optional("parts")?) else {
        return ForbiddenParts::find(&params.keep_out_parts, None, body);
    };
    let (mesh, parts) = (TriangleMesh::from_ply(&mesh)?, Parts::from_json(&parts)?);
    ForbiddenParts::find(&params.keep_out_parts, Some((&mesh, &parts)), body)
}

/// Says how far the work is; an error when it must stop.
type Progress<'a> = &'a mut dyn FnMut(f64, &str) -> Result<(), StageError>;

/// The candidates, and the rated samples that they were chosen from.
struct Placed {
    sites: Sites,
    samples: Vec<SurfaceSample>,
    /// `s(p)` of every sample, rad; 0 where no marker may sit.
    suitability: Vec<f64>,
}

fn place(
    body: &TriangleMesh,
    sockets: &Sockets,
    parts: ForbiddenParts,
    params: &Params,
    seed: u64,
    progress: Progress,
) -> Result<Placed, StageError> {
    let outlook = Outlook::new(body, params)?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let samples = sample_surface(body, params.samples as usize, params.crease_deg.to_radians(), &mut rng);
    if samples.is_empty() {
        return Err(
            StageError::input("the body has no surface").hint("look at body.ply: it should hold the object")
        );
    }
    let surface = Surface::new(body).map_err(|e| StageError::input(e.to_string()))?;
    let solid = Solid { scene: RayScene::new(body), surface };
    let scene = &solid.scene;
    progress(0.05, "keep-outs")?;
    let open = KeepOut::new(&solid, sockets, params, parts).open_samples(&samples)?;
    let suitability = rate_samples(&samples, &open, &outlook, scene, progress)?;
    progress(0.85, "candidates")?;
    let grain = (surface_area(body) / samples.len() as f64).sqrt();
    let chosen = select_candidates(&samples, &suitability, grain, params, &mut rng);
    check_count(chosen.len(), body, params)?;
    let site = |&k: &usize| Site {
        position: samples[k].position,
        normal: samples[k].normal,
        suitability_rad: suitability[k],
    };
    let chosen_samples: Vec<SurfaceSample> = chosen.iter().map(|&k| samples[k]).collect();
    let views = outlook.views(&chosen_samples, scene, params.emission_limit_deg.to_radians());
    let sites = Sites::new(outlook.centre(), chosen.iter().map(site).collect(), views);
    Ok(Placed { sites, samples, suitability })
}

/// `s(p)` of every sample, rad; 0 for those struck out.
fn rate_samples(
    samples: &[SurfaceSample],
    open: &[usize],
    outlook: &Outlook,
    scene: &RayScene,
    progress: Progress,
) -> Result<Vec<f64>, StageError> {
    const PORTION: usize = 2000;
    let mut suitability = vec![0.0; samples.len()];
    for (k, portion) in open.chunks(PORTION).enumerate() {
        progress(0.1 + 0.75 * (k * PORTION) as f64 / open.len() as f64, "visibility")?;
        for (&sample, s) in portion.iter().zip(outlook.suitability(samples, portion, scene)) {
            suitability[sample] = s;
        }
    }
    if suitability.iter().all(|&s| s == 0.0) {
        return Err(StageError::input("no place that a fibre could reach is visible from any viewpoint")
            .place_mm(outlook.centre().to_array())
            .hint("is the body inside out, or closed in by another surface? Look at body.ply"));
    }
    Ok(suitability)
}

fn check_count(count: usize, body: &TriangleMesh, params: &Params) -> Result<(), StageError> {
    const POSE_NEEDS: usize = 4;
    if count >= POSE_NEEDS {
        return Ok(());
    }
    let (low, high) = body.bounds().unwrap_or((DVec3::ZERO, DVec3::ZERO));
    let size = high - low;
    let message = format!(
        "only {count} candidate places are {} mm apart on a body of {:.0} × {:.0} × {:.0} mm; a pose needs at least {POSE_NEEDS}",
        params.spacing_mm, size.x, size.y, size.z
    );
    Err(StageError::user(message).param("/spacing_mm").hint("make spacing_mm smaller, or the object larger"))
}

fn report(sites: &Sites, job: &mut Job) {
    let count = sites.sites.len() as f64;
    let total: f64 = sites.sites.iter().map(|s| s.suitability_rad).sum();
    let seen = || sites.views.iter().map(|v| v.visible.len());
    job.metric("place.candidates", count, "1");
    job.metric("place.mean_s", total / count, "rad");
    job.metric("place.mean_visible", seen().sum::<usize>() as f64 / sites.views.len() as f64, "1");
    job.metric("place.least_visible", seen().min().unwrap_or(0) as f64, "1");
}

fn main() -> std::process::ExitCode {
    serve::<PlaceVisibility>()
}

#[cfg(test)]
mod tests;
