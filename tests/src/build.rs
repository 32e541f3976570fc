//! Real runs of the program in a folder of their own.

use crate::{checkout, executables};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A folder to build in, with a store of its own; both go when it is dropped.
pub struct Workshop {
    folder: tempfile::TempDir,
}

/// What a run of the program said.
#[derive(Debug)]
pub struct Outcome {
    /// Its exit code; −1 after a signal.
    pub code: i32,
    /// Its standard output.
    pub stdout: String,
    /// Its standard error.
    pub stderr: String,
}

/// What a build left for people to open.
pub struct Build {
    /// `build/NAME`.
    pub folder: PathBuf,
}

impl Default for Workshop {
    fn default() -> Self {
        Workshop { folder: tempfile::tempdir().expect("a temporary folder can be made") }
    }
}

impl Workshop {
    /// The folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Puts a file into the folder.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a file has a folder")).expect("folders can be made");
        std::fs::write(&path, bytes).expect("files can be written");
        path
    }

    /// Shows the checkout's profiles to recipes in the folder.
    pub fn link_profiles(&self) {
        let linked = std::os::unix::fs::symlink(checkout().join("profiles"), self.path().join("profiles"));
        linked.expect("links can be made");
    }

    /// The program, about to run here.
    pub fn program(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(executables().join("fibar"));
        command.args(arguments).current_dir(self.path()).env("FIBAR_STORE", self.path().join("store"));
        command
    }

    /// Runs the program to its end.
    pub fn run(&self, arguments: &[&str]) -> Outcome {
        Outcome::of(&mut self.program(arguments))
    }

    /// Builds one of the checkout's recipes, with further arguments.
    pub fn build(&self, recipe: &str, arguments: &[&str]) -> Outcome {
        let path = checkout().join(recipe);
        let path = path.to_str().expect("the checkout's path is text");
        self.run(&[&["build", path], arguments].concat())
    }

    /// What a build of the object of this name left.
    pub fn opened(&self, name: &str) -> Build {
        Build { folder: self.path().join("build").join(name) }
    }
}

impl Outcome {
    /// Runs a command to its end.
    pub fn of(command: &mut Command) -> Outcome {
        let output = command
            .output()
            .unwrap_or_else(|e| panic!("{command:?}: {e}; run the tests by cargo xtask test"));
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Outcome {
            code: output.status.code().unwrap_or(-1),
            stdout: text(&output.stdout),
            stderr: text(&output.stderr),
        }
    }

    /// Fails the test unless the run ended with this exit code.
    #[track_caller]
    pub fn expect(self, code: i32) -> Outcome {
        assert_eq!(self.code, code, "stdout:\n{}\nstderr:\n{}", self.stdout, self.stderr);
        self
    }

    /// Fails the test unless standard error holds every one of these.
    #[track_caller]
    pub fn says(self, parts: &[&str]) -> Outcome {
        for part in parts {
            assert!(self.stderr.contains(part), "{part:?} is missing in:\n{}", self.stderr);
        }
        self
    }
}

impl Build {
    /// Path of one of its files.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Bytes of one of its files.
    #[track_caller]
    pub fn read(&self, name: &str) -> Vec<u8> {
        let path = self.path(name);
        std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    }

    /// A metric's value.
    #[track_caller]
    pub fn metric(&self, name: &str) -> f64 {
        let metrics: Value =
            serde_json::from_slice(&self.read("metrics.json")).expect("metrics.json is JSON");
        metrics[name]["value"].as_f64().unwrap_or_else(|| panic!("no metric {name} in {metrics:#}"))
    }

    /// How many stages the build executed, by its own timings.
    #[track_caller]
    pub fn executed(&self) -> usize {
        let timings: Value =
            serde_json::from_slice(&self.read("timings.json")).expect("timings.json is JSON");
        let stages = timings["stages"].as_array().expect("timings.json lists the stages");
        stages.iter().filter(|stage| stage["result"] == "executed").count()
    }

    /// Names of its files, sorted.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let mut names: Vec<String> = entries.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}
