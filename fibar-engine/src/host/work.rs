//! The private folder of a run: inputs in, checked again afterwards; outputs out, checked before they count.
//!
//! `in/` holds verified read-only copies, `out/` starts empty, `tmp/` is the plugin's to litter, `request.json` repeats
//! the request for a run by hand. All paths a plugin sees are relative, so that none can end up in an artefact.

use crate::error::IoContext;
use crate::os::sandbox;
use crate::plan::{InputDigests, PlannedStage};
use crate::stamp::{Stamp, seal_copy};
use crate::store::{Output, Rot, Tree};
use crate::{Class, Digest, Error, Result, Store, os};
use fibar_core::diagnostic::Diagnostic;
use fibar_core::protocol::{Description, Done, InputArtefact, Request};
use std::collections::BTreeMap;
use std::fs::Metadata;
use std::path::{Path, PathBuf};

/// The outputs of a run by port, adopted by the store.
pub type Collected = BTreeMap<String, Output>;

/// The private folder of a run; removed when dropped unless kept.
pub struct WorkFolder<'a> {
    store: &'a Store,
    folder: PathBuf,
    inputs: Vec<Input>,
    files: Vec<NamedFile>,
    kept: bool,
}

/// The copy of a file that a parameter names.
struct NamedFile {
    /// Where the stage finds it, relative to the folder.
    path: String,
    /// What the recipe calls it.
    written: String,
}

struct Input {
    what: String,
    path: String,
    digest: Digest,
    /// Of the copy; none for a folder.
    stamp: Option<Stamp>,
}

impl<'a> WorkFolder<'a> {
    /// An empty one.
    pub fn new(store: &'a Store, stage: &str) -> Result<WorkFolder<'a>> {
        let folder = store.new_work_folder(stage)?;
        for name in ["in", "out", "tmp"] {
            std::fs::create_dir(folder.join(name)).context("make a work folder in", &folder)?;
        }
        Ok(WorkFolder { store, folder, inputs: Vec::new(), files: Vec::new(), kept: false })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.folder
    }

    /// Leaves the folder for people to look at.
    pub fn keep(&mut self) {
        self.kept = true;
    }

    /// A text of the stage's with the paths of copies replaced by what the recipe calls the files.
    pub fn as_written(&self, text: &str) -> String {
        let mut text = text.to_owned();
        // `in/.file-1` is the beginning of `in/.file-10`: the last first.
        for file in self.files.iter().rev() {
            for folder in [&*self.folder.to_string_lossy(), sandbox::WORK] {
                text = text.replace(&format!("{folder}/{}", file.path), &file.written);
            }
            text = text.replace(&file.path, &file.written);
        }
        text
    }

    /// Copies all inputs in and writes the request.
    pub fn prepare(
        &mut self,
        stage: &PlannedStage,
        digests: &InputDigests,
        is_tree: impl Fn(&Digest) -> bool,
        threads: u32,
        python: Option<&Path>,
    ) -> std::result::Result<Request, Rot> {
        let mut inputs: BTreeMap<String, Vec<InputArtefact>> = BTreeMap::new();
        for (port, digests) in digests {
            for (i, digest) in digests.iter().enumerate() {
                let path = if i == 0 { format!("in/{port}") } else { format!("in/{port}.{i}") };
                self.copy_in(port, &path, digest, is_tree(digest))?;
                inputs
                    .entry(port.clone())
                    .or_default()
                    .push(InputArtefact { path, digest: digest.to_string() });
            }
        }
        let request = Request {
            params: self.params_with_files(stage)?,
            inputs,
            out_dir: "out".into(),
            seed: stage.seed.unwrap_or(0),
            threads,
            memory_bytes: u64::from(stage.plugin.description.resources.memory_mb) << 20,
            python: python.map(|path| path.display().to_string()),
        };
        let path = self.folder.join("request.json");
        let text = serde_json::to_vec_pretty(&request).expect("a request is plain data");
        std::fs::write(&path, text).context("write", &path)?;
        Ok(request)
    }

    fn copy_in(
        &mut self,
        what: &str,
        path: &str,
        digest: &Digest,
        tree: bool,
    ) -> std::result::Result<(), Rot> {
        let target = self.folder.join(path);
        let stamp = if tree {
            self.store.copy_tree(digest, &target)?;
            None
        } else {
            self.store.copy_blob(digest, &target)?;
            Some(seal_copy(&target).context("protect", &target)?)
        };
        self.inputs.push(Input {
            what: format!("input `{what}`"),
            path: path.into(),
            digest: *digest,
            stamp,
        });
        Ok(())
    }

    fn params_with_files(&mut self, stage: &PlannedStage) -> Result<serde_json::Value> {
        let mut params = stage.params.clone();
        for (i, file) in stage.files.iter().enumerate() {
            let dot = if file.extension.is_empty() { "" } else { "." };
            let path = format!("in/.file-{i}{dot}{}", file.extension);
            let target = self.folder.join(&path);
            let copied = self.store.stats.copy_known(&file.path, &file.digest, &target);
            if !copied.context("copy", &file.path)? {
                let message = format!("{} changed while it was being built", file.path.display());
                return Err(Error::new(Class::Input, Diagnostic::error(message).hint("build again")));
            }
            let stamp = Some(seal_copy(&target).context("protect", &target)?);
            if let Some(slot) = params.pointer_mut(&file.pointer) {
                *slot = path.clone().into();
            }
            let written = stage.node.follow(&file.pointer).as_str();
            let written = written.map_or_else(|| file.path.display().to_string(), str::to_owned);
            self.files.push(NamedFile { path: path.clone(), written });
            let what = format!("the file of `{}`", file.pointer.trim_start_matches('/'));
            self.inputs.push(Input { what, path, digest: file.digest, stamp });
        }
        Ok(params)
    }

    /// Refuses a run that touched its inputs: those whose times have changed are hashed again.
    pub fn check_inputs(&self) -> Result<()> {
        for input in &self.inputs {
            let path = self.folder.join(&input.path);
            let found = match input.stamp {
                Some(stamp) if stamp.holds(&path) => Ok(input.digest),
                Some(_) => Digest::of_file(&path).map(|(digest, _)| digest).context("read", &path),
                None => Tree::list(&path, &mut |f| Digest::of_file(f).context("read", f))
                    .map(|tree| Digest::of(&tree.to_bytes())),
            };
            if found.ok() != Some(input.digest) || path.is_symlink() {
                return Err(fault(format!("it changed {}, which is read-only", input.what)));
            }
        }
        Ok(())
    }

    /// Hands the promised outputs to the store; anything missing, extra or odd is refused before any is published.
    pub fn collect(&self, description: &Description, done: &Done) -> Result<Collected> {
        check_names(description, done)?;
        let out = self.folder.join("out");
        self.check_nothing_else(&out, done)?;
        let mut trees = BTreeMap::new();
        for (port, name) in &done.outputs {
            let path = out.join(name);
            let meta = path.symlink_metadata();
            let meta = meta.map_err(|_| fault(format!("output `{port}` is missing: it wrote no {name}")))?;
            trees.insert(port, check_kind(&path, &meta, port)?);
        }
        let adopt = |(port, name): (&String, &String)| {
            let (path, tree) = (out.join(name), trees[port]);
            let (digest, size) =
                if tree { self.store.adopt_tree(&path) } else { self.store.adopt_blob(&path) }?;
            Ok((port.clone(), Output { name: name.clone(), digest, size, tree }))
        };
        done.outputs.iter().map(adopt).collect()
    }

    fn check_nothing_else(&self, out: &Path, done: &Done) -> Result<()> {
        for entry in std::fs::read_dir(out).context("list", out)? {
            let name = entry.context("list", out)?.file_name();
            if !done.outputs.values().any(|promised| *promised == name.to_string_lossy()) {
                return Err(fault(format!("it wrote {:?}, which is no output", name.to_string_lossy())));
            }
        }
        Ok(())
    }
}

impl Drop for WorkFolder<'_> {
    fn drop(&mut self) {
        if !self.kept {
            let _ = std::fs::remove_dir_all(&self.folder);
        }
    }
}

