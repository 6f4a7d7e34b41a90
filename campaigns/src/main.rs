//! Campaigns: slow checks and measurements over many scenes, each a subcommand over one harness.
//!
//! ```text
//! cargo run --release -p zonal-campaigns -- coverage --random 1000 --seed N
//! ```
//!
//! The exit code is 1 where a requirement fails, and 2 for bad input. `CONTRIBUTING.md` lists the campaigns of a release.

mod coverage;
mod error_against_cost;
mod harness;
mod intervals;
mod montecarlo;
mod path_tracer;
mod pictures;
mod scaling;
mod scenes;
mod view_factors;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "campaigns")]
struct CommandLine {
    #[command(subcommand)]
    campaign: Campaign,
}

#[derive(Subcommand)]
enum Campaign {
    /// Stated against true errors of random scenes, solved by every engine.
    Coverage(coverage::CoverageOptions),
    /// Stated radii against true errors of the view factors of random meshes.
    ViewFactors(view_factors::FactorCampaign),
    /// Proved intervals of random pairs against an oracle, or by additivity.
    Intervals(intervals::IntervalCampaign),
    /// Solutions, cameras, and the path tracer itself, against paths of light.
    PathTracer(path_tracer::PathTracerOptions),
    /// Measured error against processor time of furnished and difficult scenes.
    #[command(subcommand)]
    ErrorAgainstCost(error_against_cost::BenchmarkStep),
    /// The cubes of the Monte Carlo tables.
    Montecarlo(montecarlo::TableCampaign),
    /// Mitsuba's Cornell boxes, drawn and compared.
    Cornell(pictures::CornellCampaign),
    /// A solution or picture against a reference picture with standard errors.
    Picture(pictures::ReferencePicture),
    /// Time and memory of one scene at several sizes.
    Scaling(scaling::ScalingCampaign),
}

fn main() -> ExitCode {
    let outcome = match CommandLine::parse().campaign {
        Campaign::Coverage(o) => o.run(),
        Campaign::ViewFactors(o) => o.report(),
        Campaign::Intervals(o) => o.run(),
        Campaign::PathTracer(o) => o.run(),
        Campaign::ErrorAgainstCost(o) => o.run(),
        Campaign::Montecarlo(o) => o.run(),
        Campaign::Cornell(o) => o.run(),
        Campaign::Picture(o) => o.run(),
        Campaign::Scaling(o) => o.run(),
    };
    match outcome {
        Ok(passed) => ExitCode::from(u8::from(!passed)),
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::from(2)
        }
    }
}
