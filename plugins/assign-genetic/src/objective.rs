//! The paper's objective, `Σ_v E_rcg(v) · E_mseq(v)` (Tone 2020, "Marker placement"), re-evaluated where it changes.
//!
//! A chromosome is evaluated as a change of another one. Its cost follows the change: an image is triangulated anew when a
//! marker in it appears or disappears, a table entry is made anew when a pattern around it changes, and a name is looked
//! up anew when an entry that it could be mistaken for changes. All sums over views are of whole numbers, so the result
//! does not depend on the way it was reached, to the bit.

use crate::reading::Reading;
use crate::topology::Topology;
use fibar_core::images::Images;
use fibar_core::levenshtein::{Needle, SYMBOLS};
use std::sync::Arc;

/// The objective's constants.
#[derive(Clone, Debug)]
pub struct Rules {
    k1: f64,
    /// `g(n)` for `n` up to `k2`.
    gains: Vec<f64>,
}

impl Rules {
    /// `k1`, `k2`, and `g(x) = √x + 1`.
    pub fn new(k1: f64, k2: u32) -> Rules {
        Rules { k1, gains: (0..=k2).map(|n| f64::from(n).sqrt() + 1.0).collect() }
    }

    /// `E_mseq` of a view with `count` m-sequence markers.
    fn gain(&self, count: u32) -> f64 {
        self.gains[(count as usize).min(self.gains.len() - 1)]
    }
}

/// A chromosome with all that its evaluation found.
#[derive(Clone)]
pub struct Evaluated {
    /// The chromosome: the pattern of each site, 0 for a site without marker.
    pub genes: Vec<u8>,
    /// `Σ_v E_rcg(v) · E_mseq(v)`.
    pub objective: f64,
    topology: Arc<Topology>,
    readings: Vec<Arc<Reading>>,
    table: Vec<Option<Arc<Needle>>>,
    verdicts: Vec<Arc<Vec<Verdict>>>,
}

/// How the lookup of one sighting ends.
#[derive(Clone, Copy)]
struct Verdict {
    /// Levenshtein distance to the marker's own table entry.
    distance: u32,
    /// A marker of the same pattern whose entry is nearer, or as near and earlier in the table: the name is wrong.
    mistaken_for: Option<u32>,
}

/// What the lookup says about one view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Markers named rightly.
    pub right: u32,
    /// Markers named wrongly.
    pub wrong: u32,
    /// Sum of the Levenshtein distances of the rightly named ones.
    pub distance: u32,
    /// m-sequence markers, `n_mseq(v)`.
    pub m_sequence: u32,
}

impl Evaluated {
    /// The chromosome without markers, from which every other one can be reached.
    pub fn blank(images: &Images) -> Evaluated {
        let count = images.sites.len();
        Evaluated {
            genes: vec![0; count],
            objective: 0.0,
            topology: Arc::new(Topology::blank(images)),
            readings: vec![Arc::default(); count],
            table: vec![None; count],
            verdicts: vec![Arc::default(); count],
        }
    }

    /// The stored sequence of a marker, `**u**_ptn(p_m)`; `None` without a marker.
    pub fn table_entry(&self, site: usize) -> Option<&[u8]> {
        self.table[site].as_ref().map(|needle| needle.sequence())
    }

    /// Evaluates another chromosome from this one.
    pub fn changed_to(&self, genes: Vec<u8>, images: &Images, rules: &Rules) -> Evaluated {
        let active: Vec<bool> = genes.iter().map(|&g| g != 0).collect();
        let topology = self.topology.with_active(images, &active);
        let mut next = Evaluated { genes, topology, ..self.clone() };
        let mut change = Change::between(self, &next);
        for site in 0..next.genes.len() {
            if change.touched[site] {
                let reading = Reading::new(next.topology.sightings(site), &next.genes);
                let entry = reading.most_frequent(next.topology.sightings(site));
                next.table[site] = entry.map(|sequence| Arc::new(Needle::new(sequence)));
                next.readings[site] = Arc::new(reading);
                change.relisted[site] =
                    change.changed[site] || next.table_entry(site) != self.table_entry(site);
            }
        }
        let patterns = Patterns::new(self, &next, &change);
        for site in 0..next.genes.len() {
            if change.touched[site] || patterns.is_disturbed(next.genes[site]) {
                next.verdicts[site] = Arc::new(next.judge(site, self, &change, &patterns));
            }
        }
        next.objective = next.tallies(images).iter().map(|t| t.value(rules)).sum();
        next
    }

    /// For every view, what the lookup says.
    pub fn tallies(&self, images: &Images) -> Vec<Tally> {
        let mut tallies = vec![Tally::default(); images.views.len()];
        for (site, verdicts) in self.verdicts.iter().enumerate() {
            for (views, verdict) in
                std::iter::zip(self.topology.sightings(site).views.iter(), verdicts.iter())
            {
                let one = Tally::of(verdict, self.genes[site]);
                views.iter().for_each(|&view| tallies[view as usize].add(one));
            }
        }
        tallies
    }

