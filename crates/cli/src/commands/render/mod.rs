//! `zonal render`: a picture of light, a picture in false colours, or the frames of a camera animation, from a solution.

pub mod animation;
pub mod args;
pub mod camera_choice;
pub mod false_colours;
pub mod picture;
pub mod style;

pub use args::Args;

use super::context::{Context, check_picture};
use animation::KeySource;
use std::path::PathBuf;
use zonal_report::Failure;
use zonal_scene::{Progress, Solution};
use zonal_solve::distribution::{Communicator, SingleProcess};

/// Draws a solution in memory as [`run`] draws that of a file; returns the path of the picture or of the folder of frames.
///
/// # Errors
/// As [`run`].
pub fn write(args: &Args, solution: &Solution, progress: &dyn Progress) -> Result<PathBuf, Failure> {
    match (args.show, KeySource::of(args)) {
        (Some(quantity), _) => {
            let settings = false_colours::FieldPictureSettings::from_args(args, quantity)?;
            false_colours::write(args, &settings, solution, progress)?;
        }
        (None, Some(keys)) => {
            let settings = animation::FrameArguments::from_args(args)?;
            check_picture(&args.run, solution)?;
            animation::write((args, keys), settings, solution, progress, &SingleProcess)?;
        }
        (None, None) => {
            let settings = picture::PictureArguments::from_args(args)?;
            check_picture(&args.run, solution)?;
            picture::write(args, &settings, solution, progress)?;
        }
    }
    Ok(args.output.clone())
}

/// Draws the frames of an animation on several processes.
///
/// # Errors
/// As [`run`], and without an animation: one picture is not shared.
pub fn run_on_ranks(args: &Args, context: Context, communicator: &dyn Communicator) -> Result<(), Failure> {
    match (args.show, KeySource::of(args)) {
        (None, Some(keys)) => animation::run_on_ranks(args, keys, context, communicator),
        _ => Err(Failure::new(
            "processes share the frames of an animation (--animate, --turntable); draw one picture by `zonal render`",
        )),
    }
}

/// Runs the command.
///
/// # Errors
/// For options that are not valid or do not apply, solutions that cannot be read, and outputs that cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    match (args.show, KeySource::of(args)) {
        (Some(quantity), _) => false_colours::run(args, quantity, context),
        (None, Some(keys)) => animation::run(args, keys, context),
        (None, None) => picture::run(args, context),
    }
}
