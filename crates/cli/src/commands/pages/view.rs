//! `zonal view`: shows a solution, a scene or a model in the browser.

use crate::commands::context::{Context, memory_limit};
use crate::commands::scenes::init::ModelArgs;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use zonal_app::pages::live_solve::{LiveInput, PublishedData};
use zonal_app::pages::viewer::live::LivePage;
use zonal_app::pages::viewer::package::{PackageDetail, package};
use zonal_app::pages::viewer::page;
use zonal_app::pages::viewer::server::{Route, Server};
use zonal_app::quality::Quality;
use zonal_app::shown_solution::{read_uniform_light_solution, shown_bands};
use zonal_report::{Failure, note, say};

/// Show a solution, a scene or a model in a browser on this machine.
///
/// The page of a scene (.toml) or mesh file opens at once and shows direct light, then a draft with interreflection, then the solution of the scene's own
/// tolerance; changes of the file are picked up.
/// A mesh file gets a scene as `zonal init` writes it.
///
/// Bakes the solution onto triangles and serves a page that draws it with WebGL 2: walk or orbit, scale lights and exposure, probe values under the
/// pointer, show irradiance, radiosity and error in false colours. The server listens on the loopback address only; Ctrl-C ends it.
/// `zonal export RUN.npz -o page.html` writes the same page as one file that needs no server.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  zonal demo chapel --size small\n  zonal view zonal-demo/chapel.npz --open\n  zonal view hall.glb --open"
)]
pub struct Args {
    /// Solution (.npz), scene (.toml) or mesh file.
    #[arg(value_name = "RUN.npz|SCENE.toml|MODEL")]
    pub input: PathBuf,
    /// Quality of the solve of a scene or model, after the draft.
    #[arg(long, value_enum, default_value_t)]
    pub quality: Quality,
    /// Unit, upward axis and number of patches of a model.
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

impl Args {
    fn detail(&self) -> PackageDetail {
        PackageDetail { max_vertices: self.vertices as usize, ..PackageDetail::default() }
    }
}

/// Port if none is given.
const DEFAULT_PORT: u16 = 8765;

/// Runs the command until Ctrl-C.
///
/// # Errors
/// If the input cannot be read or the port is taken.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    if LiveInput::is_solved_first(&args.input) {
        run_live(args, context)
    } else {
        run_solution(args, context)
    }
}

/// Shows a solution.
fn run_solution(args: &Args, context: Context) -> Result<(), Failure> {
    let solution = read_uniform_light_solution(&args.input, args.first_band as usize)?;
    let bytes = package(&solution, &args.detail(), &context.progress())?;
    let size = bytes.len();
    if let Some(shown) = shown_bands(&solution).filter(|_| !context.json) {
        say(&shown)?;
    }
    let server = bind(args.port, page::routes(bytes))?;
    stop_on_signal(server.stopper())?;
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
    serve(args, &server, &url);
    if context.json { Ok(()) } else { say("stopped") }
}

/// Solves a scene or a model while its page is open.
fn run_live(args: &Args, context: Context) -> Result<(), Failure> {
    let input = LiveInput {
        path: args.input.clone(),
        model: args.model.options(),
        quality: args.quality,
        memory_limit: memory_limit(args.max_memory)?,
        detail: args.detail(),
        first_band: args.first_band as usize,
        report: &|data| report(data, context),
        note: &note,
    };
    let (scene, files) = input.read();
    let scene = scene?;
    let page = Arc::new(LivePage::with_observer(context.bars()));
    let server = bind(args.port, page::live_routes(&page))?;
    let stop = Arc::new(AtomicBool::new(false));
    let (ended, stopper) = (stop.clone(), server.stopper());
    stop_on_signal(move || {
        ended.store(true, Ordering::SeqCst);
        stopper();
    })?;
    let url = format!("http://{}/", server.address());
    if context.json {
        say(&serde_json::json!({ "url": url }).to_string())?;
    } else {
        say(&format!("{}: {url}\nCtrl-C ends the server", scene.name()))?;
    }
    std::thread::scope(|scope| {
        scope.spawn(|| input.keep_solving(scene, files, &page, &stop));
        serve(args, &server, &url);
    });
    if context.json { Ok(()) } else { say("stopped") }
}

/// Prints that the page has new data.
fn report(data: &PublishedData, context: Context) -> Result<(), Failure> {
    let PublishedData { version, stage, zones, bytes, refined } = *data;
    if context.json {
        let line = serde_json::json!({
            "version": version, "quality": stage, "zones": zones, "bytes": bytes, "refined": refined,
        });
        return say(&line.to_string());
    }
    let mesh = if refined { ", refined mesh" } else { "" };
    say(&format!("{stage}: {zones} zones, {:.1} MB{mesh}", bytes as f64 / 1e6))
}

/// Serves until stopped.
fn serve(args: &Args, server: &Server, url: &str) {
    if args.open {
        open_browser(url);
    }
    server.run();
}

fn stop_on_signal(stopper: impl Fn() + Send + 'static) -> Result<(), Failure> {
    ctrlc::set_handler(stopper)
        .map_err(|e| Failure::new(format!("the handler of Ctrl-C cannot be installed ({e})")))
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
