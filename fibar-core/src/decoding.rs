//! From a blob's bits to its pattern: phase, then name (Tone 2020, "Blinking pattern").
//!
//! Bits come oldest first and are taken as seen: a stage that samples frames, bridges gaps and mends errors comes before
//! this one. Nothing here knows of markers.

use crate::code::{Code, CodeError};
use crate::id::PatternId;

/// How many bits must repeat with the companions' period before a blob is held to be no m-sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// `2·b`, as printed. One too few for the paper's own codes: 100100 stands across the wrap of their m-sequence.
    Tone2020,
    /// `b + m`: the fewest that never fail, by shift-and-add; `2·b + 1` for the paper's m = 4, b = 3.
    Certain,
}

/// What a blob's bits say without a clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// It blinks the m-sequence, whose bit of this index it showed last.
    MSequence {
        /// Index of the latest bit, from 0.
        phase: usize,
    },
    /// It blinks some companion code.
    Companion,
}

/// A base's codes, ready to be recognised.
#[derive(Clone, Debug)]
pub struct Decoder {
    codes: Vec<Code>,
    degree: usize,
    companion_bits: usize,
    rule: Rule,
    /// By the value of `degree` bits: the index of the m-sequence's bit that ends them.
    phases: Vec<Option<usize>>,
}

impl Decoder {
    /// A decoder of an m-sequence, pattern 1, and companions of one length.
    pub fn new(codes: &[Code], rule: Rule) -> Result<Decoder, CodeError> {
        let first =
            codes.iter().find(|c| c.pattern == PatternId::M_SEQUENCE).ok_or(CodeError::NoMSequence)?;
        let period = first.bits.len();
        let degree = (period + 1).ilog2() as usize;
        let phases = window_phases(&first.bits, degree).ok_or(CodeError::NoMSequence)?;
        let mut lengths = codes.iter().filter(|c| c.pattern != first.pattern).map(|c| c.bits.len());
        let companion_bits = lengths.next().unwrap_or(0);
        let odd = lengths.find(|&bits| bits != companion_bits);
        if let Some(bits) =
            odd.or((companion_bits != 0 && period % companion_bits != 0).then_some(companion_bits))
        {
            return Err(CodeError::CompanionLength { bits: bits as u32, period: period as u32 });
        }
        Ok(Decoder { codes: codes.to_vec(), degree, companion_bits, rule, phases })
    }

    /// Bits that [`read`](Self::read) needs to see before it calls a blob a companion.
    pub fn window(&self) -> usize {
        match self.rule {
            Rule::Tone2020 => 2 * self.companion_bits,
            Rule::Certain => self.companion_bits + self.degree,
        }
    }

    /// What the latest bits say of themselves: an m-sequence as soon as they break the companions' period, a companion
    /// when a whole window keeps it. `None` while there are too few, or when no window of the m-sequence ends them.
    pub fn read(&self, bits: &[bool]) -> Option<Reading> {
        let window = &bits[bits.len().saturating_sub(self.window().max(self.degree))..];
        let repeats = |k: usize| window[k] == window[k - self.companion_bits];
        if self.companion_bits > 0 && (self.companion_bits..window.len()).all(repeats) {
            return (window.len() >= self.window()).then_some(Reading::Companion);
        }
        self.phase(window).map(|phase| Reading::MSequence { phase })
    }

    /// Index of the m-sequence's bit that the latest `m` bits end with, if they are bits of the m-sequence.
    pub fn phase(&self, bits: &[bool]) -> Option<usize> {
        let latest = &bits[bits.len().checked_sub(self.degree)?..];
        self.phases[value(latest)]
    }

    /// The one pattern that shows these bits when the m-sequence's latest bit has index `phase`; `None` when several
    /// do, or none does.
    pub fn name(&self, bits: &[bool], phase: usize) -> Option<PatternId> {
        let mut agreeing = self.codes.iter().filter(|code| shows(code, bits, phase));
        let only = agreeing.next().map(|code| code.pattern);
        if agreeing.next().is_some() { None } else { only }
    }
}

fn shows(code: &Code, bits: &[bool], phase: usize) -> bool {
    let length = code.bits.len();
    let at = |age: usize| code.bits[(phase % length + length - age % length) % length];
    bits.iter().rev().enumerate().all(|(age, &bit)| bit == at(age))
}

