//! Bytes that fuzzing found worth keeping, run through the readers again.

#![allow(clippy::unwrap_used, reason = "helpers of tests are tests")]

use fibar_tests::{checkout, fuzz};
use std::path::PathBuf;

/// Files of `tests/fuzz/seeds` by target.
fn seeds(target: &str) -> Vec<PathBuf> {
    let folder = checkout().join("tests/fuzz/seeds").join(target);
    let mut paths: Vec<PathBuf> = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    paths
}

#[test]
fn every_target_replays_its_corpus() {
    for (target, check) in fuzz::TARGETS {
        let paths = seeds(target);
        assert!(!paths.is_empty(), "{target} has no corpus");
        for path in paths {
            println!("{}", path.display());
            check(&std::fs::read(&path).unwrap());
        }
    }
}

#[test]
fn targets_and_folders_are_the_same() {
    let mut names: Vec<String> = fuzz::TARGETS.iter().map(|(name, _)| name.to_string()).collect();
    names.sort();
    let list = |folder: &str| {
        let entries = std::fs::read_dir(checkout().join("tests/fuzz").join(folder)).unwrap();
        let name = |e: std::fs::DirEntry| e.path().file_stem().unwrap().to_string_lossy().into_owned();
        let mut found: Vec<String> = entries.map(|e| name(e.unwrap())).collect();
        found.sort();
        found
    };
    assert_eq!(list("seeds"), names);
    assert_eq!(list("fuzz_targets"), names);
}
