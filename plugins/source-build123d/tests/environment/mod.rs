//! The Python environment of the tests: made once below `target/tmp`, as the host makes one for builds.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The interpreter of the environment, or why there is none.
pub fn ensure() -> Result<String, String> {
    let home = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let lock = Path::new(env!("CARGO_MANIFEST_DIR")).join("python/requirements.txt");
    let wanted = std::fs::read(&lock).map_err(|e| e.to_string())?;
    let alone = File::create(home.join("build123d.lock")).map_err(|e| e.to_string())?;
    alone.lock().map_err(|e| e.to_string())?;
    let (folder, stamp) = (home.join("build123d"), home.join("build123d.stamp"));
    let python = folder.join("bin/python");
    if !std::fs::read(&stamp).is_ok_and(|done| done == wanted) {
        make(&folder, &python, &lock)?;
        std::fs::write(&stamp, wanted).map_err(|e| e.to_string())?;
    }
    Ok(python.to_string_lossy().into_owned())
}

fn make(folder: &Path, python: &PathBuf, lock: &Path) -> Result<(), String> {
    run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(folder))?;
    let install =
        ["-m", "pip", "install", "--quiet", "--require-hashes", "--no-deps", "--only-binary", ":all:", "-r"];
    run(Command::new(python).args(install).arg(lock))
}

fn run(command: &mut Command) -> Result<(), String> {
    let output = command.output().map_err(|e| format!("{}: {e}", command.get_program().display()))?;
    if output.status.success() { Ok(()) } else { Err(String::from_utf8_lossy(&output.stderr).into_owned()) }
}
