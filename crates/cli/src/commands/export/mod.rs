//! `zonal export`: writes a solution for other programs, in the format of the extension.

mod args;

pub use args::Args;

use super::context::Context;
use serde_json::{Value, json};
use std::fmt::Write as _;
use zonal_app::export::{ExportOptions, ExportedFiles, GlbOptions, LightmapSettings, VolumeSettings, write};
use zonal_app::shown_solution::{read_uniform_light_solution, shown_bands};
use zonal_app::timeline::READING;
use zonal_report::{Failure, say};
use zonal_scene::{Solution, SurfaceIlluminance, printable};

/// Runs the command.
///
/// # Errors
/// For settings that do not apply, solutions that cannot be read or lack the exported part, and outputs that cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let options = options(args)?;
    options.check()?;
    let shows_colours = options.shows_colours();
    let solution = context.in_stage(READING, || {
        if shows_colours {
            read_uniform_light_solution(&args.run, options.first_band.unwrap_or(0))
        } else {
            zonal_io::output::read_solution(&args.run).map_err(Failure::from)
        }
    })?;
    let exported = write(&options, &solution, &context.progress())?;
    if let Some(shown) = shown_bands(&solution).filter(|_| shows_colours && !context.json) {
        say(&shown)?;
    }
    report(&solution, exported, context)
}

fn options(args: &Args) -> Result<ExportOptions, Failure> {
    let size = |n: u64| n as usize;
    let dims = match args.irradiance_volume.grid[..] {
        [] => None,
        [x, y, z] => Some([x, y, z].map(size)),
        _ => return Err(Failure::new("--grid: give three numbers of points, as 32,32,16")),
    };
    let volume = VolumeSettings { dims, rays: args.irradiance_volume.rays.map(size) };
    let lightmap = LightmapSettings { texel: args.lightmap.texel, atlas: args.lightmap.atlas.map(size) };
    Ok(ExportOptions {
        source: args.run.clone(),
        output: args.output.clone(),
        faces: args.faces,
        points: args.points,
        photometric: args.photometric,
        first_band: args.first_band.map(|b| b as usize),
        glb: GlbOptions {
            colours: args.glb.colours,
            curve: args.glb.curve.map(Into::into),
            stops: args.glb.stops,
            finest: args.glb.finest,
            vertices: args.glb.vertices.map(size),
            light_groups: args.glb.light_groups,
        },
        lightmap: args.lightmap.lightmap.then_some(lightmap),
        irradiance_volume: args.irradiance_volume.irradiance_volume.then_some(volume),
    })
}

/// The illuminance of a surface as JSON.
fn illuminance_row(r: &SurfaceIlluminance) -> Value {
    json!({
        "name": r.name, "area_m2": r.area, "mean_lx": r.mean, "error_lx": r.error, "min_lx": r.range[0], "max_lx": r.range[1],
        "uniformity": r.uniformity(), "flux_lm": r.flux(),
    })
}

/// The illuminances of the surfaces as a table.
fn illuminance_table(list: &[SurfaceIlluminance]) -> String {
    let width = list.iter().map(|r| printable(&r.name).chars().count()).max().unwrap_or(0).max(7);
    let mut text = format!(
        "{:width$} {:>11} {:>12} {:>10} {:>12} {:>12} {:>10} {:>12}",
        "surface", "area, m2", "mean, lx", "error, lx", "least, lx", "most, lx", "uniformity", "flux, lm"
    );
    for r in list {
        let [least, most] = r.range;
        let _ = write!(
            text,
            "\n{:width$} {:>11.3} {:>12.2} {:>10.2} {least:>12.2} {most:>12.2} {:>10.3} {:>12.2}",
            printable(&r.name),
            r.area,
            r.mean,
            r.error,
            r.uniformity(),
            r.flux()
        );
    }
    text
}

fn report(s: &Solution, exported: ExportedFiles, context: Context) -> Result<(), Failure> {
    let ExportedFiles { paths, mut sizes, illuminances } = exported;
    let names: Vec<String> = paths.iter().map(|p| p.display().to_string()).collect();
    if context.json {
        sizes.insert("zones".into(), s.zones.len().into());
        sizes.insert("written".into(), names[0].clone().into());
        sizes.insert("beside".into(), names[1..].into());
        if !illuminances.is_empty() {
            sizes.insert("surfaces".into(), illuminances.iter().map(illuminance_row).collect());
        }
        return context.say_json(Value::from(sizes));
    }
    if !illuminances.is_empty() {
        say(&illuminance_table(&illuminances))?;
    }
    let text = sizes.iter().map(|(k, v)| format!(", {k} {v}")).collect::<String>();
    say(&format!("{} zones{text} written: {}", s.zones.len(), names.join(", ")))
}
