//! Formatting, lints, features, and ARCHITECTURE.md held against the real crates and their edges.

use crate::checkout::{Checkout, Failure, run};
use crate::{features, plugins};
use std::collections::{BTreeMap, BTreeSet};

/// Crate names, each with those of our crates that it uses.
type Edges = BTreeMap<String, BTreeSet<String>>;

/// Everything that CI would complain of.
pub fn check(checkout: &Checkout) -> Result<(), Failure> {
    plugins::ensure_libraries(checkout)?;
    run(&mut checkout.cargo(&["fmt", "--all", "--check"]))?;
    run(&mut checkout.cargo(&[
        "clippy",
        "--release",
        "--workspace",
        "--all-targets",
        "--",
        "-D",
        "warnings",
    ]))?;
    features::check(checkout)?;
    check_architecture(checkout)
}

/// What a machine can put right by itself.
pub fn fix(checkout: &Checkout) -> Result<(), Failure> {
    run(&mut checkout.cargo(&["fmt", "--all"]))
}

/// ARCHITECTURE.md names every crate and none that is gone, each with the crates of ours that it really uses.
pub fn check_architecture(checkout: &Checkout) -> Result<(), Failure> {
    let path = checkout.path("ARCHITECTURE.md");
    let page = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let complaints = compare(&documented_edges(&page), &real_edges(checkout)?);
    if complaints.is_empty() {
        return Ok(());
    }
    Err(Failure::Message(format!("ARCHITECTURE.md is not true:\n  {}", complaints.join("\n  "))))
}

fn compare(documented: &Edges, real: &Edges) -> Vec<String> {
    let names: BTreeSet<&String> = documented.keys().chain(real.keys()).collect();
    let complaint = |name: &String| match (documented.get(name), real.get(name)) {
        (Some(said), Some(is)) if said == is => None,
        (Some(said), Some(is)) => Some(format!("`{name}` is said to use {said:?} but uses {is:?}")),
        (Some(_), None) => Some(format!("`{name}` is named but is no crate of the workspace")),
        (None, _) => Some(format!("`{name}` is a crate that no table row names")),
    };
    names.into_iter().filter_map(complaint).collect()
}

/// Table rows whose first cell is a crate in backticks and whose last cell lists what it uses, in backticks.
fn documented_edges(page: &str) -> Edges {
    let row = |line: &str| {
        let cells: Vec<&str> = line.strip_prefix('|')?.trim_end().strip_suffix('|')?.split('|').collect();
        let name = backticked(cells.first()?).into_iter().next()?;
        Some((name, backticked(cells.last()?).into_iter().collect()))
    };
    page.lines().filter_map(row).collect()
}

fn backticked(cell: &str) -> Vec<String> {
    cell.split('`').skip(1).step_by(2).map(str::to_string).collect()
}

/// Every package below the root, with the workspace packages among its plain dependencies.
fn real_edges(checkout: &Checkout) -> Result<Edges, String> {
    let mut manifests = Vec::new();
    for folder in ["", "plugins", "tests"] {
        let folder = checkout.path(folder);
        let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let found = entries.flatten().map(|entry| entry.path().join("Cargo.toml"));
        manifests.extend(found.filter_map(|path| std::fs::read_to_string(path).ok()));
    }
    let package = |text: &String| Some((package_name(text)?, used_crates(text)));
    let all: Vec<(String, BTreeSet<String>)> = manifests.iter().filter_map(package).collect();
    let names: BTreeSet<String> = all.iter().map(|(name, _)| name.clone()).collect();
    Ok(all.into_iter().map(|(name, used)| (name, used.intersection(&names).cloned().collect())).collect())
}

fn package_name(manifest: &str) -> Option<String> {
    let line = manifest.lines().find(|l| l.starts_with("name = "))?;
    Some(line.split('"').nth(1)?.to_string())
}

fn used_crates(manifest: &str) -> BTreeSet<String> {
    let lines =
        manifest.lines().skip_while(|l| *l != "[dependencies]").skip(1).take_while(|l| !l.starts_with('['));
    lines.filter_map(|l| l.split(['.', ' ', '=']).next()).map(str::to_string).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edges(pairs: &[(&str, &[&str])]) -> Edges {
        pairs.iter().map(|(a, b)| (a.to_string(), b.iter().map(|c| c.to_string()).collect())).collect()
    }

    #[test]
    fn rows_of_tables_are_read() {
        let page =
            "| crate | what | uses |\n|---|---|---|\n| `a` | the `x` | |\n| `b` | y | `a`, `c` |\nnot `d`\n";
        assert_eq!(documented_edges(page), edges(&[("a", &[]), ("b", &["a", "c"])]));
    }

    #[test]
    fn every_difference_is_named() {
        let real = edges(&[("a", &[]), ("b", &["a"]), ("c", &[])]);
        assert!(compare(&real, &real).is_empty());
        let documented = edges(&[("a", &["b"]), ("b", &["a"]), ("gone", &[])]);
        let complaints = compare(&documented, &real).join("\n");
        for name in ["`a` is said", "`c` is a crate that no", "`gone` is named but"] {
            assert!(complaints.contains(name), "{complaints}");
        }
    }
}
