//! One lock per action key, held while the action runs; the kernel drops it with the process, however that ends.

use super::Store;
use crate::error::IoContext;
use crate::{Digest, Result};
use std::fs::File;

/// A held lock.
#[derive(Debug)]
pub struct KeyLock(#[allow(dead_code, reason = "held, not read")] File);

impl Store {
    /// Tries to lock a key; `None` while another process executes it.
    pub fn try_lock(&self, key: &Digest) -> Result<Option<KeyLock>> {
        let path = self.root().join("locks").join(key.to_string());
        let file = File::options().create(true).append(true).open(&path).context("open the lock", &path)?;
        match file.try_lock() {
            // Swept between opening and locking: somebody else may hold the lock of that name by now.
            Ok(()) if !is_at(&file, &path) => Ok(None),
            Ok(()) => Ok(Some(KeyLock(file))),
            Err(std::fs::TryLockError::WouldBlock) => Ok(None),
            Err(std::fs::TryLockError::Error(e)) => Err(e).context("lock", &path),
        }
    }
}

/// Whether the file is still the one at the path.
fn is_at(file: &File, path: &std::path::Path) -> bool {
    let identity = |meta: std::fs::Metadata| crate::os::same_file(&meta);
    match (file.metadata(), path.metadata()) {
        (Ok(own), Ok(there)) => identity(own) == identity(there),
        _ => false,
    }
}
