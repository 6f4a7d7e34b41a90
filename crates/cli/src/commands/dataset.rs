//! `zonal dataset`: many solves of one scene with sampled numbers, for surrogate models.

use super::context::{Context, memory_limit};
use serde_json::json;
use std::path::PathBuf;
use zonal_app::dataset::{
    DatasetInputs, DatasetObserver, DatasetOptions, DatasetSummary, VariedNumber, write_dataset,
};
use zonal_report::{Failure, check_output, note, say};
use zonal_scene::Engine;

/// Solve a scene many times with sampled numbers, and write inputs and results as arrays (.npz).
///
/// KEY names a number in the template by its path: medium.heat_source, surface.NAME.temperature, surface.0.emissivity, medium.max.2, surface.*.emissivity
/// (all of them get the same value). Arrays have one row for each sample. A run that was interrupted continues when the same command is given again.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Scene file with a number for every varied key (.toml).
    pub template: PathBuf,
    /// Number to vary: KEY=LOW:HIGH (uniform), KEY=log:LOW:HIGH, KEY=normal:MEAN:DEVIATION or KEY=A,B,C (one of them). May be repeated.
    #[arg(long, value_name = "KEY=RANGE", required_unless_present = "inputs", conflicts_with = "inputs")]
    pub vary: Vec<String>,
    /// Table of inputs instead of samples (.csv): a column for each KEY, a row for each sample.
    #[arg(long, value_name = "FILE")]
    pub inputs: Option<PathBuf>,
    /// Number of samples [default: 100, or all rows of --inputs].
    #[arg(long, short, value_name = "N")]
    pub n: Option<usize>,
    /// Seed of the samples.
    #[arg(long, default_value_t = 1, value_name = "SEED")]
    pub seed: u64,
    /// Data set to write (.npz).
    #[arg(long, short, value_name = "SET.npz")]
    pub output: PathBuf,
    /// Memory limit of all solves that run at a time, GB.
    #[arg(long, default_value_t = 12.0, value_name = "GB")]
    pub max_memory: f64,
    /// Representation of the exchange between zones [default: that of the template, else spectral for boxes, else auto].
    #[arg(long, value_enum)]
    pub engine: Option<Engine>,
    /// Estimate the discretization error of every sample by a second solve [default: that of the template, else false].
    #[arg(long)]
    pub discretization_error: bool,
}

/// Runs the command.
///
/// # Errors
/// As [`write_dataset`]; and as a verdict for refused samples.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    check_output(&args.output, &["npz"])?;
    let observer = DatasetObserver { progress: &context.progress(), note: &note };
    report(args, &write_dataset(&options(args)?, &observer)?, context)
}

fn options(args: &Args) -> Result<DatasetOptions, Failure> {
    let varied = |text: &String| match text.split_once('=') {
        Some((key, range)) => VariedNumber::new(key, range),
        None => Err(Failure::new(format!("--vary {text}: write KEY=LOW:HIGH"))),
    };
    let inputs = match &args.inputs {
        Some(path) => DatasetInputs::Table(path.clone()),
        None => DatasetInputs::Sampled(args.vary.iter().map(varied).collect::<Result<_, _>>()?),
    };
    Ok(DatasetOptions {
        template: args.template.clone(),
        inputs,
        count: args.n,
        seed: args.seed,
        output: args.output.clone(),
        memory_limit: memory_limit(args.max_memory)?,
        engine: args.engine,
        discretization_error: args.discretization_error,
    })
}

/// Prints the summary.
fn report(args: &Args, summary: &DatasetSummary, context: Context) -> Result<(), Failure> {
    let DatasetSummary { samples, converged, not_converged, refused, energy_residual: residual } = *summary;
    let path = args.output.display().to_string();
    if context.json {
        context
            .say_json(json!({ "samples": samples, "converged": converged, "not_converged": not_converged,
            "refused": refused, "largest_energy_residual": residual, "written": path }))?;
    } else {
        say(&format!(
            "{samples} samples: {converged} converged, {not_converged} not converged, {refused} refused\nlargest energy residual {residual:.1e} of the power exchanged\nwritten: {path}"
        ))?;
    }
    if refused > 0 || (context.strict && not_converged > 0) {
        return Err(Failure::verdict(format!(
            "{refused} samples were refused and {not_converged} did not converge; see the array 'status' of {path}"
        )));
    }
    Ok(())
}
