//! Keeping the store small: what is oldest goes first, what a build folder refers to stays, and a build that runs meanwhile
//! loses nothing.
//!
//! Age is when something was last used: a hit touches its action. Whatever was made or used since the oldest running build
//! began is left alone; a build that still finds something gone builds it again.

use super::{Action, Output, Store};
use crate::error::IoContext;
use crate::{Digest, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Half-made files of a process that is about to register its build are at most this old.
const GRACE: Duration = Duration::from_secs(10);

/// What collecting did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Collected {
    /// Finished actions that were forgotten.
    pub actions: usize,
    /// Blobs that were deleted.
    pub blobs: usize,
    /// Bytes they took.
    pub freed: u64,
    /// Leftovers of crashed runs, quarantined blobs and locks that were swept.
    pub swept: usize,
    /// Bytes of blobs that are left.
    pub left: u64,
    /// Bytes of those that build folders refer to.
    pub pinned: u64,
}

/// A build that runs; while it is held nothing it uses is collected.
#[derive(Debug)]
pub struct Registration {
    path: PathBuf,
    _lock: File,
}

impl Drop for Registration {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// A finished action as the collector sees it.
struct Entry {
    key: Digest,
    used: SystemTime,
    blobs: Vec<Digest>,
}

impl Store {
    /// Registers a running build.
    pub fn register(&self) -> Result<Registration> {
        let folder = self.root().join("builds");
        std::fs::create_dir_all(&folder).context("make the folder", &folder)?;
        let path = folder.join(super::unique_name("b"));
        let file = File::create(&path).context("write", &path)?;
        file.lock().context("lock", &path)?;
        Ok(Registration { path, _lock: file })
    }

    /// Pins what the lock file of a build folder names, as long as that file exists.
    pub fn pin(&self, lock: &Path) -> Result<()> {
        let lock = std::path::absolute(lock).context("find", lock)?;
        let folder = self.root().join("roots");
        let text = lock.to_string_lossy();
        let path = folder.join(Digest::of(text.as_bytes()).short());
        if path.exists() {
            return Ok(());
        }
        std::fs::create_dir_all(&folder).context("make the folder", &folder)?;
        self.publish_bytes(&path, text.as_bytes())
    }

    /// Marks an action as used now.
    pub(super) fn touch_action(&self, key: &Digest) {
        // Failing to costs it its place in the queue, nothing else.
        let _ = File::options()
            .append(true)
            .open(self.action_path(key))
            .and_then(|f| f.set_modified(SystemTime::now()));
    }

    /// Deletes what was used least recently until the blobs take at most `max_size` bytes.
    pub fn collect_garbage(&self, max_size: u64) -> Result<Collected> {
        let before = self.oldest_running_build()?.min(SystemTime::now() - GRACE);
        let swept = self.sweep(before)?;
        let mut heap = Heap::of(self, before)?;
        heap.drop_unused();
        heap.drop_oldest_until(max_size);
        let pinned = heap.pinned_bytes();
        self.stats.forget_missing();
        self.stats.save();
        Ok(Collected { swept, pinned, left: heap.size, ..heap.done })
    }

    /// When the oldest build that still runs began; now, if none does. Registrations of dead builds are removed.
    fn oldest_running_build(&self) -> Result<SystemTime> {
        let mut oldest = SystemTime::now();
        for path in files(&self.root().join("builds"))? {
            let Ok(file) = File::open(&path) else { continue };
            if file.try_lock().is_ok() {
                let _ = std::fs::remove_file(&path);
            } else if let Ok(began) = file.metadata().and_then(|meta| meta.modified()) {
                oldest = oldest.min(began);
            }
        }
        Ok(oldest)
    }

    /// Removes leftovers of crashed processes, quarantined blobs and locks nobody holds.
    fn sweep(&self, before: SystemTime) -> Result<usize> {
        let mut swept = 0;
        for folder in ["tmp", "work", "quarantine", "locks"] {
            for path in files(&self.root().join(folder))? {
                let old = path.symlink_metadata().and_then(|m| m.modified()).is_ok_and(|at| at < before);
                let held = folder == "locks" && File::open(&path).is_ok_and(|file| file.try_lock().is_err());
                if old && !held {
                    let gone = std::fs::remove_file(&path).or_else(|_| std::fs::remove_dir_all(&path));
                    swept += usize::from(gone.is_ok());
                }
            }
        }
        Ok(swept)
    }

    /// Size and last change of every blob.
    fn blob_sizes(&self) -> Result<BTreeMap<Digest, (u64, SystemTime)>> {
        let size = |path: PathBuf| {
            let digest = path.file_name()?.to_str()?.parse().ok()?;
            let meta = path.metadata().ok()?;
            Some((digest, (meta.len(), meta.modified().ok()?)))
        };
        Ok(files(&self.root().join("cas"))?.into_iter().filter_map(size).collect())
    }

