//! The conformance kit: does a plugin keep the promises of the protocol? Every check says what it saw.

mod trial;

use crate::host::{End, Limits};
use crate::plugin::{Plugin, ensure_environment};
use crate::{Result, Store};
use fibar_core::diagnostic::Diagnostic;
use fibar_core::protocol::{Arity, Description, FailureKind};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trial::{Bench, outcome};

/// What is needed to run a plugin without a recipe.
#[derive(Debug, Default)]
pub struct Samples {
    /// Files or folders for input ports.
    pub inputs: BTreeMap<String, Vec<PathBuf>>,
    /// Parameters that have no default.
    pub params: serde_json::Map<String, Value>,
}

/// The result of one check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Check {
    /// What was asked.
    pub name: &'static str,
    /// What was seen.
    pub verdict: Verdict,
}

/// What was seen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// The promise is kept.
    Kept,
    /// It is broken, in this way.
    Broken(String),
    /// It could not be asked, for this reason.
    Skipped(String),
}

/// Asks a plugin everything that can be asked with the samples; `tell` hears of what takes a while.
pub fn check(executable: &Path, samples: &Samples, store: &Store, tell: &dyn Fn(&str)) -> Result<Vec<Check>> {
    let name = executable.file_stem().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let describe = || crate::host::describe(executable, store, &Limits::default());
    let checked = |description| crate::plugin::check_description(&name, &description).map(|()| description);
    let mut checks = Checks::default();
    let description = match describe().and_then(checked) {
        Ok(description) => description,
        Err(error) => {
            checks.note("describes itself", broken(error.findings.first()));
            return Ok(checks.0);
        }
    };
    checks.note("describes itself", Verdict::Kept);
    let again = describe().is_ok_and(|again| again == description);
    checks.note("says the same when asked again", kept_if(again, "it says something else"));
    checks.note("gives its parameters defaults", gives_defaults(&description));
    let plugin = Plugin::load(&name, executable, store)?;
    let environment = ensure_environment(&plugin, store, tell)?;
    let environment = environment.as_ref();
    Bench { executable, description: &description, samples, store, environment }.check(&mut checks)?;
    Ok(checks.0)
}

#[derive(Default)]
struct Checks(Vec<Check>);

impl Checks {
    fn note(&mut self, name: &'static str, verdict: Verdict) {
        self.0.push(Check { name, verdict });
    }
}

fn broken(finding: Option<&Diagnostic>) -> Verdict {
    Verdict::Broken(finding.map_or(String::new(), |finding| finding.message.clone()))
}

/// A parameter without a default in the schema would be missing from the key.
fn gives_defaults(description: &Description) -> Verdict {
    let required = description.params["required"].as_array().map_or(&[][..], Vec::as_slice);
    let properties = description.params["properties"].as_object().into_iter().flatten();
    let lacking = properties.filter(|(name, schema)| {
        schema.get("default").is_none() && !required.iter().any(|word| word == *name)
    });
    let lacking: Vec<String> = lacking.map(|(name, _)| format!("`{name}`")).collect();
    kept_if(lacking.is_empty(), &format!("the schema names none for {}", lacking.join(", ")))
}

fn kept_if(kept: bool, otherwise: &str) -> Verdict {
    if kept { Verdict::Kept } else { Verdict::Broken(otherwise.into()) }
}

impl Bench<'_> {
    /// Everything that takes a session or a run.
    fn check(&self, checks: &mut Checks) -> Result<()> {
        checks.note("refuses another protocol version", self.refuses_other_version());
        checks.note("refuses unknown parameters", self.unknown_parameter());
        checks.note("refuses missing inputs", self.missing_input());
        if let Some(reason) = self.lacks() {
            for name in ["runs with its defaults", "gives the same bytes again", "stops when asked"] {
                checks.note(name, Verdict::Skipped(reason.clone()));
            }
            return Ok(());
        }
        let first = self.run(1)?;
        checks.note("runs with its defaults", outcome(&first.report));
        if matches!(first.report.end, End::Done(_)) {
            checks.note("gives the same bytes again", self.repeats(&first)?);
        }
        checks.note("stops when asked", self.stops()?);
        Ok(())
    }

    /// Why the stage cannot be run at all.
    fn lacks(&self) -> Option<String> {
        let lacks = |port: &&fibar_core::protocol::InputPort| {
            port.arity == Arity::One && !self.samples.inputs.contains_key(&port.name)
        };
        let port = self.description.inputs.iter().find(lacks);
        port.map(|port| format!("give it an input: --input {}=FILE", port.name))
    }

    fn unknown_parameter(&self) -> Verdict {
        let mut request = self.request(1);
        request.params["no-such-parameter"] = json!(1);
        self.refuses(&request, &[FailureKind::User])
    }

    fn missing_input(&self) -> Verdict {
        if !self.description.inputs.iter().any(|port| port.arity == Arity::One) {
            return Verdict::Skipped("it needs none".into());
        }
        let mut request = self.request(1);
        request.inputs.clear();
        self.refuses(&request, &[FailureKind::Internal, FailureKind::Input, FailureKind::User])
    }

    fn repeats(&self, first: &trial::Run<'_>) -> Result<Verdict> {
        if !self.description.deterministic {
            return Ok(Verdict::Skipped("it does not promise to".into()));
        }
        let again = self.run(3)?;
        let (a, b) = (first.digests(self.description), again.digests(self.description));
        Ok(match (a, b) {
            (Ok(a), Ok(b)) if a == b => Verdict::Kept,
            (Ok(a), Ok(b)) => {
                let port = a.iter().find(|(port, digest)| b.get(*port) != Some(digest)).map(|(port, _)| port);
                Verdict::Broken(format!("output `{}` differs on 3 threads", port.map_or("?", |p| p)))
            }
            (Err(error), _) | (_, Err(error)) => broken(error.findings.first()),
        })
    }
}

/// The parameters that have a default, with it.
fn defaults_of(description: &Description) -> serde_json::Map<String, Value> {
    let properties = description.params["properties"].as_object().cloned().unwrap_or_default();
    let default =
        |(key, schema): (String, Value)| Some((key, schema.get("default").filter(|d| !d.is_null())?.clone()));
    properties.into_iter().filter_map(default).collect()
}
