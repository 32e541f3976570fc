//! What `fibar` understands.

use clap::{Args, Parser, Subcommand};
use fibar_engine::host::Sandbox;
use fibar_engine::recipe::Override;
use std::path::PathBuf;

/// Builds objects with printed optical fibres and blinking markers from recipes.
///
/// Exit codes: 0 all is well, 1 a verification rule is broken, 2 recipe, 3 input, 4 resource, 5 plugin, 130 cancelled.
#[derive(Debug, Parser)]
#[command(name = "fibar", version, propagate_version = true)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// For all commands.
    #[command(flatten)]
    pub common: Common,
}

/// For all commands.
#[derive(Debug, Args)]
pub struct Common {
    /// Look for plugins here first; then beside `fibar` and in ../libexec/fibar, never in PATH.
    #[arg(long = "plugin-path", value_name = "FOLDER", global = true)]
    pub plugin_path: Vec<PathBuf>,
    /// Keep artefacts here [default: $FIBAR_STORE, else the user's cache folder].
    #[arg(long, value_name = "FOLDER", global = true)]
    pub store: Option<PathBuf>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Build recipes and publish what comes out to build/NAME/.
    Build(BuildOptions),
    /// Build recipes and report every broken rule.
    Verify(VerifyOptions),
    /// Show what a build would run and what the store already has; runs no stage.
    Plan(PlanOptions),
    /// Say why a stage would run: the changed field of its key, old → new, and where that comes from.
    Explain(ExplainOptions),
    /// Build twice, the second time in an empty store with another number of threads, and name what differs first.
    CheckDeterminism(BuildOptions),
    /// Look after the store.
    #[command(subcommand)]
    Cache(CacheCommand),
    /// Ask about plugins.
    #[command(subcommand)]
    Plugin(PluginCommand),
}

impl Command {
    /// Whether findings were already told as JSON.
    pub fn logs_json(&self) -> bool {
        let (Command::Build(options) | Command::CheckDeterminism(options)) = self else {
            return matches!(self, Command::Verify(options) if options.build.log == LogForm::Json);
        };
        options.log == LogForm::Json
    }
}

/// Which recipes, and how they are changed.
#[derive(Debug, Args)]
pub struct Recipes {
    /// Recipe files.
    #[arg(value_name = "RECIPE", required = true)]
    pub recipes: Vec<PathBuf>,
    /// Replace a value of the recipe, e.g. `--set place-visibility.spacing_mm=10`.
    #[arg(long, value_name = "STAGE.KEY=VALUE")]
    pub set: Vec<Override>,
    /// Every variant of the recipe's [matrix], each in a build folder NAME@VALUES of its own.
    #[arg(long)]
    pub matrix: bool,
}

/// How to build.
#[derive(Debug, Args)]
pub struct BuildOptions {
    #[command(flatten)]
    pub recipes: Recipes,
    /// Use at most so many cores [default: all].
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub jobs: Option<u32>,
    /// Make build folders in here.
    #[arg(long, value_name = "FOLDER", default_value = "build")]
    pub out: PathBuf,
    /// Refuse to come to anything else than the fibar.lock in the build folder says.
    #[arg(long)]
    pub locked: bool,
    /// How progress is told on standard error; what came out goes to standard output either way.
    #[arg(long, value_enum, default_value = "text")]
    pub log: LogForm,
    /// Confine stages to their inputs, their out folder and no network.
    #[arg(long, value_enum, default_value = "auto")]
    pub sandbox: SandboxChoice,
    /// Show log lines of stages too.
    #[arg(short, long)]
    pub verbose: bool,
}

/// How progress is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum LogForm {
    /// Bars with estimates on a terminal, plain lines in a pipe.
    Text,
    /// One JSON object per line, findings included.
    Json,
}

/// Whether stages are confined.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum SandboxChoice {
    /// Where the system grants user namespaces; elsewhere the build says that it does not.
    Auto,
    /// Never.
    Off,
    /// Always; without, nothing runs.
    Require,
}