    fn entries(&self) -> Result<Vec<Entry>> {
        let entry = |(key, action): (Digest, Action)| {
            let used = std::fs::metadata(self.action_path(&key)).and_then(|meta| meta.modified()).ok()?;
            let blobs: BTreeSet<Digest> = action.outputs.values().flat_map(|o| self.blobs_of(o)).collect();
            Some(Entry { key, used, blobs: blobs.into_iter().collect() })
        };
        Ok(self.all_actions()?.into_iter().filter_map(entry).collect())
    }

    /// Every action that can be read.
    pub fn all_actions(&self) -> Result<Vec<(Digest, Action)>> {
        let action = |path: PathBuf| {
            let key = path.file_name()?.to_str()?.parse().ok()?;
            Some((key, self.read_action(&key)?))
        };
        Ok(files(&self.root().join("actions"))?.into_iter().filter_map(action).collect())
    }

    /// The blobs behind an output: itself and, for a tree, the files it lists.
    fn blobs_of(&self, output: &Output) -> Vec<Digest> {
        let tree = output.tree.then(|| self.read_tree(&output.digest).ok()).flatten();
        let files = tree.into_iter().flat_map(|tree| tree.files.into_iter().map(|file| file.digest));
        std::iter::once(output.digest).chain(files).collect()
    }

    /// The keys in lock files of build folders that still exist.
    fn roots(&self) -> Result<BTreeSet<Digest>> {
        let mut keys = BTreeSet::new();
        for root in files(&self.root().join("roots"))? {
            let lock = std::fs::read_to_string(&root).unwrap_or_default();
            match std::fs::read_to_string(&lock) {
                Ok(text) => keys.extend(crate::ledger::keys_of(&text).into_values()),
                Err(_) => {
                    let _ = std::fs::remove_file(&root);
                }
            }
        }
        Ok(keys)
    }
}

/// All blobs and who uses them, while they become fewer.
struct Heap<'a> {
    store: &'a Store,
    /// Nothing used since is touched.
    before: SystemTime,
    /// Size and last change of every blob.
    blobs: BTreeMap<Digest, (u64, SystemTime)>,
    /// How many actions have each blob among their outputs.
    users: BTreeMap<Digest, usize>,
    /// Youngest first.
    entries: Vec<Entry>,
    roots: BTreeSet<Digest>,
    size: u64,
    done: Collected,
}

impl<'a> Heap<'a> {
    fn of(store: &'a Store, before: SystemTime) -> Result<Heap<'a>> {
        let blobs = store.blob_sizes()?;
        let mut entries = store.entries()?;
        entries.sort_by_key(|entry| std::cmp::Reverse(entry.used));
        let mut users: BTreeMap<Digest, usize> = BTreeMap::new();
        entries.iter().flat_map(|e| &e.blobs).for_each(|blob| *users.entry(*blob).or_default() += 1);
        let size = blobs.values().map(|(size, _)| size).sum();
        let roots = store.roots()?;
        Ok(Heap { store, before, blobs, users, entries, roots, size, done: Collected::default() })
    }

    /// Bytes of what build folders refer to.
    fn pinned_bytes(&self) -> u64 {
        let entries = self.entries.iter().filter(|entry| self.roots.contains(&entry.key));
        let pinned: BTreeSet<Digest> = entries.flat_map(|entry| entry.blobs.iter().copied()).collect();
        pinned.iter().filter_map(|blob| self.blobs.get(blob)).map(|(size, _)| size).sum()
    }

    /// Blobs that no action has: leftovers of crashes, or of actions that became unreadable.
    fn drop_unused(&mut self) {
        let unused: Vec<Digest> =
            self.blobs.keys().filter(|b| !self.users.contains_key(b)).copied().collect();
        unused.iter().for_each(|blob| self.drop_blob(blob));
    }

    fn drop_oldest_until(&mut self, max_size: u64) {
        let mut kept = Vec::new();
        while self.size > max_size
            && let Some(entry) = self.entries.pop()
        {
            if self.roots.contains(&entry.key) || entry.used >= self.before {
                kept.push(entry);
            } else {
                self.drop_action(&entry);
            }
        }
        self.entries.extend(kept);
    }

    /// The action first: a hit must never lack a blob that is still wanted.
    fn drop_action(&mut self, entry: &Entry) {
        let gone = std::fs::remove_file(self.store.action_path(&entry.key)).is_ok();
        self.done.actions += usize::from(gone);
        for blob in &entry.blobs {
            let left = self.users.get_mut(blob).expect("every blob of an action was counted");
            *left -= 1;
            if *left == 0 {
                self.drop_blob(blob);
            }
        }
    }

    fn drop_blob(&mut self, blob: &Digest) {
        let Some((bytes, _)) = self.blobs.get(blob).filter(|(_, used)| *used < self.before) else { return };
        if std::fs::remove_file(self.store.blob_path(blob)).is_ok() {
            self.size -= bytes;
            self.done.blobs += 1;
            self.done.freed += bytes;
        }
    }
}

/// The entries of a folder, sorted; none if there is no such folder.
pub(super) fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(e).context("list", folder),
    };
    let mut paths = entries
        .map(|entry| entry.map(|e| e.path()))
        .collect::<std::io::Result<Vec<_>>>()
        .context("list", folder)?;
    paths.sort();
    Ok(paths)
}
