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

    /// The manifest of a plugin that one of the folders, `target/release` of a checkout, does not hold compiled yet.
    pub fn source(&self, name: &str) -> Option<PathBuf> {
        let checkouts = self.folders.iter().filter_map(|folder| folder.ancestors().nth(2));
        checkouts.map(|root| root.join("plugins").join(name).join("Cargo.toml")).find(|path| path.is_file())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plugin_of_the_checkout_that_is_not_compiled_has_a_source() {
        let checkout = tempfile::tempdir().unwrap();
        let folder = checkout.path().join("plugins/source-mesh");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("Cargo.toml"), "").unwrap();
        let check = |folder: &str, name: &str, found: bool| {
            let plugins = PluginPath::only(vec![checkout.path().join(folder)]);
            assert_eq!(plugins.source(name).is_some(), found, "{folder} {name}");
        };
        check("target/release", "source-mesh", true);
        check("target/release", "source-mash", false);
        check("libexec/fibar/plugins", "source-mesh", false);
    }
}
