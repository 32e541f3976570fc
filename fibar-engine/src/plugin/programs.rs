//! Programs that stages start: found in the system's folders first, then in the user's PATH.

use std::path::{Path, PathBuf};

/// The PATH of every stage.
pub const SYSTEM_PATH: &str = "/usr/local/bin:/usr/bin:/bin";

/// Folders that every stage sees anyway.
const SYSTEM: [&str; 7] = ["/usr", "/bin", "/sbin", "/lib", "/lib64", "/nix/store", "/gnu/store"];

/// The program of this name, links followed.
pub fn find(name: &str) -> Option<PathBuf> {
    let own = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::env::split_paths(SYSTEM_PATH).chain(std::env::split_paths(&own)).collect::<Vec<_>>();
    let is_program = |path: &PathBuf| path.metadata().is_ok_and(|meta| crate::os::is_executable(&meta));
    let found = folders.into_iter().map(|folder| folder.join(name)).find(is_program)?;
    found.canonicalize().ok()
}

/// What has to be shown to a stage for the program to work, if it is no part of the system: the folder above its `bin`,
/// else its own.
pub fn folder_of(program: &Path) -> Option<PathBuf> {
    if SYSTEM.iter().any(|system| program.starts_with(system)) {
        return None;
    }
    let own = program.parent()?;
    let prefix = own.parent().filter(|above| own.ends_with("bin") && above.parent().is_some());
    Some(prefix.unwrap_or(own).to_owned())
}

/// The interpreter that the first line of a script names.
pub fn interpreter_of(script: &Path) -> Option<PathBuf> {
    use std::io::Read;
    let mut head = [0; 256];
    let count = std::fs::File::open(script).and_then(|mut file| file.read(&mut head)).ok()?;
    let line = std::str::from_utf8(head[..count].strip_prefix(b"#!")?.split(|b| *b == b'\n').next()?).ok()?;
    let mut words = line.split_whitespace();
    let first = words.next()?;
    if first.ends_with("/env") {
        return find(words.find(|word| !word.starts_with('-'))?);
    }
    Path::new(first).canonicalize().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_is_shown_with_what_lies_beside_its_bin() {
        let check = |program: &str, expected: Option<&str>| {
            assert_eq!(folder_of(Path::new(program)), expected.map(PathBuf::from), "{program}");
        };
        check("/usr/bin/python3.11", None);
        check("/home/a/tools/bin/python3", Some("/home/a/tools"));
        check("/home/a/tools/slicer", Some("/home/a/tools"));
        check("/opt/bin/slicer", Some("/opt"));
    }
}
