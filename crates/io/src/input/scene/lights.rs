//! `[[light]]`: sun, sky, and surfaces whose emission is direct light.

use crate::input::error::InputError;
use crate::input::suggestion::suggest;
use crate::input::toml::key_tables::{EMITTER, SKY, SUN};
use crate::input::toml::node::{TomlNode, TomlTable};
use zonal_scene::{Bands, Light, Surface};

/// Angular diameter of a sun without one, degrees.
const DEFAULT_ANGULAR_DIAMETER_DEGREES: f64 = 0.53;
/// Parts of a surface that an error lists.
const MAX_LISTED_PARTS: usize = 12;
/// Surfaces that an error lists.
const MAX_LISTED_SURFACES: usize = 24;

/// Reads entry `index` of `[[light]]`.
pub(super) fn read_light(
    node: &TomlNode<'_>,
    index: usize,
    surfaces: &[Surface],
) -> Result<Light, InputError> {
    const KINDS: [&str; 3] = ["sun", "sky", "emitter"];
    let (name, mut t) = node.named_table("light", index)?;
    let kind = t.require("kind", "kind = \"sun\", \"sky\" or \"emitter\"")?.choice(&KINDS)?;
    match kind {
        0 => {
            t.check(SUN)?;
            t.key = format!("light '{name}'");
            read_sun(&t, name)
        }
        1 => {
            t.check(SKY)?;
            t.key = format!("light '{name}'");
            let radiance = t.require("radiance", "radiance = 100 (W/(m2 sr), number or [r, g, b])")?;
            Ok(Light::Sky { radiance: radiance.bands(f64::INFINITY)?, name })
        }
        _ => {
            t.check(EMITTER)?;
            let surface = t.require("surface", "surface = \"the name of an emitting surface\"")?;
            let name = t.get("name").map(|_| name);
            Ok(Light::Emitter { name, surface: find_emitter(&surface, surfaces)? })
        }
    }
}

fn read_sun(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let direction = t.require("direction", "direction = [x, y, z], the way along which the light travels")?;
    let d = direction.vector()?;
    // Divide by the largest component first, so that the square neither overflows nor vanishes.
    let unit = (d / d.max_abs()).normalized();
    if !unit.is_finite() {
        return Err(
            direction.error("this direction has no length; give the way along which the light travels")
        );
    }
    let irradiance = t.require("irradiance", "irradiance = 1000 (W/m2, number or [r, g, b])")?;
    let degrees = |n: TomlNode<'_>| match n.number()? {
        x if (0.0..180.0).contains(&x) => Ok(x),
        x => Err(n.error(format!("{x} is out of range; give degrees from 0 up to 180 (the sun has 0.53)"))),
    };
    Ok(Light::Sun {
        direction: unit,
        irradiance: irradiance.bands(f64::INFINITY)?,
        angular_diameter: t
            .read("angular_diameter", degrees)?
            .unwrap_or(DEFAULT_ANGULAR_DIAMETER_DEGREES)
            .to_radians(),
        name,
    })
}

/// The index of the emitting surface that a value names.
fn find_emitter(node: &TomlNode<'_>, surfaces: &[Surface]) -> Result<usize, InputError> {
    let wanted = node.text()?;
    let Some(index) = surfaces.iter().position(|s| s.name == wanted) else {
        let names: Vec<&str> = surfaces.iter().map(|s| s.name.as_str()).collect();
        let is_part = |s: &&&str| s.strip_prefix(wanted).is_some_and(|rest| rest.starts_with(['.', '/']));
        let parts: Vec<&str> = names.iter().filter(is_part).take(MAX_LISTED_PARTS).copied().collect();
        let hint = match parts.is_empty() {
            false => format!("name one of its parts: {}", parts.join(", ")),
            true if names.is_empty() => "add a [[surface]] with this name".to_string(),
            true => suggest(wanted, &names[..names.len().min(MAX_LISTED_SURFACES)]),
        };
        return Err(node.error(format!("no surface has the name '{wanted}'; {hint}")));
    };
    if surfaces[index].emission == Bands::ZERO {
        return Err(node.error(format!(
            "surface '{wanted}' does not emit; give it an emission above 0 or remove this light"
        )));
    }
    Ok(index)
}
