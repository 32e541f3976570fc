//! What is mounted where in a stage's world, prepared as C strings before the fork.

use std::ffi::CString;
use std::io::Result;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

/// Folders of the system that programs need; all read-only, missing ones skipped.
const SYSTEM: [&str; 8] = ["/usr", "/bin", "/sbin", "/lib", "/lib64", "/lib32", "/nix/store", "/gnu/store"];

/// Files below /etc without which programs or their libraries are not found. Nothing about users, hosts or this machine.
const SETTINGS: [&str; 4] = ["/etc/ld.so.cache", "/etc/ld.so.conf", "/etc/ld.so.conf.d", "/etc/alternatives"];

const DEVICES: [&str; 5] = ["/dev/null", "/dev/zero", "/dev/full", "/dev/random", "/dev/urandom"];

/// What a stage sees beside the system.
#[derive(Debug, Default)]
pub struct View {
    /// A folder of the host in which the world may be put together; stays empty.
    pub scratch: PathBuf,
    /// Host folder that becomes the writable [`super::WORK`], with its `in/` read-only.
    pub work: Option<PathBuf>,
    /// Read-only files and folders: host path, path in the world.
    pub read_only: Vec<(PathBuf, PathBuf)>,
}

/// A bind mount.
pub(super) struct Bind {
    pub from: CString,
    /// Relative to the root being built.
    pub to: CString,
    pub read_only: bool,
}

/// Everything the child needs, in the order it needs it.
pub(super) struct Plan {
    pub root: CString,
    /// Relative folders to make.
    pub folders: Vec<CString>,
    /// Relative empty files to make.
    pub files: Vec<CString>,
    /// Relative links to make: target, name.
    pub links: Vec<(CString, CString)>,
    pub binds: Vec<Bind>,
    pub user_map: Vec<u8>,
    pub group_map: Vec<u8>,
}

impl Plan {
    pub fn of(view: &View) -> Result<Plan> {
        let root = view.scratch.join("root");
        std::fs::create_dir_all(&root)?;
        let mut plan = Plan {
            root: text(&root)?,
            folders: Vec::new(),
            files: Vec::new(),
            links: Vec::new(),
            binds: Vec::new(),
            user_map: one_id(rustix::process::geteuid().as_raw()),
            group_map: one_id(rustix::process::getegid().as_raw()),
        };
        for folder in ["/proc", "/dev", "/dev/shm", "/tmp", super::WORK] {
            plan.folder(Path::new(folder))?;
        }
        for path in SYSTEM.iter().chain(&SETTINGS).map(Path::new) {
            plan.system(path)?;
        }
        for device in DEVICES.map(Path::new) {
            plan.bind(device, device, false)?;
        }
        plan.links.push((text(Path::new("/proc/self/fd"))?, text(Path::new("dev/fd"))?));
        for (from, to) in &view.read_only {
            plan.bind(from, to, true)?;
        }
        if let Some(work) = &view.work {
            plan.bind(work, Path::new(super::WORK), false)?;
            plan.bind(&work.join("in"), &Path::new(super::WORK).join("in"), true)?;
        }
        Ok(plan)
    }

    /// A part of the system: a link as a link, anything else read-only.
    fn system(&mut self, path: &Path) -> Result<()> {
        let Ok(meta) = path.symlink_metadata() else { return Ok(()) };
        if meta.is_symlink() {
            self.links.push((text(&std::fs::read_link(path)?)?, text(relative(path))?));
            return Ok(());
        }
        self.bind(path, path, true)
    }

    fn bind(&mut self, from: &Path, to: &Path, read_only: bool) -> Result<()> {
        let is_in_work = to.starts_with(super::WORK) && to != Path::new(super::WORK);
        if is_in_work {
            // Made by the host already.
        } else if from.is_dir() {
            self.folder(to)?;
        } else {
            to.parent().map_or(Ok(()), |folder| self.folder(folder))?;
            self.files.push(text(relative(to))?);
        }
        self.binds.push(Bind { from: text(from)?, to: text(relative(to))?, read_only });
        Ok(())
    }

    /// The folder and those above it.
    fn folder(&mut self, path: &Path) -> Result<()> {
        let mut above: Vec<&Path> = path.ancestors().filter(|p| p.parent().is_some()).collect();
        above.reverse();
        for folder in above {
            let folder = text(relative(folder))?;
            if !self.folders.contains(&folder) {
                self.folders.push(folder);
            }
        }
        Ok(())
    }
}

fn relative(path: &Path) -> &Path {
    path.strip_prefix("/").unwrap_or(path)
}

fn text(path: &Path) -> Result<CString> {
    Ok(CString::new(path.as_os_str().as_bytes())?)
}

/// An id in the new world is the same id outside; no other exists.
fn one_id(id: u32) -> Vec<u8> {
    format!("{id} {id} 1").into_bytes()
}
