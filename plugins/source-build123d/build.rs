//! Puts the lock file of the Python environment beside the executable, where the host looks for it.

use std::path::{Path, PathBuf};

fn main() -> std::io::Result<()> {
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    // OUT_DIR is PROFILE/build/PACKAGE-HASH/out.
    let profile = out.ancestors().nth(3).expect("OUT_DIR lies three folders below the executables");
    let beside = profile.join("source-build123d.requirements.txt");
    let lock = Path::new("python/requirements.txt");
    println!("cargo::rerun-if-changed={}", lock.display());
    println!("cargo::rerun-if-changed={}", beside.display());
    std::fs::copy(lock, beside).map(drop)
}
