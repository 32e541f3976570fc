//! The program as people and other processes meet it: its commands, many builds on one store, builds killed at any moment.
//!
//! `FIBAR_SOAK=1` (`cargo xtask soak`) runs the long form.

#![allow(clippy::unwrap_used, missing_docs, reason = "tests")]

mod commands;
mod demo;
mod progress;
mod sharing;
mod soak;
mod store;
