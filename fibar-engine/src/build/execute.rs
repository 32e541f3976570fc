//! Executing one action: lock, look again, run in a private folder, check, publish.

use super::observer::{Event, Outcome, StageName};
use super::{BuildOptions, budget::Grant};
use crate::host::{End, Launch, Report, RunSetup, WorkFolder, run};
use crate::plan::{Manifest, PlannedStage};
use crate::plugin::ensure_environment;
use crate::store::{Action, KeyLock, Rot};
use crate::{Class, Digest, Error, Store};
use fibar_core::diagnostic::Diagnostic;
use fibar_core::protocol::{Failure, FailureKind, LogLine, PluginMessage};
use std::path::Path;
use std::time::{Duration, Instant};

/// How often the lock of another process is tried.
const LOCK_PAUSE: Duration = Duration::from_millis(10);

/// An action that is to be executed.
pub(super) struct Execution<'a> {
    pub options: &'a BuildOptions<'a>,
    pub name: StageName<'a>,
    pub stage: &'a PlannedStage,
    pub manifest: Manifest,
    pub key: Digest,
    /// Inputs that are folders.
    pub trees: Vec<Digest>,
    pub grant: Grant,
}

impl Execution<'_> {
    /// Runs the action, unless another process was faster.
    pub fn execute(&self) -> Result<(Action, Outcome), Rot> {
        let _lock = self.lock()?;
        let store = self.options.store;
        if let Some(action) = look_up(store, self.stage, &self.key) {
            return Ok((action, Outcome::Shared));
        }
        let started = Instant::now();
        let mut folder = WorkFolder::new(store, &self.stage.id)?;
        let is_tree = |digest: &Digest| self.trees.contains(digest);
        let environment = self.environment()?;
        let python = environment.as_ref().map(|ready| ready.python.as_path());
        let threads = self.options.threads.unwrap_or(self.grant.cores);
        let request = folder.prepare(self.stage, &self.manifest.inputs, is_tree, threads, python)?;
        let report = run(&RunSetup {
            launch: Launch {
                executable: &self.stage.plugin.executable,
                description: Some(&self.stage.plugin.description),
                folder: folder.path(),
                scratch: &store.scratch()?,
                readable: environment.as_ref().map_or(&[], |ready| &ready.readable),
                threads,
                sandbox: self.options.sandbox,
            },
            request: &request,
            limits: self.options.limits,
            is_cancelled: self.options.is_cancelled,
            listener: &|message: &PluginMessage| self.pass_on(message, &folder),
        });
        let action = self.publish(&mut folder, report, started)?;
        Ok((action, Outcome::Executed))
    }

    /// Tells what the stage says, in the words of the recipe.
    fn pass_on(&self, message: &PluginMessage, folder: &WorkFolder<'_>) {
        let event = |message: &PluginMessage| {
            self.options.observer.event(&Event::Said { stage: self.name, message });
        };
        match message {
            PluginMessage::Log(LogLine { level, message }) => {
                let (level, message) = (level.clone(), folder.as_written(message));
                event(&PluginMessage::Log(LogLine { level, message }));
            }
            other => event(other),
        }
    }

    fn environment(&self) -> crate::Result<Option<crate::plugin::EnvironmentReady>> {
        let note = |text: &str| self.options.observer.event(&Event::Note { text });
        ensure_environment(&self.stage.plugin, self.options.store, &note)
    }

    fn lock(&self) -> crate::Result<KeyLock> {
        loop {
            if let Some(lock) = self.options.store.try_lock(&self.key)? {
                return Ok(lock);
            }
            if (self.options.is_cancelled)() {
                return Err(cancelled());
            }
            std::thread::sleep(LOCK_PAUSE);
        }
    }

    fn publish(
        &self,
        folder: &mut WorkFolder<'_>,
        report: Report,
        started: Instant,
    ) -> crate::Result<Action> {
        let done = match &report.end {
            End::Done(done) => done,
            End::Failed(failure) => return Err(self.failed(failure, folder)),
            End::Cancelled => return Err(cancelled()),
            End::Broken(reason) => {
                folder.keep();
                return Err(self.broken(reason, &report, folder));
            }
        };
        let collected =
            folder.check_inputs().and_then(|()| folder.collect(&self.stage.plugin.description, done));
        let outputs = collected.map_err(|error| self.blame(error))?;
        let mut action = Action::new(self.manifest.clone(), outputs, started.elapsed().as_secs_f64());
        action.metrics = report.metrics;
        action.violations = report.violations;
        self.options.store.publish_action(&self.key, &action)?;
        Ok(action)
    }

    /// A failure that the stage explains, at the line of the recipe it blames.
    fn failed(&self, failure: &Failure, folder: &WorkFolder<'_>) -> Error {
        let class = match failure.kind {
            FailureKind::User => Class::Recipe,
            FailureKind::Input => Class::Input,
            FailureKind::Resource => Class::Resource,
            FailureKind::Internal | FailureKind::Cancelled => Class::Plugin,
        };
        let message = folder.as_written(&failure.message);
        let mut finding = Diagnostic::error(format!("stage `{}`: {message}", self.stage.id));
        let blamed = failure.param.as_deref().map(|pointer| self.stage.node.follow(pointer));
        let is_written = |node: &&crate::recipe::Node| node.range != self.stage.node.range;
        finding.place = Some(blamed.filter(is_written).unwrap_or(&self.stage.use_node).place());
        if let (Some(pointer), true) = (&failure.param, blamed.is_none_or(|node| !is_written(&node))) {
            let key = pointer.trim_start_matches('/').replace('/', ".");
            finding = finding.note(format!("it blames `{key}`, which has its default here"));
        }
        if let Some([x, y, z]) = failure.place_mm {
            finding = finding.note(format!("at ({x:.3}, {y:.3}, {z:.3}) mm"));
        }
        if failure.kind == FailureKind::Resource {
            finding = finding.note("finished stages are kept; the same command goes on from there");
        }
        if let Some(hint) = &failure.hint {
            finding = finding.hint(folder.as_written(hint));
        }
        Error::new(class, finding)
    }

    fn broken(&self, reason: &str, report: &Report, folder: &WorkFolder<'_>) -> Error {
        let plugin = &self.stage.plugin;
        let message = format!("stage `{}`: plugin `{}` broke down: {reason}", self.stage.id, plugin.name);
        let mut finding = Diagnostic::error(message);
        finding.place = Some(self.stage.use_node.place());
        if !report.last_lines.is_empty() {
            let last_words = folder.as_written(&report.last_lines.join("\n"));
            finding = finding.note(format!("its last words:\n{last_words}"));
        }
        let folder = folder.path();
        finding = finding.note(format!("its folder is kept: {}", folder.display()));
        let rerun = format!(
            "run it by hand:\ncd {} && {} --request request.json",
            quoted(folder),
            quoted(&std::path::absolute(&plugin.executable).unwrap_or_else(|_| plugin.executable.clone()))
        );
        Error::new(Class::Plugin, finding.hint(rerun))
    }

    /// Puts the name of the stage on what the host found wrong with its work.
    fn blame(&self, mut error: Error) -> Error {
        for finding in error.findings.iter_mut().filter(|f| f.place.is_none() && error.class == Class::Plugin)
        {
            finding.message = format!(
                "stage `{}`: plugin `{}` misbehaved: {}",
                self.stage.id, self.stage.plugin.name, finding.message
            );
            finding.place = Some(self.stage.use_node.place());
            finding.notes.push("nothing of its outputs was published".into());
        }
        error
    }
}

/// The finished action of a stage, if the store has all of it.
pub(super) fn look_up(store: &Store, stage: &PlannedStage, key: &Digest) -> Option<Action> {
    let action = store.find_action(key)?;
    let ports = &stage.plugin.description.outputs;
    ports.iter().all(|port| action.outputs.contains_key(&port.name)).then_some(action)
}

/// What a build ends with when the user stopped it.
pub(super) fn cancelled() -> Error {
    let finding =
        Diagnostic::error("stopped; finished stages are kept and the same command goes on from there");
    Error::new(Class::Cancelled, finding)
}

fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+:=".contains(c);
    if text.chars().all(plain) { text } else { format!("'{}'", text.replace('\'', "'\\''")) }
}
