//! `zonal relight`: scales the light groups of a solution; solves again with other reflectances or another albedo from kept factors.

use super::context::{Context, read_light_solution};
use super::solving::{checkpoint_keys, path_beside, solve_and_hash};
use super::voxel_factors::VoxelFactors;
use crate::table;
use std::path::PathBuf;
use zonal_io::output::{self, CheckpointFolder, CheckpointState};
use zonal_report::{Failure, check_output, say};
use zonal_scene::{Bands, CheckpointStore, SceneError, Solution};
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

/// Changes of a solution, from the arguments.
struct SolutionChanges {
    /// Light groups with their factors.
    lights: Vec<(String, Bands)>,
    /// Surfaces with their reflectances.
    reflectances: Vec<(String, Bands)>,
    /// Albedo of the medium.
    albedo: Option<Bands>,
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
    fn needs_solve(&self) -> bool {
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
    // Reflectances and albedo first: they need a solve.
    if changes.needs_solve() {
        solution = solve_again(args, solution, &changes, context)?;
    }
    if !changes.lights.is_empty() {
        let in_run = |e: SceneError| Failure::in_file(&args.run, e);
        solution = relight(solution, &changes.lights).map_err(in_run)?;
        solution.scene_hash = output::scene_hash(&solution.scene);
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

/// Solves again with kept factors, starting from the fields of the old solution.
fn solve_again(
    args: &Args,
    old: Solution,
    changes: &SolutionChanges,
    context: Context,
) -> Result<Solution, Failure> {
    let pair_settings = VoxelFactors::Exact.pair_settings();
    let keys = checkpoint_keys(&old.scene, pair_settings);
    let folder = CheckpointFolder::new(&path_beside(&args.run, "factors"), keys);
    let place = folder.path().display().to_string();
    match folder.factors_state() {
        CheckpointState::Matching => {}
        CheckpointState::Empty => {
            return Err(Failure::new(format!(
                "{place}: there are no factors; solve the scene with --keep-factors"
            )));
        }
        CheckpointState::Mismatched => {
            return Err(Failure::new(format!(
                "{place}: these factors belong to other lights, another scene or another version; solve the scene again with --keep-factors"
            )));
        }
    }
    let scene = with_surface_colors(old.scene, &changes.reflectances, changes.albedo)
        .map_err(|e| Failure::in_file(&args.run, e))?;
    let progress = context.progress();
    let settings = SolveSettings {
        pair_settings,
        checkpoints: &ReadOnlyFactors(folder),
        initial_groups: &old.groups,
        ..SolveSettings::new(DEFAULT_MEMORY_LIMIT, &progress)
    };
    solve_and_hash(scene, &settings)
}

/// Kept factors that are read and not written.
struct ReadOnlyFactors(CheckpointFolder);

impl CheckpointStore for ReadOnlyFactors {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        self.0.load(stage)
    }
    fn save(&self, _: &str, _: &[u8]) {}
    fn keeps(&self) -> bool {
        false
    }
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
