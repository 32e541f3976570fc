//! A child process under a clock: its lines go to the log, and it ends by itself, in time, or is ended.

use crate::group::Group;
use fibar_plugin::{Job, StageError};
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

/// How often the clock and the host are asked.
const TICK: Duration = Duration::from_millis(20);
/// From asking a child where it is to killing it; and for the last lines of one that has ended.
const LAST_WORDS: Duration = Duration::from_millis(300);
/// Longer lines are cut into pieces.
const MAX_LINE: u64 = 2000;
/// Of the lines of a chatty child, so many are passed on.
const MAX_LINES: usize = 200;

/// How a child ended.
pub enum End {
    /// By itself.
    Exited(ExitStatus),
    /// Killed, since its time was up.
    OutOfTime,
    /// There is no such program.
    NotFound,
}

/// Runs a command until it ends, its time is up, or the host wants no more. Nothing that it started outlives this call.
pub fn run(command: &mut Command, patience: Duration, job: &mut Job) -> Result<End, StageError> {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut group = match Group::start(command) {
        Ok(group) => group,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(End::NotFound),
        Err(error) => return Err(error.into()),
    };
    let (lines, mut log) = (read_lines(&mut group), Log::default());
    let deadline = Instant::now() + patience;
    loop {
        match lines.recv_timeout(TICK) {
            Ok(line) => log.pass(&line, job),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => std::thread::sleep(TICK),
        }
        job.check_cancel()?;
        if let Some(status) = group.try_wait()? {
            while let Ok(line) = lines.recv_timeout(LAST_WORDS) {
                log.pass(&line, job);
            }
            return Ok(End::Exited(status));
        }
        if Instant::now() >= deadline {
            group.ask_where_it_is();
            std::thread::sleep(LAST_WORDS);
            return Ok(End::OutOfTime);
        }
    }
}

/// Passes the first lines on and drops the rest.
#[derive(Default)]
struct Log {
    lines: usize,
}

impl Log {
    fn pass(&mut self, line: &str, job: &mut Job) {
        self.lines += 1;
        match self.lines.cmp(&MAX_LINES) {
            std::cmp::Ordering::Less => job.log("info", line),
            std::cmp::Ordering::Equal => job.log("info", "(further lines are not shown)"),
            std::cmp::Ordering::Greater => {}
        }
    }
}

fn read_lines(group: &mut Group) -> Receiver<String> {
    let (sender, lines) = sync_channel(64);
    let child = group.child();
    if let Some(stdout) = child.stdout.take() {
        let sender = sender.clone();
        std::thread::spawn(move || forward(stdout, &sender));
    }
    if let Some(stderr) = child.stderr.take() {
        std::thread::spawn(move || forward(stderr, &sender));
    }
    lines
}

fn forward(stream: impl Read, lines: &SyncSender<String>) {
    let mut stream = BufReader::new(stream);
    loop {
        let mut line = Vec::new();
        match stream.by_ref().take(MAX_LINE).read_until(b'\n', &mut line) {
            Ok(0) | Err(_) => return,
            Ok(_) => {
                let text = String::from_utf8_lossy(&line).trim_end().to_string();
                if !text.is_empty() && lines.send(text).is_err() {
                    return;
                }
            }
        }
    }
}
