//! Published outputs: atomic copies, left alone where they are already right.

use super::{PublishedFile, RESERVED};
use crate::build::Finished;
use crate::error::{Error, IoContext};
use crate::plan::Plan;
use crate::store::{Output, Rot, Tree};
use crate::{Class, Digest, Result, Store};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The folder of one build.
pub(super) struct BuildFolder<'a> {
    path: PathBuf,
    store: &'a Store,
}

/// The outputs to publish, by file name; two stages under one name are an error.
pub(super) fn wanted<'a>(plan: &Plan, finished: &'a [Finished]) -> Result<BTreeMap<&'a str, &'a Output>> {
    let mut wanted = BTreeMap::new();
    let mut makers: BTreeMap<&str, &str> = BTreeMap::new();
    for (stage, finished) in plan.stages.iter().zip(finished) {
        for port in stage.plugin.description.outputs.iter().filter(|port| port.publish.is_some()) {
            let output = &finished.action.outputs[&port.name];
            let name = output.name.as_str();
            let other = if RESERVED.contains(&name) { Some("fibar") } else { makers.insert(name, &stage.id) };
            if let Some(other) = other {
                let message = format!("`{}` and `{other}` both publish {name}", stage.id);
                return Err(Error::new(Class::Recipe, stage.use_node.error(message)));
            }
            wanted.insert(name, output);
        }
    }
    Ok(wanted)
}

impl<'a> BuildFolder<'a> {
    pub fn new(path: PathBuf, store: &'a Store) -> BuildFolder<'a> {
        BuildFolder { path, store }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Copies what is not there yet.
    pub fn publish(&self, wanted: &BTreeMap<&str, &Output>) -> std::result::Result<Vec<PublishedFile>, Rot> {
        let mut files = Vec::new();
        for (&name, &output) in wanted {
            if !self.has(name, output) {
                self.copy(name, output)?;
            }
            files.push(PublishedFile {
                name: name.into(),
                digest: output.digest,
                size: output.size,
                tree: output.tree,
            });
        }
        Ok(files)
    }

    fn has(&self, name: &str, output: &Output) -> bool {
        let path = self.path.join(name);
        let Ok(meta) = path.symlink_metadata() else { return false };
        if output.tree {
            let mut digest_of = |file: &Path| self.store.stats.digest_of(file).context("read", file);
            return meta.is_dir()
                && Tree::list(&path, &mut digest_of)
                    .is_ok_and(|tree| Digest::of(&tree.to_bytes()) == output.digest);
        }
        let size_fits = meta.is_file() && meta.len() == output.size;
        size_fits && self.store.stats.digest_of(&path).is_ok_and(|(digest, _)| digest == output.digest)
    }

    fn copy(&self, name: &str, output: &Output) -> std::result::Result<(), Rot> {
        let temporary = self.temporary();
        let copied = match output.tree {
            true => self.store.copy_tree(&output.digest, &temporary),
            false => self.store.copy_blob(&output.digest, &temporary),
        };
        let result = copied.and_then(|_| Ok(self.put_in_place(&temporary, name)?));
        if result.is_err() {
            let _ = std::fs::remove_file(&temporary);
            let _ = std::fs::remove_dir_all(&temporary);
        }
        result
    }

    /// Renames over what is there; a folder in the way is moved aside and removed first.
    fn put_in_place(&self, temporary: &Path, name: &str) -> Result<()> {
        let target = self.path.join(name);
        if target.is_dir() && !target.is_symlink() {
            let aside = self.temporary();
            std::fs::rename(&target, &aside).context("replace", &target)?;
            let _ = std::fs::remove_dir_all(aside);
        } else if temporary.is_dir() {
            let _ = std::fs::remove_file(&target);
        }
        std::fs::rename(temporary, &target).context("publish", &target)
    }

    fn temporary(&self) -> PathBuf {
        self.path.join(crate::store::unique_name(".fibar-tmp"))
    }

    /// Writes a file of our own, all or nothing; an unchanged one is left alone.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        let target = self.path.join(name);
        if std::fs::read(&target).is_ok_and(|old| old == bytes) {
            return Ok(());
        }
        self.write_unsynced(name, bytes)
    }

    /// Writes a file of our own, all or nothing.
    pub fn write_unsynced(&self, name: &str, bytes: &[u8]) -> Result<()> {
        let temporary = self.temporary();
        let result = std::fs::write(&temporary, bytes)
            .context("write", &temporary)
            .and_then(|()| self.put_in_place(&temporary, name));
        if result.is_err() {
            let _ = std::fs::remove_file(&temporary);
        }
        result
    }

    /// The text of a file of our own, empty when there is none.
    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path.join(name)).unwrap_or_default()
    }

    pub fn remove(&self, name: &str) {
        let _ = std::fs::remove_file(self.path.join(name));
    }

    /// Removes outputs of an earlier build that this one no longer has, unless somebody changed them since.
    pub fn remove_stale(&self, previous: &BTreeMap<String, Digest>, files: &[PublishedFile]) {
        for (name, digest) in previous.iter().filter(|(name, _)| !files.iter().any(|f| f.name == **name)) {
            let path = self.path.join(name);
            if path.is_dir() && !path.is_symlink() {
                let mut digest_of = |file: &Path| self.store.stats.digest_of(file).context("read", file);
                let same =
                    Tree::list(&path, &mut digest_of).is_ok_and(|t| Digest::of(&t.to_bytes()) == *digest);
                if same {
                    let _ = std::fs::remove_dir_all(&path);
                }
            } else if self.store.stats.digest_of(&path).is_ok_and(|(found, _)| found == *digest) {
                let _ = std::fs::remove_file(&path);
            }
        }
    }
}
