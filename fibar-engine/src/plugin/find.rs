//! Where plugins are looked for: given folders, beside `fibar`, `../libexec/fibar`. Never PATH.

use crate::os;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Folders in the order they are searched.
#[derive(Debug, Clone)]
pub struct PluginPath {
    folders: Vec<PathBuf>,
}

impl PluginPath {
    /// The given folders, then those that belong to the running executable.
    pub fn new(given: &[PathBuf]) -> PluginPath {
        let mut folders = given.to_vec();
        if let Some(own) = std::env::current_exe().ok().and_then(|exe| exe.parent().map(Path::to_owned)) {
            folders.push(own.join("../libexec/fibar"));
            folders.insert(given.len(), own);
        }
        PluginPath::only(folders)
    }

    /// Only the given folders.
    pub fn only(folders: Vec<PathBuf>) -> PluginPath {
        // Stages run in folders of their own, so a relative path would lead elsewhere there.
        let absolute = |folder: PathBuf| std::path::absolute(&folder).unwrap_or(folder);
        PluginPath { folders: folders.into_iter().map(absolute).collect() }
    }

    /// The folders, in order.
    pub fn folders(&self) -> &[PathBuf] {
        &self.folders
    }

    /// The executable of a plugin: `FOLDER/NAME`, or `FOLDER/NAME/NAME` for one that brings files of its own.
    pub fn find(&self, name: &str) -> Option<PathBuf> {
        let file = format!("{name}{}", std::env::consts::EXE_SUFFIX);
        let candidates = self.folders.iter().flat_map(|f| [f.join(&file), f.join(name).join(&file)]);
        candidates.into_iter().find(|path| path.metadata().is_ok_and(|meta| os::is_executable(&meta)))
    }

    /// Every executable with a plugin-like name (verb-noun) by name. Whether it speaks the protocol is not asked.
    pub fn list(&self) -> BTreeMap<String, PathBuf> {
        let mut found = BTreeMap::new();
        for folder in &self.folders {
            let Ok(entries) = std::fs::read_dir(folder) else { continue };
            for entry in entries.flatten() {
                let name = entry.file_name().to_string_lossy().into_owned();
                let name = name.strip_suffix(std::env::consts::EXE_SUFFIX).unwrap_or(&name);
                if name.contains('-') && !name.contains('.') && self.find(name).is_some() {
                    found.entry(name.to_owned()).or_insert_with(|| self.find(name).expect("just found"));
                }
            }
        }
        found
    }
}
