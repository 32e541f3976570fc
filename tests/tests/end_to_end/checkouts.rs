//! Plugins have the same bytes in every checkout, so that machines which share a store share what is in it.

use fibar_tests::{Outcome, checkout, executables, is_full};
use std::path::Path;
use std::process::Command;

/// In another folder, and one by one rather than all in one command.
#[test]
fn plugins_are_the_same_in_another_checkout() {
    if !is_full() {
        println!("skipped: this compiles every plugin once more; cargo xtask test --full");
        return;
    }
    let other = tempfile::tempdir().unwrap();
    copy(checkout(), other.path(), &[".git", "build", "target"]);
    copy(&checkout().join("target/manifold"), &other.path().join("target/manifold"), &[]);
    // cmake and libclang stay where they are.
    let tools = "target/opensubdiv/cargo.toml";
    std::fs::create_dir_all(other.path().join("target/opensubdiv")).unwrap();
    std::fs::copy(checkout().join(tools), other.path().join(tools)).unwrap();
    let mut differ = Vec::new();
    for entry in std::fs::read_dir(checkout().join("plugins")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let mut cargo = Command::new("cargo");
        cargo.args(["build", "--release", "--quiet", "--package", &name]);
        Outcome::of(cargo.current_dir(other.path()).env_remove("CARGO_TARGET_DIR")).expect(0);
        let there = std::fs::read(other.path().join("target/release").join(&name)).unwrap();
        if there != std::fs::read(executables().join(&name)).unwrap() {
            differ.push(name);
        }
    }
    assert!(differ.is_empty(), "{differ:?} have other bytes when compiled in {}", other.path().display());
}

/// Copies a folder, without some of its entries.
fn copy(from: &Path, to: &Path, without: &[&str]) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let target = to.join(entry.file_name());
        match entry.file_type().unwrap().is_dir() {
            _ if without.iter().any(|name| *name == entry.file_name()) => {}
            true => copy(&entry.path(), &target, &[]),
            false => drop(std::fs::copy(entry.path(), target).unwrap()),
        }
    }
}
