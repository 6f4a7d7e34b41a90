//! `zonal export`: the zones as a table.

use super::{Context, check_output};
use crate::Failure;
use crate::failure::say;
use std::path::PathBuf;
use zonal_io::output;

/// Write the zones of a solution as a table.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Solution (.npz).
    pub run: PathBuf,
    /// Table to write (.csv).
    #[arg(long, short)]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    check_output(&args.output, &["csv"])?;
    let solution = output::read_solution(&args.run)?;
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
