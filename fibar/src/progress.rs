//! What a person sees while a build runs: bars with estimates on a terminal, plain lines in a pipe.

use fibar_core::protocol::PluginMessage;
use fibar_engine::build::{Event, Observer, Outcome, StageName};
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Progress on standard error.
pub struct Progress {
    verbose: bool,
    bars: Option<MultiProgress>,
    running: Mutex<BTreeMap<String, ProgressBar>>,
}

impl Progress {
    /// Bars if standard error is a terminal.
    pub fn start(verbose: bool) -> Progress {
        let bars = std::io::stderr().is_terminal().then(MultiProgress::new);
        Progress { verbose, bars, running: Mutex::default() }
    }

    fn say(&self, line: &str) {
        match &self.bars {
            Some(bars) => {
                // Without a terminal underneath any more there is nobody to tell.
                let _ = bars.println(line);
            }
            None => eprintln!("{line}"),
        }
    }

    fn start_bar(&self, name: &str) {
        let Some(bars) = &self.bars else { return };
        let template = "  {prefix:<24} {bar:24} {percent:>3} %  {elapsed:>4}, {eta:>4} left  {msg}";
        let style = ProgressStyle::with_template(template).expect("the template is well-formed");
        let bar = bars
            .add(ProgressBar::new(1000).with_style(style.progress_chars("━╸ ")).with_prefix(name.to_owned()));
        bar.enable_steady_tick(Duration::from_millis(200));
        self.bars_by_name().insert(name.to_owned(), bar);
    }

    fn end_bar(&self, name: &str) {
        if let (Some(bars), Some(bar)) = (&self.bars, self.bars_by_name().remove(name)) {
            bar.finish_and_clear();
            bars.remove(&bar);
        }
    }

    fn bars_by_name(&self) -> std::sync::MutexGuard<'_, BTreeMap<String, ProgressBar>> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn said(&self, name: &str, message: &PluginMessage) {
        match message {
            PluginMessage::Progress(progress) => {
                if let Some(bar) = self.bars_by_name().get(name) {
                    bar.set_position((progress.fraction.clamp(0.0, 1.0) * 1000.0) as u64);
                    bar.set_message(progress.phase.clone());
                }
            }
            PluginMessage::Log(line) if self.verbose || matches!(line.level.as_str(), "warn" | "error") => {
                self.say(&format!("{name}: {}: {}", line.level, line.message));
            }
            _ => {}
        }
    }
}

impl Observer for Progress {
    fn event(&self, event: &Event<'_>) {
        match event {
            Event::Planned { .. } => {}
            Event::Started { stage, cores } => {
                let name = label(stage);
                if self.bars.is_none() {
                    self.say(&format!(
                        "{name}: started on {cores} core{}",
                        if *cores == 1 { "" } else { "s" }
                    ));
                }
                self.start_bar(&name);
            }
            Event::Said { stage, message } => self.said(&label(stage), message),
            Event::Finished { stage, outcome, seconds } => {
                let name = label(stage);
                self.end_bar(&name);
                match outcome {
                    Outcome::Executed => self.say(&format!("{name}: done in {seconds:.2} s")),
                    Outcome::Shared => self.say(&format!("{name}: shared with another run, {seconds:.2} s")),
                    Outcome::Hit if self.verbose => self.say(&format!("{name}: unchanged")),
                    Outcome::Hit => {}
                }
            }
            Event::Failed { stage } => {
                self.end_bar(&label(stage));
                self.say(&format!("{}: failed", label(stage)));
            }
            Event::Note { text } => self.say(text),
            Event::Rebuilding { digest } => {
                self.say(&format!("artefact {} is damaged or gone, building it again", digest.short()));
            }
        }
    }
}

fn label(stage: &StageName<'_>) -> String {
    format!("{}/{}", stage.build, stage.stage)
}