/// By the value of a window: where in the cycle it ends; `None` if a window occurs twice or is all dark.
fn window_phases(cycle: &[bool], degree: usize) -> Option<Vec<Option<usize>>> {
    let mut phases = vec![None; 1 << degree];
    for phase in 0..cycle.len() {
        let bit = |k: usize| cycle[(phase + cycle.len() + 1 + k - degree) % cycle.len()];
        let window: Vec<bool> = (0..degree).map(bit).collect();
        if value(&window) == 0 || phases[value(&window)].replace(phase).is_some() {
            return None;
        }
    }
    Some(phases)
}

fn value(bits: &[bool]) -> usize {
    bits.iter().fold(0, |value, &bit| value << 1 | usize::from(bit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{bits_from_str, design_codes};
    use proptest::prelude::*;

    fn paper(rule: Rule) -> Decoder {
        Decoder::new(&design_codes(4, 3, 6).unwrap(), rule).unwrap()
    }

    /// The last `count` bits of a code whose m-sequence is at `phase`.
    fn stream(code: &Code, phase: usize, count: usize) -> Vec<bool> {
        let length = code.bits.len();
        (0..count).rev().map(|age| code.bits[(phase + length * count - age) % length]).collect()
    }

    #[test]
    fn bits_are_read_as_soon_as_they_tell() {
        let check = |bits: &str, expected: Option<Reading>| {
            assert_eq!(paper(Rule::Certain).read(&bits_from_str(bits).unwrap()), expected, "{bits}");
        };
        check("1000", Some(Reading::MSequence { phase: 3 }));
        check("0001", Some(Reading::MSequence { phase: 4 }));
        check("1001", None); // a companion, or the m-sequence across its wrap
        check("100100", None);
        check("1001001", Some(Reading::Companion));
        check("1001000", Some(Reading::MSequence { phase: 3 }));
        check("0000", None);
        check("10", None);
    }

    #[test]
    fn the_papers_rule_fails_at_one_phase_of_fifteen() {
        let sequence = &design_codes(4, 3, 6).unwrap()[0];
        let misread = |rule: Rule| -> Vec<usize> {
            let read =
                |&phase: &usize| paper(rule).read(&stream(sequence, phase, 15)) == Some(Reading::Companion);
            (0..15).filter(read).collect()
        };
        assert_eq!(misread(Rule::Tone2020), [2], "100|100 across the wrap ends at bit 2");
        assert_eq!(misread(Rule::Certain), [] as [usize; 0]);
    }

    #[test]
    fn sets_without_a_clock_are_refused() {
        let check = |words: &[&str], error: CodeError| {
            let code = |(word, id): (&&str, u32)| Code {
                pattern: PatternId(id),
                bits: bits_from_str(word).unwrap(),
            };
            let codes: Vec<Code> = words.iter().zip(1..).map(code).collect();
            assert_eq!(Decoder::new(&codes, Rule::Certain).unwrap_err(), error, "{words:?}");
        };
        check(&[], CodeError::NoMSequence);
        check(&["100011110101101"], CodeError::NoMSequence);
        check(&["100011110101100", "001", "0110"], CodeError::CompanionLength { bits: 4, period: 15 });
        check(&["100011110101100", "0110"], CodeError::CompanionLength { bits: 4, period: 15 });
    }

    proptest! {
        #[test]
        fn every_stream_is_named(
            (degree, bits) in prop::sample::select(vec![(4, 3), (4, 5), (6, 3), (6, 7), (6, 9), (8, 5), (8, 17)]),
            pick in any::<prop::sample::Index>(), start in 0usize..255, extra in 0usize..40,
        ) {
            let codes = design_codes(degree, bits, 6).unwrap();
            let decoder = Decoder::new(&codes, Rule::Certain).unwrap();
            let (code, period) = (pick.get(&codes), codes[0].bits.len());
            let (phase, count) = (start % period, decoder.window() + extra);
            let seen = stream(code, phase, count);
            let reading = if code.pattern == PatternId::M_SEQUENCE { Reading::MSequence { phase } } else { Reading::Companion };
            prop_assert_eq!(decoder.read(&seen), Some(reading));
            prop_assert_eq!(decoder.name(&seen, phase), Some(code.pattern));
        }

        #[test]
        fn fewer_bits_are_never_misread(pick in any::<prop::sample::Index>(), phase in 0usize..15, count in 0usize..7) {
            let codes = design_codes(4, 3, 6).unwrap();
            let code = pick.get(&codes);
            let expected = (code.pattern == PatternId::M_SEQUENCE).then_some(Reading::MSequence { phase });
            let reading = paper(Rule::Certain).read(&stream(code, phase, count));
            prop_assert!(reading.is_none() || reading == expected, "{:?} of {:?}", reading, code);
        }
    }
}
