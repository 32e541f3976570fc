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
    /// Ask about plugins.
    #[command(subcommand)]
    Plugin(PluginCommand),
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
    /// Confine stages to their inputs, their out folder and no network.
    #[arg(long, value_enum, default_value = "auto")]
    pub sandbox: SandboxChoice,
    /// Show log lines of stages too.
    #[arg(short, long)]
    pub verbose: bool,
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
    /// Print the plugins that recipes name, one per line; needs none of them.
    Required {
        /// Recipe files.
        #[arg(value_name = "RECIPE", required = true)]
        recipes: Vec<PathBuf>,
    },
}

/// How to list plugins.
#[derive(Debug, Args)]
pub struct ListOptions {
    /// Print names and executables only, without asking the plugins.
    #[arg(long)]
    pub names: bool,
}
