//! `zonal solve`: a scene in, a solution out.

use super::{Context, check_output};
use crate::failure::say;
use crate::{Failure, meter::Meter, table};
use std::path::PathBuf;
use zonal_exchange::pair::{Settings, VoxelFactors};
use zonal_io::output;
use zonal_scene::{Progress, Scene, Solution};
use zonal_solve::Job;

/// Solve a scene and write the solution.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Scene file (.toml).
    pub scene: PathBuf,
    /// Solution to write (.npz); numpy opens it without us.
    #[arg(long, short)]
    pub output: PathBuf,
    /// Relative accuracy of the exchange areas, between 0 and 1; overrides the scene's.
    #[arg(long)]
    pub tolerance: Option<f64>,
    /// Closure of the exchange areas: `measure` or `restore`; overrides the scene's.
    #[arg(long)]
    pub closure: Option<ClosureMode>,
    /// Formula for the exchange of two voxels: the exact one, or one of the paper's for comparison.
    #[arg(long, value_enum, default_value_t = Factors::Exact)]
    pub factors: Factors,
    /// Largest memory for exchange areas, GB.
    #[arg(long, default_value_t = 12.0)]
    pub max_memory: f64,
}

/// The formula for the exchange of two voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Factors {
    /// The reduced integral, attenuation inside, to 1e-11.
    Exact,
    /// The paper's method: a Gegenbauer series along strips of voxels, times the transmittance between the centres.
    Series,
    /// Proposition 1: the exact geometric factor times the transmittance between the centres.
    Prop1,
    /// Formula (3): kernel and transmittance at the centres.
    Point,
}

impl Factors {
    /// The settings of the exchange that it stands for.
    pub fn settings(self) -> Settings {
        let voxels = match self {
            Factors::Exact => VoxelFactors::Exact,
            Factors::Series => VoxelFactors::Series,
            Factors::Prop1 => VoxelFactors::Proposition1,
            Factors::Point => VoxelFactors::Point,
        };
        Settings { voxels, ..Settings::default() }
    }
}

/// What to do about closure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ClosureMode {
    /// Report the defects.
    Measure,
    /// Scale the factors, those of the surroundings included, until their sums are right; report the change.
    Restore,
}

/// Runs the command.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    check_output(&args.output, &["npz"])?;
    if !(args.max_memory > 0.0 && args.max_memory.is_finite()) {
        return Err(Failure::new("--max-memory: give a positive number of gigabytes"));
    }
    let scene = zonal_io::input::read_scene(&args.scene)?;
    let mut options = scene.options().clone();
    options.tolerance = args.tolerance.unwrap_or(options.tolerance);
    options.restore_closure = args.closure.map_or(options.restore_closure, |c| c == ClosureMode::Restore);
    let scene =
        scene.with_options(options).map_err(|e| Failure::new(format!("--tolerance: {}", e.what())))?;
    let memory = (args.max_memory * 1e9) as u64;
    let solution = solved(scene, memory, args.factors.settings(), &Meter::new(context.quiet))
        .map_err(|e| Failure::in_file(&args.scene, e))?;
    output::write_solution(&args.output, &solution)?;
    if context.json {
        say(&format!("{:#}", output::report_json(&solution)))?;
    } else {
        say(table::report(&solution).trim_end())?;
        say(&format!("written: {}", args.output.display()))?;
        if let Some(c) = solution.scene.cameras().first() {
            say(&format!("next: zonal render {} --camera {} -o picture.png", args.output.display(), c.name))?;
        }
    }
    Ok(())
}

/// Solves and signs a scene.
pub fn solved(
    scene: Scene,
    memory: u64,
    settings: Settings,
    progress: &dyn Progress,
) -> Result<Solution, Failure> {
    let job = Job { settings, ..Job::new(memory, progress) };
    let mut solution = zonal_solve::solve_job(scene, &job)?;
    solution.scene_hash = output::scene_hash(&solution.scene);
    Ok(solution)
}
