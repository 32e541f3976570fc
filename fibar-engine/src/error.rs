//! How a command fails: findings for people and an exit code for scripts.

use fibar_core::diagnostic::Diagnostic;
use std::path::Path;

/// Why a command failed; the numbers are the exit codes of `fibar`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Class {
    /// A verification rule is broken.
    Verification = 1,
    /// The recipe or the command line is wrong.
    Recipe = 2,
    /// A file or artefact is missing or unusable.
    Input = 3,
    /// Disk, memory or time ran out.
    Resource = 4,
    /// A plugin is at fault.
    Plugin = 5,
    /// The user stopped it.
    Cancelled = 130,
}

/// One or more findings that end a command.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{}", self.render())]
pub struct Error {
    /// The gravest kind among the findings.
    pub class: Class,
    /// What to show, in order.
    pub findings: Vec<Diagnostic>,
}

/// Short for results of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// One finding.
    pub fn new(class: Class, finding: Diagnostic) -> Error {
        Error { class, findings: vec![finding] }
    }

    /// A file operation that failed, with what was being done.
    pub fn io(doing: &str, path: &Path, error: &std::io::Error) -> Error {
        use std::io::ErrorKind::{OutOfMemory, QuotaExceeded, ReadOnlyFilesystem, StorageFull};
        let finding = Diagnostic::error(format!("cannot {doing} {}: {error}", path.display()));
        match error.kind() {
            StorageFull | QuotaExceeded => Error::new(
                Class::Resource,
                finding.hint("free some space and run the same command again; finished stages are kept").hint(
                    "`fibar cache gc --max-size 1G` shrinks the store; FIBAR_STORE puts it on another disk",
                ),
            ),
            OutOfMemory | ReadOnlyFilesystem => Error::new(Class::Resource, finding),
            _ => Error::new(Class::Input, finding),
        }
    }

    /// All findings as text, one after the other.
    pub fn render(&self) -> String {
        let findings: Vec<String> = self.findings.iter().map(Diagnostic::render).collect();
        findings.join("\n\n")
    }
}

/// Each finding once: variants of a recipe repeat each other's mistakes.
pub(crate) fn distinct(findings: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let mut kept: Vec<Diagnostic> = Vec::new();
    for finding in findings {
        if !kept.contains(&finding) {
            kept.push(finding);
        }
    }
    kept
}

/// Attaches what was being done, and to which path, to an I/O result.
pub(crate) trait IoContext<T> {
    /// `cannot {doing} {path}: …`
    fn context(self, doing: &str, path: &Path) -> Result<T>;
}

impl<T> IoContext<T> for std::io::Result<T> {
    fn context(self, doing: &str, path: &Path) -> Result<T> {
        self.map_err(|e| Error::io(doing, path, &e))
    }
}
