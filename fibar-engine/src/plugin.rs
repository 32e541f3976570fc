//! Plugins: where they are, what they say about themselves, which bytes they are.

mod environment;
mod find;
pub(crate) mod programs;

pub(crate) use environment::ensure as ensure_environment;
pub use environment::{Python, Ready as EnvironmentReady};
pub use find::PluginPath;

use crate::error::IoContext;
use crate::host::{self, Limits};
use crate::{Class, Digest, Error, Result, Store};
use fibar_core::diagnostic::Diagnostic;
use fibar_core::protocol::Description;
use std::path::{Component, Path, PathBuf};

/// A plugin that was found and described.
#[derive(Debug, Clone)]
pub struct Plugin {
    /// Its name.
    pub name: String,
    /// The executable.
    pub executable: PathBuf,
    /// Of the executable and the runtime files it declares; enters the key of every action.
    pub digest: Digest,
    /// What it says about itself.
    pub description: Description,
    /// The interpreter for its environment, if it names one.
    pub python: Option<Python>,
}

impl Plugin {
    /// Whether an executable can be loaded without starting it.
    pub(crate) fn is_described(name: &str, executable: &Path, store: &Store) -> bool {
        let own = store.stats.digest_of(executable);
        own.is_ok_and(|(own, _)| store.description_path(name, &own).exists())
    }

    /// Describes an executable, from the store when these very bytes were described before.
    pub fn load(name: &str, executable: &Path, store: &Store) -> Result<Plugin> {
        let (own, _) = store.stats.digest_of(executable).context("read the plugin", executable)?;
        let cache = store.description_path(name, &own);
        let known = std::fs::read(&cache).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
        let description: Description = match known {
            Some(description) => description,
            None => {
                let description = host::describe(executable, store, &Limits::default())?;
                check_description(name, &description)?;
                let bytes = serde_json::to_vec(&description).expect("a description is plain data");
                store.publish_bytes(&cache, &bytes)?;
                description
            }
        };
        let wanted = description.environment.as_ref();
        let python = wanted.map(|wanted| environment::find(wanted, store)).transpose()?;
        let digest = whole_digest(own, executable, &description, python.as_ref(), store)?;
        Ok(Plugin { name: name.into(), executable: executable.to_owned(), digest, description, python })
    }
}

/// The digest of everything a plugin consists of: executable, runtime files, interpreters. That of a plain executable is
/// its own.
fn whole_digest(
    own: Digest,
    executable: &Path,
    description: &Description,
    python: Option<&Python>,
    store: &Store,
) -> Result<Digest> {
    let folder = executable.parent().unwrap_or(Path::new("."));
    let mut listing = own.to_string();
    let lock = description.environment.as_ref().map(|environment| &environment.requirements);
    for file in description.runtime_files.iter().chain(lock) {
        let path = folder.join(file);
        let (digest, _) = store.stats.digest_of(&path).context("read the plugin's file", &path)?;
        listing.push_str(&format!("\n{digest} {file}"));
    }
    if let Some(python) = python {
        listing.push_str(&format!("\n{} python", python.digest));
    }
    if let Some(path) = programs::interpreter_of(executable) {
        let (digest, _) = store.stats.digest_of(&path).context("read the interpreter", &path)?;
        listing.push_str(&format!("\n{digest} interpreter"));
    }
    Ok(if listing.contains('\n') { Digest::of(listing.as_bytes()) } else { own })
}

/// What every description has to get right, whoever wrote the plugin.
pub(crate) fn check_description(name: &str, description: &Description) -> Result<()> {
    let mut faults = Vec::new();
    if description.name != name {
        faults.push(format!("it calls itself `{}`", description.name));
    }
    if !description.params.is_object() && !description.params.is_null() {
        faults.push("its parameters are not a JSON Schema object".into());
    }
    let reserved = |key: &&str| !description.params["properties"][*key].is_null();
    let reserved = crate::recipe::STAGE_KEYS.into_iter().filter(reserved);
    faults.extend(reserved.map(|key| format!("its parameter `{key}` is a word of the recipe")));
    for ports in [
        description.inputs.iter().map(|p| &p.name).collect::<Vec<_>>(),
        description.outputs.iter().map(|p| &p.name).collect::<Vec<_>>(),
    ] {
        let twice = ports.iter().enumerate().find(|(i, name)| ports[..*i].contains(name));
        faults.extend(twice.map(|(_, name)| format!("two of its ports are called `{name}`")));
        let odd = ports.iter().find(|name| name.is_empty() || name.contains(['/', '\\', '.', '\0']));
        faults.extend(odd.map(|name| format!("{name:?} is no name for a port")));
    }
    let files =
        description.runtime_files.iter().chain(description.environment.iter().map(|e| &e.requirements));
    let beside = |file: &&String| Path::new(file).components().all(|c| matches!(c, Component::Normal(_)));
    let odd = files.filter(|file| !beside(file));
    faults.extend(odd.map(|file| format!("its file {file:?} does not lie beside or below it")));
    if faults.is_empty() {
        return Ok(());
    }
    let message = format!("plugin `{name}` describes itself wrongly: {}", faults.join("; "));
    Err(Error::new(Class::Plugin, Diagnostic::error(message)))
}
