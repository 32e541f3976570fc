//! `route-negotiated`: fibres with the most light that keep clear of each other, of the skin and of tight bends; or why not.
//!
//! [`alone`](negotiate) every fibre finds its best course as if it were the only one, then all of them make room for each other
//! ([`joint`]) until none comes closer than it may ([`gaps`]). docs/route-negotiated.md tells how, and what was measured.

mod attempt;
mod crowd;
mod earlier;
mod gaps;
mod inspect;
mod joint;
mod misfit;
mod mouths;
mod neck;
mod negotiate;
mod nets;
mod omit;
mod params;
mod remedy;
mod reroute;
mod trunks;
mod warm;

use attempt::{Routed, Task};
use fibar_core::artefact::Document;
use fibar_core::artefact::constellation::Constellation;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::routes::{Fibre, Routes};
use fibar_core::artefact::sockets::Sockets;
use fibar_geometry::course::DEGREE;
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use params::Params;

struct RouteNegotiated;

impl Stage for RouteNegotiated {
    type Params = Params;

    fn describe() -> Description {
        Description::new("route-negotiated", "Routes every fibre with hard clearances and the most light.")
            .version(env!("CARGO_PKG_VERSION"))
            .input("body", "body", "The closed body, mm.")
            .input("sockets", "sockets", "Where the LEDs sit and what they blink.")
            .input("constellation", "constellation", "The markers and their patterns.")
            .published("routes", "routes", "routes.json", "A NURBS curve per fibre, from LED to marker.")
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        params.check()?;
        let task = Task {
            body: TriangleMesh::from_ply(&job.read("body")?)?,
            sockets: Sockets::from_json(&job.read("sockets")?)?,
            constellation: Constellation::from_json(&job.read("constellation")?)?,
            earlier: earlier::read(&params)?,
        };
        let routed = remedy::route(&task, &params, job)?;
        report(&task, &routed, job);
        write(&routed, job)
    }
}

fn report(task: &Task, routed: &Routed, job: &mut Job) {
    let (kept, all) = (routed.outcome.kept, routed.outcome.courses.len());
    if task.earlier.is_some() {
        job.metric("route.kept", kept as f64, "1");
        job.metric("route.rerouted", (all - kept) as f64, "1");
    }
    job.metric("route.left_out", (routed.nets.len() - all) as f64, "1");
    job.metric("route.diameter_mm", routed.params.diameter(), "mm");
}

fn write(routed: &Routed, job: &mut Job) -> Result<(), StageError> {
    let Routed { nets, outcome, params } = routed;
    let fibres = outcome.courses.iter().zip(1..).map(|((net, course), id)| Fibre {
        id,
        marker: nets[*net].marker,
        led: nets[*net].led,
        pattern: nets[*net].pattern,
        degree: DEGREE,
        knots: course.knots(),
        points: course.points.clone(),
        weights: vec![1.0; course.points.len()],
        radii_mm: params.radii(),
    });
    let routes = Routes::new(fibres.collect());
    job.write("routes", "routes.json", &routes.to_json())
}

fn main() -> std::process::ExitCode {
    serve::<RouteNegotiated>()
}
