//! How far away a camera still sees each fibre: the monotone law of light on the exact curve, the LEDs' light as their
//! fibres share it, and from how far the object can be tracked by it.
//!
//! Independent of every router: the curve comes from `routes.json` alone and is evaluated by `fibar-ruler`. docs/optics.md
//! says what the model of light assumes.

mod attenuation;
mod law;

mod beam;
mod discs;
mod sharing;

mod reach;

mod params;
mod sight;
mod summary;

use fibar_core::LedId;
use fibar_core::artefact::Document;
use fibar_core::artefact::bounds::Bounds;
use fibar_core::artefact::constellation::Constellation;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::routes::{Fibre, Routes};
use fibar_core::artefact::sockets::Sockets;
use fibar_plugin::{Description, Job, Stage, StageError, Violation, serve};
use fibar_ruler::curve::Curve;
use fibar_ruler::surface::ClosedSurface;
use law::MonotoneLaw;
use params::Params;
use sharing::Member;
use sight::Sight;
use std::collections::BTreeMap;
use summary::{Range, Summary};

struct VerifyLight;

impl Stage for VerifyLight {
    type Params = Params;

    fn describe() -> Description {
        Description::new(
            "verify-light",
            "Measures from how far a camera sees each fibre (monotone law, exact curve, shared light), and the object.",
        )
        .version(env!("CARGO_PKG_VERSION"))
        .input("routes", "routes", "The fibres.")
        .input("sockets", "sockets", "The LEDs that feed them.")
        .optional_input("body", "body", "What hides markers; with `constellation`, gives the range of tracking.")
        .optional_input("constellation", "constellation", "Where the markers look.")
        .optional_input("bounds", "bounds", "What each pair of LED and marker could reach, alone.")
        .published(
            "verdict",
            "verdict",
            "verdict-verify-light.json",
            "Every fibre's reach, the weakest first.",
        )
        .seeded()
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let law = MonotoneLaw::of(params.law());
        let sights = look(&params, &law, job)?;
        job.progress(0.3, "range")?;
        let range = find_range(&sights, &params, job)?;
        let summary = Summary::of(sights);
        report_metrics(&summary, &params, job);
        report_bounds(&summary, job);
        if let Some(range) = &range {
            job.metric("light.track_range_mm", range.coupled_mm, "mm");
            job.metric("light.track_range_half_mm", range.half_mm, "mm");
            job.metric("light.track_range_uncoupled_mm", range.uncoupled_mm, "mm");
        }
        let verdict = summary.verdict(&law, &params, range.as_ref());
        for broken in verdict.findings.iter().filter(|f| !f.holds) {
            job.violation(violation(broken, &summary));
        }
        job.write("verdict", "verdict-verify-light.json", &verdict.to_json())
    }
}

/// Every fibre's reach, in order of the routes.
fn look(params: &Params, law: &MonotoneLaw, job: &Job) -> Result<Vec<Sight>, StageError> {
    let routes = Routes::from_json(&job.read("routes")?)?;
    let sockets = Sockets::from_json(&job.read("sockets")?)?;
    if routes.fibres.is_empty() {
        return Err(StageError::input("there is no fibre to measure"));
    }
    let curves: Result<Vec<Curve>, String> = routes.fibres.iter().map(Curve::of_fibre).collect();
    let curves = curves.map_err(StageError::input)?;
    let pairs = routes.fibres.iter().zip(&curves);
    let mut sights: Vec<Sight> = pairs.map(|(fibre, curve)| Sight::of(fibre, curve, law)).collect();
    share_light(&mut sights, &routes.fibres, &curves, &sockets, params)?;
    if let Some(bytes) = job.read_optional("bounds")? {
        let bounds = Bounds::from_json(&bytes)?;
        if bounds.law != params.law() {
            return Err(StageError::user("the bounds were made with another law of light")
                .hint("include one material profile, which both stages take their law from"));
        }
        sights.iter_mut().for_each(|sight| sight.compare(&bounds));
    }
    Ok(sights)
}

/// Gives every fibre its share of its LED's light.
fn share_light(
    sights: &mut [Sight],
    fibres: &[Fibre],
    curves: &[Curve],
    sockets: &Sockets,
    params: &Params,
) -> Result<(), StageError> {
    let mut leds: BTreeMap<LedId, Vec<usize>> = BTreeMap::new();
    fibres.iter().enumerate().for_each(|(k, fibre)| leds.entry(fibre.led).or_default().push(k));
    let beam = beam::Beam::of(&params.led());
    for (led, members) in leds {
        let Some(socket) = sockets.sockets.iter().find(|socket| socket.led == led) else {
            let message = format!("fibre {} is fed by LED {led}, which has no socket", fibres[members[0]].id);
            return Err(StageError::input(message).place_mm(curves[members[0]].start().to_array()));
        };
        let member = |&k: &usize| Member::of(&curves[k], fibres[k].radii_mm.core);
        let couplings = sharing::couplings(&beam, socket, members.iter().map(member).collect());
        members.iter().zip(couplings).for_each(|(&k, coupling)| sights[k].coupling = coupling);
    }
    Ok(())
}

