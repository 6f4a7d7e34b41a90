//! `zonal export`: writes a solution for other programs, in the format of the extension.

pub mod args;
mod gltf;
mod irradiance_volume;
mod lightmap;

pub use args::Args;

use super::context::{Context, check_uniform_light, read_uniform_light_solution, shown_bands};
use crate::viewer::package::{PackageDetail, package};
use crate::viewer::page;
use serde_json::{Map, Value, json};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use zonal_io::output::{self, CornerArray};
use zonal_render::bake::corner_light::{CornerLight, light_at_corners};
use zonal_render::bake::{BakeOptions, bake};
use zonal_report::{Failure, check_output, say};
use zonal_scene::{Photometry, Progress, Solution, SurfaceIlluminance, printable};

/// Runs the command.
///
/// # Errors
/// For settings that do not apply, solutions that cannot be read or lack the exported part, and outputs that cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    check_args(args)?;
    let shows_colours = shows_colours(args);
    let solution = if shows_colours {
        read_uniform_light_solution(&args.run, args.first_band.unwrap_or(0) as usize)?
    } else {
        output::read_solution(&args.run)?
    };
    let exported = export(args, &solution, &context.progress())?;
    if let Some(shown) = shown_bands(&solution).filter(|_| shows_colours && !context.json) {
        say(&shown)?;
    }
    report(&solution, exported, context)
}

/// Refuses outputs that cannot be written, and settings that do not apply.
fn check_args(args: &Args) -> Result<(), Failure> {
    let formats: &[&str] = match (args.faces, args.irradiance_volume.irradiance_volume) {
        (true, _) => &["csv", "npy", "vtu"],
        (_, true) => &["npz", "json"],
        _ => &["csv", "html", "glb", "vtu", "vti"],
    };
    check_output(&args.output, formats)?;
    let same = |a: &Path, b: &Path| a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b));
    if same(&args.run, &args.output) {
        return Err(Failure::new("--output: this would replace the solution; give another name"));
    }
    let extension = extension(args);
    if args.first_band.is_some() && !shows_colours(args) {
        return Err(Failure::new(
            "--first-band: this format has all bands; remove the option, or write .html or .glb",
        ));
    }
    if args.points && extension != "vtu" {
        return Err(Failure::new("--points: values at points are written as .vtu; give this extension"));
    }
    if args.photometric.is_some() && extension != "csv" {
        return Err(Failure::new("--photometric: illuminances are written as .csv; give this extension"));
    }
    args.lightmap.check(&extension, &args.glb)?;
    if args.irradiance_volume.irradiance_volume {
        return args.irradiance_volume.check(&args.glb);
    }
    args.glb.check(&extension)
}

/// True for outputs that show three bands as red, green and blue.
fn shows_colours(args: &Args) -> bool {
    matches!(extension(args).as_str(), "html" | "glb") || args.irradiance_volume.irradiance_volume
}

