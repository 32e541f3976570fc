//! The lookup table: for every marker, the sequences of its neighbours' codes that most views see.

use crate::rings::neighbours;
use fibar_core::PatternId;
use fibar_core::images::Images;
use std::collections::BTreeMap;

/// Up to `wanted` sequences for each marker, the most frequent first, of equals in order. All images count, upright, with every
/// marker lit, as in Tone 2020, "Marker ID recognition"; the first is the line of its table.
pub fn sequences(images: &Images, genes: &[u8], wanted: usize) -> Vec<Vec<Vec<PatternId>>> {
    let mut seen = vec![BTreeMap::<Vec<PatternId>, usize>::new(); images.sites.len()];
    for image in &images.views {
        let all: Vec<usize> = (0..image.sites.len()).collect();
        for (marker, ring) in neighbours(image, &all) {
            let sequence = ring.iter().map(|&m| PatternId(u32::from(genes[m]))).collect();
            *seen[marker].entry(sequence).or_default() += 1;
        }
    }
    seen.into_iter().map(|counts| most_frequent(counts, wanted)).collect()
}

fn most_frequent(counts: BTreeMap<Vec<PatternId>, usize>, wanted: usize) -> Vec<Vec<PatternId>> {
    let mut counted: Vec<(Vec<PatternId>, usize)> = counts.into_iter().collect();
    // A stable sort of an ordered list: equals stay in order.
    counted.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    counted.into_iter().take(wanted).map(|(sequence, _)| sequence).collect()
}
