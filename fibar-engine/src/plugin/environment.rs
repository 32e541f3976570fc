//! Python environments: one folder per lock file and interpreter, made once, outside the sandbox, shared by all builds.

use super::{Plugin, programs};
use crate::error::IoContext;
use crate::{Class, Digest, Error, Result, Store};
use fibar_core::diagnostic::Diagnostic;
use fibar_core::protocol::Environment;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// An interpreter that fits an environment.
#[derive(Debug, Clone)]
pub struct Python {
    /// The interpreter, links followed.
    pub executable: PathBuf,
    /// Of the interpreter.
    pub digest: Digest,
    facts: Facts,
}

/// What an interpreter says of itself; kept in the store so that planning starts no process.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Facts {
    version: [u32; 2],
    prefix: PathBuf,
}

/// Names the environment in the store.
fn key(lock: &Digest, python: &Python) -> Digest {
    Digest::of(format!("{lock} {} {}", python.digest, python.facts.prefix.display()).as_bytes())
}

/// The interpreter for an environment: `$FIBAR_PYTHON`, else the first that fits.
pub(super) fn find(wanted: &Environment, store: &Store) -> Result<Python> {
    let given = std::env::var_os("FIBAR_PYTHON").map(PathBuf::from);
    let names = (wanted.oldest[1]..=wanted.newest[1]).rev().map(|minor| format!("python3.{minor}"));
    let names = std::iter::once("python3".to_owned()).chain(names);
    let candidates = given.into_iter().chain(names.filter_map(|name| programs::find(&name)));
    let fits = |python: &Python| (wanted.oldest..=wanted.newest).contains(&python.facts.version);
    candidates.filter_map(|path| ask(&path, store).ok()).find(fits).ok_or_else(|| {
        let ([a, b], [c, d]) = (wanted.oldest, wanted.newest);
        let finding = Diagnostic::error(format!("a stage needs Python {a}.{b} to {c}.{d}; there is none"));
        Error::new(Class::Resource, finding.hint("install one, or name it in FIBAR_PYTHON"))
    })
}

fn ask(path: &Path, store: &Store) -> Result<Python> {
    let (digest, _) = store.stats.digest_of(path).context("read", path)?;
    let known =
        store.description_path("python", &Digest::of(format!("{digest} {}", path.display()).as_bytes()));
    let cached = std::fs::read(&known).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    let facts = match cached {
        Some(facts) => facts,
        None => {
            let script = "import sys; print(*sys.version_info[:2], sys.base_prefix)";
            let text = run(Command::new(path).args(["-I", "-c", script]))?;
            let mut words = text.trim().splitn(3, ' ');
            let mut number = || words.next().and_then(|w| w.parse().ok()).unwrap_or(0);
            let facts = Facts { version: [number(), number()], prefix: words.next().unwrap_or("").into() };
            store.publish_bytes(&known, &serde_json::to_vec(&facts).expect("plain data"))?;
            facts
        }
    };
    Ok(Python { executable: path.to_owned(), digest, facts })
}

/// What a run with an environment needs.
#[derive(Debug)]
pub struct Ready {
    /// The interpreter of the environment.
    pub python: PathBuf,
    /// Folders the stage has to see for it.
    pub readable: Vec<PathBuf>,
}

/// The environment of a plugin, made if it is not there yet; `note` is told when that takes a while.
pub(crate) fn ensure(plugin: &Plugin, store: &Store, note: &dyn Fn(&str)) -> Result<Option<Ready>> {
    let (Some(wanted), Some(python)) = (&plugin.description.environment, &plugin.python) else {
        return Ok(None);
    };
    let lock = plugin.executable.with_file_name(&wanted.requirements);
    let (lock_digest, _) = store.stats.digest_of(&lock).context("read", &lock)?;
    let key = key(&lock_digest, python);
    let folder = store.environment_path(&key);
    let bin = if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" };
    if !folder.exists() {
        let _alone = loop {
            if let Some(lock) = store.try_lock(&key)? {
                break lock;
            }
            std::thread::sleep(Duration::from_millis(100));
        };
        if !folder.exists() {
            note(&format!("setting up the Python environment of {} (once)", plugin.name));
            make(&folder, &lock, python, bin)?;
        }
    }
    let prefix =
        Some(python.facts.prefix.clone()).filter(|p| programs::folder_of(&p.join("python")).is_some());
    let readable = std::iter::once(folder.clone()).chain(prefix).collect();
    Ok(Some(Ready { python: folder.join(bin), readable }))
}

fn make(folder: &Path, lock: &Path, python: &Python, bin: &str) -> Result<()> {
    let work = folder.with_file_name(crate::store::unique_name("env"));
    std::fs::create_dir_all(&work).context("make the folder", &work)?;
    let install =
        ["-I", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--require-hashes"];
    let result = run(Command::new(&python.executable).args(["-I", "-m", "venv"]).arg(&work))
        .and_then(|_| {
            let mut pip = Command::new(work.join(bin));
            run(pip.args(install).args(["--no-deps", "--only-binary", ":all:", "--requirement"]).arg(lock))
        })
        .and_then(|_| std::fs::rename(&work, folder).context("publish", folder));
    if result.is_err() {
        let _ = std::fs::remove_dir_all(&work);
    }
    result
}

fn run(command: &mut Command) -> Result<String> {
    let name = command.get_program().display().to_string();
    let fault = |message: String| Error::new(Class::Resource, Diagnostic::error(message));
    let output = command.output().map_err(|e| fault(format!("cannot run {name}: {e}")))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let last: Vec<&str> = said.lines().filter(|l| !l.trim().is_empty()).collect();
    let last = last[last.len().saturating_sub(6)..].join("\n");
    Err(fault(format!("{name} failed ({}): {last}", output.status)))
}
