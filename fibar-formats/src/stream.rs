//! A file as bytes, front to back, through one buffer: what a reader holds of the file does not grow with the file.

use crate::error::{Place, ReadError};
use std::io::Read;

/// Bytes asked of the source at once.
const CHUNK: usize = 1 << 16;
/// The longest line or word that is taken into memory.
const LONGEST: usize = 1 << 24;

/// The bytes of a file that have not been taken yet.
pub struct Stream<'a> {
    source: &'a mut dyn Read,
    buffer: Vec<u8>,
    /// Bytes of `buffer` that have been taken.
    taken: usize,
    /// Bytes of the file before `buffer`.
    before: u64,
    length: u64,
}

impl<'a> Stream<'a> {
    /// A source that holds `length` bytes.
    pub fn new(source: &'a mut dyn Read, length: u64) -> Stream<'a> {
        Stream { source, buffer: Vec::new(), taken: 0, before: 0, length }
    }

    /// Bytes taken so far.
    pub fn offset(&self) -> u64 {
        self.before + self.taken as u64
    }

    /// Bytes that the file still holds.
    pub fn remaining(&self) -> u64 {
        self.length.saturating_sub(self.offset())
    }

    /// At least `count` bytes from here on, fewer only where the file ends.
    pub fn peek(&mut self, count: usize) -> Result<&[u8], ReadError> {
        while self.buffer.len() - self.taken < count && self.refill()? {}
        Ok(&self.buffer[self.taken..])
    }

    /// Passes over bytes that `peek` has shown.
    pub fn skip(&mut self, count: usize) {
        self.taken = (self.taken + count).min(self.buffer.len());
    }

    /// The next `count` bytes; an error where the file ends before.
    pub fn take(&mut self, count: usize) -> Result<&[u8], ReadError> {
        if self.peek(count)?.len() < count {
            let end = Place::Byte(self.before + self.buffer.len() as u64);
            return Err(ReadError::new(end, "the file ends too early"));
        }
        let start = self.taken;
        self.taken += count;
        Ok(&self.buffer[start..start + count])
    }

    /// How many bytes there are before the first one that `is_end`, or before the end of the file.
    pub fn length_until(&mut self, is_end: impl Fn(u8) -> bool) -> Result<usize, ReadError> {
        let mut searched = 0;
        loop {
            let window = &self.buffer[self.taken..];
            if let Some(found) = window[searched..].iter().position(|&byte| is_end(byte)) {
                return Ok(searched + found);
            }
            searched = window.len();
            if searched > LONGEST {
                return Err(ReadError::new(Place::Byte(self.offset()), "a line of more than 16 MB"));
            }
            if !self.refill()? {
                return Ok(searched);
            }
        }
    }

    /// The next line without its end; none at the end of the file.
    pub fn line(&mut self) -> Result<Option<&[u8]>, ReadError> {
        let length = self.length_until(|byte| byte == b'\n')?;
        let start = self.taken;
        let ended = self.buffer.len() - start > length;
        self.taken += length + usize::from(ended);
        Ok((length > 0 || ended).then(|| &self.buffer[start..start + length]))
    }

    /// Reads more; false at the end of the file.
    fn refill(&mut self) -> Result<bool, ReadError> {
        self.buffer.drain(..self.taken);
        self.before += std::mem::take(&mut self.taken) as u64;
        let held = self.buffer.len();
        self.buffer.resize(held + CHUNK.max(held), 0);
        let read = self.source.read(&mut self.buffer[held..]);
        self.buffer.truncate(held + *read.as_ref().unwrap_or(&0));
        match read {
            Ok(count) => Ok(count > 0),
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => Ok(true),
            Err(error) => {
                let place = Place::Byte(self.before + held as u64);
                Err(ReadError::new(place, format!("cannot read on: {error}")))
            }
        }
    }
}
