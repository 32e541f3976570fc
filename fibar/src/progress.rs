//! What a person sees while a build runs: bars with estimates on a terminal, plain lines in a pipe.

use crate::speak::tell;
use fibar_core::protocol::PluginMessage;
use fibar_engine::build::{Event, Left, Observer, Outcome, StageName};
use indicatif::{MultiProgress, ProgressBar, ProgressState, ProgressStyle};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How often bars move by themselves.
const TICK: Duration = Duration::from_millis(200);

/// Progress on standard error.
pub struct Progress {
    verbose: bool,
    bars: Option<Bars>,
    /// What is left, and since when that is known.
    left: Arc<Mutex<Option<(Left, Instant)>>>,
}

/// One bar per running stage, and one for everything below them.
struct Bars {
    all: MultiProgress,
    whole: ProgressBar,
    running: Mutex<BTreeMap<String, ProgressBar>>,
}

impl Progress {
    /// Bars if standard error is a terminal.
    pub fn start(verbose: bool) -> Progress {
        let left = Arc::default();
        let bars = std::io::stderr().is_terminal().then(|| Bars::new(Arc::clone(&left)));
        Progress { verbose, bars, left }
    }

    fn say(&self, line: &str) {
        match &self.bars {
            Some(bars) => {
                // Without a terminal underneath any more there is nobody to tell.
                let _ = bars.all.println(line);
            }
            None => tell(line),
        }
    }

    fn started(&self, name: &str, cores: u32) {
        match &self.bars {
            Some(bars) => bars.start(name),
            None => {
                self.say(&format!("{name}: started on {cores} core{}", if cores == 1 { "" } else { "s" }))
            }
        }
    }

    fn ended(&self, name: &str) {
        if let Some(bars) = &self.bars {
            bars.end(name);
        }
    }

    /// Bars show it from now on; a pipe is told once.
    fn left(&self, left: Left) {
        let before = lock(&self.left).replace((left, Instant::now()));
        if self.bars.is_none() && before.is_none() && left.seconds >= 1.0 {
            self.say(&format!("{} to go by what earlier builds took", in_words(left, Duration::ZERO)));
        }
    }

    fn said(&self, name: &str, message: &PluginMessage) {
        match message {
            PluginMessage::Progress(progress) => {
                if let Some(bars) = &self.bars {
                    bars.advance(name, progress.fraction, &progress.phase);
                }
            }
            PluginMessage::Log(line) if self.verbose || matches!(line.level.as_str(), "warn" | "error") => {
                self.say(&format!("{name}: {}: {}", line.level, line.message));
            }
            _ => {}
        }
    }

    fn finished(&self, name: &str, outcome: Outcome, seconds: f64) {
        self.ended(name);
        if let Some(bars) = &self.bars {
            bars.whole.inc(1);
        }
        match outcome {
            Outcome::Executed => self.say(&format!("{name}: done in {seconds:.2} s")),
            Outcome::Shared => self.say(&format!("{name}: shared with another run, {seconds:.2} s")),
            Outcome::Hit if self.verbose => self.say(&format!("{name}: unchanged")),
            Outcome::Hit => {}
        }
    }
}

impl Observer for Progress {
    fn event(&self, event: &Event<'_>) {
        match event {
            Event::Planned { stages } => {
                if let Some(bars) = &self.bars {
                    bars.whole.set_length(*stages as u64);
                }
            }
            Event::Left(left) => self.left(*left),
            Event::Started { stage, cores } => self.started(&label(stage), *cores),
            Event::Said { stage, message } => self.said(&label(stage), message),
            Event::Finished { stage, outcome, seconds } => self.finished(&label(stage), *outcome, *seconds),
            Event::Failed { stage } => {
                self.ended(&label(stage));
                self.say(&format!("{}: failed", label(stage)));
            }
            Event::Note { text } => self.say(text),
            Event::Rebuilding { digest } => {
                self.say(&format!("artefact {} is damaged or gone, building it again", digest.short()));
            }
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bars) = &self.bars {
            bars.whole.finish_and_clear();
        }
    }
}

impl Bars {
    fn new(left: Arc<Mutex<Option<(Left, Instant)>>>) -> Bars {
        let say_left = move |_: &ProgressState, out: &mut dyn Write| {
            let words = lock(&left).map(|(left, since)| in_words(left, since.elapsed()) + " left");
            // A bar that cannot be drawn is not worth an error.
            let _ = out.write_str(&words.unwrap_or_default());
        };
        let style = style("  {prefix:<24} {bar:24} {pos:>3} of {len}  {elapsed:>4}  {left}");
        let all = MultiProgress::new();
        let whole =
            all.add(ProgressBar::new(0).with_style(style.with_key("left", say_left)).with_prefix("stages"));
        Bars { all, whole, running: Mutex::default() }
    }

    fn start(&self, name: &str) {
        let style = style("  {prefix:<24} {bar:24} {percent:>3} %  {elapsed:>4}, {eta:>4} left  {msg}");
        let bar = ProgressBar::new(1000).with_style(style).with_prefix(name.to_owned());
        let bar = self.all.insert_before(&self.whole, bar);
        bar.enable_steady_tick(TICK);
        self.whole.enable_steady_tick(TICK);
        lock(&self.running).insert(name.to_owned(), bar);
    }

    fn advance(&self, name: &str, fraction: f64, phase: &str) {
        if let Some(bar) = lock(&self.running).get(name) {
            bar.set_position((fraction.clamp(0.0, 1.0) * 1000.0) as u64);
            bar.set_message(phase.to_owned());
        }
    }

    fn end(&self, name: &str) {
        if let Some(bar) = lock(&self.running).remove(name) {
            bar.finish_and_clear();
            self.all.remove(&bar);
        }
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the template is well-formed").progress_chars("━╸ ")
}

/// `about 2 min 05 s`; `at least` when not everything is known.
fn in_words(left: Left, since: Duration) -> String {
    let seconds = (left.seconds - since.as_secs_f64()).max(0.0).round() as u64;
    let how = if left.unknown == 0 { "about" } else { "at least" };
    match seconds {
        0..60 => format!("{how} {seconds} s"),
        60..3600 => format!("{how} {} min {:02} s", seconds / 60, seconds % 60),
        _ => format!("{how} {} h {:02} min", seconds / 3600, seconds % 3600 / 60),
    }
}

fn label(stage: &StageName<'_>) -> String {
    format!("{}/{}", stage.build, stage.stage)
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_said_in_words() {
        let check = |seconds, unknown, since, expected: &str| {
            assert_eq!(in_words(Left { seconds, unknown }, Duration::from_secs(since)), expected);
        };
        check(12.4, 0, 0, "about 12 s");
        check(12.4, 1, 2, "at least 10 s");
        check(12.4, 0, 20, "about 0 s");
        check(125.0, 0, 0, "about 2 min 05 s");
        check(7500.0, 0, 0, "about 2 h 05 min");
    }
}
