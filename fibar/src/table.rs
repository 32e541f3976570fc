//! Results as short tables on standard output.

use fibar_core::protocol::Arity;
use fibar_engine::Store;
use fibar_engine::build::{Finished, Outcome};
use fibar_engine::conformance::{Check, Verdict};
use fibar_engine::determinism::Comparison;
use fibar_engine::ledger::{BuildReport, FoundViolation};
use fibar_engine::plan::Plan;
use fibar_engine::plugin::Plugin;
use fibar_engine::store::{Audit, Collected, Stats};
use std::fmt::Write;

/// How many violations of one rule are shown; the verdict files have them all.
const SHOWN_PER_RULE: usize = 3;

/// What came out of a build, where, and how good it is.
pub fn build(report: &BuildReport) -> String {
    let mut out = format!("\n{}: {}\n", report.name, summary(report));
    let width = report.stages.iter().map(|s| s.id.len()).max().unwrap_or(0);
    for stage in &report.stages {
        let what = match stage.outcome {
            Outcome::Hit => format!("unchanged   (made in {:.2} s)", stage.made_in),
            _ => format!("{:<11} {:>8.2} s", stage.outcome.word(), stage.seconds),
        };
        let _ = writeln!(out, "  {:<width$}  {what}", stage.id);
    }
    if report.executed() > 0 {
        let chain = report.critical_path.join(" → ");
        let _ = writeln!(out, "  longest chain {:.2} s: {chain}", report.critical_path_seconds);
    }
    let _ = writeln!(out, "{}", report.folder.display());
    for file in &report.files {
        let name = if file.tree { format!("{}/", file.name) } else { file.name.clone() };
        let _ = writeln!(out, "  {name:<28} {:>10}  {}", size(file.size), file.digest.short());
    }
    let _ = writeln!(out, "  metrics.json, timings.json, trace.json, fibar.lock, provenance.json");
    violations_into(&mut out, report);
    out
}

/// What verifying found.
pub fn verification(report: &BuildReport) -> String {
    let mut out = format!("\n{}: {}\n", report.name, summary(report));
    violations_into(&mut out, report);
    if report.violations.is_empty() {
        out.push_str("  no rule is broken\n");
    }
    out
}

fn summary(report: &BuildReport) -> String {
    let executed = report.executed();
    let verdict = if report.is_verified() { "verified" } else { "UNVERIFIED" };
    let ran = if executed == 0 {
        "nothing to do".into()
    } else {
        format!("{executed} of {} stages ran", report.stages.len())
    };
    format!("{verdict}, {ran}, {:.2} s", report.total)
}

fn violations_into(out: &mut String, report: &BuildReport) {
    let mut shown: Vec<(&str, &str, usize)> = Vec::new();
    for found in &report.violations {
        let (stage, rule) = (found.stage.as_str(), found.violation.rule.as_str());
        match shown.iter_mut().find(|(s, r, _)| (*s, *r) == (stage, rule)) {
            Some((_, _, count)) => *count += 1,
            None => shown.push((stage, rule, 1)),
        }
        if shown.iter().any(|&(s, r, count)| (s, r) == (stage, rule) && count <= SHOWN_PER_RULE) {
            violation_into(out, found);
        }
    }
    for (stage, rule, count) in shown.iter().filter(|(_, _, count)| *count > SHOWN_PER_RULE) {
        let _ = writeln!(out, "  … {} of {rule} in all ({stage})", count);
    }
}

fn violation_into(out: &mut String, found: &FoundViolation) {
    let word = if found.allowed { "allowed" } else { "BROKEN" };
    let _ = write!(out, "  {word} {} ({}): {}", found.violation.rule, found.stage, found.violation.message);
    if let Some([x, y, z]) = found.violation.place_mm {
        let _ = write!(out, " at ({x:.2}, {y:.2}, {z:.2}) mm");
    }
    out.push('\n');
}

/// What two builds of the same came to.
pub fn determinism(comparison: &Comparison) -> String {
    let name = &comparison.name;
    let mut out = match &comparison.difference {
        None => format!("{name}: {} outputs are the same, byte by byte\n", comparison.same),
        Some(found) => {
            let field = found.field.as_deref().unwrap_or("of an unknown form");
            let [first, second] = &found.seen;
            format!(
                "{name}: `{}` gives another {}: byte {}, {field}\n  first:  {first}\n  second: {second}\n",
                found.stage, found.artefact, found.byte
            )
        }
    };
    if !comparison.skipped.is_empty() {
        let _ = writeln!(out, "  not compared, no such promise: {}", comparison.skipped.join(", "));
    }
    out
}

