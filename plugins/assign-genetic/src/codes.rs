//! The codes that blink: as many as LEDs, and each LED knows which.

use crate::params::Params;
use fibar_core::artefact::constellation::Pattern;
use fibar_core::artefact::sockets::Sockets;
use fibar_core::code::{CodeError, design_codes};
use fibar_plugin::StageError;

/// The code set for the LEDs of a base, pattern 1 first.
pub fn codes_for(sockets: &Sockets, params: &Params) -> Result<Vec<Pattern>, StageError> {
    let leds = sockets.sockets.len();
    let codes = params.codes.map_or(leds, |c| c as usize);
    if codes > leds {
        let message = format!("{codes} codes asked for, but the base has {leds} LEDs to blink them");
        return Err(StageError::user(message)
            .param("/codes")
            .hint("lower codes, or raise count of socket-led"));
    }
    if codes < leds {
        let message = format!(
            "{codes} codes asked for, but the base has {leds} LEDs: {} would blink none",
            leds - codes
        );
        return Err(StageError::user(message)
            .param("/codes")
            .hint("raise codes, or lower count of socket-led"));
    }
    let mut patterns: Vec<u32> = sockets.sockets.iter().map(|s| s.pattern.0).collect();
    patterns.sort_unstable();
    if !patterns.iter().copied().eq(1..=codes as u32) {
        let message = format!("the LEDs blink patterns {patterns:?}, not 1 to {codes} each once");
        return Err(StageError::input(message).hint("socket-led numbers them so"));
    }
    let designed = design_codes(params.degree, params.companion_bits, codes - 1).map_err(impossible)?;
    Ok(designed.into_iter().map(|code| Pattern { id: code.pattern, bits: code.bits }).collect())
}

fn impossible(error: CodeError) -> StageError {
    let (param, hint) = match error {
        CodeError::Degree(_) | CodeError::NoMSequence => ("/degree", "4 is the paper's"),
        CodeError::CompanionLength { .. } => {
            ("/companion_bits", "with degree 4 use 3 or 5; degrees 3, 5 and 7 have no companion codes")
        }
        CodeError::TooMany { .. } => ("/companion_bits", "longer codes are more: 5 bits at degree 4 give 30"),
    };
    StageError::user(error.to_string()).param(param).hint(hint)
}
