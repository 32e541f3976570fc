//! What must hold of a store and a build folder at every moment, as other programs see them.

use fibar_tests::{Build, Outcome, Workshop};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Fails unless every blob of a workshop's store has the SHA-256 it is named by, as another program computes it, and every
/// action can be read and has its outputs. Says how many blobs there are.
#[track_caller]
pub fn check_store(shop: &Workshop) -> usize {
    let blobs = files(&shop.path().join("store/cas"));
    for (path, sum) in blobs.iter().zip(sha256(&blobs)) {
        assert!(path.ends_with(&sum), "{} has the SHA-256 {sum}", path.display());
    }
    let said = shop.run(&["cache", "verify"]).expect(0).stdout;
    for none in [" 0 damaged", " 0 unreadable", " 0 incomplete"] {
        assert!(said.contains(none), "{said}");
    }
    blobs.len()
}

/// Fails unless every file that the lock of a build names has the SHA-256 it says; folders are left to `--locked`. Says how
/// many there are.
#[track_caller]
pub fn check_published(build: &Build) -> usize {
    let lock = String::from_utf8(build.read("fibar.lock")).unwrap();
    let outputs = lock.lines().filter_map(|line| line.strip_prefix("output ")?.split_once(' '));
    let outputs = outputs.map(|(sum, name)| (sum, build.path(name)));
    let (sums, paths): (Vec<&str>, Vec<PathBuf>) = outputs.filter(|(_, path)| !path.is_dir()).unzip();
    assert_eq!(sha256(&paths), sums, "{paths:?}");
    assert!(!sums.is_empty(), "{lock}");
    sums.len()
}

/// How many finished actions a store has.
pub fn actions(shop: &Workshop) -> usize {
    files(&shop.path().join("store/actions")).len()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    std::fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path()).collect()
}

fn sha256(paths: &[PathBuf]) -> Vec<String> {
    if paths.is_empty() {
        return Vec::new();
    }
    let sums = Outcome::of(Command::new("sha256sum").args(paths)).expect(0).stdout;
    sums.lines().map(|line| line.split(' ').next().unwrap().to_owned()).collect()
}
