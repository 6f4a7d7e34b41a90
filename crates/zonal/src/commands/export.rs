//! `zonal export`: a solution for other programs, by the ending of the file's name.

mod scene;

use super::{Context, check_output, read_light};
use crate::failure::say;
use crate::viewer::package::{Detail, package};
use crate::viewer::page;
use crate::{Failure, meter::Meter};
use clap::ValueEnum;
use std::path::{Path, PathBuf};
use zonal_io::output::{self, Curve};
use zonal_render::bake::{BakeOptions, bake};
use zonal_scene::Solution;

/// What the endings mean.
const ENDINGS: &str = "\
The ending of the name says what is written:
  .csv  one line a zone, for spreadsheets
  .html the page of `zonal view` with all its data: one file that opens without a server or a network
  .glb  the scene with its light baked into vertex colours, for Blender, web viewers and engines; the light of the
        medium goes beside it, as NAME.medium.npz
  .vtu  patches and panes with all fields, for ParaView
  .vti  the medium on its grid with all fields, for ParaView
docs/export.md says what each file holds and how to open it.";

/// Write a solution for other programs.
#[derive(clap::Args, Debug)]
#[command(after_long_help = ENDINGS)]
pub struct Args {
    /// Solution (.npz).
    pub run: PathBuf,
    /// File to write: .csv, .html, .glb, .vtu or .vti.
    #[arg(long, short)]
    pub output: PathBuf,
    /// How the .glb is baked.
    #[command(flatten)]
    pub bake: Bake,
}

/// Settings of the .glb.
#[derive(clap::Args, Debug, Default, PartialEq)]
#[command(next_help_heading = "Settings of the .glb")]
pub struct Bake {
    /// What the colours show: the light that leaves the surfaces (radiosity), or the light that falls on them, as on white
    /// plaster (irradiance).
    #[arg(long, value_name = "WHAT")]
    pub colours: Option<Colours>,
    /// How light becomes colour: filmic (highlights roll off, as in pictures; the default) or linear (clipped at white).
    #[arg(long, value_name = "CURVE")]
    pub curve: Option<CurveName>,
    /// Exposure in stops above the automatic one.
    #[arg(long, allow_hyphen_values = true)]
    pub stops: Option<f64>,
    /// Edges shorter than this are not halved at shadow edges, m (default: a thousandth of the scene's diagonal).
    #[arg(long, value_name = "METRES")]
    pub finest: Option<f64>,
    /// The most vertices (default: 2000000). Where they run out, the sharpest shadows have them.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    pub vertices: Option<u64>,
    /// Keep the irradiance of each light group in W/m² as vertex attributes _IRRADIANCE_0, _IRRADIANCE_1, …
    #[arg(long)]
    pub light_groups: bool,
}

/// What colours show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Colours {
    /// B, as seen.
    #[default]
    Radiosity,
    /// H, as on white plaster.
    Irradiance,
}

/// How light becomes colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum CurveName {
    /// As in pictures.
    #[default]
    Filmic,
    /// Clipped at white.
    Linear,
}

impl From<CurveName> for Curve {
    fn from(c: CurveName) -> Curve {
        match c {
            CurveName::Filmic => Curve::Filmic,
            CurveName::Linear => Curve::Linear,
        }
    }
}

/// Runs the command.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    check_output(&args.output, &["csv", "html", "glb", "vtu", "vti"])?;
    let ending =
        args.output.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    check(&args.bake, &ending)?;
    let solution = match ending.as_str() {
        "html" | "glb" => read_light(&args.run)?,
        _ => output::read_solution(&args.run)?,
    };
    let mut written = vec![args.output.clone()];
    let mut more = serde_json::Map::new();
    match ending.as_str() {
        "csv" => output::write_zones_csv(&args.output, &solution)?,
        "vtu" => output::write_vtu(&args.output, &solution)?,
        "vti" => output::write_vti(&args.output, &solution)?,
        "html" => write_page(args, &solution, context, &mut more)?,
        _ => written.extend(write_scene(args, &solution, context, &mut more)?),
    }
    let names: Vec<String> = written.iter().map(|p| p.display().to_string()).collect();
    if context.json {
        more.insert("zones".into(), solution.zones.len().into());
        more.insert("written".into(), names[0].clone().into());
        more.insert("beside".into(), names[1..].into());
        say(&serde_json::Value::from(more).to_string())?;
    } else {
        let what = more.iter().map(|(k, v)| format!(", {k} {v}")).collect::<String>();
        say(&format!("{} zones{what} written: {}", solution.zones.len(), names.join(", ")))?;
    }
    Ok(())
}

/// Refuses settings that are out of range, or that the file would not heed.
fn check(b: &Bake, ending: &str) -> Result<(), Failure> {
    if ending != "glb" && *b != Bake::default() {
        let list = "--colours, --curve, --stops, --finest, --vertices and --light-groups";
        return Err(Failure::new(format!("{list} are for .glb; leave them out for .{ending}")));
    }
    if b.stops.is_some_and(|s| !(s.is_finite() && s.abs() <= 30.0)) {
        return Err(Failure::new("--stops: give a number between -30 and 30"));
    }
    if b.finest.is_some_and(|f| !(f.is_finite() && f > 0.0)) {
        return Err(Failure::new("--finest: give a length above 0, in metres"));
    }
    Ok(())
}

/// Bakes and writes the viewer's page.
fn write_page(
    args: &Args,
    s: &Solution,
    context: Context,
    more: &mut serde_json::Map<String, serde_json::Value>,
) -> Result<(), Failure> {
    let text = page::single(&package(s, &Detail::default(), &Meter::new(context.quiet))?);
    more.insert("bytes".into(), text.len().into());
    Ok(output::write_bytes(&args.output, text.as_bytes())?)
}

/// Bakes and writes the .glb and what lies beside it; returns the names of the latter.
fn write_scene(
    args: &Args,
    s: &Solution,
    context: Context,
    more: &mut serde_json::Map<String, serde_json::Value>,
) -> Result<Vec<PathBuf>, Failure> {
    let beside = beside(&args.output);
    if s.scene.voxmap().is_some() {
        check_output(&beside, &["npz"])?;
    }
    let defaults = BakeOptions::default();
    let options = BakeOptions {
        finest: args.bake.finest,
        vertices: args.bake.vertices.map_or(defaults.vertices, |v| v as usize),
        ..defaults
    };
    let baked = bake(s, &options, &Meter::new(context.quiet));
    let model = scene::model(s, &baked, &args.bake);
    more.insert("vertices".into(), (baked.surfaces.positions.len() + baked.panes.positions.len()).into());
    more.insert("triangles".into(), (baked.surfaces.triangles.len() + baked.panes.triangles.len()).into());
    output::write_glb(&args.output, &model)?;
    let Some(medium) = &baked.medium else { return Ok(Vec::new()) };
    scene::write_medium(&beside, &baked.groups, medium)?;
    Ok(vec![beside])
}

/// NAME.glb ↦ NAME.medium.npz.
fn beside(path: &Path) -> PathBuf {
    path.with_extension("medium.npz")
}
