//! Blink codes: the m-sequence and its companions (Tone 2020, "Blinking pattern", table "Binary codes for seven LEDs").
//!
//! A base blinks one m-sequence of `2^m − 1` bits, pattern 1, from whose latest `m` bits a camera tells the phase; every
//! other pattern has a short code whose length divides the m-sequence's, so that phase names its bits too.

use crate::id::PatternId;

/// One pattern and the bits it repeats, first bit first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Code {
    /// Which pattern blinks it.
    pub pattern: PatternId,
    /// One period of the code.
    pub bits: Vec<bool>,
}

/// Why a set of codes cannot exist.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CodeError {
    /// Pattern 1 is missing, or is no m-sequence.
    #[error("pattern 1 must be an m-sequence: each of its windows of m bits occurs once")]
    NoMSequence,
    /// No primitive polynomial is tabled for this degree.
    #[error("no m-sequence of degree {0} is known here: use a degree from 3 to 8")]
    Degree(u32),
    /// The companion length does not divide the m-sequence's, or exceeds half of it.
    #[error(
        "companion codes of {bits} bits do not fit an m-sequence of {period} bits: the length must divide {period} and be at most half of it"
    )]
    CompanionLength {
        /// Companion length asked for.
        bits: u32,
        /// Length of the m-sequence.
        period: u32,
    },
    /// More patterns asked for than distinct words exist.
    #[error(
        "{wanted} companion codes asked for, but only {available} words of {bits} bits blink and have no shorter period"
    )]
    TooMany {
        /// Companions asked for.
        wanted: usize,
        /// Companions that exist.
        available: usize,
        /// Companion length.
        bits: u32,
    },
}

/// The paper's code set: the m-sequence as pattern 1, then `companions` words of `companion_bits` bits in rising binary
/// order, all-dark, all-lit and words of a shorter period left out.
pub fn design_codes(degree: u32, companion_bits: u32, companions: usize) -> Result<Vec<Code>, CodeError> {
    let sequence = m_sequence(degree)?;
    let words = companion_words(sequence.len() as u32, companion_bits)?;
    if companions > words.len() {
        return Err(CodeError::TooMany { wanted: companions, available: words.len(), bits: companion_bits });
    }
    let first = Code { pattern: PatternId::M_SEQUENCE, bits: sequence };
    let others = words.into_iter().take(companions).zip(2..);
    Ok(std::iter::once(first).chain(others.map(|(bits, id)| Code { pattern: PatternId(id), bits })).collect())
}

/// The m-sequence of `2^degree − 1` bits. Degree 4 gives the paper's `100011110101100`.
pub fn m_sequence(degree: u32) -> Result<Vec<bool>, CodeError> {
    // s[n] = s[n − degree] ⊕ s[n − degree + tap] of the primitive polynomials x^m + x^tap + … + 1.
    let taps: &[u32] = match degree {
        3 => &[1],
        4 => &[3],
        5 => &[2],
        6 => &[1],
        7 => &[1],
        8 => &[2, 3, 4],
        _ => return Err(CodeError::Degree(degree)),
    };
    let (m, period) = (degree as usize, (1usize << degree) - 1);
    let mut bits = vec![false; period];
    bits[0] = true;
    for n in m..period {
        bits[n] = taps.iter().fold(bits[n - m], |bit, &tap| bit ^ bits[n - m + tap as usize]);
    }
    Ok(bits)
}

/// Every word of `bits` bits that may accompany an m-sequence of `period` bits, in rising binary order.
fn companion_words(period: u32, bits: u32) -> Result<Vec<Vec<bool>>, CodeError> {
    if bits == 0 || !period.is_multiple_of(bits) || bits > period / 2 || bits > 24 {
        return Err(CodeError::CompanionLength { bits, period });
    }
    let word = |value: u32| (0..bits).rev().map(|k| value >> k & 1 == 1).collect::<Vec<bool>>();
    Ok((1..(1u32 << bits) - 1).map(word).filter(|w| has_full_period(w)).collect())
}

fn has_full_period(word: &[bool]) -> bool {
    (1..word.len()).all(|shift| (0..word.len()).any(|k| word[k] != word[(k + shift) % word.len()]))
}

/// The bits as text, `1` lit and `0` dark.
pub fn bits_to_string(bits: &[bool]) -> String {
    bits.iter().map(|&b| if b { '1' } else { '0' }).collect()
}

/// Bits from text; `None` if it holds anything but `0` and `1`, or nothing.
pub fn bits_from_str(text: &str) -> Option<Vec<bool>> {
    let bits: Option<Vec<bool>> = text.chars().map(|c| matches!(c, '0' | '1').then_some(c == '1')).collect();
    bits.filter(|b| !b.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_table_of_seven_codes() {
        let codes = design_codes(4, 3, 6).unwrap();
        let text: Vec<String> = codes.iter().map(|c| bits_to_string(&c.bits)).collect();
        assert_eq!(text, ["100011110101100", "001", "010", "011", "100", "101", "110"]);
        assert_eq!(codes.iter().map(|c| c.pattern.0).collect::<Vec<_>>(), [1, 2, 3, 4, 5, 6, 7]);
    }

    #[test]
    fn every_window_of_an_m_sequence_is_unique() {
        for degree in 3..=8 {
            let bits = m_sequence(degree).unwrap();
            let n = bits.len();
            let windows: std::collections::BTreeSet<Vec<bool>> =
                (0..n).map(|i| (0..degree as usize).map(|k| bits[(i + k) % n]).collect()).collect();
            assert_eq!(windows.len(), n, "degree {degree}");
        }
    }

    #[test]
    fn an_m_sequence_is_unlike_its_shifts() {
        for degree in 3..=8 {
            let bits = m_sequence(degree).unwrap();
            let n = bits.len();
            let differing = |shift: usize| (0..n).filter(|&k| bits[k] != bits[(k + shift) % n]).count();
            assert!(
                (1..n).all(|shift| differing(shift) == n.div_ceil(2)),
                "degree {degree}: autocorrelation −1"
            );
        }
    }

    #[test]
    fn impossible_sets_are_refused() {
        assert_eq!(m_sequence(9), Err(CodeError::Degree(9)));
        for degree in [3, 5, 7] {
            let period = (1 << degree) - 1;
            assert_eq!(
                design_codes(degree, 3, 1),
                Err(CodeError::CompanionLength { bits: 3, period }),
                "the period {period} is prime"
            );
        }
        assert_eq!(design_codes(4, 3, 7), Err(CodeError::TooMany { wanted: 7, available: 6, bits: 3 }));
    }
}
