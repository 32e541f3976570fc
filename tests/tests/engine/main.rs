//! The engine under other processes: many builds on one store, and builds that are killed at any moment.
//!
//! `FIBAR_SOAK=1` (`cargo xtask soak`) runs the long form.

#![allow(clippy::unwrap_used, missing_docs, reason = "tests")]

mod demo;
mod sharing;
mod soak;
mod store;
