//! Collapses edges, cheapest first, as long as the surface stays near where it was.

use crate::base::{Base, Room};
use crate::quadric::Quadric;
use crate::web::{Ring, Web};
use crate::witnesses::Witnesses;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::distance::{Surface, distance_to_triangle};
use fibar_plugin::StageError;
use glam::DVec3;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A triangle must not turn by more than about 78°: the cosine.
const LEAST_TURN: f64 = 0.2;
/// Height over longest side that a triangle keeps, unless it was flatter before.
const LEAST_HEIGHT: f64 = 0.02;
/// All edges are tried again as long as that brings this share of the triangles.
const WORTHWHILE: f64 = 0.005;
/// Triangles around a new vertex: more only make all that follows there slower.
const CROWD: usize = 24;
/// Witnesses of a ring that are asked before all others.
const SCOUTS: usize = 24;
/// A witness that is this near to a triangle lies on it, mm.
const TOUCHING_MM: f64 = 1e-9;
/// A new vertex lies at most so many lengths of its edge away from it.
const FARTHEST: f64 = 2.0;

/// A surface that loses triangles.
pub struct Collapse<'a> {
    web: Web,
    quadrics: Vec<Quadric>,
    witnesses: Witnesses,
    base: Base,
    before: &'a Surface,
    /// Changes of each vertex: an edge in the queue is stale once one of its ends has changed.
    changes: Vec<u32>,
    queue: BinaryHeap<Reverse<Entry>>,
}

/// Cost as bits (no cost is negative), ends, and the changes of both when it was queued.
type Entry = (u64, [u32; 2], u32);

/// A collapse that keeps to the limits: the place of the vertex, and who holds which witness then.
struct Move {
    place: DVec3,
    hands: Vec<(u32, u32)>,
}

