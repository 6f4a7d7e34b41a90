//! `zonal validate`: runs the cases with known answers.

use crate::commands::context::Context;
use std::path::PathBuf;
use zonal_report::Failure;
use zonal_validation::validate::{self, ValidationOptions};

/// Compare results with known answers.
///
/// Exit codes: 0 if every verdict passes; 1 if a verdict fails or all selected cases were skipped; 2 for options that are not valid, a reference folder
/// that does not exist, or a folder that cannot be written.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Cases to run, by name or pattern with * and ?, separated by commas [default: all].
    #[arg(long, value_name = "CASES", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Run only the quick cases, which take at most a few seconds each.
    #[arg(long)]
    pub quick: bool,
    /// List the cases without running them.
    #[arg(long)]
    pub list: bool,
    /// Folder of the page validation.md and its plots; created if missing [default: docs if all cases run, else no page].
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Folder of reference files that are not part of the program [default: ../shared]. Cases whose files are missing are skipped.
    #[arg(long, value_name = "DIR")]
    pub reference: Option<PathBuf>,
    /// Write every solved scene into this folder, for `zonal solve`.
    #[arg(long, value_name = "DIR")]
    pub scenes: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// See the exit codes of [`Args`].
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let options = ValidationOptions {
        only: args.only.clone(),
        quick: args.quick,
        list: args.list,
        output: args.output.clone(),
        reference: args.reference.clone(),
        scenes: args.scenes.clone(),
        json: context.json,
    };
    let context = Context { quiet: context.quiet || context.json, ..context };
    let progress = context.progress();
    validate::run(&options, &progress)
}
