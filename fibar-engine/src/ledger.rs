//! The build folder: what came out, where, how good, and how long it took.
//!
//! Published outputs are copies under the names their stages gave them; beside them `metrics.json` (sorted, no times),
//! `timings.json` (all times), `fibar.lock` (what made what), and `UNVERIFIED` while a broken rule is not allowed.

mod files;
mod lock;
mod metrics;
mod report;
mod timings;

pub(crate) use lock::keys_of;
pub use report::{BuildReport, FoundViolation, PublishedFile, StageReport};

use crate::build::{BuildOptions, Finished, Waivers};
use crate::error::IoContext;
use crate::plan::Plan;
use crate::store::Rot;
use files::BuildFolder;
use std::time::Instant;

/// The file that says which rules are broken.
pub const UNVERIFIED: &str = "UNVERIFIED";

/// Names in a build folder that no stage may publish under.
const RESERVED: [&str; 4] = ["metrics.json", "timings.json", "fibar.lock", UNVERIFIED];

/// Publishes a finished plan to its build folder.
pub(crate) fn publish(
    plan: &Plan,
    finished: &[Finished],
    options: &BuildOptions<'_>,
    started: Instant,
) -> Result<BuildReport, Rot> {
    let folder = options.out.join(&plan.name);
    std::fs::create_dir_all(&folder).context("make the build folder", &folder)?;
    let folder = BuildFolder::new(folder, options.store);
    let violations = violations(plan, finished, options.waivers);
    let broken: Vec<_> = violations.iter().filter(|v| !v.allowed).collect();
    if !broken.is_empty() {
        folder.write(UNVERIFIED, report::unverified_text(&broken).as_bytes())?;
    }
    let wanted = files::wanted(plan, finished)?;
    let previous = lock::outputs_of(&folder.read("fibar.lock"));
    let files = folder.publish(&wanted)?;
    folder.write("metrics.json", metrics::text(plan, finished).as_bytes())?;
    folder.write("fibar.lock", lock::text(plan, finished, &files).as_bytes())?;
    options.store.pin(&folder.path().join("fibar.lock"))?;
    folder.remove_stale(&previous, &files);
    if broken.is_empty() {
        folder.remove(UNVERIFIED);
    }
    let stages = report::stages(plan, finished);
    let total = started.elapsed().as_secs_f64();
    folder.write_unsynced("timings.json", timings::text(plan, finished, total).as_bytes())?;
    Ok(BuildReport {
        name: plan.name.clone(),
        folder: folder.path().to_owned(),
        stages,
        files,
        violations,
        total,
    })
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