    /// Looks up every sighting of a marker: in the whole table where it or the marker's own entry is not as before, else
    /// among the entries that are not.
    fn judge(&self, site: usize, before: &Evaluated, change: &Change, patterns: &Patterns) -> Vec<Verdict> {
        let Some(own) = &self.table[site] else { return Vec::new() };
        let (members, disturbed) = patterns.rivals(self.genes[site]);
        let sightings = self.topology.sightings(site);
        let afresh = change.relisted[site] || !Change::has_same_sightings(before, self, site);
        let judge = |k: usize| {
            let (sequence, counts) = self.readings[site].sequence(sightings, k);
            let same = || !change.touched[site] || before.readings[site].sequence(sightings, k).0 == sequence;
            let known = (!afresh && same()).then(|| before.verdicts[site][k]);
            let rivals = match known {
                Some(Verdict { mistaken_for: Some(rival), .. }) if change.relisted[rival as usize] => members,
                Some(verdict) if verdict.mistaken_for.is_some() => return verdict,
                Some(_) => disturbed,
                None => members,
            };
            let distance = known.map_or_else(|| own.distance(sequence), |verdict| verdict.distance);
            // The first of equals wins the lookup.
            let limit = |rival: u32| distance + u32::from((rival as usize) < site);
            let wins = |rival: u32| {
                self.table[rival as usize]
                    .as_ref()
                    .is_some_and(|e| e.is_nearer(sequence, counts, limit(rival)))
            };
            let mistaken_for = rivals.iter().copied().find(|&rival| rival as usize != site && wins(rival));
            Verdict { distance, mistaken_for }
        };
        (0..sightings.rings.len()).map(judge).collect()
    }
}

/// What differs between two evaluations.
struct Change {
    /// Sites of another gene.
    changed: Vec<bool>,
    /// Sites of which any sequence seen, or the own pattern, may not be as before.
    touched: Vec<bool>,
    /// Sites of another gene or table entry; filled in as the table is made.
    relisted: Vec<bool>,
}

impl Change {
    fn between(before: &Evaluated, after: &Evaluated) -> Change {
        let changed: Vec<bool> = std::iter::zip(&before.genes, &after.genes).map(|(a, b)| a != b).collect();
        let sites = 0..changed.len();
        let mut change = Change { relisted: vec![false; changed.len()], touched: Vec::new(), changed };
        let is_touched = |site: usize| {
            change.changed[site]
                || !Change::has_same_sightings(before, after, site)
                || !change.spares(&after.topology.sightings(site).around)
        };
        change.touched = sites.map(is_touched).collect();
        change
    }

    fn has_same_sightings(before: &Evaluated, after: &Evaluated, site: usize) -> bool {
        Arc::ptr_eq(before.topology.sightings(site), after.topology.sightings(site))
    }

    /// Whether none of these sites has another gene.
    fn spares(&self, sites: &[u32]) -> bool {
        !sites.iter().any(|&site| self.changed[site as usize])
    }
}

/// Markers by pattern.
struct Patterns {
    /// All of them, rising.
    members: Vec<Vec<u32>>,
    /// Those whose table entry is not as before, rising.
    relisted: Vec<Vec<u32>>,
    /// Whether a pattern gained, lost or changed an entry.
    disturbed: Vec<bool>,
}

impl Patterns {
    fn new(before: &Evaluated, after: &Evaluated, change: &Change) -> Patterns {
        let mut patterns = Patterns {
            members: vec![Vec::new(); SYMBOLS],
            relisted: vec![Vec::new(); SYMBOLS],
            disturbed: vec![false; SYMBOLS],
        };
        for (site, &gene) in after.genes.iter().enumerate() {
            let pattern = usize::from(gene);
            patterns.members[pattern].push(site as u32);
            if change.relisted[site] {
                patterns.relisted[pattern].push(site as u32);
                patterns.disturbed[pattern] = true;
                patterns.disturbed[usize::from(before.genes[site])] = true;
            }
        }
        patterns
    }

    /// Whether the lookup of an unchanged marker of this pattern may end otherwise than before; never of no marker.
    fn is_disturbed(&self, gene: u8) -> bool {
        gene != 0 && self.disturbed[usize::from(gene)]
    }

    /// All markers of a pattern, and those whose entry is not as before.
    fn rivals(&self, gene: u8) -> (&[u32], &[u32]) {
        (&self.members[usize::from(gene)], &self.relisted[usize::from(gene)])
    }
}

impl Tally {
    /// One marker.
    fn of(verdict: &Verdict, gene: u8) -> Tally {
        let right = u32::from(verdict.mistaken_for.is_none());
        Tally {
            right,
            wrong: 1 - right,
            distance: verdict.distance * right,
            m_sequence: u32::from(u32::from(gene) == fibar_core::PatternId::M_SEQUENCE.0),
        }
    }

    fn add(&mut self, other: Tally) {
        self.right += other.right;
        self.wrong += other.wrong;
        self.distance += other.distance;
        self.m_sequence += other.m_sequence;
    }

    /// `E_rcg(v) · E_mseq(v)`.
    fn value(&self, rules: &Rules) -> f64 {
        self.recognition(rules) * rules.gain(self.m_sequence)
    }

    /// `E_rcg(v)`: `k1 − distance` for every right name, `−k1` for every wrong one.
    fn recognition(&self, rules: &Rules) -> f64 {
        let balance = f64::from(self.right) - f64::from(self.wrong);
        rules.k1 * balance - f64::from(self.distance)
    }
}

#[cfg(test)]
mod tests;
