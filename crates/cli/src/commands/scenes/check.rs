//! `zonal check`: validates a scene and estimates the cost of a solve.

use crate::commands::context::{Context, memory_limit, option_failure};
use crate::commands::quality::Quality;
use std::path::PathBuf;
use std::time::Instant;
use zonal_exchange::pair::PairSettings;
use zonal_math::Vec3;
use zonal_report::{Failure, say};
use zonal_scene::{Diagnostic, Engine, Scene, SceneError, ZoneImages, Zones};
use zonal_solve::engines::problem_size::{self, ProblemSize};
use zonal_solve::forecast::distribution_cost::Traffic;
use zonal_solve::forecast::time_and_memory::{self, CostEstimate, CostModelInput};
use zonal_solve::pipeline::mirrors::{self, MirroredSolve};
use zonal_transport::{Transport, build_zones};

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

/// Everything that the command found out about a scene.
struct SceneCheck<'a> {
    scene: &'a Scene,
    size: ProblemSize,
    threads: usize,
    /// Number of processes.
    ranks: usize,
    /// Expected number of shadow rays.
    shadow_rays: f64,
    /// Expected seconds of direct light.
    direct_light_seconds: f64,
    /// Expected seconds of `zonal exchange`, if known.
    exchange_seconds: Option<f64>,
    /// The estimate of a solve, or the reason why it would be refused.
    estimate: Result<CostEstimate, SceneError>,
    diagnostics: Vec<Diagnostic>,
}

/// Runs the command.
///
/// # Errors
/// For options and scenes that are not valid, and for scenes that `zonal solve` would refuse.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let memory_limit = memory_limit(args.max_memory)?;
    let start = Instant::now();
    let scene = with_options(zonal_io::input::read_scene(&args.scene)?, args)?;
    let in_scene = |e: SceneError| Failure::in_file(&args.scene, e);
    let report = |check: SceneCheck| {
        if context.json {
            say(&format!("{:#}", json(&check)))?;
        } else {
            print_text(args, &check)?;
        }
        if let Err(e) = check.estimate {
            return Err(in_scene(e));
        }
        context.check_warnings(&check.diagnostics)
    };
    with_check(&scene, (memory_limit, args.ranks.into()), start, report).map_err(in_scene)?
}

/// The JSON report of a scene for a memory limit in bytes; `start` is when reading began.
///
/// # Errors
/// If the scene cannot be divided into zones. A solve that would be refused is the verdict `refused`.
pub fn scene_report(
    scene: &Scene,
    memory_limit: u64,
    start: Instant,
) -> Result<serde_json::Value, SceneError> {
    with_check(scene, (memory_limit, 1), start, |check| json(&check))
}

/// Divides a scene into zones, estimates the cost of a solve, and passes the result on.
fn with_check<T>(
    scene: &Scene,
    limits: (u64, usize),
    start: Instant,
    report: impl FnOnce(SceneCheck<'_>) -> T,
) -> Result<T, SceneError> {
    // Divide it into zones.
    let transport = Transport::new(scene);
    let mut zones = build_zones(scene, &transport)?;
    let mut excluded = mirrors::excluded_parts_of(scene, &transport, &zones)?;
    let (scenes, own) = (std::slice::from_ref(scene), std::slice::from_mut(&mut zones));
    zonal_solve::thermal::apply_boundary_conditions(scenes, own);
    // Estimate the cost of a solve; a scene with mirrors is solved on its even extension.
    let mirrored = MirroredSolve::of(scene, &zones)?;
    excluded.extend(mirrored.as_ref().map(|m| mirrors::mirror_note(scene, m.images.image_count())));
    let mut check = match &mirrored {
        Some(m) => {
            let transport = Transport::new(&m.extension.scene);
            let images = Some(&m.images);
            check_scene((&m.extension.scene, &m.zones, &transport, images), limits, excluded, start)
        }
        None => check_scene((scene, &zones, &transport, None), limits, excluded, start),
    };
    // Counts and names are those of the scene itself.
    check.scene = scene;
    Ok(report(check))
}

/// The scene with the options of the command line.
fn with_options(scene: Scene, args: &Args) -> Result<Scene, Failure> {
    let mut o = args.quality.of_solve(&scene);
    o.tolerance = args.tolerance.unwrap_or(o.tolerance);
    o.engine = args.engine.unwrap_or(o.engine);
    scene.with_options(o).map_err(|e| option_failure(&e))
}

/// Counts, cost and diagnostics of a scene; `start` is when reading began.
fn check_scene<'a>(
    (scene, zones, transport, images): (&'a Scene, &Zones, &Transport, Option<&ZoneImages>),
    (memory_limit, ranks): (u64, usize),
    excluded: Vec<Diagnostic>,
    start: Instant,
) -> SceneCheck<'a> {
    let reading_seconds = start.elapsed().as_secs_f64();
    let clock = || start.elapsed().as_secs_f64();
    let threads = rayon::current_num_threads();
    let size = ProblemSize::new(scene, zones, transport).with_images(images);
    let mut diagnostics = excluded;
    diagnostics.extend(zonal_scene::topology::survey(scene));
    if problem_size::is_open(scene, zones, transport) {
        let text =
            "the scene is open: some rays leave it; the surroundings take part in the exchange as a zone";
        diagnostics.push(Diagnostic::note("open-scene", text));
    }
    let (shadow_rays, direct_light_seconds) =
        problem_size::direct_light_cost(scene, zones, transport, threads);
    let input = CostModelInput {
        scene,
        zones,
        transport,
        size: &size,
        pair_settings: PairSettings::default(),
        memory_limit,
        threads,
        ranks,
    };
    let estimate =
        CostEstimate::new(&input, &clock).map(|e| e.for_bands(scene).with_reading_time(reading_seconds));
    let basis = estimate.as_ref().map_or(zonal_scene::ZoneBasis::Constant, CostEstimate::basis);
    diagnostics.extend(problem_size::scene_diagnostics(scene, zones, size.thickness, basis));
    diagnostics.extend(estimate.iter().flat_map(|e| e.notes.iter().cloned()));
    let exchange_seconds = time_and_memory::exchange_areas_cost(&input, &clock);
    SceneCheck {
        scene,
        size,
        threads,
        ranks,
        shadow_rays,
        direct_light_seconds,
        exchange_seconds,
        estimate,
        diagnostics,
    }
}

