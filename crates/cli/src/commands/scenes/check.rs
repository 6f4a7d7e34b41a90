//! `zonal check`: validates a scene and estimates the cost of a solve.

use crate::commands::context::{Context, memory_limit, option_failure};
use std::path::PathBuf;
use std::time::Instant;
use zonal_app::quality::Quality;
use zonal_app::scene_check::{CheckSettings, SceneCheck};
use zonal_math::Vec3;
use zonal_report::{Failure, say};
use zonal_scene::{Engine, SceneError};
use zonal_solve::forecast::distribution_cost::Traffic;
use zonal_solve::forecast::time_and_memory::CostEstimate;

/// Validate a scene; count its zones; estimate time and memory of a solve.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Scene file (.toml).
    pub scene: PathBuf,
    /// Quality of the estimated solve.
    #[arg(long, value_enum, default_value_t)]
    pub quality: Quality,
    /// Relative tolerance of the estimated solve, 0 < T < 1 [default: that of the scene, else 0.01].
    #[arg(long, value_name = "T")]
    pub tolerance: Option<f64>,
    /// Engine of the estimated solve [default: that of the scene, else auto].
    #[arg(long, value_enum)]
    pub engine: Option<Engine>,
    /// Memory limit of the estimated solve, GB.
    #[arg(long, default_value_t = 12.0, value_name = "GB")]
    pub max_memory: f64,
    /// Number of processes that share the estimated solve (`zonal-mpi`), each with the threads of this command.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub ranks: u16,
}

/// Runs the command.
///
/// # Errors
/// For options and scenes that are not valid, and for scenes that `zonal solve` would refuse.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let memory_limit = memory_limit(args.max_memory)?;
    let settings = CheckSettings { memory_limit, ranks: args.ranks.into(), start: Instant::now() };
    let scene = zonal_io::input::read_scene(&args.scene)?;
    let mut options = args.quality.of_solve(&scene);
    options.tolerance = args.tolerance.unwrap_or(options.tolerance);
    options.engine = args.engine.unwrap_or(options.engine);
    let scene = scene.with_options(options).map_err(|e| option_failure(&e))?;
    let in_scene = |e: SceneError| Failure::in_file(&args.scene, e);
    let check = SceneCheck::new(&scene, &settings).map_err(in_scene)?;
    if context.json {
        context.say_json(check.json())?;
    } else {
        print_text(args, &check)?;
    }
    check.estimate.map_err(in_scene)?;
    context.check_warnings(&check.diagnostics)
}

fn print_text(args: &Args, c: &SceneCheck) -> Result<(), Failure> {
    let (scene, size) = (c.scene, &c.size);
    let verdict = if c.estimate.is_ok() { "valid" } else { "`zonal solve` will refuse it" };
    say(&format!("{}: {verdict}", args.scene.display()))?;
    let (lower, upper) = scene.bounds();
    say(&format!("  {}", extent_text(lower, upper)))?;
    say(&format!(
        "  {} surfaces, {} facets, {} possible occluders",
        scene.surfaces().len(),
        scene.facets().len(),
        size.occluders
    ))?;
    say(&format!(
        "  {} patches, {} voxel zones ({} of cut voxels), {} pane zones",
        size.patches, size.voxels, size.cut, size.panes
    ))?;
    if let Ok(e) = &c.estimate {
        print_estimate(e, c.threads, c.ranks)?;
    }
    say(&format!(
        "  {} pairs in {} distinct band(s), {:.2} GB as matrices; {:.3e} shadow rays of direct light",
        size.pairs,
        size.groups,
        size.bytes as f64 / 1e9,
        c.shadow_rays
    ))?;
    if let Some(seconds) = c.exchange_seconds {
        say(&format!("  exchange areas of all pairs as arrays (`zonal exchange`): about {seconds:.1} s"))?;
    }
    let cameras: Vec<&str> = scene.cameras().iter().map(|c| c.name.as_str()).collect();
    say(&format!("  cameras: {}", if cameras.is_empty() { "none".into() } else { cameras.join(", ") }))?;
    c.diagnostics.iter().try_for_each(|d| say(&format!("  {}", d.line())))
}

/// Size and place of a scene, in metres.
fn extent_text(lower: Vec3, upper: Vec3) -> String {
    let size = (upper - lower).array().map(|x| format!("{x:.4}"));
    let corner = |p: Vec3| p.array().map(|x| format!("{x:.4}")).join(", ");
    format!("extent {} m, from ({}) to ({})", size.join(" × "), corner(lower), corner(upper))
}

/// Prints engine, time and memory of a solve.
fn print_estimate(e: &CostEstimate, threads: usize, ranks: usize) -> Result<(), Failure> {
    let (seconds, gigabytes) = (|s: f64| format!("{:.*}", usize::from(s < 9.95), s), |b: u64| b as f64 / 1e9);
    say(&format!("  engine: {} ({})", e.engine.name(), e.reason))?;
    let has_upper_bound = e.seconds[1] > e.seconds[0] || e.bytes[1] > e.bytes[0];
    let upper_bound = if has_upper_bound {
        format!("; upper bound {} s and {:.2} GB", seconds(e.seconds[1]), gigabytes(e.bytes[1]))
    } else {
        String::new()
    };
    let place = match ranks {
        1 => format!("on {threads} thread(s)"),
        _ => format!("for each of {ranks} ranks of {threads} thread(s)"),
    };
    say(&format!(
        "  about {} s and {:.2} GB {place}{upper_bound}",
        seconds(e.seconds[0]),
        gigabytes(e.bytes[0])
    ))?;
    if let Some(Traffic { product, total }) = e.traffic {
        let [product, total] = [product, total].map(|b| b as f64 / 1e6);
        say(&format!(
            "  a rank sends about {total:.0} MB, {product:.2} MB for each product of a light group"
        ))?;
    }
    let phases: Vec<String> = e.parts.iter().map(|(phase, s)| format!("{phase} {} s", seconds(*s))).collect();
    say(&format!("    {}", phases.join(", ")))
}