/// What collecting garbage did.
pub fn collected(done: &Collected, max_size: u64) -> String {
    let mut out = format!(
        "freed {}: {} blobs of {} actions; swept {} leftovers; {} left\n",
        size(done.freed),
        done.blobs,
        done.actions,
        done.swept,
        size(done.left)
    );
    if done.left > max_size {
        let _ = writeln!(
            out,
            "  more than asked: build folders refer to {}, running builds may use the rest",
            size(done.pinned)
        );
    }
    out
}

/// What an audit of the store found.
pub fn audit(audit: &Audit) -> String {
    let mut out = format!(
        "{} blobs, {}: {} damaged\n{} actions: {} unreadable, {} incomplete\n",
        audit.blobs + audit.damaged.len(),
        size(audit.bytes),
        audit.damaged.len(),
        audit.actions + audit.unreadable,
        audit.unreadable,
        audit.incomplete
    );
    for digest in &audit.damaged {
        let _ = writeln!(out, "  quarantined {digest}");
    }
    out
}

/// How much there is.
pub fn stats(store: &Store, stats: &Stats) -> String {
    format!(
        "{}\n  {} blobs, {}\n  {} actions that took {:.1} s to make\n  {} quarantined blobs, {} folders of runs\n",
        store.root().display(),
        stats.blobs,
        size(stats.bytes),
        stats.actions,
        stats.seconds,
        stats.quarantined,
        stats.work
    )
}

/// What the conformance kit saw.
pub fn conformance(checks: &[Check]) -> String {
    let mut out = String::new();
    for check in checks {
        let _ = match &check.verdict {
            Verdict::Kept => writeln!(out, "  ok       {}", check.name),
            Verdict::Broken(reason) => writeln!(out, "  BROKEN   {}: {reason}", check.name),
            Verdict::Skipped(reason) => writeln!(out, "  skipped  {}: {reason}", check.name),
        };
    }
    out
}

/// Many plans on one line: how much they share.
pub fn plans(plans: &[Plan], found: &[Vec<Option<Finished>>]) -> String {
    let stages: usize = plans.iter().map(|plan| plan.stages.len()).sum();
    let hits = found.iter().flatten().filter(|found| found.is_some()).count();
    format!("{} variants, {stages} stages, {hits} hits\n", plans.len())
}

/// Hit or miss per stage.
pub fn plan(plan: &Plan, found: &[Option<Finished>]) -> String {
    let misses = found.iter().filter(|f| f.is_none()).count();
    let mut out = format!("{}: {} stages, {misses} to run\n", plan.name, plan.stages.len());
    let width = plan.stages.iter().map(|s| s.id.len()).max().unwrap_or(0);
    for (stage, found) in plan.stages.iter().zip(found) {
        let what = match found {
            Some(finished) => format!("hit   {}", finished.key.short()),
            None => "miss".to_owned(),
        };
        let _ = writeln!(out, "  {:<width$}  {what}", stage.id);
    }
    out
}

/// The same for programs.
pub fn plan_json(plan: &Plan, found: &[Option<Finished>]) -> serde_json::Value {
    let stages = plan.stages.iter().zip(found).map(|(stage, found)| {
        serde_json::json!({
            "id": stage.id,
            "use": stage.plugin.name,
            "hit": found.is_some(),
            "key": found.as_ref().map(|f| f.key),
        })
    });
    serde_json::json!({"name": plan.name, "stages": stages.collect::<Vec<_>>()})
}

/// A plugin on a few lines.
pub fn plugin(plugin: &Plugin) -> String {
    let about = &plugin.description;
    let inputs = about.inputs.iter().map(|port| match port.arity {
        Arity::One => port.kind.clone(),
        Arity::Optional => format!("{}?", port.kind),
        Arity::Many => format!("{}*", port.kind),
    });
    let inputs = inputs.collect::<Vec<_>>().join(", ");
    let outputs = about.outputs.iter().map(|port| port.kind.as_str()).collect::<Vec<_>>().join(", ");
    format!("{} {}  [{inputs} -> {outputs}]\n  {}\n", about.name, about.version, about.summary)
}

fn size(bytes: u64) -> String {
    match bytes {
        0..1_000 => format!("{bytes} B"),
        1_000..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", bytes as f64 / 1e6),
        _ => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}
