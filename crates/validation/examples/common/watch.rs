//! Commands run to completion, with their cost.

#[path = "process.rs"]
pub(crate) mod process;

use process::Process;
use std::io::Read as _;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Time between two looks at a process.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Wall time in s, processor time in s, and peak of the resident memory in MB of a process.
pub(crate) type Consumption = [f64; 3];

/// Peak of the resident memory so far, MB.
fn peak(id: u32) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? * 1024.0 / 1e6)
}

/// Runs a command to completion; returns its output, wall time, processor time and peak memory.
#[allow(dead_code, reason = "shared by examples of which some set a limit")]
pub(crate) fn watched(command: &mut Command) -> Result<(String, Consumption), Box<dyn std::error::Error>> {
    watched_until(command, f64::INFINITY)?.ok_or_else(|| "a process without a limit was ended".into())
}

/// As [`watched`]; the process is ended, with `None`, when it has used more than `limit` seconds of processor time.
pub(crate) fn watched_until(
    command: &mut Command,
    limit: f64,
) -> Result<Option<(String, Consumption)>, Box<dyn std::error::Error>> {
    let start = Instant::now();
    let mut child = command.stdout(Stdio::piped()).spawn()?;
    let mut pipe = child.stdout.take().ok_or("no output")?;
    let reader = std::thread::spawn(move || {
        let mut text = String::new();
        pipe.read_to_string(&mut text).map(|_| text)
    });
    let (id, mut most) = (child.id(), 0.0f64);
    let (process, mut ended_early) = (Process::new(&id.to_string()), false);
    // A terminated process that was not waited for still reports its times.
    while process.stat().is_some_and(|s| s.first().is_some_and(|state| state != "Z")) {
        most = peak(id).map_or(most, |p| p.max(most));
        if !ended_early && process.seconds().is_some_and(|s| s > limit) {
            child.kill()?;
            ended_early = true;
        }
        std::thread::sleep(POLL_INTERVAL);
    }
    let (wall, seconds) = (start.elapsed().as_secs_f64(), process.seconds().unwrap_or(0.0));
    let ended = child.wait()?;
    let text = reader.join().map_err(|_| "the output could not be read")??;
    if ended_early {
        return Ok(None);
    }
    if !ended.success() {
        return Err(format!("{command:?} ended with {ended}").into());
    }
    Ok(Some((text, [wall, seconds, most])))
}
