//! `route-negotiated`: fibres with the most light that keep clear of each other, of the skin and of tight bends; or why not.
//!
//! [`alone`](negotiate) every fibre finds its best course as if it were the only one, then all of them make room for each other
//! ([`joint`]) until none comes closer than it may ([`gaps`]). docs/route-negotiated.md tells how, and what was measured.

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
mod params;
mod reroute;
mod trunks;
mod warm;

use fibar_core::artefact::Document;
use fibar_core::artefact::constellation::Constellation;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::routes::{Fibre, Routes};
use fibar_core::artefact::sockets::Sockets;
use fibar_geometry::alone::World;
use fibar_geometry::course::nodes::Tables;
use fibar_geometry::course::{DEGREE, Freedom};
use fibar_geometry::distance::Surface;
use fibar_geometry::optics::Absorption;
use fibar_geometry::room::{Room, RoomOptions};
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use negotiate::Outcome;
use nets::{Net, Rules};
use params::Params;
use std::sync::OnceLock;

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
        let body = TriangleMesh::from_ply(&job.read("body")?)?;
        let sockets = Sockets::from_json(&job.read("sockets")?)?;
        let constellation = Constellation::from_json(&job.read("constellation")?)?;
        params.check()?;
        let earlier = earlier::read(&params)?;
        job.progress(0.0, "room")?;
        let surface = Surface::new(&body).map_err(|e| StageError::input(format!("body: {e}")))?;
        let options = RoomOptions { spacing: params.grid_mm, band: 6.0 };
        let room = Room::new(surface, &sockets, params.keeping(), options);
        let rules = Rules { marker_tolerance: params.marker_tolerance_mm, apart: params.apart() };
        let nets = nets::of(&sockets, &constellation, &room, &rules)?;
        let tables = Tables::all();
        let world = World {
            room: &room,
            absorption: Absorption::monotone(params.light()),
            tables: &tables,
            freedom: Freedom {
                mouth_radius: params.mouth_radius_mm,
                tilt: libm::tan(params.arrival_tilt_deg.to_radians()),
            },
            min_bend_radius: params.min_bend_radius_mm,
        };
        let outcome = match earlier {
            None => negotiate::route(&world, &OnceLock::new(), &nets, &params, job)?,
            Some(earlier) => route_from(&earlier, &world, &nets, &params, job)?,
        };
        write(&nets, &outcome, &params, job)
    }
}

/// Routes what the earlier routes do not fit.
fn route_from(
    earlier: &Routes,
    world: &World,
    nets: &[Net],
    params: &Params,
    job: &mut Job,
) -> Result<Outcome, StageError> {
    let courses = earlier::courses(earlier, nets, world.freedom, params);
    let outcome = if courses.iter().all(Option::is_none) {
        let why = earlier::why_none(earlier, params);
        job.log("warn", &format!("no fibre of the earlier routes fits, all are routed anew: {why}"));
        negotiate::route(world, &OnceLock::new(), nets, params, job)?
    } else {
        warm::route(world, &OnceLock::new(), nets, courses, params, job)?
    };
    let (kept, all) = (outcome.kept, outcome.courses.len());
    job.log(
        "info",
        &format!("{kept} of {all} fibres are those of the earlier routes, {} are routed anew", all - kept),
    );
    job.metric("route.kept", kept as f64, "1");
    job.metric("route.rerouted", (all - kept) as f64, "1");
    Ok(outcome)
}

fn write(nets: &[Net], outcome: &Outcome, params: &Params, job: &mut Job) -> Result<(), StageError> {
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
