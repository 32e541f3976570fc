//! Initial routing: insert midpoints, move all control points, again (Tone 2020, "Initial routing").

use crate::bundle::{Bundle, FIXED};
use crate::ends::Ends;
use crate::interior::Interior;
use crate::moves::{self, Chain};
use crate::neighbours::Cells;
use crate::params::Params;
use fibar_plugin::StageError;
use glam::DVec3;
use rayon::prelude::*;

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
        for count in 0..params.moves {
            bundle.points = moved(&bundle, interior, params);
            let share = f64::from(count) / f64::from(params.moves);
            report((f64::from(round) + share) / f64::from(params.rounds))?;
        }
    }
    Ok(bundle)
}

/// All control points after one move of each, all from the same positions; the ends stay.
fn moved(bundle: &Bundle, interior: &Interior, params: &Params) -> Vec<DVec3> {
    let cells = Cells::of(&bundle.points, params.fibre_threshold_mm);
    let mut points = bundle.points.clone();
    points.par_chunks_mut(bundle.count).enumerate().for_each(|(fibre, after)| {
        let before = &bundle.points[fibre * bundle.count..][..bundle.count];
        let chain = Chain::of(before);
        for k in FIXED..bundle.count - FIXED {
            let others = foreign(bundle, &cells, fibre, before[k]);
            let step = step(&chain, k, before[k], others, interior, params);
            after[k] = interior.keep_inside(before[k] + step);
        }
    });
    points
}

/// Control points near a place that belong to other patterns.
fn foreign(bundle: &Bundle, cells: &Cells, fibre: usize, place: DVec3) -> impl Iterator<Item = DVec3> {
    let pattern = bundle.ends[fibre].pattern;
    let other = move |k: &usize| bundle.ends[k / bundle.count].pattern != pattern;
    cells.near(place).filter(other).map(|k| bundle.points[k])
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
