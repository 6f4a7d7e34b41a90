//! Solves in a process of their own, so that processor time and peak memory are those of the solve, reading and writing included.

use crate::arguments::Arguments;
use crate::scenes::Error;
use crate::solved::ReportSummary;
use crate::watch::{Consumption, watched_until};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use zonal_io::{input, output};
use zonal_scene::{Engine, NoProgress, Solution};
use zonal_solve::{SolveSettings, solve_with_settings};

/// Memory limit of a solve, GB.
const MAX_MEMORY_GB: u64 = 8;

/// What is solved, and how.
pub(crate) struct SolveRequest<'a> {
    /// The command `zonal`; this program where there is none.
    pub command: Option<&'a Path>,
    /// The scene file.
    pub scene: &'a Path,
    /// The solution to write.
    pub run: &'a Path,
    /// Name of the engine.
    pub engine: &'a str,
    /// The tolerance.
    pub tolerance: f64,
    /// Most processor time, s.
    pub limit: f64,
}

impl SolveRequest<'_> {
    /// Solves; `None` where the solve was ended at its limit.
    pub(crate) fn run(&self) -> Result<Option<(ReportSummary, Consumption)>, Error> {
        let own = std::env::current_exe()?;
        let mut command = Command::new(self.command.unwrap_or(&own));
        command.arg("solve").arg(self.scene).arg("-o").arg(self.run).args(["--engine", self.engine]);
        command.args([
            "--tolerance",
            &self.tolerance.to_string(),
            "--discretization-error",
            "false",
            "--json",
        ]);
        command.args(["--max-memory", &MAX_MEMORY_GB.to_string()]);
        let log = self.run.with_extension("log");
        command.stderr(Stdio::from(std::fs::File::create(&log)?));
        let outcome = watched_until(&mut command, self.limit).map_err(|e| {
            let said = std::fs::read_to_string(&log).unwrap_or_default();
            format!("{e}: {}", said.lines().next_back().unwrap_or("no message"))
        })?;
        outcome.map(|(said, cost)| Ok((ReportSummary::new(&said)?, cost))).transpose()
    }
}

/// The sub-command `solve`: as `zonal solve`.
pub(crate) fn solve(arguments: &Arguments) -> Result<bool, Error> {
    let scene = PathBuf::from(
        arguments.word(1).ok_or("give the scene: error_against_cost solve SCENE.toml -o RUN.npz")?,
    );
    let run = PathBuf::from(arguments.text("-o").ok_or("give -o RUN.npz")?);
    let scene = input::read_scene(&scene)?;
    let mut options = scene.options().clone();
    options.tolerance = arguments.number("--tolerance", options.tolerance)?;
    options.discretization_error = Some(false);
    if let Some(name) = arguments.text("--engine") {
        options.engine = engine(name)?;
    }
    let scene = scene.with_options(options)?;
    let gigabytes: u64 = arguments.number("--max-memory", MAX_MEMORY_GB)?;
    let mut solution: Solution =
        solve_with_settings(scene, &SolveSettings::new(gigabytes << 30, &NoProgress))?;
    solution.scene_hash = output::scene_hash(&solution.scene);
    output::write_solution(&run, &solution)?;
    println!("{:#}", output::report_json(&solution));
    Ok(true)
}

/// The engine of a name.
fn engine(name: &str) -> Result<Engine, Error> {
    match name {
        "auto" => Ok(Engine::Auto),
        "dense" => Ok(Engine::Dense),
        "rays" => Ok(Engine::Rays),
        "spectral" => Ok(Engine::Spectral),
        other => Err(format!("--engine {other}: give auto, dense, rays or spectral").into()),
    }
}
