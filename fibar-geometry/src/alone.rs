//! The best course of one fibre alone in the object: several starts, each improved until its light no longer grows.
//!
//! What it finds is the best *known*; how much better another could be is what [`crate::bound`] certifies.

use crate::course::costs::{self, Limits, Watch};
use crate::course::nodes::{MOST_POINTS, Node, Pull, Table, Tables};
use crate::course::{Course, DEGREE, Ends, FEWEST_POINTS, Freedom};
use crate::minimise::{MinimiseOptions, minimise};
use crate::optics::{Absorption, Throughput, ThroughputOptions};
use crate::passage::Ways;
use crate::pieces::{self, Piece};
use crate::room::Room;
use glam::DVec3;

/// What every course of an object has in common.
#[derive(Clone, Copy)]
pub struct World<'a> {
    /// Where axes may run.
    pub room: &'a Room,
    /// The law of light.
    pub absorption: Absorption,
    /// Basis functions.
    pub tables: &'a Tables,
    /// What the ends may do.
    pub freedom: Freedom,
    /// Least bend radius, mm.
    pub min_bend_radius: f64,
}

/// How hard to try.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AloneOptions {
    /// Length of a knot span, mm.
    pub span: f64,
    /// Most steps of the minimiser at each of the rounds.
    pub iterations: usize,
    /// Rounds with growing margins, for courses that break a limit.
    pub rounds: usize,
    /// Done when the cost has fallen by less than this in ten steps.
    pub least_gain: f64,
}

/// A course that keeps all limits, and its light.
#[derive(Clone, Debug, PartialEq)]
pub struct Alone {
    /// The course.
    pub course: Course,
    /// What it lets through.
    pub throughput: Throughput,
}

/// Improves the starts and returns the best that keeps the limits.
pub fn best(world: &World, starts: &[Course], options: &AloneOptions) -> Option<Alone> {
    let mut best: Option<Alone> = None;
    for start in starts {
        let found = improve(world, start.clone(), options);
        let better = |found: &Alone| best.as_ref().is_none_or(|b| b.throughput.loss > found.throughput.loss);
        if let Some(found) = found.filter(better) {
            best = Some(found);
        }
    }
    best
}

/// The best course from the most promising starts; where none of them leads to one, from all starts with more patience.
pub fn find(
    world: &World,
    ends: Ends,
    ways: Option<&Ways>,
    keep: usize,
    options: &AloneOptions,
) -> Option<Alone> {
    const PATIENT: AloneOptions = AloneOptions { span: 6.0, iterations: 300, rounds: 10, least_gain: 1e-5 };
    let starts = promising_starts(world, ends, ways, keep, options);
    best(world, &starts, options).or_else(|| {
        let starts = promising_starts(world, ends, ways, usize::MAX, &PATIENT);
        best(world, &starts, &PATIENT)
    })
}

/// Improves one course; none if its limits cannot be kept.
pub fn improve(world: &World, mut course: Course, options: &AloneOptions) -> Option<Alone> {
    const WALL_MARGIN: f64 = 0.02;
    const BEND_MARGIN: f64 = 1.005;
    let mut limits = Limits {
        curvature: 1.0 / (BEND_MARGIN * world.min_bend_radius),
        wall_margin: WALL_MARGIN,
        wall_weight: 0.3,
        bend_weight: 3.0,
        speed_weight: 1.0,
    };
    let mut watched = Watched::default();
    for round in 0..options.rounds {
        settle(world, &mut course, &limits, &watched, (options.iterations, options.least_gain));
        let flaws = flaws(world, &pieces::of(&course.points));
        if flaws.none() {
            let absorption = &world.absorption;
            let throughput = Throughput::of(&course.curve(), absorption, ThroughputOptions::default());
            return Some(Alone { course, throughput });
        }
        if round > 0 && flaws.lack > 4.0 {
            return None;
        }
        watched.add(&flaws);
        limits.wall_weight *= 4.0;
        limits.bend_weight *= 4.0;
        limits.wall_margin += flaws.lack.clamp(0.0, 0.1);
        limits.curvature /= 1.0 + flaws.bend.clamp(0.0, 0.05);
    }
    None
}

/// Moves a course to a place of least cost. Room is watched at its nodes, and at these parameters.
pub fn settle(
    world: &World,
    course: &mut Course,
    limits: &Limits,
    watched: &Watched,
    (iterations, least_gain): (usize, f64),
) -> f64 {
    let table = world.tables.of(course.points.len());
    let mut x = course.variables();
    let mut buffers = Buffers::default();
    table.sample(&course.points, &mut buffers.nodes);
    let watch = Watch::over(&buffers.nodes, world.room, &watched.walls);
    let bends = Table::at(course.points.len(), &watched.bends);
    let mut cost = |x: &[f64], gradient: &mut [f64]| {
        course.set_variables(x);
        gradient.fill(0.0);
        table.sample(&course.points, &mut buffers.nodes);
        let room = Some((world.room, &watch));
        let cost = costs::of_nodes(&buffers.nodes, &world.absorption, room, limits, &mut buffers.pulls);
        buffers.by_points.clear();
        buffers.by_points.resize(course.points.len(), DVec3::ZERO);
        table.pull_back(&buffers.pulls, &mut buffers.by_points);
        bends.sample(&course.points, &mut buffers.bends);
        let bent = costs::of_bends(&buffers.bends, limits, &mut buffers.pulls);
        bends.pull_back(&buffers.pulls, &mut buffers.by_points);
        course.pull_back(x, &buffers.by_points, gradient);
        cost.loss + cost.penalty + bent + course.leg_cost(x, gradient)
    };
    let options = MinimiseOptions { iterations, least_gain, patience: 10, longest_step: 3.0 };
    let value = minimise(&mut cost, &mut x, options);
    course.set_variables(&x);
    value
}

