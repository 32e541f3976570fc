//! Processor time of this process and its children.

/// Ticks of `/proc` per second: the same on every Linux that Rust runs on.
const TICKS_PER_SECOND: f64 = 100.0;

/// User and system seconds of all children that were waited for, to a hundredth; none where there is no `/proc`.
pub fn children_seconds() -> Option<f64> {
    // `cutime` and `cstime` are fields 16 and 17 of `man proc`.
    seconds_after(13)
}

/// User and system seconds of this process itself, to a hundredth; none where there is no `/proc`.
pub fn own_seconds() -> Option<f64> {
    // `utime` and `stime` are fields 14 and 15.
    seconds_after(11)
}

/// The sum of two fields of `/proc/self/stat`, so many after the name of the program; that is in brackets and may hold spaces.
fn seconds_after(skipped: usize) -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let (_, fields) = stat.rsplit_once(')')?;
    let mut ticks = fields.split_whitespace().skip(skipped).take(2).map(str::parse::<f64>);
    Some((ticks.next()?.ok()? + ticks.next()?.ok()?) / TICKS_PER_SECOND)
}
