//! The checkout we stand in, and how programs are run from it.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Root folder of the workspace.
pub struct Checkout {
    /// Absolute path.
    pub root: PathBuf,
}

/// Why a task ended early.
pub enum Failure {
    /// A program has said what was wrong itself; its exit code is passed on.
    Exit(u8),
    /// What went wrong.
    Message(String),
}

impl From<String> for Failure {
    fn from(message: String) -> Self {
        Failure::Message(message)
    }
}

impl Checkout {
    /// The workspace that this program was compiled in.
    pub fn find() -> Result<Checkout, Failure> {
        let manifest = std::env::var_os("CARGO_MANIFEST_DIR").ok_or("run me as `cargo xtask`".to_string())?;
        let root = Path::new(&manifest).parent().ok_or("xtask has no parent folder".to_string())?;
        Ok(Checkout { root: root.to_path_buf() })
    }

    /// A path below the root.
    pub fn path(&self, relative: &str) -> PathBuf {
        self.root.join(relative)
    }

    /// `cargo` with these arguments, to be run at the root with the settings that all builds share.
    pub fn cargo(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
        command.current_dir(&self.root).args(arguments);
        for name in read_before(std::env::vars_os()) {
            command.env_remove(name);
        }
        command
    }

    /// The compiled program or plugin of this name.
    pub fn executable(&self, name: &str) -> PathBuf {
        self.target().join("release").join(format!("{name}{}", std::env::consts::EXE_SUFFIX))
    }

    /// Where cargo puts things.
    pub fn target(&self) -> PathBuf {
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| self.path("target"), PathBuf::from)
    }
}

/// Variables that the cargo above us read from `target/opensubdiv/cargo.toml`. That may have been written anew since, and the cargo
/// below would take them for the user's, which go first.
fn read_before(variables: impl Iterator<Item = (OsString, OsString)>) -> Vec<OsString> {
    let folder = ["target", "opensubdiv"].join(std::path::MAIN_SEPARATOR_STR);
    let ours = |value: &OsString| value.to_string_lossy().contains(&folder);
    variables.filter(|(_, value)| ours(value)).map(|(name, _)| name).collect()
}

/// Runs a command with our own terminal; a failure passes its exit code on.
pub fn run(command: &mut Command) -> Result<(), Failure> {
    let status =
        command.status().map_err(|e| format!("cannot run {}: {e}", command.get_program().display()))?;
    if status.success() { Ok(()) } else { Err(Failure::Exit(status.code().map_or(1, |c| c as u8))) }
}

/// Runs a command silently; a failure shows what it printed.
pub fn run_quietly(command: &mut Command) -> Result<String, String> {
    let program = command.get_program().display().to_string();
    let output = command.output().map_err(|e| format!("cannot run {program}: {e}"))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if output.status.success() {
        return Ok(text(&output.stdout));
    }
    Err(format!("{program} failed ({}):\n{}{}", output.status, text(&output.stdout), text(&output.stderr)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_of_a_folder_that_moved_are_forgotten() {
        let check = |value: &str, forgotten: bool| {
            let variables = [("CMAKE".into(), value.into())];
            assert_eq!(read_before(variables.into_iter()).len(), usize::from(forgotten), "{value}");
        };
        check("/home/me/old/target/opensubdiv/cmake-4/bin/cmake", true);
        check("/usr/bin/cmake", false);
    }
}
