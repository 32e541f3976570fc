//! Which code each marker blinks: annealing on how easily two markers of one code are taken for one another.
//!
//! `Σ_{p<q} Σ_{i,j} share(p,i) share(q,j) β^d(i,j)` over all pairs of markers of one code, where `i` and `j` are rings of neighbours
//! of `p` and of `q`, and `d` is the least Levenshtein distance over all rotations between the codes in them: markers
//! that look alike at some roll, also when some of their neighbours are missing, should not blink alike. With light, what each marker
//! falls short of the goal counts too.

use crate::annealing::Cooling;
use crate::clashes::{Clashes, GRAIN_MM2, LOSS_PER_MM2};
use crate::coverage::HOPELESS;
use crate::light::Light;
use crate::rings::Rings;
use fibar_core::levenshtein::Needle;
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

/// `β^d` for `d` = 0, 1, …; nothing beyond.
const ALIKE: [f64; 4] = [1.0, 0.25, 0.0625, 0.015625];
/// A marker more than the mean on one code costs so much times the square of the difference: an LED's light is shared.
const CROWDED: f64 = 0.02;
/// Temperatures at the beginning and at the end, in the unit of the cost.
const HEAT: (f64, f64) = (0.1, 0.001);
/// The number of the m-sequence.
pub const M_SEQUENCE: u8 = 1;

/// A marker in the dark costs so much; two markers that look the same cost 1.
const DARK: f64 = 5.0;
/// A loss `∫a ds` of 1 by clashes.
const CLASHING: f64 = 1.5;

/// Codes by marker, and how much they confuse.
#[derive(Clone)]
pub struct Codes<'a> {
    rings: &'a Rings,
    seen_from: &'a [Vec<usize>],
    /// The code of each marker, from 1.
    pub genes: Vec<u8>,
    counts: Vec<usize>,
    lit: Lit<'a>,
    read: Vec<Vec<Needle>>,
    /// For every two markers, how alike they are if they blink alike; 0 if not. Only `p < q` is used.
    alike: Vec<f64>,
}

