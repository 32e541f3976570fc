//! One try to route everything with fibres of one thickness.

use crate::earlier;
use crate::misfit::{Misfit, Unfit};
use crate::negotiate::{self, Outcome};
use crate::nets::{self, Net, Rules};
use crate::params::Params;
use crate::warm;
use fibar_core::MarkerId;
use fibar_core::artefact::constellation::Constellation;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::routes::Routes;
use fibar_core::artefact::sockets::Sockets;
use fibar_geometry::alone::World;
use fibar_geometry::course::Freedom;
use fibar_geometry::course::nodes::Tables;
use fibar_geometry::distance::Surface;
use fibar_geometry::optics::Absorption;
use fibar_geometry::passage::Passages;
use fibar_geometry::room::{Room, RoomOptions};
use fibar_plugin::{Job, StageError};
use std::collections::BTreeSet;
use std::sync::OnceLock;

/// What is to be routed, whatever the thickness.
pub struct Task {
    /// The object.
    pub body: TriangleMesh,
    /// Where fibres start.
    pub sockets: Sockets,
    /// Where they end.
    pub constellation: Constellation,
    /// Routes to start from.
    pub earlier: Option<Routes>,
}

/// A routing.
pub struct Routed {
    /// All nets.
    pub nets: Vec<Net>,
    /// Their courses.
    pub outcome: Outcome,
    /// How thick the fibres are.
    pub params: Params,
}

impl Routed {
    /// Markers that no fibre leads to.
    pub fn left_out(&self) -> Vec<MarkerId> {
        let led: BTreeSet<MarkerId> =
            self.outcome.courses.iter().map(|(net, _)| self.nets[*net].marker).collect();
        let mut out: Vec<MarkerId> =
            self.nets.iter().map(|net| net.marker).filter(|m| !led.contains(m)).collect();
        out.sort_unstable();
        out
    }
}

impl Task {
    /// Routes everything, or says what does not fit.
    pub fn attempt(&self, params: &Params, job: &mut Job) -> Result<Routed, Unfit> {
        job.progress(0.0, "room")?;
        let room = self.room(params)?;
        let nets = self.nets(&room, params)?;
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
        let passages = OnceLock::new();
        let outcome = match &self.earlier {
            None => negotiate::route(&world, &passages, &nets, params, job)?,
            Some(earlier) => route_from(earlier, (&world, &passages), &nets, params, job)?,
        };
        Ok(Routed { nets, outcome, params: params.clone() })
    }

    /// Whether every fibre of this thickness has places to start and to end.
    pub fn has_places(&self, params: &Params) -> Result<bool, StageError> {
        let room = self.room(params)?;
        Ok(self.nets(&room, params).is_ok())
    }

    fn room(&self, params: &Params) -> Result<Room, StageError> {
        let surface = Surface::new(&self.body).map_err(|e| StageError::input(format!("body: {e}")))?;
        let options = RoomOptions { spacing: params.grid_mm, band: 6.0, exact: params.grid_mm };
        Ok(Room::new(surface, &self.sockets, params.keeping(), options))
    }

    fn nets(&self, room: &Room, params: &Params) -> Result<Vec<Net>, Misfit> {
        let rules = Rules { marker_tolerance: params.marker_tolerance_mm, apart: params.apart() };
        nets::of(&self.sockets, &self.constellation, room, &rules).map_err(Misfit::Place)
    }
}

/// Routes what the earlier routes do not fit.
fn route_from(
    earlier: &Routes,
    (world, passages): (&World, &OnceLock<Passages>),
    nets: &[Net],
    params: &Params,
    job: &mut Job,
) -> Result<Outcome, Unfit> {
    let courses = earlier::courses(earlier, nets, world.freedom, params);
    let outcome = if courses.iter().all(Option::is_none) {
        let why = earlier::why_none(earlier, params);
        job.log("warn", &format!("no fibre of the earlier routes fits, all are routed anew: {why}"));
        negotiate::route(world, passages, nets, params, job)?
    } else {
        warm::route(world, passages, nets, courses, params, job)?
    };
    let (kept, all) = (outcome.kept, outcome.courses.len());
    job.log(
        "info",
        &format!("{kept} of {all} fibres are those of the earlier routes, {} are routed anew", all - kept),
    );
    Ok(outcome)
}
