//! Blobs: in by rename, out by verified copy.

use super::Store;
use crate::error::{Error, IoContext};
use crate::stamp::Stamp;
use crate::{Class, Digest, Result, os};
use fibar_core::diagnostic::Diagnostic;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

/// Blobs that this process has hashed and put in place, as they were then: handed out again while they are warm, they need no second look.
#[derive(Debug, Default)]
pub(super) struct Fresh(Mutex<BTreeMap<Digest, Stamp>>);

impl Fresh {
    fn add(&self, digest: Digest, path: &Path) {
        if let Ok(stamp) = Stamp::of(path) {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(digest, stamp);
        }
    }

    fn stamp(&self, digest: &Digest) -> Option<Stamp> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(digest).copied()
    }
}

/// A blob that cannot be handed out: gone, or its bytes no longer match its name.
#[derive(Debug, Clone)]
pub enum Rot {
    /// The blob was damaged or missing, is in quarantine now, and can be rebuilt.
    Rebuild(Digest),
    /// The copy failed for another reason.
    Other(Error),
}

impl Store {
    /// Where a blob is or would be.
    pub fn blob_path(&self, digest: &Digest) -> PathBuf {
        self.root().join("cas").join(digest.to_string())
    }

    /// Whether a blob of this size is there; its bytes are checked when it is consumed.
    pub fn has_blob(&self, digest: &Digest, size: u64) -> bool {
        std::fs::metadata(self.blob_path(digest)).is_ok_and(|meta| meta.is_file() && meta.len() == size)
    }

    /// Takes over a file that nobody writes any more, on the same disk.
    pub fn adopt_blob(&self, file: &Path) -> Result<(Digest, u64)> {
        let (digest, size) = Digest::of_file(file).context("read", file)?;
        if self.has_blob(&digest, size) {
            self.touch_blob(&digest);
            return Ok((digest, size));
        }
        os::make_read_only(file).context("protect", file)?;
        let target = self.blob_path(&digest);
        std::fs::rename(file, &target).context("publish", &target)?;
        self.fresh.add(digest, &target);
        self.unsynced.add(&target);
        Ok((digest, size))
    }

    /// Stores bytes.
    pub fn put_blob(&self, bytes: &[u8]) -> Result<Digest> {
        let digest = Digest::of(bytes);
        if self.has_blob(&digest, bytes.len() as u64) {
            self.touch_blob(&digest);
        } else {
            self.publish_bytes(&self.blob_path(&digest), bytes)?;
        }
        Ok(digest)
    }

    /// Copies a blob to a new file, checking every byte on the way; those alone are taken as they are that this process put there
    /// and nobody changed since.
    pub fn copy_blob(&self, digest: &Digest, to: &Path) -> std::result::Result<u64, Rot> {
        let path = self.blob_path(digest);
        let mut from = match File::open(&path) {
            Ok(file) => file,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Err(Rot::Rebuild(*digest)),
            Err(e) => return Err(Rot::Other(Error::io("read", &path, &e))),
        };
        let copied =
            File::create_new(to).and_then(|mut file| self.copy_checked(digest, &mut from, &mut file));
        match copied {
            Ok((found, size)) if found == *digest => Ok(size),
            Ok(_) => {
                let _ = std::fs::remove_file(to);
                Err(self.quarantine(digest))
            }
            Err(e) => Err(Rot::Other(Error::io("copy an artefact to", to, &e))),
        }
    }

    fn copy_checked(
        &self,
        digest: &Digest,
        from: &mut File,
        to: &mut File,
    ) -> std::io::Result<(Digest, u64)> {
        match self.fresh.stamp(digest) {
            Some(stamp) if stamp.holds(&self.blob_path(digest)) => Ok((*digest, std::io::copy(from, to)?)),
            _ => Digest::of_copy(from, to),
        }
    }

    /// The bytes of a blob, checked.
    pub fn read_blob(&self, digest: &Digest) -> std::result::Result<Vec<u8>, Rot> {
        match std::fs::read(self.blob_path(digest)) {
            Ok(bytes) if Digest::of(&bytes) == *digest => Ok(bytes),
            Ok(_) => Err(self.quarantine(digest)),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Err(Rot::Rebuild(*digest)),
            Err(e) => Err(Rot::Other(Error::io("read", &self.blob_path(digest), &e))),
        }
    }

    /// Marks a blob as made now, so that it is not collected as somebody else's leftover.
    fn touch_blob(&self, digest: &Digest) {
        let _ = File::open(self.blob_path(digest)).and_then(|file| file.set_modified(SystemTime::now()));
    }

    /// Hashes a blob; its size.
    pub fn check_blob(&self, digest: &Digest) -> std::result::Result<u64, Rot> {
        match Digest::of_file(&self.blob_path(digest)) {
            Ok((found, size)) if found == *digest => Ok(size),
            Ok(_) => Err(self.quarantine(digest)),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Err(Rot::Rebuild(*digest)),
            Err(e) => Err(Rot::Other(Error::io("read", &self.blob_path(digest), &e))),
        }
    }

    /// Moves a damaged blob aside, so that its action becomes a miss.
    fn quarantine(&self, digest: &Digest) -> Rot {
        let from = self.blob_path(digest);
        let to = self.root().join("quarantine").join(super::unique_name(&digest.short()));
        match std::fs::rename(&from, &to) {
            Ok(()) => Rot::Rebuild(*digest),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Rot::Rebuild(*digest),
            Err(e) => Rot::Other(Error::io("quarantine", &from, &e)),
        }
    }
}

impl Rot {
    /// As an error, when rebuilding did not help.
    pub fn into_error(self) -> Error {
        match self {
            Rot::Other(error) => error,
            Rot::Rebuild(digest) => {
                let message =
                    format!("artefact {} is damaged again right after it was rebuilt", digest.short());
                Error::new(Class::Resource, Diagnostic::error(message).hint("check the disk of the store"))
            }
        }
    }
}

impl From<Error> for Rot {
    fn from(error: Error) -> Rot {
        Rot::Other(error)
    }
}
