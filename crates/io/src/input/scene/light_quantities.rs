//! Fluxes and directions of lights.

use crate::input::error::InputError;
use crate::input::toml::node::{TomlNode, TomlTable};
use zonal_math::Vec3;
use zonal_scene::Bands;

/// A flux of light: in the bands of the scene, or in the band of sunlight.
pub(super) fn read_flux(n: &TomlNode<'_>) -> Result<Bands, InputError> {
    let Some(in_solar_band) = n.solar_band() else { return n.flux_bands() };
    match n.is_list() {
        true => Err(n.error("in thermal mode sunlight has one band; give a number")),
        false => n.non_negative().map(in_solar_band),
    }
}

/// The unit vector along which light travels.
pub(super) fn read_direction(t: &TomlTable<'_>) -> Result<Vec3, InputError> {
    unit_vector(t.require("direction", "direction = [x, y, z], the way along which the light travels")?)
}

/// The unit vector along which light travels, of a value.
pub(super) fn unit_vector(direction: TomlNode<'_>) -> Result<Vec3, InputError> {
    let d = direction.vector()?;
    // Divide by the largest component first, so that the square neither overflows nor vanishes.
    let unit = (d / d.max_abs()).normalized();
    if !unit.is_finite() {
        return Err(
            direction.error("this direction has no length; give the way along which the light travels")
        );
    }
    Ok(unit)
}
