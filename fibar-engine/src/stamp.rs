//! What tells a changed file from an unchanged one without reading it: size, inode, modification and change time.
//!
//! Times are coarse on some disks: a change in the very instant of the stamp can escape it. So a stamp saves hashing only where
//! the bytes are hashed once more before anything depends on them for good, or where it is old (see [`crate::store::StatCache`]).

use crate::os;
use std::fs::File;
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// A file changed more recently than this may change again without its times showing it.
const RACY_NANOS: i64 = 50_000_000;
/// The date of every copy that a stage gets, 1 January 1980: as good as any other, and whoever writes the file changes it.
const DATE_OF_COPIES: Duration = Duration::from_secs(315_532_800);

/// Size and identity of a file as they were once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stamp {
    /// In bytes.
    pub size: u64,
    /// See [`os::file_identity`].
    pub identity: [i64; 4],
}

impl Stamp {
    /// Of a file as it is now; a folder is an error.
    pub fn of(path: &Path) -> std::io::Result<Stamp> {
        let meta = std::fs::metadata(path)?;
        if meta.is_dir() {
            return Err(std::io::Error::from(std::io::ErrorKind::IsADirectory));
        }
        Ok(Stamp { size: meta.len(), identity: os::file_identity(&meta) })
    }

    /// Whether the file has still this stamp. Never true where the system keeps no time of change, which nobody can set back.
    pub fn holds(&self, path: &Path) -> bool {
        os::KEEPS_CHANGE_TIMES && Stamp::of(path).is_ok_and(|now| now == *self)
    }

    /// Whether it is so old that any later change shows.
    pub fn is_settled(&self) -> bool {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_nanos() as i64);
        let [_, _, modified, changed] = self.identity;
        now - modified.max(changed) > RACY_NANOS
    }
}

/// Protects a copy that a stage is to read, and gives it the date of all copies.
pub fn seal_copy(path: &Path) -> std::io::Result<Stamp> {
    File::options().append(true).open(path)?.set_modified(UNIX_EPOCH + DATE_OF_COPIES)?;
    os::make_read_only(path)?;
    Stamp::of(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_writes_breaks_the_seal() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("copy");
        let check = |spoil: &dyn Fn(&mut File), holds: bool| {
            let _ = std::fs::remove_file(&path);
            std::fs::write(&path, "some bytes").unwrap();
            let mut file = File::options().write(true).open(&path).unwrap();
            let stamp = seal_copy(&path).unwrap();
            spoil(&mut file);
            assert_eq!(stamp.holds(&path), holds && os::KEEPS_CHANGE_TIMES);
        };
        check(&|_| {}, true);
        check(&|file| std::io::Write::write_all(file, b"other").unwrap(), false);
        check(&|file| file.set_len(3).unwrap(), false);
        check(&|_| std::fs::remove_file(&path).unwrap(), false);
    }
}
