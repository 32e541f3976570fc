//! Whether codes can be told apart, and how many bits of them a camera must see to do so.
//!
//! Two codes that repeat for ever agree either for ever or only for a bounded run of bits. One bit more than the
//! longest such run tells them apart, wherever in time the camera begins to look.

use crate::code::Code;
use crate::id::PatternId;

/// What a camera knows of time when it compares a blob's bits with a code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// Which bit of its period every code is at: an m-sequence has been recognised.
    Locked,
    /// Nothing: any bit of one code may coincide with any bit of the other.
    Free,
}

/// Two codes that show the same bits for ever.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("patterns {first} and {second} show the same bits for ever when one is {shift} bits late")]
pub struct Twins {
    /// One pattern.
    pub first: PatternId,
    /// The other.
    pub second: PatternId,
    /// How many bits the second must be ahead of the first for that.
    pub shift: usize,
}

/// Bits that tell a base's codes apart by the scheme of Tone 2020, "Blinking pattern": the m-sequence from every other
/// code without a clock, the others from each other once the m-sequence has set the clock.
pub fn bits_to_name(codes: &[Code]) -> Result<usize, Twins> {
    let clock = |a: &Code, b: &Code| {
        let locks = [a, b].iter().any(|code| code.pattern == PatternId::M_SEQUENCE);
        if locks { Clock::Free } else { Clock::Locked }
    };
    worst_pair(codes, clock)
}

/// Bits that tell every code from every other under one clock.
pub fn bits_to_tell_apart(codes: &[Code], clock: Clock) -> Result<usize, Twins> {
    worst_pair(codes, |_, _| clock)
}

fn worst_pair(codes: &[Code], clock: impl Fn(&Code, &Code) -> Clock) -> Result<usize, Twins> {
    let mut bits = 0;
    for (k, first) in codes.iter().enumerate() {
        for second in &codes[k + 1..] {
            bits = bits.max(bits_between(first, second, clock(first, second))?);
        }
    }
    Ok(bits)
}

fn bits_between(first: &Code, second: &Code, clock: Clock) -> Result<usize, Twins> {
    let shifts = match clock {
        Clock::Locked => 0..1,
        Clock::Free => 0..second.bits.len(),
    };
    let mut bits = 0;
    for shift in shifts {
        let run = longest_agreement(&first.bits, &second.bits, shift);
        let twins = Twins { first: first.pattern, second: second.pattern, shift };
        bits = bits.max(1 + run.ok_or(twins)?);
    }
    Ok(bits)
}

/// Most consecutive bits on which two repeated words agree, the second `shift` bits ahead; `None` for all.
fn longest_agreement(a: &[bool], b: &[bool], shift: usize) -> Option<usize> {
    let period = a.len() / greatest_common_divisor(a.len(), b.len()) * b.len();
    let agrees = |n: usize| a[n % a.len()] == b[(n + shift) % b.len()];
    let break_at = (0..period).find(|&n| !agrees(n))?;
    let (mut run, mut longest) = (0, 0);
    for n in break_at..break_at + period {
        run = if agrees(n) { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    Some(longest)
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{bits_from_str, design_codes};
    use proptest::prelude::*;

    fn codes(words: &[&str]) -> Vec<Code> {
        let code =
            |(word, id): (&&str, u32)| Code { pattern: PatternId(id), bits: bits_from_str(word).unwrap() };
        words.iter().zip(1..).map(code).collect()
    }

    #[test]
    fn bits_are_those_of_the_longest_agreement_and_one() {
        let check = |words: &[&str], clock: Clock, bits: usize| {
            assert_eq!(bits_to_tell_apart(&codes(words), clock), Ok(bits), "{words:?} {clock:?}");
        };
        check(&["1", "0"], Clock::Free, 1);
        check(&["10", "100"], Clock::Free, 4); // …10|10010 against …0|1010: 010 in both
        check(&["001", "010", "100"], Clock::Locked, 2);
        check(&["01"], Clock::Free, 0);
        check(&[], Clock::Locked, 0);
    }

    #[test]
    fn shifts_of_one_word_are_twins_without_a_clock() {
        let check = |words: &[&str], shift: usize| {
            let twins = Twins { first: PatternId(1), second: PatternId(2), shift };
            assert_eq!(bits_to_tell_apart(&codes(words), Clock::Free), Err(twins), "{words:?}");
        };
        check(&["001", "010"], 2);
        check(&["001", "100"], 1);
        check(&["01", "0101"], 0);
    }

    #[test]
    fn companions_of_three_bits_take_three_and_m() {
        let check = |degree: u32, bits: usize| {
            assert_eq!(bits_to_name(&design_codes(degree, 3, 6).unwrap()), Ok(bits), "m = {degree}");
        };
        check(4, 7);
        check(6, 9); // more than 2·b + 1
        check(8, 11);
    }

    proptest! {
        /// Shift-and-add: an m-sequence and itself b bits later add up to a third shift of it, whose longest dark run is
        /// m − 1; so it blinks like a code of b bits for exactly b + m − 1 bits, and b + m tell.
        #[test]
        fn a_companion_is_told_from_the_m_sequence_by_b_and_m_bits((degree, bits) in companions()) {
            let all = design_codes(degree, bits, usize::min(12, (1 << bits) - 2 - short_words(bits))).unwrap();
            let needed = bits_to_name(&all).unwrap();
            prop_assert!(needed <= (bits + degree) as usize, "{needed} bits for m = {degree}, b = {bits}");
        }
    }

    fn companions() -> impl Strategy<Value = (u32, u32)> {
        prop::sample::select(vec![(4, 3), (4, 5), (6, 3), (6, 7), (6, 9), (8, 3), (8, 5), (8, 15), (8, 17)])
    }

    /// Words of `bits` bits that blink with a shorter period.
    fn short_words(bits: u32) -> usize {
        match bits {
            9 => 6,
            15 => 6 + 30,
            _ => 0,
        }
    }
}
