//! What a build tells while it runs.

use super::Left;
use crate::Digest;
use fibar_core::protocol::PluginMessage;

/// Somebody who wants to know; called from several threads.
pub trait Observer: Sync {
    /// Something happened.
    fn event(&self, event: &Event<'_>);
}

/// Nobody.
pub struct Silent;

impl Observer for Silent {
    fn event(&self, _: &Event<'_>) {}
}

/// A stage of a build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct StageName<'a> {
    /// The object.
    pub build: &'a str,
    /// The stage.
    pub stage: &'a str,
}

/// Something that happened.
#[derive(Debug)]
pub enum Event<'a> {
    /// Stages are about to run or be found.
    Planned {
        /// How many.
        stages: usize,
    },
    /// How much is left, whenever stages have started.
    Left(Left),
    /// A stage starts.
    Started {
        /// Which.
        stage: StageName<'a>,
        /// On so many cores.
        cores: u32,
    },
    /// A running stage says something: progress or a log line.
    Said {
        /// Which.
        stage: StageName<'a>,
        /// What.
        message: &'a PluginMessage,
    },
    /// A stage is finished.
    Finished {
        /// Which.
        stage: StageName<'a>,
        /// How it came to its result.
        outcome: Outcome,
        /// How long that took, s.
        seconds: f64,
    },
    /// A stage failed; the error follows at the end of the build.
    Failed {
        /// Which.
        stage: StageName<'a>,
    },
    /// Something people should know that concerns no stage alone.
    Note {
        /// One line.
        text: &'a str,
    },
    /// An artefact was found damaged and is being rebuilt.
    Rebuilding {
        /// Which.
        digest: Digest,
    },
}

/// How a stage came to its result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// It ran.
    Executed,
    /// The store had it.
    Hit,
    /// Another stage or process ran the same action meanwhile.
    Shared,
}

impl Outcome {
    /// One word for tables and `timings.json`.
    pub fn word(self) -> &'static str {
        match self {
            Outcome::Executed => "executed",
            Outcome::Hit => "hit",
            Outcome::Shared => "shared",
        }
    }
}