/// The extension of the output, in lower case.
fn extension(args: &Args) -> String {
    args.output.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// Writes a solution in the format of the output's extension; returns the paths of all files.
///
/// # Errors
/// As [`run`].
pub fn write(args: &Args, solution: &Solution, progress: &dyn Progress) -> Result<Vec<PathBuf>, Failure> {
    check_args(args)?;
    Ok(export(args, solution, progress)?.paths)
}

fn export(args: &Args, solution: &Solution, progress: &dyn Progress) -> Result<ExportedFiles, Failure> {
    let extension = extension(args);
    if shows_colours(args) {
        check_uniform_light(&args.run, solution)?;
    }
    if args.faces {
        return export_faces(args, solution, &extension);
    }
    let mut exported =
        ExportedFiles { paths: vec![args.output.clone()], sizes: Map::new(), illuminances: Vec::new() };
    match extension.as_str() {
        "csv" => match args.photometric {
            Some(efficacy) => export_illuminances(args, solution, efficacy, &mut exported)?,
            None => output::write_zones_csv(&args.output, solution)?,
        },
        _ if args.irradiance_volume.irradiance_volume => {
            let (beside, sizes) = irradiance_volume::write(args, solution, progress)?;
            exported.paths.extend(beside);
            exported.sizes.extend(sizes);
        }
        "vtu" if args.points => write_corners(args, solution, progress)?,
        "vtu" => output::write_vtu(&args.output, solution)?,
        "vti" => output::write_vti(&args.output, solution)?,
        "html" => write_page(args, solution, progress, &mut exported)?,
        _ if args.lightmap.lightmap => {
            let written = lightmap::write(args, solution, progress)?;
            exported.sizes.extend(written.sizes);
            exported.paths.push(written.picture);
        }
        _ => write_glb(args, solution, progress, &mut exported)?,
    }
    Ok(exported)
}

/// Writes the illuminances of the zones, and collects those of the surfaces.
fn export_illuminances(
    args: &Args,
    s: &Solution,
    efficacy: f64,
    exported: &mut ExportedFiles,
) -> Result<(), Failure> {
    let photometry =
        Photometry::new(s, efficacy).map_err(|e| Failure::in_file(&args.run, e.message().to_string()))?;
    output::write_photometric_csv(&args.output, s, &photometry)?;
    exported.illuminances = photometry.surfaces();
    Ok(())
}

/// Writes patches and panes with their values and those at their corners.
fn write_corners(args: &Args, s: &Solution, progress: &dyn Progress) -> Result<(), Failure> {
    let (radiosity, irradiance) = s
        .blocks()
        .map(|block| light_at_corners(block, progress))
        .map(|CornerLight { radiosity, irradiance }| (radiosity, irradiance))
        .unzip();
    let arrays = [
        CornerArray { name: "radiosity [W/m2]", blocks: radiosity },
        CornerArray { name: "total irradiance [W/m2]", blocks: irradiance },
    ];
    Ok(output::write_vtu_with_points(&args.output, s, &arrays)?)
}

/// Writes the results by face.
fn export_faces(args: &Args, s: &Solution, extension: &str) -> Result<ExportedFiles, Failure> {
    let faces = s.scene.faces().len();
    if faces == 0 {
        let message = "this solution has no faces: its scene has no mesh file, or an older version wrote it; export zones (without --faces), or solve the scene again";
        return Err(Failure::in_file(&args.run, message));
    }
    match extension {
        "csv" => output::write_faces_csv(&args.output, s)?,
        "npy" => output::write_faces_npy(&args.output, s)?,
        _ => output::write_faces_vtu(&args.output, s)?,
    }
    let sizes = Map::from_iter([("faces".to_string(), Value::from(faces))]);
    Ok(ExportedFiles { paths: vec![args.output.clone()], sizes, illuminances: Vec::new() })
}

/// The written files, their sizes by name (bytes, vertices, triangles), and the illuminances of the surfaces if they are wanted.
struct ExportedFiles {
    paths: Vec<PathBuf>,
    sizes: Map<String, Value>,
    illuminances: Vec<SurfaceIlluminance>,
}

/// Writes the page of the viewer with its data.
fn write_page(
    args: &Args,
    s: &Solution,
    progress: &dyn Progress,
    exported: &mut ExportedFiles,
) -> Result<(), Failure> {
    let text = page::single_file(&package(s, &PackageDetail::default(), progress)?);
    exported.sizes.insert("bytes".into(), text.len().into());
    Ok(output::write_bytes(&args.output, text.as_bytes())?)
}

/// Bakes and writes the .glb, and the medium beside it.
fn write_glb(
    args: &Args,
    s: &Solution,
    progress: &dyn Progress,
    exported: &mut ExportedFiles,
) -> Result<(), Failure> {
    let medium_path = medium_path(&args.output);
    if s.scene.voxel_grid().is_some() {
        check_output(&medium_path, &["npz"])?;
    }
    let defaults = BakeOptions::default();
    let options = BakeOptions {
        min_edge: args.glb.finest,
        max_vertices: args.glb.vertices.map_or(defaults.max_vertices, |v| v as usize),
        ..defaults
    };
    let baked = bake(s, &options, progress);
    let model = gltf::model(s, &baked, &args.glb);
    let (surfaces, panes) = (&baked.surfaces, &baked.panes);
    exported.sizes.insert("vertices".into(), (surfaces.positions.len() + panes.positions.len()).into());
    exported.sizes.insert("triangles".into(), (surfaces.triangles.len() + panes.triangles.len()).into());
    output::write_glb(&args.output, &model)?;
    if let Some(medium) = &baked.medium {
        gltf::write_medium(&medium_path, &baked.groups, medium)?;
        exported.paths.push(medium_path);
    }
    Ok(())
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

/// NAME.glb ↦ NAME.medium.npz.
fn medium_path(path: &Path) -> PathBuf {
    path.with_extension("medium.npz")
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
        return say(&Value::from(sizes).to_string());
    }
    if !illuminances.is_empty() {
        say(&illuminance_table(&illuminances))?;
    }
    let text = sizes.iter().map(|(k, v)| format!(", {k} {v}")).collect::<String>();
    say(&format!("{} zones{text} written: {}", s.zones.len(), names.join(", ")))
}
