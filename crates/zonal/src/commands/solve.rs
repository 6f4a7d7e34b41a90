//! `zonal solve`: a scene in, a solution out.

use super::{Context, check_output};
use crate::failure::{note, say};
use crate::{Failure, meter::Meter, table};
use std::path::{Path, PathBuf};
use zonal_exchange::pair::{Settings, VoxelFactors};
use zonal_io::output::{self, Folder, Held, Keys};
use zonal_scene::scene::ThickZones;
use zonal_scene::{Engine, Groups, NoVault, Progress, Scene, Solution, Vault};
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
    /// Closure of the exchange areas: `measure`, or `restore`, which thermal mode does by itself; overrides the scene's.
    #[arg(long)]
    pub closure: Option<ClosureMode>,
    /// Formula for the exchange of two voxels: the exact one, or one of the paper's for comparison.
    #[arg(long, value_enum, default_value_t = Factors::Exact)]
    pub factors: Factors,
    /// Largest memory, GB: for exchange areas of pairs, or all that the other engines hold; fewer rays are shot to stay within it.
    #[arg(long, default_value_t = 12.0)]
    pub max_memory: f64,
    /// Engine; overrides the scene's.
    #[arg(long, value_enum)]
    pub engine: Option<EngineName>,
    /// Light groups that are solved apart, for `zonal relight`; overrides the scene's.
    #[arg(long, value_enum)]
    pub groups: Option<GroupsName>,
    /// What is done about voxels that are thick in optical depths; overrides the scene's.
    #[arg(long, value_enum)]
    pub thick_zones: Option<ThickName>,
    /// Whether to tell what the size of the zones costs, by a second solve on larger ones; overrides the scene's.
    #[arg(long, value_name = "BOOL")]
    pub zoning_error: Option<bool>,
    /// Exactly so many sweeps of the Neumann series in place of the solver; overrides the scene's.
    #[arg(long)]
    pub sweeps: Option<usize>,
    /// Keep what is done in a folder while solving (default: OUTPUT.checkpoint); it goes when the solution is written.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1)]
    pub checkpoint: Option<Option<PathBuf>>,
    /// Go on from the checkpoint that a killed solve of the same scene left behind; without one, begin.
    #[arg(long)]
    pub resume: bool,
    /// Keep the factors in the folder OUTPUT.factors, so that `zonal relight` can change reflectances and the albedo.
    #[arg(long)]
    pub keep_factors: bool,
}

/// The engine, as an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum EngineName {
    /// Dense for few zones, for many spectral where that applies, else hierarchical.
    Auto,
    /// Every pair of zones.
    Dense,
    /// Links between clusters of zones.
    Hierarchical,
    /// Every pair of zones of a box on the grid of its medium, by transforms.
    Spectral,
}

/// What is done about thick voxels, as an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ThickName {
    /// Slopes where voxels are thick and the engine can.
    Auto,
    /// Slopes of radiosity in every zone, by the spectral engine.
    Linear,
    /// Nothing: radiosity is constant in every zone.
    Constant,
}

