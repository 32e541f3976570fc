//! The command line of fibar.

fn main() {}
