//! Why a stage would run: which field of its key changed, old → new, and what upstream or in which file that comes from.
//!
//! A stage is held against the action it had in the last build (by `fibar.lock`), else against the action of the same
//! plugin in the store that differs in the fewest fields.

mod difference;
mod render;

use crate::build::{Finished, predict};
use crate::ledger::keys_of;
use crate::plan::{InputDigests, Manifest, Plan, PlannedStage};
use crate::store::Action;
use crate::{Class, Digest, Error, Result, Store};
use difference::differences;
use fibar_core::diagnostic::{Diagnostic, Place, did_you_mean};
use std::collections::BTreeMap;
use std::path::Path;

/// Why one stage runs or does not.
#[derive(Debug)]
pub struct Explanation {
    /// The stage.
    pub stage: String,
    /// The plugin.
    pub plugin: String,
    /// What a build would do with it.
    pub verdict: Verdict,
    /// What it was held against.
    pub earlier: Option<Digest>,
    /// The fields of the key that differ from that.
    pub changes: Vec<Change>,
}

/// What a build would do with a stage.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing: the store has this.
    Hit(Digest),
    /// Run it: the store does not have this key.
    Miss(Digest),
    /// Run it: the store had this, but an output is gone.
    Gone(Digest),
    /// Nobody knows before the stages run that it takes inputs from; the same bytes again would be a hit.
    Waits,
}

/// A field of a key that differs.
#[derive(Debug)]
pub struct Change {
    /// E.g. `params/spacing_mm`, `plugin_digest`, `inputs/body`.
    pub field: String,
    /// In the earlier action.
    pub old: String,
    /// Now.
    pub new: String,
    /// Where the new value is written.
    pub place: Option<Place>,
    /// The stage that the changed input comes from.
    pub because: Option<Box<Explanation>>,
}

/// Explains one stage of a plan; `lock` is the lock file of its last build.
pub fn explain(plan: &Plan, stage: &str, store: &Store, lock: &Path) -> Result<Explanation> {
    let at = plan.stages.iter().position(|s| s.id == stage).ok_or_else(|| {
        let ids = || plan.stages.iter().map(|s| s.id.as_str());
        let finding = Diagnostic::error(format!("the recipe has no stage `{stage}`"));
        Error::new(
            Class::Recipe,
            match did_you_mean(stage, ids()) {
                Some(id) => finding.hint(format!("did you mean `{id}`?")),
                None => finding.hint(format!("stages: {}", ids().collect::<Vec<_>>().join(", "))),
            },
        )
    })?;
    let explainer = Explainer {
        plan,
        found: predict(plan, store),
        last: keys_of(&std::fs::read_to_string(lock).unwrap_or_default()),
        known: store.all_actions()?.into_iter().collect(),
        store,
    };
    Ok(explainer.stage(at, None))
}

struct Explainer<'a> {
    plan: &'a Plan,
    store: &'a Store,
    found: Vec<Option<Finished>>,
    /// Keys of the last build, by stage.
    last: BTreeMap<String, Digest>,
    known: BTreeMap<Digest, Action>,
}

impl Explainer<'_> {
    /// Explains a stage, against the action that made `old` if that is given.
    fn stage(&self, at: usize, old: Option<&Digest>) -> Explanation {
        let stage = &self.plan.stages[at];
        let inputs = crate::build::resolve_inputs(stage, &self.found);
        let waits = inputs.is_none();
        let manifest = Manifest::of(stage, inputs.unwrap_or_else(|| self.partial_inputs(stage)));
        let key = manifest.key();
        let verdict = match (waits, &self.found[at]) {
            (true, _) => Verdict::Waits,
            (false, Some(_)) => Verdict::Hit(key),
            (false, None) if self.store.read_action(&key).is_some() => Verdict::Gone(key),
            (false, None) => Verdict::Miss(key),
        };
        let earlier = self.earlier(stage, &manifest, old).filter(|(found, _)| **found != key);
        let changes = earlier.map_or_else(Vec::new, |(_, action)| {
            let fields = differences(&action.manifest, &manifest);
            fields.into_iter().map(|f| self.change(stage, f, &action.manifest)).collect()
        });
        Explanation {
            stage: stage.id.clone(),
            plugin: stage.plugin.name.clone(),
            verdict,
            earlier: earlier.map(|(key, _)| *key),
            changes,
        }
    }

    /// The inputs that are known; ports that wait for a stage are empty.
    fn partial_inputs(&self, stage: &PlannedStage) -> InputDigests {
        let digests = |wire: &crate::plan::Wire| {
            let digest = |source: &crate::plan::WireSource| {
                self.found[source.stage].as_ref().map(|f| f.action.outputs[&source.port].digest)
            };
            wire.sources.iter().map(digest).collect::<Option<Vec<_>>>().unwrap_or_default()
        };
        stage.wires.iter().map(|wire| (wire.port.clone(), digests(wire))).collect()
    }

    /// What to hold a stage against: the action that made a given artefact, else that of the last build, else the nearest.
    fn earlier(
        &self,
        stage: &PlannedStage,
        manifest: &Manifest,
        old: Option<&Digest>,
    ) -> Option<(&Digest, &Action)> {
        let same_plugin = || self.known.iter().filter(|(_, a)| a.manifest.plugin == manifest.plugin);
        let made = |old: &Digest| {
            same_plugin().find(|(_, action)| action.outputs.values().any(|output| output.digest == *old))
        };
        let last = || self.last.get(&stage.id).and_then(|key| self.known.get_key_value(key));
        let nearest = || same_plugin().min_by_key(|(_, a)| differences(&a.manifest, manifest).len());
        old.and_then(made).or_else(last).or_else(nearest)
    }

    fn change(&self, stage: &PlannedStage, difference: difference::Difference, earlier: &Manifest) -> Change {
        let difference::Difference { field, old, new } = difference;
        let port = field.strip_prefix("inputs/");
        let because = port.and_then(|port| self.because(stage, port, earlier));
        let new = match &because {
            Some(because) if new.is_empty() => format!("whatever `{}` gives", because.stage),
            _ => new,
        };
        Change { place: place_of(stage, &field), because, field, old, new }
    }

    /// The stage behind a changed input.
    fn because(&self, stage: &PlannedStage, port: &str, earlier: &Manifest) -> Option<Box<Explanation>> {
        let wire = stage.wires.iter().find(|wire| wire.port == port)?;
        let old = earlier.inputs.get(port);
        let source_of = |(i, source): (usize, &crate::plan::WireSource)| {
            let before = old.and_then(|digests| digests.get(i));
            let now = self.found[source.stage].as_ref().map(|f| f.action.outputs[&source.port].digest);
            (now.is_none() || before != now.as_ref()).then_some((source.stage, before))
        };
        let (at, before) = wire.sources.iter().enumerate().find_map(source_of)?;
        Some(Box::new(self.stage(at, before)))
    }
}

/// Where the recipe writes the value of a field, or the stage as a whole.
fn place_of(stage: &PlannedStage, field: &str) -> Option<Place> {
    let pointer = match field {
        "seed" => "/seed",
        _ => field.strip_prefix("params")?,
    };
    let node = stage.node.follow(pointer);
    Some(if node.range == stage.node.range { stage.use_node.place() } else { node.place() })
}
