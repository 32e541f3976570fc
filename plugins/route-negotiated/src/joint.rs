//! All courses together: light, limits of each, and what it costs where two patterns come too close.
//!
//! Fibres push each other aside: every course is a variable of one smooth problem, and a pair of segments of different patterns that
//! is closer than it may be costs the square of what is lacking. Courses that start tangled can pass through each other while the
//! weight of that cost is small, and settle apart as it grows.

use crate::crowd::{Crowd, Segment};
use fibar_geometry::alone::{Watched, World};
use fibar_geometry::course::Course;
use fibar_geometry::course::costs::{self, Limits, Watch};
use fibar_geometry::course::nodes::{Node, Pull, Table};
use fibar_geometry::minimise::{MinimiseOptions, minimise};
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
    /// Where it is watched beside its nodes.
    pub watched: Watched,
    /// Whether it stays as it is.
    pub held: bool,
    /// Whether it is to stay so to the end, since it is the course of an earlier routing.
    pub kept: bool,
}

/// How far axes of different patterns keep apart, and what it costs if they do not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Apart {
    /// mm.
    pub distance: f64,
    /// Cost per mm of length and mm² of lacking distance.
    pub weight: f64,
}

impl Strand {
    /// Its axis as segments between nodes.
    pub fn segments(&self, world: &World) -> Vec<Segment> {
        let points = &self.course.points;
        let mut nodes = vec![];
        world.tables.of(points.len()).sample(points, &mut nodes);
        Segment::along(&nodes, self.pattern, self.margin).collect()
    }
}

/// Moves strands to a place of least cost among fibres that stay. Returns the cost.
pub fn settle_among(
    world: &World,
    still: &Crowd,
    strands: &mut [&mut Strand],
    apart: Apart,
    options: MinimiseOptions,
) -> f64 {
    let mut problem = Problem::of(world, still, strands, apart);
    let mut x: Vec<f64> = strands.iter().flat_map(|strand| strand.course.variables()).collect();
    let value = minimise(&mut |x, gradient| problem.cost(x, gradient), &mut x, options);
    for (strand, state) in strands.iter_mut().zip(&problem.states) {
        strand.course.set_variables(&x[state.first..][..state.gradient.len()]);
    }
    value
}

/// Moves all strands that are not held to a place of least cost.
pub fn settle(world: &World, strands: &mut [Strand], apart: Apart, options: MinimiseOptions) -> f64 {
    let mut still = Crowd::within(world.room.surface().bounds());
    strands.iter().filter(|strand| strand.held).for_each(|strand| still.push(strand.segments(world)));
    let mut free: Vec<&mut Strand> = strands.iter_mut().filter(|strand| !strand.held).collect();
    settle_among(world, &still, &mut free, apart, options)
}

/// The problem of one settling.
struct Problem<'a> {
    world: &'a World<'a>,
    still: &'a Crowd,
    apart: Apart,
    states: Vec<State>,
    near: Near,
}

/// Does something with every strand: on all threads if there are many.
fn for_each(states: &mut [State], each: impl Fn(&mut State) + Send + Sync) {
    const MANY: usize = 8;
    if states.len() >= MANY {
        states.par_iter_mut().for_each(each);
    } else {
        states.iter_mut().for_each(each);
    }
}

/// One strand with its memory.
struct State {
    strand: Strand,
    watch: Watch,
    bends: Table,
    bend_nodes: Vec<Node>,
    bend_pulls: Vec<Pull>,
    nodes: Vec<Node>,
    segments: Vec<Segment>,
    pulls: Vec<Pull>,
    by_points: Vec<DVec3>,
    gradient: Vec<f64>,
    /// Place of its variables among all.
    first: usize,
    cost: f64,
}

