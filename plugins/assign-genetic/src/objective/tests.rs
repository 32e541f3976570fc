//! Every term of the objective against a reference that follows the paper's words, without any reuse or cleverness.

use super::*;
use crate::tests::globe;
use fibar_core::PatternId;
use fibar_core::adjacency::clockwise_neighbours;
use fibar_core::levenshtein::sequence_distance;
use fibar_core::recognition::{Entry, look_up, most_frequent};
use glam::DVec2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

/// Sequences of neighbours' patterns of every marker in one view, by site.
fn read_view(images: &Images, view: usize, genes: &[u8]) -> BTreeMap<usize, Vec<PatternId>> {
    let image = &images.views[view];
    let shown = (0..image.sites.len()).filter(|&k| genes[image.sites[k] as usize] != 0);
    let (sites, points): (Vec<usize>, Vec<DVec2>) =
        shown.map(|k| (image.sites[k] as usize, image.points[k])).unzip();
    let pattern = |k: &usize| PatternId(u32::from(genes[sites[*k]]));
    let rings = clockwise_neighbours(&points).into_iter();
    std::iter::zip(sites.clone(), rings.map(|ring| ring.iter().map(pattern).collect())).collect()
}

/// `E_rcg(p_m, v)` of every marker in every view, and `n_mseq(v)` (Tone 2020, "Marker placement").
fn reference(images: &Images, genes: &[u8], k1: f64) -> Vec<(Vec<f64>, u32)> {
    let views: Vec<_> = (0..images.views.len()).map(|v| read_view(images, v, genes)).collect();
    let pattern = |site: usize| PatternId(u32::from(genes[site]));
    let stored = |site: usize| most_frequent(views.iter().filter_map(|v| v.get(&site).cloned()));
    let table: Vec<(usize, Vec<PatternId>)> =
        (0..genes.len()).filter(|&s| genes[s] != 0).filter_map(|s| stored(s).map(|t| (s, t))).collect();
    let entries: Vec<Entry> =
        table.iter().map(|(s, t)| Entry { pattern: pattern(*s), neighbours: t }).collect();
    let judge = |(&site, seen): (&usize, &Vec<PatternId>)| {
        let named = look_up(Entry { pattern: pattern(site), neighbours: seen }, &entries).unwrap();
        let (found, stored) = &table[named];
        if *found == site { k1 - sequence_distance(seen, stored) as f64 } else { -k1 }
    };
    let m_sequence = |view: &BTreeMap<usize, _>| view.keys().filter(|&&s| genes[s] == 1).count() as u32;
    views.iter().map(|view| (view.iter().map(judge).collect(), m_sequence(view))).collect()
}

fn check(images: &Images, found: &Evaluated, k1: f64, k2: u32) {
    let rules = Rules::new(k1, k2);
    let mut total = 0.0;
    for (tally, (terms, m_sequence)) in
        std::iter::zip(found.tallies(images), reference(images, &found.genes, k1))
    {
        let recognition: f64 = terms.iter().sum();
        assert!((tally.recognition(&rules) - recognition).abs() < 1e-9, "E_rcg {tally:?} ≠ {terms:?}");
        assert_eq!(tally.m_sequence, m_sequence);
        let gain = f64::from(m_sequence.min(k2)).sqrt() + 1.0;
        assert_eq!(rules.gain(m_sequence), gain, "E_mseq of {m_sequence}");
        total += recognition * gain;
    }
    assert!((found.objective - total).abs() < 1e-6, "{} ≠ {total}", found.objective);
}

#[test]
fn every_term_is_the_papers_after_every_change() {
    for (seed, sites, patterns, k1, k2) in
        [(1, 9, 2, 5.0, 2), (2, 24, 7, 5.0, 2), (3, 24, 3, 2.5, 4), (4, 40, 7, 5.0, 1)]
    {
        let images = globe(sites, 60.0);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let rules = Rules::new(k1, k2);
        let mut here = Evaluated::blank(&images);
        check(&images, &here, k1, k2);
        for step in 0..60 {
            let mut genes = here.genes.clone();
            let changes = if step == 0 { sites } else { rng.random_range(1..4) };
            for _ in 0..changes {
                let site = rng.random_range(0..genes.len());
                genes[site] = rng.random_range(0..=patterns);
            }
            here = here.changed_to(genes, &images, &rules);
            check(&images, &here, k1, k2);
        }
    }
}

#[test]
fn the_way_to_a_chromosome_leaves_no_trace() {
    let images = globe(30, 60.0);
    let rules = Rules::new(5.0, 2);
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut genes = || (0..images.sites.len()).map(|_| rng.random_range(0..=7)).collect::<Vec<u8>>();
    let (detour, goal) = (genes(), genes());
    let blank = Evaluated::blank(&images);
    let straight = blank.changed_to(goal.clone(), &images, &rules);
    let around = blank.changed_to(detour, &images, &rules).changed_to(goal, &images, &rules);
    assert_eq!(straight.objective, around.objective);
    assert_eq!(straight.tallies(&images), around.tallies(&images));
}

#[test]
fn one_marker_alone_is_always_right() {
    let images = globe(12, 60.0);
    let mut genes = vec![0; images.sites.len()];
    genes[3] = 2;
    let found = Evaluated::blank(&images).changed_to(genes, &images, &Rules::new(5.0, 2));
    assert_eq!(found.table_entry(3), Some(&[][..]));
    assert_eq!(found.objective, 5.0 * images.views_of[3].len() as f64);
}
