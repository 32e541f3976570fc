//! The plugin host: starts a plugin, talks to it, watches it, and never trusts it.

mod run;
mod session;
mod work;

pub use run::{End, Report, RunSetup, run};
pub use work::{Collected, WorkFolder};

use crate::{Class, Error, Result};
use fibar_core::diagnostic::Diagnostic;
use fibar_core::protocol::{Description, Hello, HostMessage, PROTOCOL_VERSION, PluginMessage};
use session::{Heard, Session};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// How patient the host is.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Until the first `hello`, and until a description.
    pub start: Duration,
    /// Silence before a ping, and silence after it before the plugin counts as stalled.
    pub silence: Duration,
    /// From `cancel` to the kill.
    pub cancel: Duration,
    /// From `done` or `error` to the kill.
    pub exit: Duration,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            start: Duration::from_secs(20),
            silence: Duration::from_secs(15),
            cancel: Duration::from_millis(1500),
            exit: Duration::from_secs(2),
        }
    }
}

/// Asks a plugin to describe itself.
pub fn describe(executable: &Path, limits: &Limits) -> Result<Description> {
    let fault = |message: String| {
        let message = format!("{} does not describe itself: {message}", executable.display());
        Error::new(Class::Plugin, Diagnostic::error(message).hint("is it a plugin of this version of fibar?"))
    };
    let mut command = Command::new(executable);
    environment(&mut command, 1, None);
    let mut session = Session::start(command).map_err(|e| fault(e.to_string()))?;
    let result = greet(&mut session, limits).and_then(|()| {
        session.send(&HostMessage::Describe {});
        match session.hear_until(Instant::now() + limits.start) {
            Heard::Message(PluginMessage::Description(description)) => Ok(*description),
            other => Err(other.complaint("a description")),
        }
    });
    session.end(limits.exit);
    result.map_err(fault)
}

/// Exchanges hellos.
fn greet(session: &mut Session, limits: &Limits) -> std::result::Result<(), String> {
    let name = concat!("fibar ", env!("CARGO_PKG_VERSION"));
    session.send(&HostMessage::Hello(Hello::new(name)));
    match session.hear_until(Instant::now() + limits.start) {
        Heard::Message(PluginMessage::Hello(hello)) if hello.protocol == PROTOCOL_VERSION => Ok(()),
        Heard::Message(PluginMessage::Hello(hello)) => Err(format!(
            "{} speaks protocol {}, this fibar speaks {PROTOCOL_VERSION}",
            hello.name, hello.protocol
        )),
        other => Err(other.complaint("hello")),
    }
}

/// The environment a plugin sees: nothing of the user's, only what every run has alike.
fn environment(command: &mut Command, threads: u32, folder: Option<&Path>) {
    command.env_clear();
    command.env("PATH", "/usr/local/bin:/usr/bin:/bin").env("LANG", "C.UTF-8").env("TZ", "UTC");
    command.env("RAYON_NUM_THREADS", threads.to_string()).env("OMP_NUM_THREADS", threads.to_string());
    command.env("PYTHONDONTWRITEBYTECODE", "1").env("PYTHONHASHSEED", "0");
    if cfg!(windows) {
        command.envs(["SYSTEMROOT", "PATH"].into_iter().filter_map(|k| std::env::var_os(k).map(|v| (k, v))));
    }
    if let Some(folder) = folder {
        command.current_dir(folder).env("HOME", folder.join("tmp")).env("TMPDIR", folder.join("tmp"));
    }
}
