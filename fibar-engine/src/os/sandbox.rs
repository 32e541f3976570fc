//! The sandbox on Linux: namespaces of a user's own, in which a stage sees the system's programs, its plugin, its inputs
//! and its out folder, and neither network nor processes nor anything else.
//!
//! ```text
//! fibar ── keeper (dies with fibar; leads the process group) ── init (PID 1 of the stage's world) ── the stage
//! ```
//!
//! When the keeper is killed, init dies with it, and the kernel ends every process below init: nothing that a stage
//! starts can outlive it, however the host ends. What is mounted where is decided before the fork ([`View`], [`Plan`]);
//! between fork and exec only system calls are made.

mod enter;
mod mounts;

pub use mounts::View;

use mounts::Plan;
use std::io::Result;
use std::os::unix::process::CommandExt;
use std::process::Command;
use std::sync::OnceLock;

/// Where a stage finds its private folder.
pub const WORK: &str = "/stage";

/// Where a stage's plugin lies.
pub const PLUGIN: &str = "/plugin";

/// Why this system grants no sandbox; asked once, by making one.
pub fn available() -> std::result::Result<(), String> {
    static PROBE: OnceLock<std::result::Result<(), String>> = OnceLock::new();
    PROBE.get_or_init(|| probe().map_err(|e| refusal(&e))).clone()
}

fn refusal(error: &std::io::Error) -> String {
    let reason = match error.raw_os_error() {
        // What the kernel answers to one namespace too many (namespaces(7)), whatever the words of that number are.
        Some(libc::ENOSPC) => "their number is limited (/proc/sys/user/max_user_namespaces)".into(),
        Some(libc::EPERM | libc::EACCES) => {
            format!("they are forbidden here, as in many containers: {error}")
        }
        _ => error.to_string(),
    };
    format!("the system grants no user namespaces: {reason}")
}

fn probe() -> Result<()> {
    let folder = std::env::temp_dir().join(crate::store::unique_name("fibar-probe"));
    std::fs::create_dir(&folder)?;
    let view = View { scratch: folder.clone(), ..View::default() };
    let mut command = Command::new("true");
    let status = confine_then(&mut command, &view, enter::Then::Leave).and_then(|()| command.status());
    let _ = std::fs::remove_dir_all(&folder);
    match status?.code() {
        Some(0) => Ok(()),
        _ => Err(std::io::Error::other("a process of its own world does not start")),
    }
}

/// Makes the command run in a world that holds nothing but the view.
pub fn confine(command: &mut Command, view: &View) -> Result<()> {
    confine_then(command, view, enter::Then::Exec)
}

fn confine_then(command: &mut Command, view: &View, then: enter::Then) -> Result<()> {
    let plan = Plan::of(view)?;
    let parent = std::process::id() as libc::pid_t;
    command.process_group(0);
    // SAFETY: `enter` makes system calls only, on memory prepared in `plan`.
    unsafe { command.pre_exec(move || enter::enter(&plan, parent, then)) };
    Ok(())
}
