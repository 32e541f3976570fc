//! Levenshtein distance, bit-parallel (Myers 1999, in Hyyrö's form for whole sequences); from one sequence to many through a
//! [`Needle`].

/// More symbols than this do not occur: patterns are numbered from 1 to 15.
pub const SYMBOLS: usize = 16;

/// Least number of insertions, deletions and substitutions that make one sequence of the other.
pub fn sequence_distance<T: PartialEq>(a: &[T], b: &[T]) -> usize {
    if a.is_empty() || a.len() > 64 {
        return strsim::generic_levenshtein(&Sequence(a), &Sequence(b));
    }
    let places = |symbol: &T| a.iter().rev().fold(0, |bits, own| bits << 1 | u64::from(own == symbol));
    distance_by_places(a.len(), b.iter().map(places), u32::MAX).expect("no limit was set") as usize
}

/// A slice whose reference can be iterated over without naming a lifetime, as strsim wants it.
struct Sequence<'a, T>(&'a [T]);

impl<'a, T> IntoIterator for &Sequence<'a, T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;
    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

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
            1..=64 => {
                let places = other.iter().map(|&symbol| self.places[usize::from(symbol)]);
                return distance_by_places(self.length, places, limit);
            }
            _ => sequence_distance(self.sequence(), other) as u32,
        };
        (distance < limit).then_some(distance)
    }
}

/// One column of the table of distances at a time, as bit vectors of its vertical steps up (`rises`) and down (`falls`). Of the other
/// sequence it is enough where each of its symbols occurs in the first. `None` unless less than a limit.
fn distance_by_places(length: usize, places: impl ExactSizeIterator<Item = u64>, limit: u32) -> Option<u32> {
    let last = length - 1;
    let (mut rises, mut falls) = (u64::MAX, 0u64);
    let mut distance = length as u32;
    let mut rest = places.len() as u32;
    for equal in places {
        let diagonal = ((equal & rises).wrapping_add(rises) ^ rises) | equal;
        let vertical = equal | falls;
        let up = falls | !(diagonal | rises);
        let down = rises & diagonal;
        distance += (up >> last & 1) as u32;
        distance -= (down >> last & 1) as u32;
        rest -= 1;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recognition::cyclic_distance;
    use proptest::prelude::*;

    fn by_strsim(a: &[u8], b: &[u8]) -> usize {
        strsim::generic_levenshtein(&Sequence(a), &Sequence(b))
    }

    fn by_turns(a: &[u8], b: &[u8]) -> usize {
        let turned = |k: usize| [&b[k..], &b[..k]].concat();
        (0..b.len().max(1)).map(|k| by_strsim(a, &turned(k))).min().unwrap()
    }

    proptest! {
        #[test]
        fn distances_are_those_of_strsim(
            a in prop::collection::vec(1u8..8, 0..10),
            b in prop::collection::vec(1u8..8, 0..10),
        ) {
            prop_assert_eq!(sequence_distance(&a, &b), by_strsim(&a, &b));
            prop_assert_eq!(Needle::new(&a).distance(&b) as usize, by_strsim(&a, &b));
            prop_assert_eq!(Needle::new(&a).cyclic_distance(&Needle::new(&b)) as usize, by_turns(&a, &b));
            prop_assert_eq!(cyclic_distance(&a, &b), by_turns(&a, &b));
        }

        #[test]
        fn long_sequences_too(
            a in prop::collection::vec(1u8..8, 0..90),
            b in prop::collection::vec(1u8..8, 0..90),
        ) {
            prop_assert_eq!(sequence_distance(&a, &b), by_strsim(&a, &b));
            prop_assert_eq!(Needle::new(&a).distance(&b) as usize, by_strsim(&a, &b));
        }
    }
}
