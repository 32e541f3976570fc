//! The plugin host: starts a plugin, talks to it, watches it, and never trusts it.

mod launch;
mod run;
mod session;
mod work;

pub use launch::{Launch, Sandbox};
pub use run::{End, Report, RunSetup, run};
pub use work::{Collected, WorkFolder};

use crate::{Class, Error, Result, Store};
use fibar_core::diagnostic::Diagnostic;
use fibar_core::protocol::{Description, Hello, HostMessage, PROTOCOL_VERSION, PluginMessage};
use session::{Heard, Session};
use std::path::Path;
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
pub fn describe(executable: &Path, store: &Store, limits: &Limits) -> Result<Description> {
    in_session(executable, store, limits, |session| {
        greet(session, limits)?;
        session.send(&HostMessage::Describe {});
        match session.hear_until(Instant::now() + limits.start) {
            Heard::Message(PluginMessage::Description(description)) => Ok(*description),
            other => Err(other.complaint("a description")),
        }
    })
}

/// Whether a plugin hangs up on a host of another version.
pub(crate) fn greet_as(executable: &Path, store: &Store, protocol: u32) -> Result<bool> {
    let limits = Limits::default();
    in_session(executable, store, &limits, |session| {
        session.send(&HostMessage::Hello(Hello { protocol, ..Hello::new("fibar of another time") }));
        session.send(&HostMessage::Describe {});
        match session.hear_until(Instant::now() + limits.start) {
            Heard::Message(PluginMessage::Hello(_)) => {}
            other => return Err(other.complaint("hello")),
        }
        Ok(matches!(session.hear_until(Instant::now() + limits.exit), Heard::Closed))
    })
}

/// A session that is no run, in an empty folder.
fn in_session<T>(
    executable: &Path,
    store: &Store,
    limits: &Limits,
    talk: impl FnOnce(&mut Session) -> std::result::Result<T, String>,
) -> Result<T> {
    let fault = |message: String| {
        let message = format!("{} does not describe itself: {message}", executable.display());
        Error::new(Class::Plugin, Diagnostic::error(message).hint("is it a plugin of this version of fibar?"))
    };
    let folder = WorkFolder::new(store, "describe")?;
    let launch = Launch {
        executable,
        description: None,
        folder: folder.path(),
        scratch: &store.scratch()?,
        readable: &[],
        threads: 1,
        sandbox: Sandbox::Auto,
    };
    let command = launch.command().map_err(|e| fault(e.to_string()))?;
    let mut session = Session::start(command).map_err(|e| fault(e.to_string()))?;
    let result = talk(&mut session);
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
