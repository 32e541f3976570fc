//! The same without Unix: no process groups and no sandbox.

use std::process::{Child, Command};
use std::time::UNIX_EPOCH;

/// Ctrl-C ends the process; stages end when their standard input closes.
pub fn catch_interrupts() {}

/// None are caught.
pub fn interrupts() -> u32 {
    0
}

/// Nothing to do.
pub fn isolate(_: &mut Command) {}

/// Only the child itself; `Child::kill` follows.
pub fn kill_group(_: &Child) {}

/// A guess.
pub fn memory_mb() -> u64 {
    8192
}

/// Marks the file read-only.
pub fn make_read_only(path: &std::path::Path) -> std::io::Result<()> {
    let mut permissions = std::fs::metadata(path)?.permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(path, permissions)
}

/// Programs can set all times of a file.
pub const KEEPS_CHANGE_TIMES: bool = false;

/// Modification time only.
pub fn file_identity(meta: &std::fs::Metadata) -> [i64; 4] {
    let modified = meta.modified().ok().and_then(|t| t.duration_since(UNIX_EPOCH).ok());
    [0, 0, modified.map_or(0, |d| d.as_nanos() as i64), 0]
}

/// Cannot be told; a file in use cannot be swept here anyway.
pub fn same_file(_: &std::fs::Metadata) -> (u64, u64) {
    (0, 0)
}

/// Cannot be asked.
pub fn has_other_names(_: &std::fs::Metadata) -> bool {
    false
}

/// Any file may be.
pub fn is_executable(meta: &std::fs::Metadata) -> bool {
    meta.is_file()
}

/// Waits a moment: it cannot be asked without collecting it.
pub fn await_end(_: &Child, patience: std::time::Duration) {
    std::thread::sleep(patience.min(std::time::Duration::from_millis(50)));
}
