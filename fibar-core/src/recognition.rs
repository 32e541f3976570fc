//! The paper's lookup: a marker's name from its pattern and its neighbours' (Tone 2020, "Marker ID recognition").

use crate::id::PatternId;
use crate::levenshtein::sequence_distance;

/// A line of the lookup table: a marker's own pattern and its stored sequence of neighbours' patterns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry<'a> {
    /// The marker's own pattern, `u_ptn(p_d)`.
    pub pattern: PatternId,
    /// Patterns of its neighbours, clockwise, `**u**_ptn(p_d)`.
    pub neighbours: &'a [PatternId],
}

/// Index of the entry of the same pattern whose sequence is nearest in Levenshtein distance; the first of equals.
pub fn look_up(seen: Entry<'_>, table: &[Entry<'_>]) -> Option<usize> {
    let candidates = table.iter().enumerate().filter(|(_, entry)| entry.pattern == seen.pattern);
    candidates
        .min_by_key(|(_, entry)| sequence_distance(seen.neighbours, entry.neighbours))
        .map(|(index, _)| index)
}

/// Least Levenshtein distance between two sequences over all rotations of one: the same at any roll of the camera.
pub fn cyclic_distance<T: PartialEq + Clone>(a: &[T], b: &[T]) -> usize {
    let turned = |k: usize| [&b[k..], &b[..k]].concat();
    (0..b.len().max(1)).map(|k| sequence_distance(a, &turned(k))).min().expect("one rotation at least")
}

/// The sequence that occurs most often; of equals the one first in order. `None` of none.
pub fn most_frequent(sequences: impl IntoIterator<Item = Vec<PatternId>>) -> Option<Vec<PatternId>> {
    let mut counts = std::collections::BTreeMap::<Vec<PatternId>, usize>::new();
    for sequence in sequences {
        *counts.entry(sequence).or_default() += 1;
    }
    counts.into_iter().rev().max_by_key(|(_, count)| *count).map(|(sequence, _)| sequence)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ids(text: &str) -> Vec<PatternId> {
        text.bytes().map(|b| PatternId(u32::from(b - b'0'))).collect()
    }

    #[test]
    fn distances_are_levenshtein() {
        let check =
            |a: &str, b: &str, d: usize| assert_eq!(sequence_distance(&ids(a), &ids(b)), d, "{a} {b}");
        check("", "", 0);
        check("123", "", 3);
        check("1234", "1243", 2);
        check("1234", "234", 1);
        check("1234", "2341", 2);
    }

    #[test]
    fn nearest_of_the_same_pattern_wins() {
        let sequences = [ids("234"), ids("345"), ids("345")];
        let patterns = [1, 2, 1];
        let table: Vec<Entry> = std::iter::zip(patterns, &sequences)
            .map(|(pattern, s)| Entry { pattern: PatternId(pattern), neighbours: s })
            .collect();
        let check = |pattern: u32, seen: &str, expected: Option<usize>| {
            assert_eq!(
                look_up(Entry { pattern: PatternId(pattern), neighbours: &ids(seen) }, &table),
                expected
            );
        };
        check(1, "345", Some(2));
        check(1, "23", Some(0));
        check(2, "234", Some(1));
        check(7, "234", None);
    }

    #[test]
    fn ties_of_frequency_go_to_the_first_in_order() {
        assert_eq!(most_frequent([ids("21"), ids("12"), ids("12"), ids("21"), ids("3")]), Some(ids("12")));
        assert_eq!(most_frequent([]), None);
    }
}
