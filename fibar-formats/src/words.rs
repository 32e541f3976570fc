//! Text as words with their lines.

use crate::error::{Place, ReadError};

/// The words of a text, split at white space.
pub struct Words<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Words<'a> {
    /// Words of `text`, whose first line counts as `line`.
    pub fn new(text: &'a [u8], line: usize) -> Words<'a> {
        Words { rest: text, line }
    }

    /// The next word; an error where the text ends.
    pub fn next(&mut self) -> Result<&'a str, ReadError> {
        self.peek_start();
        let length = self.rest.iter().position(u8::is_ascii_whitespace).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(length);
        self.rest = rest;
        if word.is_empty() {
            return Err(self.error("the file ends too early"));
        }
        std::str::from_utf8(word).map_err(|_| self.error("this is not text"))
    }

    /// The next word, which must be `word` (any case).
    pub fn expect(&mut self, word: &str) -> Result<(), ReadError> {
        let found = self.next()?;
        if found.eq_ignore_ascii_case(word) {
            return Ok(());
        }
        Err(self.error(format!("`{found}` where `{word}` should be")))
    }

    /// The next word as a finite number.
    pub fn number(&mut self) -> Result<f64, ReadError> {
        let word = self.next()?;
        parse_number(word, self.place())
    }

    /// Leaves out the rest of the line.
    pub fn skip_line(&mut self) {
        let length = self.rest.iter().position(|&b| b == b'\n').unwrap_or(self.rest.len());
        self.rest = &self.rest[length..];
    }

    /// Whether only white space is left.
    pub fn is_at_end(&mut self) -> bool {
        self.peek_start();
        self.rest.is_empty()
    }

    /// Bytes not read yet, white space before and after them aside.
    pub fn remaining(&self) -> usize {
        self.rest.trim_ascii().len()
    }

    /// The line of the word read last.
    pub fn place(&self) -> Place {
        Place::Line(self.line)
    }

    /// An error at the word read last.
    pub fn error(&self, message: impl Into<String>) -> ReadError {
        ReadError::new(self.place(), message)
    }

    /// Moves to the first byte of the next word.
    fn peek_start(&mut self) {
        let blank = self.rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(self.rest.len());
        let (skipped, rest) = self.rest.split_at(blank);
        // At the end of the file the error belongs to the last line that holds something.
        if !rest.is_empty() {
            self.line += skipped.iter().filter(|&&b| b == b'\n').count();
        }
        self.rest = rest;
    }
}

/// A word as a finite number.
pub fn parse_number(word: &str, place: Place) -> Result<f64, ReadError> {
    match word.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(ReadError::new(place, format!("`{word}` is not a finite number"))),
        Err(_) => Err(ReadError::new(place, format!("`{word}` is not a number"))),
    }
}
