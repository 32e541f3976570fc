//! The Python that has build123d: found, or set up once per user from a lock file with the hash of every package.
//!
//! `python/set_up.py` does the work with any Python 3.11 to 3.14 on the path. Lock file and programs are part of this
//! executable, so that they are part of its digest.

use crate::child::{self, End};
use crate::listener::Listener;
use fibar_plugin::StageError;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};
use std::time::Duration;

const SET_UP: &str = include_str!("../python/set_up.py");
const REQUIREMENTS: &str = include_str!("../python/requirements.txt");

/// Interpreters to try, in this order.
const PYTHONS: [&str; 5] = ["python3.11", "python3.12", "python3.13", "python3.14", "python3"];
/// About 1 GB is fetched.
const PATIENCE: Duration = Duration::from_secs(1800);

/// The interpreter of the environment. Making it takes about a minute, which is said to the listener; other processes that
/// need it meanwhile wait.
pub fn ensure(listener: &mut dyn Listener) -> Result<PathBuf, StageError> {
    let folder = tempfile::tempdir()?;
    let (script, lock) = (folder.path().join("set_up.py"), folder.path().join("requirements.txt"));
    std::fs::write(&script, SET_UP)?;
    std::fs::write(&lock, REQUIREMENTS)?;
    let mut unsuitable = Vec::new();
    for name in PYTHONS {
        let mut command = Command::new(name);
        command.args(["-I", "-S"]).arg(&script).arg(&lock).arg(fallback());
        match attempt(&mut command, listener)? {
            Attempt::Ready(python) => return Ok(python),
            Attempt::Absent => {}
            Attempt::Unsuitable(why) => unsuitable.push(format!("{name}: {why}")),
            Attempt::Failed(why) => return Err(not_made(&why)),
        }
    }
    Err(no_python(&unsuitable))
}

/// Where environments go if the user has no writable home: beside this executable.
fn fallback() -> PathBuf {
    let own = std::env::current_exe().unwrap_or_default();
    own.parent().unwrap_or(Path::new(".")).join("environments")
}

enum Attempt {
    Ready(PathBuf),
    Absent,
    Unsuitable(String),
    Failed(String),
}

fn attempt(command: &mut Command, listener: &mut dyn Listener) -> Result<Attempt, StageError> {
    let (mut python, mut failure) = (None, None);
    let end = child::run(command, PATIENCE, listener, &mut |line, listener| match line.split_once(' ') {
        Some(("python", path)) => python = Some(PathBuf::from(path)),
        Some(("note", text)) => listener.say(text),
        Some(("failed", text)) => failure = Some(text.to_string()),
        _ => failure = failure.take().or(Some(line.to_string())),
    });
    Ok(match (end?, python, failure) {
        (End::NotFound, _, _) => Attempt::Absent,
        (End::Exited(status), Some(python), _) if status.success() => Attempt::Ready(python),
        (End::OutOfTime, _, _) => Attempt::Failed(format!("it took more than {} s", PATIENCE.as_secs())),
        (End::Exited(status), _, failure) => judge(status, failure.unwrap_or_else(|| status.to_string())),
    })
}

fn judge(status: ExitStatus, why: String) -> Attempt {
    const NOT_MADE: i32 = 8;
    if status.code() == Some(NOT_MADE) { Attempt::Failed(why) } else { Attempt::Unsuitable(why) }
}

fn no_python(unsuitable: &[String]) -> StageError {
    let found = if unsuitable.is_empty() { String::new() } else { format!(" ({})", unsuitable.join("; ")) };
    StageError::resource(format!("build123d needs Python 3.11 to 3.14, and there is none on the path{found}"))
        .hint("install it, e.g. apt-get install python3 python3-venv")
}

fn not_made(why: &str) -> StageError {
    let hint = if why.contains("ensurepip") {
        "install the venv module, e.g. apt-get install python3-venv"
    } else {
        "behind a proxy, or to see more, run `source-build123d --set-up` in a terminal once"
    };
    StageError::resource(format!("the environment for build123d cannot be set up: {why}")).hint(hint)
}
