//! Levenshtein distance from one sequence to many, bit-parallel (Myers 1999, in Hyyrö's form for whole sequences).
//!
//! The same numbers as `crate::recognition::sequence_distance`, an order of magnitude sooner.

use crate::recognition::sequence_distance;

/// More symbols than this do not occur: patterns are numbered from 1 to 15.
pub const SYMBOLS: usize = 16;

/// A sequence prepared for comparison.
#[derive(Clone, Debug)]
pub struct Needle {
    length: usize,
    /// The sequence twice over: every rotation of it is a part.
    doubled: Vec<u8>,
    counts: Counts,
    /// For every symbol, the places where it occurs, one bit each; unused by sequences of more than 64.
    places: [u64; SYMBOLS],
}

/// How often each symbol occurs in a sequence, up to 255 times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts([u8; SYMBOLS]);

impl Counts {
    /// Counts the symbols, all below [`SYMBOLS`].
    pub fn of(sequence: &[u8]) -> Counts {
        let mut counts = [0u8; SYMBOLS];
        for &symbol in sequence {
            let count = &mut counts[usize::from(symbol)];
            *count = count.saturating_add(1);
        }
        Counts(counts)
    }

    /// Bag distance, the greater of the surpluses on either side: every edit mends one missing and one superfluous symbol
    /// at most, so no Levenshtein distance is less.
    fn bag_distance(&self, other: &Counts, length_difference: u32) -> u32 {
        let differences: u32 = std::iter::zip(self.0, other.0).map(|(a, b)| u32::from(a.abs_diff(b))).sum();
        differences.midpoint(length_difference)
    }
}

impl Needle {
    /// Prepares a sequence of symbols below [`SYMBOLS`].
    pub fn new(sequence: &[u8]) -> Needle {
        let mut places = [0; SYMBOLS];
        for (k, &symbol) in sequence.iter().take(64).enumerate() {
            places[usize::from(symbol)] |= 1 << k;
        }
        Needle { length: sequence.len(), doubled: sequence.repeat(2), counts: Counts::of(sequence), places }
    }

    /// The sequence itself.
    pub fn sequence(&self) -> &[u8] {
        &self.doubled[..self.length]
    }

    /// Least number of insertions, deletions and substitutions that make one sequence of the other.
    pub fn distance(&self, other: &[u8]) -> u32 {
        self.distance_below(other, u32::MAX).expect("no limit was set")
    }

    /// The least distance to any rotation of another sequence: neighbours around a marker have an order but no first.
    pub fn cyclic_distance(&self, other: &Needle) -> u32 {
        self.cyclic_distance_below(other, u32::MAX).expect("no limit was set")
    }

    /// The same if it is less than a limit; the counts of symbols alone often tell that it is not.
    pub fn cyclic_distance_below(&self, other: &Needle, limit: u32) -> Option<u32> {
        let length_difference = self.length.abs_diff(other.length) as u32;
        if self.counts.bag_distance(&other.counts, length_difference) >= limit {
            return None;
        }
        let mut least = None;
        for turn in 0..other.length.max(1) {
            let turned = &other.doubled[turn..turn + other.length];
            least = self.distance_below(turned, least.unwrap_or(limit)).or(least);
        }
        least
    }

    /// Whether the distance to a sequence with these counts of symbols is less than a limit; the counts alone often tell.
    pub fn is_nearer(&self, other: &[u8], counts: &Counts, limit: u32) -> bool {
        let length_difference = self.length.abs_diff(other.len()) as u32;
        self.counts.bag_distance(counts, length_difference) < limit
            && self.distance_below(other, limit).is_some()
    }

    /// The distance if it is less than a limit.
    fn distance_below(&self, other: &[u8], limit: u32) -> Option<u32> {
        let distance = match self.length {
            0 => other.len() as u32,
            1..=64 => return self.bit_parallel_distance(other, limit),
            _ => sequence_distance(self.sequence(), other) as u32,
        };
        (distance < limit).then_some(distance)
    }

    /// One column of the table of distances at a time, as bit vectors of its vertical steps up (`rises`) and down (`falls`).
    fn bit_parallel_distance(&self, other: &[u8], limit: u32) -> Option<u32> {
        let last = self.length - 1;
        let (mut rises, mut falls) = (u64::MAX, 0u64);
        let mut distance = self.length as u32;
        for (&symbol, rest) in other.iter().zip((0..other.len() as u32).rev()) {
            let equal = self.places[usize::from(symbol)];
            let diagonal = ((equal & rises).wrapping_add(rises) ^ rises) | equal;
            let vertical = equal | falls;
            let up = falls | !(diagonal | rises);
            let down = rises & diagonal;
            distance += (up >> last & 1) as u32;
            distance -= (down >> last & 1) as u32;
            // Each symbol to come takes one off at most.
            if distance.saturating_sub(rest) >= limit {
                return None;
            }
            let up = up << 1 | 1;
            rises = down << 1 | !(vertical | up);
            falls = up & vertical;
        }
        (distance < limit).then_some(distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PatternId;
    use crate::recognition::cyclic_distance;
    use proptest::prelude::*;

    fn ids(sequence: &[u8]) -> Vec<PatternId> {
        sequence.iter().map(|&x| PatternId(u32::from(x))).collect()
    }

    proptest! {
        #[test]
        fn distances_are_those_of_the_recogniser(
            a in prop::collection::vec(1u8..8, 0..10),
            b in prop::collection::vec(1u8..8, 0..10),
        ) {
            prop_assert_eq!(Needle::new(&a).distance(&b) as usize, sequence_distance(&ids(&a), &ids(&b)));
            prop_assert_eq!(Needle::new(&a).cyclic_distance(&Needle::new(&b)) as usize, cyclic_distance(&ids(&a), &ids(&b)));
        }

        #[test]
        fn long_sequences_too(
            a in prop::collection::vec(1u8..8, 0..90),
            b in prop::collection::vec(1u8..8, 0..90),
        ) {
            prop_assert_eq!(Needle::new(&a).distance(&b) as usize, sequence_distance(&ids(&a), &ids(&b)));
        }
    }
}
