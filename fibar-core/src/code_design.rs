//! Words for blinking without an m-sequence: far from each other at every shift, never dark for long.
//!
//! A camera that has no clock meets a word at any of its bits, so what separates two words is the least Hamming distance over
//! all rotations of one against the other. `d` errors in a period are noticed by a distance of `d + 1` and mended by
//! `2·d + 1`. Which LED blinks which word, and how a camera decodes them, is settled elsewhere.

/// What a set of words shall be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WordGoal {
    /// Bits of a word, 2 to 20.
    pub length: u32,
    /// How many words.
    pub words: usize,
    /// Least distance between two words at any shift.
    pub distance: u32,
    /// Least distance between a word and its own shifts, so that a word also tells the time; 0 allows any word.
    pub own_distance: u32,
    /// Longest run of dark bits in the endless repetition of a word: what a tracker must bridge.
    pub longest_dark: u32,
}

/// Why there are no such words.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DesignError {
    /// Words of this length are not searched.
    #[error("words of {0} bits are not designed here: use a length from 2 to 20")]
    Length(u32),
    /// All possibilities were tried.
    #[error("no {wanted} words of {length} bits keep these distances: {found} is the most that exist")]
    Impossible {
        /// Words asked for.
        wanted: usize,
        /// The most that fit together.
        found: usize,
        /// Length of a word.
        length: u32,
    },
    /// The search was given up.
    #[error(
        "found {found} of {wanted} words before {steps} comparisons were used up: ask for fewer words, less distance, or more steps"
    )]
    GaveUp {
        /// Words asked for.
        wanted: usize,
        /// The most found.
        found: usize,
        /// Comparisons of words made.
        steps: u64,
    },
}

/// Searches words that keep the goal's distances, each the least of its rotations, depth first in rising order, for at
/// most `steps` comparisons of two words. The same goal gives the same words.
pub fn design_words(goal: &WordGoal, steps: u64) -> Result<Vec<Vec<bool>>, DesignError> {
    if !(2..=20).contains(&goal.length) {
        return Err(DesignError::Length(goal.length));
    }
    let candidates: Vec<u32> = (1..1 << goal.length).filter(|&word| is_candidate(word, goal)).collect();
    let mut search = Search { goal, left: steps, chosen: Vec::new(), best: 0 };
    if search.extend(&candidates) {
        return Ok(search.chosen.iter().map(|&word| bits(word, goal.length)).collect());
    }
    let (wanted, found) = (goal.words, search.best);
    Err(match search.left {
        0 => DesignError::GaveUp { wanted, found, steps },
        _ => DesignError::Impossible { wanted, found, length: goal.length },
    })
}

struct Search<'a> {
    goal: &'a WordGoal,
    left: u64,
    chosen: Vec<u32>,
    best: usize,
}

impl Search<'_> {
    /// Adds words out of `candidates`, all far from the chosen ones, until there are enough.
    fn extend(&mut self, candidates: &[u32]) -> bool {
        self.best = self.best.max(self.chosen.len());
        if self.chosen.len() >= self.goal.words {
            return true;
        }
        for (k, &word) in candidates.iter().enumerate() {
            let enough = self.chosen.len() + candidates.len() - k;
            if self.left == 0 || (enough < self.goal.words && enough <= self.best) {
                return false;
            }
            self.chosen.push(word);
            let rest = self.far_from(word, &candidates[k + 1..]);
            if self.extend(&rest) {
                return true;
            }
            self.chosen.pop();
        }
        false
    }

    fn far_from(&mut self, word: u32, others: &[u32]) -> Vec<u32> {
        self.left = self.left.saturating_sub(others.len() as u64);
        let WordGoal { length, distance, .. } = *self.goal;
        others.iter().copied().filter(|&other| cyclic_distance(word, other, length) >= distance).collect()
    }
}

fn is_candidate(word: u32, goal: &WordGoal) -> bool {
    let mut own = (1..goal.length).map(|shift| rotate(word, shift, goal.length));
    own.clone().all(|other| other >= word)
        && longest_dark(word, goal.length) <= goal.longest_dark
        && own.all(|other| (word ^ other).count_ones() >= goal.own_distance)
}

/// Least Hamming distance over all rotations.
fn cyclic_distance(a: u32, b: u32, length: u32) -> u32 {
    (0..length).map(|shift| (a ^ rotate(b, shift, length)).count_ones()).min().unwrap_or(0)
}

/// Longest cyclic run of zeros; for a word that is the least of its rotations it stands in front.
fn longest_dark(word: u32, length: u32) -> u32 {
    word.leading_zeros() - (32 - length)
}

fn rotate(word: u32, shift: u32, length: u32) -> u32 {
    (word << shift | word >> (length - shift)) & ((1 << length) - 1)
}

fn bits(word: u32, length: u32) -> Vec<bool> {
    (0..length).rev().map(|k| word >> k & 1 == 1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::bits_to_string;
    use proptest::prelude::*;

    const STEPS: u64 = 20_000_000;

    fn check_words(goal: &WordGoal, words: &[Vec<bool>]) {
        let length = goal.length as usize;
        let distance = |a: &[bool], b: &[bool], shift: usize| {
            (0..length).filter(|&k| a[k] != b[(k + shift) % length]).count() as u32
        };
        assert_eq!(words.len(), goal.words);
        for (k, word) in words.iter().enumerate() {
            assert_eq!(word.len(), length);
            let twice = bits_to_string(word).repeat(2);
            assert!(!twice.contains(&"0".repeat(goal.longest_dark as usize + 1)), "{twice} is dark for long");
            assert!((1..length).all(|shift| distance(word, word, shift) >= goal.own_distance), "{twice}");
            for other in &words[..k] {
                assert!((0..length).all(|shift| distance(word, other, shift) >= goal.distance), "{twice}");
            }
        }
    }

    #[test]
    fn known_sets_exist() {
        let check = |length, words, distance, own_distance, longest_dark| {
            let goal = WordGoal { length, words, distance, own_distance, longest_dark };
            check_words(&goal, &design_words(&goal, STEPS).unwrap());
        };
        check(15, 7, 5, 0, 15);
        check(15, 7, 4, 4, 4);
        check(12, 7, 3, 0, 3);
        check(3, 2, 1, 2, 2);
        check(2, 1, 0, 2, 1);
    }

    #[test]
    fn what_cannot_be_is_said() {
        let check = |length, words, distance, steps, error: DesignError| {
            let goal = WordGoal { length, words, distance, own_distance: 0, longest_dark: length };
            assert_eq!(design_words(&goal, steps), Err(error), "{goal:?}");
        };
        check(1, 1, 0, STEPS, DesignError::Length(1));
        check(21, 1, 0, STEPS, DesignError::Length(21));
        check(3, 4, 1, STEPS, DesignError::Impossible { wanted: 4, found: 3, length: 3 });
        check(6, 3, 6, STEPS, DesignError::Impossible { wanted: 3, found: 1, length: 6 });
        check(15, 40, 5, 1000, DesignError::GaveUp { wanted: 40, found: 1, steps: 1000 });
    }

    proptest! {
        #[test]
        fn whatever_is_found_keeps_the_goal(
            length in 2u32..11, words in 1usize..6, distance in 0u32..5, own_distance in 0u32..4, longest_dark in 1u32..11,
        ) {
            let goal = WordGoal { length, words, distance, own_distance, longest_dark };
            if let Ok(found) = design_words(&goal, 200_000) {
                check_words(&goal, &found);
            }
        }
    }
}
