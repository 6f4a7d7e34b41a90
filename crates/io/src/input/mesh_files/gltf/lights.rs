//! Lights of a glTF document (KHR_lights_punctual): points, spots and directional lights on nodes.
//!
//! A light shines along the −z axis of its node. Its intensity is in cd, of a directional light in lx; its range is a hint for programs that cut light off and is
//! not read.

use super::nodes::{LightInstance, NodeInstance};
use crate::input::mesh::model::{MeshLight, MeshLightKind};
use crate::input::reading::error::FileFault;
use gltf::Document;
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use gltf::json::validation::Checked;
use std::f64::consts::FRAC_PI_2;
use zonal_scene::Bands;

/// Least outer half-angle of a spot, radians.
const MIN_OUTER_ANGLE: f64 = 2e-3;

/// The lights of the nodes, in the file's axes, and notes.
pub(super) fn read_lights(
    file: &str,
    document: &Document,
    nodes: &[NodeInstance],
) -> Result<(Vec<MeshLight>, Vec<String>), FileFault> {
    let extension = document.as_json().extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let all: &[Light] = extension.map_or(&[], |e| &e.lights);
    let mut lights = Vec::new();
    let mut ranges = 0;
    for instance in nodes.iter().filter_map(|n| LightInstance::of(document, n)) {
        let place = format!("node {}", instance.node);
        let Some(light) = all.get(instance.light) else {
            let message = "this node names a light that is not there; export the file again";
            return Err(FileFault::new(file, place, message));
        };
        ranges += usize::from(light.range.is_some());
        lights.push(read_light(light, &instance).map_err(|message| FileFault::new(file, place, message))?);
    }
    let note =
        || format!("{file}: the range of {ranges} light(s) is not read; their light falls off as 1/r²");
    Ok((lights, (ranges > 0).then(note).into_iter().collect()))
}

/// A light at its node; an error says what is wrong.
fn read_light(light: &Light, instance: &LightInstance) -> Result<MeshLight, &'static str> {
    let colour = light.color.map(f64::from);
    let intensity = f64::from(light.intensity);
    let is_valid = |x: f64| x.is_finite() && x >= 0.0;
    if !(is_valid(intensity) && colour.into_iter().all(is_valid)) {
        return Err("the intensity and the colour of a light are numbers from 0; export the file again");
    }
    let kind = match light.type_ {
        Checked::Valid(Type::Directional) => MeshLightKind::Directional,
        Checked::Valid(Type::Point) => MeshLightKind::Point,
        Checked::Valid(Type::Spot) => {
            let Some(spot) = &light.spot else { return Err("this spot has no cone; export the file again") };
            let (inner, outer) = (f64::from(spot.inner_cone_angle), f64::from(spot.outer_cone_angle));
            if !((MIN_OUTER_ANGLE..=FRAC_PI_2 + 1e-6).contains(&outer) && inner >= 0.0 && inner <= outer) {
                return Err(
                    "the cone of a spot has 0 ≤ inner ≤ outer ≤ π/2, outer above 0.002; correct the file",
                );
            }
            MeshLightKind::Spot([inner, outer])
        }
        Checked::Invalid => return Err("this kind of light is not read; export the file without it"),
    };
    Ok(MeshLight {
        name: light.name.clone().unwrap_or_else(|| format!("light{}", instance.light + 1)),
        position: instance.position,
        direction: instance.direction,
        intensity: intensity * Bands::from_rgb(colour),
        kind,
    })
}
