//! Process groups, signals and machine facts on Unix.

use std::os::unix::process::CommandExt;
use std::process::{Child, Command};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

static INTERRUPTS: AtomicU32 = AtomicU32::new(0);

extern "C" fn note_interrupt(_: libc::c_int) {
    INTERRUPTS.fetch_add(1, Ordering::Relaxed);
}

/// From now on SIGINT, SIGTERM and SIGHUP are counted instead of ending the process.
pub fn catch_interrupts() {
    let handler = note_interrupt as extern "C" fn(libc::c_int);
    for signal in [libc::SIGINT, libc::SIGTERM, libc::SIGHUP] {
        // SAFETY: the handler only touches an atomic, which is async-signal-safe.
        unsafe { libc::signal(signal, handler as libc::sighandler_t) };
    }
}

/// How many signals were caught.
pub fn interrupts() -> u32 {
    INTERRUPTS.load(Ordering::Relaxed)
}

/// Puts the child into a process group of its own that dies with the calling thread.
pub fn isolate(command: &mut Command) {
    command.process_group(0);
    #[cfg(target_os = "linux")]
    {
        let parent = std::process::id() as libc::pid_t;
        // SAFETY: prctl and getppid are async-signal-safe and nothing is allocated between fork and exec.
        unsafe {
            command.pre_exec(move || {
                if libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL) != 0 {
                    return Err(std::io::Error::last_os_error());
                }
                if libc::getppid() != parent {
                    return Err(std::io::Error::from(std::io::ErrorKind::Interrupted));
                }
                Ok(())
            });
        }
    }
}

/// Kills the process group of a child made with [`isolate`], stragglers included.
pub fn kill_group(child: &Child) {
    let group = child.id() as libc::pid_t;
    // SAFETY: kill has no memory effects; the group is ours since the child leads it.
    unsafe { libc::kill(-group, libc::SIGKILL) };
}

/// The memory of the machine, MB; a guess where it cannot be asked.
pub fn memory_mb() -> u64 {
    #[cfg(target_os = "linux")]
    {
        let info = rustix::system::sysinfo();
        (info.totalram as u64).saturating_mul(u64::from(info.mem_unit)) / (1024 * 1024)
    }
    #[cfg(not(target_os = "linux"))]
    {
        8192
    }
}

/// Makes a file readable by all and writable by nobody; `executable` keeps it runnable.
pub fn make_read_only(path: &std::path::Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o444))
}

/// Files have a time of change that no program can set.
pub const KEEPS_CHANGE_TIMES: bool = true;

/// What tells a changed file from an unchanged one without reading it: device, inode, modification and change time.
pub fn file_identity(meta: &std::fs::Metadata) -> [i64; 4] {
    use std::os::unix::fs::MetadataExt;
    let nanos = |s: i64, ns: i64| s.wrapping_mul(1_000_000_000).wrapping_add(ns);
    let modified = nanos(meta.mtime(), meta.mtime_nsec());
    let changed = nanos(meta.ctime(), meta.ctime_nsec());
    [meta.dev() as i64, meta.ino() as i64, modified, changed]
}

/// What tells one file from another: device and inode.
pub fn same_file(meta: &std::fs::Metadata) -> (u64, u64) {
    use std::os::unix::fs::MetadataExt;
    (meta.dev(), meta.ino())
}

/// Whether a file has other names too, through which it could still be written.
pub fn has_other_names(meta: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    meta.is_file() && meta.nlink() > 1
}

/// Whether the permissions let somebody run the file.
pub fn is_executable(meta: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::PermissionsExt;
    meta.is_file() && meta.permissions().mode() & 0o111 != 0
}

/// Whether the child has ended, without collecting it: its process group stays ours until it is.
fn has_ended(child: &Child) -> bool {
    use rustix::process::{Pid, WaitId, WaitIdOptions, waitid};
    let Some(pid) = Pid::from_raw(child.id() as i32) else { return true };
    let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
    waitid(WaitId::Pid(pid), options).is_ok_and(|status| status.is_some())
}

/// Waits until the child has ended, at most so long, without collecting it.
pub fn await_end(child: &Child, patience: Duration) {
    let deadline = Instant::now() + patience;
    while !has_ended(child) {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return;
        }
        pause(child, left);
    }
}

/// Sleeps until the child ends, or for a while.
#[cfg(target_os = "linux")]
fn pause(child: &Child, longest: Duration) {
    // SAFETY: plain system calls; the descriptor is ours and closed here.
    unsafe {
        let fd = libc::syscall(libc::SYS_pidfd_open, child.id(), 0) as libc::c_int;
        if fd < 0 {
            std::thread::sleep(Duration::from_millis(1));
            return;
        }
        let mut watch = libc::pollfd { fd, events: libc::POLLIN, revents: 0 };
        let millis = longest.as_millis().clamp(1, 60_000) as libc::c_int;
        libc::poll(&raw mut watch, 1, millis);
        libc::close(fd);
    }
}

/// Sleeps for a short while.
#[cfg(not(target_os = "linux"))]
fn pause(_: &Child, longest: Duration) {
    std::thread::sleep(longest.min(Duration::from_millis(2)));
}
