//! `metrics.json`: every number the stages reported, sorted by name.

use crate::build::Finished;
use crate::plan::Plan;
use fibar_core::protocol::Metric;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// `{"name": {"value": …, "unit": …}}`, with `place_mm` where the number has one. A name that an earlier stage has used
/// is followed by `@` and the id of the stage; a stage that reports a name twice means the last.
pub(super) fn text(plan: &Plan, finished: &[Finished]) -> String {
    let mut all: BTreeMap<String, Value> = BTreeMap::new();
    for (stage, finished) in plan.stages.iter().zip(finished) {
        let own: BTreeMap<&str, &Metric> =
            finished.action.metrics.iter().map(|m| (m.name.as_str(), m)).collect();
        for (name, metric) in own {
            let taken = all.contains_key(name);
            let name = if taken { format!("{name}@{}", stage.id) } else { name.to_owned() };
            all.insert(name, entry(metric));
        }
    }
    let lines: Vec<String> =
        all.iter().map(|(name, value)| format!("  {}: {value}", Value::from(name.as_str()))).collect();
    format!("{{\n{}\n}}\n", lines.join(",\n"))
}

fn entry(metric: &Metric) -> Value {
    let mut entry = Map::new();
    // Counts read better as whole numbers.
    let whole = metric.value.fract() == 0.0 && metric.value.abs() < 9e15 && metric.unit == "1";
    entry.insert("value".into(), if whole { json!(metric.value as i64) } else { json!(metric.value) });
    entry.insert("unit".into(), json!(metric.unit));
    if let Some(place) = metric.place_mm {
        entry.insert("place_mm".into(), json!(place));
    }
    Value::Object(entry)
}
