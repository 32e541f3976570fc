//! Real builds from recipe to print file, as a user would run them.

#![allow(clippy::unwrap_used, reason = "helpers of tests are tests")]

mod bad_input;
mod bunny;
mod checkouts;
mod labels;
mod optics;
mod pebble;
mod peers;
mod plugins;
mod recipes;
mod repair;
