//! One run of `python/runner.py`: what it is asked, how it may end, and in what words its failures reach the user.

use crate::child::{self, End};
use crate::group;
use crate::manifest::{self, Refusal, RefusalKind, Shape};
use crate::params::{Params, Value};
use fibar_plugin::{Job, StageError};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};
use std::time::Duration;

/// The program, file by file. It is unpacked for each run, so that it is part of this executable's digest.
const PROGRAM: [(&str, &str); 8] = [
    ("runner.py", include_str!("../python/runner.py")),
    ("refusal.py", include_str!("../python/refusal.py")),
    ("script_file.py", include_str!("../python/script_file.py")),
    ("exchange_file.py", include_str!("../python/exchange_file.py")),
    ("step_assembly.py", include_str!("../python/step_assembly.py")),
    ("assembly.py", include_str!("../python/assembly.py")),
    ("plausible.py", include_str!("../python/plausible.py")),
    ("triangles.py", include_str!("../python/triangles.py")),
];

/// The CAD kernel, ready to run.
pub struct Kernel<'a> {
    /// The interpreter that has build123d.
    pub python: PathBuf,
    /// What to do.
    pub params: &'a Params,
}

/// `REQUEST.json` of the runner.
#[derive(Serialize)]
struct Request {
    shown: String,
    parameters: BTreeMap<String, Value>,
    chord_error_mm: f64,
    angle_rad: f64,
    scale: f64,
    turn: [[f64; 3]; 3],
    size_mm: [f64; 2],
    threads: usize,
}

impl Kernel<'_> {
    /// Runs the script or reads the file; what comes back has been checked.
    pub fn run(&self, job: &mut Job) -> Result<Shape, StageError> {
        let folder = tempfile::tempdir()?;
        let mut command = self.command(folder.path(), job)?;
        let patience = Duration::from_secs_f64(self.params.timeout_s);
        let end = child::run(&mut command, patience, job)?;
        let out = folder.path().join("out");
        match end {
            End::Exited(_) if out.join("manifest.json").exists() => match manifest::read(&out)? {
                Ok(shape) => Ok(shape),
                Err(refusal) => Err(self.refused(refusal)),
            },
            End::Exited(status) => Err(self.died(status, &out)),
            End::OutOfTime => Err(self.out_of_time(&out)),
            End::NotFound => Err(self.environment_is_broken("its Python is gone")),
        }
    }

    fn command(&self, folder: &Path, job: &Job) -> Result<Command, StageError> {
        let (program, out, work) = (folder.join("program"), folder.join("out"), folder.join("work"));
        for made in [&program, &out, &work] {
            std::fs::create_dir(made)?;
        }
        for (name, text) in PROGRAM {
            std::fs::write(program.join(name), text)?;
        }
        let request = serde_json::to_vec(&self.request(job)?).expect("a request is plain data");
        std::fs::write(folder.join("request.json"), request)?;
        let source = std::path::absolute(self.params.path.path())?;
        let mut command = Command::new(&self.python);
        // Isolated as by -I, but that would also ignore the hash seed, and order in sets would change from run to run.
        command.args(["-s", "-P"]).arg(program.join("runner.py"));
        command.arg(source).arg(&out).arg(folder.join("request.json"));
        command
            .env_clear()
            .current_dir(&work)
            .env("HOME", &work)
            .env("TMPDIR", &work)
            .env("PYTHONHASHSEED", "0");
        command.env("PATH", "/usr/local/bin:/usr/bin:/bin").env("LANG", "C.UTF-8").env("TZ", "UTC");
        command.env("PYTHONDONTWRITEBYTECODE", "1").env("OMP_NUM_THREADS", job.threads().to_string());
        Ok(command)
    }

    fn request(&self, job: &Job) -> Result<Request, StageError> {
        let mut parameters = self.params.parameters.clone();
        for (name, file) in &self.params.files {
            let path = std::path::absolute(file.path())?.to_string_lossy().into_owned();
            if parameters.insert(name.clone(), Value::Text(path)).is_some() {
                let message = format!("`{name}` is both among parameters and files");
                return Err(StageError::user(message).param(format!("/files/{name}")));
            }
        }
        Ok(Request {
            shown: self.shown(),
            parameters,
            chord_error_mm: self.params.chord_error_mm,
            angle_rad: self.params.angle_deg.to_radians(),
            scale: self.params.scale,
            turn: self.params.up.turn_to_z(),
            size_mm: self.params.size_mm,
            threads: job.threads(),
        })
    }

    /// The name of the file in messages: the path that the stage was given.
    fn shown(&self) -> String {
        self.params.path.path().to_string_lossy().into_owned()
    }

    fn refused(&self, refusal: Refusal) -> StageError {
        let error = match refusal.kind {
            RefusalKind::Parameter => {
                let group = match &refusal.parameter {
                    Some(name) if self.params.files.contains_key(name) => "files",
                    _ => "parameters",
                };
                let name = refusal.parameter.unwrap_or_default();
                StageError::user(refusal.message).param(format!("/{group}/{name}"))
            }
            RefusalKind::Environment => return self.environment_is_broken(&refusal.message),
            RefusalKind::Script | RefusalKind::File | RefusalKind::Size | RefusalKind::NoSolid => {
                StageError::input(refusal.message).param("/path")
            }
        };
        match refusal.hint {
            Some(hint) => error.hint(hint),
            None => error,
        }
    }

    fn died(&self, status: ExitStatus, out: &Path) -> StageError {
        let how = match group::signal_of(status) {
            Some(signal) => format!("ended by {signal}"),
            None => format!("ended before it was finished ({status})"),
        };
        let message = format!("{}: the process {how}", self.place(out));
        StageError::input(message).param("/path").hint("the log of the stage has the last that it printed")
    }

    fn out_of_time(&self, out: &Path) -> StageError {
        let message = format!("{}: not finished after {} s", self.place(out), self.params.timeout_s);
        let hint = "does it end by itself? If so, set a larger timeout_s, or a coarser chord_error_mm";
        StageError::input(message).param("/path").hint(hint)
    }

    fn environment_is_broken(&self, why: &str) -> StageError {
        let environment = self.python.ancestors().nth(2).unwrap_or(&self.python);
        let hint = format!("remove the folder {} and build again", environment.display());
        StageError::resource(format!("the environment for build123d is broken: {why}")).hint(hint)
    }

    /// File and, if the runner could still write it down, line that was running.
    fn place(&self, out: &Path) -> String {
        let shown = self.shown();
        let text = std::fs::read_to_string(out.join("fault.txt")).unwrap_or_default();
        match line_in(&text, &shown) {
            Some(line) => format!("{shown}:{line}"),
            None => shown,
        }
    }
}

/// The innermost line inside the script, from a trace of Python's faulthandler, whose lines read
/// `File "NAME", line N in FUNCTION`, innermost first.
fn line_in(trace: &str, script: &str) -> Option<u64> {
    let start = format!("File \"{script}\", line ");
    let rest = trace.lines().find_map(|line| line.trim_start().strip_prefix(&start))?;
    rest.split(' ').next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_innermost_line_of_the_script_is_found() {
        let check = |trace: &str, expected| assert_eq!(line_in(trace, "in/a.py"), expected, "{trace}");
        check("", None);
        check("Stack:\n  File \"in/b.py\", line 3 in f\n", None);
        check(
            "  File \"x.py\", line 9 in s\n  File \"in/a.py\", line 3 in f\n  File \"in/a.py\", line 4 in g",
            Some(3),
        );
        check("  File \"in/a.py\", line many in f", None);
    }
}