fn check_names(description: &Description, done: &Done) -> Result<()> {
    for port in &description.outputs {
        if !done.outputs.contains_key(&port.name) {
            return Err(fault(format!("output `{}` is missing", port.name)));
        }
    }
    let mut seen = BTreeMap::new();
    for (port, name) in &done.outputs {
        if !description.outputs.iter().any(|p| p.name == *port) {
            return Err(fault(format!("output `{port}` is not in its description")));
        }
        if name.is_empty() || name.starts_with('.') || name.contains(['/', '\\', ':', '\0']) {
            return Err(fault(format!("output `{port}` is called {name:?}, which is not a plain file name")));
        }
        if let Some(other) = seen.insert(name, port) {
            return Err(fault(format!("outputs `{other}` and `{port}` are the same file {name}")));
        }
    }
    Ok(())
}

/// Whether the output is a folder; links and odd files anywhere in it are refused.
fn check_kind(path: &Path, meta: &Metadata, port: &str) -> Result<bool> {
    let odd = |what: &str| Err(fault(format!("output `{port}` holds {what}: {}", path.display())));
    if meta.is_symlink() {
        return odd("a symbolic link");
    }
    if os::has_other_names(meta) {
        return odd("a file with other names");
    }
    if meta.is_dir() {
        for entry in std::fs::read_dir(path).context("list", path)? {
            let path = entry.context("list", path)?.path();
            check_kind(&path, &path.symlink_metadata().context("look at", &path)?, port)?;
        }
    } else if !meta.is_file() {
        return odd("something that is neither file nor folder");
    }
    Ok(meta.is_dir())
}

fn fault(message: String) -> Error {
    Error::new(Class::Plugin, Diagnostic::error(message))
}
