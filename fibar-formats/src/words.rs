//! Text as words with their lines.

use crate::error::{Place, ReadError};
use crate::stream::Stream;

/// The words of a text, split at white space.
pub struct Words<'a> {
    stream: Stream<'a>,
    line: u64,
}

/// A word and where it stands.
pub struct Word<'w> {
    /// The word; empty where the text ends.
    pub text: &'w str,
    /// Its line.
    pub place: Place,
}

impl<'a> Words<'a> {
    /// Words of a text, whose first line counts as `line`.
    pub fn new(stream: Stream<'a>, line: u64) -> Words<'a> {
        Words { stream, line }
    }

    /// The next word; an error where the text ends.
    pub fn next(&mut self) -> Result<Word<'_>, ReadError> {
        if self.is_at_end()? {
            return Err(self.error("the file ends too early"));
        }
        let length = self.stream.length_until(|byte| byte.is_ascii_whitespace())?;
        let place = self.place();
        let text = std::str::from_utf8(self.stream.take(length)?);
        text.map(|text| Word { text, place }).map_err(|_| ReadError::new(place, "this is not text"))
    }

    /// The next word, which must be `word` (any case).
    pub fn expect(&mut self, word: &str) -> Result<(), ReadError> {
        let found = self.next()?;
        if found.text.eq_ignore_ascii_case(word) {
            return Ok(());
        }
        Err(found.error(format!("`{}` where `{word}` should be", found.shown())))
    }

    /// The next word as a finite number.
    pub fn number(&mut self) -> Result<f64, ReadError> {
        let word = self.next()?;
        parse_number(word.text, word.place)
    }

    /// Leaves out the rest of the line.
    pub fn skip_line(&mut self) -> Result<(), ReadError> {
        let length = self.stream.length_until(|byte| byte == b'\n')?;
        self.stream.skip(length);
        Ok(())
    }

    /// Moves to the first byte of the next word; true if there is none.
    pub fn is_at_end(&mut self) -> Result<bool, ReadError> {
        let mut lines = 0;
        loop {
            let window = self.stream.peek(1)?;
            let blank = window.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(window.len());
            lines += window[..blank].iter().filter(|&&b| b == b'\n').count() as u64;
            let (is_end, is_word) = (window.is_empty(), blank < window.len());
            self.stream.skip(blank);
            if is_word {
                // At the end of the file an error belongs to the last line that holds something.
                self.line += lines;
            }
            if is_end || is_word {
                return Ok(is_end);
            }
        }
    }

    /// Bytes not read yet, white space included.
    pub fn remaining(&self) -> u64 {
        self.stream.remaining()
    }

    /// The line of the word read last.
    pub fn place(&self) -> Place {
        Place::Line(self.line)
    }

    /// An error at the word read last.
    pub fn error(&self, message: impl Into<String>) -> ReadError {
        ReadError::new(self.place(), message)
    }
}

impl Word<'_> {
    /// An error here.
    pub fn error(&self, message: impl Into<String>) -> ReadError {
        ReadError::new(self.place, message)
    }

    /// The word as it can be shown.
    pub fn shown(&self) -> String {
        shown(self.text)
    }
}

/// A word as a finite number.
pub fn parse_number(word: &str, place: Place) -> Result<f64, ReadError> {
    match word.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(ReadError::new(place, format!("`{}` is not a finite number", shown(word)))),
        Err(_) => Err(ReadError::new(place, format!("`{}` is not a number", shown(word)))),
    }
}

/// The beginning of a text, without control characters: fit for a message.
pub fn shown(text: &str) -> String {
    let head: String = text.chars().take(40).map(|c| if c.is_control() { '\u{FFFD}' } else { c }).collect();
    if text.chars().nth(40).is_some() { head + "…" } else { head }
}
