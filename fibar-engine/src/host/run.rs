//! One run: send the request, listen, ping, cancel, and say how it ended.

use super::session::{Heard, Session};
use super::{Launch, Limits, greet};
use fibar_core::protocol::{
    Done, Failure, FailureKind, HostMessage, Metric, PluginMessage, Request, Violation,
};
use std::collections::VecDeque;
use std::process::ExitStatus;
use std::time::{Duration, Instant};

/// More metrics or violations than this are a flood.
const MAX_REPORTS: usize = 10_000;
/// How many lines of standard error are kept for the report of a crash.
const LAST_LINES: usize = 12;
/// How often cancelling is looked at.
const TICK: Duration = Duration::from_millis(50);

/// What a run needs.
pub struct RunSetup<'a> {
    /// The plugin and its surroundings.
    pub launch: Launch<'a>,
    /// What it is asked; paths are relative to its private folder.
    pub request: &'a Request,
    /// How patient the host is.
    pub limits: Limits,
    /// Whether the user wants to stop.
    pub is_cancelled: &'a dyn Fn() -> bool,
    /// Told of progress, logs and lines of standard error (as logs of level `stderr`).
    pub listener: &'a dyn Fn(&PluginMessage),
}

/// How a run went.
#[derive(Debug)]
pub struct Report {
    /// How it ended.
    pub end: End,
    /// In the order they came.
    pub metrics: Vec<Metric>,
    /// In the order they came.
    pub violations: Vec<Violation>,
    /// The last lines of standard error.
    pub last_lines: Vec<String>,
    /// It was asked to stop and did not in time.
    pub killed: bool,
}

/// How a run ended.
#[derive(Debug)]
pub enum End {
    /// With outputs, which nobody has looked at yet.
    Done(Done),
    /// With an error that the stage explains.
    Failed(Failure),
    /// Because the user stopped it.
    Cancelled,
    /// By dying, stalling or breaking the protocol.
    Broken(String),
}

/// Runs a plugin once, from start to the end of its process group.
pub fn run(setup: &RunSetup<'_>) -> Report {
    let mut report = Report {
        end: End::Cancelled,
        metrics: Vec::new(),
        violations: Vec::new(),
        last_lines: Vec::new(),
        killed: false,
    };
    match setup.launch.command().and_then(Session::start) {
        Ok(session) => Conversation::new(setup, session).hold(&mut report),
        Err(e) => report.end = End::Broken(format!("it cannot be started: {e}")),
    }
    report
}

struct Conversation<'a> {
    setup: &'a RunSetup<'a>,
    session: Session,
    heard_at: Instant,
    pings: u64,
    pinged: bool,
    cancel_sent: Option<Instant>,
    last_lines: VecDeque<String>,
}

impl<'a> Conversation<'a> {
    fn new(setup: &'a RunSetup<'a>, session: Session) -> Conversation<'a> {
        let last_lines = VecDeque::new();
        let heard_at = Instant::now();
        Conversation { setup, session, heard_at, pings: 0, pinged: false, cancel_sent: None, last_lines }
    }

    fn hold(mut self, report: &mut Report) {
        let started = greet(&mut self.session, &self.setup.limits);
        report.end = match started {
            Ok(()) => {
                self.session.send(&HostMessage::Run(self.setup.request.clone()));
                self.heard_at = Instant::now();
                self.listen(report)
            }
            Err(reason) => End::Broken(reason),
        };
        self.finish(report);
    }

    fn listen(&mut self, report: &mut Report) -> End {
        loop {
            let heard = self.session.hear(TICK);
            if !matches!(heard, Heard::Silence) {
                self.heard_at = Instant::now();
                self.pinged = false;
            }
            match heard {
                Heard::Message(message) => {
                    if let Some(end) = self.message(message, report) {
                        return end;
                    }
                }
                Heard::Stderr(line) => self.note(line),
                Heard::Garbage(reason) => {
                    return End::Broken(format!("it wrote a line that is no message: {reason}"));
                }
                Heard::Closed if self.cancel_sent.is_some() => return End::Cancelled,
                Heard::Closed => return End::Broken(String::new()),
                Heard::Silence => {}
            }
            if let Some(end) = self.check_time() {
                report.killed = true;
                return end;
            }
        }
    }

    fn message(&mut self, message: PluginMessage, report: &mut Report) -> Option<End> {
        match message {
            PluginMessage::Done(done) => return Some(End::Done(done)),
            PluginMessage::Error(failure) if failure.kind == FailureKind::Cancelled => {
                let asked = self.cancel_sent.is_some();
                return Some(if asked { End::Cancelled } else { End::Failed(failure) });
            }
            PluginMessage::Error(failure) => return Some(End::Failed(failure)),
            PluginMessage::Metric(metric) => report.metrics.push(metric),
            PluginMessage::Violation(violation) => report.violations.push(violation),
            PluginMessage::Progress(_) | PluginMessage::Log(_) => (self.setup.listener)(&message),
            PluginMessage::Pong(_) => {}
            PluginMessage::Hello(_) | PluginMessage::Description(_) => {
                return Some(End::Broken(Heard::Message(message).complaint("reports of a run")));
            }
        }
        let flood = report.metrics.len().max(report.violations.len()) > MAX_REPORTS;
        flood.then(|| End::Broken(format!("it reported more than {MAX_REPORTS} metrics or violations")))
    }

    fn note(&mut self, line: String) {
        let level = "stderr".into();
        (self.setup.listener)(&PluginMessage::Log(fibar_core::protocol::LogLine {
            level,
            message: line.clone(),
        }));
        self.last_lines.push_back(line);
        if self.last_lines.len() > LAST_LINES {
            self.last_lines.pop_front();
        }
    }

    /// Cancel, ping and kill when it is time.
    fn check_time(&mut self) -> Option<End> {
        let limits = &self.setup.limits;
        if let Some(since) = self.cancel_sent {
            return (since.elapsed() >= limits.cancel).then_some(End::Cancelled);
        }
        if (self.setup.is_cancelled)() {
            self.session.send(&HostMessage::Cancel {});
            self.cancel_sent = Some(Instant::now());
        } else if self.heard_at.elapsed() >= limits.silence * 2 {
            let seconds = self.heard_at.elapsed().as_secs_f64();
            return Some(End::Broken(format!(
                "it stalled: no sign of life for {seconds:.0} s, not even to a ping"
            )));
        } else if self.heard_at.elapsed() >= limits.silence && !self.pinged {
            self.pings += 1;
            self.pinged = true;
            self.session.send(&HostMessage::Ping { id: self.pings });
        }
        None
    }

    /// The last words that were still on their way.
    fn drain(&mut self) {
        for _ in 0..2 {
            loop {
                match self.session.hear(TICK) {
                    Heard::Stderr(line) => self.note(line),
                    Heard::Message(_) | Heard::Garbage(_) => {}
                    Heard::Closed => break,
                    Heard::Silence => return,
                }
            }
        }
    }

    fn finish(mut self, report: &mut Report) {
        let patience = match &report.end {
            End::Cancelled => Duration::ZERO,
            End::Broken(reason) if !reason.is_empty() => Duration::ZERO,
            _ => self.setup.limits.exit,
        };
        let status = self.session.end(patience);
        self.drain();
        if let End::Broken(reason) = &mut report.end
            && reason.is_empty()
        {
            *reason = format!("it ended without a result ({})", status_text(status));
        }
        report.last_lines = self.last_lines.into();
    }
}

fn status_text(status: Option<ExitStatus>) -> String {
    status.map_or("nobody knows how".into(), |status| status.to_string())
}
