//! What a plugin says about itself: parameters, ports, determinism, resources.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A plugin's answer to `describe`. The host caches it by the digest of the executable.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// The plugin's name: its executable and what a recipe's `use` says.
    pub name: String,
    /// The version shown to people; keys use the digest of the executable.
    #[serde(default)]
    pub version: String,
    /// One line of what the stage does.
    pub summary: String,
    /// JSON Schema of the parameters: an object without additional properties, each with description, default and,
    /// where it has one, `unit`.
    #[serde(default)]
    pub params: Value,
    /// What the stage reads.
    #[serde(default)]
    pub inputs: Vec<InputPort>,
    /// What the stage writes.
    #[serde(default)]
    pub outputs: Vec<OutputPort>,
    /// Same request, same bytes. A stage that cannot promise this is still cached, but not compared.
    #[serde(default = "yes")]
    pub deterministic: bool,
    /// The stage uses its seed; without this, `seed` in a recipe is an error and does not enter the key.
    #[serde(default)]
    pub seeded: bool,
    /// What the stage needs to run well.
    #[serde(default)]
    pub resources: Resources,
    /// Files beside the executable, relative to it, that change what the stage does; they enter the plugin digest.
    #[serde(default)]
    pub runtime_files: Vec<String>,
    /// Programs the stage starts, by name; the sandbox lets it see their folders.
    #[serde(default)]
    pub programs: Vec<String>,
    /// A Python environment that the host sets up once, outside the sandbox.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment: Option<Environment>,
}

/// A Python environment: what pip installs from a lock file. Lock and interpreter enter the plugin digest; a run gets the
/// path of the environment's interpreter.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Environment {
    /// The lock file beside the executable, relative to it: `requirements.txt` with hashes.
    pub requirements: String,
    /// The oldest Python that will do, e.g. `[3, 11]`.
    pub oldest: [u32; 2],
    /// The newest.
    pub newest: [u32; 2],
}

/// Something a stage reads.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputPort {
    /// Name of the port; what `from` wires.
    pub name: String,
    /// Artefact type, e.g. `body`.
    #[serde(rename = "type")]
    pub kind: String,
    /// One line for people.
    #[serde(default)]
    pub doc: String,
    /// How many artefacts the port takes.
    #[serde(default)]
    pub arity: Arity,
}

/// How many artefacts an input port takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Arity {
    /// Exactly one: the nearest earlier one of the type.
    #[default]
    One,
    /// The nearest earlier one, if there is any.
    Optional,
    /// Every earlier one of the type, in recipe order.
    Many,
}

/// Something a stage writes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutputPort {
    /// Name of the port.
    pub name: String,
    /// Artefact type, e.g. `routes`.
    #[serde(rename = "type")]
    pub kind: String,
    /// One line for people.
    #[serde(default)]
    pub doc: String,
    /// The usual file name in the build folder, for an output that people open.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub publish: Option<String>,
}

/// What a stage needs to run well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Resources {
    /// The stage starts with at least so many cores, where the machine has them.
    pub min_cores: u32,
    /// More cores than this are of no use to it; 0 for "as many as there are".
    pub max_cores: u32,
    /// Peak memory to plan with, MB.
    pub memory_mb: u32,
}

impl Default for Resources {
    fn default() -> Resources {
        Resources { min_cores: 1, max_cores: 0, memory_mb: 256 }
    }
}

fn yes() -> bool {
    true
}

impl Description {
    /// A description without ports; `serve` adds the schema of the parameters.
    pub fn new(name: impl Into<String>, summary: impl Into<String>) -> Description {
        Description {
            name: name.into(),
            version: String::new(),
            summary: summary.into(),
            params: Value::Null,
            inputs: Vec::new(),
            outputs: Vec::new(),
            deterministic: true,
            seeded: false,
            resources: Resources::default(),
            runtime_files: Vec::new(),
            programs: Vec::new(),
            environment: None,
        }
    }

    /// The version shown to people, usually `env!("CARGO_PKG_VERSION")`.
    pub fn version(mut self, version: &str) -> Description {
        self.version = version.into();
        self
    }

    /// An input that takes exactly one artefact.
    pub fn input(self, name: &str, kind: &str, doc: &str) -> Description {
        self.input_of(Arity::One, name, kind, doc)
    }

    /// An input that may stay unwired.
    pub fn optional_input(self, name: &str, kind: &str, doc: &str) -> Description {
        self.input_of(Arity::Optional, name, kind, doc)
    }

    /// An input that takes every earlier artefact of the type.
    pub fn input_of_all(self, name: &str, kind: &str, doc: &str) -> Description {
        self.input_of(Arity::Many, name, kind, doc)
    }

    fn input_of(mut self, arity: Arity, name: &str, kind: &str, doc: &str) -> Description {
        self.inputs.push(InputPort { name: name.into(), kind: kind.into(), doc: doc.into(), arity });
        self
    }

    /// An output for later stages only.
    pub fn output(mut self, name: &str, kind: &str, doc: &str) -> Description {
        self.outputs.push(OutputPort {
            name: name.into(),
            kind: kind.into(),
            doc: doc.into(),
            publish: None,
        });
        self
    }

    /// An output that also appears in the build folder, usually as `file`; the name that the run writes it under
    /// wins, so that two profiles of one stage can sit side by side.
    pub fn published(mut self, name: &str, kind: &str, file: &str, doc: &str) -> Description {
        let publish = Some(file.into());
        self.outputs.push(OutputPort { name: name.into(), kind: kind.into(), doc: doc.into(), publish });
        self
    }

    /// The stage uses its seed.
    pub fn seeded(mut self) -> Description {
        self.seeded = true;
        self
    }

    /// The stage cannot promise the same bytes twice.
    pub fn nondeterministic(mut self) -> Description {
        self.deterministic = false;
        self
    }

    /// The stage keeps at most so many cores busy (default: all it gets).
    pub fn max_cores(mut self, cores: u32) -> Description {
        self.resources.max_cores = cores;
        self
    }

    /// The stage starts only when so many cores are free (default: 1).
    pub fn min_cores(mut self, cores: u32) -> Description {
        self.resources.min_cores = cores;
        self
    }

    /// Peak memory to plan with, MB (default: 256).
    pub fn memory_mb(mut self, megabytes: u32) -> Description {
        self.resources.memory_mb = megabytes;
        self
    }

    /// A file beside the executable that changes what the stage does.
    pub fn runtime_file(mut self, path: &str) -> Description {
        self.runtime_files.push(path.into());
        self
    }

    /// The Python environment of the stage; `job.python()` is its interpreter.
    pub fn python_environment(
        mut self,
        requirements: &str,
        oldest: [u32; 2],
        newest: [u32; 2],
    ) -> Description {
        self.environment = Some(Environment { requirements: requirements.into(), oldest, newest });
        self
    }

    /// A program that the stage starts.
    pub fn program(mut self, name: &str) -> Description {
        self.programs.push(name.into());
        self
    }
}
