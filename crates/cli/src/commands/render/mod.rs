//! `zonal render`: a picture of light, a picture in false colours, or the frames of a camera animation, from a solution.

pub mod animation;
pub mod args;
pub mod false_colours;
pub mod picture;
pub mod style;

pub use args::Args;

use super::context::Context;
use zonal_report::Failure;

/// Runs the command.
///
/// # Errors
/// For options that are not valid or do not apply, solutions that cannot be read, and outputs that cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    match (args.show, &args.animate) {
        (Some(quantity), _) => false_colours::run(args, quantity, context),
        (None, Some(path)) => animation::run(args, path, context),
        (None, None) => picture::run(args, context),
    }
}
