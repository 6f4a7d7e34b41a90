//! `[[light]]` without extent: points, spots and luminaires.
//!
//! A light of power Φ has the unit intensity I₀ = Φ/∫f dω, with f its relative intensity. That of a luminaire is its largest luminous intensity times the dimming factor
//! and the tilt factor of the file at its aim, over the luminous efficacy.

use crate::input::light_files::photometry::read_luminaire;
use crate::input::reading::error::InputError;
use crate::input::scene::quantities::light_quantities::{in_bands, read_quantity};
use crate::input::toml::light_keys::{CONE, LUMINAIRE, PLACED_LIGHT, SUN};
use crate::input::toml::node::TomlTable;
use std::rc::Rc;
use zonal_scene::{Bands, IntensityDistribution, Light};

/// An isotropic light.
pub(crate) fn read_point(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let distribution = IntensityDistribution::isotropic();
    let intensity = read_unit_intensity(t, &distribution)?;
    let position = t.required(&PLACED_LIGHT.position)?;
    Ok(Light::Point { name, position, intensity, distribution })
}

/// A cone of light.
pub(crate) fn read_spot(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let outer_angle = t.required(&CONE.outer_angle)?;
    let inner_angle = t.or_default(&CONE.inner_angle)?;
    if let Some(n) = t.get(&CONE.inner_angle).filter(|_| !(0.0..=outer_angle).contains(&inner_angle)) {
        return Err(n.error(format!(
            "{inner_angle} is out of range; give degrees from 0 up to the outer angle, {outer_angle}"
        )));
    }
    let half_angles = [inner_angle, outer_angle].map(f64::to_radians);
    let distribution = IntensityDistribution::spot(t.required(&SUN.direction)?, half_angles);
    let intensity = read_unit_intensity(t, &distribution)?;
    let position = t.required(&PLACED_LIGHT.position)?;
    Ok(Light::Point { name, position, intensity, distribution })
}

/// A light with the intensities of a photometric file.
pub(crate) fn read_luminaire_light(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let node = t.require(&LUMINAIRE.file)?;
    let (path, files) = node.named_file()?;
    let luminaire = node.once(|| read_luminaire(files, &path).map_err(|f| node.error(f.to_string())))?;
    let luminaire = Rc::unwrap_or_clone(luminaire);
    let dimming = t.or_default(&LUMINAIRE.dimming)?;
    let aim = t.or_default(&LUMINAIRE.direction)?;
    let off_straight_down = (-aim.z).clamp(-1.0, 1.0).acos().to_degrees();
    let tilt = luminaire.tilt.map_or(Ok(1.0), |t| t.at(off_straight_down)).map_err(|e| node.error(e))?;
    if tilt == 0.0 {
        return Err(node.error("the tilt factor of the file at this direction is 0; the luminaire is dark"));
    }
    let intensity = in_bands(t, luminaire.peak * dimming * tilt)?;
    let rotation = t.or_default(&LUMINAIRE.rotation)?.to_radians();
    let distribution = IntensityDistribution::table(luminaire.table, aim, rotation);
    let position = t.required(&PLACED_LIGHT.position)?;
    Ok(Light::Point { name, position, intensity, distribution })
}

/// The unit intensity, W/sr, from an intensity or a power.
fn read_unit_intensity(t: &TomlTable<'_>, distribution: &IntensityDistribution) -> Result<Bands, InputError> {
    let keys = [["intensity", "luminous_intensity"], ["power", "luminous_flux"]];
    let example = "intensity = 10 (W/sr, number or [r, g, b]), power in W, luminous_intensity in cd or luminous_flux in lm";
    Ok(match read_quantity(t, &keys, example)? {
        ("power", flux) => flux / distribution.solid_angle_integral(),
        (_, intensity) => intensity,
    })
}
