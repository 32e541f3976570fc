//! How a stage says that it cannot do its work.

use fibar_core::protocol::{Failure, FailureKind};

/// The end of a run that failed: whose fault, what, where, and what to try.
#[derive(Debug, Clone, PartialEq)]
pub struct StageError {
    pub(crate) failure: Failure,
}

impl StageError {
    /// A parameter asks for something impossible; name it with [`StageError::param`].
    pub fn user(message: impl Into<String>) -> StageError {
        StageError::new(FailureKind::User, message)
    }

    /// An input breaks its promises or cannot be worked with.
    pub fn input(message: impl Into<String>) -> StageError {
        StageError::new(FailureKind::Input, message)
    }

    /// The stage itself is at fault.
    pub fn internal(message: impl Into<String>) -> StageError {
        StageError::new(FailureKind::Internal, message)
    }

    /// Memory, disk or time ran out.
    pub fn resource(message: impl Into<String>) -> StageError {
        StageError::new(FailureKind::Resource, message)
    }

    /// The host asked to stop; comes out of [`crate::Job::progress`].
    pub fn cancelled() -> StageError {
        StageError::new(FailureKind::Cancelled, "cancelled")
    }

    fn new(kind: FailureKind, message: impl Into<String>) -> StageError {
        StageError { failure: Failure::new(kind, message) }
    }

    /// The same, with what to try.
    pub fn hint(mut self, hint: impl Into<String>) -> StageError {
        self.failure.hint = Some(hint.into());
        self
    }

    /// The same, with something else to try before what it says already.
    pub fn hint_first(self, hint: &str) -> StageError {
        let hint = match &self.failure.hint {
            Some(already) => format!("{hint}; else {already}"),
            None => hint.to_owned(),
        };
        self.hint(hint)
    }

    /// The same, blaming a parameter by JSON pointer, e.g. `/spacing_mm` or `/fit_mm/0`.
    pub fn param(mut self, pointer: impl Into<String>) -> StageError {
        self.failure.param = Some(pointer.into());
        self
    }

    /// The same, at a place in the body's frame, mm.
    pub fn place_mm(mut self, place: [f64; 3]) -> StageError {
        self.failure.place_mm = Some(place);
        self
    }
}

impl std::fmt::Display for StageError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.failure.message)
    }
}

impl std::error::Error for StageError {}

impl From<std::io::Error> for StageError {
    fn from(error: std::io::Error) -> StageError {
        match error.kind() {
            std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => {
                StageError::resource(format!("the disk is full ({error})"))
                    .hint("free some space and build again")
            }
            std::io::ErrorKind::OutOfMemory => StageError::resource(error.to_string()),
            _ => StageError::internal(error.to_string()),
        }
    }
}

impl From<fibar_core::artefact::ArtefactError> for StageError {
    fn from(error: fibar_core::artefact::ArtefactError) -> StageError {
        StageError::input(error.to_string())
    }
}

impl From<fibar_core::code_set::CodeSetError> for StageError {
    /// Blames the parameter of the same name as the plan's field, or the sockets.
    fn from(error: fibar_core::code_set::CodeSetError) -> StageError {
        match error.field {
            Some(field) => StageError::user(error.message).param(format!("/{field}")),
            None => StageError::input(error.message),
        }
        .hint(error.hint)
    }
}
