//! Says what to run where OpenSubdiv cannot be compiled, before its own build script fails for want of cmake.

use std::env;
use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    ["CMAKE", "LIBCLANG_PATH", "PATH"].iter().for_each(|name| println!("cargo::rerun-if-env-changed={name}"));
    if !has_cmake() || !has_libclang() {
        println!(
            "cargo::error=OpenSubdiv needs cmake and libclang. Run `cargo xtask setup` (or any `cargo xtask build …` of a \
             recipe that subdivides), which fetches them, or install both (apt-get install cmake libclang-dev) and set \
             LIBCLANG_PATH to the folder with libclang."
        );
        std::process::exit(1);
    }
}

fn has_cmake() -> bool {
    let cmake = env::var_os("CMAKE").unwrap_or("cmake".into());
    Command::new(cmake).arg("--version").output().is_ok_and(|output| output.status.success())
}

/// As bindgen looks for it: where the environment says, or by llvm-config.
fn has_libclang() -> bool {
    let given = env::var_os("LIBCLANG_PATH").is_some_and(|path| Path::new(&path).exists());
    given || Command::new("llvm-config").arg("--version").output().is_ok_and(|output| output.status.success())
}
