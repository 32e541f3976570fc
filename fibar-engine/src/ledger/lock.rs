//! `fibar.lock`: one sorted line per stage and per output, so that two of them merge and differ line by line.

use crate::build::Finished;
use crate::plan::Plan;
use crate::store::Output;
use crate::{Class, Digest, Error, Result};
use fibar_core::diagnostic::Diagnostic;
use std::collections::BTreeMap;
use std::path::Path;

const HEADER: &str = "# fibar.lock 1, written by `fibar build`: what made what, by SHA-256\n";

/// The text of the file.
pub(super) fn text(plan: &Plan, finished: &[Finished], wanted: &BTreeMap<&str, &Output>) -> String {
    let mut lines: Vec<String> = plan
        .stages
        .iter()
        .zip(finished)
        .map(|(stage, finished)| {
            let outputs = finished.action.outputs.iter().map(|(port, o)| format!(" {port}={}", o.digest));
            format!(
                "stage {} use={} plugin={} key={}{}",
                stage.id,
                stage.plugin.name,
                stage.plugin.digest,
                finished.key,
                outputs.collect::<String>()
            )
        })
        .collect();
    lines.extend(wanted.iter().map(|(name, output)| format!("output {} {name}", output.digest)));
    lines.sort();
    format!("{HEADER}{}\n", lines.join("\n"))
}

/// Refuses anything but what the lock says.
pub(super) fn require(path: &Path, text: &str) -> Result<()> {
    let locked = read(path)?;
    if locked == text {
        return Ok(());
    }
    let changed = |old: &str, new: &str| {
        let new: Vec<&str> = new.lines().collect();
        old.lines().filter(|line| !new.contains(line)).map(str::to_owned).collect::<Vec<_>>()
    };
    let (gone, fresh) = (changed(&locked, text), changed(text, &locked));
    let finding =
        Diagnostic::error(format!("this build differs from {}; nothing was published", path.display()));
    let lines =
        gone.iter().map(|line| format!("- {line}")).chain(fresh.iter().map(|line| format!("+ {line}")));
    Err(Error::new(Class::Verification, finding.note(lines.collect::<Vec<_>>().join("\n")).hint(UNLOCK)))
}

/// Refuses other stages or plugins than the lock's, before any of them runs.
pub(super) fn require_plugins(path: &Path, plan: &Plan) -> Result<()> {
    let locked = read(path)?;
    let word = |line: &str, key: &str| line.split(' ').find_map(|w| w.strip_prefix(key)).map(str::to_owned);
    let of = |id: &str| {
        locked
            .lines()
            .find(|line| line.strip_prefix("stage ").is_some_and(|l| l.split(' ').next() == Some(id)))
    };
    for stage in &plan.stages {
        let now = stage.plugin.digest.to_string();
        let before = of(&stage.id).and_then(|line| word(line, "plugin="));
        if before.as_ref() != Some(&now) {
            let message = format!("stage `{}` is not as {} has it", stage.id, path.display());
            let finding = stage.use_node.error(message);
            let finding = finding.note(format!("plugin: {} → {now}", before.as_deref().unwrap_or("none")));
            return Err(Error::new(Class::Verification, finding.hint(UNLOCK)));
        }
    }
    Ok(())
}

const UNLOCK: &str = "build without --locked to accept the difference";

fn read(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).map_err(|e| {
        let finding = Diagnostic::error(format!("--locked needs {}: {e}", path.display()));
        Error::new(Class::Input, finding.hint("build once without --locked"))
    })
}

/// The keys that a lock names, by stage; lines that cannot be read are skipped.
pub(crate) fn keys_of(text: &str) -> BTreeMap<String, Digest> {
    let key = |line: &str| {
        let mut words = line.strip_prefix("stage ")?.split(' ');
        let stage = words.next()?;
        let key = words.find_map(|word| word.strip_prefix("key="))?;
        Some((stage.to_owned(), key.parse().ok()?))
    };
    text.lines().filter_map(key).collect()
}

/// The outputs that a lock names; lines that cannot be read are skipped.
pub(super) fn outputs_of(text: &str) -> BTreeMap<String, Digest> {
    let output = |line: &str| {
        let (digest, name) = line.strip_prefix("output ")?.split_once(' ')?;
        Some((name.to_owned(), digest.parse().ok()?)).filter(|_| !name.contains(['/', '\\']) && name != "..")
    };
    text.lines().filter_map(output).collect()
}
