//! What the views read of one marker: for every ring of neighbours, the sequence of their patterns.

use crate::topology::Sightings;
use fibar_core::levenshtein::Counts;

/// The sequences of one marker, in the order of its sightings.
#[derive(Default)]
pub struct Reading {
    symbols: Vec<u8>,
    counts: Vec<Counts>,
}

impl Reading {
    /// Reads the patterns of the neighbours in every ring.
    pub fn new(sightings: &Sightings, genes: &[u8]) -> Reading {
        let symbols: Vec<u8> = sightings.rings.items().iter().map(|&site| genes[site as usize]).collect();
        let count = |k| Counts::of(&symbols[sightings.rings.range(k)]);
        Reading { counts: (0..sightings.rings.len()).map(count).collect(), symbols }
    }

    /// Sequence `k` of these sightings, and how often each symbol occurs in it.
    pub fn sequence(&self, sightings: &Sightings, k: usize) -> (&[u8], &Counts) {
        (&self.symbols[sightings.rings.range(k)], &self.counts[k])
    }

    /// The sequence that most views see; of equals the first in order, as `recognition::most_frequent` has it.
    pub fn most_frequent(&self, sightings: &Sightings) -> Option<&[u8]> {
        let read = |(k, views): (usize, &[u32])| {
            let (sequence, _) = self.sequence(sightings, k);
            (leading_symbols(sequence), sequence, views.len())
        };
        let mut counted: Vec<(u64, &[u8], usize)> = sightings.views.iter().enumerate().map(read).collect();
        counted.sort_unstable();
        let votes = |same: &&[(u64, &[u8], usize)]| same.iter().map(|(.., count)| count).sum::<usize>();
        // `max_by_key` takes the last of equals: walk backwards to get the first.
        let best = counted.chunk_by(|a, b| a.1 == b.1).rev().max_by_key(votes)?;
        Some(best[0].1)
    }
}

/// The first sixteen symbols as one number, in the order of the sequences: what sorting looks at before the sequences.
fn leading_symbols(sequence: &[u8]) -> u64 {
    let leading = &sequence[..sequence.len().min(16)];
    let number = leading.iter().fold(0, |number, &symbol| number << 4 | u64::from(symbol));
    // Shorter sequences come before those they begin.
    if leading.is_empty() { 0 } else { number << (4 * (16 - leading.len())) }
}
