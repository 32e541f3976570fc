//! `trace.json`: a build as a Chrome trace; open it in a browser at `about:tracing` or ui.perfetto.dev.

use crate::build::{Finished, Outcome};
use crate::plan::Plan;
use serde_json::{Value, json};

/// The text of the file: one row per stage that ran at the same time, hits as instants.
pub(super) fn text(plan: &Plan, finished: &[Finished]) -> String {
    let mut rows: Vec<f64> = Vec::new();
    let mut order: Vec<usize> = (0..finished.len()).collect();
    order.sort_by(|&a, &b| finished[a].start.total_cmp(&finished[b].start));
    let mut events = Vec::new();
    for at in order {
        let (stage, finished) = (&plan.stages[at], &finished[at]);
        let row = match finished.outcome {
            Outcome::Hit => 0,
            _ => free_row(&mut rows, finished),
        };
        events.push(event(&stage.id, &stage.plugin.name, finished, row));
    }
    let value = json!({"displayTimeUnit": "ms", "traceEvents": events});
    serde_json::to_string_pretty(&value).expect("a trace is plain data") + "\n"
}

/// The first row that nothing occupies when the stage starts; `rows` holds when each becomes free.
fn free_row(rows: &mut Vec<f64>, finished: &Finished) -> usize {
    let row = rows.iter().position(|&free| free <= finished.start).unwrap_or_else(|| {
        rows.push(0.0);
        rows.len() - 1
    });
    rows[row] = finished.start + finished.seconds;
    row
}

fn event(id: &str, plugin: &str, finished: &Finished, row: usize) -> Value {
    let microseconds = |s: f64| (s * 1e6).round();
    let mut event = json!({
        "name": id,
        "cat": finished.outcome.word(),
        "ph": "X",
        "ts": microseconds(finished.start),
        "dur": microseconds(finished.seconds),
        "pid": 1,
        "tid": row + 1,
        "args": {"use": plugin, "key": finished.key, "cores": finished.cores, "made_in_s": finished.action.seconds},
    });
    if finished.outcome == Outcome::Hit {
        event["ph"] = json!("i");
        event["s"] = json!("p");
        event.as_object_mut().map(|fields| fields.remove("dur"));
    }
    event
}
