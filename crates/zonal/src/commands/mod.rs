//! The subcommands of `zonal`.

pub mod animate;
pub mod check;
pub mod demo;
pub mod exchange;
pub mod export;
pub mod factors;
pub mod relight;
pub mod render;
pub mod reproduce;
pub mod show;
pub mod solve;
pub mod validate;
pub mod view;

use clap::{Parser, Subcommand};
use std::path::Path;

use crate::Failure;
use zonal_scene::{Note, Report};

/// Radiative exchange between surfaces and participating media by the zonal method.
///
/// A scene file (TOML) names surfaces, media, lights and cameras. `check` it, `solve` it once, `render` it from anywhere.
/// Start with `zonal demo`.
#[derive(Parser, Debug)]
#[command(version, about, arg_required_else_help = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Threads to use (default: all cores). Results do not depend on it.
    #[arg(long, global = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Reports as JSON on standard output.
    #[arg(long, global = true)]
    pub json: bool,
    /// No progress bars. They are off anyway where standard error is not a terminal.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Any warning in a report ends with exit code 1; what was asked for is written all the same.
    #[arg(long, global = true)]
    pub strict: bool,
}

/// The subcommands.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// Solve an embedded chapel with stained glass and dusty air, and draw it.
    Demo(demo::Args),
    /// Validate a scene, count its zones, forecast time and memory, warn.
    Check(check::Args),
    /// Solve a scene and write the solution (.npz).
    Solve(solve::Args),
    /// Turn the lights of a solution up and down without solving; list them.
    Relight(relight::Args),
    /// Draw a picture from a solution, or the frames of a flight through it.
    Render(render::Args),
    /// Walk through a solution in a browser on this machine.
    View(view::Args),
    /// Write a solution for other programs: table, one-file web page, Blender, ParaView (.csv, .html, .glb, .vtu, .vti).
    Export(export::Args),
    /// Write the exchange areas of all zones of a scene, each with its error radius (.npz).
    Exchange(exchange::Args),
    /// Exchange factors of axis-aligned pairs, with proven error bounds, from a table to a table (.csv).
    Factors(factors::Args),
    /// Compute the paper's figures, table and claims afresh, with plots and a page that explains them.
    Reproduce(reproduce::Args),
    /// Run the cases with known answers: a verdict for each quantity, and a page with plots of convergence.
    Validate(validate::Args),
}

/// Where reports go.
#[derive(Clone, Copy, Debug)]
pub struct Context {
    /// JSON instead of tables.
    pub json: bool,
    /// No progress bars.
    pub quiet: bool,
    /// Warnings count as a failed verdict.
    pub strict: bool,
}

impl Context {
    /// Refuses a report with warnings where the user is strict; its end is exit code 1.
    pub fn judge<'a>(self, notes: impl IntoIterator<Item = &'a Note>) -> Result<(), Failure> {
        let warnings: Vec<&Note> = notes.into_iter().filter(|n| n.is_warning()).collect();
        match warnings.first() {
            Some(first) if self.strict => {
                Err(Failure::verdict(format!("{} warning(s) with --strict, first: {first}", warnings.len())))
            }
            _ => Ok(()),
        }
    }
    /// The same of all that a report says.
    pub fn judge_report(self, report: &Report) -> Result<(), Failure> {
        self.judge(report.warnings.iter().chain(report.zoning.iter().flat_map(|z| &z.notes)))
    }
}

/// Runs a parsed command line.
pub fn run(cli: Cli) -> Result<(), Failure> {
    let threads = cli.threads.map_or(0, usize::from);
    // Also fails where a pool exists already, which then serves as well.
    if let Err(e) = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()
        && std::error::Error::source(&e).is_some()
    {
        let what = "no threads can be started; allow more memory or fewer threads (--threads)";
        return Err(Failure::new(format!("{what} ({e})")));
    }
    let context = Context { json: cli.json, quiet: cli.quiet, strict: cli.strict };
    match cli.command {
        Command::Demo(a) => demo::run(&a, context),
        Command::Check(a) => check::run(&a, context),
        Command::Solve(a) => solve::run(&a, context),
        Command::Relight(a) => relight::run(&a, context),
        Command::Render(a) => render::run(&a, context),
        Command::View(a) => view::run(&a, context),
        Command::Export(a) => export::run(&a, context),
        Command::Exchange(a) => exchange::run(&a, context),
        Command::Factors(a) => factors::run(&a, context),
        Command::Reproduce(a) => reproduce::run(&a, context),
        Command::Validate(a) => validate::run(&a, context),
    }
}

/// A solution that is to be looked at as light; refused where it is one of heat, of which exports and tables tell.
pub fn read_light(path: &Path) -> Result<zonal_scene::Solution, Failure> {
    let solution = zonal_io::output::read_solution(path)?;
    if solution.scene.thermal().is_none() {
        return Ok(solution);
    }
    Err(Failure::in_file(
        path,
        "this is a solution of mode = \"thermal\", whose temperatures are no picture of light; draw them with zonal render --show temperature, or export as .vtu (walls), .vti (medium) or .csv",
    ))
}

/// Refuses an output whose folder does not exist or cannot be written, or whose name has another ending than those allowed, before any work is done.
pub fn check_output(path: &Path, endings: &[&str]) -> Result<(), Failure> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    // A device or a pipe has no ending; where there is but one kind of file, that is it.
    let stream = zonal_io::output::is_stream(path);
    if stream && endings.len() == 1 {
        return Ok(());
    }
    if !endings.contains(&ending.as_str()) {
        let list = endings.iter().map(|e| format!(".{e}")).collect::<Vec<_>>().join(" or ");
        return Err(Failure::new(format!("{}: the output's name must end in {list}", path.display())));
    }
    if path.is_dir() {
        return Err(Failure::new(format!("{}: is a folder; name a file", path.display())));
    }
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(Failure::new(format!(
            "{}: there is no folder {}; make it first",
            path.display(),
            folder.display()
        )));
    }
    zonal_io::output::check_writable(path).map_err(Failure::from)
}
