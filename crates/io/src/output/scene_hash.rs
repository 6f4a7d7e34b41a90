//! The scene hash: BLAKE3 over the scene as a solution file holds it, as 64 hexadecimal digits.
//!
//! The header of the file and its arrays are hashed in the order of the file: whatever is written into a solution is in its hash, and with it the contents of
//! every file that the scene reads. Names, notes and cameras are excluded, since they do not change a solution. The hash identifies the scene of a solution
//! or checkpoint; it is compared with hashes of the same program only.

use super::npz::writer::ArrayWriter;
use super::solution::header::encode_unnamed_scene;
use super::solution::write::write_scene;
use zonal_scene::{Bands, Scene, SceneError, SolveOptions};

/// The hash of all that a solution depends on: 64 hexadecimal digits.
pub fn scene_hash(scene: &Scene) -> String {
    hasher_of(scene).finalize().to_hex().to_string()
}

/// The hash over a scene, to which more may be added.
fn hasher_of(scene: &Scene) -> blake3::Hasher {
    let mut arrays = ArrayWriter::into_sink(blake3::Hasher::new(), scene.bands());
    arrays.sink.update(encode_unnamed_scene(scene).to_string().as_bytes());
    // A hash takes all bytes.
    write_scene(&mut arrays, scene).unwrap_or_default();
    arrays.sink
}

/// The hash of numbers: 64 hexadecimal digits.
pub(super) fn numbers_hash(numbers: impl Iterator<Item = f64>) -> String {
    let mut hasher = blake3::Hasher::new();
    numbers.for_each(|x| _ = hasher.update(&x.to_le_bytes()));
    hasher.finalize().to_hex().to_string()
}

/// The hash of all that the exchange factors and the direct light of a scene depend on: without reflectances, albedos, the emission of
/// zones that are no direct lights, and the settings of the iteration. 64 hexadecimal digits.
pub(crate) fn factors_hash(scene: &Scene) -> String {
    // These changes keep a valid scene valid.
    let bare = scene.map_blocks(without_scattering).unwrap_or_else(|_| scene.clone());
    let further = [scene.surroundings().has_radiance(), scene.restores_closure(), scene.restores_rows()];
    hasher_of(&bare).update(&further.map(u8::from)).finalize().to_hex().to_string()
}

/// A block of bands without what scatters and what emits but for direct lights.
fn without_scattering(scene: Scene) -> Result<Scene, SceneError> {
    let emitters: Vec<bool> = (0..scene.surfaces().len()).map(|s| scene.is_direct_emitter(s)).collect();
    let mut parts = scene.into_parts();
    for (surface, is_emitter) in parts.surfaces.iter_mut().zip(emitters) {
        surface.reflectance = Bands::ZERO;
        surface.transmission.iter_mut().for_each(|t| t.transmittance = Bands::ZERO);
        if !is_emitter {
            surface.emission = Bands::ZERO;
        }
    }
    parts.faces = Default::default();
    parts.panes.iter_mut().for_each(|p| (p.albedo, p.emission) = (Bands::ZERO, Bands::ZERO));
    if let Some(v) = &mut parts.voxel_grid {
        v.set_albedo(Bands::ZERO);
        v.scale_sources(Bands::ZERO);
        v.clear_heat();
    }
    parts.thermal = None;
    parts.surroundings.radiance = Bands::ZERO;
    let SolveOptions { tolerance, patch_size, patch_rule, engine, zone_basis, .. } = parts.options;
    parts.options =
        SolveOptions { tolerance, patch_size, patch_rule, engine, zone_basis, ..SolveOptions::default() };
    Scene::new(parts)
}
