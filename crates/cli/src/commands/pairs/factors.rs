//! `zonal factors`: exchange factors of axis-aligned pairs with proved error bounds, from a table to a table.

use crate::commands::context::Context;
use std::path::PathBuf;
use zonal_app::pairs::check_tolerance;
use zonal_app::pairs::pair_table::{PairFactorTable, factors_of_file};
use zonal_io::output;
use zonal_report::{Failure, check_output, note, say};

/// Compute exchange factors of axis-aligned pairs with proved error bounds.
///
/// Adds the columns value, error_bound, grade and method to a table of pairs. The value is (1/pi) times the integral of exp(-kappa r) cosines / r^2, in m2
/// (ss), m3 (sv) or m4 (vv).
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Table of pairs (.csv) with the columns kind (vv, sv or ss), a_x0 … a_z1, a_normal, b_x0 … b_z1, b_normal (m; +x, -x, …), kappa (1/m).
    pub pairs: PathBuf,
    /// Relative tolerance of each value, 0 < T < 1.
    #[arg(long, default_value_t = 1e-8, value_name = "T")]
    pub tolerance: f64,
    /// Table to write (.csv).
    #[arg(long, short, value_name = "FACTORS.csv")]
    pub output: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// For tables that are not valid, lengths too far apart for double precision, and outputs that cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    check_tolerance(args.tolerance)?;
    check_output(&args.output, &["csv"])?;
    if let (Ok(a), Ok(b)) = (args.pairs.canonicalize(), args.output.canonicalize())
        && a == b
    {
        return Err(Failure::in_file(&args.output, "is the table of pairs; write to another file"));
    }
    let PairFactorTable { csv, pairs, missed } =
        factors_of_file(&args.pairs, args.tolerance, &context.progress())?;
    output::write_bytes(&args.output, &csv)?;
    if missed > 0 {
        note(&format!(
            "{missed} pair(s) do not reach the tolerance {:e} in double precision; see their error_bound",
            args.tolerance
        ));
    }
    if context.json {
        context
            .say_json(serde_json::json!({ "pairs": pairs, "written": args.output.display().to_string() }))?;
    } else {
        say(&format!("{pairs} pairs written: {}", args.output.display()))?;
    }
    Ok(())
}
