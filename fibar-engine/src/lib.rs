//! Recipe → plan → store → schedule → plugin host → ledger.
//!
//! A walk along the data: [`recipe`] reads TOML and remembers where everything was written; [`plan`] asks the plugins
//! ([`plugin`]) what they are and turns the recipe into stages with complete parameters and typed wires, or reports
//! every mistake at once; [`build`] looks each stage up in the [`store`] by the hash of everything that goes into it and
//! runs what is missing through the [`host`]; [`ledger`] copies the results to the build folder and says what came out.
//!
//! Deliberately absent: any knowledge of meshes or light (artefacts are bytes with a type name), and any trust in
//! plugins (the host hashes and checks everything they hand over). Times are only ever written to `timings.json` and `trace.json`,
//! and beside the results of an action, for estimates.
//! Unsafe code lives in [`os`] alone.

pub mod build;
pub mod conformance;
pub mod determinism;
pub mod explain;
pub mod host;
pub mod ledger;
pub mod plan;
pub mod plugin;
pub mod recipe;
pub mod store;

mod canonical;
mod digest;
mod error;
pub mod os;
mod stamp;

pub use digest::Digest;
pub use error::{Class, Error, Result};
pub use store::Store;
