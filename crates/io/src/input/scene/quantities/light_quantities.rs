//! Fluxes and directions of lights.
//!
//! A photometric quantity, in lm, lx, cd or cd/m², is divided by the luminous efficacy, by default 683 lm/W: that of 555 nm, so that illuminances are 683 times irradiances.
//! A tint of mean 1 distributes it over the bands.

use crate::input::reading::error::InputError;
use crate::input::toml::node::{TomlNode, TomlTable};
use crate::input::toml::sky_keys::{EFFICACY, PHOTOMETRY};
use zonal_scene::Bands;

/// Largest deviation of the mean of a tint from 1.
const TINT_ROUNDING: f64 = 1e-3;

/// A key in radiometric units, the same quantity in photometric ones, and the value in the bands of the scene.
pub(crate) type KeyedFlux = (&'static str, Bands);

/// The first of some quantities that is given, each with its radiometric and its photometric key. One of them must be given; `example` shows it.
pub(crate) fn read_quantity(
    t: &TomlTable<'_>,
    keys: &[[&'static str; 2]],
    example: &str,
) -> Result<KeyedFlux, InputError> {
    let given: Vec<(&str, TomlNode)> = keys.iter().flatten().filter_map(|k| Some((*k, t.get(k)?))).collect();
    if let [(first, _), (second, n), ..] = given.as_slice() {
        return Err(n.error(format!("{first} and {second} are both given; keep one of them")));
    }
    for [radiometric, photometric] in keys {
        if let Some(n) = t.get(photometric) {
            return Ok((radiometric, read_photometric(t, &n)?));
        }
    }
    for unused in [EFFICACY.efficacy.as_ref(), PHOTOMETRY.tint.as_ref()] {
        if let Some(n) = t.get(unused) {
            let list: Vec<&str> = keys.iter().map(|k| k[1]).collect();
            return Err(n.error(format!("it belongs to {}; remove it", list.join(", "))));
        }
    }
    match keys.iter().find_map(|k| Some((k[0], t.get(k[0])?))) {
        Some((key, n)) => Ok((key, n.light()?)),
        None => Err(t.missing(keys[0][0], example)),
    }
}

/// A photometric quantity over the efficacy, in the bands of the scene.
fn read_photometric(t: &TomlTable<'_>, n: &TomlNode<'_>) -> Result<Bands, InputError> {
    in_bands(t, n.non_negative()?)
}

/// A number of lumens, or of lumens per area or solid angle, in the bands of the scene.
pub(crate) fn in_bands(t: &TomlTable<'_>, lumens: f64) -> Result<Bands, InputError> {
    let efficacy = t.or_default(&EFFICACY.efficacy)?;
    with_tint(t, lumens / efficacy)
}

/// A number of watts, or of watts per area or solid angle, with the tint of the light, in the bands of the scene.
pub(crate) fn with_tint(t: &TomlTable<'_>, watts: f64) -> Result<Bands, InputError> {
    let tint = t.get(&PHOTOMETRY.tint).map(|n| read_tint(&n)).transpose()?;
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
