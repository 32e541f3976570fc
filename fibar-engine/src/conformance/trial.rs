//! Single runs of a plugin under test, outside any recipe.

use super::{Samples, Verdict, defaults_of};
use crate::host::{self, End, Launch, Limits, Report, RunSetup, Sandbox, WorkFolder};
use crate::plugin::EnvironmentReady;
use crate::store::Output;
use crate::{Result, Store};
use fibar_core::protocol::{Description, FailureKind, InputArtefact, Request};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// A plugin with everything it needs.
pub(super) struct Bench<'a> {
    pub executable: &'a Path,
    pub description: &'a Description,
    pub samples: &'a Samples,
    pub store: &'a Store,
    /// Its Python environment, if it names one.
    pub environment: Option<&'a EnvironmentReady>,
}

/// A run that is over, with its folder.
pub(super) struct Run<'a> {
    pub report: Report,
    folder: WorkFolder<'a>,
}

impl<'a> Bench<'a> {
    /// A request with defaults and samples.
    pub fn request(&self, threads: u32) -> Request {
        let mut params = defaults_of(self.description);
        params.extend(self.samples.params.clone());
        let artefacts = |(port, paths): (&String, &Vec<std::path::PathBuf>)| {
            let artefact = |i: usize| InputArtefact { path: format!("in/{port}.{i}"), digest: String::new() };
            (port.clone(), (0..paths.len()).map(artefact).collect())
        };
        Request {
            params: Value::Object(params),
            inputs: self.samples.inputs.iter().map(artefacts).collect(),
            out_dir: "out".into(),
            seed: 1,
            threads,
            memory_bytes: 0,
            python: self.environment.map(|ready| ready.python.display().to_string()),
        }
    }

    /// Runs it to its end.
    pub fn run(&self, threads: u32) -> Result<Run<'a>> {
        self.run_request(&self.request(threads), &|| false)
    }

    fn run_request(&self, request: &Request, is_cancelled: &dyn Fn() -> bool) -> Result<Run<'a>> {
        let folder = WorkFolder::new(self.store, "test")?;
        for (port, paths) in &self.samples.inputs {
            for (i, path) in paths.iter().enumerate() {
                copy(path, &folder.path().join(format!("in/{port}.{i}")))?;
            }
        }
        let launch = Launch {
            executable: self.executable,
            description: Some(self.description),
            folder: folder.path(),
            scratch: &self.store.scratch()?,
            readable: self.environment.map_or(&[], |ready| &ready.readable),
            threads: request.threads,
            sandbox: Sandbox::Auto,
        };
        let limits = Limits::default();
        let report = host::run(&RunSetup { launch, request, limits, is_cancelled, listener: &|_| {} });
        Ok(Run { report, folder })
    }

    /// Whether a request that is wrong ends with an error that the plugin explains.
    pub fn refuses(&self, request: &Request, kinds: &[FailureKind]) -> Verdict {
        match self.run_request(request, &|| false).map(|run| run.report.end) {
            Ok(End::Failed(failure)) if kinds.contains(&failure.kind) => Verdict::Kept,
            Ok(End::Failed(failure)) => {
                Verdict::Broken(format!("it says {:?}: {}", failure.kind, failure.message))
            }
            Ok(End::Done(_)) => Verdict::Broken("it ran as if nothing were wrong".into()),
            Ok(End::Broken(reason)) => Verdict::Broken(reason),
            Ok(End::Cancelled) => Verdict::Broken("it says that it was cancelled".into()),
            Err(error) => super::broken(error.findings.first()),
        }
    }

    /// A host of another version is told, not served.
    pub fn refuses_other_version(&self) -> Verdict {
        match host::greet_as(self.executable, self.store, u32::MAX) {
            Ok(true) => Verdict::Kept,
            Ok(false) => Verdict::Broken("it goes on with a host of version 4294967295".into()),
            Err(error) => super::broken(error.findings.first()),
        }
    }

    /// Whether it ends soon after a cancel; one that is too quick for that is fine too.
    pub fn stops(&self) -> Result<Verdict> {
        let started = Instant::now();
        let run = self.run_request(&self.request(1), &|| started.elapsed() > Duration::from_millis(50))?;
        Ok(match run.report.end {
            End::Cancelled if !run.report.killed => Verdict::Kept,
            End::Cancelled => Verdict::Broken("it had to be killed".into()),
            End::Done(_) => Verdict::Skipped("it was done before it could be asked".into()),
            _ => outcome(&run.report),
        })
    }
}

impl Run<'_> {
    /// What it wrote, after the checks that every run has to pass.
    pub fn digests(&self, description: &Description) -> Result<BTreeMap<String, Output>> {
        match &self.report.end {
            End::Done(done) => self.folder.collect(description, done),
            _ => Ok(BTreeMap::new()),
        }
    }
}

/// How a run went.
pub(super) fn outcome(report: &Report) -> Verdict {
    match &report.end {
        End::Done(_) => Verdict::Kept,
        End::Failed(failure) if failure.kind == FailureKind::User => {
            Verdict::Skipped(format!("it needs parameters (--set key=value): {}", failure.message))
        }
        End::Failed(failure) => Verdict::Broken(failure.message.clone()),
        End::Broken(reason) => Verdict::Broken(reason.clone()),
        End::Cancelled => Verdict::Broken("it says that it was cancelled".into()),
    }
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    use crate::error::IoContext;
    if !from.is_dir() {
        return std::fs::copy(from, to).map(drop).context("copy", from);
    }
    std::fs::create_dir_all(to).context("make the folder", to)?;
    for entry in std::fs::read_dir(from).context("list", from)? {
        let entry = entry.context("list", from)?;
        copy(&entry.path(), &to.join(entry.file_name()))?;
    }
    Ok(())
}
