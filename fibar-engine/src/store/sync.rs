//! Syncing what a build published, once, at its end. What a power cut takes before that is found by its digest and
//! built again; nothing wrong can be read.

use super::Store;
use crate::Result;
use crate::error::IoContext;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// File systems write many files at once as fast as one.
const SYNC_THREADS: usize = 16;

/// Files that are visible but may not be on the disk yet.
#[derive(Debug, Default)]
pub(super) struct Unsynced(Mutex<Vec<PathBuf>>);

impl Unsynced {
    /// Notes a file.
    pub fn add(&self, path: &Path) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(path.to_owned());
    }

    fn take(&self) -> Vec<PathBuf> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Store {
    /// Waits until everything this store published is on the disk.
    pub fn sync(&self) -> Result<()> {
        let files = self.unsynced.take();
        if files.is_empty() {
            return Ok(());
        }
        let share = files.len().div_ceil(SYNC_THREADS);
        std::thread::scope(|scope| {
            let threads: Vec<_> = files
                .chunks(share)
                .map(|files| scope.spawn(|| files.iter().try_for_each(|f| sync(f))))
                .collect();
            threads.into_iter().try_for_each(|thread| thread.join().expect("syncing does not panic"))
        })
    }
}

/// A file that is gone again needs no syncing.
fn sync(path: &Path) -> Result<()> {
    match File::open(path) {
        Ok(file) => file.sync_all().context("sync", path),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(()),
        Err(e) => Err(e).context("sync", path),
    }
}
