//! `zonal solve`: reads a scene, solves it, writes the solution.

use super::context::{Context, memory_limit, option_failure};
use crate::table;
use std::path::PathBuf;
use zonal_app::quality::Quality;
use zonal_app::solving::{SharedSolve, SolveCheckpoint, SolveInput, VoxelFactors, path_beside};
use zonal_app::timeline::READING;
use zonal_io::output;
use zonal_report::{Failure, check_output, note, say};
use zonal_scene::{Engine, LightGrouping, Scene, Solution, SolveOptions, ZoneBasis};
use zonal_solve::distribution::{Communicator, SingleProcess};

/// Solve a scene and write the solution.
///
/// The report gives the engine, counts, the energy balance, and the estimated errors. Options override the keys of the section `solve` of the scene.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Scene file (.toml).
    pub scene: PathBuf,
    /// Solution to write (.npz). numpy.load opens it.
    #[arg(long, short, value_name = "RUN.npz")]
    pub output: PathBuf,
    /// Tolerance and patch size at once: draft is a first look, fine halves the patches and takes a third of the tolerance.
    #[arg(long, value_enum, default_value_t)]
    pub quality: Quality,
    /// Relative tolerance of the exchange areas, 0 < T < 1 [default: that of the scene, else 0.01].
    #[arg(long, value_name = "T")]
    pub tolerance: Option<f64>,
    /// Closure of the row sums of the exchange areas [default: that of the scene, else restore in thermal mode and measure in light mode].
    #[arg(long, value_name = "MODE")]
    pub closure: Option<ClosureMode>,
    /// Formula of the exchange factor of two voxels; the paper's formulas are for comparison.
    #[arg(long, value_enum, default_value_t = VoxelFactors::Exact, value_name = "FORMULA")]
    pub factors: VoxelFactors,
    /// Memory limit, GB: of the exchange areas with the dense engine, of the whole solve with the others. Less memory means fewer rays and larger errors.
    #[arg(long, default_value_t = 12.0, value_name = "GB")]
    pub max_memory: f64,
    /// Representation of the exchange between zones [default: that of the scene, else auto].
    #[arg(long, value_enum)]
    pub engine: Option<Engine>,
    /// Lights that are solved separately, so that `zonal relight` can scale them [default: that of the scene, else auto].
    #[arg(long, value_enum, value_name = "GROUPING")]
    pub light_groups: Option<LightGrouping>,
    /// Basis of the radiosity inside a zone [default: that of the scene, else auto].
    #[arg(long, value_enum, value_name = "BASIS")]
    pub zone_basis: Option<ZoneBasis>,
    /// Estimate the discretization error by a second solve on zones of another size [default: that of the scene, else true in thermal mode].
    #[arg(long, value_name = "BOOL")]
    pub discretization_error: Option<bool>,
    /// Stop after N orders of scattering and reflection: N terms of the Neumann series in place of the iterative solver [default: that of the scene, else
    /// the solver].
    #[arg(long, value_name = "N")]
    pub scattering_orders: Option<usize>,
    /// Keep finished stages in a folder during the solve [default folder: OUTPUT.checkpoint]. It is removed when the solution is written.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1)]
    pub checkpoint: Option<Option<PathBuf>>,
    /// Resume from the checkpoint of an interrupted solve of the same scene; without a checkpoint, start from the beginning.
    #[arg(long)]
    pub resume: bool,
    /// Keep the exchange factors in the folder OUTPUT.factors, so that `zonal relight` can change reflectances and albedo.
    #[arg(long)]
    pub keep_factors: bool,
}

/// Treatment of the closure defect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ClosureMode {
    /// Report the defects of the row sums.
    Measure,
    /// Scale the exchange areas symmetrically, surroundings included, until their row sums close; report the largest change.
    Restore,
}

/// Runs the command.
///
/// # Errors
/// For options and scenes that are not valid, solves that are refused, and outputs that cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    run_on_ranks(args, context, &SingleProcess)
}

/// Runs the command on several processes, of which the first writes and prints.
///
/// # Errors
/// As [`run`], on all ranks alike, and where the ranks have different scenes or versions.
pub fn run_on_ranks(args: &Args, context: Context, communicator: &dyn Communicator) -> Result<(), Failure> {
    let checkpoint = args.checkpoint();
    let solve = SharedSolve {
        pair_settings: args.factors.pair_settings(),
        checkpoint: checkpoint.as_ref(),
        progress: &context.progress(),
        communicator,
        note: &note,
    };
    let input = context.in_stage(READING, || read_input(args));
    let solved = solve.solve_and_write(input, &args.output);
    let Some(solution) = solved.map_err(|e| e.in_scene(&args.scene))? else { return Ok(()) };
    print_report(args, &solution, context)?;
    context.check_report(&solution.report)
}

/// The scene with the options of the command line, and the memory limit.
fn read_input(args: &Args) -> Result<SolveInput, Failure> {
    check_output(&args.output, &["npz"])?;
    let memory_limit = memory_limit(args.max_memory)?;
    let scene = zonal_io::input::read_scene(&args.scene)?;
    let options = args.options(&scene);
    let scene = scene.with_options(options).map_err(|e| option_failure(&e))?;
    Ok(SolveInput { scene, memory_limit })
}

impl Args {
    /// The settings of a scene, with those that flags give.
    fn options(&self, scene: &Scene) -> SolveOptions {
        let o = self.quality.of_solve(scene);
        SolveOptions {
            tolerance: self.tolerance.unwrap_or(o.tolerance),
            restore_closure: self.closure.map(|c| c == ClosureMode::Restore).or(o.restore_closure),
            engine: self.engine.unwrap_or(o.engine),
            light_grouping: self.light_groups.unwrap_or(o.light_grouping),
            zone_basis: self.zone_basis.unwrap_or(o.zone_basis),
            discretization_error: self.discretization_error.or(o.discretization_error),
            scattering_orders: self.scattering_orders.or(o.scattering_orders),
            ..o
        }
    }

    fn checkpoint(&self) -> Option<SolveCheckpoint> {
        if self.checkpoint.is_none() && !self.resume && !self.keep_factors {
            return None;
        }
        let named = self.checkpoint.clone().flatten();
        Some(SolveCheckpoint {
            folder: named.unwrap_or_else(|| path_beside(&self.output, "checkpoint")),
            resume: self.resume,
            keep_factors: self.keep_factors.then(|| path_beside(&self.output, "factors")),
        })
    }
}

/// Prints the report, and a command to draw the solution.
fn print_report(args: &Args, solution: &Solution, context: Context) -> Result<(), Failure> {
    if context.json {
        return context.say_json(output::report_json(solution));
    }
    let run = args.output.display();
    say(table::report(solution).trim_end())?;
    say(&format!("written: {run}"))?;
    let scene = &solution.scene;
    if scene.thermal().is_some() {
        let (low, high) = scene.bounds();
        let has_only_medium = solution.zones.patches.is_empty() && solution.zones.panes.is_empty();
        let slice =
            if has_only_medium { format!(" --slice z={}", 0.5 * (low.z + high.z)) } else { String::new() };
        return say(&format!("next: zonal render {run} --show temperature{slice} -o walls.png"));
    }
    match scene.cameras().first() {
        Some(c) => say(&format!("next: zonal render {run} --camera {} -o picture.png", c.name)),
        None => Ok(()),
    }
}
