//! Features of other people's crates, which must not depend on what is compiled in one command.
//!
//! Cargo unites the features of all packages that are selected. A plugin compiled for one recipe would then have other
//! bytes than the same plugin compiled for another, so another digest, and share nothing in a store. `workspace-hack`
//! switches on for all what differs between some; here it is held against what Cargo resolves.

use crate::checkout::{Checkout, Failure, run_quietly};
use std::collections::{BTreeMap, BTreeSet};

/// Sets of features by package with version; a package can have several, for the stages and for build scripts and macros.
type Features = BTreeMap<String, BTreeSet<String>>;

/// Fails if a plugin alone is compiled with other features than together with everything else, tests included.
pub fn check(checkout: &Checkout) -> Result<(), Failure> {
    let mut complaints = BTreeMap::new();
    // What is linked into a stage, then that and what makes it: a crate can have other features in each.
    for (read, own, all) in [
        (read_linked as fn(&str) -> Features, "normal", "normal,dev"),
        (read_tree, "normal,build", "normal,build,dev"),
    ] {
        let together = read(&resolve(checkout, &["--workspace", "--edges", all])?);
        for plugin in plugins(checkout)? {
            let alone = read(&resolve(checkout, &["--package", &plugin, "--edges", own])?);
            complaints.extend(complain(&plugin, &alone, &together));
        }
    }
    if complaints.is_empty() {
        return Ok(());
    }
    let complaints: Vec<String> = complaints.into_values().collect();
    Err(Failure::Message(format!(
        "digests of plugins would depend on what is compiled with them; name in workspace-hack/Cargo.toml:\n  {}",
        complaints.join("\n  ")
    )))
}

fn plugins(checkout: &Checkout) -> Result<Vec<String>, String> {
    let folder = checkout.path("plugins");
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut names: Vec<String> = entries.flatten().map(|e| e.file_name().to_string_lossy().into()).collect();
    names.sort();
    Ok(names)
}

/// What Cargo makes of a selection of packages: lines of depth, package and features.
fn resolve(checkout: &Checkout, selection: &[&str]) -> Result<String, String> {
    let mut tree = checkout.cargo(&["tree", "--no-dedupe", "--prefix", "depth", "--format", "|{p}|{f}"]);
    run_quietly(tree.args(selection))
}

/// All packages of a tree.
fn read_tree(text: &str) -> Features {
    let mut features = Features::new();
    for (_, package, enabled) in text.lines().filter_map(read_line) {
        let package = package.split(' ').take(2).collect::<Vec<_>>().join(" ");
        features.entry(package).or_default().insert(enabled.to_owned());
    }
    features
}

/// The packages of a tree that are not there for the sake of a macro.
fn read_linked(text: &str) -> Features {
    let mut macro_depth = None;
    let is_linked = |line: &&str| {
        let Some((depth, package, _)) = read_line(line) else { return false };
        if macro_depth.is_some_and(|above| depth > above) {
            return false;
        }
        macro_depth = package.contains("(proc-macro)").then_some(depth);
        macro_depth.is_none()
    };
    let linked: Vec<&str> = text.lines().filter(is_linked).collect();
    read_tree(&linked.join("\n"))
}

fn read_line(line: &str) -> Option<(usize, &str, &str)> {
    let (depth, rest) = line.split_once('|')?;
    let (package, features) = rest.rsplit_once('|')?;
    Some((depth.parse().ok()?, package, features))
}

/// What a plugin alone has otherwise, by package.
fn complain(plugin: &str, alone: &Features, together: &Features) -> Vec<(String, String)> {
    let complaint = |(package, sets): (&String, &BTreeSet<String>)| {
        let odd = sets.iter().find(|set| !together.get(package).is_some_and(|all| all.contains(*set)))?;
        let all = together.get(package).into_iter().flatten().cloned().collect::<Vec<_>>().join("] or [");
        Some((package.clone(), format!("{package} with [{all}]: {plugin} alone has it with [{odd}]")))
    };
    alone.iter().filter_map(complaint).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_features_are_named() {
        let together = read_tree("0|a v1 (/x)|std\n1|a v1|\n1|b v2|std,derive\n\n");
        let check = |alone: &str, expected: &[&str]| {
            let found: Vec<String> =
                complain("p", &read_tree(alone), &together).into_iter().map(|(name, _)| name).collect();
            assert_eq!(found, expected, "{alone}");
        };
        check("0|a v1|std\n1|b v2|std,derive", &[]);
        check("0|a v1|\n", &[]);
        check("0|a v1|std\n1|b v2|std", &["b v2"]);
        check("0|a v1|derive\n1|c v1|", &["a v1", "c v1"]);
    }

    #[test]
    fn what_a_macro_needs_is_not_linked() {
        let tree = "0|a v1|\n1|m v1 (proc-macro)|\n2|s v1|full\n3|t v1|\n1|s v1|std\n";
        assert_eq!(read_linked(tree), read_tree("0|a v1|\n1|s v1|std"));
    }
}
