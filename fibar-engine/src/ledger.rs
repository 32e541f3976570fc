//! The build folder: what came out, where, how good, and how long it took.
//!
//! Published outputs are copies under the names their stages gave them; beside them `metrics.json` (sorted, no times),
//! `timings.json` and `trace.json` (all times), `fibar.lock` (what made what),
//! `provenance.json` (the same for auditors), and `UNVERIFIED` while a broken rule is not allowed.

mod files;
mod lock;
mod metrics;
mod provenance;
mod report;
mod timings;
mod trace;

pub(crate) use lock::keys_of;
pub use report::{BuildReport, FoundViolation, PublishedFile, StageReport};
pub(crate) use timings::earlier_seconds;

use crate::build::{BuildOptions, Finished, Locking, Waivers};
use crate::error::IoContext;
use crate::plan::Plan;
use crate::store::Rot;
use files::BuildFolder;
use std::time::Instant;

/// The file that says which rules are broken.
pub const UNVERIFIED: &str = "UNVERIFIED";

/// Names in a build folder that no stage may publish under.
const RESERVED: [&str; 6] =
    ["metrics.json", "timings.json", "trace.json", "fibar.lock", "provenance.json", UNVERIFIED];

/// Publishes a finished plan to its build folder.
pub(crate) fn publish(
    plan: &Plan,
    finished: &[Finished],
    options: &BuildOptions<'_>,
    started: Instant,
) -> Result<BuildReport, Rot> {
    let wanted = files::wanted(plan, finished)?;
    let folder = options.out.join(&plan.name);
    let lock_text = lock::text(plan, finished, &wanted);
    if options.locking == Locking::Require {
        lock::require(&folder.join("fibar.lock"), &lock_text)?;
    }
    std::fs::create_dir_all(&folder).context("make the build folder", &folder)?;
    let folder = BuildFolder::new(folder, options.store);
    let violations = violations(plan, finished, options.waivers);
    let broken: Vec<_> = violations.iter().filter(|v| !v.allowed).collect();
    if !broken.is_empty() {
        folder.write(UNVERIFIED, report::unverified_text(&broken).as_bytes())?;
    }
    let previous = lock::outputs_of(&folder.read("fibar.lock"));
    let files = folder.publish(&wanted)?;
    folder.write("metrics.json", metrics::text(plan, finished).as_bytes())?;
    folder.write("provenance.json", provenance::text(plan, finished, &files, options.store)?.as_bytes())?;
    folder.write("fibar.lock", lock_text.as_bytes())?;
    options.store.pin(&folder.path().join("fibar.lock"))?;
    folder.remove_stale(&previous, &files);
    if broken.is_empty() {
        folder.remove(UNVERIFIED);
    }
    let stages = report::stages(plan, finished);
    let (critical_path, critical_path_seconds) = timings::critical_path(plan, finished);
    let total = started.elapsed().as_secs_f64();
    folder.write_unsynced("trace.json", trace::text(plan, finished).as_bytes())?;
    folder.write_unsynced("timings.json", timings::text(plan, finished, total).as_bytes())?;
    Ok(BuildReport {
        name: plan.name.clone(),
        folder: folder.path().to_owned(),
        stages,
        files,
        violations,
        total,
        critical_path: critical_path.into_iter().map(str::to_owned).collect(),
        critical_path_seconds,
    })
}

/// Before anything runs: a locked build must have the stages and plugins of its lock.
pub(crate) fn check_locked_plugins(plan: &Plan, options: &BuildOptions<'_>) -> crate::Result<()> {
    match options.locking {
        Locking::Update => Ok(()),
        Locking::Require => lock::require_plugins(&options.out.join(&plan.name).join("fibar.lock"), plan),
    }
}

fn violations(plan: &Plan, finished: &[Finished], waivers: Waivers) -> Vec<FoundViolation> {
    let of_stage = |(stage, finished): (&crate::plan::PlannedStage, &Finished)| {
        let found = |violation: &fibar_core::protocol::Violation| FoundViolation {
            stage: stage.id.clone(),
            allowed: waivers == Waivers::Respect && stage.allow.contains(&violation.rule),
            violation: violation.clone(),
        };
        finished.action.violations.iter().map(found).collect::<Vec<_>>()
    };
    plan.stages.iter().zip(finished).flat_map(of_stage).collect()
}