/// What is known of light, beside which codes are chosen.
#[derive(Clone, Copy, Default)]
pub struct Lit<'a> {
    /// What each marker could get, and how much that weighs.
    pub light: Option<(&'a Light, f64)>,
    /// Whose fibres are in each other's way, and how much that weighs.
    pub clashes: Option<(&'a Clashes, f64)>,
    /// The site of each marker.
    pub sites: &'a [usize],
}

impl<'a> Codes<'a> {
    /// Codes to begin with; `patterns` of them exist.
    pub fn new(
        rings: &'a Rings,
        seen_from: &'a [Vec<usize>],
        genes: Vec<u8>,
        patterns: u8,
        lit: Lit<'a>,
    ) -> Codes<'a> {
        let markers = rings.len();
        let mut counts = vec![0; usize::from(patterns) + 1];
        genes.iter().for_each(|&g| counts[usize::from(g)] += 1);
        let alike = vec![0.0; markers * markers];
        let read = vec![Vec::new(); markers];
        let mut codes = Codes { rings, seen_from, genes, counts, lit, read, alike };
        codes.refresh(&(0..markers).collect::<Vec<_>>());
        codes
    }

    /// What annealing makes smaller.
    pub fn cost(&self) -> f64 {
        let markers = self.genes.len();
        let mean = markers as f64 / (self.counts.len() - 1) as f64;
        let crowd = |&count: &usize| (count as f64 - mean).max(0.0) * (count as f64 - mean).max(0.0);
        let dark = self.lit.light.map_or(0.0, |(light, weight)| weight * DARK * self.shortage(light));
        let crowded = CROWDED * self.counts[1..].iter().map(crowd).sum::<f64>();
        let lost = self.lit.clashes.map_or(0.0, |(_, weight)| weight * CLASHING * self.clash_loss());
        self.confusion() + crowded + dark + lost
    }

    /// What all fibres lose to those in their way, `∫a ds`.
    pub fn clash_loss(&self) -> f64 {
        let Some((clashes, _)) = self.lit.clashes else { return 0.0 };
        let fibres: Vec<(usize, u8)> =
            self.lit.sites.iter().copied().zip(self.genes.iter().copied()).collect();
        let pairs = fibres.iter().enumerate().flat_map(|(k, a)| fibres[..k].iter().map(move |b| (*a, *b)));
        let sum: u64 = pairs.map(|(a, b)| u64::from(clashes.between(a, b))).sum();
        sum as f64 * GRAIN_MM2 * LOSS_PER_MM2
    }

    /// What all markers together fall short of the goal.
    fn shortage(&self, light: &Light) -> f64 {
        let short = |(marker, &code): (usize, &u8)| {
            light.shortage(marker, code, self.counts[usize::from(code)] as f64)
        };
        self.genes.iter().enumerate().map(short).sum()
    }

    /// The sum over all pairs of markers of one code.
    pub fn confusion(&self) -> f64 {
        let markers = self.genes.len();
        (0..markers).map(|p| self.alike[p * markers + p + 1..(p + 1) * markers].iter().sum::<f64>()).sum()
    }

    /// Improves the codes of the markers that do not blink the m-sequence; the best on the way.
    pub fn anneal(mut self, moves: u32, mut rng: ChaCha8Rng) -> Codes<'a> {
        let mut cooling = Cooling::new(HEAT.0, HEAT.1, moves);
        let free: Vec<usize> = (0..self.genes.len()).filter(|&m| self.genes[m] != M_SEQUENCE).collect();
        let mut best = self.clone();
        let (mut cost, mut least) = (self.cost(), best.cost());
        for _ in 0..moves {
            let Some(change) = self.draw_change(&free, &mut rng) else { continue };
            let undo = change.map(|(marker, _)| (marker, self.genes[marker]));
            self.recode(&change);
            let next = self.cost();
            if !cooling.takes(next - cost, &mut rng) {
                self.recode(&undo);
                continue;
            }
            cost = next;
            if cost < least {
                (best, least) = (self.clone(), cost);
            }
        }
        best
    }

    /// Two markers and their new codes: another code for one, the other as it was, or an exchange.
    fn draw_change(&self, free: &[usize], rng: &mut ChaCha8Rng) -> Option<[(usize, u8); 2]> {
        let (&one, &other) = (free.choose(rng)?, free.choose(rng)?);
        let (code, other_code) = (self.genes[one], self.genes[other]);
        let reached = |marker: usize, code: u8| {
            self.lit.light.is_none_or(|(light, _)| light.shortage(marker, code, 1.0) < HOPELESS)
        };
        if rng.random::<bool>() {
            let new = code != other_code && reached(one, other_code) && reached(other, code);
            return new.then_some([(one, other_code), (other, code)]);
        }
        let drawn = rng.random_range(M_SEQUENCE + 1..self.counts.len().max(3) as u8);
        (drawn != code && one != other && usize::from(drawn) < self.counts.len() && reached(one, drawn))
            .then_some([(one, drawn), (other, other_code)])
    }

    fn recode(&mut self, change: &[(usize, u8)]) {
        let mut touched = Vec::new();
        for &(marker, code) in change {
            if self.genes[marker] != code {
                self.counts[usize::from(self.genes[marker])] -= 1;
                self.counts[usize::from(code)] += 1;
                self.genes[marker] = code;
                touched.push(marker);
                touched.extend(&self.seen_from[marker]);
            }
        }
        touched.sort_unstable();
        touched.dedup();
        self.refresh(&touched);
    }

    /// Reads the rings of these markers anew, and compares them with all others.
    fn refresh(&mut self, touched: &[usize]) {
        for &marker in touched {
            let rings = self.rings.of(marker).iter();
            let symbols = |members: &[usize]| members.iter().map(|&m| self.genes[m]).collect::<Vec<u8>>();
            self.read[marker] = rings.map(|ring| Needle::new(&symbols(&ring.members))).collect();
        }
        let markers = self.genes.len();
        for &marker in touched {
            for other in (0..markers).filter(|&other| other != marker) {
                let (p, q) = (marker.min(other), marker.max(other));
                self.alike[p * markers + q] = self.likeness(p, q);
            }
        }
    }

    fn likeness(&self, p: usize, q: usize) -> f64 {
        if self.genes[p] != self.genes[q] {
            return 0.0;
        }
        let mut sum = 0.0;
        for (ring, sequence) in std::iter::zip(self.rings.of(p), &self.read[p]) {
            for (other_ring, other) in std::iter::zip(self.rings.of(q), &self.read[q]) {
                if let Some(distance) = sequence.cyclic_distance_below(other, ALIKE.len() as u32) {
                    sum += ring.share * other_ring.share * ALIKE[distance as usize];
                }
            }
        }
        sum
    }
}

