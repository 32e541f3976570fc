//! Real builds from recipe to print file, as a user would run them.

mod bad_input;
mod bunny;
mod pebble;
mod peers;
mod recipes;
