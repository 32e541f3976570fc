//! What the operating system does for the host: signals, process groups, and later the sandbox. All unsafe code of the
//! engine is in here.

#[cfg(unix)]
mod unix;
#[cfg(unix)]
pub use unix::*;

#[cfg(not(unix))]
mod portable;
#[cfg(not(unix))]
pub use portable::*;
