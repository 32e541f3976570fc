//! Initial routing: insert midpoints, move all control points, again (Tone 2020, "Initial routing").

use crate::bundle::{Bundle, FIXED};
use crate::ends::Ends;
use crate::foreign::Foreign;
use crate::interior::Interior;
use crate::moves::{self, Chain};
use crate::params::Params;
use fibar_plugin::StageError;
use glam::DVec3;
use rayon::prelude::*;

/// Slack of the neighbour lists; changes the time only.
const SLACK_MM: f64 = 2.0;

/// Chains from LED to marker, 35 control points each after five rounds; `report` hears how far it is, 0 to 1.
pub fn route(
    ends: Vec<Ends>,
    interior: &Interior,
    params: &Params,
    report: &mut dyn FnMut(f64) -> Result<(), StageError>,
) -> Result<Bundle, StageError> {
    let mut bundle = Bundle::of_ends(ends);
    for round in 0..params.rounds {
        bundle = bundle.with_midpoints();
        let mut foreign = Foreign::of(&bundle, params.fibre_threshold_mm, SLACK_MM);
        for count in 0..params.moves {
            foreign.refresh(&bundle);
            bundle.points = moved(&bundle, &foreign, interior, params);
            let share = f64::from(count) / f64::from(params.moves);
            report((f64::from(round) + share) / f64::from(params.rounds))?;
        }
    }
    Ok(bundle)
}

/// All control points after one move of each, all from the same positions; the ends stay.
fn moved(bundle: &Bundle, foreign: &Foreign, interior: &Interior, params: &Params) -> Vec<DVec3> {
    let mut points = bundle.points.clone();
    points.par_chunks_mut(bundle.count).enumerate().for_each(|(fibre, after)| {
        let first = fibre * bundle.count;
        let before = &bundle.points[first..][..bundle.count];
        let chain = Chain::of(before);
        for k in FIXED..bundle.count - FIXED {
            let others = foreign.near(first + k).iter().map(|&other| bundle.points[other as usize]);
            let step = step(&chain, k, before[k], others, interior, params);
            after[k] = interior.keep_inside(before[k] + step);
        }
    });
    points
}

/// `l + r + f + s` with the gains of the parameters, no longer than the longest move, mm.
fn step(
    chain: &Chain,
    k: usize,
    point: DVec3,
    others: impl Iterator<Item = DVec3>,
    interior: &Interior,
    params: &Params,
) -> DVec3 {
    let l = params.length_gain * chain.shorten(k);
    let r = params.bend_gain * chain.round(k);
    let f = params.fibre_step_mm * moves::part(point, others, params.fibre_threshold_mm);
    let s = params.surface_step_mm * moves::leave_surface(interior.depth(point), params.surface_threshold_mm);
    (l + r + f + s).clamp_length_max(params.longest_move_mm)
}
