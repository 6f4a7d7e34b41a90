//! The subcommands of `zonal`: arguments, dispatch, exit codes.
//!
//! Each subcommand is a module with `Args` (the arguments, whose documentation is the text of `--help`) and `run`.

pub mod checks;
pub mod context;
pub mod dataset;
pub mod export;
pub mod pages;
pub mod pairs;
pub mod relight;
pub mod render;
pub mod scenes;
pub mod solve;

use clap::{Parser, Subcommand};
use context::Context;
use zonal_app::timeline::Timeline;
use zonal_report::Failure;

/// Radiative exchange between surfaces and participating media by the zonal method.
///
/// A scene file (TOML) describes surfaces, media, lights and cameras. `zonal check` validates it, `zonal solve` computes the solution once,
/// `zonal render` draws it from any camera. Start with `zonal demo`.
#[derive(Parser, Debug)]
#[command(name = "zonal", version, about, arg_required_else_help = true)]
pub struct Cli {
    /// Subcommand.
    #[command(subcommand)]
    pub command: Command,
    /// Number of threads, 1 to 1024 [default: all cores]. Results are identical to the bit for any number.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Write reports as JSON to standard output.
    #[arg(long, global = true)]
    pub json: bool,
    /// Hide progress bars. They are always hidden if standard error is not a terminal.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// End with exit code 1 if a report contains a warning. Outputs are written all the same.
    #[arg(long, global = true)]
    pub strict: bool,
    /// Report wall time, processor time and threads at work by phase.
    #[arg(long, global = true)]
    pub timings: bool,
}

/// The subcommands.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// Solve and draw a built-in scene with stained glass and dusty air.
    Demo(checks::demo::Args),
    /// Write a scene file for a mesh file: materials, patches, light and cameras, ready to solve.
    Init(scenes::init::Args),
    /// Validate a scene; count its zones; estimate time and memory of a solve.
    Check(scenes::check::Args),
    /// Solve a scene and write the solution (.npz).
    Solve(solve::Args),
    /// Scale the light groups of a solution without solving again, or list them.
    Relight(relight::Args),
    /// Draw a picture from a solution, or the frames of a camera animation.
    Render(Box<render::Args>),
    /// Show a solution in a browser on this machine.
    View(pages::view::Args),
    /// Write a solution for other programs (.csv, .html, .glb, .vtu, .vti).
    Export(export::Args),
    /// Write a page with pictures, tables with errors, and provenance of a solution (.html).
    Report(pages::report::Args),
    /// Write the exchange areas of all pairs of zones of a scene with their error radii (.npz, .csv, .mtx).
    Exchange(pairs::exchange::Args),
    /// Compute fluxes for other temperatures, powers or emissivities from stored exchange areas.
    Update(pairs::update::Args),
    /// Solve a scene many times with sampled numbers, and write inputs and results as arrays (.npz).
    Dataset(dataset::Args),
    /// Compute exchange factors of axis-aligned pairs with proved error bounds, from a table to a table (.csv).
    Factors(pairs::factors::Args),
    /// Compute the view factors of a mesh, or of an input file of View3D (.vs3), with obstructions and sky.
    ViewFactors(pairs::view_factors::Args),
    /// Print the grey gases and the total emissivity of a gas model.
    Gas(pairs::gas::Args),
    /// Print the reference of all keys of scene files.
    Keys(scenes::keys::Args),
    /// Recompute the figures, tables and claims of the 1996 paper, with plots and a page.
    Reproduce(checks::reproduce::Args),
    /// Run the cases with known answers; write verdicts and a page with convergence plots.
    Validate(checks::validate::Args),
}

/// Runs a parsed command line.
///
/// # Errors
/// If a thread cannot be started, and as the subcommand.
pub fn run(cli: Cli) -> Result<(), Failure> {
    start_threads(cli.threads)?;
    let timeline = cli.timings.then(Timeline::default);
    let context =
        Context { json: cli.json, quiet: cli.quiet, strict: cli.strict, timeline: timeline.as_ref() };
    let outcome = match cli.command {
        Command::Demo(a) => checks::demo::run(&a, context),
        Command::Init(a) => scenes::init::run(&a, context),
        Command::Check(a) => scenes::check::run(&a, context),
        Command::Solve(a) => solve::run(&a, context),
        Command::Relight(a) => relight::run(&a, context),
        Command::Render(a) => render::run(&a, context),
        Command::View(a) => pages::view::run(&a, context),
        Command::Export(a) => export::run(&a, context),
        Command::Report(a) => pages::report::run(&a, context),
        Command::Exchange(a) => pairs::exchange::run(&a, context),
        Command::Update(a) => pairs::update::run(&a, context),
        Command::Dataset(a) => dataset::run(&a, context),
        Command::Factors(a) => pairs::factors::run(&a, context),
        Command::ViewFactors(a) => pairs::view_factors::run(&a, context),
        Command::Gas(a) => pairs::gas::run(&a, context),
        Command::Keys(a) => scenes::keys::run(&a, context),
        Command::Reproduce(a) => checks::reproduce::run(&a, context),
        Command::Validate(a) => checks::validate::run(&a, context),
    };
    // A verdict comes after the report.
    context.say_timings().and(outcome)
}

/// Starts the global pool of threads; an existing pool is kept.
///
/// # Errors
/// If a thread cannot be started.
pub fn start_threads(threads: Option<u16>) -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.map_or(0, usize::from));
    match pool.build_global() {
        // An error without a source reports an existing pool.
        Err(e) if std::error::Error::source(&e).is_some() => Err(Failure::new(format!(
            "no threads can be started; allow more memory or fewer threads (--threads) ({e})"
        ))),
        _ => Ok(()),
    }
}
