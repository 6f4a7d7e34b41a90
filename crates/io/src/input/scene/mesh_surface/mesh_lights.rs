//! Lights of a mesh file as lights of the scene: cd and lx over 683 lm/W are W/sr and W/m².

use crate::input::mesh::model::{MeshData, MeshLight, MeshLightKind};
use crate::input::reading::error::InputError;
use crate::input::scene::scene_reader::SceneReader;
use crate::input::toml::node::TomlTable;
use crate::input::toml::surface_keys::SURFACE;
use zonal_scene::{Bands, Diagnostic, IntensityDistribution, Light};

/// Luminous efficacy of light of 555 nm, lm/W.
const MAX_EFFICACY: f64 = 683.0;

/// Adds the placed lights of the mesh of the surface `name`, unless the surface says `lights = false`.
pub(crate) fn add_lights(
    table: &TomlTable<'_>,
    mesh: &MeshData,
    name: &str,
    reader: &mut SceneReader<'_>,
) -> Result<(), InputError> {
    let wanted = table.or_default(&SURFACE.lights)?;
    if !wanted || mesh.lights.is_empty() {
        return Ok(());
    }
    if reader.parts.thermal.is_some() {
        let text = format!(
            "mesh of surface '{name}': its {} light(s) are left out in thermal mode; give them as [[light]]",
            mesh.lights.len()
        );
        reader.note(Diagnostic::note("mesh-lights", text));
        return Ok(());
    }
    for light in &mesh.lights {
        let added = scene_light(light, name, reader);
        reader.parts.lights.push(added);
    }
    Ok(())
}

/// The light in the bands of the scene; its mean where colours are unknown.
fn scene_light(light: &MeshLight, surface: &str, reader: &SceneReader<'_>) -> Light {
    let (bands, rgb) = (reader.source.bands(), light.intensity / MAX_EFFICACY);
    let power = if bands.is_rgb() {
        rgb
    } else {
        let mean = Bands::splat(rgb.sum() / 3.0);
        bands.from_rgb(reader.source.block(), rgb.to_rgb()).unwrap_or(mean)
    };
    let name = format!("{surface}/{}", light.name);
    let point = |distribution| Light::Point {
        name: name.clone(),
        position: light.position,
        intensity: power,
        distribution,
    };
    match light.kind {
        MeshLightKind::Directional => Light::Sun {
            name: name.clone(),
            direction: light.direction.normalized(),
            irradiance: power,
            angular_diameter: 0.0,
        },
        MeshLightKind::Point => point(IntensityDistribution::isotropic()),
        MeshLightKind::Spot(half_angles) => point(IntensityDistribution::spot(light.direction, half_angles)),
    }
}
