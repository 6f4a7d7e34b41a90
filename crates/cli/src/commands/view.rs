//! `zonal view`: shows a solution, a scene or a model in the browser.

use super::context::{
    Context, check_uniform_light, memory_limit, option_failure, shown_bands, with_shown_bands,
};
use super::init::ModelArgs;
use super::quality::Quality;
use super::solving::solve_and_hash;
use crate::scene_proposal::propose;
use crate::viewer::package::{PackageDetail, package};
use crate::viewer::page;
use crate::viewer::server::{Route, Server};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use zonal_report::{Failure, say};
use zonal_scene::Solution;
use zonal_solve::SolveSettings;

/// Show a solution, a scene or a model in a browser on this machine.
///
/// A scene (.toml) is solved first, a mesh file gets a scene as `zonal init` writes it. Bakes the solution onto triangles and serves a page that draws it with WebGL 2: walk or orbit, scale lights and exposure, probe values under the
/// pointer, show irradiance, radiosity and error in false colours. The server listens on the loopback address only; Ctrl-C ends it.
/// `zonal export RUN.npz -o page.html` writes the same page as one file that needs no server.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  zonal demo --size small\n  zonal view zonal-demo/chapel.npz --open\n  zonal view hall.glb --open"
)]
pub struct Args {
    /// Solution (.npz), scene (.toml) or mesh file.
    #[arg(value_name = "RUN.npz|SCENE.toml|MODEL")]
    pub input: PathBuf,
    /// Quality of the solve of a scene or model.
    #[arg(long, value_enum, default_value_t = Quality::Draft)]
    pub quality: Quality,
    /// What a model is and becomes.
    #[command(flatten)]
    pub model: ModelArgs,
    /// Memory limit of the solve of a scene or model, GB.
    #[arg(long, default_value_t = 12.0, value_name = "GB")]
    pub max_memory: f64,
    /// Port on the loopback address; 0 takes any free port [default: 8765, or any free port if that is taken].
    #[arg(long)]
    pub port: Option<u16>,
    /// Open the page in the browser.
    #[arg(long)]
    pub open: bool,
    /// Largest number of vertices on surfaces: fewer load faster, more show finer shadows.
    #[arg(long, value_name = "N", default_value_t = PackageDetail::default().max_vertices as u32, value_parser = clap::value_parser!(u32).range(1000..=8_000_000))]
    pub vertices: u32,
    /// First of the three bands that stand for red, green and blue, where the solution has other bands: 0, 3, 6, ….
    #[arg(long, value_name = "B", default_value_t = 0)]
    pub first_band: u32,
}

/// Port if none is given.
const DEFAULT_PORT: u16 = 8765;

/// Runs the command until Ctrl-C.
///
/// # Errors
/// If the solution cannot be read or the port is taken.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let solution = with_shown_bands(read_or_solve(args, context)?, args.first_band as usize)?;
    check_uniform_light(&args.input, &solution)?;
    let detail = PackageDetail { max_vertices: args.vertices as usize };
    let bytes = package(&solution, &detail, &context.progress())?;
    let size = bytes.len();
    if let Some(shown) = shown_bands(&solution).filter(|_| !context.json) {
        say(&shown)?;
    }
    let server = bind(args.port, page::routes(bytes))?;
    ctrlc::set_handler(server.stopper())
        .map_err(|e| Failure::new(format!("the handler of Ctrl-C cannot be installed ({e})")))?;
    let url = format!("http://{}/", server.address());
    if context.json {
        say(&serde_json::json!({ "url": url, "zones": solution.zones.len(), "bytes": size }).to_string())?;
    } else {
        say(&format!(
            "{}: {} zones, {:.1} MB: {url}\nCtrl-C ends the server",
            solution.scene.name(),
            solution.zones.len(),
            size as f64 / 1e6
        ))?;
    }
    drop(solution);
    if args.open {
        open_browser(&url);
    }
    server.run();
    if context.json { Ok(()) } else { say("stopped") }
}

/// The solution of a file, or that of a scene or model.
fn read_or_solve(args: &Args, context: Context) -> Result<Solution, Failure> {
    let memory_limit = memory_limit(args.max_memory)?;
    let extension = args.input.extension().map(|e| e.to_string_lossy().to_lowercase());
    let scene = match extension.as_deref() {
        Some("npz") => return Ok(zonal_io::output::read_solution(&args.input)?),
        Some("toml") => zonal_io::input::read_scene(&args.input)?,
        _ => propose(&args.input, Path::new(""), &args.model.options())?.scene,
    };
    let options = args.quality.of_solve(&scene);
    let scene = scene.with_options(options).map_err(|e| option_failure(&e))?;
    let progress = context.progress();
    let settings = SolveSettings::new(memory_limit, &progress);
    solve_and_hash(scene, &settings)
}

/// Listens on the given port; without one on the default port, or on any free port.
fn bind(port: Option<u16>, routes: Vec<Route>) -> Result<Server, Failure> {
    let bound = match port {
        Some(p) => Server::bind(p, routes),
        None => Server::bind(DEFAULT_PORT, routes.clone()).or_else(|_| Server::bind(0, routes)),
    };
    bound.map_err(|e| {
        let p = port.unwrap_or(0);
        let why = match e.kind() {
            ErrorKind::AddrInUse => "the port is in use".to_string(),
            _ => e.to_string(),
        };
        Failure::new(format!("--port {p}: {why}; give another port, or 0 for any free one"))
    })
}

/// Opens the page in the default browser. A failure is ignored, since the address is printed.
fn open_browser(url: &str) {
    let (program, first): (&str, &[&str]) = match std::env::consts::OS {
        "macos" => ("open", &[]),
        "windows" => ("cmd", &["/C", "start", ""]),
        _ => ("xdg-open", &[]),
    };
    let null = std::process::Stdio::null;
    let _ = std::process::Command::new(program)
        .args(first)
        .arg(url)
        .stdin(null())
        .stdout(null())
        .stderr(null())
        .spawn();
}
