//! Which sites become markers and what they blink: greedily, then by annealing. With light, LEDs are chosen along with places, so that
//! fibres are bright and not in each other's way; without, the codes beside the m-sequence are left to `codes`.

use crate::annealing::Cooling;
use crate::clashes::{Clashes, GRAIN_MM2, LOSS_PER_MM2};
use crate::codes::M_SEQUENCE;
use crate::coverage::Coverage;
use crate::regions::Regions;
use fibar_core::artefact::sites::Sites;
use fibar_plugin::StageError;
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

/// Share of the moves that bring a marker to another site; the others change who blinks what.
const RELOCATIONS: f64 = 0.7;
/// Sites around a marker among which half of its relocations end.
const VICINITY: usize = 24;
/// Temperatures at the beginning and at the end, in the unit of `Coverage::cost`.
const HEAT: (f64, f64) = (0.5, 0.005);

/// A mean loss `∫a ds` of 1 by clashes, in the unit of `Coverage::cost`.
const CLASHING: f64 = 50.0;
/// A marker too few or too many in a region, in the unit of `Coverage::cost`: more than anything that one marker brings.
const MISPLACED: f64 = 100.0;

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
    codes: u8,
    /// Whose fibres are in each other's way, and how much that weighs.
    clashes: Option<(&'a Clashes, f64)>,
    /// Sum over all pairs of markers, in multiples of [`GRAIN_MM2`].
    clash: u64,
    /// How many markers are where.
    regions: Regions<'a>,
}

/// What a choice is made of and for.
#[derive(Clone)]
pub struct Terms<'a> {
    /// Which sites crowd each other.
    pub crowd: &'a Crowd,
    /// Codes that places are chosen with, the m-sequence included.
    pub codes: u8,
    /// Whose fibres are in each other's way, and how much that weighs.
    pub clashes: Option<(&'a Clashes, f64)>,
    /// How many markers.
    pub wanted: usize,
    /// How many of them where.
    pub regions: Regions<'a>,
}

