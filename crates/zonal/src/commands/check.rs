//! `zonal check`: is the scene sound, what will it take.

use super::Context;
use super::solve::EngineName;
use crate::Failure;
use crate::failure::say;
use std::path::PathBuf;
use std::time::Instant;
use zonal_exchange::pair::Settings;
use zonal_scene::{Engine, Note, Scene, SceneError};
use zonal_solve::forecast::{self, Forecast};
use zonal_solve::outlook::{self, Outlook, Plan};
use zonal_transport::zoning::left_out;
use zonal_transport::{Transport, build_zones};

/// Validate a scene, count its zones, forecast time and memory, warn.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Scene file (.toml).
    pub scene: PathBuf,
    /// Forecast for this accuracy, between 0 and 1, in place of the scene's.
    #[arg(long)]
    pub tolerance: Option<f64>,
    /// Forecast for this engine in place of the scene's.
    #[arg(long, value_enum)]
    pub engine: Option<EngineName>,
    /// Largest memory that `solve` may take, GB.
    #[arg(long, default_value_t = 12.0)]
    pub max_memory: f64,
}

/// Runs the command.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    if !(args.max_memory > 0.0 && args.max_memory.is_finite()) {
        return Err(Failure::new("--max-memory: give a positive number of gigabytes"));
    }
    let start = Instant::now();
    let scene = with_options(zonal_io::input::read_scene(&args.scene)?, args)?;
    let transport = Transport::new(&scene);
    let mut zones = build_zones(&scene, &transport).map_err(|e| Failure::in_file(&args.scene, e))?;
    let mut warnings = left_out(&scene, &transport, &zones).map_err(|e| Failure::in_file(&args.scene, e))?;
    zonal_solve::thermal::pose(&scene, &mut zones);
    let reading = start.elapsed().as_secs_f64();
    let f = Forecast::new(&scene, &zones, &transport);
    if forecast::is_open(&scene, &zones, &transport) {
        let text = "the scene is open: some rays leave it; its surroundings take part as a zone";
        warnings.push(Note::new("open-scene", text));
    }
    let threads = rayon::current_num_threads();
    let (rays, light) = forecast::direct_light(&scene, &zones, &transport, threads);
    let plan = Plan {
        scene: &scene,
        zones: &zones,
        transport: &transport,
        forecast: &f,
        settings: Settings::default(),
        memory: (args.max_memory * 1e9) as u64,
        threads,
    };
    let outlook = Outlook::new(&plan, &|| start.elapsed().as_secs_f64()).map(|o| o.beginning(reading));
    warnings.extend(forecast::warnings(&scene, f.thickness, !outlook.as_ref().is_ok_and(|o| o.slopes)));
    if let Ok(o) = &outlook {
        warnings.extend(o.notes.iter().cloned());
    }
    if context.json {
        let o = outlook.as_ref().ok();
        let parts = |o: &Outlook| {
            o.parts.iter().map(|(k, s)| serde_json::json!({"what": k, "seconds": s})).collect::<Vec<_>>()
        };
        let json = serde_json::json!({
            "verdict": if o.is_some() { "sound" } else { "refused" },
            "scene": scene.name(), "surfaces": scene.surfaces().len(), "facets": scene.facets().len(),
            "patches": f.patches, "voxel_zones": f.voxels, "cut_voxel_zones": f.cut, "pane_zones": f.panes,
            "pairs": f.pairs, "distinct_bands": f.groups, "dense_bytes": f.bytes,
            "engine": o.map(|o| o.engine.word()), "reason": o.map(|o| o.reason.clone()),
            "seconds": o.map(|o| o.seconds), "memory_bytes": o.map(|o| o.bytes), "parts": o.map(parts),
            "zone_bytes": f.zone_bytes, "shadow_rays": rays, "direct_light_seconds": light,
            "occluders": f.occluders, "lights": scene.lights().len(),
            "cameras": scene.cameras().iter().map(|c| c.name.clone()).collect::<Vec<_>>(),
            "warnings": zonal_io::output::notes_json(&warnings),
        });
        say(&format!("{json:#}"))?;
        verdict(args, outlook)?;
        return context.judge(&warnings);
    }
    let word = if outlook.is_ok() { "sound" } else { "`solve` will refuse it" };
    say(&format!("{}: {word}", args.scene.display()))?;
    say(&format!(
        "  {} surfaces, {} facets, {} of which can hide something",
        scene.surfaces().len(),
        scene.facets().len(),
        f.occluders
    ))?;
    say(&format!(
        "  {} patches, {} voxel zones ({} parts of cut voxels), {} pane zones",
        f.patches, f.voxels, f.cut, f.panes
    ))?;
    if let Ok(o) = &outlook {
        tell(o, threads)?;
    }
    say(&format!(
        "  {} pairs in {} distinct band(s), all of them {:.2} GB; {rays:.3e} shadow rays of direct light",
        f.pairs,
        f.groups,
        f.bytes as f64 / 1e9
    ))?;
    if let Some(seconds) = outlook::exchange_areas(&plan, &|| start.elapsed().as_secs_f64()) {
        say(&format!("  all exchange areas as arrays (`zonal exchange`): about {seconds:.1} s"))?;
    }
    let cameras: Vec<&str> = scene.cameras().iter().map(|c| c.name.as_str()).collect();
    say(&format!("  cameras: {}", if cameras.is_empty() { "none".into() } else { cameras.join(", ") }))?;
    for w in &warnings {
        say(&format!("  {}", w.line()))?;
    }
    verdict(args, outlook)?;
    context.judge(&warnings)
}

/// A refusal that `solve` would end with, as it would end.
fn verdict(args: &Args, outlook: Result<Outlook, SceneError>) -> Result<(), Failure> {
    outlook.map(|_| ()).map_err(|e| Failure::in_file(&args.scene, e))
}

/// The scene with the options of the command line.
fn with_options(scene: Scene, args: &Args) -> Result<Scene, Failure> {
    let mut o = scene.options().clone();
    o.tolerance = args.tolerance.unwrap_or(o.tolerance);
    o.engine = args.engine.map_or(o.engine, |e| Engine::ALL[e as usize]);
    scene.with_options(o).map_err(|e| {
        let flag = e.key().strip_prefix("solve.").unwrap_or(e.key());
        Failure::new(format!("--{flag}: {}", e.what()))
    })
}

/// Says what a solve will take.
fn tell(o: &Outlook, threads: usize) -> Result<(), Failure> {
    let (seconds, gigabytes) = (|s: f64| format!("{:.*}", usize::from(s < 9.95), s), |b: u64| b as f64 / 1e9);
    say(&format!("  engine: {} ({})", o.engine.word(), o.reason))?;
    let hardly = match o.seconds[1] > o.seconds[0] || o.bytes[1] > o.bytes[0] {
        true => format!("; hardly more than {} s and {:.2} GB", seconds(o.seconds[1]), gigabytes(o.bytes[1])),
        false => String::new(),
    };
    say(&format!(
        "  about {} s and {:.2} GB on {threads} thread(s){hardly}",
        seconds(o.seconds[0]),
        gigabytes(o.bytes[0])
    ))?;
    let parts: Vec<String> = o.parts.iter().map(|(what, s)| format!("{what} {} s", seconds(*s))).collect();
    say(&format!("    {}", parts.join(", ")))
}
