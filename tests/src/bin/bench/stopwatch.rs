//! Wall time of whole processes.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// One run; the reason if it fails.
pub fn once(command: &mut Command) -> Result<Duration, String> {
    let started = Instant::now();
    let output = command.stdout(Stdio::piped()).stderr(Stdio::piped()).output();
    let output = output.map_err(|e| format!("{:?}: {e}", command.get_program()))?;
    let took = started.elapsed();
    if output.status.success() {
        return Ok(took);
    }
    Err(format!("{:?} failed: {}", command.get_program(), String::from_utf8_lossy(&output.stderr)))
}

/// The best and the median of several runs.
pub fn several(
    count: usize,
    mut run: impl FnMut() -> Result<Duration, String>,
) -> Result<[Duration; 2], String> {
    let mut times = (0..count).map(|_| run()).collect::<Result<Vec<_>, _>>()?;
    times.sort();
    Ok([times[0], times[count / 2]])
}

/// `12.3 ms` or `1.23 s`.
pub fn text(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    if seconds < 1.0 { format!("{:.1} ms", seconds * 1e3) } else { format!("{seconds:.2} s") }
}
