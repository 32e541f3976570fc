//! Elsewhere than on Linux there is no sandbox, and this says so.

use std::path::PathBuf;
use std::process::Command;

/// Where a stage would find its private folder.
pub const WORK: &str = "/stage";

/// Where a stage's plugin would lie.
pub const PLUGIN: &str = "/plugin";

/// What a stage would see.
#[derive(Debug, Default)]
pub struct View {
    /// Unused.
    pub scratch: PathBuf,
    /// Unused.
    pub work: Option<PathBuf>,
    /// Unused.
    pub read_only: Vec<(PathBuf, PathBuf)>,
}

/// Never.
pub fn available() -> Result<(), String> {
    Err("there is a sandbox on Linux only".into())
}

/// Never.
pub fn confine(_: &mut Command, _: &View) -> std::io::Result<()> {
    Err(std::io::Error::from(std::io::ErrorKind::Unsupported))
}
