//! `zonal relight`: lights turned up and down in a solution; other reflectances and another albedo from kept factors.

use super::solve::{Factors, beside, keys, signed};
use super::{Context, check_output, read_light};
use crate::failure::say;
use crate::{Failure, meter::Meter, table};
use std::path::PathBuf;
use zonal_io::output::{self, Folder, Held};
use zonal_scene::{Bands, Solution};
use zonal_solve::Job;
use zonal_solve::pipeline::DEFAULT_MEMORY;
use zonal_solve::relight::{relight, repainted};

/// Turn the lights of a solution up and down without solving; list them.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Solution (.npz).
    pub run: PathBuf,
    /// Light groups and how many times as strongly each shall shine, a number or r,g,b: `sun=0.2 lamp=3`. Without any, the groups are
    /// listed.
    #[arg(value_name = "NAME=FACTOR")]
    pub lights: Vec<String>,
    /// Solution to write (.npz).
    #[arg(long, short)]
    pub output: Option<PathBuf>,
    /// Another reflectance of a surface, a number or r,g,b: solves again with the factors that `solve --keep-factors` kept.
    #[arg(long, value_name = "SURFACE=VALUE")]
    pub reflectance: Vec<String>,
    /// Another albedo of the medium, a number or r,g,b: likewise.
    #[arg(long, value_name = "VALUE")]
    pub albedo: Option<String>,
}

/// A number or r,g,b, from 0 to `most`.
fn value(argument: &str, text: &str, most: f64) -> Result<Bands, Failure> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
    let bands = match numbers.as_deref() {
        Some([x]) => [*x; 3],
        Some([r, g, b]) => [*r, *g, *b],
        _ => return Err(Failure::new(format!("{argument}: '{text}' is no number and no r,g,b"))),
    };
    match bands.iter().find(|x| !(0.0..=most).contains(*x)) {
        Some(x) if most.is_finite() => {
            Err(Failure::new(format!("{argument}: {x} is out of range; give numbers from 0 to {most}")))
        }
        Some(x) => Err(Failure::new(format!("{argument}: {x} is out of range; give numbers from 0"))),
        None => Ok(bands),
    }
}

/// `NAME=VALUE` with numbers up to `most`; the name may hold the sign itself.
fn assignment(argument: &str, text: &str, most: f64) -> Result<(String, Bands), Failure> {
    let Some((name, number)) = text.rsplit_once('=') else {
        return Err(Failure::new(format!("{argument}: '{text}' has no value; write {text}=0.5")));
    };
    Ok((name.to_string(), value(&format!("{argument} '{name}'"), number, most)?))
}

/// Runs the command.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let all = |list: &[String], what: &str, most: f64| -> Result<Vec<(String, Bands)>, Failure> {
        list.iter().map(|t| assignment(what, t, most)).collect()
    };
    let lights = all(&args.lights, "light group", f64::MAX)?;
    let reflectances = all(&args.reflectance, "--reflectance", 1.0)?;
    let albedo = args.albedo.as_ref().map(|t| value("--albedo", t, 1.0)).transpose()?;
    let repaint = !reflectances.is_empty() || albedo.is_some();
    if lights.is_empty() && !repaint {
        if args.output.is_some() {
            return Err(Failure::new("--output: nothing changes; name a light group, as in sun=0.5"));
        }
        return list(&read_light(&args.run)?, context);
    }
    let Some(path) = &args.output else {
        return Err(Failure::new("--output: name the solution to write, as in -o relit.npz"));
    };
    check_output(path, &["npz"])?;
    let mut solution = read_light(&args.run)?;
    let at = |e: zonal_scene::SceneError| Failure::in_file(&args.run, e);
    if repaint {
        solution = resolved(args, solution, &reflectances, albedo, context)?;
    }
    if !lights.is_empty() {
        solution = relight(solution, &lights).map_err(at)?;
        solution.scene_hash = output::scene_hash(&solution.scene);
    }
    output::write_solution(path, &solution)?;
    if context.json {
        say(&format!("{:#}", output::report_json(&solution)))?;
    } else {
        say(table::report(&solution).trim_end())?;
        say(&format!("written: {}", path.display()))?;
    }
    context.judge_report(&solution.report)
}

/// Solves again with kept factors, from the light that the solution holds.
fn resolved(
    args: &Args,
    old: Solution,
    reflectances: &[(String, Bands)],
    albedo: Option<Bands>,
    context: Context,
) -> Result<Solution, Failure> {
    let settings = Factors::Exact.settings();
    let folder = Folder::new(&beside(&args.run, "factors"), keys(&old.scene, settings));
    let place = folder.path().display().to_string();
    match folder.held_factors() {
        Held::Same => {}
        Held::Nothing => {
            return Err(Failure::new(format!(
                "{place}: there are no factors; solve the scene with --keep-factors"
            )));
        }
        Held::Other => {
            return Err(Failure::new(format!(
                "{place}: these factors belong to other lights, another scene or another version; solve the scene again with --keep-factors"
            )));
        }
    }
    let scene = repainted(old.scene, reflectances, albedo).map_err(|e| Failure::in_file(&args.run, e))?;
    let meter = Meter::new(context.quiet);
    let job =
        Job { settings, vault: &ReadOnly(folder), initial: &old.groups, ..Job::new(DEFAULT_MEMORY, &meter) };
    signed(scene, &job)
}

/// Kept factors that nobody adds to.
struct ReadOnly(Folder);

impl zonal_scene::Vault for ReadOnly {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        self.0.load(stage)
    }
    fn save(&self, _: &str, _: &[u8]) {}
    fn keeps(&self) -> bool {
        false
    }
}

/// The groups: name, what each gives and what becomes of it.
fn list(s: &Solution, context: Context) -> Result<(), Failure> {
    if context.json {
        return say(&format!("{:#}", output::report_json(s)["groups"]));
    }
    if s.groups.is_empty() {
        return say("no light groups were kept");
    }
    say(table::groups(s).trim_end())
}
