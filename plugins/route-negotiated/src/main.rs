//! `route-negotiated`: fibres with the most light that keep clear of each other, of the skin and of tight bends; or why not.
//!
//! [`alone`](negotiate) every fibre finds its best course as if it were the only one, then all of them make room for each other
//! ([`joint`]) until none comes closer than it may ([`gaps`]). docs/route-negotiated.md tells how, and what was measured.

mod crowd;
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
use fibar_geometry::passage::Passages;
use fibar_geometry::room::{Room, RoomOptions};
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use negotiate::Outcome;
use nets::{Net, Rules};
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
        let body = TriangleMesh::from_ply(&job.read("body")?)?;
        let sockets = Sockets::from_json(&job.read("sockets")?)?;
        let constellation = Constellation::from_json(&job.read("constellation")?)?;
        params.check()?;
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
        let passages = Passages::of(&room, params.search_mm);
        let outcome = negotiate::route(&world, &passages, &nets, &params, job)?;
        write(&nets, &outcome, &params, job)
    }
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
