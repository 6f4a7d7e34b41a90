//! `zonal solve`: reads a scene, solves it, writes the solution.

use super::context::{Context, memory_limit, option_failure};
use super::quality::Quality;
use super::solving::{checkpoint_keys, if_all_succeeded, path_beside};
use crate::commands::pairs::voxel_factors::VoxelFactors;
use crate::table;
use std::borrow::Cow;
use std::cell::Cell;
use std::path::PathBuf;
use zonal_io::output::{self, CheckpointFolder, CheckpointState};
use zonal_report::{Failure, check_output, note, say};
use zonal_scene::{CheckpointStore, Engine, LightGrouping, NoCheckpoints, Scene, Solution, ZoneBasis};
use zonal_solve::SolveSettings;
use zonal_solve::distribution::{Communicator, SingleProcess};
use zonal_solve::pipeline::zone_division;

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
    let is_first = communicator.rank() == 0;
    // Check the arguments and read the scene.
    let AgreedScene { scene, hash, memory_limit } = agreed(read_scene(args), communicator)?;
    let uses_checkpoint = args.checkpoint.is_some() || args.resume || args.keep_factors;
    let folder = uses_checkpoint.then(|| shared_checkpoint(&scene, args, communicator)).transpose()?;
    // Solve it.
    let progress = context.progress();
    let stages = folder.as_ref().map(|folder| RankCheckpoints { folder, is_first });
    let settings = SolveSettings {
        pair_settings: args.factors.pair_settings(),
        checkpoints: stages.as_ref().map_or(&NoCheckpoints, |f| f as &dyn CheckpointStore),
        communicator,
        ..SolveSettings::new(memory_limit, &progress)
    };
    let solved = zonal_solve::solve_with_settings(scene, &settings).map_err(|e| {
        // A refused solve leaves nothing to resume.
        folder.iter().filter(|_| is_first).for_each(CheckpointFolder::remove);
        Failure::in_file(&args.scene, e)
    })?;
    let solution = Solution { scene_hash: hash, ..solved };
    // Write the solution, then remove the checkpoint. The first rank writes, and collects the fields of the others.
    let collected = Cell::new(0);
    let collect: &output::CollectZones = &|own| {
        collected.set(collected.get() + 1);
        zone_division::collect(&solution, communicator, own)
    };
    if !is_first {
        output::collect_solution(&solution, collect);
        return Ok(());
    }
    let written = output::write_divided_solution(&args.output, &solution, collect);
    if written.is_err() {
        // The other ranks send what is left.
        let left = Cell::new(collected.get());
        output::collect_solution(&solution, &|own| match left.get() {
            0 => zone_division::collect(&solution, communicator, own),
            n => {
                left.set(n - 1);
                Cow::Borrowed(own)
            }
        });
    }
    written?;
    if let Some(folder) = folder {
        close_checkpoint(folder, args)?;
    }
    print_report(args, &solution, context)?;
    context.check_report(&solution.report)
}

/// The scene with the options of the command line, and the memory limit.
fn read_scene(args: &Args) -> Result<(Scene, u64), Failure> {
    check_output(&args.output, &["npz"])?;
    let memory_limit = memory_limit(args.max_memory)?;
    let scene = zonal_io::input::read_scene(&args.scene)?;
    Ok((with_options(scene, args)?, memory_limit))
}

/// What every rank read.
struct AgreedScene {
    scene: Scene,
    /// Hash of the scene.
    hash: String,
    /// Memory limit, bytes.
    memory_limit: u64,
}

/// What every rank read, if all could read the same scene with the same version.
fn agreed(
    read: Result<(Scene, u64), Failure>,
    communicator: &dyn Communicator,
) -> Result<AgreedScene, Failure> {
    let read = read.map(|(scene, memory_limit)| {
        let hash = output::scene_hash(&scene);
        AgreedScene { scene, hash, memory_limit }
    });
    if communicator.size() == 1 {
        return read;
    }
    let own = match &read {
        Ok(read) => format!("{} {} {}", env!("CARGO_PKG_VERSION"), read.hash, read.memory_limit),
        Err(e) => format!("{FAILED}{e}"),
    };
    let all = communicator.all_gather(own.into_bytes());
    let read = read?;
    let failure = |(rank, text): (usize, &Vec<u8>)| {
        let message = text.strip_prefix(FAILED.as_bytes())?;
        Some(Failure::new(format!("rank {rank}: {}", String::from_utf8_lossy(message))))
    };
    if let Some(failure) = all.iter().enumerate().find_map(failure) {
        return Err(failure);
    }
    match all.iter().position(|other| *other != all[0]) {
        None => Ok(read),
        Some(rank) => Err(Failure::new(format!(
            "rank {rank} has another scene, another memory limit or another version than rank 0; give all ranks the same files and the same program"
        ))),
    }
}

