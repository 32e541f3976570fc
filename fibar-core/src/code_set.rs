//! The codes that the LEDs of a base blink: as many as LEDs, and each LED knows which.

use crate::artefact::constellation::Pattern;
use crate::artefact::sockets::Sockets;
use crate::code::{CodeError, design_codes};

/// What a recipe says about the codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CodePlan {
    /// Degree `m` of the m-sequence of `2^m − 1` bits.
    pub degree: u32,
    /// Length `b` of the other codes, a divisor of `2^m − 1`.
    pub companion_bits: u32,
    /// How many codes blink; one for each LED if left out.
    pub codes: Option<u32>,
}

/// Why a base cannot blink the codes that are asked for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct CodeSetError {
    /// What is wrong.
    pub message: String,
    /// What to try.
    pub hint: &'static str,
    /// Field of [`CodePlan`] that asks for it; `None` if the sockets are at fault.
    pub field: Option<&'static str>,
}

/// The code set for the LEDs of a base, pattern 1 first.
pub fn codes_for(sockets: &Sockets, plan: CodePlan) -> Result<Vec<Pattern>, CodeSetError> {
    let leds = sockets.sockets.len();
    let codes = plan.codes.map_or(leds, |c| c as usize);
    if codes > leds {
        let message = format!("{codes} codes asked for, but the base has {leds} LEDs to blink them");
        return Err(refuse(message, "lower codes, or raise count of socket-led", "codes"));
    }
    if codes < leds {
        let dark = leds - codes;
        let message =
            format!("{codes} codes asked for, but the base has {leds} LEDs: {dark} would blink none");
        return Err(refuse(message, "raise codes, or lower count of socket-led", "codes"));
    }
    let mut patterns: Vec<u32> = sockets.sockets.iter().map(|s| s.pattern.0).collect();
    patterns.sort_unstable();
    if !patterns.iter().copied().eq(1..=codes as u32) {
        let message = format!("the LEDs blink patterns {patterns:?}, not 1 to {codes} each once");
        return Err(CodeSetError { message, hint: "socket-led numbers them so", field: None });
    }
    let designed = design_codes(plan.degree, plan.companion_bits, codes - 1).map_err(impossible)?;
    Ok(designed.into_iter().map(|code| Pattern { id: code.pattern, bits: code.bits }).collect())
}

fn impossible(error: CodeError) -> CodeSetError {
    let (field, hint) = match error {
        CodeError::Degree(_) | CodeError::NoMSequence => ("degree", "4 is the paper's"),
        CodeError::CompanionLength { .. } => {
            ("companion_bits", "with degree 4 use 3 or 5; degrees 3, 5 and 7 have no companion codes")
        }
        CodeError::TooMany { .. } => ("companion_bits", "longer codes are more: 5 bits at degree 4 give 30"),
    };
    refuse(error.to_string(), hint, field)
}

fn refuse(message: String, hint: &'static str, field: &'static str) -> CodeSetError {
    CodeSetError { message, hint, field: Some(field) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::artefact::sockets::{Hole, Socket};
    use crate::{LedId, PatternId};
    use glam::DVec3;

    const PAPER: CodePlan = CodePlan { degree: 4, companion_bits: 3, codes: None };

    fn base(leds: u32) -> Sockets {
        let socket = |k: u32| Socket {
            led: LedId(k),
            pattern: PatternId(k + 1),
            position: DVec3::X * f64::from(k),
            axis: DVec3::Z,
        };
        Sockets::new(Hole { diameter_mm: 5.2, depth_mm: 8.6 }, (0..leds).map(socket).collect())
    }

    #[test]
    fn impossible_codes_are_refused() {
        let check = |leds: u32, plan: CodePlan, says: &str| {
            let error = codes_for(&base(leds), plan).unwrap_err().to_string();
            assert!(error.contains(says), "{error:?} does not say {says:?}");
        };
        let eight = CodePlan { codes: Some(8), ..PAPER };
        check(7, eight, "8 codes asked for, but the base has 7 LEDs to blink them");
        check(7, CodePlan { codes: Some(5), ..PAPER }, "2 would blink none");
        check(9, PAPER, "8 companion codes asked for, but only 6");
        check(7, CodePlan { degree: 5, ..PAPER }, "companion codes of 3 bits do not fit");
    }

    #[test]
    fn every_led_needs_a_pattern_of_its_own() {
        let mut strange = base(7);
        strange.sockets[6].pattern = PatternId(9);
        let error = codes_for(&strange, PAPER).unwrap_err();
        assert!(error.to_string().contains("not 1 to 7") && error.field.is_none(), "{error}");
    }

    #[test]
    fn there_are_as_many_codes_as_leds() {
        let check = |leds: u32| assert_eq!(codes_for(&base(leds), PAPER).unwrap().len(), leds as usize);
        check(1);
        check(4);
        check(7);
    }
}
