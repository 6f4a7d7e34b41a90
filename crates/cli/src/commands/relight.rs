//! `zonal relight`: scales the light groups of a solution; solves again with other reflectances or another albedo from kept factors.

use super::context::{Context, read_light_solution};
use super::solving::{checkpoint_keys, path_beside, with_hash};
use crate::commands::pairs::voxel_factors::VoxelFactors;
use crate::table;
use std::path::{Path, PathBuf};
use zonal_exchange::pair::PairSettings;
use zonal_io::output::{self, CheckpointFolder, CheckpointState};
use zonal_report::{Failure, check_output, say};
use zonal_scene::{Bands, CheckpointStore, Progress, SceneError, Solution};
use zonal_solve::SolveSettings;
use zonal_solve::relight::{relight, with_surface_colors};
use zonal_solve::settings::DEFAULT_MEMORY_LIMIT;

/// Scale the light groups of a solution without solving again, or list them.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Solution (.npz).
    pub run: PathBuf,
    /// Light groups with their factors from 0, a number or r,g,b: `sun=0.2 lamp=3`. Without any, the groups are listed.
    #[arg(value_name = "NAME=FACTOR")]
    pub lights: Vec<String>,
    /// Solution to write (.npz).
    #[arg(long, short, value_name = "RUN.npz")]
    pub output: Option<PathBuf>,
    /// Another reflectance of a surface, 0 to 1, a number or r,g,b. Solves again with the factors of `solve --keep-factors`.
    #[arg(long, value_name = "SURFACE=VALUE")]
    pub reflectance: Vec<String>,
    /// Another albedo of the medium, 0 to 1, a number or r,g,b. Solves again with the factors of `solve --keep-factors`.
    #[arg(long, value_name = "VALUE")]
    pub albedo: Option<String>,
}

/// Changes of a solution.
#[derive(Clone, Debug, Default)]
pub struct SolutionChanges {
    /// Light groups with their factors.
    pub lights: Vec<(String, Bands)>,
    /// Surfaces with their reflectances.
    pub reflectances: Vec<(String, Bands)>,
    /// Albedo of the medium.
    pub albedo: Option<Bands>,
}

impl SolutionChanges {
    fn parse(args: &Args) -> Result<SolutionChanges, Failure> {
        let assignments =
            |list: &[String], argument: &str, max: f64| -> Result<Vec<(String, Bands)>, Failure> {
                list.iter().map(|t| parse_assignment(argument, t, max)).collect()
            };
        Ok(SolutionChanges {
            lights: assignments(&args.lights, "light group", f64::MAX)?,
            reflectances: assignments(&args.reflectance, "--reflectance", 1.0)?,
            albedo: args.albedo.as_ref().map(|t| parse_bands("--albedo", t, 1.0)).transpose()?,
        })
    }
    /// True if the changes are not linear in the sources, so that the equations are solved again.
    #[must_use]
    pub fn needs_solve(&self) -> bool {
        !self.reflectances.is_empty() || self.albedo.is_some()
    }
    fn is_empty(&self) -> bool {
        self.lights.is_empty() && !self.needs_solve()
    }
}

/// A number or r,g,b, from 0 to `max`.
fn parse_bands(argument: &str, text: &str, max: f64) -> Result<Bands, Failure> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
    let bands = match numbers.as_deref() {
        Some([x]) => Bands::splat(*x),
        Some([r, g, b]) => Bands::from_rgb([*r, *g, *b]),
        _ => return Err(Failure::new(format!("{argument}: '{text}' is neither a number nor r,g,b"))),
    };
    match bands.iter().find(|x| !(0.0..=max).contains(*x)) {
        Some(x) if max < f64::MAX => {
            Err(Failure::new(format!("{argument}: {x} is out of range; give numbers from 0 to {max}")))
        }
        Some(x) => Err(Failure::new(format!("{argument}: {x} is out of range; give numbers from 0"))),
        None => Ok(bands),
    }
}

/// `NAME=VALUE` with numbers up to `max`; the name may contain an equals sign.
fn parse_assignment(argument: &str, text: &str, max: f64) -> Result<(String, Bands), Failure> {
    let Some((name, number)) = text.rsplit_once('=') else {
        return Err(Failure::new(format!("{argument}: '{text}' has no value; write {text}=0.5")));
    };
    Ok((name.to_string(), parse_bands(&format!("{argument} '{name}'"), number, max)?))
}

