//! What users see of the engine, one file per promise.

#![allow(clippy::unwrap_used, missing_docs, reason = "tests")]

mod bench;
mod caching;
mod comparing;
mod explaining;
mod keeping;
mod kit;
mod mistakes;
mod publishing;
mod rudeness;
mod variants;
