//! `--log json`: everything that happens as one JSON object per line on standard error, for programs.

use crate::speak::tell;
use fibar_core::diagnostic::Severity;
use fibar_core::protocol::PluginMessage;
use fibar_engine::Error;
use fibar_engine::build::{Event, Observer};
use serde_json::{Value, json};
use std::time::Instant;

/// Events with the seconds since the start.
pub struct JsonLog {
    started: Instant,
}

impl JsonLog {
    /// Starts the clock.
    pub fn start() -> JsonLog {
        JsonLog { started: Instant::now() }
    }
}

impl Observer for JsonLog {
    fn event(&self, event: &Event<'_>) {
        let mut line = fields(event);
        line["t"] = json!((self.started.elapsed().as_secs_f64() * 1e4).round() / 1e4);
        tell(line);
    }
}

fn fields(event: &Event<'_>) -> Value {
    match event {
        Event::Planned { stages } => json!({"event": "planned", "stages": stages}),
        Event::Left(left) => json!({"event": "left", "seconds": left.seconds, "unknown": left.unknown}),
        Event::Started { stage, cores } => {
            json!({"event": "started", "build": stage.build, "stage": stage.stage, "cores": cores})
        }
        Event::Said { stage, message } => {
            let (build, stage) = (stage.build, stage.stage);
            match message {
                PluginMessage::Progress(p) => {
                    json!({"event": "progress", "build": build, "stage": stage, "fraction": p.fraction, "phase": p.phase})
                }
                other => json!({"event": "said", "build": build, "stage": stage, "message": other}),
            }
        }
        Event::Finished { stage, outcome, seconds } => json!({
            "event": "finished", "build": stage.build, "stage": stage.stage,
            "result": outcome.word(), "seconds": seconds,
        }),
        Event::Failed { stage } => json!({"event": "failed", "build": stage.build, "stage": stage.stage}),
        Event::Note { text } => json!({"event": "note", "text": text}),
        Event::Rebuilding { digest } => json!({"event": "rebuilding", "digest": digest}),
    }
}

/// Findings, one per line, with file, line and column where they have a place.
pub fn findings(error: &Error) {
    for finding in &error.findings {
        let place = finding.place.as_ref().map(|place| {
            let (line, column) = place.source.line_column(place.range.start);
            json!({"file": place.source.name, "line": line, "column": column})
        });
        let severity = if finding.severity == Severity::Error { "error" } else { "warning" };
        let line = json!({
            "event": severity, "class": format!("{:?}", error.class).to_lowercase(), "message": finding.message,
            "place": place, "notes": finding.notes, "hints": finding.hints,
        });
        tell(line);
    }
}
