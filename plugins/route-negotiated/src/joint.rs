//! All courses together: light, limits of each, and what it costs where two patterns come too close.
//!
//! Fibres push each other aside: every course is a variable of one smooth problem, and a pair of segments of different patterns that
//! is closer than it may be costs the square of what is lacking. Courses that start tangled can pass through each other while the
//! weight of that cost is small, and settle apart as it grows.

use fibar_geometry::alone::World;
use fibar_geometry::course::Course;
use fibar_geometry::course::costs::{self, Limits, Watch};
use fibar_geometry::course::nodes::{Node, Pull};
use fibar_geometry::minimise::{MinimiseOptions, minimise};
use fibar_geometry::segments::approach;
use glam::DVec3;
use rayon::prelude::*;

/// What a course has in common with others of its pattern.
#[derive(Clone, Debug)]
pub struct Strand {
    /// What it carries.
    pub pattern: u32,
    /// The axis.
    pub course: Course,
    /// Added to the distance that it keeps from others, mm.
    pub margin: f64,
    /// Limits of its own.
    pub limits: Limits,
    /// Parameters at which its room is watched beside its nodes.
    pub watched: Vec<f64>,
    /// Whether it stays as it is.
    pub held: bool,
}

/// How far axes of different patterns keep apart, and what it costs if they do not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Apart {
    /// mm.
    pub distance: f64,
    /// Cost per mm of length and mm² of lacking distance.
    pub weight: f64,
}

/// Moves one strand alone from a course of its own, the others held; the cost is of that strand.
pub fn settle_one(
    world: &World,
    strands: &[Strand],
    (number, course): (usize, Course),
    weights: &[f64],
    apart: Apart,
    options: MinimiseOptions,
) -> (f64, Course) {
    let mut strands: Vec<Strand> = strands.iter().map(|s| Strand { held: true, ..s.clone() }).collect();
    strands[number].held = false;
    strands[number].course = course;
    let mut value = f64::INFINITY;
    for weight in weights {
        value = settle(world, &mut strands, Apart { weight: *weight, ..apart }, options);
    }
    (value, strands.swap_remove(number).course)
}

/// Moves all strands that are not held to a place of least cost.
pub fn settle(world: &World, strands: &mut [Strand], apart: Apart, options: MinimiseOptions) -> f64 {
    let mut problem = Problem::of(world, strands, apart);
    let mut x = problem.variables();
    let value = minimise(&mut |x, gradient| problem.cost(x, gradient), &mut x, options);
    let mut gradient = vec![0.0; x.len()];
    problem.cost(&x, &mut gradient);
    for (strand, state) in strands.iter_mut().zip(problem.states) {
        strand.course = state.strand.course;
    }
    value
}

/// The problem of one settling.
struct Problem<'a> {
    world: &'a World<'a>,
    apart: Apart,
    states: Vec<State>,
    near: Near,
}

/// Does something with every strand that is not held: on all threads if there are many.
fn for_each_free(states: &mut [State], each: impl Fn(&mut State) + Send + Sync) {
    const MANY: usize = 8;
    let free = states.iter().filter(|state| !state.strand.held).count();
    if free >= MANY {
        states.par_iter_mut().filter(|state| !state.strand.held).for_each(each);
    } else {
        states.iter_mut().filter(|state| !state.strand.held).for_each(each);
    }
}

/// One strand with its memory.
struct State {
    strand: Strand,
    watch: Watch,
    nodes: Vec<Node>,
    pulls: Vec<Pull>,
    by_points: Vec<DVec3>,
    gradient: Vec<f64>,
    /// Place of its variables among all.
    first: usize,
    cost: f64,
}

impl<'a> Problem<'a> {
    fn of(world: &'a World<'a>, strands: &[Strand], apart: Apart) -> Problem<'a> {
        let mut first = 0;
        let mut states: Vec<State> = strands
            .iter()
            .map(|strand| {
                let state = State::of(world, strand.clone(), first);
                first += state.gradient.len();
                state
            })
            .collect();
        for_each_free(&mut states, |state| {
            state.watch = Watch::over(&state.nodes, world.room, &state.strand.watched);
        });
        Problem { world, apart, states, near: Near::default() }
    }

    fn variables(&self) -> Vec<f64> {
        let free = self.states.iter().filter(|state| !state.strand.held);
        free.flat_map(|state| state.strand.course.variables()).collect()
    }

    fn cost(&mut self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let world = self.world;
        for_each_free(&mut self.states, |state| state.measure(world, x));
        self.near.update(&self.states, self.apart.distance);
        let pairs = self.push_apart();
        for_each_free(&mut self.states, |state| state.pull_back(world, x));
        for state in self.states.iter().filter(|state| !state.strand.held) {
            gradient[state.first..][..state.gradient.len()].copy_from_slice(&state.gradient);
        }
        self.states.iter().fold(pairs, |sum, state| sum + state.cost)
    }

    /// What pairs of segments that are too close cost; adds to the pulls of their nodes.
    fn push_apart(&mut self) -> f64 {
        let mut cost = 0.0;
        for &[a, i, b, j] in &self.near.pairs {
            let (a, i, b, j) = (a as usize, i as usize, b as usize, j as usize);
            let (one, other) = (&self.states[a], &self.states[b]);
            let distance = self.apart.distance + one.strand.margin + other.strand.margin;
            let segment = |state: &State, k: usize| [state.nodes[k].position, state.nodes[k + 1].position];
            let (p, q) = (segment(one, i), segment(other, j));
            let found = approach(p, q);
            let between = found.arm.length();
            let lack = distance - between;
            if lack <= 0.0 {
                continue;
            }
            let share = self.apart.weight * (p[0].distance(p[1]) * q[0].distance(q[1])).sqrt();
            cost += share * lack * lack;
            let push = -2.0 * share * lack * found.arm / between.max(1e-6);
            self.states[a].pulls[i].position += (1.0 - found.s) * push;
            self.states[a].pulls[i + 1].position += found.s * push;
            self.states[b].pulls[j].position -= (1.0 - found.t) * push;
            self.states[b].pulls[j + 1].position -= found.t * push;
        }
        cost
    }
}