/// Codes for markers of which some blink the m-sequence: the others in turn.
pub fn in_turn(m_sequence: &[bool], patterns: u8) -> Vec<u8> {
    let mut turn = (M_SEQUENCE + 1..=patterns.max(M_SEQUENCE + 1)).cycle();
    let code =
        |&m: &bool| if m || patterns == M_SEQUENCE { M_SEQUENCE } else { turn.next().unwrap_or(M_SEQUENCE) };
    m_sequence.iter().map(code).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{params, sites};
    use fibar_core::PatternId;
    use fibar_core::images::Images;
    use fibar_core::recognition::cyclic_distance;
    use rand::SeedableRng;

    /// The sum of the module's header, made of definitions in `fibar-core` alone.
    fn confusion_by_definition(rings: &Rings, genes: &[u8]) -> f64 {
        let read = |ring: &crate::rings::Ring| -> Vec<PatternId> {
            ring.members.iter().map(|&m| PatternId(u32::from(genes[m]))).collect()
        };
        let mut sum = 0.0;
        for p in 0..genes.len() {
            for q in (p + 1..genes.len()).filter(|&q| genes[q] == genes[p]) {
                for (i, j) in rings.of(p).iter().flat_map(|i| rings.of(q).iter().map(move |j| (i, j))) {
                    let distance = cyclic_distance(&read(i), &read(j));
                    sum += i.share * j.share * ALIKE.get(distance).unwrap_or(&0.0);
                }
            }
        }
        sum
    }

    #[test]
    fn confusion_is_what_its_definition_says_after_any_changes() {
        let images = Images::new(&sites(2));
        let rings = Rings::collect(&images, 0.3, 1);
        let seen_from = rings.seen_from();
        let mut m_sequence = vec![false; rings.len()];
        m_sequence[..6].fill(true);
        let first = Codes::new(&rings, &seen_from, in_turn(&m_sequence, 4), 4, Lit::default());
        let check = |codes: &Codes| {
            let expected = confusion_by_definition(&rings, &codes.genes);
            assert!((codes.confusion() - expected).abs() < 1e-9, "{} ≠ {expected}", codes.confusion());
        };
        check(&first);
        let moves = params(|_| ()).code_moves;
        let best = first.clone().anneal(moves, ChaCha8Rng::seed_from_u64(4));
        check(&best);
        assert!(best.cost() < first.cost());
        let blinking: Vec<bool> = best.genes.iter().map(|&g| g == M_SEQUENCE).collect();
        assert_eq!(blinking, m_sequence);
    }

    #[test]
    fn one_code_for_all_is_no_search() {
        let images = Images::new(&sites(2));
        let rings = Rings::collect(&images, 0.3, 1);
        let seen_from = rings.seen_from();
        let codes = Codes::new(&rings, &seen_from, in_turn(&vec![false; rings.len()], 1), 1, Lit::default());
        assert_eq!(codes.anneal(50, ChaCha8Rng::seed_from_u64(4)).genes, vec![M_SEQUENCE; rings.len()]);
    }
}
