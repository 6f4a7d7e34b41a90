//! `zonal view`: a solution in the browser.

use super::{Context, read_light};
use crate::failure::say;
use crate::viewer::package::{Detail, package};
use crate::viewer::{page, server::Server};
use crate::{Failure, meter::Meter};
use std::io::ErrorKind;
use std::path::PathBuf;

/// Walk through a solution in a browser on this machine.
///
/// Bakes the solution on a mesh and serves a page that draws it with WebGL 2: walk or orbit, turn lights and exposure, probe what is under
/// the pointer, see irradiance, radiosity and error in false colours. Only this machine can reach the page; Ctrl-C ends it.
/// `zonal export RUN.npz -o page.html` writes the same page as one file that needs no server.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  zonal demo --size small\n  zonal view zonal-demo/chapel.npz --open")]
pub struct Args {
    /// Solution (.npz).
    pub run: PathBuf,
    /// Port on the loopback address; 0 takes any free one [default: 8765, or any free one]
    #[arg(long)]
    pub port: Option<u16>,
    /// Open the page in the browser.
    #[arg(long)]
    pub open: bool,
    /// The most vertices on surfaces: fewer load faster, more show finer shadows.
    #[arg(long, value_name = "N", default_value_t = Detail::default().vertices as u32, value_parser = clap::value_parser!(u32).range(1000..=8_000_000))]
    pub vertices: u32,
}

/// The port where none is asked for.
const PORT: u16 = 8765;

/// Runs the command until Ctrl-C.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let solution = read_light(&args.run)?;
    let detail = Detail { vertices: args.vertices as usize };
    let bytes = package(&solution, &detail, &Meter::new(context.quiet))?;
    let size = bytes.len();
    let server = listen(args.port, page::routes(bytes))?;
    let stop = server.stopper();
    ctrlc::set_handler(stop).map_err(|e| Failure::new(format!("Ctrl-C cannot be heard ({e})")))?;
    let url = format!("http://{}/", server.address());
    if context.json {
        say(&serde_json::json!({ "url": url, "zones": solution.zones.len(), "bytes": size }).to_string())?;
    } else {
        say(&format!(
            "{}: {} zones, {:.1} MB: {url}\nCtrl-C ends it",
            solution.scene.name(),
            solution.zones.len(),
            size as f64 / 1e6
        ))?;
    }
    drop(solution);
    if args.open {
        open(&url);
    }
    server.run();
    if context.json { Ok(()) } else { say("stopped") }
}

/// Listens on the port asked for, or on the usual one, or on any.
fn listen(port: Option<u16>, routes: Vec<crate::viewer::server::Route>) -> Result<Server, Failure> {
    let bound = match port {
        Some(p) => Server::bind(p, routes),
        None => Server::bind(PORT, routes.clone()).or_else(|_| Server::bind(0, routes)),
    };
    bound.map_err(|e| {
        let p = port.unwrap_or(0);
        let why = match e.kind() {
            ErrorKind::AddrInUse => "something else listens there".to_string(),
            _ => e.to_string(),
        };
        Failure::new(format!("--port {p}: {why}; give another, or 0 for any free one"))
    })
}

/// Asks the system to show the page; where it cannot, the address is on the screen anyway.
fn open(url: &str) {
    let (program, first): (&str, &[&str]) = match std::env::consts::OS {
        "macos" => ("open", &[]),
        "windows" => ("cmd", &["/C", "start", ""]),
        _ => ("xdg-open", &[]),
    };
    let quiet = std::process::Stdio::null;
    let _ = std::process::Command::new(program)
        .args(first)
        .arg(url)
        .stdin(quiet())
        .stdout(quiet())
        .stderr(quiet())
        .spawn();
}
