//! Shortest ways through the room on a lattice of 26 neighbours: starts for courses, and what cannot be reached at all.

use crate::distance::Lattice;
use crate::room::Room;
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The lattice of places that ways run over.
pub struct Passages {
    lattice: Lattice,
    /// Slack at every point, mm.
    slack: Vec<f64>,
}

/// Shortest ways from one place to everywhere.
pub struct Ways<'a> {
    passages: &'a Passages,
    /// The point before each, itself at the source, none where no way leads.
    before: Vec<Option<u32>>,
    /// Length of the way, mm.
    length: Vec<f64>,
}

impl Passages {
    /// Samples a room every `spacing` mm.
    pub fn of(room: &Room, spacing: f64) -> Passages {
        let lattice = Lattice::around(room.surface().bounds(), spacing, spacing);
        let slack = (0..lattice.len()).map(|n| room.slack(lattice.place(n)).0).collect();
        Passages { lattice, slack }
    }

    /// Ways over points with at least `least_slack` mm, from the point nearest to a place; `extra` is the added cost of a mm
    /// at a point, relative to its length.
    pub fn from(&self, place: DVec3, least_slack: f64, extra: &impl Fn(usize) -> f64) -> Option<Ways<'_>> {
        let source = self.nearest(place, least_slack)?;
        let mut ways = Ways {
            passages: self,
            before: vec![None; self.lattice.len()],
            length: vec![f64::INFINITY; self.lattice.len()],
        };
        ways.before[source] = Some(source as u32);
        ways.length[source] = 0.0;
        let mut open = BinaryHeap::from([(Reverse(Ordered(0.0)), source)]);
        while let Some((Reverse(Ordered(length)), here)) = open.pop() {
            if length > ways.length[here] {
                continue;
            }
            for (next, step) in self.neighbours(here) {
                if self.slack[next] < least_slack {
                    continue;
                }
                let longer = length + step * (1.0 + extra(next));
                if longer < ways.length[next] {
                    ways.length[next] = longer;
                    ways.before[next] = Some(here as u32);
                    open.push((Reverse(Ordered(longer)), next));
                }
            }
        }
        Some(ways)
    }

    /// The lattice.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Slack at a point, mm.
    pub fn slack(&self, point: usize) -> f64 {
        self.slack[point]
    }

    /// The nearest point with enough slack, within three steps.
    fn nearest(&self, place: DVec3, least_slack: f64) -> Option<usize> {
        const STEPS: i64 = 3;
        let Lattice { origin, spacing, counts } = self.lattice;
        let at = ((place - origin) / spacing).round().as_i64vec3().to_array();
        let range = |axis: usize| {
            let last = counts[axis] as i64 - 1;
            (at[axis] - STEPS).clamp(0, last)..=(at[axis] + STEPS).clamp(0, last)
        };
        let points = range(2)
            .flat_map(|k| range(1).flat_map(move |j| range(0).map(move |i| ((k, j), i)).collect::<Vec<_>>()));
        points
            .map(|((k, j), i)| (k as usize * counts[1] + j as usize) * counts[0] + i as usize)
            .filter(|&n| self.slack[n] >= least_slack)
            .min_by(|&a, &b| {
                let distance = |n: usize| self.lattice.place(n).distance_squared(place);
                distance(a).total_cmp(&distance(b)).then(a.cmp(&b))
            })
    }

    /// The neighbours of a point and how far off they are, mm. The border of the lattice lies outside the body.
    fn neighbours(&self, point: usize) -> impl Iterator<Item = (usize, f64)> {
        let [nx, ny, nz] = self.lattice.counts.map(|n| n as i64);
        let spacing = self.lattice.spacing;
        let p = point as i64;
        let (i, j, k) = (p % nx, p / nx % ny, p / (nx * ny));
        (0..27i64).filter(|&n| n != 13).filter_map(move |n| {
            let (di, dj, dk) = (n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
            let (i, j, k) = (i + di, j + dj, k + dk);
            let inside = (0..nx).contains(&i) && (0..ny).contains(&j) && (0..nz).contains(&k);
            let step = spacing * ((di * di + dj * dj + dk * dk) as f64).sqrt();
            inside.then_some((((k * ny + j) * nx + i) as usize, step))
        })
    }
}

impl Ways<'_> {
    /// The way to a place, from the source on; none if no way leads there.
    pub fn to(&self, place: DVec3, least_slack: f64) -> Option<Vec<DVec3>> {
        let mut here = self.passages.nearest(place, least_slack)?;
        let mut way = vec![];
        loop {
            let before = self.before[here]? as usize;
            way.push(self.passages.lattice.place(here));
            if before == here {
                break;
            }
            here = before;
        }
        way.reverse();
        Some(way)
    }

    /// Length of the way to a place with its extra cost, mm; infinite if none leads there.
    pub fn length_to(&self, place: DVec3, least_slack: f64) -> f64 {
        self.passages.nearest(place, least_slack).map_or(f64::INFINITY, |n| self.length[n])
    }
}

/// A float with its total order.
#[derive(Clone, Copy, PartialEq)]
struct Ordered(f64);

impl Eq for Ordered {}

impl PartialOrd for Ordered {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Ordered {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}
