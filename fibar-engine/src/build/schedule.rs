//! Which stage when: hits at once, the rest side by side as far as wires and budget allow.
//!
//! One coordinating thread owns all state; each running action has a thread that does nothing but wait for its plugin.

use super::BuildOptions;
use super::budget::{Free, Grant};
use super::estimate::Estimate;
use super::execute::{Execution, cancelled, look_up};
use super::observer::{Event, Outcome, StageName};
use crate::plan::{InputDigests, Manifest, Plan, PlannedStage};
use crate::store::{Action, Rot};
use crate::{Digest, Error, Store};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::Scope;
use std::time::{Duration, Instant};

/// What is left is told again after so long at the earliest.
const ESTIMATE_PAUSE: Duration = Duration::from_millis(200);

/// A stage with its result.
#[derive(Debug, Clone)]
pub struct Finished {
    /// The key of its action.
    pub key: Digest,
    /// What it gave.
    pub action: Arc<Action>,
    /// How it came to that.
    pub outcome: Outcome,
    /// When it started, s after the build did.
    pub start: f64,
    /// How long that took in this build, s.
    pub seconds: f64,
    /// Cores it ran on; 0 for a hit.
    pub cores: u32,
}

/// The digests on the input ports of a stage, once all its sources are finished.
pub fn resolve_inputs(stage: &PlannedStage, finished: &[Option<Finished>]) -> Option<InputDigests> {
    let mut inputs = InputDigests::new();
    for wire in &stage.wires {
        let digest = |source: &crate::plan::WireSource| {
            finished[source.stage].as_ref().map(|f| f.action.outputs[&source.port].digest)
        };
        let digests: Option<Vec<Digest>> = wire.sources.iter().map(digest).collect();
        inputs.insert(wire.port.clone(), digests?);
    }
    Some(inputs)
}

/// What the store already has of a plan: per stage, its result, or `None` for a stage that would have to run.
pub fn predict(plan: &Plan, store: &Store) -> Vec<Option<Finished>> {
    predict_one(plan, store, &mut BTreeMap::new())
}

/// The same for several plans; an action that they share is looked up once.
pub fn predict_all(plans: &[Plan], store: &Store) -> Vec<Vec<Option<Finished>>> {
    let mut known = BTreeMap::new();
    plans.iter().map(|plan| predict_one(plan, store, &mut known)).collect()
}

fn predict_one(
    plan: &Plan,
    store: &Store,
    known: &mut BTreeMap<Digest, Option<Arc<Action>>>,
) -> Vec<Option<Finished>> {
    let mut finished: Vec<Option<Finished>> = Vec::with_capacity(plan.stages.len());
    for stage in &plan.stages {
        let result = resolve_inputs(stage, &finished).and_then(|inputs| {
            let key = Manifest::of(stage, inputs).key();
            let look_up = || look_up(store, stage, &key).map(Arc::new);
            known.entry(key).or_insert_with(look_up).clone().map(|action| hit(key, action))
        });
        finished.push(result);
    }
    finished
}

fn hit(key: Digest, action: Arc<Action>) -> Finished {
    Finished { key, action, outcome: Outcome::Hit, start: 0.0, seconds: 0.0, cores: 0 }
}

/// Runs all stages of all plans that the store does not have.
pub(super) fn run(plans: &[Plan], options: &BuildOptions<'_>) -> Result<Vec<Vec<Finished>>, Rot> {
    options.observer.event(&Event::Planned { stages: plans.iter().map(|p| p.stages.len()).sum() });
    let (results, arrivals) = channel();
    std::thread::scope(|scope| {
        let mut scheduler = Scheduler::new(plans, options, results);
        scheduler.run(scope, &arrivals);
        scheduler.conclude()
    })
}

/// The result of a thread.
struct Arrival {
    key: Digest,
    grant: Grant,
    start: f64,
    seconds: f64,
    result: Result<(Action, Outcome), Rot>,
}

/// Where a stage stands: plan, stage.
type Slot = (usize, usize);

struct Scheduler<'a> {
    plans: &'a [Plan],
    options: &'a BuildOptions<'a>,
    results: Sender<Arrival>,
    started: Instant,
    finished: Vec<Vec<Option<Finished>>>,
    /// How many inputs of each stage are not there yet.
    missing: Vec<Vec<usize>>,
    /// The stages that each stage feeds, once per wire.
    readers: Vec<Vec<Vec<usize>>>,
    /// Stages whose inputs are there and whose action has not been looked up yet.
    unblocked: VecDeque<Slot>,
    /// Actions that can run as soon as the budget allows.
    ready: VecDeque<(Digest, Manifest)>,
    /// Stages by the key of their action, which is ready or running; stages with the same key share one run.
    waiting: BTreeMap<Digest, Vec<Slot>>,
    running: usize,
    free: Free,
    failures: Vec<Rot>,
    /// Whether the state of the sandbox was told.
    said: bool,
    /// Made when the first stage starts: a build with nothing to do needs none.
    estimate: Option<Estimate>,
    /// When it was last told.
    estimated: Option<Instant>,
}

