//! A running plugin: its process, lines to it, lines from it.

use crate::os;
use fibar_core::protocol::{HostMessage, PluginMessage};
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::time::{Duration, Instant};

/// A longer line is no message.
const MAX_LINE: u64 = 8 << 20;

/// A plugin that floods its output waits after so many unread lines.
const MAX_UNREAD: usize = 256;

/// A plugin that was started. Dropping it kills its process group.
pub struct Session {
    child: Child,
    to_plugin: Option<Sender<String>>,
    from_plugin: Receiver<Heard>,
    ended: bool,
}

/// What comes from a plugin.
#[derive(Debug)]
pub enum Heard {
    /// A message of the protocol.
    Message(PluginMessage),
    /// A line of its standard error.
    Stderr(String),
    /// A line on standard output that is no message.
    Garbage(String),
    /// Standard output was closed.
    Closed,
    /// Nothing yet.
    Silence,
}

impl Session {
    /// Starts a plugin with the protocol flag.
    pub fn start(mut command: Command) -> std::io::Result<Session> {
        command.arg(fibar_core::protocol::STDIO_FLAG);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = spawn(&mut command)?;
        let (to_plugin, lines) = channel();
        let (heard, from_plugin) = sync_channel(MAX_UNREAD);
        let pipes = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (Some(stdin), Some(stdout), Some(stderr)) = pipes else {
            return Err(std::io::Error::other("no pipes"));
        };
        std::thread::spawn(move || write_lines(stdin, &lines));
        let log = heard.clone();
        std::thread::spawn(move || read_stderr(stderr, &log));
        std::thread::spawn(move || read_messages(stdout, &heard));
        Ok(Session { child, to_plugin: Some(to_plugin), from_plugin, ended: false })
    }

    /// Sends a message; a plugin that no longer reads is noticed elsewhere.
    pub fn send(&self, message: &HostMessage) {
        let mut line = serde_json::to_string(message).expect("protocol messages are plain data");
        line.push('\n');
        if let Some(to_plugin) = &self.to_plugin {
            let _ = to_plugin.send(line);
        }
    }

    /// The next thing heard within a time.
    pub fn hear(&self, patience: Duration) -> Heard {
        match self.from_plugin.recv_timeout(patience) {
            Ok(heard) => heard,
            Err(RecvTimeoutError::Timeout) => Heard::Silence,
            Err(RecvTimeoutError::Disconnected) => Heard::Closed,
        }
    }

    /// The next thing heard on standard output before a moment.
    pub fn hear_until(&self, deadline: Instant) -> Heard {
        loop {
            match self.hear(deadline.saturating_duration_since(Instant::now())) {
                Heard::Stderr(_) => {}
                heard => return heard,
            }
        }
    }

    /// Hangs up, waits a little for the plugin to end, then kills what is left of its process group.
    pub fn end(&mut self, patience: Duration) -> Option<ExitStatus> {
        if std::mem::replace(&mut self.ended, true) {
            return None;
        }
        os::await_end(&self.child, patience);
        self.to_plugin = None;
        os::kill_group(&self.child);
        let _ = self.child.kill();
        self.child.wait().ok()
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.end(Duration::ZERO);
    }
}

impl Heard {
    /// What to say when something else was expected.
    pub fn complaint(&self, expected: &str) -> String {
        match self {
            Heard::Message(message) => {
                format!("expected {expected}, got {}", shorten(&format!("{message:?}")))
            }
            Heard::Garbage(reason) => format!("expected {expected}, got a line that is no message: {reason}"),
            Heard::Closed => format!("it ended before it sent {expected}"),
            Heard::Silence | Heard::Stderr(_) => format!("it did not send {expected} in time"),
        }
    }
}

/// A plugin that was written a moment ago may still be open for writing in a process that another thread is just forking;
/// that passes.
fn spawn(command: &mut Command) -> std::io::Result<Child> {
    for _ in 0..50 {
        match command.spawn() {
            Err(e) if e.kind() == std::io::ErrorKind::ExecutableFileBusy => {
                std::thread::sleep(Duration::from_millis(10));
            }
            other => return other,
        }
    }
    command.spawn()
}

fn write_lines(mut stdin: ChildStdin, lines: &Receiver<String>) {
    for line in lines {
        if stdin.write_all(line.as_bytes()).and_then(|()| stdin.flush()).is_err() {
            return;
        }
    }
}

fn read_messages(stdout: ChildStdout, heard: &SyncSender<Heard>) {
    let mut reader = BufReader::new(stdout);
    loop {
        let mut line = Vec::new();
        match reader.by_ref().take(MAX_LINE).read_until(b'\n', &mut line) {
            Ok(0) | Err(_) => break,
            Ok(_) => {}
        }
        let message = match serde_json::from_slice(&line) {
            Ok(message) => Heard::Message(message),
            Err(e) => Heard::Garbage(format!("{} ({e})", shorten(&String::from_utf8_lossy(&line)))),
        };
        let is_garbage = matches!(message, Heard::Garbage(_));
        if heard.send(message).is_err() || is_garbage {
            break;
        }
    }
    let _ = heard.send(Heard::Closed);
}

fn read_stderr(stderr: ChildStderr, heard: &SyncSender<Heard>) {
    let mut reader = BufReader::new(stderr);
    loop {
        let mut line = Vec::new();
        match reader.by_ref().take(4096).read_until(b'\n', &mut line) {
            Ok(0) | Err(_) => return,
            Ok(_) => {}
        }
        if heard.send(Heard::Stderr(String::from_utf8_lossy(&line).trim_end().to_owned())).is_err() {
            return;
        }
    }
}

fn shorten(text: &str) -> String {
    let text = text.trim();
    match text.char_indices().nth(160) {
        Some((at, _)) => format!("{:?}…", &text[..at]),
        None => format!("{text:?}"),
    }
}
