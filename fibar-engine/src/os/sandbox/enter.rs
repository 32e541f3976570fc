//! From the forked child to the stage's world. Nothing here allocates or takes a lock: the host has threads, and between
//! fork and exec only system calls are safe.

use super::mounts::{Bind, Plan};
use libc::{c_int, c_ulong, pid_t};
use std::ffi::CStr;
use std::io::{Error, Result};
use std::ptr::null;

/// What happens inside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Then {
    /// The command is run.
    Exec,
    /// Nothing: it was only asked whether one gets in.
    Leave,
}

/// Why a process other than the stage could not do its part; seen as the exit code of the stage.
const LOST: c_int = 127;

/// Runs in the child that becomes the keeper; returns in the process that becomes the stage.
pub(super) fn enter(plan: &Plan, parent: pid_t, then: Then) -> Result<()> {
    let worlds = libc::CLONE_NEWUSER
        | libc::CLONE_NEWNS
        | libc::CLONE_NEWPID
        | libc::CLONE_NEWNET
        | libc::CLONE_NEWIPC
        | libc::CLONE_NEWUTS;
    // SAFETY (all blocks of this file): plain system calls on memory that outlives them, in a process with one thread.
    check(unsafe { libc::unshare(worlds) })?;
    die_with_parent()?;
    if unsafe { libc::getppid() } != parent {
        return Err(Error::from_raw_os_error(libc::EINTR));
    }
    write(c"/proc/self/setgroups", b"deny")?;
    write(c"/proc/self/uid_map", &plan.user_map)?;
    write(c"/proc/self/gid_map", &plan.group_map)?;
    let keeper = check_long(unsafe { libc::syscall(libc::SYS_pidfd_open, libc::getpid(), 0) })? as c_int;
    match fork()? {
        0 => {}
        init => keep(init),
    }
    watch(keeper)?;
    build(plan)?;
    match fork()? {
        0 => {}
        stage => reap_until(stage),
    }
    give_up_power()?;
    if then == Then::Leave {
        unsafe { libc::_exit(0) };
    }
    Ok(())
}

/// Folders of the new root that stages may write to, kept in memory.
const MEMORY: [&CStr; 2] = [c"dev/shm", c"tmp"];

/// Puts the new root together and moves into it.
fn build(plan: &Plan) -> Result<()> {
    mount(None, c"/", None, libc::MS_REC | libc::MS_PRIVATE, None)?;
    let small = Some(c"size=16m,mode=755");
    mount(Some(c"none"), &plan.root, Some(c"tmpfs"), libc::MS_NOSUID | libc::MS_NODEV, small)?;
    check(unsafe { libc::chdir(plan.root.as_ptr()) })?;
    for folder in &plan.folders {
        check(unsafe { libc::mkdir(folder.as_ptr(), 0o755) })?;
        // At once: what is made below it later must not be hidden.
        if MEMORY.contains(&folder.as_c_str()) {
            mount(Some(c"none"), folder, Some(c"tmpfs"), libc::MS_NOSUID | libc::MS_NODEV, None)?;
        }
    }
    for file in &plan.files {
        let fd = check(unsafe { libc::open(file.as_ptr(), libc::O_CREAT | libc::O_CLOEXEC, 0o644) })?;
        unsafe { libc::close(fd) };
    }
    for (target, name) in &plan.links {
        check(unsafe { libc::symlink(target.as_ptr(), name.as_ptr()) })?;
    }
    plan.binds.iter().try_for_each(bind)?;
    // While the old root is still there: the kernel shows the new processes only to who could see the old ones.
    let flags = libc::MS_NOSUID | libc::MS_NODEV | libc::MS_NOEXEC;
    mount(Some(c"proc"), c"proc", Some(c"proc"), flags, None)?;
    check_long(unsafe { libc::syscall(libc::SYS_pivot_root, c".".as_ptr(), c".".as_ptr()) })?;
    check(unsafe { libc::umount2(c".".as_ptr(), libc::MNT_DETACH) })?;
    protect(c"/", 0)?;
    check(unsafe { libc::chdir(c"/stage".as_ptr()) })?;
    Ok(())
}

fn bind(bind: &Bind) -> Result<()> {
    mount(Some(&bind.from), &bind.to, None, libc::MS_BIND | libc::MS_REC, None)?;
    if bind.read_only { protect(&bind.to, libc::AT_RECURSIVE) } else { Ok(()) }
}

