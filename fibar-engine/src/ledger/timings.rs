//! `timings.json`: all times of a build, and nothing else holds any.

use crate::build::Finished;
use crate::plan::Plan;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

/// The text of the file: per stage what it took in this build, and what its making took whenever that was.
pub(super) fn text(plan: &Plan, finished: &[Finished], total: f64) -> String {
    let stages = plan.stages.iter().zip(finished).map(|(stage, finished)| {
        json!({
            "id": stage.id,
            "use": stage.plugin.name,
            "result": finished.outcome.word(),
            "start_s": round(finished.start),
            "seconds": round(finished.seconds),
            "made_in_s": round(finished.action.seconds),
            "cores": finished.cores,
        })
    });
    let (path, seconds) = critical_path(plan, finished);
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let value = json!({
        "format": "fibar.timings/1",
        "finished_unix_s": now,
        "total_s": round(total),
        "stages": stages.collect::<Vec<Value>>(),
        "critical_path": path,
        "critical_path_s": round(seconds),
    });
    serde_json::to_string_pretty(&value).expect("timings are plain data") + "\n"
}

/// What each stage took to make in the last build into a folder, s, by id; nothing if that cannot be read.
pub(crate) fn earlier_seconds(folder: &Path) -> BTreeMap<String, f64> {
    let text = std::fs::read(folder.join("timings.json")).unwrap_or_default();
    let timings: Value = serde_json::from_slice(&text).unwrap_or_default();
    let stages = timings["stages"].as_array().into_iter().flatten();
    let known = stages.filter_map(|s| Some((s["id"].as_str()?.to_owned(), s["made_in_s"].as_f64()?)));
    known.collect()
}

/// The chain of stages that takes longest to make, and how long: no number of cores makes the build faster than that.
pub(super) fn critical_path<'a>(plan: &'a Plan, finished: &[Finished]) -> (Vec<&'a str>, f64) {
    let mut best: Vec<(f64, Option<usize>)> = Vec::new();
    for (stage, finished) in plan.stages.iter().zip(finished) {
        let sources = stage.wires.iter().flat_map(|wire| &wire.sources).map(|source| source.stage);
        let longest = sources.max_by(|&a, &b| best[a].0.total_cmp(&best[b].0));
        best.push((longest.map_or(0.0, |at| best[at].0) + finished.action.seconds, longest));
    }
    let mut at = (0..best.len()).max_by(|&a, &b| best[a].0.total_cmp(&best[b].0));
    let total = at.map_or(0.0, |at| best[at].0);
    let mut path = Vec::new();
    while let Some(stage) = at {
        path.push(plan.stages[stage].id.as_str());
        at = best[stage].1;
    }
    path.reverse();
    (path, total)
}

fn round(seconds: f64) -> f64 {
    (seconds * 1e4).round() / 1e4
}