/// Memory that is used again.
#[derive(Default)]
struct Buffers {
    nodes: Vec<Node>,
    bends: Vec<Node>,
    pulls: Vec<Pull>,
    by_points: Vec<DVec3>,
}

/// Parameters at which a course is watched beside its nodes, since it broke limits there.
#[derive(Clone, Debug, PartialEq)]
pub struct Watched {
    /// For its distance from walls.
    pub walls: Vec<f64>,
    /// For its bend.
    pub bends: Vec<f64>,
}

impl Default for Watched {
    /// The ends, where many a fibre would bend at once.
    fn default() -> Watched {
        Watched { walls: vec![], bends: vec![0.0, 1.0] }
    }
}

impl Watched {
    /// Watches the worst places of a course.
    pub fn add(&mut self, flaws: &Flaws) {
        if flaws.lack > 0.0 && flaws.lack.is_finite() {
            self.walls.push(flaws.place);
        }
        if flaws.bend > 0.0 {
            self.bends.push(flaws.bend_place);
        }
    }
}

/// By how much a course breaks its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flaws {
    /// Room that it lacks, mm; not positive if none.
    pub lack: f64,
    /// The parameter where it lacks most.
    pub place: f64,
    /// Relative excess of its curvature; not positive if none.
    pub bend: f64,
    /// The parameter where it bends most.
    pub bend_place: f64,
}

impl Flaws {
    /// Whether all limits are kept.
    pub fn none(&self) -> bool {
        self.lack <= 0.0 && self.bend <= 0.0
    }
}

/// Measures a course, given as its pieces, against its limits.
pub fn flaws(world: &World, pieces: &[Piece]) -> Flaws {
    const TOLERANCE: f64 = 0.01;
    const TO_SPARE: f64 = 1.0012; // whoever looks again may be off by a thousandth
    let (curvature, bend_place) = pieces::tightest_curvature(pieces);
    let bend = TO_SPARE * curvature * world.min_bend_radius - 1.0;
    // Bends are looked at first: walls take longer.
    if bend > 0.5 {
        return Flaws { lack: f64::INFINITY, place: 0.5, bend, bend_place };
    }
    let (slack, place) = world.room.least_slack(pieces, TOLERANCE);
    Flaws { lack: -slack, place, bend, bend_place }
}

/// Largest curvature among sixteen places of every span, 1/mm.
pub fn tightest_curvature(curve: &crate::curve::Curve) -> f64 {
    const PLACES: usize = 16;
    let at = |w: &[f64], k: usize| curve.jet(w[0] + (w[1] - w[0]) * k as f64 / PLACES as f64).curvature();
    let spans = curve.breaks();
    spans.windows(2).fold(0.0f64, |most, w| (0..=PLACES).fold(most, |most, k| most.max(at(w, k))))
}

/// A smooth polyline that leaves and arrives in the right directions: a cubic Hermite arc whose end tangents are `ease` times
/// the distance.
pub fn hermite(ends: Ends, ease: f64) -> Vec<DVec3> {
    const POINTS: usize = 24;
    let reach = ease * ends.tip.distance(ends.marker) / 3.0;
    let (p, q) = (ends.tip + reach * ends.axis, ends.marker - reach * ends.normal);
    let at = |k: usize| {
        let t = k as f64 / POINTS as f64;
        let s = 1.0 - t;
        s * s * s * ends.tip + 3.0 * s * s * t * p + 3.0 * s * t * t * q + t * t * t * ends.marker
    };
    (0..=POINTS).map(at).collect()
}

/// The `keep` starts of least cost, soft limits included, among Hermite arcs of several reaches and the shortest way.
pub fn promising_starts(
    world: &World,
    ends: Ends,
    ways: Option<&Ways>,
    keep: usize,
    options: &AloneOptions,
) -> Vec<Course> {
    const EASES: [f64; 4] = [0.5, 0.9, 1.4, 2.0];
    let mut starts: Vec<Vec<DVec3>> = EASES.iter().map(|ease| hermite(ends, *ease)).collect();
    starts.extend(ways.and_then(|ways| detour(ends, ways)));
    let limits = Limits {
        curvature: 1.0 / world.min_bend_radius,
        wall_margin: 0.0,
        wall_weight: 0.3,
        bend_weight: 3.0,
        speed_weight: 0.0,
    };
    let mut ranked: Vec<(f64, Course)> = starts
        .into_iter()
        .map(|start| {
            let count = points_for(&start, options.span);
            let mut course = Course::along((ends, world.freedom), &start, count);
            (settle(world, &mut course, &limits, &Watched::default(), (12, options.least_gain)), course)
        })
        .collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked.into_iter().take(keep).map(|(_, course)| course).collect()
}

/// The shortest way through the room, with straight legs at either end.
fn detour(ends: Ends, ways: &Ways) -> Option<Vec<DVec3>> {
    const LEG: f64 = 8.0;
    let (launch, landing) = (ends.tip + LEG * ends.axis, ends.marker - LEG * ends.normal);
    let way = ways.to(landing, 0.0)?;
    let middle = way.into_iter().skip(2);
    Some([ends.tip, launch].into_iter().chain(middle).chain([landing, ends.marker]).collect())
}

fn points_for(line: &[DVec3], span: f64) -> usize {
    let length: f64 = line.windows(2).map(|w| w[0].distance(w[1])).sum();
    (libm::round(length / span) as usize + DEGREE).clamp(FEWEST_POINTS, MOST_POINTS)
}
