//! Which sites become markers and which of them blink the m-sequence: greedily, then by annealing.

use crate::annealing::Cooling;
use crate::coverage::{Blink, Coverage};
use fibar_core::artefact::sites::Sites;
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

/// Share of the moves that bring a marker to another site; the others change who blinks the m-sequence.
const RELOCATIONS: f64 = 0.7;
/// Sites around a marker among which half of its relocations end.
const VICINITY: usize = 24;
/// Temperatures at the beginning and at the end, in the unit of `Coverage::cost`.
const HEAT: (f64, f64) = (0.5, 0.005);

/// Who stands in whose way, and who is near.
pub struct Crowd {
    /// For every site, others nearer than the spacing.
    rivals: Vec<Vec<usize>>,
    /// For every site, the nearest others.
    vicinity: Vec<Vec<usize>>,
}

impl Crowd {
    /// The sites and a straight spacing, mm.
    pub fn new(sites: &Sites, spacing: f64) -> Crowd {
        let gap = |a: usize, b: usize| sites.sites[a].position.distance(sites.sites[b].position);
        let all = 0..sites.sites.len();
        let others = |a: usize| all.clone().filter(move |&b| b != a);
        let vicinity = |a: usize| {
            let mut near: Vec<usize> = others(a).collect();
            near.sort_by(|&b, &c| gap(a, b).total_cmp(&gap(a, c)).then(b.cmp(&c)));
            near.truncate(VICINITY);
            near
        };
        Crowd {
            rivals: all.clone().map(|a| others(a).filter(|&b| gap(a, b) < spacing).collect()).collect(),
            vicinity: all.clone().map(vicinity).collect(),
        }
    }
}

/// A choice on the way to a better one.
#[derive(Clone)]
pub struct Choice<'a> {
    /// What it is worth.
    pub coverage: Coverage<'a>,
    /// Sites with a marker.
    pub markers: Vec<usize>,
    crowd: &'a Crowd,
    /// For every site, markers nearer than the spacing.
    blocked: Vec<u32>,
}

impl<'a> Choice<'a> {
    /// Markers one by one where each brings most, up to `wanted` or until nothing is free, then m-sequences until no further one
    /// brings anything.
    pub fn greedy(coverage: Coverage<'a>, crowd: &'a Crowd, wanted: usize) -> Choice<'a> {
        let blocked = vec![0; crowd.rivals.len()];
        let mut choice = Choice { coverage, markers: Vec::new(), crowd, blocked };
        while choice.markers.len() < wanted {
            let free = (0..choice.blocked.len()).filter(|&k| choice.is_free(k));
            let Some((_, best)) = choice.best_of(free.collect(), Blink::Companion) else { break };
            choice.put(best, Blink::Companion);
        }
        loop {
            let companions = choice.markers.iter().copied();
            let companions =
                companions.filter(|&k| choice.coverage.carried(k) == Some(Blink::Companion)).collect();
            let before = choice.coverage.cost();
            match choice.best_of(companions, Blink::MSequence) {
                Some((cost, best)) if cost < before => choice.coverage.carry(best, Some(Blink::MSequence)),
                _ => return choice,
            }
        }
    }

    /// The site where a blink costs least, and that cost; of equals the first.
    fn best_of(&mut self, sites: Vec<usize>, blink: Blink) -> Option<(f64, usize)> {
        let mut best: Option<(f64, usize)> = None;
        for site in sites {
            let before = self.coverage.carried(site);
            self.coverage.carry(site, Some(blink));
            let cost = self.coverage.cost();
            self.coverage.carry(site, before);
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, site));
            }
        }
        best
    }

    /// Improves the choice by random changes; the best choice on the way.
    pub fn anneal(mut self, moves: u32, mut rng: ChaCha8Rng) -> Choice<'a> {
        let mut cooling = Cooling::new(HEAT.0, HEAT.1, moves);
        let mut best = self.clone();
        let (mut cost, mut least) = (self.coverage.cost(), best.coverage.cost());
        for _ in 0..moves {
            let Some(change) = self.draw_change(&mut rng) else { continue };
            self.make(change);
            let next = self.coverage.cost();
            if !cooling.takes(next - cost, &mut rng) {
                self.make(change.reversed());
                continue;
            }
            cost = next;
            if cost < least {
                (best, least) = (self.clone(), cost);
            }
        }
        best
    }

    fn draw_change(&self, rng: &mut ChaCha8Rng) -> Option<Change> {
        let slot = rng.random_range(0..self.markers.len());
        if rng.random::<f64>() < RELOCATIONS {
            let from = self.markers[slot];
            let to = match rng.random::<bool>() {
                true => *self.crowd.vicinity[from].choose(rng)?,
                false => rng.random_range(0..self.blocked.len()),
            };
            let blocked_by_others = self.blocked[to] - u32::from(self.crowd.rivals[to].contains(&from));
            let free = blocked_by_others == 0 && self.coverage.carried(to).is_none();
            return free.then_some(Change::Move { slot, from, to });
        }
        let site = self.markers[slot];
        if rng.random::<bool>() {
            return Some(Change::Toggle { site });
        }
        let other = *self.markers.choose(rng)?;
        (self.coverage.carried(site) != self.coverage.carried(other)).then_some(Change::Swap { site, other })
    }

    fn make(&mut self, change: Change) {
        match change {
            Change::Move { slot, from, to } => {
                let blink = self.coverage.carried(from);
                self.coverage.carry(from, None);
                self.coverage.carry(to, blink);
                self.block(from, false);
                self.block(to, true);
                self.markers[slot] = to;
            }
            Change::Toggle { site } => self.toggle(site),
            Change::Swap { site, other } => {
                self.toggle(site);
                self.toggle(other);
            }
        }
    }

    fn toggle(&mut self, site: usize) {
        let toggled = match self.coverage.carried(site) {
            Some(Blink::MSequence) => Blink::Companion,
            _ => Blink::MSequence,
        };
        self.coverage.carry(site, Some(toggled));
    }

    fn is_free(&self, site: usize) -> bool {
        self.blocked[site] == 0 && self.coverage.carried(site).is_none()
    }

    fn put(&mut self, site: usize, blink: Blink) {
        self.coverage.carry(site, Some(blink));
        self.block(site, true);
        self.markers.push(site);
    }

    fn block(&mut self, site: usize, put: bool) {
        for &rival in &self.crowd.rivals[site] {
            self.blocked[rival] = if put { self.blocked[rival] + 1 } else { self.blocked[rival] - 1 };
        }
    }
}

/// A step to a neighbouring choice.
#[derive(Clone, Copy)]
enum Change {
    Move { slot: usize, from: usize, to: usize },
    Toggle { site: usize },
    Swap { site: usize, other: usize },
}

impl Change {
    fn reversed(self) -> Change {
        match self {
            Change::Move { slot, from, to } => Change::Move { slot, from: to, to: from },
            same => same,
        }
    }
}