/// Makes a mount read-only.
fn protect(path: &CStr, recursive: c_int) -> Result<()> {
    let attributes =
        libc::mount_attr { attr_set: libc::MOUNT_ATTR_RDONLY, attr_clr: 0, propagation: 0, userns_fd: 0 };
    let size = size_of::<libc::mount_attr>();
    check_long(unsafe {
        libc::syscall(libc::SYS_mount_setattr, libc::AT_FDCWD, path.as_ptr(), recursive, &attributes, size)
    })?;
    Ok(())
}

/// The first process of the new world dies with the keeper.
fn watch(keeper: c_int) -> Result<()> {
    die_with_parent()?;
    let mut watch = libc::pollfd { fd: keeper, events: libc::POLLIN, revents: 0 };
    if unsafe { libc::poll(&raw mut watch, 1, 0) } != 0 {
        unsafe { libc::_exit(LOST) };
    }
    Ok(())
}

/// The keeper: waits for init, then ends as the stage did.
fn keep(init: pid_t) -> ! {
    close_all();
    let code = wait_for(init);
    // A shell's way to say that a signal ended the stage; 130 is also how a stage says that it was cancelled.
    if code > 128 && code != 130 {
        unsafe {
            let no_core = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
            libc::setrlimit(libc::RLIMIT_CORE, &raw const no_core);
            libc::signal(code - 128, libc::SIG_DFL);
            libc::kill(libc::getpid(), code - 128);
        }
    }
    unsafe { libc::_exit(code) }
}

/// Init: collects whatever ends until the stage does; the kernel then ends the rest.
fn reap_until(stage: pid_t) -> ! {
    close_all();
    unsafe { libc::_exit(wait_for(stage)) }
}

/// The exit code of one child, others collected on the way; 128 + n after signal n.
fn wait_for(wanted: pid_t) -> c_int {
    loop {
        let mut status = 0;
        let ended = unsafe { libc::waitpid(-1, &raw mut status, 0) };
        if ended < 0 && Error::last_os_error().raw_os_error() != Some(libc::EINTR) {
            return LOST;
        }
        if ended == wanted {
            let signalled = libc::WIFSIGNALED(status);
            return if signalled { 128 + libc::WTERMSIG(status) } else { libc::WEXITSTATUS(status) };
        }
    }
}

/// No capability is left, and none can be gained by running something.
fn give_up_power() -> Result<()> {
    for capability in 0..64 {
        // Beyond the last capability the kernel says EINVAL.
        unsafe { libc::prctl(libc::PR_CAPBSET_DROP, capability as c_ulong, 0, 0, 0) };
    }
    check(unsafe { libc::prctl(libc::PR_SET_NO_NEW_PRIVS, 1 as c_ulong, 0, 0, 0) })?;
    const VERSION_3: u32 = 0x2008_0522;
    let (header, nothing) = ([VERSION_3, 0], [0u32; 6]);
    check_long(unsafe { libc::syscall(libc::SYS_capset, header.as_ptr(), nothing.as_ptr()) })?;
    Ok(())
}

fn die_with_parent() -> Result<()> {
    check(unsafe { libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL as c_ulong, 0, 0, 0) })?;
    Ok(())
}

/// Pipes to the host belong to the stage alone.
fn close_all() {
    unsafe { libc::syscall(libc::SYS_close_range, 0, u32::MAX, 0) };
}

fn fork() -> Result<pid_t> {
    Ok(check_long(unsafe { libc::syscall(libc::SYS_clone, libc::SIGCHLD, 0, 0, 0, 0) })? as pid_t)
}

fn write(path: &CStr, bytes: &[u8]) -> Result<()> {
    let fd = check(unsafe { libc::open(path.as_ptr(), libc::O_WRONLY | libc::O_CLOEXEC) })?;
    let written = unsafe { libc::write(fd, bytes.as_ptr().cast(), bytes.len()) };
    let result = check_long(written as libc::c_long);
    unsafe { libc::close(fd) };
    result.map(drop)
}

fn mount(
    from: Option<&CStr>,
    to: &CStr,
    kind: Option<&CStr>,
    flags: c_ulong,
    data: Option<&CStr>,
) -> Result<()> {
    let pointer = |text: Option<&CStr>| text.map_or(null(), CStr::as_ptr);
    check(unsafe { libc::mount(pointer(from), to.as_ptr(), pointer(kind), flags, pointer(data).cast()) })?;
    Ok(())
}

fn check(result: c_int) -> Result<c_int> {
    if result < 0 { Err(Error::last_os_error()) } else { Ok(result) }
}

fn check_long(result: libc::c_long) -> Result<libc::c_long> {
    if result < 0 { Err(Error::last_os_error()) } else { Ok(result) }
}