impl<'a> Problem<'a> {
    fn of(world: &'a World<'a>, still: &'a Crowd, strands: &[&mut Strand], apart: Apart) -> Problem<'a> {
        let mut first = 0;
        let mut states: Vec<State> = strands
            .iter()
            .map(|strand| {
                let state = State::of(world, (**strand).clone(), first);
                first += state.gradient.len();
                state
            })
            .collect();
        for_each(&mut states, |state| {
            state.watch = Watch::over(&state.nodes, world.room, &state.strand.watched.walls);
        });
        Problem { world, still, apart, states, near: Near::default() }
    }

    fn cost(&mut self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let world = self.world;
        for_each(&mut self.states, |state| state.measure(world, x));
        self.near.update(&self.states, self.still, self.world, self.apart.distance);
        let pairs = self.push_apart() + self.push_away();
        for_each(&mut self.states, |state| state.pull_back(world, x));
        for state in &self.states {
            gradient[state.first..][..state.gradient.len()].copy_from_slice(&state.gradient);
        }
        self.states.iter().fold(pairs, |sum, state| sum + state.cost)
    }

    /// What pairs of moving segments that are too close cost; adds to the pulls of their nodes.
    fn push_apart(&mut self) -> f64 {
        let Apart { distance, weight } = self.apart;
        let mut cost = 0.0;
        for &[a, i, b, j] in &self.near.moving {
            let [a, i, b, j] = [a, i, b, j].map(|k| k as usize);
            let (one, other) = (&self.states[a].segments[i], &self.states[b].segments[j]);
            if !one.may_touch(other, distance) {
                continue;
            }
            if let Some(push) = one.push(other, distance, weight) {
                cost += push.cost;
                self.states[a].pull(i, push.slopes[0]);
                self.states[b].pull(j, push.slopes[1]);
            }
        }
        cost
    }

    /// The same of moving segments and those that stay.
    fn push_away(&mut self) -> f64 {
        let Apart { distance, weight } = self.apart;
        let mut cost = 0.0;
        for &[a, i, b, j] in &self.near.still {
            let (a, i) = (a as usize, i as usize);
            let (one, other) = (&self.states[a].segments[i], self.still.segment([b, j]));
            if !one.may_touch(other, distance) {
                continue;
            }
            if let Some(push) = one.push(other, distance, weight) {
                cost += push.cost;
                self.states[a].pull(i, push.slopes[0]);
            }
        }
        cost
    }
}

impl State {
    fn of(world: &World, strand: Strand, first: usize) -> State {
        let mut nodes = vec![];
        world.tables.of(strand.course.points.len()).sample(&strand.course.points, &mut nodes);
        let length = Course::variable_count(strand.course.points.len());
        State {
            watch: Watch::over(&[], world.room, &[]),
            bends: Table::at(strand.course.points.len(), &strand.watched.bends),
            bend_nodes: vec![],
            bend_pulls: vec![],
            segments: vec![],
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
        self.segments.clear();
        self.segments.extend(Segment::along(&self.nodes, self.strand.pattern, self.strand.margin));
        let room = Some((world.room, &self.watch));
        let cost =
            costs::of_nodes(&self.nodes, &world.absorption, room, &self.strand.limits, &mut self.pulls);
        self.bends.sample(points, &mut self.bend_nodes);
        let bent = costs::of_bends(&self.bend_nodes, &self.strand.limits, &mut self.bend_pulls);
        self.cost = cost.loss + cost.penalty + bent;
    }

    /// Adds to the pulls of the nodes of a segment.
    fn pull(&mut self, segment: usize, slopes: [DVec3; 2]) {
        self.pulls[segment].position += slopes[0];
        self.pulls[segment + 1].position += slopes[1];
    }

    fn pull_back(&mut self, world: &World, x: &[f64]) {
        let x = &x[self.first..][..self.gradient.len()];
        let course = &self.strand.course;
        self.by_points.clear();
        self.by_points.resize(course.points.len(), DVec3::ZERO);
        world.tables.of(course.points.len()).pull_back(&self.pulls, &mut self.by_points);
        self.bends.pull_back(&self.bend_pulls, &mut self.by_points);
        self.gradient.fill(0.0);
        course.pull_back(x, &self.by_points, &mut self.gradient);
        self.cost += course.leg_cost(x, &mut self.gradient);
    }
}

/// Pairs of segments that are near, kept until something has moved far.
#[derive(Default)]
struct Near {
    /// The moving strands where they were when the pairs were listed; empty if there is only one.
    crowd: Option<Crowd>,
    /// Moving strand and its segment, another moving strand and its segment.
    moving: Vec<[u32; 4]>,
    /// Moving strand and its segment, still strand and its segment.
    still: Vec<[u32; 4]>,
    /// Where the nodes were when the pairs were listed.
    places: Vec<Vec<DVec3>>,
}

/// Listed beyond the distance to keep, mm.
const BEYOND: f64 = 2.0;

impl Near {
    fn update(&mut self, states: &[State], still: &Crowd, world: &World, distance: f64) {
        let moved = |(state, places): (&State, &Vec<DVec3>)| {
            let far = |(n, p): (&Node, &DVec3)| n.position.distance_squared(*p) > 0.25 * BEYOND * BEYOND;
            state.nodes.iter().zip(places).any(far)
        };
        if self.places.len() == states.len() && !states.iter().zip(&self.places).any(moved) {
            return;
        }
        self.places = states.iter().map(|s| s.nodes.iter().map(|n| n.position).collect()).collect();
        self.moving.clear();
        self.still.clear();
        let reach = distance + BEYOND;
        for (a, state) in (0..).zip(states) {
            for (i, segment) in (0..).zip(&state.segments) {
                still.for_each_near(segment, reach, |[b, j], _| self.still.push([a, i, b, j]));
            }
        }
        if states.len() < 2 {
            return;
        }
        let crowd = self.crowd.get_or_insert_with(|| Crowd::within(world.room.surface().bounds()));
        crowd.clear();
        for (a, state) in (0..).zip(states) {
            for (i, segment) in (0..).zip(&state.segments) {
                crowd.for_each_near(segment, reach, |[b, j], _| self.moving.push([a, i, b, j]));
            }
            crowd.push(state.segments.clone());
        }
    }
}
