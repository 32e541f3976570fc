//! Rip-up: a fibre that lost much light to its neighbours looks for another way between them.

use crate::crowd::{Crowd, Segment};
use crate::joint::{Apart, Strand, settle_among};
use fibar_geometry::alone::World;
use fibar_geometry::course::{Course, costs};
use fibar_geometry::minimise::MinimiseOptions;
use rayon::prelude::*;
use std::f64::consts::PI;

/// `∫a ds` of a course by its nodes.
pub fn loss_of(world: &World, course: &Course) -> f64 {
    let mut nodes = vec![];
    world.tables.of(course.points.len()).sample(&course.points, &mut nodes);
    costs::loss(&nodes, &world.absorption)
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

/// What is known of a fibre from before it met the others.
pub struct Alone {
    /// Its best course.
    pub course: Course,
    /// What that loses.
    pub loss: f64,
}

/// Which fibres are worth a look: those for which none was in vain, those that lose more since, and those in whose way others have been or
/// are now.
pub struct Looks {
    /// The best courses alone.
    alone: Crowd,
    /// What a fibre lost after the last look, if nothing has changed about it since.
    in_vain: Vec<Option<f64>>,
}

impl Looks {
    /// Every fibre is.
    pub fn new(world: &World, strands: &[Strand]) -> Looks {
        let mut alone = Crowd::within(world.room.surface().bounds());
        strands.iter().for_each(|strand| alone.push(strand.segments(world)));
        Looks { alone, in_vain: vec![None; strands.len()] }
    }

    /// Whether a fibre that loses this much is.
    fn is_worth(&self, strand: usize, loss: f64) -> bool {
        const RISE: f64 = 0.1;
        self.in_vain[strand].is_none_or(|before| loss > before + RISE)
    }

    /// A course was given up, or taken: fibres whose best ways it is near are worth a look again.
    fn change(&mut self, course: &[Segment], distance: f64) {
        for segment in course {
            self.alone
                .for_each_near(segment, distance, |[strand, _], _| self.in_vain[strand as usize] = None);
        }
    }
}

/// Rips up fibres one after the other, worst first; each takes the cheapest way found between the others. Returns how many changed.
pub fn pass(
    world: &World,
    strands: &mut [Strand],
    alone: &[Alone],
    looks: &mut Looks,
    options: &Reroute,
    check: &mut dyn FnMut(f64) -> Result<(), fibar_plugin::StageError>,
) -> Result<usize, fibar_plugin::StageError> {
    let losses: Vec<f64> = strands.par_iter().map(|s| loss_of(world, &s.course)).collect();
    let excess = |k: usize| losses[k] - alone[k].loss;
    let mut order: Vec<usize> = (0..strands.len()).filter(|&k| excess(k) > options.least_excess).collect();
    order.sort_by(|&a, &b| excess(b).total_cmp(&excess(a)).then(a.cmp(&b)));
    let mut changed = 0;
    let mut crowd = Crowd::within(world.room.surface().bounds());
    strands.iter().for_each(|strand| crowd.push(strand.segments(world)));
    for (done, &k) in order.iter().enumerate() {
        check(done as f64 / order.len() as f64)?;
        if !looks.is_worth(k, losses[k]) {
            continue;
        }
        let before = strands[k].segments(world);
        let (course, is_new) = cheapest_way(world, &crowd, &strands[k], &alone[k].course, options);
        strands[k].course = course;
        let now = strands[k].segments(world);
        if is_new {
            let distance = options.apart.distance + options.aside;
            looks.change(&before, distance);
            looks.change(&now, distance);
        }
        looks.in_vain[k] = Some(loss_of(world, &strands[k].course));
        crowd.replace(k, now);
        changed += usize::from(is_new);
    }
    Ok(changed)
}

/// The cheaper of the present way and the best new one.
fn cheapest_way(
    world: &World,
    crowd: &Crowd,
    strand: &Strand,
    alone: &Course,
    options: &Reroute,
) -> (Course, bool) {
    const WORTH_A_CHANGE: f64 = 0.02;
    let present = settle_way((world, crowd, strand), &strand.course, options.apart, MANY);
    let best = new_way((world, crowd, strand), alone, options, Some(&present));
    match best.filter(|best| best.0 < present.0 - WORTH_A_CHANGE) {
        Some((_, course)) => (course, true),
        None => (present.1, false),
    }
}

/// Steps of the minimiser for a first look, and to the end.
const FEW: usize = 12;
const MANY: usize = 40;

/// The cheapest of ways that start from the fibre's own best, straight and to all sides. After a few steps only the two most
/// hopeful ones that have not fallen back to the present way go on.
pub fn new_way(
    scene: (&World, &Crowd, &Strand),
    alone: &Course,
    options: &Reroute,
    present: Option<&(f64, Course)>,
) -> Option<(f64, Course)> {
    const MAY_FALL: f64 = 0.5;
    const GENTLY: f64 = 0.05;
    let gentle = Apart { weight: GENTLY * options.apart.weight, ..options.apart };
    let mut starts = vec![(alone.clone(), false), (alone.clone(), true)];
    starts.extend(sideways(alone, options.aside).into_iter().map(|course| (course, true)));
    let first_look = |(course, gently): &(Course, bool)| {
        let eased = gently.then(|| settle_way(scene, course, gentle, FEW).1);
        settle_way(scene, eased.as_ref().unwrap_or(course), options.apart, FEW)
    };
    let mut tried: Vec<(f64, Course)> = starts.par_iter().map(first_look).collect();
    if let Some((cost, course)) = present {
        tried.retain(|way| way.0 < cost + MAY_FALL && differ(&way.1, course));
    }
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    tried.truncate(2);
    let improved: Vec<(f64, Course)> =
        tried.par_iter().map(|(_, course)| settle_way(scene, course, options.apart, MANY)).collect();
    improved.into_iter().reduce(|best, next| if next.0 < best.0 { next } else { best })
}

fn settle_way(
    (world, crowd, strand): (&World, &Crowd, &Strand),
    course: &Course,
    apart: Apart,
    iterations: usize,
) -> (f64, Course) {
    let steps = MinimiseOptions { iterations, least_gain: 1e-3, patience: 8, longest_step: 3.0 };
    let mut strand = Strand { course: course.clone(), held: false, ..strand.clone() };
    let cost = settle_among(world, crowd, &mut [&mut strand], apart, steps);
    (cost, strand.course)
}

/// Whether two courses of one fibre are not about the same.
fn differ(a: &Course, b: &Course) -> bool {
    const MM: f64 = 2.0;
    a.points.len() != b.points.len()
        || a.points.iter().zip(&b.points).any(|(p, q)| p.distance_squared(*q) > MM * MM)
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
