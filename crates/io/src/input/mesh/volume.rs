//! The materials of a glTF file that have KHR_materials_volume, for those who want the numbers themselves.

use super::{glb, gltf, material};
use crate::input::error::{Fault, InputError};
use crate::input::files;
use std::path::Path;
use zonal_scene::Bands;

/// A material with KHR_materials_volume, as its file gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeMaterial {
    /// Name; empty where the file gives none.
    pub name: String,
    /// Thickness factor, in the unit of the node that shows it; zero for a thin wall.
    pub thickness: f64,
    /// Attenuation distance, in the file's unit of length; infinite where not given.
    pub attenuation_distance: f64,
    /// The share of light that is left after that distance.
    pub attenuation_colour: Bands,
    /// Absorption κ_a = −ln(colour)/distance, in 1/(the file's unit).
    pub absorption: Bands,
    /// The factors by which the nodes that show this material scale lengths, ascending, each once.
    pub node_scales: Vec<f64>,
}

/// The volume materials of a GLB or glTF file.
pub fn volume_materials(path: &Path) -> Result<Vec<VolumeMaterial>, InputError> {
    let file = path.display().to_string();
    read(path, &file).map_err(|f| InputError::new(&file, None, "", f.to_string()))
}

/// As [`volume_materials`], of a GLB or glTF file in memory that refers to no other file.
pub fn volume_materials_from_bytes(bytes: &[u8]) -> Result<Vec<VolumeMaterial>, InputError> {
    let file = "memory";
    parse(bytes, file).map_err(|f| InputError::new(file, None, "", f.to_string()))
}

fn read(path: &Path, file: &str) -> Result<Vec<VolumeMaterial>, Fault> {
    let bytes = files::read(path, glb::MAX_FILE).map_err(|what| Fault::new(file, "", what))?;
    parse(&bytes, file)
}

fn parse(bytes: &[u8], file: &str) -> Result<Vec<VolumeMaterial>, Fault> {
    let (json, _) = glb::split(file, bytes)?;
    let document = gltf::document(file, json)?;
    let instances = gltf::instances(file, &document)?;
    let meshes = &document.as_json().meshes;
    let mut out = Vec::new();
    for (i, m) in document.materials().enumerate() {
        let Some(v) = m.volume() else { continue };
        let absorption = material::absorption(&v).ok_or_else(|| {
            let what = "the attenuation is negative or not a number; export the file again";
            Fault::new(file, format!("material {i}"), what)
        })?;
        let shows = |mesh: usize| {
            meshes.get(mesh).is_some_and(|mesh| {
                let mut of = mesh.primitives.iter().filter_map(|p| p.material);
                of.any(|m| m.value() == i)
            })
        };
        let shown = instances.iter().filter(|n| shows(n.mesh()));
        let mut node_scales: Vec<f64> = shown.map(gltf::Instance::scale).collect();
        node_scales.sort_by(f64::total_cmp);
        node_scales.dedup();
        out.push(VolumeMaterial {
            name: m.name().unwrap_or("").to_string(),
            thickness: f64::from(v.thickness_factor()),
            attenuation_distance: f64::from(v.attenuation_distance()),
            attenuation_colour: v.attenuation_color().map(f64::from),
            absorption,
            node_scales,
        });
    }
    Ok(out)
}
