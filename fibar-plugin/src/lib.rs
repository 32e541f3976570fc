//! What the author of a stage needs: the [`Stage`] trait, typed parameters with a schema, [`serve()`].
//!
//! A stage is an executable that turns input artefacts into output artefacts. It never sees the recipe, the clock or
//! the store; it gets complete parameters, inputs, a seed, a thread budget and an empty folder. A whole one:
//!
//! ```no_run
//! use fibar_plugin::{Description, Job, Stage, StageError, serve};
//!
//! #[derive(serde::Deserialize, schemars::JsonSchema)]
//! #[serde(deny_unknown_fields, default)]
//! struct Params {
//!     /// How often to say it.
//!     #[schemars(range(min = 1, max = 9))]
//!     times: u32,
//! }
//!
//! impl Default for Params {
//!     fn default() -> Params {
//!         Params { times: 2 }
//!     }
//! }
//!
//! struct Echo;
//!
//! impl Stage for Echo {
//!     type Params = Params;
//!
//!     fn describe() -> Description {
//!         Description::new("echo", "Repeats a text.")
//!             .version(env!("CARGO_PKG_VERSION"))
//!             .input("text", "text", "What to repeat.")
//!             .published("text", "text", "text.txt", "The text, repeated.")
//!     }
//!
//!     fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
//!         let text = job.read("text")?;
//!         job.metric("echo.bytes", text.len() as f64 * f64::from(params.times), "1");
//!         job.write("text", "text.txt", &text.repeat(params.times as usize))
//!     }
//! }
//!
//! fn main() -> std::process::ExitCode {
//!     serve::<Echo>()
//! }
//! ```
//!
//! Run by hand, `echo --help` explains the stage and its parameters, and `echo --request FILE` does one run.

mod direction;
mod error;
mod help;
mod input_file;
mod job;
mod line;
mod serve;
mod stage;

pub use direction::Direction;
pub use error::StageError;
pub use fibar_core::protocol::{Description, Violation};
pub use input_file::InputFile;
pub use job::Job;
pub use serve::serve;
pub use stage::Stage;
