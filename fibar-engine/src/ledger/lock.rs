//! `fibar.lock`: one sorted line per stage and per output, so that two of them merge and differ line by line.

use super::PublishedFile;
use crate::Digest;
use crate::build::Finished;
use crate::plan::Plan;
use std::collections::BTreeMap;

const HEADER: &str = "# fibar.lock 1, written by `fibar build`: what made what, by SHA-256\n";

/// The text of the file.
pub(super) fn text(plan: &Plan, finished: &[Finished], files: &[PublishedFile]) -> String {
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
    lines.extend(files.iter().map(|file| format!("output {} {}", file.digest, file.name)));
    lines.sort();
    format!("{HEADER}{}\n", lines.join("\n"))
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
