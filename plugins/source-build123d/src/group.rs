//! A child process with all that it starts: what can be asked of it and how it ends. The one file that knows Unix.

use std::process::{Child, Command, ExitStatus};

/// A child that leads its own process group; dropping it kills the group.
pub struct Group {
    child: Child,
    ended: bool,
}

impl Group {
    /// Starts the command.
    pub fn start(command: &mut Command) -> std::io::Result<Group> {
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        Ok(Group { child: command.spawn()?, ended: false })
    }

    /// The child.
    pub fn child(&mut self) -> &mut Child {
        &mut self.child
    }

    /// How the child ended, if it has; whatever it started ends with it.
    pub fn try_wait(&mut self) -> std::io::Result<Option<ExitStatus>> {
        if !self.has_ended()? {
            return Ok(None);
        }
        self.kill().map(Some)
    }

    /// Kills the whole group and collects the child.
    pub fn kill(&mut self) -> std::io::Result<ExitStatus> {
        if !std::mem::replace(&mut self.ended, true) {
            self.kill_all();
        }
        self.child.wait()
    }
}

impl Drop for Group {
    fn drop(&mut self) {
        let _ = self.kill();
    }
}

#[cfg(unix)]
impl Group {
    /// Whether the child has ended, without collecting it, so that its number still is the group's.
    fn has_ended(&self) -> std::io::Result<bool> {
        use rustix::process::{WaitId, WaitIdOptions, waitid};
        if self.ended {
            return Ok(true);
        }
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        Ok(waitid(WaitId::Pid(self.pid()), options)?.is_some())
    }

    /// Asks the child to write down where it is; see `tell_where_it_died` in `python/runner.py`.
    pub fn ask_where_it_is(&self) {
        let _ = rustix::process::kill_process(self.pid(), rustix::process::Signal::USR1);
    }

    fn kill_all(&mut self) {
        let _ = rustix::process::kill_process_group(self.pid(), rustix::process::Signal::KILL);
    }

    fn pid(&self) -> rustix::process::Pid {
        let number = i32::try_from(self.child.id()).expect("process numbers fit in i32");
        rustix::process::Pid::from_raw(number).expect("process numbers are not 0")
    }
}

#[cfg(not(unix))]
impl Group {
    fn has_ended(&mut self) -> std::io::Result<bool> {
        Ok(self.child.try_wait()?.is_some())
    }

    /// Nobody can be asked.
    pub fn ask_where_it_is(&self) {}

    fn kill_all(&mut self) {
        let _ = self.child.kill();
    }
}

/// The signal that ended a process, in words.
pub fn signal_of(status: ExitStatus) -> Option<String> {
    #[cfg(unix)]
    {
        let number = std::os::unix::process::ExitStatusExt::signal(&status)?;
        let name = match number {
            4 => "an illegal instruction",
            6 => "an abort",
            7 => "a bus error",
            8 => "an arithmetic error",
            9 => "being killed (out of memory?)",
            11 => "a segmentation fault",
            _ => return Some(format!("signal {number}")),
        };
        Some(name.into())
    }
    #[cfg(not(unix))]
    {
        let _ = status;
        None
    }
}