/// The range of tracking, where body and constellation are given.
fn find_range(sights: &[Sight], params: &Params, job: &Job) -> Result<Option<Range>, StageError> {
    const SHOWN_MM: [f64; 4] = [500.0, 1000.0, 1500.0, 2000.0];
    let (body, constellation) = (job.read_optional("body")?, job.read_optional("constellation")?);
    let Some((body, constellation)) = body.zip(constellation) else { return Ok(None) };
    let body = TriangleMesh::from_ply(&body)?;
    let constellation = Constellation::from_json(&constellation)?;
    let (low, high) = body.bounds().ok_or_else(|| StageError::input("the body is empty"))?;
    let markers: Result<Vec<usize>, StageError> =
        sights.iter().map(|s| index_of(s, &constellation)).collect();
    let surface = ClosedSurface::of(&body);
    let views = params.views(job.seed());
    let stage = reach::Stage::of(&surface, (low + high) / 2.0, &constellation, &markers?, views);
    let coupled: Vec<f64> = sights.iter().map(Sight::coupled_d_cam_mm).collect();
    let uncoupled: Vec<f64> = sights.iter().map(|s| s.d_cam_mm).collect();
    Ok(Some(Range {
        coupled_mm: stage.range(&coupled, reach::MOST),
        half_mm: stage.range(&coupled, 0.5),
        uncoupled_mm: stage.range(&uncoupled, reach::MOST),
        shares: SHOWN_MM.map(|distance| (distance, stage.share(&coupled, distance))).into(),
    }))
}

fn index_of(sight: &Sight, constellation: &Constellation) -> Result<usize, StageError> {
    let found = constellation.markers.binary_search_by_key(&sight.marker, |marker| marker.id);
    found.map_err(|_| {
        let message =
            format!("fibre {} leads to marker {}, which the constellation lacks", sight.fibre, sight.marker);
        StageError::input(message).place_mm(sight.end.to_array())
    })
}

fn report_metrics(summary: &Summary, params: &Params, job: &mut Job) {
    let (worst, dim) = (summary.worst(), summary.worst_coupled());
    let coupled = Sight::coupled_d_cam_mm;
    job.metric("light.fibres", summary.sights.len() as f64, "1");
    job.metric("light.mean_d_cam_mm", summary.mean(|s| s.d_cam_mm), "mm");
    job.metric("light.mean_d_cam_uncertainty_mm", summary.mean_uncertainty_mm(params), "mm");
    job.metric("light.p10_d_cam_mm", summary.tenth_percentile(|s| s.d_cam_mm), "mm");
    job.metric_at("light.worst_d_cam_mm", worst.d_cam_mm, "mm", worst.end.to_array());
    job.metric("light.mean_d_cam_coupled_mm", summary.mean(coupled), "mm");
    job.metric("light.p10_d_cam_coupled_mm", summary.tenth_percentile(coupled), "mm");
    job.metric_at("light.worst_d_cam_coupled_mm", dim.coupled_d_cam_mm(), "mm", dim.end.to_array());
    job.metric("light.mean_coupling", summary.mean(|s| s.coupling), "1");
    job.metric("light.mean_d_cam_printed_law_mm", summary.mean(|s| s.printed_d_cam_mm), "mm");
    job.metric("light.share_over_700mm", summary.well_lit_share(|s| s.d_cam_mm), "1");
    job.metric("light.share_over_700mm_coupled", summary.well_lit_share(coupled), "1");
    job.metric("light.length_below_20mm_share", summary.tight_share(), "1");
    job.metric("light.mean_length_mm", summary.mean(|s| s.attenuation.length_mm), "mm");
}

fn report_bounds(summary: &Summary, job: &mut Job) {
    if let Some(share) = summary.mean_known(Sight::bound_share) {
        job.metric("light.bound_share", share, "1");
    }
    if let Some(share) = summary.mean_known(Sight::certified_share) {
        job.metric("light.certified_share", share, "1");
    }
}

fn violation(broken: &fibar_core::artefact::verdict::Finding, summary: &Summary) -> Violation {
    let bound = broken.bound.unwrap_or(0.0);
    let message = match broken.rule.as_str() {
        "light.reach" => format!(
            "{} of {} fibres are seen from less than {bound} mm; the weakest is fibre {} with {:.0} mm",
            summary.darker_than(bound),
            summary.sights.len(),
            summary.worst().fibre,
            broken.value
        ),
        _ => broken.message.clone(),
    };
    let place_mm = broken.places.first().map(|place| place.position.to_array());
    Violation { rule: broken.rule.clone(), message, place_mm }
}

fn main() -> std::process::ExitCode {
    serve::<VerifyLight>()
}
