//! `zonal render`: a picture of light, a picture in false colours, or the frames of a camera animation, from a solution.

pub mod args;
mod report;
mod view_args;

pub use args::Args;

use super::context::Context;
use zonal_app::pictures::{Drawing, draw};
use zonal_app::shown_solution::read_picture_solution;
use zonal_app::solving::if_all_succeeded;
use zonal_app::timeline::READING;
use zonal_report::Failure;
use zonal_scene::Solution;
use zonal_solve::distribution::{Communicator, SingleProcess};

/// Runs the command.
///
/// # Errors
/// For options that are not valid or do not apply, solutions that cannot be read, and outputs that cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    draw_and_report(args, context, &SingleProcess)
}

/// Draws the frames of an animation on several processes.
///
/// # Errors
/// As [`run`], and without an animation: one picture is not shared.
pub fn run_on_ranks(args: &Args, context: Context, communicator: &dyn Communicator) -> Result<(), Failure> {
    if args.show.is_some() || args.animate.is_none() && args.turntable.is_none() {
        return Err(Failure::new(
            "processes share the frames of an animation (--animate, --turntable); draw one picture by `zonal render`",
        ));
    }
    draw_and_report(args, context, communicator)
}

fn draw_and_report(args: &Args, context: Context, communicator: &dyn Communicator) -> Result<(), Failure> {
    let read = || {
        let options = args.options()?;
        options.check()?;
        Ok::<_, Failure>((options, read_solution(args)?))
    };
    let (options, solution) = if_all_succeeded(context.in_stage(READING, read), communicator)?;
    let drawing = draw(&options, &solution, &context.progress(), communicator)?;
    if communicator.rank() > 0 {
        return Ok(());
    }
    if context.json {
        context.say_json(report::json_of(&drawing, args))?;
    } else {
        report::print(&drawing, args)?;
    }
    match &drawing {
        Drawing::Light(summary) => context.check_warnings(&summary.warnings),
        _ => Ok(()),
    }
}

fn read_solution(args: &Args) -> Result<Solution, Failure> {
    if args.show.is_some() {
        return Ok(zonal_io::output::read_solution(&args.run)?);
    }
    read_picture_solution(&args.run)
}
