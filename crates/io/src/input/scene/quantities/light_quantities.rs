//! Fluxes and directions of lights.
//!
//! A photometric quantity, in lm, lx, cd or cd/m², is divided by the luminous efficacy, by default 683 lm/W: that of 555 nm, so that illuminances are 683 times irradiances.
//! A tint of mean 1 distributes it over the bands.

use crate::input::reading::error::InputError;
use crate::input::toml::node::{TomlNode, TomlTable};
use zonal_math::Vec3;
use zonal_scene::Bands;

/// Luminous efficacy of light of 555 nm, lm/W.
const MAX_EFFICACY: f64 = 683.0;
/// Largest deviation of the mean of a tint from 1.
const TINT_ROUNDING: f64 = 1e-3;

/// A flux of light: in the bands of the scene, or in the band of sunlight.
pub(crate) fn read_flux(n: &TomlNode<'_>) -> Result<Bands, InputError> {
    let Some(in_solar_band) = n.solar_band() else { return n.flux_bands() };
    if n.is_list() {
        Err(n.error("in thermal mode sunlight has one band; give a number"))
    } else {
        n.non_negative().map(in_solar_band)
    }
}

/// A key in radiometric units, the same quantity in photometric ones, and the value in the bands of the scene.
pub(crate) type KeyedFlux = (&'static str, Bands);

/// The first of some quantities that is given, each with its radiometric and its photometric key. One of them must be given; `example` shows it.
pub(crate) fn read_quantity(
    t: &TomlTable<'_>,
    keys: &[[&'static str; 2]],
    example: &str,
) -> Result<KeyedFlux, InputError> {
    let all = || keys.iter().flatten().filter(|k| t.get(k).is_some());
    if let Some(second) = all().nth(1) {
        let first = all().next().map_or("", |k| k);
        return Err(t
            .require(second, example)?
            .error(format!("{first} and {second} are both given; keep one of them")));
    }
    for [radiometric, photometric] in keys {
        if let Some(n) = t.get(photometric) {
            return Ok((radiometric, read_photometric(t, &n)?));
        }
    }
    for unused in ["efficacy", "tint"] {
        if let Some(n) = t.get(unused) {
            let list: Vec<&str> = keys.iter().map(|k| k[1]).collect();
            return Err(n.error(format!("it belongs to {}; remove it", list.join(", "))));
        }
    }
    let given = all().next().map_or(keys[0][0], |k| k);
    Ok((given, read_flux(&t.require(given, example)?)?))
}

/// A photometric quantity over the efficacy, in the bands of the scene.
fn read_photometric(t: &TomlTable<'_>, n: &TomlNode<'_>) -> Result<Bands, InputError> {
    in_bands(t, n.non_negative()?)
}

/// A number of lumens, or of lumens per area or solid angle, in the bands of the scene.
pub(crate) fn in_bands(t: &TomlTable<'_>, lumens: f64) -> Result<Bands, InputError> {
    let efficacy = t.read("efficacy", |n| n.positive())?.unwrap_or(MAX_EFFICACY);
    with_tint(t, lumens / efficacy)
}

/// A number of watts, or of watts per area or solid angle, with the tint of the light, in the bands of the scene.
pub(crate) fn with_tint(t: &TomlTable<'_>, watts: f64) -> Result<Bands, InputError> {
    let tint = t.read("tint", |n| read_tint(&n))?;
    Ok(in_solar_band(t, watts).unwrap_or(tint.unwrap_or(Bands::ONE) * watts))
}

/// A flux in the band of sunlight; `None` in scenes without that band.
pub(crate) fn in_solar_band(t: &TomlTable<'_>, flux: f64) -> Option<Bands> {
    let bands = t.source.bands();
    bands.has_solar_band().then(|| bands.in_solar_band(t.source.block(), flux))
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

/// The unit vector along which light travels.
pub(crate) fn read_direction(t: &TomlTable<'_>) -> Result<Vec3, InputError> {
    unit_vector(t.require("direction", "direction = [x, y, z], the way along which the light travels")?)
}

/// The unit vector along which light travels, of a value.
pub(crate) fn unit_vector(direction: TomlNode<'_>) -> Result<Vec3, InputError> {
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
