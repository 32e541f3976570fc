//! How long the rest of a build will take, going by what its stages took in earlier builds.

use crate::Digest;
use crate::ledger::earlier_seconds;
use crate::plan::{InputDigests, Manifest, Plan, PlannedStage};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

/// What is left of a build.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Left {
    /// Time, s, for the stages that earlier builds had; less if their inputs turn out unchanged.
    pub seconds: f64,
    /// Stages to come that no earlier build had.
    pub unknown: usize,
}

/// What is known of the stages of some plans before they run.
pub(super) struct Estimate {
    stages: Vec<Vec<Expected>>,
}

struct Expected {
    /// Equal for stages of several plans that will turn out to be one action.
    identity: Digest,
    seconds: Option<f64>,
    began: Option<Instant>,
}

impl Estimate {
    /// From the last build into each plan's folder; a variant without one goes by its siblings.
    pub fn from_earlier(plans: &[Plan], out: &Path) -> Estimate {
        let earlier: Vec<_> = plans.iter().map(|plan| earlier_seconds(&out.join(&plan.name))).collect();
        let anywhere: BTreeMap<&str, f64> =
            earlier.iter().flatten().map(|(id, s)| (id.as_str(), *s)).collect();
        let seconds = |at: usize, id: &str| earlier[at].get(id).or(anywhere.get(id)).copied();
        let expected = |(at, plan): (usize, &Plan)| {
            let named = plan.stages.iter().zip(identities(plan));
            let expect = |(stage, identity): (&PlannedStage, Digest)| Expected {
                identity,
                seconds: seconds(at, &stage.id),
                began: None,
            };
            named.map(expect).collect()
        };
        Estimate { stages: plans.iter().enumerate().map(expected).collect() }
    }

    /// Notes that a stage runs now.
    pub fn start(&mut self, (plan, stage): (usize, usize)) {
        self.stages[plan][stage].began = Some(Instant::now());
    }

    /// What is left, on so many cores: the longest chain, and the rest side by side (the bound of Graham 1969).
    pub fn left(&self, plans: &[Plan], is_finished: impl Fn(usize, usize) -> bool, cores: u32) -> Left {
        let mut work: BTreeMap<Digest, Option<f64>> = BTreeMap::new();
        let mut longest: f64 = 0.0;
        for (p, plan) in plans.iter().enumerate() {
            let mut chains: Vec<f64> = Vec::new();
            for (s, stage) in plan.stages.iter().enumerate() {
                let expected = &self.stages[p][s];
                let own = if is_finished(p, s) { Some(0.0) } else { expected.left() };
                work.entry(expected.identity).or_insert(own);
                let sources = stage.wires.iter().flat_map(|wire| &wire.sources);
                let before = sources.map(|source| chains[source.stage]).fold(0.0, f64::max);
                chains.push(before + own.unwrap_or(0.0));
            }
            longest = chains.into_iter().fold(longest, f64::max);
        }
        let total: f64 = work.values().flatten().sum();
        let unknown = work.values().filter(|seconds| seconds.is_none()).count();
        Left { seconds: longest + (total - longest).max(0.0) / f64::from(cores.max(1)), unknown }
    }
}

impl Expected {
    fn left(&self) -> Option<f64> {
        let since = self.began.map_or(0.0, |began| began.elapsed().as_secs_f64());
        self.seconds.map(|seconds| (seconds - since).max(0.0))
    }
}

/// A digest per stage of everything that is known of its key before anything ran.
fn identities(plan: &Plan) -> Vec<Digest> {
    let mut known: Vec<Digest> = Vec::new();
    for stage in &plan.stages {
        let inputs: InputDigests = stage
            .wires
            .iter()
            .map(|wire| (wire.port.clone(), wire.sources.iter().map(|source| known[source.stage]).collect()))
            .collect();
        known.push(Manifest::of(stage, inputs).key());
    }
    known
}
