//! `zonal reproduce`: recomputes the claims of the 1996 paper.

use super::demo::DemoSize;
use crate::commands::context::Context;
use std::path::PathBuf;
use zonal_report::Failure;
use zonal_validation::reproduce::{self, ReproductionOptions};

/// Recompute the figures, tables and claims of the 1996 paper.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Folder of plots, tables and the page README.md; created if missing.
    #[arg(long, short, default_value = "docs/reproduction", value_name = "DIR")]
    pub output: PathBuf,
    /// Resolution: small takes seconds, full takes minutes.
    #[arg(long, value_enum, default_value_t = DemoSize::Full)]
    pub size: DemoSize,
}

/// Runs the command.
///
/// # Errors
/// If the folder cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let options = ReproductionOptions {
        output: args.output.clone(),
        size: args.size.into(),
        json: context.json,
        quiet: context.quiet,
    };
    reproduce::run(&options)
}
