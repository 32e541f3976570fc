//! The store: artefacts by content in `cas/`, finished actions by key in `actions/`, everything else by convention.
//!
//! | folder | holds |
//! | --- | --- |
//! | `cas/<sha256>` | a blob, read-only; a tree is a blob that lists its files |
//! | `actions/<key>` | what an action gave, with the manifest of its key, below a checksum |
//! | `locks/<key>` | one `flock` per action being executed |
//! | `descriptions/` | descriptions by plugin digest |
//! | `work/` | private folders of running stages, and of crashed ones |
//! | `quarantine/` | blobs whose bytes no longer match their name |
//! | `tmp/` | files on their way |
//! | `environments/` | Python environments of stages, by lock file and interpreter |
//! | `builds/` | a held `flock` per running build |
//! | `roots/` | which lock files of build folders pin their actions |
//! | `empty/` | nothing, ever: where sandboxes begin |
//!
//! Every file becomes visible by rename, complete; a build syncs all its files at its end, at once (see
//! `docs/decisions/sync-once.md`). No database, no daemon; deleting the store costs time only.

mod action;
mod audit;
mod blob;
mod gc;
mod lock;
mod stat_cache;
mod sync;
mod tree;

pub use action::{Action, Output};
pub use audit::{Audit, Stats};
pub use blob::Rot;
pub use gc::{Collected, Registration};
pub use lock::KeyLock;
pub use stat_cache::StatCache;
pub use tree::{Tree, TreeFile};

use crate::error::IoContext;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// The format of everything in the store.
const STORE_FORMAT: &str = "fibar.store/1\n";

/// A store in a folder.
#[derive(Debug)]
pub struct Store {
    root: PathBuf,
    environments: PathBuf,
    unsynced: sync::Unsynced,
    fresh: blob::Fresh,
    /// Digests of files already hashed.
    pub stats: StatCache,
}

impl Store {
    /// Opens the store in a folder, making what is missing.
    pub fn open(root: &Path) -> crate::Result<Store> {
        let root = std::path::absolute(root).context("find", root)?;
        for folder in ["cas", "actions", "locks", "descriptions", "work", "quarantine", "tmp"] {
            let folder = root.join(folder);
            std::fs::create_dir_all(&folder).context("make the folder", &folder)?;
        }
        let format = root.join("format");
        if std::fs::read_to_string(&format).ok().as_deref() != Some(STORE_FORMAT) {
            refuse_other_formats(&format)?;
        }
        let stats = StatCache::load(&root.join("stat-cache"));
        let environments = root.join("environments");
        let store = Store {
            stats,
            unsynced: sync::Unsynced::default(),
            fresh: blob::Fresh::default(),
            environments,
            root,
        };
        if !format.exists() {
            store.publish_bytes(&format, STORE_FORMAT.as_bytes())?;
        }
        Ok(store)
    }

    /// The folder of the store.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Opens another store that uses this one's Python environments, which are the same for all and slow to make.
    pub fn open_beside(&self, root: &Path) -> crate::Result<Store> {
        Ok(Store { environments: self.environments.clone(), ..Store::open(root)? })
    }

    /// Where the Python environment of this name is or would be.
    pub fn environment_path(&self, name: &crate::Digest) -> PathBuf {
        self.environments.join(name.to_string())
    }

    /// Where the store is when nobody says: `$FIBAR_STORE`, else the user's cache folder.
    pub fn default_root() -> PathBuf {
        let from = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
        from("FIBAR_STORE").unwrap_or_else(|| {
            let cache = from("XDG_CACHE_HOME")
                .or_else(|| from("LOCALAPPDATA"))
                .or_else(|| from("HOME").map(|home| home.join(".cache")));
            cache.unwrap_or_else(std::env::temp_dir).join("fibar")
        })
    }

    /// A fresh name in `tmp/`.
    fn temporary(&self) -> PathBuf {
        self.root.join("tmp").join(unique_name("t"))
    }

    /// A fresh private folder for a run.
    pub fn new_work_folder(&self, label: &str) -> crate::Result<PathBuf> {
        let folder = self.root.join("work").join(unique_name(label));
        std::fs::create_dir_all(&folder).context("make the folder", &folder)?;
        Ok(folder)
    }

    /// An empty folder that nothing is ever put into.
    pub fn scratch(&self) -> crate::Result<PathBuf> {
        let folder = self.root.join("empty");
        std::fs::create_dir_all(&folder).context("make the folder", &folder)?;
        Ok(folder)
    }

    /// Where the description of a plugin with this digest is kept.
    pub fn description_path(&self, name: &str, digest: &crate::Digest) -> PathBuf {
        self.root.join("descriptions").join(format!("{name}-{digest}.json"))
    }

    /// Makes bytes visible under a path inside the store, all or nothing.
    pub fn publish_bytes(&self, path: &Path, bytes: &[u8]) -> crate::Result<()> {
        let temporary = self.temporary();
        let write = || {
            let mut file = std::fs::File::create(&temporary)?;
            file.write_all(bytes)?;
            std::fs::rename(&temporary, path)
        };
        let result = write().context("write", path);
        if result.is_err() {
            let _ = std::fs::remove_file(&temporary);
        }
        self.unsynced.add(path);
        result
    }
}

fn refuse_other_formats(format: &Path) -> crate::Result<()> {
    match std::fs::read_to_string(format) {
        Ok(other) if other != STORE_FORMAT => {
            let finding = fibar_core::diagnostic::Diagnostic::error(format!(
                "{} says {:?}, this fibar uses {:?}",
                format.display(),
                other.trim(),
                STORE_FORMAT.trim()
            ));
            let finding = finding.hint("delete the store, or name another folder with FIBAR_STORE");
            Err(crate::Error::new(crate::Class::Resource, finding))
        }
        _ => Ok(()),
    }
}

/// A file name nobody else uses: label, process, time of start, count.
pub(crate) fn unique_name(label: &str) -> String {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let nanos =
        std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0, |d| d.as_nanos());
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    format!("{label}-{}-{:x}-{count}", std::process::id(), nanos & 0xffff_ffff_ffff)
}
