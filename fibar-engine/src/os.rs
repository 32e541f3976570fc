//! What the operating system does for the host: signals, process groups, the sandbox. All unsafe code of the engine is in
//! here.

#[cfg(unix)]
mod unix;
#[cfg(unix)]
pub use unix::*;

#[cfg(not(unix))]
mod portable;
#[cfg(not(unix))]
pub use portable::*;

#[cfg(target_os = "linux")]
pub mod sandbox;
#[cfg(not(target_os = "linux"))]
#[path = "os/no_sandbox.rs"]
pub mod sandbox;
