//! `route-fibar`: the paper's routing of the fibres (Tone 2020, "3D Printed Optical Fibers").
//!
//! [`initial`] bends a chain of control points per fibre from LED to marker, [`refine`] improves all of them by Adam on
//! [`objective`]. What the paper leaves open is a parameter ([`params`]) and told in `docs/route-fibar.md`. Nothing here
//! guarantees that fibres keep clear of each other or of the skin; `verify-clearance` says how they do.

mod params;

mod ends;

mod bundle;
mod foreign;
mod initial;
mod interior;
mod moves;
mod neighbours;

mod adam;
mod objective;
#[cfg(test)]
mod reference;
mod refine;
mod wall;

mod history;

use bundle::Bundle;
use fibar_core::artefact::Document;
use fibar_core::artefact::constellation::Constellation;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::routes::Routes;
use fibar_core::artefact::sockets::Sockets;
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use history::History;
use interior::Interior;
use objective::Objective;
use params::Params;
use refine::Refined;

struct RouteFibar;

impl Stage for RouteFibar {
    type Params = Params;

    fn describe() -> Description {
        Description::new(
            "route-fibar",
            "Routes every fibre as Tone et al. 2020 do: heuristic moves, then Adam.",
        )
        .version(env!("CARGO_PKG_VERSION"))
        .input("body", "body", "The closed body, mm.")
        .input("sockets", "sockets", "Where the LEDs sit and what they blink.")
        .input("constellation", "constellation", "The markers and their patterns.")
        .published("routes", "routes", "routes.json", "A NURBS curve per fibre, from LED to marker.")
        .published(
            "history",
            "table",
            "route-history.csv",
            "Every term of the objective at every iteration.",
        )
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let body = TriangleMesh::from_ply(&job.read("body")?)?;
        let sockets = Sockets::from_json(&job.read("sockets")?)?;
        let constellation = Constellation::from_json(&job.read("constellation")?)?;
        params.check()?;
        job.progress(0.0, "distances")?;
        let interior = Interior::of(&body, &params)?;
        let ends = ends::of_fibres(&sockets, &constellation, &interior, &params)?;
        let start =
            initial::route(ends, &interior, &params, &mut |t| job.progress(0.1 + 0.3 * t, "initial routes"))?;
        job.progress(0.4, "wall field")?;
        let objective = Objective::of(&body, &interior, &params);
        let report = &mut |t| job.progress(0.5 + 0.5 * t, "Adam");
        let Refined { best, history } = refine::improve(start, &objective, &interior, &params, report)?;
        write(&best, &history, &params, job)
    }
}

fn write(best: &Bundle, history: &History, params: &Params, job: &mut Job) -> Result<(), StageError> {
    report_metrics(history, params.light().c5_mm, job);
    job.write("history", "route-history.csv", history.to_csv().as_bytes())?;
    let routes = Routes::new(best.to_fibres(params.radii()));
    job.write("routes", "routes.json", &routes.to_json())
}

fn report_metrics(history: &History, c5_mm: f64, job: &mut Job) {
    let (first, best) = (history.first(), history.best());
    job.metric("route.mean_e_cam_initial_mm", c5_mm * first.mean_e_cam, "mm");
    job.metric("route.mean_e_cam_mm", c5_mm * best.mean_e_cam, "mm");
    job.metric("route.iterations", history.iterations() as f64, "1");
    job.metric("route.objective_initial", first.objective, "1");
    job.metric("route.objective", best.objective, "1");
    job.metric("route.term_cam", best.terms.cam, "1");
    job.metric("route.term_fib", best.terms.fib, "1");
    job.metric("route.term_surf", best.terms.surf, "1");
    job.metric("route.term_reg", best.terms.reg, "mm");
}

fn main() -> std::process::ExitCode {
    serve::<RouteFibar>()
}
