//! What went wrong, where, and what to try: one value for everything a person has to read.
//!
//! A diagnostic knows its place in a source text by byte range; turning it into `file:line:column` with an excerpt is
//! done here, printing it is not.

use std::fmt::Write;
use std::ops::Range;
use std::sync::Arc;

/// One finding, ready to be shown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong, one sentence in the user's units.
    pub message: String,
    /// Where in which source text.
    pub place: Option<Place>,
    /// Further lines: what it was derived from, what was found instead.
    pub notes: Vec<String>,
    /// What to try.
    pub hints: Vec<String>,
}

/// How bad a [`Diagnostic`] is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing.
    Warning,
    /// Nothing can be built until it is mended.
    Error,
}

/// A range of bytes in a source text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The text.
    pub source: Arc<SourceText>,
    /// Bytes of `source.text`.
    pub range: Range<usize>,
}

/// A text that diagnostics point into.
#[derive(Debug, PartialEq, Eq)]
pub struct SourceText {
    /// As the user named it, e.g. `recipes/bunny.toml`.
    pub name: String,
    /// The whole text.
    pub text: String,
}

impl Diagnostic {
    /// An error without a place.
    pub fn error(message: impl Into<String>) -> Diagnostic {
        Diagnostic {
            severity: Severity::Error,
            message: message.into(),
            place: None,
            notes: Vec::new(),
            hints: Vec::new(),
        }
    }

    /// A warning without a place.
    pub fn warning(message: impl Into<String>) -> Diagnostic {
        Diagnostic { severity: Severity::Warning, ..Diagnostic::error(message) }
    }

    /// The same, at a place.
    pub fn at(mut self, source: &Arc<SourceText>, range: Range<usize>) -> Diagnostic {
        self.place = Some(Place { source: Arc::clone(source), range });
        self
    }

    /// The same, with one more note.
    pub fn note(mut self, note: impl Into<String>) -> Diagnostic {
        self.notes.push(note.into());
        self
    }

    /// The same, with one more thing to try.
    pub fn hint(mut self, hint: impl Into<String>) -> Diagnostic {
        self.hints.push(hint.into());
        self
    }

    /// Several lines of text: message, place with excerpt, notes, hints. No colours, no trailing newline.
    pub fn render(&self) -> String {
        let mut out = match self.severity {
            Severity::Warning => format!("warning: {}", self.message),
            Severity::Error => format!("error: {}", self.message),
        };
        if let Some(place) = &self.place {
            place.render_into(&mut out);
        }
        for note in &self.notes {
            let _ = write!(out, "\n  note: {}", note.replace('\n', "\n        "));
        }
        for hint in &self.hints {
            let _ = write!(out, "\n  try: {}", hint.replace('\n', "\n       "));
        }
        out
    }
}

impl std::fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.render())
    }
}

impl Place {
    /// `file:line:column`, both counted from 1, columns in characters.
    pub fn label(&self) -> String {
        let (line, column) = self.source.line_column(self.range.start);
        format!("{}:{line}:{column}", self.source.name)
    }

    fn render_into(&self, out: &mut String) {
        let (line, column) = self.source.line_column(self.range.start);
        let text = self.source.line(line);
        let gutter = line.to_string().len();
        let on_line = text.chars().count() + 1 - column.min(text.chars().count() + 1);
        let wanted = self.source.text.get(self.range.clone()).map_or(1, |s| s.chars().count());
        let carets = "^".repeat(wanted.clamp(1, on_line.max(1)));
        let _ = write!(out, "\n{:gutter$}--> {}", "", self.label());
        let _ = write!(out, "\n{:gutter$} |\n{line} | {}", "", text.replace('\t', " "));
        let _ = write!(out, "\n{:gutter$} | {:skip$}{carets}", "", "", skip = column - 1);
    }
}

impl SourceText {
    /// A text under the name people know it by.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Arc<SourceText> {
        Arc::new(SourceText { name: name.into(), text: text.into() })
    }

    /// Line and column of a byte, both from 1, columns in characters.
    pub fn line_column(&self, byte: usize) -> (usize, usize) {
        let byte = self.text.floor_char_boundary(byte.min(self.text.len()));
        let before = &self.text[..byte];
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }

    /// The text of a line, counted from 1, without its line end.
    pub fn line(&self, number: usize) -> &str {
        self.text.lines().nth(number - 1).unwrap_or("")
    }
}

/// The candidate that `word` was probably meant to be: at most a third of its letters away.
pub fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let folded = word.to_lowercase().replace('-', "_");
    let distance = |c: &str| strsim::damerau_levenshtein(&folded, &c.to_lowercase().replace('-', "_"));
    let (best, candidate) = candidates.into_iter().map(|c| (distance(c), c)).min()?;
    let allowed = (word.chars().count().max(candidate.chars().count()) / 3).max(1);
    (best <= allowed).then_some(candidate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::{Expect, expect};

    #[track_caller]
    fn check(text: &str, marked: &str, expected: Expect) {
        let source = SourceText::new("a.toml", text);
        let start = text.find(marked).unwrap();
        let diagnostic = Diagnostic::error("bad").at(&source, start..start + marked.len()).hint("this");
        expected.assert_eq(&diagnostic.render());
    }

    #[test]
    fn excerpt_marks_the_place() {
        check(
            "a = 1\nspacin = 12\n",
            "spacin",
            expect![[r#"
                error: bad
                 --> a.toml:2:1
                  |
                2 | spacin = 12
                  | ^^^^^^
                  try: this"#]],
        );
        check(
            "é = \"x\ny\"",
            "\"x\ny\"",
            expect![[r#"
                error: bad
                 --> a.toml:1:5
                  |
                1 | é = "x
                  |     ^^
                  try: this"#]],
        );
        check(
            "",
            "",
            expect![[r#"
                error: bad
                 --> a.toml:1:1
                  |
                1 | 
                  | ^
                  try: this"#]],
        );
    }

    #[track_caller]
    fn check_guess(word: &str, expected: Option<&str>) {
        assert_eq!(did_you_mean(word, ["spacing_mm", "path", "route-fibar", "k3"]), expected, "{word}");
    }

    #[test]
    fn guesses_are_near() {
        check_guess("spacing", Some("spacing_mm"));
        check_guess("spacing-mm", Some("spacing_mm"));
        check_guess("Path", Some("path"));
        check_guess("route_fiber", Some("route-fibar"));
        check_guess("k4", Some("k3"));
        check_guess("colour", None);
        check_guess("", None);
    }
}
