//! Features of other people's crates, which must not depend on what is compiled in one command.
//!
//! Cargo unites the features of all packages that are selected. A plugin compiled for one recipe would then have other
//! bytes than the same plugin compiled for another, so another digest, and share nothing in a store. `workspace-hack`
//! switches on for all what differs between some; here it is held against what Cargo resolves.

use crate::checkout::{Checkout, Failure, run_quietly};
use std::collections::{BTreeMap, BTreeSet};

/// Sets of features by package with version; a package can be there twice, for the target and for build scripts.
type Features = BTreeMap<String, BTreeSet<String>>;

/// Fails if a plugin alone is compiled with other features than together with everything else, tests included.
pub fn check(checkout: &Checkout) -> Result<(), Failure> {
    let together = resolve(checkout, &["--workspace", "--edges", "normal,build,dev"])?;
    let mut complaints = BTreeMap::new();
    for plugin in plugins(checkout)? {
        let alone = resolve(checkout, &["--package", &plugin, "--edges", "normal,build"])?;
        complaints.extend(complain(&plugin, &alone, &together));
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

/// What Cargo makes of a selection of packages.
fn resolve(checkout: &Checkout, selection: &[&str]) -> Result<Features, String> {
    let mut tree = checkout.cargo(&["tree", "--no-dedupe", "--prefix", "none", "--format", "{p}|{f}"]);
    Ok(read_tree(&run_quietly(tree.args(selection))?))
}

fn read_tree(text: &str) -> Features {
    let mut features = Features::new();
    for (package, enabled) in text.lines().filter_map(|line| line.rsplit_once('|')) {
        let package = package.split(' ').take(2).collect::<Vec<_>>().join(" ");
        features.entry(package).or_default().insert(enabled.to_owned());
    }
    features
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
        let together = read_tree("a v1 (/x)|std\na v1|\nb v2|std,derive\n\n[dev-dependencies]\n");
        let check = |alone: &str, expected: &[&str]| {
            let found: Vec<String> =
                complain("p", &read_tree(alone), &together).into_iter().map(|(name, _)| name).collect();
            assert_eq!(found, expected, "{alone}");
        };
        check("a v1|std\nb v2|std,derive", &[]);
        check("a v1|\n", &[]);
        check("a v1|std\nb v2|std", &["b v2"]);
        check("a v1|derive\nc v1|", &["a v1", "c v1"]);
    }
}