impl<'a> Collapse<'a> {
    /// A closed mesh, its surface, and the witnesses of it.
    pub fn of(mesh: &TriangleMesh, before: &'a Surface, witnesses: Witnesses) -> Collapse<'a> {
        let web = Web::of(mesh);
        let quadric = |v: u32| {
            let own = |&t: &u32| {
                let corner = web.triangles[t as usize].iter().position(|&w| w == v).expect("a fan's corner");
                Quadric::of_corner(web.corners(t), corner)
            };
            web.fan(v).iter().map(own).fold(Quadric::default(), |a, b| a + b)
        };
        let count = mesh.vertices.len();
        let quadrics = (0..count as u32).into_par_iter().map(quadric).collect();
        let changes = vec![0; count];
        let base = Base::of(mesh);
        Collapse { web, quadrics, witnesses, base, before, changes, queue: BinaryHeap::new() }
    }

    /// Collapses down to `fewest` triangles or as far as it goes; `tick` hears how many are left, and may end it.
    pub fn run(
        mut self,
        fewest: usize,
        tick: &mut impl FnMut(usize) -> Result<(), StageError>,
    ) -> Result<TriangleMesh, StageError> {
        loop {
            let before = self.web.left();
            self.fill_queue();
            while let Some(Reverse((_, edge, stamp))) = self.queue.pop() {
                if self.web.left() <= fewest {
                    return Ok(self.web.mesh());
                }
                if stamp == self.stamp(edge) && self.try_edge(edge) {
                    tick(self.web.left())?;
                }
            }
            if ((before - self.web.left()) as f64) < WORTHWHILE * before as f64 {
                return Ok(self.web.mesh());
            }
        }
    }

    fn fill_queue(&mut self) {
        let edges = self.web.edges();
        let entries: Vec<Reverse<Entry>> =
            edges.into_par_iter().map(|edge| Reverse(self.entry(edge))).collect();
        self.queue = BinaryHeap::from(entries);
    }

    fn stamp(&self, edge: [u32; 2]) -> u32 {
        let gone = edge.iter().any(|&v| self.web.fan(v).is_empty());
        if gone { u32::MAX } else { edge.iter().map(|&v| self.changes[v as usize]).sum() }
    }

    fn entry(&self, edge: [u32; 2]) -> Entry {
        let sum = self.sum(edge);
        let ends = edge.map(|v| self.web.places[v as usize]);
        let place = sum.lowest().filter(|&place| is_near(place, ends)).unwrap_or((ends[0] + ends[1]) * 0.5);
        (sum.at(place).to_bits(), edge, self.stamp(edge))
    }

    fn sum(&self, [u, v]: [u32; 2]) -> Quadric {
        self.quadrics[u as usize] + self.quadrics[v as usize]
    }

    fn try_edge(&mut self, edge: [u32; 2]) -> bool {
        let Some(ring) = self.web.ring(edge).filter(|ring| ring.kept.len() <= CROWD) else { return false };
        let Some(found) = self.best_move(edge, &ring) else { return false };
        self.web.collapse(edge, &ring, found.place);
        ring.gone.iter().chain(&ring.kept).for_each(|&t| self.witnesses.release(t));
        found.hands.into_iter().for_each(|(witness, t)| self.witnesses.hand(witness, t));
        let [keep, _] = edge;
        self.base.merge(edge);
        self.quadrics[keep as usize] = self.sum(edge);
        self.changes[keep as usize] += 1;
        for other in self.web.neighbours(keep) {
            let entry = self.entry([keep.min(other), keep.max(other)]);
            self.queue.push(Reverse(entry));
        }
        true
    }

    /// The first place, best first, where the two ends can lie together.
    fn best_move(&self, edge: [u32; 2], ring: &Ring) -> Option<Move> {
        let room = self.base.room(&self.web, edge, ring);
        let ends = edge.map(|v| self.web.places[v as usize]);
        let sum = self.sum(edge);
        let lowest = match room {
            Room::Nowhere => return None,
            Room::End(end) => return self.examine(edge, ring, ends[end]),
            Room::Plane(z) => sum.lowest_at_height(z),
            Room::Anywhere => sum.lowest(),
        };
        let better = usize::from(sum.distance_at(ends[1]) < sum.distance_at(ends[0]));
        let lowest =
            lowest.filter(|&place| is_near(place, ends)).and_then(|place| self.base.admit(place, room));
        let within = |place: DVec3| if let Room::Plane(z) = room { place.with_z(z) } else { place };
        let mut tried: Option<DVec3> = None;
        let mut attempt = |place: DVec3| {
            let same = |tried: DVec3| tried.distance(place) < 1e-3 * ends[0].distance(ends[1]);
            if tried.is_some_and(same) {
                return None;
            }
            tried = Some(place);
            self.examine(edge, ring, place)
        };
        // A corner of flat faces stays where it is, to the bit.
        let corner = lowest.filter(|&place| sum.distance_at(place) >= sum.distance_at(ends[better]));
        let by_planes = corner.and_then(|_| attempt(ends[better]));
        let by_planes = by_planes.or_else(|| lowest.and_then(|place| attempt(within(place))));
        // Quadrics put vertices outside of what bulges: nearer to the surface there may be room yet.
        let nearer = by_planes.or_else(|| {
            let (place, on) = lowest.map(|place| (place, self.before.foot(place)))?;
            attempt(within(place.lerp(on, 0.5))).or_else(|| attempt(within(on)))
        });
        nearer.or_else(|| attempt(ends[better])).or_else(|| attempt(ends[1 - better]))
    }

    /// Whether the surface stays near where it was if the ends of an edge come to lie at a place.
    fn examine(&self, edge: [u32; 2], ring: &Ring, place: DVec3) -> Option<Move> {
        let after: Vec<[DVec3; 3]> =
            ring.kept.iter().map(|&t| self.web.corners_after(t, edge, place)).collect();
        let mut shapes = ring.kept.iter().zip(&after);
        if !shapes.all(|(&t, after)| keeps_shape(self.web.corners(t), *after)) {
            return None;
        }
        let (hands, reach) = self.hand_over(ring, &after)?;
        let stays = |(k, corners): (usize, &[DVec3; 3])| {
            probes(*corners, place).into_iter().all(|point| self.is_near_before(point, reach, k, &hands))
        };
        let stays = self.is_near_before(place, reach, 0, &hands) && after.iter().enumerate().all(stays);
        let hands = hands.into_iter().map(|(witness, k)| (witness, ring.kept[k]));
        stays.then(|| Move { place, hands: hands.collect() })
    }

    /// Whether a point lies near the surface as it came, which is first asked of where the nearest witness of a triangle stood.
    fn is_near_before(&self, point: DVec3, reach: f64, holder: usize, hands: &[(u32, usize)]) -> bool {
        let own = hands.iter().filter(|hand| hand.1 == holder).map(|hand| hand.0);
        let away = |&witness: &u32| self.witnesses.all[witness as usize].place.distance_squared(point);
        let nearest = own.min_by(|a, b| away(a).total_cmp(&away(b)));
        let is_there = |&t: &u32| distance_to_triangle(point, self.before.corners(t)) <= reach;
        nearest.is_some_and(|witness| self.witnesses.stood_on(witness).iter().any(is_there))
            || self.before.nearest_within(point, reach).is_some()
    }

    /// Who of a ring would hold each of its witnesses, by number among those kept, and the least that any of them allows.
    fn hand_over(&self, ring: &Ring, after: &[[DVec3; 3]]) -> Option<(Vec<(u32, usize)>, f64)> {
        let numbers: Vec<u32> =
            ring.gone.iter().chain(&ring.kept).flat_map(|&t| self.witnesses.held_by(t)).copied().collect();
        let allows = |&number: &u32| {
            let witness = self.witnesses.all[number as usize];
            let (holder, distance) = nearest(witness.place, after);
            (distance <= witness.reach).then_some((number, holder))
        };
        // Most of what cannot be is seen by a few.
        if numbers.iter().step_by(1 + numbers.len() / SCOUTS).any(|number| allows(number).is_none()) {
            return None;
        }
        let hands: Vec<(u32, usize)> = numbers.iter().map(allows).collect::<Option<_>>()?;
        let reaches = hands.iter().map(|hand| self.witnesses.all[hand.0 as usize].reach);
        let least = reaches.fold(self.witnesses.reach, f64::min);
        Some((hands, least))
    }
}

/// The nearest triangle of a list, and its distance; the first one that a place lies on.
fn nearest(place: DVec3, triangles: &[[DVec3; 3]]) -> (usize, f64) {
    let mut best = (0, f64::INFINITY);
    for (k, corners) in triangles.iter().enumerate() {
        let distance = distance_to_triangle(place, *corners);
        if distance < best.1 {
            best = (k, distance);
        }
        if distance <= TOUCHING_MM {
            break;
        }
    }
    best
}

fn is_near(place: DVec3, [a, b]: [DVec3; 2]) -> bool {
    place.distance(a).min(place.distance(b)) <= FARTHEST * a.distance(b)
}

/// Whether a triangle neither turns over nor degenerates.
fn keeps_shape(before: [DVec3; 3], after: [DVec3; 3]) -> bool {
    let (old, new) = (normal(before), normal(after));
    let turned = old.dot(new) < LEAST_TURN * old.length() * new.length();
    !turned && new != DVec3::ZERO && height(after) >= height(before).min(LEAST_HEIGHT)
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Height over longest side; 0 for a needle or a point.
fn height([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    if longest > 0.0 { normal([a, b, c]).length() / longest } else { 0.0 }
}

/// Points of a new triangle that are held against the surface as it came: its middle, and those of the sides at the new vertex.
fn probes(corners: [DVec3; 3], place: DVec3) -> [DVec3; 3] {
    let [a, b, c] = corners;
    let sides = [[a, b], [b, c], [c, a]].into_iter().filter(|side| side.contains(&place));
    let mut middles = sides.map(|[p, q]| (p + q) * 0.5);
    [(a + b + c) / 3.0, middles.next().unwrap_or(place), middles.next().unwrap_or(place)]
}
