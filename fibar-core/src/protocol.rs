//! What host and plugin say to each other: JSON Lines over stdio, data by path.
//!
//! A session is short: both sides say `hello`, then the host either asks to `describe` or to `run`. While a run lasts
//! the plugin reports `progress`, `log`, `metric` and `violation`, answers `ping`, and ends with `done` or `error`.
//! Here are only the messages; who starts processes, reads pipes and checks files is the engine's business.
//!
//! Within a version an unknown field is an error, except in [`Hello`], which stays readable for ever.

mod description;
mod failure;

pub use description::{Arity, Description, Environment, InputPort, OutputPort, Resources};
pub use failure::{Failure, FailureKind};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// The version both sides must share; it changes only when a message changes its meaning.
pub const PROTOCOL_VERSION: u32 = 1;

/// The argument that makes a plugin speak the protocol on its standard input and output.
pub const STDIO_FLAG: &str = "--fibar-stdio";

/// The largest seed that survives a trip through JSON numbers, 2^53 − 1.
pub const MAX_SEED: u64 = (1 << 53) - 1;

/// The `format` of a schema string that names a file: the host resolves, hashes and hands it in.
pub const FILE_FORMAT: &str = "fibar-file";

/// What the host says to a plugin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum HostMessage {
    /// The first line of a session.
    Hello(Hello),
    /// Asks for the [`Description`].
    Describe {},
    /// Starts the one run of this session.
    Run(Request),
    /// Asks the run to stop; a plugin that has not ended two seconds later is killed.
    Cancel {},
    /// Asks for a sign of life, answered by [`PluginMessage::Pong`].
    Ping {
        /// Comes back in the answer.
        id: u64,
    },
}

/// What a plugin says to the host.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum PluginMessage {
    /// The first line of a session.
    Hello(Hello),
    /// The answer to `describe`.
    Description(Box<Description>),
    /// How far the run is.
    Progress(Progress),
    /// A line for the log of the stage.
    Log(LogLine),
    /// A number for `metrics.json`.
    Metric(Metric),
    /// A rule that the checked artefact breaks.
    Violation(Violation),
    /// The answer to `ping`.
    Pong(Pong),
    /// The run ended well.
    Done(Done),
    /// The run ended badly.
    Error(Failure),
}

/// The first message each way. Fields unknown to the reader are skipped, so that any two versions can at least
/// tell each other which version they are.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// The sender's [`PROTOCOL_VERSION`].
    pub protocol: u32,
    /// Who speaks, e.g. `fibar 0.1.0` or `route-fibar 0.1.0`.
    pub name: String,
    /// Optional abilities beyond the version; none are defined yet.
    #[serde(default)]
    pub features: Vec<String>,
}

impl Hello {
    /// A hello in the version of this library.
    pub fn new(name: impl Into<String>) -> Hello {
        Hello { protocol: PROTOCOL_VERSION, name: name.into(), features: Vec::new() }
    }
}

/// One run: everything a stage gets to know. A plugin never sees the recipe.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Complete, validated parameters; a file parameter holds the path of its read-only copy.
    #[serde(default)]
    pub params: Value,
    /// The artefacts of each input port, in recipe order; a port of arity one has exactly one.
    #[serde(default)]
    pub inputs: BTreeMap<String, Vec<InputArtefact>>,
    /// An empty folder; outputs are written here and nowhere else.
    pub out_dir: String,
    /// For seeded generators; at most [`MAX_SEED`].
    #[serde(default)]
    pub seed: u64,
    /// How many threads the stage may keep busy; never changes a byte of the outputs.
    #[serde(default = "one_thread")]
    pub threads: u32,
    /// How much memory the stage should stay under, in bytes; 0 when nobody said.
    #[serde(default)]
    pub memory_bytes: u64,
    /// The interpreter of the environment that the description names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub python: Option<String>,
}

fn one_thread() -> u32 {
    1
}

