//! The command `zonal` as a process, with its cost from Linux's `/proc`: reading, tables and writing included.

use super::{Error, ScratchFolder};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Clock ticks a second in `/proc/*/stat`: 100 on every Linux that programs see.
const TICKS_PER_SECOND: f64 = 100.0;
/// Time between two looks at a process.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Cost of a process.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cost {
    /// Time that passed, s.
    pub wall: f64,
    /// Processor time of all threads, s.
    pub processor: f64,
    /// Peak of the resident memory, MB.
    pub memory: f64,
}

/// The command `zonal`.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct ZonalCommand {
    /// Command `zonal` that solves
    #[arg(long, default_value = "target/release/zonal")]
    pub zonal: PathBuf,
}

impl ZonalCommand {
    /// Solves a scene file with more arguments: the report and the cost, or `None` where the process was ended because it used more than
    /// `limit` seconds of processor time.
    pub(crate) fn solve(
        &self,
        scene: &Path,
        run: &Path,
        arguments: &[&str],
        limit: f64,
    ) -> Result<Option<(Value, Cost)>, Error> {
        let [report, log] = ["report.json", "report.log"].map(|end| run.with_extension(end));
        let start = Instant::now();
        let mut child = Command::new(&self.zonal)
            .arg("solve")
            .arg(scene)
            .args(["--json", "-o"])
            .arg(run)
            .args(arguments)
            .stdout(Stdio::from(std::fs::File::create(&report)?))
            .stderr(Stdio::from(std::fs::File::create(&log)?))
            .spawn()
            .map_err(|e| format!("{}: {e}", self.zonal.display()))?;
        let (mut cost, mut ended) = (Cost::default(), false);
        // A terminated process that was not waited for still reports its times.
        while let Some((state, processor)) = state(child.id()) {
            cost.processor = processor;
            if state == "Z" {
                break;
            }
            cost.memory = peak(child.id()).map_or(cost.memory, |p| p.max(cost.memory));
            if !ended && processor > limit {
                child.kill()?;
                ended = true;
            }
            std::thread::sleep(POLL_INTERVAL);
        }
        cost.wall = start.elapsed().as_secs_f64();
        let status = child.wait()?;
        if ended {
            return Ok(None);
        }
        if !status.success() {
            let said = std::fs::read_to_string(&log)?;
            return Err(format!("{status}: {}", said.lines().next_back().unwrap_or("no message")).into());
        }
        Ok(Some((serde_json::from_str(&std::fs::read_to_string(&report)?)?, cost)))
    }

    /// Solves the scene of a text in a folder: the report, the cost, and the solution file.
    pub(crate) fn solve_text(
        &self,
        folder: &ScratchFolder,
        text: &str,
        arguments: &[&str],
    ) -> Result<(Value, Cost, PathBuf), Error> {
        let (scene, run) = (folder.join("scene.toml"), folder.join("run.npz"));
        std::fs::write(&scene, text)?;
        let solved = self.solve(&scene, &run, arguments, f64::INFINITY)?;
        let (report, cost) = solved.ok_or("a solve without a limit was ended")?;
        Ok((report, cost, run))
    }
}

/// Processor time of all threads of this process so far, s; 0 where the system does not tell it.
pub(crate) fn own_processor_time() -> f64 {
    state(std::process::id()).map_or(0.0, |s| s.1)
}

/// State of a process, and processor time of all its threads, s.
fn state(id: u32) -> Option<(String, f64)> {
    let text = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    // The second field is the command's name in brackets, in which anything may stand.
    let fields: Vec<&str> = text.rsplit_once(") ")?.1.split_whitespace().collect();
    let ticks = |k: usize| fields.get(k)?.parse::<f64>().ok();
    Some((fields.first()?.to_string(), (ticks(11)? + ticks(12)?) / TICKS_PER_SECOND))
}

/// Peak of the resident memory so far, MB.
fn peak(id: u32) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? * 1024.0 / 1e6)
}
