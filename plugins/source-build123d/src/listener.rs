//! Who listens while a child process runs: the host of a stage, or a terminal.

use fibar_plugin::{Job, StageError};

/// Takes lines from a child and may ask it to stop.
pub trait Listener {
    /// A line for people.
    fn say(&mut self, line: &str);

    /// An error when the child should stop.
    fn check_cancel(&mut self) -> Result<(), StageError>;
}

impl Listener for Job {
    fn say(&mut self, line: &str) {
        self.log("info", line);
    }

    fn check_cancel(&mut self) -> Result<(), StageError> {
        Job::check_cancel(self)
    }
}

/// A person at a terminal; Ctrl-C ends this process, and its child sees that.
pub struct Terminal;

impl Listener for Terminal {
    fn say(&mut self, line: &str) {
        eprintln!("{line}");
    }

    fn check_cancel(&mut self) -> Result<(), StageError> {
        Ok(())
    }
}
