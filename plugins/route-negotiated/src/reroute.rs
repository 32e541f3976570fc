//! Rip-up: a fibre that lost much light to its neighbours looks for another way between them.

use crate::joint::{Apart, Strand, settle_one};
use fibar_geometry::alone::World;
use fibar_geometry::course::Course;
use fibar_geometry::minimise::MinimiseOptions;
use fibar_geometry::optics::{Throughput, ThroughputOptions};
use rayon::prelude::*;
use std::f64::consts::PI;

/// `∫a ds` of a course, to a thousandth.
pub fn loss_of(world: &World, course: &Course) -> f64 {
    let options = ThroughputOptions { tolerance: 1e-3 };
    Throughput::of(&course.curve(), &world.absorption, options).loss
}

/// How rip-up is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reroute {
    /// What closeness costs while a fibre looks for its way.
    pub apart: Apart,
    /// Only fibres that lose at least this much more than alone are ripped up.
    pub least_excess: f64,
    /// How far new ways lead to the side, mm.
    pub aside: f64,
}

/// Rips up fibres one after the other, worst first; each takes the cheapest way found between the others. Returns how many changed.
pub fn pass(
    world: &World,
    strands: &mut [Strand],
    alone: &[(Course, f64)],
    options: &Reroute,
    check: &mut dyn FnMut(f64) -> Result<(), fibar_plugin::StageError>,
) -> Result<usize, fibar_plugin::StageError> {
    let excess: Vec<f64> =
        strands.par_iter().zip(alone).map(|(s, alone)| loss_of(world, &s.course) - alone.1).collect();
    let mut order: Vec<usize> = (0..strands.len()).filter(|&k| excess[k] > options.least_excess).collect();
    order.sort_by(|&a, &b| excess[b].total_cmp(&excess[a]).then(a.cmp(&b)));
    let mut changed = 0;
    for (done, &k) in order.iter().enumerate() {
        check(done as f64 / order.len() as f64)?;
        let (course, is_new) = cheapest_way(world, strands, k, &alone[k].0, options);
        strands[k].course = course;
        changed += usize::from(is_new);
    }
    Ok(changed)
}

/// The cheapest of the present way and those that start from the fibre's own best, straight and to all sides.
fn cheapest_way(
    world: &World,
    strands: &[Strand],
    number: usize,
    alone: &Course,
    options: &Reroute,
) -> (Course, bool) {
    const WORTH_A_CHANGE: f64 = 0.02;
    let steps = MinimiseOptions { iterations: 40, least_gain: 1e-3, patience: 8, longest_step: 3.0 };
    let weight = options.apart.weight;
    let gently = vec![0.05 * weight, weight];
    let mut starts = vec![
        (strands[number].course.clone(), vec![weight]),
        (alone.clone(), gently.clone()),
        (alone.clone(), vec![weight]),
    ];
    starts.extend(sideways(alone, options.aside).into_iter().map(|course| (course, gently.clone())));
    let tried: Vec<(f64, Course)> = starts
        .into_par_iter()
        .map(|(course, weights)| settle_one(world, strands, (number, course), &weights, options.apart, steps))
        .collect();
    let present = tried[0].0;
    let best = tried.into_iter().reduce(|best, next| if next.0 < best.0 { next } else { best });
    let (cost, course) = best.expect("the present way was tried");
    (course, cost < present - WORTH_A_CHANGE)
}

/// A course that bows out to each of four sides.
fn sideways(alone: &Course, aside: f64) -> Vec<Course> {
    let chord = (alone.ends.marker - alone.ends.tip).normalize_or(alone.ends.axis);
    let (a, b) = chord.any_orthonormal_pair();
    let bow = |side: glam::DVec3| {
        let mut course = alone.clone();
        let last = course.points.len() - 1;
        for k in 2..last - 1 {
            course.points[k] += aside * libm::sin(PI * k as f64 / last as f64) * side;
        }
        course
    };
    [a, -a, b, -b].map(bow).to_vec()
}