impl From<SandboxChoice> for Sandbox {
    fn from(choice: SandboxChoice) -> Sandbox {
        match choice {
            SandboxChoice::Auto => Sandbox::Auto,
            SandboxChoice::Off => Sandbox::Off,
            SandboxChoice::Require => Sandbox::Require,
        }
    }
}

/// How to verify.
#[derive(Debug, Args)]
pub struct VerifyOptions {
    #[command(flatten)]
    pub build: BuildOptions,
    /// Ignore `allow` in recipes: every violation fails.
    #[arg(long)]
    pub strict: bool,
}

/// How to plan.
#[derive(Debug, Args)]
pub struct PlanOptions {
    #[command(flatten)]
    pub recipes: Recipes,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// What to explain.
#[derive(Debug, Args)]
pub struct ExplainOptions {
    /// Recipe file.
    pub recipe: PathBuf,
    /// Id of the stage.
    pub stage: String,
    /// Replace a value of the recipe, e.g. `--set place-visibility.spacing_mm=10`.
    #[arg(long, value_name = "STAGE.KEY=VALUE")]
    pub set: Vec<Override>,
    /// Where build folders are.
    #[arg(long, value_name = "FOLDER", default_value = "build")]
    pub out: PathBuf,
}

/// Looking after the store.
#[derive(Debug, Subcommand)]
pub enum CacheCommand {
    /// Delete what was used least recently; what build folders refer to stays. Safe while builds run.
    Gc {
        /// Bytes to keep at most, e.g. 500M or 2G.
        #[arg(long, value_name = "SIZE", value_parser = parse_size)]
        max_size: u64,
    },
    /// Hash every artefact; damaged ones are quarantined and built again when they are needed.
    Verify,
    /// Count what is there.
    Stats,
}

/// `500M`: with k, M, G, T for powers of 1000.
fn parse_size(text: &str) -> Result<u64, String> {
    let (digits, power) = match text.trim_end_matches(['B', 'b']).char_indices().last() {
        Some((at, unit)) if unit.is_ascii_alphabetic() => {
            let power = "kMGT".to_lowercase().find(unit.to_ascii_lowercase()).ok_or("use k, M, G or T")?;
            (&text[..at], power as u32 + 1)
        }
        _ => (text.trim_end_matches(['B', 'b']), 0),
    };
    let number: u64 = digits.trim().parse().map_err(|_| format!("{text:?} is no size such as 500M"))?;
    number.checked_mul(1000u64.pow(power)).ok_or_else(|| "that is too much".into())
}

/// Questions about plugins.
#[derive(Debug, Subcommand)]
pub enum PluginCommand {
    /// List the plugins that are found.
    List(ListOptions),
    /// Show ports and parameters of a plugin as JSON.
    Describe {
        /// Its name.
        name: String,
    },
    /// Ask a plugin whether it keeps the promises of the protocol.
    Test(TestOptions),
    /// Print the plugins that recipes name, one per line; needs none of them.
    Required {
        /// Recipe files.
        #[arg(value_name = "RECIPE", required = true)]
        recipes: Vec<PathBuf>,
    },
}

/// How to test a plugin.
#[derive(Debug, Args)]
pub struct TestOptions {
    /// The executable, or the name of a plugin that is found.
    pub plugin: PathBuf,
    /// A file or folder for an input port; several for a port that takes many.
    #[arg(long, value_name = "PORT=PATH", value_parser = parse_pair)]
    pub input: Vec<(String, String)>,
    /// A parameter, as JSON or text.
    #[arg(long, value_name = "KEY=VALUE", value_parser = parse_pair)]
    pub set: Vec<(String, String)>,
}

fn parse_pair(text: &str) -> Result<(String, String), String> {
    let (key, value) =
        text.split_once('=').ok_or_else(|| format!("{text:?} is not of the form name=value"))?;
    Ok((key.into(), value.into()))
}

/// How to list plugins.
#[derive(Debug, Args)]
pub struct ListOptions {
    /// Print names and executables only, without asking the plugins.
    #[arg(long)]
    pub names: bool,
}
