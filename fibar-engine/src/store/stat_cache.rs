//! Digests of files that did not change since they were hashed, by size, inode, modification and change time.
//!
//! Only a cache: entries prove themselves against the file, and losing it costs hashing.

use crate::Digest;
use crate::stamp::Stamp;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The cache, loaded at the start and written back when something was learned.
#[derive(Debug)]
pub struct StatCache {
    path: PathBuf,
    entries: Mutex<Entries>,
}

#[derive(Debug, Default)]
struct Entries {
    by_path: BTreeMap<PathBuf, (Stamp, Digest)>,
    learned: bool,
}

impl StatCache {
    /// Reads the cache; anything odd in it is forgotten.
    pub fn load(path: &Path) -> StatCache {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        let by_path = text.lines().filter_map(parse_line).collect();
        StatCache { path: path.to_owned(), entries: Mutex::new(Entries { by_path, learned: false }) }
    }

    /// The digest and size of a file, hashed only if it is new or changed.
    pub fn digest_of(&self, path: &Path) -> std::io::Result<(Digest, u64)> {
        let path = std::path::absolute(path)?;
        let stamp = Stamp::of(&path)?;
        if let Some(digest) = self.known(&path, &stamp) {
            return Ok((digest, stamp.size));
        }
        let (digest, size) = Digest::of_file(&path)?;
        if Stamp::of(&path)? == stamp {
            self.learn(path, stamp, digest);
        }
        Ok((digest, size))
    }

    /// Copies a file to a new one; whether it held the bytes of this digest. They are hashed unless they were before and the file
    /// did not change since.
    pub fn copy_known(&self, path: &Path, digest: &Digest, to: &Path) -> std::io::Result<bool> {
        let path = std::path::absolute(path)?;
        let stamp = Stamp::of(&path)?;
        let (mut from, mut to) = (File::open(&path)?, File::create_new(to)?);
        if self.known(&path, &stamp) == Some(*digest) {
            std::io::copy(&mut from, &mut to)?;
            return Ok(stamp.holds(&path));
        }
        Ok(Digest::of_copy(&mut from, &mut to)?.0 == *digest)
    }

    fn known(&self, path: &Path, stamp: &Stamp) -> Option<Digest> {
        let entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        entries.by_path.get(path).filter(|(known, _)| known == stamp).map(|(_, digest)| *digest)
    }

    fn learn(&self, path: PathBuf, stamp: Stamp, digest: Digest) {
        if stamp.is_settled() && !path.to_string_lossy().contains('\n') {
            let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
            entries.by_path.insert(path, (stamp, digest));
            entries.learned = true;
        }
    }

    /// Forgets files that are gone.
    pub fn forget_missing(&self) {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let before = entries.by_path.len();
        entries.by_path.retain(|path, _| path.exists());
        entries.learned |= entries.by_path.len() < before;
    }

    /// Writes the cache back if it learned something. Failing to is no error.
    pub fn save(&self) {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        if !std::mem::take(&mut entries.learned) {
            return;
        }
        let mut text = String::new();
        for (path, (stamp, digest)) in &entries.by_path {
            let Stamp { size, identity: [device, inode, modified, changed] } = stamp;
            let path = path.to_string_lossy();
            let _ = writeln!(text, "{digest} {size} {device} {inode} {modified} {changed} {path}");
        }
        let temporary = self.path.with_file_name(super::unique_name("stat-cache"));
        if std::fs::write(&temporary, text).and_then(|()| std::fs::rename(&temporary, &self.path)).is_err() {
            let _ = std::fs::remove_file(&temporary);
        }
    }
}

fn parse_line(line: &str) -> Option<(PathBuf, (Stamp, Digest))> {
    let mut parts = line.splitn(7, ' ');
    let digest = parts.next()?.parse().ok()?;
    let size = parts.next()?.parse().ok()?;
    let mut number = || parts.next()?.parse::<i64>().ok();
    let identity = [number()?, number()?, number()?, number()?];
    Some((PathBuf::from(parts.next()?), (Stamp { size, identity }, digest)))
}