impl State {
    fn of(world: &World, strand: Strand, first: usize) -> State {
        let mut nodes = vec![];
        world.tables.of(strand.course.points.len()).sample(&strand.course.points, &mut nodes);
        let length = if strand.held { 0 } else { Course::variable_count(strand.course.points.len()) };
        State {
            watch: Watch::over(&[], world.room, &[]),
            pulls: vec![Pull::default(); nodes.len()],
            nodes,
            by_points: vec![],
            gradient: vec![0.0; length],
            first,
            cost: 0.0,
            strand,
        }
    }

    fn measure(&mut self, world: &World, x: &[f64]) {
        let x = &x[self.first..][..self.gradient.len()];
        self.strand.course.set_variables(x);
        let points = &self.strand.course.points;
        world.tables.of(points.len()).sample(points, &mut self.nodes);
        let room = Some((world.room, &self.watch));
        let cost =
            costs::of_nodes(&self.nodes, &world.absorption, room, &self.strand.limits, &mut self.pulls);
        self.cost = cost.loss + cost.penalty;
    }

    fn pull_back(&mut self, world: &World, x: &[f64]) {
        let x = &x[self.first..][..self.gradient.len()];
        let course = &self.strand.course;
        self.by_points.clear();
        self.by_points.resize(course.points.len(), DVec3::ZERO);
        world.tables.of(course.points.len()).pull_back(&self.pulls, &mut self.by_points);
        self.gradient.fill(0.0);
        course.pull_back(x, &self.by_points, &mut self.gradient);
        self.cost += course.leg_cost(x, &mut self.gradient);
    }
}

/// Pairs of segments that are near, kept until something has moved far.
#[derive(Default)]
struct Near {
    /// Strand and segment, strand and segment.
    pairs: Vec<[u32; 4]>,
    /// Where the nodes were when the pairs were listed.
    places: Vec<Vec<DVec3>>,
}

/// Segments in a row that share a ball.
const ROW: usize = 6;
/// Listed beyond the distance to keep, mm.
const BEYOND: f64 = 3.0;

impl Near {
    fn update(&mut self, states: &[State], distance: f64) {
        let moved = |(state, places): (&State, &Vec<DVec3>)| {
            state
                .nodes
                .iter()
                .zip(places)
                .any(|(n, p)| n.position.distance_squared(*p) > 0.25 * BEYOND * BEYOND)
        };
        if self.places.len() == states.len() && !states.iter().zip(&self.places).any(moved) {
            return;
        }
        self.places = states.iter().map(|s| s.nodes.iter().map(|n| n.position).collect()).collect();
        let places = &self.places;
        let balls: Vec<Vec<Ball>> = places.iter().map(|places| Ball::along(places)).collect();
        let margin = states.iter().fold(0.0, |most: f64, s| most.max(s.strand.margin));
        let reach = distance + 2.0 * margin + BEYOND;
        let lists: Vec<Vec<[u32; 4]>> = (0..states.len())
            .map(|a| {
                let others = (0..a).filter(|&b| {
                    let (a, b) = (&states[a].strand, &states[b].strand);
                    a.pattern != b.pattern && !(a.held && b.held)
                });
                others.flat_map(|b| near_segments(a, b, places, &balls, reach)).collect()
            })
            .collect();
        self.pairs = lists.concat();
    }
}

fn near_segments(
    a: usize,
    b: usize,
    places: &[Vec<DVec3>],
    balls: &[Vec<Ball>],
    reach: f64,
) -> Vec<[u32; 4]> {
    let mut pairs = vec![];
    for one in &balls[a] {
        for other in &balls[b] {
            let limit = reach + one.radius + other.radius;
            if one.centre.distance_squared(other.centre) > limit * limit {
                continue;
            }
            for i in one.segments.clone() {
                for j in other.segments.clone() {
                    let segment = |s: usize, k: usize| [places[s][k], places[s][k + 1]];
                    if approach(segment(a, i), segment(b, j)).arm.length_squared() < reach * reach {
                        pairs.push([a as u32, i as u32, b as u32, j as u32]);
                    }
                }
            }
        }
    }
    pairs
}

/// A ball around some segments in a row.
struct Ball {
    centre: DVec3,
    radius: f64,
    segments: std::ops::Range<usize>,
}

impl Ball {
    fn along(places: &[DVec3]) -> Vec<Ball> {
        let last = places.len() - 1;
        let ball = |first: usize| {
            let end = (first + ROW).min(last);
            let covered = &places[first..=end];
            let centre = covered.iter().copied().sum::<DVec3>() / covered.len() as f64;
            let radius = covered.iter().fold(0.0, |r: f64, p| r.max(p.distance(centre)));
            Ball { centre, radius, segments: first..end }
        };
        (0..last).step_by(ROW).map(ball).collect()
    }
}