/// One input: a read-only file or folder.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputArtefact {
    /// Where it lies.
    pub path: String,
    /// The SHA-256 of its bytes (of its listing, for a folder) in hexadecimal; empty in a request written by hand.
    #[serde(default)]
    pub digest: String,
}

/// How far a run is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Progress {
    /// From 0 to 1 over the whole run.
    pub fraction: f64,
    /// What is being done, one or two words.
    pub phase: String,
}

/// A line for the log of the stage.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LogLine {
    /// `error`, `warn`, `info` or `debug`.
    pub level: String,
    /// One line of text.
    pub message: String,
}

/// A number for `metrics.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Metric {
    /// Dotted, e.g. `place.markers`; unique in a build.
    pub name: String,
    /// Finite.
    pub value: f64,
    /// `1` for counts and ratios, else `mm`, `mm3`, …
    pub unit: String,
    /// The place the number was found at, in the body's frame, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place_mm: Option<[f64; 3]>,
}

/// A rule that the checked artefact breaks. The build keeps its outputs, marked UNVERIFIED, unless the recipe allows
/// the rule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Violation {
    /// The name of the rule, e.g. `clearance.gap`; what `allow = [..]` names.
    pub rule: String,
    /// What is wrong, with numbers and units.
    pub message: String,
    /// Where, in the body's frame, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place_mm: Option<[f64; 3]>,
}

/// The answer to a ping.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pong {
    /// The number in the ping.
    pub id: u64,
}

/// The run ended well and these are its outputs; the host hashes, checks and publishes them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Done {
    /// Output port → name of a file or folder directly inside `out_dir`. A published output appears in the build
    /// folder under this name.
    pub outputs: BTreeMap<String, String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(line: &str, expected: PluginMessage) {
        let message: PluginMessage = serde_json::from_str(line).unwrap();
        assert_eq!(message, expected);
        let again = serde_json::to_string(&message).unwrap();
        assert_eq!(serde_json::from_str::<PluginMessage>(&again).unwrap(), message, "{again}");
    }

    #[track_caller]
    fn check_refused(line: &str, part: &str) {
        let error = serde_json::from_str::<PluginMessage>(line).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }

    #[test]
    fn messages_read_back() {
        check(r#"{"type":"pong","id":3}"#, PluginMessage::Pong(Pong { id: 3 }));
        let progress = Progress { fraction: 0.5, phase: "rays".into() };
        check(r#"{"type":"progress","fraction":0.5,"phase":"rays"}"#, PluginMessage::Progress(progress));
        let failure = Failure::new(FailureKind::Input, "mesh is empty");
        check(r#"{"type":"error","kind":"input","message":"mesh is empty"}"#, PluginMessage::Error(failure));
        let metric = Metric { name: "a.b".into(), value: 65.0, unit: "1".into(), place_mm: None };
        check(r#"{"type":"metric","name":"a.b","value":65,"unit":"1"}"#, PluginMessage::Metric(metric));
    }

    #[test]
    fn hello_of_the_future_is_readable() {
        let hello = Hello { protocol: 99, name: "x 7".into(), features: vec![] };
        check(
            r#"{"type":"hello","protocol":99,"name":"x 7","dialect":"klingon"}"#,
            PluginMessage::Hello(hello),
        );
    }

    #[test]
    fn unknown_fields_are_errors() {
        check_refused(r#"{"type":"pong","id":3,"x":1}"#, "unknown field `x`");
        check_refused(r#"{"type":"progress","fraction":0.5}"#, "missing field `phase`");
        check_refused(r#"{"type":"dance"}"#, "unknown variant `dance`");
    }

    #[test]
    fn requests_can_be_written_by_hand() {
        let request: Request = serde_json::from_str(r#"{"out_dir":"out"}"#).unwrap();
        assert_eq!((request.seed, request.threads, request.inputs.len()), (0, 1, 0));
    }
}
