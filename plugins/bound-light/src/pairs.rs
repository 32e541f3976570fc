//! All pairs of LEDs and targets, each bounded for itself.

use crate::params::{Effort, Params};
use fibar_core::artefact::bounds::Target;
use fibar_core::artefact::courses::{Reached, rounded};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::sockets::{Socket, Sockets};
use fibar_geometry::alone::{Alone, AloneOptions, World, find};
use fibar_geometry::bound::LeastLoss;
use fibar_geometry::bound::reach::Reach;
use fibar_geometry::course::nodes::Tables;
use fibar_geometry::course::{Ends, Freedom};
use fibar_geometry::distance::Surface;
use fibar_geometry::optics::Absorption;
use fibar_geometry::passage::{Passages, Ways};
use fibar_geometry::room::{Keeping, Room, RoomOptions};
use fibar_plugin::{Job, StageError};
use glam::DVec3;
use rayon::prelude::*;

/// Targets bounded between two reports of progress.
const BATCH: usize = 32;

/// Bounds for every place, in order, and the curves by which it is reached.
pub fn bound(
    body: &TriangleMesh,
    sockets: &Sockets,
    places: &[(DVec3, DVec3)],
    params: &Params,
    job: &mut Job,
) -> Result<Vec<(Target, Reached)>, StageError> {
    job.progress(0.0, "room")?;
    let surface = Surface::new(body).map_err(|e| StageError::input(format!("body: {e}")))?;
    let keeping = Keeping { radius: params.fibre_radius_mm, skin: params.skin_mm, wall: params.wall_mm };
    let room = Room::new(
        surface,
        sockets,
        keeping,
        RoomOptions { spacing: params.grid_mm, band: 6.0, exact: f64::INFINITY },
    );
    let passages = Passages::of(&room, params.search_mm);
    let ways: Vec<Option<Ways>> =
        sockets.sockets.par_iter().map(|s| passages.from(s.position + 4.0 * s.axis, 0.0, &|_| 0.0)).collect();
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
    let reach = |s: &Socket| Reach::from(&room, s.position, params.mouth_radius_mm);
    let reach: Vec<Reach> = sockets.sockets.par_iter().map(reach).collect();
    let least = LeastLoss::new(&world.absorption, params.min_bend_radius_mm);
    let mut targets = Vec::with_capacity(places.len());
    for batch in places.chunks(BATCH) {
        job.progress(0.1 + 0.9 * targets.len() as f64 / places.len() as f64, "pairs")?;
        let bounded: Vec<(Target, Reached)> = batch
            .par_iter()
            .map(|place| target(&world, (&least, &reach), sockets, &ways, *place, params))
            .collect();
        targets.extend(bounded);
    }
    Ok(targets)
}

fn target(
    world: &World,
    (least, reach): (&LeastLoss, &[Reach]),
    sockets: &Sockets,
    ways: &[Option<Ways>],
    (position, normal): (DVec3, DVec3),
    params: &Params,
) -> (Target, Reached) {
    let mut target = Target { position, normal, certified_mm: vec![], best_mm: vec![] };
    let mut curves = vec![];
    for ((socket, ways), reach) in sockets.sockets.iter().zip(ways).zip(reach) {
        let ends = Ends { tip: socket.position, axis: socket.axis, marker: position, normal };
        let (best, certified) = match reach.reaches(ends) {
            true => lights(world, least, ends, ways.as_ref(), params.effort),
            false => (None, 0.0),
        };
        target.best_mm.push(best.as_ref().map_or(0.0, |best| best.throughput.d_cam_mm));
        target.certified_mm.push(certified);
        curves.push(best.map_or(vec![], |best| best.course.points.iter().map(|p| rounded(*p)).collect()));
    }
    (target, Reached { position, curves })
}

/// The best course known, if any is; and the d_cam, mm, that no course between these ends exceeds.
fn lights(
    world: &World,
    least: &LeastLoss,
    ends: Ends,
    ways: Option<&Ways>,
    effort: Effort,
) -> (Option<Alone>, f64) {
    const FAINTEST: f64 = 20.0; // d_cam is 0.3 mm
    const BEYOND_BEST: f64 = 0.5; // so that a bound that the best known breaks shows
    let (keep, options, attempts) = match effort {
        Effort::Quick => (1, AloneOptions { span: 9.0, iterations: 60, rounds: 5, least_gain: 1e-5 }, 4),
        Effort::Normal => (2, AloneOptions { span: 7.5, iterations: 120, rounds: 6, least_gain: 1e-5 }, 12),
        Effort::Thorough => {
            (usize::MAX, AloneOptions { span: 6.0, iterations: 500, rounds: 8, least_gain: 1e-5 }, 60)
        }
    };
    let best = find(world, ends, ways, keep, &options);
    let enough = best.as_ref().map_or(FAINTEST, |best| best.throughput.loss + BEYOND_BEST);
    let certified = world.absorption.d_cam_mm(least.between(ends, world.freedom, enough, attempts));
    (best, certified)
}
