//! Other people's programs, which check ours: lib3mf, PrusaSlicer, the glTF validator, OpenCV, Mitsuba.
//!
//! Each is set up once below `target/peers`. Where one cannot be had the tests that need it are skipped, and say why;
//! with `CI=true` that is a failure.

use crate::checkout::{Checkout, Failure, run_quietly};
use std::path::Path;
use std::process::Command;

/// Sets up every peer. The folder that the tests find them in comes back.
pub fn ensure(checkout: &Checkout) -> Result<std::path::PathBuf, Failure> {
    let folder = checkout.target().join("peers");
    std::fs::create_dir_all(&folder).map_err(|e| format!("cannot make {}: {e}", folder.display()))?;
    let must = std::env::var("CI").is_ok_and(|ci| ci == "true");
    for (name, result) in [
        ("lib3mf from PyPI", ensure_python(checkout, &folder, "python", "requirements.txt")),
        ("OpenCV from PyPI", ensure_python(checkout, &folder, "vision", "requirements-vision.txt")),
        ("Mitsuba from PyPI", ensure_python(checkout, &folder, "optics", "requirements-optics.txt")),
        ("gltf-validator from npm", ensure_npm(checkout, &folder)),
        ("prusa-slicer from Debian", ensure_prusa_slicer()),
    ] {
        match result {
            Err(why) if must => return Err(Failure::Message(format!("{name} cannot be set up: {why}"))),
            Err(why) => eprintln!("xtask: {name} cannot be set up, tests that need it are skipped: {why}"),
            Ok(()) => {}
        }
    }
    Ok(folder)
}

/// A virtual environment of this name with the hash-pinned packages of a list in `tests/peers`.
fn ensure_python(checkout: &Checkout, folder: &Path, name: &str, list: &str) -> Result<(), String> {
    let requirements = checkout.path("tests/peers").join(list);
    once(&folder.join(format!("{name}.stamp")), &requirements, || {
        let environment = folder.join(name);
        eprintln!("xtask: setting up {} (once)", environment.display());
        run_quietly(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&environment))?;
        let mut pip = Command::new(environment.join("bin/python"));
        pip.args([
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
            "--require-hashes",
            "-r",
        ]);
        run_quietly(pip.arg(&requirements)).map(drop)
    })
}

/// The npm packages of `tests/peers/package-lock.json`.
fn ensure_npm(checkout: &Checkout, folder: &Path) -> Result<(), String> {
    let lock = checkout.path("tests/peers/package-lock.json");
    once(&folder.join("npm.stamp"), &lock, || {
        eprintln!("xtask: setting up {} (once)", folder.join("node_modules").display());
        for name in ["package.json", "package-lock.json"] {
            let from = checkout.path("tests/peers").join(name);
            std::fs::copy(&from, folder.join(name)).map_err(|e| format!("{}: {e}", from.display()))?;
        }
        run_quietly(
            Command::new("npm").args(["ci", "--silent", "--no-audit", "--no-fund"]).current_dir(folder),
        )
        .map(drop)
    })
}

/// PrusaSlicer, from Debian where we may install it.
fn ensure_prusa_slicer() -> Result<(), String> {
    if run_quietly(Command::new("prusa-slicer").arg("--help")).is_ok() {
        return Ok(());
    }
    let root = run_quietly(Command::new("id").arg("-u")).is_ok_and(|id| id.trim() == "0");
    if !root {
        return Err("not installed; try: sudo apt-get install --no-install-recommends prusa-slicer".into());
    }
    eprintln!("xtask: installing prusa-slicer (once)");
    run_quietly(Command::new("apt-get").args(["update", "-qq"]))?;
    let install = ["install", "-y", "-qq", "--no-install-recommends", "prusa-slicer"];
    run_quietly(Command::new("apt-get").args(install).env("DEBIAN_FRONTEND", "noninteractive")).map(drop)
}

/// Does the work unless the stamp already holds what `source` holds.
fn once(stamp: &Path, source: &Path, work: impl FnOnce() -> Result<(), String>) -> Result<(), String> {
    let wanted = std::fs::read(source).map_err(|e| format!("{}: {e}", source.display()))?;
    if std::fs::read(stamp).is_ok_and(|done| done == wanted) {
        return Ok(());
    }
    work()?;
    std::fs::write(stamp, wanted).map_err(|e| format!("{}: {e}", stamp.display()))
}