impl<'a> Choice<'a> {
    /// Markers one by one where each brings most, up to `wanted` or until nothing is free, then m-sequences until no further one
    /// brings anything.
    pub fn greedy(coverage: Coverage<'a>, terms: Terms<'a>) -> Choice<'a> {
        let Terms { crowd, codes, clashes, wanted, regions } = terms;
        let blocked = vec![0; crowd.rivals.len()];
        let mut choice =
            Choice { coverage, markers: Vec::new(), crowd, blocked, codes, clashes, clash: 0, regions };
        while choice.markers.len() < wanted {
            let reached = |k: usize| !choice.coverage.is_hopeless(k, choice.coverage.brightest_companion(k));
            let free = (0..choice.blocked.len()).filter(|&k| choice.is_free(k) && reached(k));
            let Some((_, best)) = choice.best_of(free.collect(), |c, site| c.brightest_companion(site))
            else {
                break;
            };
            choice.put(best);
        }
        loop {
            let companions = choice.markers.iter().copied();
            let open = |k: usize| {
                !choice.coverage.blinks_m_sequence(k) && !choice.coverage.is_hopeless(k, M_SEQUENCE)
            };
            let companions = companions.filter(|&k| open(k)).collect();
            let before = choice.cost();
            match choice.best_of(companions, |_, _| M_SEQUENCE) {
                Some((cost, best)) if cost < before => choice.carry(best, Some(M_SEQUENCE)),
                _ => return choice,
            }
        }
    }

    /// How bad the choice is, in the unit of `Coverage::cost`.
    pub fn cost(&self) -> f64 {
        let weight = self.clashes.map_or(0.0, |(_, weight)| weight);
        self.coverage.cost()
            + weight * CLASHING * self.mean_clash_loss()
            + MISPLACED * self.regions.off() as f64
    }

    /// An error if a region has too few markers or too many.
    pub fn check_regions(&self) -> Result<(), StageError> {
        self.regions.check()
    }

    /// What a marker's fibre loses in the mean to those in its way, `∫a ds`.
    pub fn mean_clash_loss(&self) -> f64 {
        self.clash as f64 * GRAIN_MM2 * LOSS_PER_MM2 / self.markers.len().max(1) as f64
    }

    /// Changes what a site carries.
    fn carry(&mut self, site: usize, code: Option<u8>) {
        self.clash -= self.clash_of(site);
        if self.coverage.carried(site).is_some() != code.is_some() {
            self.regions.count(site, code.is_some());
        }
        self.coverage.carry(site, code);
        self.clash += self.clash_of(site);
    }

    /// With the fibres of all others, as the site is now.
    fn clash_of(&self, site: usize) -> u64 {
        let Some(((clashes, _), code)) = self.clashes.zip(self.coverage.carried(site)) else { return 0 };
        let others = self.markers.iter().filter(|&&other| other != site);
        let with = |&other: &usize| {
            let carried = self.coverage.carried(other);
            carried.map_or(0, |blinks| u64::from(clashes.between((site, code), (other, blinks))))
        };
        others.map(with).sum()
    }

    /// The site where the code that `code` names for it costs least, and that cost; of equals the first.
    fn best_of(&mut self, sites: Vec<usize>, code: impl Fn(&Coverage, usize) -> u8) -> Option<(f64, usize)> {
        let mut best: Option<(f64, usize)> = None;
        for site in sites {
            let before = self.coverage.carried(site);
            let next = code(&self.coverage, site);
            self.carry(site, Some(next));
            let cost = self.cost();
            self.carry(site, before);
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
        let (mut cost, mut least) = (self.cost(), best.cost());
        for _ in 0..moves {
            let Some(change) = self.draw_change(&mut rng) else { continue };
            self.make(change);
            let next = self.cost();
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
        let site = self.markers[slot];
        let code = self.coverage.carried(site)?;
        if rng.random::<f64>() < RELOCATIONS {
            let to = match rng.random::<bool>() {
                true => *self.crowd.vicinity[site].choose(rng)?,
                false => rng.random_range(0..self.blocked.len()),
            };
            let blocked_by_others = self.blocked[to] - u32::from(self.crowd.rivals[to].contains(&site));
            let free = blocked_by_others == 0 && self.coverage.carried(to).is_none();
            let recode = code != M_SEQUENCE && rng.random::<bool>();
            let there = if recode { self.coverage.brightest_companion(to) } else { code };
            let reached = !self.coverage.is_hopeless(to, there);
            return (free && reached).then_some(Change::Move { slot, from: (site, code), to: (to, there) });
        }
        if rng.random::<bool>() {
            let drawn = rng.random_range(M_SEQUENCE..=self.codes.max(M_SEQUENCE + 1));
            let new = drawn != code && !self.coverage.is_hopeless(site, drawn);
            return new.then_some(Change::Recode { site, from: code, to: drawn });
        }
        let other = *self.markers.choose(rng)?;
        let codes = [code, self.coverage.carried(other)?];
        let reached =
            !self.coverage.is_hopeless(site, codes[1]) && !self.coverage.is_hopeless(other, codes[0]);
        (codes[0] != codes[1] && reached).then_some(Change::Swap { sites: [site, other], codes })
    }

    fn make(&mut self, change: Change) {
        match change {
            Change::Move { slot, from: (from, _), to: (to, code) } => {
                self.carry(from, None);
                self.block(from, false);
                self.markers[slot] = to;
                self.carry(to, Some(code));
                self.block(to, true);
            }
            Change::Recode { site, to, .. } => self.carry(site, Some(to)),
            Change::Swap { sites, codes } => {
                self.carry(sites[0], Some(codes[1]));
                self.carry(sites[1], Some(codes[0]));
            }
        }
    }

    fn is_free(&self, site: usize) -> bool {
        self.blocked[site] == 0 && self.coverage.carried(site).is_none() && !self.regions.is_full_at(site)
    }

    fn put(&mut self, site: usize) {
        self.markers.push(site);
        self.carry(site, Some(self.coverage.brightest_companion(site)));
        self.block(site, true);
    }

    fn block(&mut self, site: usize, put: bool) {
        for &rival in &self.crowd.rivals[site] {
            self.blocked[rival] = if put { self.blocked[rival] + 1 } else { self.blocked[rival] - 1 };
        }
    }
}

/// A step to a neighbouring choice; sites with their codes.
#[derive(Clone, Copy)]
enum Change {
    Move { slot: usize, from: (usize, u8), to: (usize, u8) },
    Recode { site: usize, from: u8, to: u8 },
    Swap { sites: [usize; 2], codes: [u8; 2] },
}

impl Change {
    fn reversed(self) -> Change {
        match self {
            Change::Move { slot, from, to } => Change::Move { slot, from: to, to: from },
            Change::Recode { site, from, to } => Change::Recode { site, from: to, to: from },
            Change::Swap { sites, codes: [one, other] } => Change::Swap { sites, codes: [other, one] },
        }
    }
}