/// The light groups, as an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum GroupsName {
    /// Each, as long as they are few; else all in one sum.
    Auto,
    /// Each.
    Each,
    /// All in one sum.
    All,
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
    let scene = with_options(scene, args)?;
    let kept = args.checkpoint.is_some() || args.resume || args.keep_factors;
    let folder = if kept { Some(checkpoint(&scene, args)?) } else { None };
    let meter = Meter::new(context.quiet);
    let job = Job {
        settings: args.factors.settings(),
        vault: folder.as_ref().map_or(&NoVault, |f| f as &dyn Vault),
        ..Job::new((args.max_memory * 1e9) as u64, &meter)
    };
    let solution = signed(scene, &job).map_err(|e| {
        // A refusal is no interruption: there is nothing to go on from.
        folder.iter().for_each(Folder::remove);
        Failure::in_file(&args.scene, e)
    })?;
    output::write_solution(&args.output, &solution)?;
    if let Some(folder) = folder {
        if let Some(e) = folder.failure() {
            note(&format!("the checkpoint could not be written: {e}"));
        }
        if args.keep_factors {
            folder.keep_factors(&beside(&args.output, "factors"))?;
        } else {
            folder.remove();
        }
    }
    if context.json {
        say(&format!("{:#}", output::report_json(&solution)))?;
    } else {
        say(table::report(&solution).trim_end())?;
        say(&format!("written: {}", args.output.display()))?;
        if solution.scene.thermal().is_some() {
            let (low, high) = solution.scene.bounds();
            let gas = solution.zones.patches.is_empty() && solution.zones.panes.is_empty();
            let slice = if gas { format!(" --slice z={}", 0.5 * (low.z + high.z)) } else { String::new() };
            say(&format!(
                "next: zonal render {} --show temperature{slice} -o walls.png",
                args.output.display()
            ))?;
        } else if let Some(c) = solution.scene.cameras().first() {
            say(&format!("next: zonal render {} --camera {} -o picture.png", args.output.display(), c.name))?;
        }
    }
    context.judge_report(&solution.report)
}

/// The scene with the options of the command line.
fn with_options(scene: Scene, args: &Args) -> Result<Scene, Failure> {
    let mut o = scene.options().clone();
    o.tolerance = args.tolerance.unwrap_or(o.tolerance);
    o.restore_closure = args.closure.map(|c| c == ClosureMode::Restore).or(o.restore_closure);
    o.engine = args.engine.map_or(o.engine, |e| Engine::ALL[e as usize]);
    o.groups = args.groups.map_or(o.groups, |g| Groups::ALL[g as usize]);
    o.thick_zones = args.thick_zones.map_or(o.thick_zones, |t| ThickZones::ALL[t as usize]);
    o.zoning_error = args.zoning_error.or(o.zoning_error);
    o.sweeps = args.sweeps.or(o.sweeps);
    scene.with_options(o).map_err(|e| {
        let flag = e.key().strip_prefix("solve.").unwrap_or(e.key()).replace('_', "-");
        Failure::new(format!("--{flag}: {}", e.what()))
    })
}

/// `NAME.npz` with an ending more.
pub fn beside(output: &Path, ending: &str) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(format!(".{ending}"));
    PathBuf::from(name)
}

/// What the stages of a scene belong to, with formulas of these settings.
pub fn keys(scene: &Scene, settings: Settings) -> Keys {
    let made = |hash: String| format!("zonal {} {hash} {:?}", env!("CARGO_PKG_VERSION"), settings.voxels);
    Keys { whole: made(output::scene_hash(scene)), factors: made(output::factors_hash(scene)) }
}

/// The folder of the checkpoint, ready: with what it holds where that is wanted and of this scene, else empty.
fn checkpoint(scene: &Scene, args: &Args) -> Result<Folder, Failure> {
    let named = args.checkpoint.clone().flatten();
    let path = named.unwrap_or_else(|| beside(&args.output, "checkpoint"));
    let folder = Folder::new(&path, keys(scene, args.factors.settings()));
    match folder.held() {
        Held::Same if args.resume => {}
        Held::Other if args.resume => {
            note(&format!(
                "{}: holds the state of another scene, of other options or of another version; beginning anew",
                path.display()
            ));
            folder.remove();
        }
        _ => folder.remove(),
    }
    folder.begin()?;
    Ok(folder)
}

/// Solves and signs a scene.
pub fn signed(scene: Scene, job: &Job) -> Result<Solution, Failure> {
    let mut solution = zonal_solve::solve_job(scene, job)?;
    solution.scene_hash = output::scene_hash(&solution.scene);
    Ok(solution)
}

/// The same with nothing but formulas to choose.
pub fn solved(
    scene: Scene,
    memory: u64,
    settings: Settings,
    progress: &dyn Progress,
) -> Result<Solution, Failure> {
    signed(scene, &Job { settings, ..Job::new(memory, progress) })
}
