//! Digests of files that did not change since they were hashed, by size, inode, modification and change time.
//!
//! Only a cache: entries prove themselves against the file, and losing it costs hashing.

use crate::{Digest, os};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

/// A file changed more recently than this may change again without its times showing it.
const RACY_NANOS: i64 = 50_000_000;

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

/// Size and identity of a file.
type Stamp = (u64, [i64; 4]);

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
        let stamp = stamp(&path)?;
        if let Some(digest) = self.known(&path, &stamp) {
            return Ok((digest, stamp.0));
        }
        let (digest, size) = Digest::of_file(&path)?;
        if self::stamp(&path)? == stamp {
            self.learn(path, stamp, digest);
        }
        Ok((digest, size))
    }

    fn known(&self, path: &Path, stamp: &Stamp) -> Option<Digest> {
        let entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        entries.by_path.get(path).filter(|(known, _)| known == stamp).map(|(_, digest)| *digest)
    }

    fn learn(&self, path: PathBuf, stamp: Stamp, digest: Digest) {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_nanos() as i64);
        let [_, _, modified, changed] = stamp.1;
        if now - modified.max(changed) > RACY_NANOS && !path.to_string_lossy().contains('\n') {
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
        for (path, ((size, [device, inode, modified, changed]), digest)) in &entries.by_path {
            let path = path.to_string_lossy();
            let _ = writeln!(text, "{digest} {size} {device} {inode} {modified} {changed} {path}");
        }
        let temporary = self.path.with_file_name(super::unique_name("stat-cache"));
        if std::fs::write(&temporary, text).and_then(|()| std::fs::rename(&temporary, &self.path)).is_err() {
            let _ = std::fs::remove_file(&temporary);
        }
    }
}

fn stamp(path: &Path) -> std::io::Result<Stamp> {
    let meta = std::fs::metadata(path)?;
    if meta.is_dir() {
        return Err(std::io::Error::from(std::io::ErrorKind::IsADirectory));
    }
    Ok((meta.len(), os::file_identity(&meta)))
}

fn parse_line(line: &str) -> Option<(PathBuf, (Stamp, Digest))> {
    let mut parts = line.splitn(7, ' ');
    let digest = parts.next()?.parse().ok()?;
    let size = parts.next()?.parse().ok()?;
    let mut number = || parts.next()?.parse::<i64>().ok();
    let identity = [number()?, number()?, number()?, number()?];
    Some((PathBuf::from(parts.next()?), ((size, identity), digest)))
}
