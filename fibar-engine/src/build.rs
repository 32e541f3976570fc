//! Building recipes: plan, run what is missing, publish, and say what came out.

mod budget;
mod estimate;
mod execute;
mod observer;
mod schedule;

pub use budget::Budget;
pub use estimate::Left;
pub use observer::{Event, Observer, Outcome, Silent, StageName};
pub use schedule::{Finished, predict, predict_all, resolve_inputs};

use crate::host::Sandbox;
use crate::ledger::{self, BuildReport};
use crate::plan::{Plan, PlanOptions};
use crate::plugin::PluginPath;
use crate::recipe::{Matrix, Override};
use crate::store::Rot;
use crate::{Error, Result, Store};
use std::path::PathBuf;
use std::time::Instant;

/// A damaged store is mended by rebuilding, but not for ever.
const MAX_ROT: usize = 16;

/// What a build needs to know beside the recipes.
#[derive(Clone)]
pub struct BuildOptions<'a> {
    /// Where artefacts are kept.
    pub store: &'a Store,
    /// Where plugins are found.
    pub plugins: &'a PluginPath,
    /// Values replaced from the command line.
    pub overrides: &'a [Override],
    /// Whether `[matrix]` counts.
    pub matrix: Matrix,
    /// Whether the result must be what the lock file in the build folder says.
    pub locking: Locking,
    /// Cores and memory to use.
    pub budget: Budget,
    /// Build folders are made in here.
    pub out: PathBuf,
    /// Whether `allow` in a recipe counts.
    pub waivers: Waivers,
    /// How stages are confined.
    pub sandbox: Sandbox,
    /// Every stage is told this many threads instead of its share; for finding out whether it matters.
    pub threads: Option<u32>,
    /// How patient the host is with plugins.
    pub limits: crate::host::Limits,
    /// Told what happens.
    pub observer: &'a dyn Observer,
    /// Whether the user wants to stop.
    pub is_cancelled: &'a (dyn Fn() -> bool + Sync),
}

/// Whether `allow` in a recipe counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Waivers {
    /// Allowed violations are listed but do not fail the build.
    Respect,
    /// Every violation fails the build.
    Ignore,
}

/// What the lock file of an earlier build means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Locking {
    /// Nothing; it is written anew.
    #[default]
    Update,
    /// A build that would come to anything else fails and publishes nothing.
    Require,
}

/// Plans all recipes and builds them together; nothing is run unless all make sense.
pub fn build(recipes: &[PathBuf], options: &BuildOptions<'_>) -> Result<Vec<BuildReport>> {
    let plans = plan_all(recipes, options)?;
    build_plans(&plans, options)
}

/// Plans all recipes, or reports what is wrong with any of them.
pub fn plan_all(recipes: &[PathBuf], options: &BuildOptions<'_>) -> Result<Vec<Plan>> {
    let plan_options = PlanOptions {
        plugins: options.plugins,
        store: options.store,
        overrides: options.overrides,
        matrix: options.matrix,
    };
    let mut plans = Vec::new();
    let mut failed: Option<Error> = None;
    for recipe in recipes {
        match Plan::make(recipe, &plan_options) {
            Ok(variants) => plans.extend(variants),
            Err(error) => match &mut failed {
                Some(failed) => {
                    failed.class = failed.class.min(error.class);
                    failed.findings.extend(error.findings);
                }
                None => failed = Some(error),
            },
        }
    }
    options.store.stats.save();
    failed.map_or(Ok(plans), Err)
}

/// Builds plans and publishes what comes out; an artefact found damaged is rebuilt.
pub fn build_plans(plans: &[Plan], options: &BuildOptions<'_>) -> Result<Vec<BuildReport>> {
    let started = Instant::now();
    for plan in plans {
        ledger::check_locked_plugins(plan, options)?;
    }
    mending_rot(options, || {
        let finished = schedule::run(plans, options)?;
        let reports = plans.iter().zip(&finished);
        reports.map(|(plan, finished)| ledger::publish(plan, finished, options, started)).collect()
    })
}

/// Builds plans into the store only: the results per stage, in the order of each plan.
pub fn run_plans(plans: &[Plan], options: &BuildOptions<'_>) -> Result<Vec<Vec<Finished>>> {
    mending_rot(options, || schedule::run(plans, options))
}

fn mending_rot<T>(
    options: &BuildOptions<'_>,
    attempt: impl Fn() -> std::result::Result<T, Rot>,
) -> Result<T> {
    let _running = options.store.register()?;
    for _ in 0..MAX_ROT {
        match attempt() {
            Err(Rot::Rebuild(digest)) => options.observer.event(&Event::Rebuilding { digest }),
            Err(Rot::Other(error)) => return Err(error),
            Ok(result) => {
                options.store.stats.save();
                options.store.sync()?;
                return Ok(result);
            }
        }
    }
    attempt().map_err(Rot::into_error)
}
