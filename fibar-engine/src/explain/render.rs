//! An explanation as lines of text, one step to the right per stage upstream.

use super::{Change, Explanation, Verdict};
use std::fmt;

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, 0)
    }
}

impl Explanation {
    fn write(&self, f: &mut fmt::Formatter<'_>, depth: usize) -> fmt::Result {
        let verdict = match &self.verdict {
            Verdict::Hit(key) => format!("hit {}: the store has this, nothing would run", key.short()),
            Verdict::Miss(key) => format!("miss {}: would run", key.short()),
            Verdict::Gone(key) => format!("miss {}: the store had this, but an output is gone", key.short()),
            Verdict::Waits => "waits for its inputs".to_owned(),
        };
        let indent = "  ".repeat(2 * depth);
        writeln!(f, "{indent}`{}` ({}) {verdict}", self.stage, self.plugin)?;
        match self.earlier {
            Some(earlier) if !self.changes.is_empty() => {
                writeln!(f, "{indent}  compared with the earlier run {}:", earlier.short())?;
            }
            _ if matches!(self.verdict, Verdict::Miss(_)) => {
                writeln!(f, "{indent}  the store knows no earlier run of it")?;
            }
            _ => {}
        }
        self.changes.iter().try_for_each(|change| change.write(f, &indent, depth))
    }
}

impl Change {
    fn write(&self, f: &mut fmt::Formatter<'_>, indent: &str, depth: usize) -> fmt::Result {
        let or_none = |text: &str| if text.is_empty() { "nothing".to_owned() } else { text.to_owned() };
        write!(f, "{indent}  {}: {} → {}", self.field, or_none(&self.old), or_none(&self.new))?;
        if let Some(place) = &self.place {
            write!(f, "  ({})", place.label())?;
        }
        writeln!(f)?;
        self.because.as_ref().map_or(Ok(()), |because| because.write(f, depth + 1))
    }
}
