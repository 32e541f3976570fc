//! How much may come out of an archive: declared sizes are not believed, bytes are counted as they come.

use std::cell::Cell;
use std::io::{self, Read};
use std::rc::Rc;

/// The longest tag, attributes included, or text.
const LONGEST_TOKEN: u64 = 1 << 24;

/// What is left of the bytes that an archive may unpack to. Clones share it.
#[derive(Clone)]
pub struct Budget(Rc<State>);

struct State {
    most: u64,
    left: Cell<u64>,
    token: Cell<u64>,
    excess: Cell<Option<Excess>>,
}

#[derive(Clone, Copy)]
enum Excess {
    Total,
    Token,
}

impl Budget {
    /// So many bytes in all.
    pub fn new(most: u64) -> Budget {
        Budget(Rc::new(State { most, left: Cell::new(most), token: Cell::new(0), excess: Cell::new(None) }))
    }

    /// The next bytes belong to another tag or text.
    pub fn begin_token(&self) {
        self.0.token.set(0);
    }

    /// What was too much, if something was.
    pub fn excess(&self) -> Option<String> {
        self.0.excess.get().map(|excess| match excess {
            Excess::Total => format!("it unpacks to more than {} bytes: a ZIP bomb", self.0.most),
            Excess::Token => "a tag or text of more than 16 MB".to_string(),
        })
    }

    fn spend(&self, count: u64) -> io::Result<()> {
        let State { left, token, excess, .. } = &*self.0;
        token.set(token.get() + count);
        match left.get().checked_sub(count) {
            None => excess.set(Some(Excess::Total)),
            Some(_) if token.get() > LONGEST_TOKEN => excess.set(Some(Excess::Token)),
            Some(rest) => {
                left.set(rest);
                return Ok(());
            }
        }
        Err(io::Error::other("too much"))
    }
}

/// Counts what is read.
pub struct Counted<R> {
    /// What is read.
    pub inner: R,
    /// What is counted against.
    pub budget: Budget,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(buffer)?;
        self.budget.spend(count as u64)?;
        Ok(count)
    }
}