/// Mark of a rank that failed to read its scene.
const FAILED: &str = "failed ";

/// The folder of the checkpoint, which the first rank prepares before the others use it.
fn shared_checkpoint(
    scene: &Scene,
    args: &Args,
    communicator: &dyn Communicator,
) -> Result<CheckpointFolder, Failure> {
    let folder = match communicator.rank() {
        0 => resume_or_begin_checkpoint(scene, args),
        _ => Ok(checkpoint_folder(scene, args)),
    };
    if_all_succeeded(folder, communicator)
}

/// The stages of a checkpoint for one rank: it saves the rows that it owns, the first rank also what all ranks have.
struct RankCheckpoints<'a> {
    folder: &'a CheckpointFolder,
    is_first: bool,
}

impl CheckpointStore for RankCheckpoints<'_> {
    fn keeps(&self) -> bool {
        self.folder.keeps()
    }
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        self.folder.load(stage)
    }
    fn save(&self, stage: &str, bytes: &[u8]) {
        if self.is_first || zonal_solve::distribution::is_stage_of_one_rank(stage) {
            self.folder.save(stage, bytes);
        }
    }
}

/// The scene with the options of the command line.
fn with_options(scene: Scene, args: &Args) -> Result<Scene, Failure> {
    let mut o = args.quality.of_solve(&scene);
    o.tolerance = args.tolerance.unwrap_or(o.tolerance);
    o.restore_closure = args.closure.map(|c| c == ClosureMode::Restore).or(o.restore_closure);
    o.engine = args.engine.unwrap_or(o.engine);
    o.light_grouping = args.light_groups.unwrap_or(o.light_grouping);
    o.zone_basis = args.zone_basis.unwrap_or(o.zone_basis);
    o.discretization_error = args.discretization_error.or(o.discretization_error);
    o.scattering_orders = args.scattering_orders.or(o.scattering_orders);
    scene.with_options(o).map_err(|e| option_failure(&e))
}

fn checkpoint_path(args: &Args) -> PathBuf {
    let named = args.checkpoint.clone().flatten();
    named.unwrap_or_else(|| path_beside(&args.output, "checkpoint"))
}

fn checkpoint_folder(scene: &Scene, args: &Args) -> CheckpointFolder {
    CheckpointFolder::new(&checkpoint_path(args), checkpoint_keys(scene, args.factors.pair_settings()))
}

/// The folder of the checkpoint: with its stages if `--resume` is given and they belong to this scene, else empty.
fn resume_or_begin_checkpoint(scene: &Scene, args: &Args) -> Result<CheckpointFolder, Failure> {
    let folder = checkpoint_folder(scene, args);
    folder.claim()?;
    match folder.state() {
        CheckpointState::Matching if args.resume => {}
        CheckpointState::Mismatched if args.resume => {
            note(&format!(
                "{}: this checkpoint belongs to another scene, other options or another version; starting from the beginning",
                checkpoint_path(args).display()
            ));
            folder.clear();
        }
        _ => folder.clear(),
    }
    folder.begin()?;
    Ok(folder)
}

/// Removes a checkpoint after the solve, or keeps its factors.
fn close_checkpoint(folder: CheckpointFolder, args: &Args) -> Result<(), Failure> {
    if let Some(e) = folder.failure() {
        note(&format!("the checkpoint could not be written: {e}"));
    }
    if args.keep_factors {
        return Ok(folder.keep_factors(&path_beside(&args.output, "factors"))?);
    }
    folder.remove();
    Ok(())
}

/// Prints the report, and a command to draw the solution.
fn print_report(args: &Args, solution: &Solution, context: Context) -> Result<(), Failure> {
    if context.json {
        return say(&format!("{:#}", output::report_json(solution)));
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
