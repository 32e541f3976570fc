//! `include`: profiles of printers, materials and cameras whose values hold for every stage of a plugin unless the stage says
//! otherwise.
//!
//! ```toml
//! fibar = 1
//! [profile]
//! name = "polyjet"
//! [defaults.sweep-solids]
//! skin_mm = 0.4
//! ```
//!
//! A name without `.toml` is looked up in the `profiles` folders above the recipe; anything else is a path from the recipe. Of
//! several profiles the last wins, the stage's own value before all of them.

use super::{Entry, Node, NodeValue, Source};
use fibar_core::diagnostic::{Diagnostic, SourceText, did_you_mean};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Keys of a profile.
pub(super) const PROFILE_KEYS: [&str; 3] = ["fibar", "profile", "defaults"];

/// The profiles that a recipe includes, in order.
pub(super) fn profiles(root: &Node, findings: &mut Vec<Diagnostic>) -> Vec<Node> {
    let names: Vec<&Node> = match root.get("include").map(|node| (node, &node.value)) {
        None => Vec::new(),
        Some((node, NodeValue::String(_))) => vec![node],
        Some((_, NodeValue::Array(items))) => items.iter().collect(),
        Some((node, _)) => {
            findings.push(node.error("`include` lists profiles").hint("include = [\"polyjet\"]"));
            Vec::new()
        }
    };
    names.into_iter().filter_map(|name| profile(name, findings)).collect()
}

fn profile(name: &Node, findings: &mut Vec<Diagnostic>) -> Option<Node> {
    let Some(text) = name.as_str() else {
        findings.push(name.error("a profile is named by a text"));
        return None;
    };
    let path = find(text, &name.source.folder);
    let read = std::fs::read_to_string(&path);
    let Ok(text) = read.map_err(|e| findings.push(missing(name, text, &path, &e))) else { return None };
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let source = Arc::new(Source { text: SourceText::new(path.display().to_string(), text), folder });
    let (root, mut found) = Node::parse_file(&source);
    findings.append(&mut found);
    Some(root)
}

fn find(text: &str, folder: &Path) -> PathBuf {
    if text.ends_with(".toml") {
        return folder.join(text);
    }
    let file = format!("{text}.toml");
    // A recipe named by its file alone lies in the folder "", which has no absolute path.
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let above = std::path::absolute(here).unwrap_or(folder.to_owned());
    let candidates = above.ancestors().map(|folder| folder.join("profiles").join(&file));
    candidates.into_iter().find(|path| path.is_file()).unwrap_or(folder.join("profiles").join(file))
}

fn missing(name: &Node, text: &str, path: &Path, error: &std::io::Error) -> Diagnostic {
    let finding = name.error(format!("cannot read the profile {}: {error}", path.display()));
    let beside = path.parent().and_then(|folder| std::fs::read_dir(folder).ok());
    let names = beside.into_iter().flatten().flatten().map(|e| e.file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.filter_map(|n| n.strip_suffix(".toml").map(str::to_owned)).collect();
    names.sort();
    match did_you_mean(text, names.iter().map(String::as_str)) {
        Some(guess) => finding.hint(format!("did you mean \"{guess}\"?")),
        None => finding.note("profiles are found in `profiles` folders above the recipe, or by a path"),
    }
}

/// Puts the values of profiles into the table of a stage that does not have them.
pub(super) fn fill(stage: &mut Node, profiles: &[Node]) {
    let Some(plugin) = stage.get("use").and_then(Node::as_str).map(str::to_owned) else { return };
    let NodeValue::Table(entries) = &mut stage.value else { return };
    for profile in profiles.iter().rev() {
        let defaults = profile.get("defaults").and_then(|d| d.get(&plugin));
        for entry in defaults.map_or(&[][..], Node::entries) {
            if !entries.iter().any(|own: &Entry| own.key == entry.key) {
                entries.push(entry.clone());
            }
        }
    }
}
