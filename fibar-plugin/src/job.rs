//! One run as a stage sees it: inputs, seed, threads, a folder for outputs, and ways to report.

use crate::StageError;
use crate::line::Line;
use fibar_core::protocol::{
    Arity, Description, Done, InputArtefact, LogLine, Metric, PluginMessage, Progress, Request, Violation,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Progress of the same phase is reported at most this often.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(40);

/// One run of a stage.
pub struct Job {
    request: Request,
    description: Description,
    outputs: BTreeMap<String, String>,
    line: Line,
    reported: Option<(Instant, String)>,
}

impl Job {
    pub(crate) fn new(request: Request, description: Description, line: Line) -> Job {
        Job { request, description, outputs: BTreeMap::new(), line, reported: None }
    }

    /// The bytes of a blob input.
    pub fn read(&self, port: &str) -> Result<Vec<u8>, StageError> {
        read_file(&self.input_path(port)?, port)
    }

    /// The bytes of an optional blob input, `None` when it is not wired.
    pub fn read_optional(&self, port: &str) -> Result<Option<Vec<u8>>, StageError> {
        self.inputs(port)?.first().map(|input| read_file(Path::new(&input.path), port)).transpose()
    }

    /// Where a blob or tree input lies, read-only.
    pub fn input_path(&self, port: &str) -> Result<PathBuf, StageError> {
        let first = self.inputs(port)?.first();
        first.map(|i| PathBuf::from(&i.path)).ok_or_else(|| {
            StageError::internal(format!("input `{port}` is not in the request"))
                .hint(format!("add it: \"inputs\": {{\"{port}\": [{{\"path\": \"…\"}}]}}"))
        })
    }

    /// Where all artefacts of an input of arity many lie, in recipe order.
    pub fn input_paths(&self, port: &str) -> Result<Vec<PathBuf>, StageError> {
        Ok(self.inputs(port)?.iter().map(|i| PathBuf::from(&i.path)).collect())
    }

    fn inputs(&self, port: &str) -> Result<&[InputArtefact], StageError> {
        if !self.description.inputs.iter().any(|p| p.name == port) {
            return Err(StageError::internal(format!(
                "input `{port}` is not in the description of this stage"
            )));
        }
        Ok(self.request.inputs.get(port).map_or(&[], Vec::as_slice))
    }

    /// How many threads the stage may keep busy; the global rayon pool already has this size. Never let it change a
    /// byte of the outputs.
    pub fn threads(&self) -> usize {
        self.request.threads.max(1) as usize
    }

    /// For `ChaCha8Rng::seed_from_u64` and the like.
    pub fn seed(&self) -> u64 {
        self.request.seed
    }

    /// The interpreter of the Python environment that the description names, set up by the host.
    pub fn python(&self) -> Result<&Path, StageError> {
        self.request.python.as_deref().map(Path::new).ok_or_else(|| {
            StageError::resource("the request names no Python")
                .hint("add it: \"python\": \"…/bin/python\", with the packages of the requirements")
        })
    }

    /// The folder for outputs, empty at the start.
    pub fn out_dir(&self) -> &Path {
        Path::new(&self.request.out_dir)
    }

    /// Says how far the run is, from 0 to 1, and whether to go on: `job.progress(0.3, "rays")?`. Cheap enough for
    /// inner loops of about a microsecond and more.
    pub fn progress(&mut self, fraction: f64, phase: &str) -> Result<(), StageError> {
        self.check_cancel()?;
        let due = |(at, last): &(Instant, String)| at.elapsed() >= PROGRESS_INTERVAL || last != phase;
        if self.reported.as_ref().is_none_or(due) {
            let fraction = if fraction.is_finite() { fraction.clamp(0.0, 1.0) } else { 0.0 };
            self.line.send(&PluginMessage::Progress(Progress { fraction, phase: phase.into() }));
            self.reported = Some((Instant::now(), phase.into()));
        }
        Ok(())
    }

    /// An error when the host asked to stop; for loops that have no progress to report.
    pub fn check_cancel(&self) -> Result<(), StageError> {
        if self.line.is_cancelled() { Err(StageError::cancelled()) } else { Ok(()) }
    }

    /// A number for `metrics.json`, unit `1`, `mm`, `mm3`, …; one that is not finite is left out with a warning.
    pub fn metric(&mut self, name: &str, value: f64, unit: &str) {
        self.send_metric(Metric { name: name.into(), value, unit: unit.into(), place_mm: None });
    }

    /// The same, with the place where the number was found, in the body's frame, mm.
    pub fn metric_at(&mut self, name: &str, value: f64, unit: &str, place_mm: [f64; 3]) {
        self.send_metric(Metric { name: name.into(), value, unit: unit.into(), place_mm: Some(place_mm) });
    }

    fn send_metric(&mut self, metric: Metric) {
        let place_is_finite = metric.place_mm.is_none_or(|p| p.iter().all(|x| x.is_finite()));
        if metric.value.is_finite() && place_is_finite {
            self.line.send(&PluginMessage::Metric(metric));
        } else {
            self.log("warn", &format!("metric {} is {}, left out", metric.name, metric.value));
        }
    }

    /// A line for the log of the stage; `level` is `error`, `warn`, `info` or `debug`.
    pub fn log(&mut self, level: &str, message: &str) {
        self.line.send(&PluginMessage::Log(LogLine { level: level.into(), message: message.into() }));
    }

    /// A rule that the checked artefact breaks; the build is UNVERIFIED unless the recipe allows the rule.
    pub fn violation(&mut self, mut violation: Violation) {
        violation.place_mm = violation.place_mm.filter(|p| p.iter().all(|x| x.is_finite()));
        self.line.send(&PluginMessage::Violation(violation));
    }

    /// Writes a blob output as `file` in the output folder.
    pub fn write(&mut self, port: &str, file: &str, bytes: &[u8]) -> Result<(), StageError> {
        let path = self.declare(port, file)?;
        std::fs::write(&path, bytes)?;
        Ok(())
    }

    /// Promises a blob output and says where to write it, for writers that want a path or stream.
    pub fn create_file(&mut self, port: &str, file: &str) -> Result<PathBuf, StageError> {
        self.declare(port, file)
    }

    /// Makes the folder of a tree output and says where it is.
    pub fn create_tree(&mut self, port: &str, folder: &str) -> Result<PathBuf, StageError> {
        let path = self.declare(port, folder)?;
        std::fs::create_dir_all(&path)?;
        Ok(path)
    }

    fn declare(&mut self, port: &str, name: &str) -> Result<PathBuf, StageError> {
        if !self.description.outputs.iter().any(|p| p.name == port) {
            return Err(StageError::internal(format!(
                "output `{port}` is not in the description of this stage"
            )));
        }
        if let Some(other) = self.outputs.insert(port.into(), name.into()) {
            return Err(StageError::internal(format!("output `{port}` was already written as {other}")));
        }
        Ok(self.out_dir().join(name))
    }

    /// What the host should collect, or the output that was forgotten.
    pub(crate) fn finish(self) -> Result<Done, StageError> {
        let forgotten = self.description.outputs.iter().find(|p| !self.outputs.contains_key(&p.name));
        match forgotten {
            Some(port) => Err(StageError::internal(format!("output `{}` was not written", port.name))),
            None => Ok(Done { outputs: self.outputs }),
        }
    }

    /// Whether the request wires what the description demands.
    pub(crate) fn check_inputs(&self) -> Result<(), StageError> {
        for port in self.description.inputs.iter().filter(|p| p.arity == Arity::One) {
            self.input_path(&port.name)?;
        }
        Ok(())
    }
}

fn read_file(path: &Path, port: &str) -> Result<Vec<u8>, StageError> {
    std::fs::read(path).map_err(|e| StageError::input(format!("input `{port}`: {}: {e}", path.display())))
}
