//! Other people's readers, set up by `cargo xtask test`.

use crate::{Outcome, checkout};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A reader that is not ours.
pub enum Peer {
    /// A script of `tests/peers` in the Python environment with lib3mf and others.
    Python(&'static str),
    /// A script of `tests/peers` in the Python environment with OpenCV.
    Vision(&'static str),
    /// A script of `tests/peers` in the Python environment with Mitsuba.
    Optics(&'static str),
    /// A script of `tests/peers` in the Python environment with the menders of meshes, which only `test --full` and
    /// `bench repair` set up.
    Repair(&'static str),
    /// A script of `tests/peers` run by node, beside the npm packages.
    Node(&'static str),
}

impl Peer {
    /// Runs the peer, unless it could not be set up: then says so and gives nothing, or fails where `CI=true`.
    pub fn run(&self, arguments: &[&Path]) -> Option<Outcome> {
        let Some((program, script)) = self.find() else {
            let must = std::env::var("CI").is_ok_and(|ci| ci == "true");
            assert!(!must, "{} cannot run: the peers are not set up", self.script());
            println!("skipped: {} is not set up; cargo xtask test says why", self.script());
            return None;
        };
        Some(Outcome::of(Command::new(program).arg(script).args(arguments).env("FIBAR_PEERS", folder())))
    }

    fn script(&self) -> &'static str {
        match self {
            Peer::Python(script) | Peer::Vision(script) | Peer::Optics(script) => script,
            Peer::Repair(script) | Peer::Node(script) => script,
        }
    }

    fn find(&self) -> Option<(PathBuf, PathBuf)> {
        let script = checkout().join("tests/peers").join(self.script());
        let (program, stamp) = match self {
            Peer::Python(_) => (folder().join("python/bin/python"), "python.stamp"),
            Peer::Vision(_) => (folder().join("vision/bin/python"), "vision.stamp"),
            Peer::Optics(_) => (folder().join("optics/bin/python"), "optics.stamp"),
            Peer::Repair(_) => (folder().join("repair/bin/python"), "repair.stamp"),
            Peer::Node(_) => (PathBuf::from("node"), "npm.stamp"),
        };
        folder().join(stamp).exists().then_some((program, script))
    }
}

fn folder() -> PathBuf {
    std::env::var_os("FIBAR_PEERS").map_or_else(|| checkout().join("target/peers"), PathBuf::from)
}