impl<'a> Scheduler<'a> {
    fn new(plans: &'a [Plan], options: &'a BuildOptions<'a>, results: Sender<Arrival>) -> Scheduler<'a> {
        let missing: Vec<Vec<usize>> =
            plans.iter().map(|plan| plan.stages.iter().map(|s| sources(s).count()).collect()).collect();
        let free_of_inputs = |(p, missing): (usize, &Vec<usize>)| {
            let first = (0..missing.len()).filter(|&s| missing[s] == 0);
            first.map(|s| (p, s)).collect::<Vec<_>>()
        };
        Scheduler {
            plans,
            options,
            results,
            started: Instant::now(),
            finished: plans.iter().map(|plan| vec![None; plan.stages.len()]).collect(),
            unblocked: missing.iter().enumerate().flat_map(free_of_inputs).collect(),
            missing,
            readers: plans.iter().map(readers).collect(),
            ready: VecDeque::new(),
            waiting: BTreeMap::new(),
            running: 0,
            free: Free::new(options.budget),
            failures: Vec::new(),
            said: false,
            estimate: None,
            estimated: None,
        }
    }

    fn run<'scope, 'env>(&mut self, scope: &'scope Scope<'scope, 'env>, arrivals: &Receiver<Arrival>)
    where
        'a: 'scope,
    {
        loop {
            self.look_up_unblocked();
            if self.failures.is_empty() && !(self.options.is_cancelled)() {
                self.launch(scope);
            }
            if self.running == 0 {
                return;
            }
            self.say_what_is_left();
            if let Ok(arrival) = arrivals.recv() {
                self.arrive(arrival);
            }
        }
    }

    /// Finishes hits, which unblocks others, and makes the rest ready.
    fn look_up_unblocked(&mut self) {
        while let Some((p, s)) = self.unblocked.pop_front() {
            let stage = &self.plans[p].stages[s];
            let inputs = resolve_inputs(stage, &self.finished[p]).expect("no input is missing");
            self.look_up((p, s), Manifest::of(stage, inputs));
        }
    }

    fn look_up(&mut self, slot: Slot, manifest: Manifest) {
        let key = manifest.key();
        if let Some(waiting) = self.waiting.get_mut(&key) {
            waiting.push(slot);
        } else if let Some(action) = look_up(self.options.store, &self.plans[slot.0].stages[slot.1], &key) {
            let (outcome, seconds) = (Outcome::Hit, 0.0);
            self.options.observer.event(&Event::Finished { stage: self.name(slot), outcome, seconds });
            self.finish(slot, hit(key, Arc::new(action)));
        } else {
            self.waiting.insert(key, vec![slot]);
            self.ready.push_back((key, manifest));
        }
    }

    fn finish(&mut self, (p, s): Slot, finished: Finished) {
        self.finished[p][s] = Some(finished);
        for &reader in &self.readers[p][s] {
            self.missing[p][reader] -= 1;
            if self.missing[p][reader] == 0 {
                self.unblocked.push_back((p, reader));
            }
        }
    }

    fn name(&self, (p, s): Slot) -> StageName<'a> {
        StageName { build: &self.plans[p].name, stage: &self.plans[p].stages[s].id }
    }

    /// Says once, before anything runs, that stages are not confined.
    fn say_if_open(&mut self) {
        if std::mem::replace(&mut self.said, true) {
            return;
        }
        if let Err(reason) = self.options.sandbox.granted() {
            let text = format!("note: stages run without a sandbox, with network and all files: {reason}");
            self.options.observer.event(&Event::Note { text: &text });
        }
    }

    /// Not after every stage: of a thousand variants some finish every millisecond.
    fn say_what_is_left(&mut self) {
        if self.estimated.is_some_and(|at| at.elapsed() < ESTIMATE_PAUSE) {
            return;
        }
        if let Some(estimate) = &self.estimate {
            self.estimated = Some(Instant::now());
            let is_finished = |p: usize, s: usize| self.finished[p][s].is_some();
            let left = estimate.left(self.plans, is_finished, self.options.budget.cores);
            self.options.observer.event(&Event::Left(left));
        }
    }

    /// Starts ready actions while the budget lasts.
    fn launch<'scope, 'env>(&mut self, scope: &'scope Scope<'scope, 'env>)
    where
        'a: 'scope,
    {
        let mut left = VecDeque::new();
        while let Some((key, manifest)) = self.ready.pop_front() {
            if self.free.is_used_up() {
                self.ready.push_front((key, manifest));
                break;
            }
            self.say_if_open();
            let slot = self.waiting[&key][0];
            let wish = &self.plans[slot.0].stages[slot.1].plugin.description.resources;
            match self.free.take(wish, 1 + self.ready.len()) {
                Some(grant) => self.spawn(scope, slot, manifest, key, grant),
                None => left.push_back((key, manifest)),
            }
        }
        left.append(&mut self.ready);
        self.ready = left;
    }

    fn spawn<'scope, 'env>(
        &mut self,
        scope: &'scope Scope<'scope, 'env>,
        slot: Slot,
        manifest: Manifest,
        key: Digest,
        grant: Grant,
    ) where
        'a: 'scope,
    {
        self.running += 1;
        let earlier = || Estimate::from_earlier(self.plans, &self.options.out);
        self.estimate.get_or_insert_with(earlier).start(slot);
        let name = self.name(slot);
        self.options.observer.event(&Event::Started { stage: name, cores: grant.cores });
        let stage = &self.plans[slot.0].stages[slot.1];
        let trees = self.input_trees(slot);
        let execution = Execution { options: self.options, name, stage, manifest, key, trees, grant };
        let (results, started) = (self.results.clone(), self.started);
        scope.spawn(move || {
            let start = started.elapsed().as_secs_f64();
            let result = execution.execute();
            let seconds = started.elapsed().as_secs_f64() - start;
            // The coordinator outlives all threads of the scope.
            let _ = results.send(Arrival { key, grant, start, seconds, result });
        });
    }

    fn input_trees(&self, (p, s): Slot) -> Vec<Digest> {
        let sources = self.plans[p].stages[s].wires.iter().flat_map(|wire| &wire.sources);
        let outputs = sources.filter_map(|source| {
            let finished = self.finished[p][source.stage].as_ref()?;
            finished.action.outputs.get(&source.port)
        });
        outputs.filter(|output| output.tree).map(|output| output.digest).collect()
    }

    fn arrive(&mut self, arrival: Arrival) {
        let Arrival { key, grant, start, seconds, result } = arrival;
        self.running -= 1;
        self.free.give_back(grant);
        let slots = self.waiting.remove(&key).unwrap_or_default();
        let (action, outcome) = match result {
            Ok((action, outcome)) => (Arc::new(action), outcome),
            Err(failure) => {
                for slot in slots {
                    self.options.observer.event(&Event::Failed { stage: self.name(slot) });
                }
                self.failures.push(failure);
                return;
            }
        };
        for (i, slot) in slots.into_iter().enumerate() {
            let outcome = if i == 0 { outcome } else { Outcome::Shared };
            let cores = if outcome == Outcome::Executed { grant.cores } else { 0 };
            self.options.observer.event(&Event::Finished { stage: self.name(slot), outcome, seconds });
            let action = Arc::clone(&action);
            self.finish(slot, Finished { key, action, outcome, start, seconds, cores });
        }
    }

    /// All results, or what went wrong: real errors before rot, rot before cancellation.
    fn conclude(self) -> Result<Vec<Vec<Finished>>, Rot> {
        let mut errors: Vec<Error> = Vec::new();
        for failure in self.failures {
            match failure {
                Rot::Rebuild(digest) if errors.is_empty() => return Err(Rot::Rebuild(digest)),
                Rot::Rebuild(_) => {}
                Rot::Other(error) => errors.push(error),
            }
        }
        if let Some(error) = merge(errors) {
            return Err(Rot::Other(error));
        }
        let complete = |plan: Vec<Option<Finished>>| plan.into_iter().collect::<Option<Vec<_>>>();
        let all: Option<Vec<_>> = self.finished.into_iter().map(complete).collect();
        all.ok_or_else(|| Rot::Other(cancelled()))
    }
}

/// The stages that a stage reads from, once per wire.
fn sources(stage: &PlannedStage) -> impl Iterator<Item = usize> {
    stage.wires.iter().flat_map(|wire| &wire.sources).map(|source| source.stage)
}

/// The stages that read from each stage of a plan, once per wire.
fn readers(plan: &Plan) -> Vec<Vec<usize>> {
    let mut readers = vec![Vec::new(); plan.stages.len()];
    for (reader, stage) in plan.stages.iter().enumerate() {
        sources(stage).for_each(|source| readers[source].push(reader));
    }
    readers
}

fn merge(errors: Vec<Error>) -> Option<Error> {
    errors.into_iter().reduce(|mut first, next| {
        if next.class != crate::Class::Cancelled {
            if first.class == crate::Class::Cancelled {
                first.findings.clear();
                first.class = next.class;
            }
            first.class = first.class.max(next.class);
            first.findings.extend(next.findings);
        }
        first
    })
}