fn json(c: &SceneCheck) -> serde_json::Value {
    let (scene, size, e) = (c.scene, &c.size, c.estimate.as_ref().ok());
    let (lower, upper) = scene.bounds();
    let extent = [lower, upper].map(Vec3::array);
    let phases = |e: &CostEstimate| {
        e.parts.iter().map(|(k, s)| serde_json::json!({"phase": k, "seconds": s})).collect::<Vec<_>>()
    };
    serde_json::json!({
        "verdict": if e.is_some() { "valid" } else { "refused" },
        "extent": extent,
        "scene": scene.name(), "surfaces": scene.surfaces().len(), "facets": scene.facets().len(),
        "patches": size.patches, "voxel_zones": size.voxels, "cut_voxel_zones": size.cut, "pane_zones": size.panes,
        "pairs": size.pairs, "distinct_bands": size.groups, "dense_bytes": size.bytes,
        "engine": e.map(|e| e.engine.name()), "reason": e.map(|e| e.reason.clone()),
        "seconds": e.map(|e| e.seconds), "memory_bytes": e.map(|e| e.bytes), "ranks": c.ranks,
        "sent_bytes": e.and_then(|e| e.traffic).map(|t| t.total), "sent_bytes_of_product": e.and_then(|e| e.traffic).map(|t| t.product), "phases": e.map(phases),
        "exchange_areas_seconds": c.exchange_seconds,
        "zone_bytes": size.zone_bytes, "shadow_rays": c.shadow_rays, "direct_light_seconds": c.direct_light_seconds,
        "occluders": size.occluders, "lights": scene.lights().len(),
        "cameras": scene.cameras().iter().map(|c| c.name.clone()).collect::<Vec<_>>(),
        "warnings": zonal_io::output::notes_json(&c.diagnostics),
    })
}

fn print_text(args: &Args, c: &SceneCheck) -> Result<(), Failure> {
    let (scene, size) = (c.scene, &c.size);
    let verdict = if c.estimate.is_ok() { "valid" } else { "`zonal solve` will refuse it" };
    say(&format!("{}: {verdict}", args.scene.display()))?;
    say(&format!("  {}", extent_text(scene.bounds())))?;
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
        print_estimate(e, [c.threads, c.ranks])?;
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
fn extent_text((lower, upper): (Vec3, Vec3)) -> String {
    let size = (upper - lower).array().map(|x| format!("{x:.4}"));
    let corner = |p: Vec3| p.array().map(|x| format!("{x:.4}")).join(", ");
    format!("extent {} m, from ({}) to ({})", size.join(" × "), corner(lower), corner(upper))
}

/// Prints engine, time and memory of a solve.
fn print_estimate(e: &CostEstimate, [threads, ranks]: [usize; 2]) -> Result<(), Failure> {
    let (seconds, gigabytes) = (|s: f64| format!("{:.*}", usize::from(s < 9.95), s), |b: u64| b as f64 / 1e9);
    say(&format!("  engine: {} ({})", e.engine.name(), e.reason))?;
    let upper_bound = match e.seconds[1] > e.seconds[0] || e.bytes[1] > e.bytes[0] {
        true => format!("; upper bound {} s and {:.2} GB", seconds(e.seconds[1]), gigabytes(e.bytes[1])),
        false => String::new(),
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
