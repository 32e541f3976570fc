//! Trees: a folder as a blob that lists its files, sorted by path.

use super::{Rot, Store};
use crate::error::{Error, IoContext};
use crate::{Class, Digest, Result};
use fibar_core::diagnostic::Diagnostic;
use serde::{Deserialize, Serialize};
use std::path::Path;

const TREE_FORMAT: &str = "fibar.tree/1";

/// The listing of a folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tree {
    format: String,
    /// Sorted by path.
    pub files: Vec<TreeFile>,
}

/// A file of a tree.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TreeFile {
    /// Relative, with `/`.
    pub path: String,
    /// Of its bytes.
    pub digest: Digest,
    /// In bytes.
    pub size: u64,
}

impl Tree {
    /// The bytes that name the tree.
    pub fn to_bytes(&self) -> Vec<u8> {
        serde_json::to_vec(self).expect("a listing is plain data")
    }

    /// Lists a folder, giving every file to `digest_of`; anything but plain files and folders is refused.
    pub fn list(folder: &Path, digest_of: &mut dyn FnMut(&Path) -> Result<(Digest, u64)>) -> Result<Tree> {
        let mut files = Vec::new();
        list_into(folder, "", digest_of, &mut files)?;
        files.sort_by(|a: &TreeFile, b| a.path.cmp(&b.path));
        Ok(Tree { format: TREE_FORMAT.into(), files })
    }

    /// Bytes of all files together.
    pub fn size(&self) -> u64 {
        self.files.iter().map(|f| f.size).sum()
    }
}

fn list_into(
    folder: &Path,
    prefix: &str,
    digest_of: &mut dyn FnMut(&Path) -> Result<(Digest, u64)>,
    files: &mut Vec<TreeFile>,
) -> Result<()> {
    for entry in std::fs::read_dir(folder).context("list", folder)? {
        let entry = entry.context("list", folder)?;
        let (path, kind) = (entry.path(), entry.file_type().context("look at", folder)?);
        let Ok(name) = entry.file_name().into_string() else {
            return Err(refuse(&path, "its name is not Unicode"));
        };
        let relative = format!("{prefix}{name}");
        if kind.is_dir() {
            list_into(&path, &format!("{relative}/"), digest_of, files)?;
        } else if kind.is_file() {
            let (digest, size) = digest_of(&path)?;
            files.push(TreeFile { path: relative, digest, size });
        } else {
            return Err(refuse(&path, "it is neither file nor folder"));
        }
    }
    Ok(())
}

fn refuse(path: &Path, reason: &str) -> Error {
    Error::new(Class::Plugin, Diagnostic::error(format!("{} cannot be in a tree: {reason}", path.display())))
}

impl Store {
    /// Takes over a folder that nobody writes any more: its files, then its listing.
    pub fn adopt_tree(&self, folder: &Path) -> Result<(Digest, u64)> {
        let tree = Tree::list(folder, &mut |file| self.adopt_blob(file))?;
        Ok((self.put_blob(&tree.to_bytes())?, tree.size()))
    }

    /// The listing of a tree.
    pub fn read_tree(&self, digest: &Digest) -> std::result::Result<Tree, Rot> {
        let bytes = self.read_blob(digest)?;
        serde_json::from_slice(&bytes).map_err(|e| {
            let message = format!("artefact {} is not the listing of a tree: {e}", digest.short());
            Rot::Other(Error::new(Class::Input, Diagnostic::error(message)))
        })
    }

    /// Whether the listing and all files of a tree are there.
    pub fn has_tree(&self, digest: &Digest) -> bool {
        self.read_tree(digest).is_ok_and(|tree| tree.files.iter().all(|f| self.has_blob(&f.digest, f.size)))
    }

    /// Copies a tree to a new folder, checking every byte on the way.
    pub fn copy_tree(&self, digest: &Digest, to: &Path) -> std::result::Result<u64, Rot> {
        let tree = self.read_tree(digest)?;
        std::fs::create_dir_all(to).context("make the folder", to)?;
        for file in &tree.files {
            let target = to.join(&file.path);
            if let Some(folder) = target.parent() {
                std::fs::create_dir_all(folder).context("make the folder", folder)?;
            }
            self.copy_blob(&file.digest, &target)?;
        }
        Ok(tree.size())
    }
}
