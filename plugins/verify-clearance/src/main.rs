//! Gaps between fibres, walls to the skin, bend radii and ends: certificates on the exact curves.
//!
//! Every value is a bound that the exact NURBS curves cannot undercut, found by enclosing them in capsules and descending
//! where something nearer may hide; it is at most [`CURVE_TOLERANCE_MM`] (twice that between two fibres) too strict.
//! Nothing is shared with the stages that made the routes. docs/verification.md says what is measured between what.

mod bend;
mod bernstein;
mod ends;
mod gap;
mod judgement;
#[cfg(test)]
mod mutation;
mod socket_gap;
mod strand;
mod wall;

use fibar_core::artefact::Document;
use fibar_core::artefact::constellation::Constellation;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::routes::Routes;
use fibar_core::artefact::sockets::Sockets;
use fibar_core::artefact::verdict::Verdict;
use fibar_core::material::SKIN_THICKNESS_MM;
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use fibar_ruler::surface::ClosedSurface;
use judgement::Judgement;
use strand::Strand;

/// How much a measured distance may be stricter than the exact one, per curve, mm.
const CURVE_TOLERANCE_MM: f64 = 5e-4;

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// Least distance between the outer surfaces of fibres of different patterns.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm"))]
    min_gap_mm: f64,
    /// Least distance from a fibre's outer surface to the skin's inner side, away from the ends.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm"))]
    min_wall_mm: f64,
    /// Least distance from a fibre's outer surface to the hole of another LED, and to a cavity.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm"))]
    min_socket_gap_mm: f64,
    /// Least bend radius of a fibre's axis.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "mm"))]
    min_bend_radius_mm: f64,
    /// Thickness of the skin under the outer surface.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "mm"))]
    skin_mm: f64,
    /// Length of the fixed leg at either end. Walls are measured from the end of the LED's leg up to where, before the
    /// marker, this leg and the fibre's own radius and the skin remain: nearer to its end a fibre must meet the surface.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm"))]
    end_leg_mm: f64,
    /// How far a fibre may start from its LED's tip or end from the surface.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "mm"))]
    end_tolerance_mm: f64,
    /// How far beside its LED's tip a fibre may start, in the plane of the tip: with a core of 0.875 mm, up to this its mouth
    /// lies under the dome of a 5 mm package.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm"))]
    mouth_offset_mm: f64,
    /// How far a fibre may start off its socket's axis.
    #[schemars(range(min = 0.0, max = 90.0), extend("unit" = "deg"))]
    start_tilt_deg: f64,
    /// How far a fibre may arrive off its marker's outward normal (the body's, without `constellation`); 180 judges nothing.
    #[schemars(range(min = 0.0, max = 180.0), extend("unit" = "deg"))]
    arrival_tilt_deg: f64,
}

impl Default for Params {
    fn default() -> Params {
        Params {
            min_gap_mm: 0.0,
            min_wall_mm: 0.0,
            min_socket_gap_mm: 0.0,
            min_bend_radius_mm: 0.0,
            skin_mm: SKIN_THICKNESS_MM,
            end_leg_mm: 2.5,
            end_tolerance_mm: 0.01,
            mouth_offset_mm: 1.625,
            start_tilt_deg: 1.0,
            arrival_tilt_deg: 180.0,
        }
    }
}

struct VerifyClearance;

impl Stage for VerifyClearance {
    type Params = Params;

    fn describe() -> Description {
        Description::new(
            "verify-clearance",
            "Certifies gaps, walls, bend radii and ends of the fibres' exact curves.",
        )
        .version(env!("CARGO_PKG_VERSION"))
        .input("body", "body", "The object that the fibres must stay inside of.")
        .input("sockets", "sockets", "Where the fibres start.")
        .input("routes", "routes", "The fibres.")
        .optional_input(
            "constellation",
            "constellation",
            "Where the markers look; else the body's surface says.",
        )
        .published(
            "verdict",
            "verdict",
            "verdict-verify-clearance.json",
            "Every rule with its tightest places.",
        )
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let body = ClosedSurface::of(&TriangleMesh::from_ply(&job.read("body")?)?);
        let sockets = Sockets::from_json(&job.read("sockets")?)?;
        let routes = Routes::from_json(&job.read("routes")?)?;
        let strands: Result<Vec<Strand>, StageError> = routes.fibres.iter().map(Strand::of).collect();
        let strands = strands?;
        if strands.is_empty() {
            return Err(StageError::input("there is no fibre to measure"));
        }
        let constellation = job.read_optional("constellation")?;
        let constellation = constellation.map(|bytes| Constellation::from_json(&bytes)).transpose()?;
        let scene = Scene { body: &body, sockets: &sockets, constellation: constellation.as_ref() };
        let judgements = measure(&params, &scene, &strands, job)?;
        for judgement in &judgements {
            judgement.report(job);
        }
        let findings = judgements.into_iter().map(|judgement| judgement.finding).collect();
        let verdict = Verdict::new("verify-clearance", findings);
        job.write("verdict", "verdict-verify-clearance.json", &verdict.to_json())
    }
}

/// What the fibres are held against.
struct Scene<'a> {
    body: &'a ClosedSurface,
    sockets: &'a Sockets,
    constellation: Option<&'a Constellation>,
}

/// All rules, one after the other.
fn measure(
    params: &Params,
    scene: &Scene,
    strands: &[Strand],
    job: &mut Job,
) -> Result<Vec<Judgement>, StageError> {
    job.progress(0.0, "gaps")?;
    let gaps = gap::judge(strands, params.min_gap_mm);
    job.progress(0.4, "walls")?;
    let walls = wall::judge(strands, scene.body, &wall::Rule::of(params));
    job.progress(0.8, "sockets and bends")?;
    let socket_gaps = socket_gap::judge(strands, scene.sockets, params.min_socket_gap_mm);
    let cavity_gaps = socket_gap::judge_cavities(strands, scene.sockets, params.min_socket_gap_mm);
    let bends = bend::judge(strands, params.min_bend_radius_mm);
    let ends = ends::judge(strands, scene, &ends::Rule::of(params));
    Ok([gaps, walls, socket_gaps, cavity_gaps, bends, ends].into_iter().flatten().collect())
}

fn main() -> std::process::ExitCode {
    serve::<VerifyClearance>()
}
