//! The line to the host: messages out, cancel and ping in.

use fibar_core::protocol::{HostMessage, PluginMessage, Pong};
use std::fs::File;
use std::io::{BufRead, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Where messages go. Clones share the line.
#[derive(Clone)]
pub(crate) struct Line {
    out: Arc<Mutex<File>>,
    cancelled: Arc<AtomicBool>,
}

impl Line {
    /// A line that writes to `out`.
    pub fn new(out: File) -> Line {
        Line { out: Arc::new(Mutex::new(out)), cancelled: Arc::default() }
    }

    /// Writes one message; a host that no longer listens ends the process, since nobody wants the result.
    pub fn send(&self, message: &PluginMessage) {
        let mut text = serde_json::to_string(message).expect("protocol messages are plain data");
        text.push('\n');
        let mut out = self.out.lock().unwrap_or_else(PoisonError::into_inner);
        if out.write_all(text.as_bytes()).and_then(|()| out.flush()).is_err() {
            std::process::exit(5);
        }
    }

    /// Whether the host asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Answers pings and notes a cancel until the host hangs up, which ends the process.
    pub fn listen(self, input: impl BufRead + Send + 'static) {
        std::thread::spawn(move || {
            for line in input.lines().map_while(Result::ok) {
                match serde_json::from_str(&line) {
                    Ok(HostMessage::Ping { id }) => self.send(&PluginMessage::Pong(Pong { id })),
                    Ok(HostMessage::Cancel {}) => self.cancelled.store(true, Ordering::Relaxed),
                    other => eprintln!("unexpected during a run, skipped: {other:?}"),
                }
            }
            std::process::exit(5);
        });
    }
}
