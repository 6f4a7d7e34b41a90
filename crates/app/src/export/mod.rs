//! A solution for other programs, in the format of the extension of its file.
//!
//! | module | contents |
//! |---|---|
//! | `options` | what is written, and which settings apply |
//! | `gltf`, `lightmap` | a glTF model with vertex colours or with a lightmap |
//! | `irradiance_volume` | incident radiance on a grid |

mod gltf;
mod irradiance_volume;
mod lightmap;
mod options;

pub use options::{
    ATLAS_RANGE, ColourQuantity, ExportOptions, GRID_RANGE, GlbOptions, LightmapSettings, VERTEX_RANGE,
    VOLUME_RAY_RANGE, VolumeSettings,
};

use crate::pages::viewer::package::{PackageDetail, package};
use crate::pages::viewer::page;
use crate::shown_solution::check_uniform_light;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};
use zonal_io::output::{self, CornerArray};
use zonal_render::bake::corner_light::{CornerLight, light_at_corners};
use zonal_render::bake::{BakeOptions, bake};
use zonal_report::{Failure, check_output};
use zonal_scene::{Photometry, Progress, Solution, SurfaceIlluminance};

/// The written files, their sizes by name (bytes, vertices, triangles), and the illuminances of the surfaces if they are wanted.
pub struct ExportedFiles {
    /// The file of the options first.
    pub paths: Vec<PathBuf>,
    /// Sizes by name.
    pub sizes: Map<String, Value>,
    /// Illuminances of the surfaces, lx.
    pub illuminances: Vec<SurfaceIlluminance>,
}

/// Writes a solution. An output that shows three bands of many shows the first three of the solution.
///
/// # Errors
/// For settings that do not apply, solutions that lack the exported part, and outputs that cannot be written.
pub fn write(
    options: &ExportOptions,
    solution: &Solution,
    progress: &dyn Progress,
) -> Result<ExportedFiles, Failure> {
    options.check()?;
    let extension = options.extension();
    if options.shows_colours() {
        check_uniform_light(&options.source, solution)?;
    }
    if options.faces {
        return export_faces(options, solution, &extension);
    }
    let mut exported =
        ExportedFiles { paths: vec![options.output.clone()], sizes: Map::new(), illuminances: Vec::new() };
    match extension.as_str() {
        "csv" => match options.photometric {
            Some(efficacy) => export_illuminances(options, solution, efficacy, &mut exported)?,
            None => output::write_zones_csv(&options.output, solution)?,
        },
        "vtu" if options.points => write_corners(options, solution, progress)?,
        "vtu" => output::write_vtu(&options.output, solution)?,
        "vti" => output::write_vti(&options.output, solution)?,
        "html" => write_page(options, solution, progress, &mut exported)?,
        _ => match (&options.irradiance_volume, &options.lightmap) {
            (Some(settings), _) => {
                let (beside, sizes) = irradiance_volume::write(options, settings, solution, progress)?;
                exported.paths.extend(beside);
                exported.sizes.extend(sizes);
            }
            (None, Some(settings)) => {
                let written = lightmap::write(options, settings, solution, progress)?;
                exported.sizes.extend(written.sizes);
                exported.paths.push(written.picture);
            }
            (None, None) => write_glb(options, solution, progress, &mut exported)?,
        },
    }
    Ok(exported)
}

/// Writes the illuminances of the zones, and collects those of the surfaces.
fn export_illuminances(
    options: &ExportOptions,
    s: &Solution,
    efficacy: f64,
    exported: &mut ExportedFiles,
) -> Result<(), Failure> {
    let photometry = Photometry::new(s, efficacy)
        .map_err(|e| Failure::in_file(&options.source, e.message().to_string()))?;
    output::write_photometric_csv(&options.output, s, &photometry)?;
    exported.illuminances = photometry.surfaces();
    Ok(())
}

/// Writes patches and panes with their values and those at their corners.
fn write_corners(options: &ExportOptions, s: &Solution, progress: &dyn Progress) -> Result<(), Failure> {
    let (radiosity, irradiance) = s
        .blocks()
        .map(|block| light_at_corners(block, progress))
        .map(|CornerLight { radiosity, irradiance }| (radiosity, irradiance))
        .unzip();
    let arrays = [
        CornerArray { name: "radiosity [W/m2]", blocks: radiosity },
        CornerArray { name: "total irradiance [W/m2]", blocks: irradiance },
    ];
    Ok(output::write_vtu_with_points(&options.output, s, &arrays)?)
}

/// Writes the results by face.
fn export_faces(options: &ExportOptions, s: &Solution, extension: &str) -> Result<ExportedFiles, Failure> {
    let faces = s.scene.faces().len();
    if faces == 0 {
        let message =
            "this solution has no faces: its scene has no mesh file; export zones (without --faces)";
        return Err(Failure::in_file(&options.source, message));
    }
    match extension {
        "csv" => output::write_faces_csv(&options.output, s)?,
        "npy" => output::write_faces_npy(&options.output, s)?,
        _ => output::write_faces_vtu(&options.output, s)?,
    }
    let sizes = Map::from_iter([("faces".to_string(), Value::from(faces))]);
    Ok(ExportedFiles { paths: vec![options.output.clone()], sizes, illuminances: Vec::new() })
}

/// Writes the page of the viewer with its data.
fn write_page(
    options: &ExportOptions,
    s: &Solution,
    progress: &dyn Progress,
    exported: &mut ExportedFiles,
) -> Result<(), Failure> {
    let text = page::single_file(&package(s, &PackageDetail::default(), progress)?);
    exported.sizes.insert("bytes".into(), text.len().into());
    Ok(output::write_bytes(&options.output, text.as_bytes())?)
}

/// Bakes and writes the .glb, and the medium beside it.
fn write_glb(
    options: &ExportOptions,
    s: &Solution,
    progress: &dyn Progress,
    exported: &mut ExportedFiles,
) -> Result<(), Failure> {
    let medium_path = medium_path(&options.output);
    if s.scene.voxel_grid().is_some() {
        check_output(&medium_path, &["npz"])?;
    }
    let defaults = BakeOptions::default();
    let settings = BakeOptions {
        min_edge: options.glb.finest,
        max_vertices: options.glb.vertices.unwrap_or(defaults.max_vertices),
        ..defaults
    };
    let baked = bake(s, &settings, progress);
    let model = gltf::model(s, &baked, &options.glb);
    let (surfaces, panes) = (&baked.surfaces, &baked.panes);
    exported.sizes.insert("vertices".into(), (surfaces.positions.len() + panes.positions.len()).into());
    exported.sizes.insert("triangles".into(), (surfaces.triangles.len() + panes.triangles.len()).into());
    output::write_glb(&options.output, &model)?;
    if let Some(medium) = &baked.medium {
        gltf::write_medium(&medium_path, &baked.groups, medium)?;
        exported.paths.push(medium_path);
    }
    Ok(())
}

/// NAME.glb ↦ NAME.medium.npz.
fn medium_path(path: &Path) -> PathBuf {
    path.with_extension("medium.npz")
}
