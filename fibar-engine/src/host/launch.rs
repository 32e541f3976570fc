//! How a plugin is started: its environment variables, and the sandbox around it.

use crate::os::{self, sandbox};
use crate::plugin::programs;
use fibar_core::protocol::Description;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// How glibc hands out memory: large pages for large arrays, as fresh memory costs a page fault each 4 kB otherwise; and arrays
/// below 256 MB are kept for the next one, as the kernel clears what it hands out anew.
const ALLOCATION: &str =
    "glibc.malloc.hugetlb=1:glibc.malloc.mmap_threshold=268435456:glibc.malloc.trim_threshold=536870912";

/// Whether stages run in a sandbox.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sandbox {
    /// Where the system grants one.
    #[default]
    Auto,
    /// Never.
    Off,
    /// Always; without one nothing runs.
    Require,
}

/// What is needed to start a plugin.
#[derive(Debug, Clone, Copy)]
pub struct Launch<'a> {
    /// The plugin.
    pub executable: &'a Path,
    /// What it says about itself; nothing is known before it is asked.
    pub description: Option<&'a Description>,
    /// Its private folder, with `in/` and `tmp/`.
    pub folder: &'a Path,
    /// An empty folder for the sandbox's own use.
    pub scratch: &'a Path,
    /// Further folders it may read.
    pub readable: &'a [PathBuf],
    /// Cores it may keep busy.
    pub threads: u32,
    /// How it is confined.
    pub sandbox: Sandbox,
}

impl Sandbox {
    /// Whether a run would be confined, or why it would not.
    pub fn granted(self) -> Result<(), String> {
        match self {
            Sandbox::Off => Err("the sandbox is switched off".into()),
            Sandbox::Auto | Sandbox::Require => sandbox::available(),
        }
    }
}

impl Launch<'_> {
    /// The command, ready to be spawned.
    pub fn command(&self) -> std::io::Result<Command> {
        let programs = self.programs();
        match self.sandbox.granted() {
            Ok(()) => self.confined(&programs),
            Err(reason) if self.sandbox == Sandbox::Require => Err(std::io::Error::other(reason)),
            Err(_) => {
                let mut command = Command::new(self.executable);
                self.set_variables(&mut command, self.folder, &programs);
                command.current_dir(self.folder);
                os::isolate(&mut command);
                Ok(command)
            }
        }
    }

    /// Programs it starts: those it declares, and its own interpreter if it is a script.
    fn programs(&self) -> Vec<PathBuf> {
        let declared = self.description.map_or(&[][..], |d| &d.programs);
        let declared = declared.iter().filter_map(|name| programs::find(name));
        declared.chain(programs::interpreter_of(self.executable)).collect()
    }

    fn confined(&self, programs: &[PathBuf]) -> std::io::Result<Command> {
        let name = self.executable.file_name().unwrap_or_default();
        let inside = Path::new(sandbox::PLUGIN).join(name);
        let mut command = Command::new(&inside);
        self.set_variables(&mut command, Path::new(sandbox::WORK), programs);
        let mut read_only = vec![(self.executable.to_owned(), inside)];
        let beside = self.executable.parent().unwrap_or(Path::new("."));
        for file in self.description.map_or(&[][..], |d| &d.runtime_files) {
            read_only.push((beside.join(file), Path::new(sandbox::PLUGIN).join(file)));
        }
        let folders = programs.iter().filter_map(|program| programs::folder_of(program));
        read_only.extend(folders.chain(self.readable.iter().cloned()).map(|f| (f.clone(), f)));
        let work = Some(self.folder.to_owned());
        let view = sandbox::View { scratch: self.scratch.to_owned(), work, read_only };
        sandbox::confine(&mut command, &view)?;
        Ok(command)
    }

    /// The environment a plugin sees: nothing of the user's, only what every run has alike.
    fn set_variables(&self, command: &mut Command, folder: &Path, programs: &[PathBuf]) {
        let mut path = OsString::from(programs::SYSTEM_PATH);
        for folder in programs.iter().filter_map(|p| p.parent()).filter(|p| programs::folder_of(p).is_some())
        {
            path.push(":");
            path.push(folder);
        }
        let threads = self.threads.to_string();
        command.env_clear();
        command.env("PATH", path).env("LANG", "C.UTF-8").env("TZ", "UTC");
        command.env("RAYON_NUM_THREADS", &threads).env("OMP_NUM_THREADS", &threads);
        command.env("PYTHONDONTWRITEBYTECODE", "1").env("PYTHONHASHSEED", "0");
        if cfg!(all(target_os = "linux", target_env = "gnu")) {
            command.env("GLIBC_TUNABLES", ALLOCATION);
        }
        command.env("HOME", folder.join("tmp")).env("TMPDIR", folder.join("tmp"));
        if cfg!(windows) {
            let kept = ["SYSTEMROOT", "PATH"].into_iter();
            command.envs(kept.filter_map(|k| std::env::var_os(k).map(|v| (k, v))));
        }
    }
}
