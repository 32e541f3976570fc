//! Words to a terminal or whoever listens. A listener that has heard enough, such as `head`, is no failure: what was asked
//! for is done all the same.

use std::fmt::Display;
use std::io::Write;

/// What was asked for, on standard output.
pub fn answer(text: impl Display) {
    let _ = write!(std::io::stdout(), "{text}");
}

/// A line about it, on standard error.
pub fn tell(line: impl Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
