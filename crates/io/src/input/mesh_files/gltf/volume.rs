//! The materials of a glTF file that have KHR_materials_volume.

use super::container::{MAX_GLTF_FILE_BYTES, split_chunks};
use super::document::parse_document;
use super::materials::absorption_coefficient;
use super::nodes::{NodeInstance, node_instances};
use crate::files;
use crate::input::reading::error::{FileFault, InputError};
use std::path::Path;
use zonal_scene::Bands;

/// A material with KHR_materials_volume, as its file gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeMaterial {
    /// Name; empty if the file gives none.
    pub name: String,
    /// Thickness factor, in the unit of the node that shows it; zero for a thin wall.
    pub thickness: f64,
    /// Attenuation distance, in the file's unit of length; infinite if not given.
    pub attenuation_distance: f64,
    /// Transmittance of that distance.
    pub attenuation_colour: Bands,
    /// Absorption κ_a = −ln(colour)/distance, in 1/(the file's unit).
    pub absorption: Bands,
    /// The factors by which the nodes that show this material scale lengths, ascending, each once.
    pub node_scales: Vec<f64>,
}

/// The volume materials of a GLB or glTF file.
///
/// # Errors
///
/// The file cannot be read or is not valid glTF.
pub fn volume_materials(path: &Path) -> Result<Vec<VolumeMaterial>, InputError> {
    let file = path.display().to_string();
    read(path, &file).map_err(|f| InputError::new(&file, None, "", f.to_string()))
}

/// As [`volume_materials`], of a GLB or glTF file in memory that refers to no other file.
///
/// # Errors
///
/// The bytes are not valid glTF.
pub fn volume_materials_from_bytes(bytes: &[u8]) -> Result<Vec<VolumeMaterial>, InputError> {
    let file = "memory";
    parse(bytes, file).map_err(|f| InputError::new(file, None, "", f.to_string()))
}

fn read(path: &Path, file: &str) -> Result<Vec<VolumeMaterial>, FileFault> {
    let bytes = files::read(path, MAX_GLTF_FILE_BYTES).map_err(|e| FileFault::new(file, "", e))?;
    parse(&bytes, file)
}

fn parse(bytes: &[u8], file: &str) -> Result<Vec<VolumeMaterial>, FileFault> {
    let (json, _) = split_chunks(file, bytes)?;
    let (document, _) = parse_document(file, json)?;
    let instances = node_instances(file, &document)?;
    let meshes = &document.as_json().meshes;
    let mut out = Vec::new();
    for (i, m) in document.materials().enumerate() {
        let Some(v) = m.volume() else { continue };
        let absorption = absorption_coefficient(&v).ok_or_else(|| {
            let message = "the attenuation is negative or not a number; export the file again";
            FileFault::new(file, format!("material {i}"), message)
        })?;
        let shows = |mesh: usize| {
            meshes.get(mesh).is_some_and(|mesh| {
                let mut of = mesh.primitives.iter().filter_map(|p| p.material);
                of.any(|m| m.value() == i)
            })
        };
        let shown = instances.iter().filter(|n| n.mesh.is_some_and(shows));
        let mut node_scales: Vec<f64> = shown.map(NodeInstance::scale).collect();
        node_scales.sort_by(f64::total_cmp);
        node_scales.dedup();
        out.push(VolumeMaterial {
            name: m.name().unwrap_or("").to_string(),
            thickness: f64::from(v.thickness_factor()),
            attenuation_distance: f64::from(v.attenuation_distance()),
            attenuation_colour: Bands::from_rgb(v.attenuation_color().map(f64::from)),
            absorption,
            node_scales,
        });
    }
    Ok(out)
}
