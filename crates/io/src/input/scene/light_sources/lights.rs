//! `[[light]]`: sun, sky, point lights, and surfaces whose emission is direct light.
//!
//! In thermal mode their power is in the band of sunlight. A planet of angular radius α and flux M at its surface, W/m², is a disc of uniform radiance
//! M/π, which gives a plane normal to it the irradiance M sin²α: infrared in the bands of the emission, reflected sunlight in that of sunlight.

use super::point_lights::{read_luminaire_light, read_point, read_spot};
use super::skies::{read_cie_sky, read_image_sky, read_perez_sky, read_uniform_sky};
use super::sun_place::SunPlace;
use crate::input::reading::error::InputError;
use crate::input::reading::suggestion::suggest;
use crate::input::scene::quantities::light_quantities::read_quantity;
use crate::input::scene::scene_reader::SceneReader;
use crate::input::scene::surfaces::tube::read_tube;
use crate::input::toml::key_specs::KeyGroups;
use crate::input::toml::light_keys::{
    EMITTER, Emitter, Luminaire, PLANET, Planet, PointLight, SUN, Spot, Sun, Tube,
};
use crate::input::toml::node::{TomlNode, TomlTable};
use crate::input::toml::sky_keys::{CieSky, ImageSky, PLACE, PerezSky, Sky};
use zonal_scene::thermal::blackbody_emissive_power;
use zonal_scene::{Bands, Light, Surface, Thermal};

/// Parts of a surface that an error lists.
const MAX_LISTED_PARTS: usize = 12;
/// Surfaces that an error lists.
const MAX_LISTED_SURFACES: usize = 24;

/// The kinds of lights with their keys.
const KINDS: [(&str, KeyGroups); 11] = [
    ("sun", Sun::TABLE),
    ("sky", Sky::TABLE),
    ("emitter", Emitter::TABLE),
    ("planet", Planet::TABLE),
    ("point", PointLight::TABLE),
    ("spot", Spot::TABLE),
    ("luminaire", Luminaire::TABLE),
    ("cie-sky", CieSky::TABLE),
    ("perez-sky", PerezSky::TABLE),
    ("image-sky", ImageSky::TABLE),
    ("tube", Tube::TABLE),
];

/// Reads entry `index` of `[[light]]`.
pub(crate) fn read_light(
    node: &TomlNode<'_>,
    index: usize,
    reader: &mut SceneReader<'_>,
) -> Result<Light, InputError> {
    let (name, mut t) = node.named_table("light", index)?;
    let kinds = KINDS.map(|k| k.0);
    let Some(kind_node) = t.get(&SUN.kind) else {
        return Err(t.missing("kind", &format!("kind = \"{}\"", kinds.join("\" or \""))));
    };
    let kind = kind_node.choice(&kinds)?;
    if kind == 3 && reader.parts.thermal.is_none() {
        return Err(kind_node.error(
            "planets belong to thermal mode; give a sun of its angular diameter, or write mode = \"thermal\" at the top of the file",
        ));
    }
    t.check(KINDS[kind].1)?;
    if kind == 2 {
        let surface = t.require(&EMITTER.surface)?;
        let name = t.get(&EMITTER.name).map(|_| name);
        return Ok(Light::Emitter { name, surface: find_emitter(&surface, &reader.parts.surfaces)? });
    }
    t.key = format!("light '{name}'");
    match kind {
        0 => read_sun(&t, name),
        1 => read_uniform_sky(&t, name),
        3 => read_planet(&t, name, reader.parts.thermal.as_ref()),
        4 => read_point(&t, name),
        5 => read_spot(&t, name),
        6 => read_luminaire_light(&t, name),
        7 => read_cie_sky(&t, name),
        8 => read_perez_sky(&t, name),
        9 => read_image_sky(&t, name),
        _ => read_tube(&t, name, reader),
    }
}

/// A planet in thermal mode.
fn read_planet(t: &TomlTable<'_>, name: String, thermal: Option<&Thermal>) -> Result<Light, InputError> {
    let angular_diameter = t.required(&PLANET.angular_diameter)?.to_radians();
    let infrared = match (t.get(&PLANET.temperature), t.get(&PLANET.infrared_flux)) {
        (Some(_), Some(n)) => {
            return Err(n.error("temperature and infrared_flux are both given; keep one of them"));
        }
        (Some(n), None) => blackbody_emissive_power(PLANET.temperature.read(&n)?),
        _ => t.or_default(&PLANET.infrared_flux)?,
    };
    let reflected = t.value(&PLANET.reflected_flux)?;
    if infrared == 0.0 && reflected.is_none() {
        return Err(
            t.error("this planet sends nothing; give temperature or infrared_flux, and reflected_flux")
        );
    }
    let emitted = thermal.map_or(Bands::ZERO, |t| t.band_fractions.emissive_powers(infrared)[0]);
    let over_flux = (0.5 * angular_diameter).sin().powi(2);
    let irradiance = (emitted + reflected.unwrap_or_default()) * over_flux;
    Ok(Light::Sun { name, direction: t.required(&SUN.direction)?, irradiance, angular_diameter })
}

fn read_sun(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    if let (Some(_), Some(n)) = (t.get(&SUN.direction), t.get(&PLACE.up)) {
        return Err(n.error("up belongs to latitude, longitude and time; remove it"));
    }
    let sun = SunPlace::read(t)?;
    let example = "irradiance = 1000 (W/m2, number or [r, g, b]), or illuminance in lx";
    let (_, irradiance) = read_quantity(t, &[["irradiance", "illuminance"]], example)?;
    Ok(Light::Sun {
        direction: -sun.towards,
        irradiance,
        angular_diameter: t.or_default(&SUN.angular_diameter)?.to_radians(),
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
        let hint = if !parts.is_empty() {
            format!("name one of its parts: {}", parts.join(", "))
        } else if names.is_empty() {
            "add a [[surface]] with this name".to_string()
        } else {
            suggest(wanted, &names[..names.len().min(MAX_LISTED_SURFACES)])
        };
        return Err(node.error(format!("no surface has the name '{wanted}'; {hint}")));
    };
    // The emission in thermal mode is in the block of the band of sunlight.
    let in_block = node.solar_band().is_none_or(|flux| flux(1.0) != Bands::ZERO);
    if in_block && surfaces[index].emission == Bands::ZERO {
        return Err(node.error(format!(
            "surface '{wanted}' does not emit; give it an emission above 0 or remove this light"
        )));
    }
    Ok(index)
}
