//! `[[light]]` without extent: points, spots and luminaires.
//!
//! A light of power Φ has the unit intensity I₀ = Φ/∫f dω, with f its relative intensity.

use super::lights::{read_direction, read_flux};
use crate::input::error::InputError;
use crate::input::toml::node::{TomlNode, TomlTable};
use zonal_scene::{Bands, IntensityDistribution, Light};

/// Range of the half-angles of a spot, degrees.
const MIN_OUTER_ANGLE: f64 = 0.1;
const MAX_OUTER_ANGLE: f64 = 180.0;

/// An isotropic light.
pub(super) fn read_point(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let distribution = IntensityDistribution::isotropic();
    let intensity = read_unit_intensity(t, &distribution)?;
    let position = t.require("position", "position = [x, y, z] (m)")?.vector()?;
    Ok(Light::Point { name, position, intensity, distribution })
}

/// A cone of light.
pub(super) fn read_spot(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let outer = t.require("outer_angle", "outer_angle = 40 (degrees between the axis and the edge of the cone)")?;
    let outer_angle = match outer.number()? {
        x if (MIN_OUTER_ANGLE..=MAX_OUTER_ANGLE).contains(&x) => x,
        x => {
            return Err(outer.error(format!(
                "{x} is out of range; give degrees from {MIN_OUTER_ANGLE} to {MAX_OUTER_ANGLE} between axis and edge"
            )));
        }
    };
    let inner = |n: TomlNode<'_>| match n.number()? {
        x if (0.0..=outer_angle).contains(&x) => Ok(x),
        x => Err(n.error(format!("{x} is out of range; give degrees from 0 up to the outer angle, {outer_angle}"))),
    };
    let inner_angle = t.read("inner_angle", inner)?.unwrap_or(0.0);
    let half_angles = [inner_angle, outer_angle].map(f64::to_radians);
    let distribution = IntensityDistribution::spot(read_direction(t)?, half_angles);
    let intensity = read_unit_intensity(t, &distribution)?;
    let position = t.require("position", "position = [x, y, z] (m)")?.vector()?;
    Ok(Light::Point { name, position, intensity, distribution })
}

/// The unit intensity, W/sr, from `intensity` or `power`.
fn read_unit_intensity(t: &TomlTable<'_>, distribution: &IntensityDistribution) -> Result<Bands, InputError> {
    match (t.get("intensity"), t.get("power")) {
        (Some(_), Some(n)) => Err(n.error("intensity and power are both given; keep one of them")),
        (None, Some(n)) => Ok(read_flux(&n)? / distribution.solid_angle_integral()),
        _ => read_flux(&t.require("intensity", "intensity = 10 (W/sr, number or [r, g, b]), or power in W")?),
    }
}
