//! `zonal export`: the zones as a table, or the viewer's page in one file.

use super::{Context, check_output};
use crate::failure::say;
use crate::viewer::package::{Detail, package};
use crate::viewer::page;
use crate::{Failure, meter::Meter};
use std::path::PathBuf;
use zonal_io::output;
use zonal_scene::Solution;

/// Write the zones of a solution as a table, or the viewer's page as one file.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Solution (.npz).
    pub run: PathBuf,
    /// What to write: a table of the zones (.csv), or the page of `zonal view` with all its data in one file, which opens without a
    /// server or a network (.html).
    #[arg(long, short)]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    check_output(&args.output, &["csv", "html"])?;
    let solution = output::read_solution(&args.run)?;
    if args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("html")) {
        return write_page(args, &solution, context);
    }
    output::write_zones_csv(&args.output, &solution)?;
    if context.json {
        say(&format!(
            "{}",
            serde_json::json!({ "zones": solution.zones.len(), "written": args.output.display().to_string() })
        ))?;
    } else {
        say(&format!("{} zones written: {}", solution.zones.len(), args.output.display()))?;
    }
    Ok(())
}

/// The viewer's page.
fn write_page(args: &Args, solution: &Solution, context: Context) -> Result<(), Failure> {
    let package = package(solution, &Detail::default(), &Meter::new(context.quiet))?;
    let text = page::single(&package);
    output::write_bytes(&args.output, text.as_bytes())?;
    let place = args.output.display();
    if context.json {
        return say(&serde_json::json!({ "bytes": text.len(), "written": place.to_string() }).to_string());
    }
    say(&format!("a page of {:.1} MB written: {place}", text.len() as f64 / 1e6))
}
