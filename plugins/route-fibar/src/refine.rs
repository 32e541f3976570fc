//! Refinement of the routes by Adam, keeping the best that was seen.

use crate::adam::Adam;
use crate::bundle::{Bundle, FIXED};
use crate::history::{Entry, History};
use crate::interior::Interior;
use crate::objective::{Objective, Terms};
use crate::params::Params;
use fibar_plugin::StageError;
use glam::DVec3;
use rayon::prelude::*;

/// The outcome.
pub struct Refined {
    /// The routes of the least objective seen.
    pub best: Bundle,
    /// The terms on the way.
    pub history: History,
}

/// Takes Adam's steps until the objective has not gained for `patience` iterations, or the iterations are used up. The end
/// pieces stay, and the guard keeps the rest inside.
pub fn improve(
    start: Bundle,
    objective: &Objective,
    interior: &Interior,
    params: &Params,
    report: &mut dyn FnMut(f64) -> Result<(), StageError>,
) -> Result<Refined, StageError> {
    let mut bundle = start.clone();
    let mut best = start;
    let mut history = History::default();
    let mut adam = Adam::of(bundle.points.len());
    let mut gradient = vec![DVec3::ZERO; bundle.points.len()];
    for iteration in 0..=params.iterations {
        let terms = objective.evaluate(&bundle, &mut gradient);
        if history.add(entry(&terms, objective, &bundle), params.least_gain) {
            best.points.clone_from(&bundle.points);
        }
        if history.since_gain() >= params.patience as usize {
            break;
        }
        let done = f64::from(iteration) / f64::from(params.iterations.max(1));
        hold_ends(&mut gradient, bundle.count);
        follow(&mut bundle, &adam.step(&gradient, params.learning_rate_mm), interior);
        report(done)?;
    }
    Ok(Refined { best, history })
}

fn entry(terms: &Terms, objective: &Objective, bundle: &Bundle) -> Entry {
    let mean_e_cam = 1.0 - terms.cam / bundle.ends.len() as f64;
    Entry { terms: *terms, objective: objective.weigh(terms), mean_e_cam }
}

fn hold_ends(gradient: &mut [DVec3], count: usize) {
    for chain in gradient.chunks_mut(count) {
        chain[..FIXED].fill(DVec3::ZERO);
        chain[count - FIXED..].fill(DVec3::ZERO);
    }
}

fn follow(bundle: &mut Bundle, steps: &[DVec3], interior: &Interior) {
    let count = bundle.count;
    bundle.points.par_chunks_mut(count).zip(steps.par_chunks(count)).for_each(|(chain, steps)| {
        for k in FIXED..count - FIXED {
            chain[k] = interior.keep_inside(chain[k] + steps[k]);
        }
    });
}
