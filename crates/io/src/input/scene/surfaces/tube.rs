//! `[[light]]` with `kind = "tube"`: a cylinder that emits diffusely, as a surface of its own.
//!
//! The surface is a prism of N = 15 rectangles of the perimeter 2πr of the cylinder, so that area and power are those of the cylinder. The mean over all directions of its width is that of the cylinder too
//! (Cauchy); as N is odd, its width in one direction differs by at most (π/2N)²/3 = 0.4 %. Its ends are open and dark.
//!
//! A tube of power Φ and length L emits Φ/(2πrL) W/m². Far away its intensity at the angle θ from the axis is Φ sinθ/π².

use crate::input::reading::error::InputError;
use crate::input::scene::quantities::light_quantities::read_quantity;
use crate::input::scene::scene_reader::SceneReader;
use crate::input::toml::light_keys::TUBE;
use crate::input::toml::node::TomlTable;
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_math::direction_sampling::sin_cos_turns;
use zonal_scene::{Facet, Light, Plate, Surface};

/// Number of sides of the prism: odd, and few enough for the closed form of the light of a small emitter.
const SIDES: usize = 15;
/// Largest radius over the length.
const MAX_RELATIVE_RADIUS: f64 = 10.0;

/// Reads a tube and adds its surface.
pub(crate) fn read_tube(
    t: &TomlTable<'_>,
    name: String,
    reader: &mut SceneReader<'_>,
) -> Result<Light, InputError> {
    if reader.parts.thermal.is_some() {
        return Err(t.error(
            "tubes belong to light mode; in thermal mode give a surface with temperature and emission, and a light of kind \"emitter\"",
        ));
    }
    let start = t.required(&TUBE.start)?;
    let end_node = t.require(&TUBE.end)?;
    let axis = end_node.vector()? - start;
    let radius_node = t.require(&TUBE.radius)?;
    let radius = radius_node.positive()?;
    let length = axis.length();
    if !(length.is_finite() && length > 0.0) {
        return Err(end_node.error("the tube has no length; move its end away from its start"));
    }
    if radius > MAX_RELATIVE_RADIUS * length {
        return Err(radius_node.error(format!(
            "the radius is more than {MAX_RELATIVE_RADIUS} times the length; give a radius below it"
        )));
    }
    let example = "power = 30 (W, number or [r, g, b]), or luminous_flux in lm";
    let (_, power) = read_quantity(t, &[["power", "luminous_flux"]], example)?;
    let reflectance = t.or_default(&TUBE.reflectance)?;
    let surface = Surface {
        name: name.clone(),
        reflectance,
        emission: power / (2.0 * PI * radius * length),
        ..Surface::default()
    };
    t.record_place();
    reader.source.inherit_place(&format!("surface '{name}'"), &t.key);
    reader.parts.surfaces.push(surface);
    let surface = reader.parts.surfaces.len() - 1;
    let facet = |plate| Facet { surface, plate, uv: [[0.0; 2]; 3] };
    reader.parts.facets.extend(prism(start, axis, radius).map(facet));
    Ok(Light::Emitter { name: None, surface })
}

/// The sides of the prism about an axis that begins at `start`, with their fronts outside.
fn prism(start: Vec3, axis: Vec3, radius: f64) -> [Plate; SIDES] {
    // Corners on a circle that gives the prism the perimeter of the cylinder.
    let (across, along) = axis.normalized().frame();
    let circle = PI * radius / (SIDES as f64 * (PI / SIDES as f64).sin());
    let corner = |k: usize| {
        let (sin, cos) = sin_cos_turns(k as f64 / SIDES as f64);
        start + (across * cos + along * sin) * circle
    };
    std::array::from_fn(|k| {
        let (a, b) = (corner(k), corner((k + 1) % SIDES));
        let outward = Plate::parallelogram(a, b - a, axis);
        if outward.normal().dot(a + b - start * 2.0) > 0.0 {
            outward
        } else {
            Plate::parallelogram(a, axis, b - a)
        }
    })
}
