//! `[[light]]` without extent: points, spots and luminaires.
//!
//! A light of power Φ has the unit intensity I₀ = Φ/∫f dω, with f its relative intensity. That of a luminaire is its largest luminous intensity times the dimming factor
//! over the luminous efficacy, by default 683 lm/W: that of 555 nm, so that illuminances are 683 times irradiances.

use super::light_quantities::{read_direction, read_flux, unit_vector};
use crate::input::error::InputError;
use crate::input::photometry::read_luminaire;
use crate::input::toml::node::{TomlNode, TomlTable};
use zonal_math::vec3;
use zonal_scene::{Bands, IntensityDistribution, Light};

/// Range of the half-angles of a spot, degrees.
const MIN_OUTER_ANGLE: f64 = 0.1;
const MAX_OUTER_ANGLE: f64 = 180.0;
/// Luminous efficacy of light of 555 nm, lm/W.
const MAX_EFFICACY: f64 = 683.0;
/// Largest deviation of the mean of a tint from 1.
const TINT_ROUNDING: f64 = 1e-3;

/// An isotropic light.
pub(super) fn read_point(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let distribution = IntensityDistribution::isotropic();
    let intensity = read_unit_intensity(t, &distribution)?;
    let position = t.require("position", "position = [x, y, z] (m)")?.vector()?;
    Ok(Light::Point { name, position, intensity, distribution })
}

/// A cone of light.
pub(super) fn read_spot(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let outer =
        t.require("outer_angle", "outer_angle = 40 (degrees between the axis and the edge of the cone)")?;
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
        x => Err(
            n.error(format!("{x} is out of range; give degrees from 0 up to the outer angle, {outer_angle}"))
        ),
    };
    let inner_angle = t.read("inner_angle", inner)?.unwrap_or(0.0);
    let half_angles = [inner_angle, outer_angle].map(f64::to_radians);
    let distribution = IntensityDistribution::spot(read_direction(t)?, half_angles);
    let intensity = read_unit_intensity(t, &distribution)?;
    let position = t.require("position", "position = [x, y, z] (m)")?.vector()?;
    Ok(Light::Point { name, position, intensity, distribution })
}

/// A light with the intensities of a photometric file.
pub(super) fn read_luminaire_light(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let node = t.require("file", "file = \"lamp.ies\" or \"lamp.ldt\"")?;
    let Some((folder, files)) = t.source.files() else {
        return Err(
            node.error("this scene is a text without a folder and cannot refer to files; save it as a file")
        );
    };
    let luminaire =
        read_luminaire(files, &folder.join(node.text()?)).map_err(|f| node.error(f.to_string()))?;
    let dimming = t.read("dimming", |n| n.non_negative())?.unwrap_or(1.0);
    let efficacy = t.read("efficacy", |n| n.positive())?.unwrap_or(MAX_EFFICACY);
    let tint = t.read("tint", |n| read_tint(&n))?;
    let watts = luminaire.peak * dimming / efficacy;
    let intensity = match node.solar_band() {
        Some(in_solar_band) => in_solar_band(watts),
        None => tint.unwrap_or(Bands::ONE) * watts,
    };
    let aim = t.read("direction", unit_vector)?.unwrap_or(vec3(0.0, 0.0, -1.0));
    let rotation = t.read("rotation", |n| n.number())?.unwrap_or(0.0).to_radians();
    let distribution = IntensityDistribution::table(luminaire.table, aim, rotation);
    let position = t.require("position", "position = [x, y, z] (m)")?.vector()?;
    Ok(Light::Point { name, position, intensity, distribution })
}

/// A tint: bands of mean 1.
fn read_tint(n: &TomlNode<'_>) -> Result<Bands, InputError> {
    if n.solar_band().is_some() {
        return Err(n.error("in thermal mode sunlight has one band; remove the tint"));
    }
    if n.is_list() {
        let values = n.list()?.iter().map(TomlNode::number).collect::<Result<Vec<f64>, InputError>>()?;
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        if mean.is_nan() || (mean - 1.0).abs() > TINT_ROUNDING {
            return Err(n.error(format!(
                "the mean of the bands is {mean}; divide them by it, so that the light keeps its lumens"
            )));
        }
    }
    n.flux_bands()
}

/// The unit intensity, W/sr, from `intensity` or `power`.
fn read_unit_intensity(t: &TomlTable<'_>, distribution: &IntensityDistribution) -> Result<Bands, InputError> {
    match (t.get("intensity"), t.get("power")) {
        (Some(_), Some(n)) => Err(n.error("intensity and power are both given; keep one of them")),
        (None, Some(n)) => Ok(read_flux(&n)? / distribution.solid_angle_integral()),
        _ => read_flux(&t.require("intensity", "intensity = 10 (W/sr, number or [r, g, b]), or power in W")?),
    }
}
