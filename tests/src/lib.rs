//! What end-to-end tests share: the compiled program, real builds of recipes, other people's readers.
//!
//! `cargo xtask test` compiles the program and all plugins first and sets `FIBAR_BIN` to their folder and `FIBAR_PEERS` to
//! that of the peers.

pub mod broken;
mod build;
pub mod fuzz;
pub mod judge;
mod peer;

pub use build::{Build, Outcome, Workshop};
pub use peer::Peer;

use std::path::{Path, PathBuf};

/// The checkout.
pub fn checkout() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the tests live one folder below the root")
}

/// Folder of the compiled program and plugins.
pub fn executables() -> PathBuf {
    std::env::var_os("FIBAR_BIN").map_or_else(|| checkout().join("target/release"), PathBuf::from)
}

/// Whether slow tests run too: `cargo xtask test --full`.
pub fn is_full() -> bool {
    std::env::var_os("FIBAR_TEST_FULL").is_some()
}
