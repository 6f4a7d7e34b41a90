//! `zonal relight`: scales the light groups of a solution; solves again with other reflectances or another albedo from kept factors.

use super::context::Context;
use crate::table;
use std::path::PathBuf;
use zonal_app::relight::{RelightSettings, SolutionChanges};
use zonal_app::shown_solution::read_light_solution;
use zonal_app::solving::path_beside;
use zonal_app::timeline::{READING, WRITING};
use zonal_io::output;
use zonal_report::{Failure, check_output, say};
use zonal_scene::{Bands, Solution};
use zonal_solve::settings::DEFAULT_MEMORY_LIMIT;

/// Scale the light groups of a solution without solving again, or list them.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Solution (.npz).
    pub run: PathBuf,
    /// Light groups with their factors from 0, a number or r,g,b: `sun=0.2 lamp=3`. Without any, the groups are listed.
    #[arg(value_name = "NAME=FACTOR")]
    pub lights: Vec<String>,
    /// Solution to write (.npz).
    #[arg(long, short, value_name = "RUN.npz")]
    pub output: Option<PathBuf>,
    /// Another reflectance of a surface, 0 to 1, a number or r,g,b. Solves again with the factors of `solve --keep-factors`.
    #[arg(long, value_name = "SURFACE=VALUE")]
    pub reflectance: Vec<String>,
    /// Another albedo of the medium, 0 to 1, a number or r,g,b. Solves again with the factors of `solve --keep-factors`.
    #[arg(long, value_name = "VALUE")]
    pub albedo: Option<String>,
}

/// The changes of the arguments.
fn changes(args: &Args) -> Result<SolutionChanges, Failure> {
    let assignments = |list: &[String], argument: &str, max: f64| -> Result<Vec<(String, Bands)>, Failure> {
        list.iter().map(|t| parse_assignment(argument, t, max)).collect()
    };
    Ok(SolutionChanges {
        lights: assignments(&args.lights, "light group", f64::MAX)?,
        reflectances: assignments(&args.reflectance, "--reflectance", 1.0)?,
        albedo: args.albedo.as_ref().map(|t| parse_bands("--albedo", t, 1.0)).transpose()?,
    })
}

/// A number or r,g,b, from 0 to `max`.
fn parse_bands(argument: &str, text: &str, max: f64) -> Result<Bands, Failure> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
    let bands = match numbers.as_deref() {
        Some([x]) => Bands::splat(*x),
        Some([r, g, b]) => Bands::from_rgb([*r, *g, *b]),
        _ => return Err(Failure::new(format!("{argument}: '{text}' is neither a number nor r,g,b"))),
    };
    match bands.iter().find(|x| !(0.0..=max).contains(*x)) {
        Some(x) if max < f64::MAX => {
            Err(Failure::new(format!("{argument}: {x} is out of range; give numbers from 0 to {max}")))
        }
        Some(x) => Err(Failure::new(format!("{argument}: {x} is out of range; give numbers from 0"))),
        None => Ok(bands),
    }
}

/// `NAME=VALUE` with numbers up to `max`; the name may contain an equals sign.
fn parse_assignment(argument: &str, text: &str, max: f64) -> Result<(String, Bands), Failure> {
    let Some((name, number)) = text.rsplit_once('=') else {
        return Err(Failure::new(format!("{argument}: '{text}' has no value; write {text}=0.5")));
    };
    Ok((name.to_string(), parse_bands(&format!("{argument} '{name}'"), number, max)?))
}

/// Runs the command.
///
/// # Errors
/// For unknown groups and surfaces, factors out of range, missing kept factors, and outputs that cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let changes = changes(args)?;
    if changes.is_empty() {
        if args.output.is_some() {
            return Err(Failure::new("--output: nothing changes; name a light group, as in sun=0.5"));
        }
        return list_groups(&read_light_solution(&args.run)?, context);
    }
    let Some(path) = &args.output else {
        return Err(Failure::new("--output: name the solution to write, as in -o relit.npz"));
    };
    check_output(path, &["npz"])?;
    let solution = context.in_stage(READING, || read_light_solution(&args.run))?;
    let settings = RelightSettings {
        kept_factors: &path_beside(&args.run, "factors"),
        remedy: "solve the scene with --keep-factors",
        memory_limit: DEFAULT_MEMORY_LIMIT,
        progress: &context.progress(),
    };
    let solution = changes.apply(solution, &settings).map_err(|e| e.in_scene(&args.run))?;
    context.in_stage(WRITING, || output::write_solution(path, &solution))?;
    if context.json {
        context.say_json(output::report_json(&solution))?;
    } else {
        say(table::report(&solution).trim_end())?;
        say(&format!("written: {}", path.display()))?;
    }
    context.check_report(&solution.report)
}

/// Prints the light groups with their power.
fn list_groups(s: &Solution, context: Context) -> Result<(), Failure> {
    if context.json {
        return context.say_json(output::report_json(s)["light_groups"].take());
    }
    if s.groups.is_empty() {
        return say("no light groups were kept");
    }
    say(table::light_groups(s).trim_end())
}
