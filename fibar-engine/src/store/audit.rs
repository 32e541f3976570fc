//! Looking the whole store over: does every blob still match its name, and how much is there?

use super::{Rot, Store, gc};
use crate::{Digest, Result};

/// What an audit found.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Audit {
    /// Blobs that were hashed.
    pub blobs: usize,
    /// Bytes they take.
    pub bytes: u64,
    /// Blobs whose bytes no longer match their name; they are in quarantine now and will be built again.
    pub damaged: Vec<Digest>,
    /// Actions that can be read.
    pub actions: usize,
    /// Action files that cannot be read; they are misses.
    pub unreadable: usize,
    /// Actions that lack an output; they are misses.
    pub incomplete: usize,
}

/// How much there is.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Stats {
    /// Blobs.
    pub blobs: usize,
    /// Bytes they take.
    pub bytes: u64,
    /// Finished actions.
    pub actions: usize,
    /// Time their making took, s: what the store saves.
    pub seconds: f64,
    /// Quarantined blobs.
    pub quarantined: usize,
    /// Folders of runs, kept for people or left by crashes.
    pub work: usize,
}

impl Store {
    /// Hashes every blob and reads every action.
    pub fn audit(&self) -> Result<Audit> {
        let mut audit = Audit::default();
        for path in gc::files(&self.root().join("cas"))? {
            let Some(digest) = path.file_name().and_then(|n| n.to_str()).and_then(|n| n.parse().ok()) else {
                continue;
            };
            match self.check_blob(&digest) {
                Ok(size) => {
                    audit.blobs += 1;
                    audit.bytes += size;
                }
                Err(Rot::Rebuild(_)) => audit.damaged.push(digest),
                Err(Rot::Other(error)) => return Err(error),
            }
        }
        let actions = self.all_actions()?;
        audit.unreadable = gc::files(&self.root().join("actions"))?.len() - actions.len();
        audit.actions = actions.len();
        let complete = |action: &super::Action| action.outputs.values().all(|output| self.has_output(output));
        audit.incomplete = actions.iter().filter(|(_, action)| !complete(action)).count();
        Ok(audit)
    }

    /// Counts without hashing.
    pub fn statistics(&self) -> Result<Stats> {
        let folder = |name: &str| gc::files(&self.root().join(name));
        let blobs = folder("cas")?;
        let actions = self.all_actions()?;
        Ok(Stats {
            bytes: blobs.iter().filter_map(|path| path.metadata().ok()).map(|meta| meta.len()).sum(),
            blobs: blobs.len(),
            seconds: actions.iter().map(|(_, action)| action.seconds).sum(),
            actions: actions.len(),
            quarantined: folder("quarantine")?.len(),
            work: folder("work")?.len(),
        })
    }
}