/// Runs the command.
///
/// # Errors
/// For unknown groups and surfaces, factors out of range, missing kept factors, and outputs that cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let changes = SolutionChanges::parse(args)?;
    if changes.is_empty() {
        if args.output.is_some() {
            return Err(Failure::new("--output: nothing changes; name a light group, as in sun=0.5"));
        }
        return list_groups(&read_light_solution(&args.run)?, context);
    }
    let Some(path) = &args.output else {
        return Err(Failure::new("--output: name the solution to write, as in -o relit.npz"));
    };
    check_output(path, &["npz"])?;
    let mut solution = read_light_solution(&args.run)?;
    let in_run = |e: SceneError| Failure::in_file(&args.run, e);
    // Reflectances and albedo first: they need a solve.
    if changes.needs_solve() {
        let factors = KeptFactors::open(&path_beside(&args.run, "factors"), &solution);
        factors.check("solve the scene with --keep-factors")?;
        let settings = RelightSettings { memory_limit: DEFAULT_MEMORY_LIMIT, progress: &context.progress() };
        solution = solve_again(solution, &changes, &factors, &settings).map_err(in_run)?;
    }
    if !changes.lights.is_empty() {
        solution = scale_lights(solution, &changes.lights).map_err(in_run)?;
    }
    output::write_solution(path, &solution)?;
    if context.json {
        say(&format!("{:#}", output::report_json(&solution)))?;
    } else {
        say(table::report(&solution).trim_end())?;
        say(&format!("written: {}", path.display()))?;
    }
    context.check_report(&solution.report)
}

/// The exchange factors of a solution in a folder, which are read and not written.
pub struct KeptFactors(CheckpointFolder);

/// The exact factors, which alone are kept for other reflectances.
fn pair_settings() -> PairSettings {
    VoxelFactors::Exact.pair_settings()
}

impl KeptFactors {
    /// The folder of the factors of a solution.
    #[must_use]
    pub fn open(path: &Path, solution: &Solution) -> KeptFactors {
        KeptFactors(CheckpointFolder::new(path, checkpoint_keys(&solution.scene, pair_settings())))
    }

    /// Refuses a folder without factors, or with those of another scene; `remedy` says how to keep factors.
    ///
    /// # Errors
    /// If the folder has no factors of the solution.
    pub fn check(&self, remedy: &str) -> Result<(), Failure> {
        let place = self.0.path().display();
        match self.0.factors_state() {
            CheckpointState::Matching => Ok(()),
            CheckpointState::Empty => Err(Failure::new(format!("{place}: there are no factors; {remedy}"))),
            CheckpointState::Mismatched => Err(Failure::new(format!(
                "{place}: these factors belong to other lights, another scene or another version; {remedy}"
            ))),
        }
    }
}

impl CheckpointStore for KeptFactors {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        self.0.load(stage)
    }
    fn save(&self, _: &str, _: &[u8]) {}
    fn keeps(&self) -> bool {
        false
    }
}

/// Settings of a solve with kept factors.
pub struct RelightSettings<'a> {
    /// Bytes.
    pub memory_limit: u64,
    /// Observer of the progress.
    pub progress: &'a dyn Progress,
}

/// Solves again with other reflectances or another albedo from kept factors, starting from the fields of the old solution.
///
/// # Errors
/// For unknown surfaces, values out of range, and as [`zonal_solve::solve_with_settings`].
pub fn solve_again(
    old: Solution,
    changes: &SolutionChanges,
    factors: &KeptFactors,
    settings: &RelightSettings<'_>,
) -> Result<Solution, SceneError> {
    let scene = with_surface_colors(old.scene, &changes.reflectances, changes.albedo)?;
    let run = SolveSettings {
        pair_settings: pair_settings(),
        checkpoints: factors,
        initial_groups: &old.groups,
        ..SolveSettings::new(settings.memory_limit, settings.progress)
    };
    zonal_solve::solve_with_settings(scene, &run).map(with_hash)
}

/// The solution with its light groups scaled.
///
/// # Errors
/// As [`relight`].
pub fn scale_lights(solution: Solution, lights: &[(String, Bands)]) -> Result<Solution, SceneError> {
    relight(solution, lights).map(with_hash)
}

/// Prints the light groups with their power.
fn list_groups(s: &Solution, context: Context) -> Result<(), Failure> {
    if context.json {
        return say(&format!("{:#}", output::report_json(s)["light_groups"]));
    }
    if s.groups.is_empty() {
        return say("no light groups were kept");
    }
    say(table::light_groups(s).trim_end())
}
