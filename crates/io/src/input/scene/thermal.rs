//! `mode = "thermal"`: boundary conditions of surfaces, panes and the medium, and the band fractions of the emission.
//!
//! Keys of the other mode are refused in every section, with a remedy that names their place.

use crate::input::reading::error::InputError;
use crate::input::toml::key_tables::ROOT;
use crate::input::toml::keys::Key;
use crate::input::toml::kinds::KELVIN;
use crate::input::toml::medium_keys::{PANE as VOLUME, SOLAR_OPTICS};
use crate::input::toml::node::{TomlNode, TomlTable};
use crate::input::toml::surface_keys::SURFACE_PROPERTIES as SURFACE;
use crate::input::toml::thermal_keys::{THERMAL, Thermal as ThermalKeys};
use zonal_scene::{Band, BandFractions, Bands, PerBand, Thermal, ThermalCondition};

/// Keys of boundary conditions of surfaces, in thermal mode.
const SURFACE_CONDITIONS: [&str; 3] = ["temperature", "heat_flux", "net_power"];
/// Keys of a surface beside them that belong to thermal mode.
const NETWORK_KEYS: [&str; 4] = ["node", "heat_transfer_coefficient", "ambient_temperature", "back"];
/// Keys of thermal conditions of volumes, in thermal mode.
const VOLUME_CONDITIONS: [&str; 2] = ["temperature", "heat_source"];
/// Keys that belong to light mode.
const LIGHT_MODE_KEYS: [&str; 5] = ["emission", "texture", "source", "radiance", "transmittance"];
/// Largest difference, absolute and relative, between two statements of one quantity.
const CONSISTENCY_TOLERANCE: f64 = 1e-9;

/// The mode of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SceneMode {
    /// Radiation from given sources.
    Light,
    /// Temperatures and heat.
    Thermal,
}

/// Refuses the keys of a table that belong to the other mode.
pub(crate) fn check_mode(t: &TomlTable<'_>, mode: SceneMode) -> Result<(), InputError> {
    check_keys(t, mode, &LIGHT_MODE_KEYS)
}

/// As [`check_mode`] for a surface: with sunlight in thermal mode its emission is light, and a number.
pub(crate) fn check_surface_mode(t: &TomlTable<'_>, mode: SceneMode) -> Result<(), InputError> {
    let emission = t.get(&SURFACE.emission).filter(|n| !n.is_value_file() && mode == SceneMode::Thermal);
    if emission.is_some_and(|n| n.solar_band().is_some()) {
        check_keys(t, mode, &LIGHT_MODE_KEYS[1..])
    } else {
        check_keys(t, mode, &LIGHT_MODE_KEYS)
    }
}

fn check_keys(t: &TomlTable<'_>, mode: SceneMode, light_keys: &[&'static str]) -> Result<(), InputError> {
    let (wrong, remedy, more) = match mode {
        SceneMode::Thermal => (
            light_keys,
            "this key belongs to mode = \"light\"; in thermal mode give temperatures and emissivities, or heat",
            None,
        ),
        SceneMode::Light => (
            &SURFACE_CONDITIONS[..],
            "this key belongs to thermal mode; write mode = \"thermal\" at the top of the file, or remove it",
            Some("heat_source"),
        ),
    };
    let network = if mode == SceneMode::Light { &NETWORK_KEYS[..] } else { &[] };
    match wrong.iter().chain(network).copied().chain(more).find_map(|k| t.get(k)) {
        Some(n) => Err(n.error(remedy)),
        None => Ok(()),
    }
}

/// The value of the one key of a list that is given, with the key's index; none if none is given.
fn at_most_one<'a>(t: &TomlTable<'a>, keys: &[&str]) -> Result<Option<(usize, TomlNode<'a>)>, InputError> {
    let mut given = keys.iter().enumerate().filter_map(|(k, key)| Some((k, t.get(key)?)));
    let first = given.next();
    if let (Some(_), Some((_, n))) = (&first, given.next()) {
        let list = keys.join(", ");
        return Err(n.error(format!("more than one of {list} is given; keep the one that is known")));
    }
    Ok(first)
}

/// The boundary condition of a surface's table.
pub(crate) fn read_surface_condition(t: &TomlTable<'_>) -> Result<Option<ThermalCondition>, InputError> {
    // Values from a file are read with the mesh.
    let Some((k, n)) = at_most_one(t, &SURFACE_CONDITIONS)?.filter(|(_, n)| !n.is_table()) else {
        return Ok(None);
    };
    Ok(Some(match k {
        0 => ThermalCondition::Temperature(SURFACE.temperature.read(&n)?),
        1 => ThermalCondition::Flux(SURFACE.heat_flux.read(&n)?),
        _ => ThermalCondition::Power(SURFACE.net_power.read(&n)?),
    }))
}

/// The thermal condition of a volume's table, if it is a number.
pub(crate) fn read_volume_condition(t: &TomlTable<'_>) -> Result<Option<ThermalCondition>, InputError> {
    match at_most_one(t, &VOLUME_CONDITIONS)? {
        Some((_, n)) if n.is_table() => Ok(None),
        Some((0, n)) => Ok(Some(ThermalCondition::Temperature(VOLUME.temperature.read(&n)?))),
        Some((_, n)) => Ok(Some(ThermalCondition::Flux(VOLUME.heat_source.read(&n)?))),
        None => Ok(None),
    }
}

/// The value of a key for the band of sunlight.
pub(crate) fn read_solar(t: &TomlTable<'_>, key: &Key<f64>) -> Result<Option<f64>, InputError> {
    let Some(n) = t.get(key) else { return Ok(None) };
    if !t.source.bands().has_solar_band() {
        return Err(n.error(
            "the scene has no sunlight; add a [[light]] to a scene of mode = \"thermal\", or remove this key",
        ));
    }
    key.read(&n).map(Some)
}

/// ρ, from `reflectance` or `emissivity` = 1 − ρ; NaN in the band of sunlight where a list lacks it.
pub(crate) fn read_reflectance(t: &TomlTable<'_>) -> Result<Option<Bands>, InputError> {
    let number = |key: &str| t.get(key).filter(|n| !n.is_value_file() && !n.is_by_temperature());
    let given = number("reflectance").map(|n| n.bands_or_infrared(1.0, f64::NAN)).transpose()?;
    let Some(n) = number("emissivity") else { return Ok(given) };
    let own = 1.0 - n.bands_or_infrared(1.0, f64::NAN)?;
    match given {
        Some(r) if (r - own).any(|d| d.abs() > CONSISTENCY_TOLERANCE) => {
            Err(n.error("emissivity and reflectance are at odds: they sum to 1; keep one of them"))
        }
        _ => Ok(Some(own)),
    }
}

/// κ and Ω of all bands. Those of sunlight are `solar_extinction` and `solar_albedo`, or else those of all other bands if these are one number.
pub(crate) fn read_extinction_and_albedo(t: &TomlTable<'_>) -> Result<[Option<Bands>; 2], InputError> {
    let [kappa, albedo] = read_two_of_three(t)?;
    let solar = [read_solar(t, &SOLAR_OPTICS.solar_extinction)?, read_solar(t, &SOLAR_OPTICS.solar_albedo)?];
    let (bands, block) = (t.source.bands(), t.source.block());
    let with_solar = |values: Option<Bands>, solar: Option<f64>, key: &str| match (values, solar) {
        (Some(values), Some(solar)) => Ok(Some(bands.with_solar_value(block, values, solar))),
        (Some(values), None) if values.any(f64::is_nan) => {
            Err(t.error(format!("the list for the infrared bands has no value for sunlight; add {key}")))
        }
        (None, Some(_)) => Err(t.error(format!(
            "{key} stands beside a number or list for the infrared, which is missing; give that too"
        ))),
        (values, None) => Ok(values),
    };
    // Without an albedo in the infrared the medium does not scatter there.
    let albedo = albedo.or(solar[1]
        .filter(|_| kappa.is_some() && !t.get(&VOLUME.albedo).is_some_and(|n| n.is_table()))
        .map(|_| Bands::ZERO));
    Ok([
        with_solar(kappa, solar[0], "solar_extinction (1/m)")?,
        with_solar(albedo, solar[1], "solar_albedo")?,
    ])
}

/// κ and Ω, from two of `extinction`, `albedo` and `absorption` = κ(1 − Ω); NaN in the band of sunlight where a list lacks it.
fn read_two_of_three(t: &TomlTable<'_>) -> Result<[Option<Bands>; 2], InputError> {
    let kappa = t.value(&VOLUME.extinction)?;
    // An albedo from a file fills in later.
    let albedo = match t.get(&VOLUME.albedo) {
        Some(n) if !n.is_table() => Some(n.bands_or_infrared(1.0, f64::NAN)?),
        _ => None,
    };
    let Some(n) = t.get(&VOLUME.absorption) else { return Ok([kappa, albedo]) };
    let own = VOLUME.absorption.read(&n)?;
    if t.get(&VOLUME.albedo).is_some_and(|a| a.is_table()) {
        return Err(n.error("beside an albedo from a file the absorption follows from the extinction; give the extinction instead"));
    }
    match (kappa, albedo) {
        (None, None) => Ok([Some(own), Some(Bands::ZERO)]),
        (Some(k), None) => {
            if Band::all().any(|b| own[b] > k[b]) {
                return Err(n.error("the absorption exceeds the extinction; give no more than that"));
            }
            let albedo = own.zip_map(k, |a, k| if k > 0.0 { 1.0 - a / k } else { 0.0 });
            Ok([Some(k), Some(albedo)])
        }
        (None, Some(o)) => {
            if o.any(|o| o == 1.0) {
                return Err(n.error(
                    "at an albedo of 1 the absorption does not determine the extinction; give extinction and albedo",
                ));
            }
            Ok([Some(own / (1.0 - o)), Some(o)])
        }
        (Some(k), Some(o)) => {
            let difference = (k * (1.0 - o) - own).abs();
            if Band::all().any(|b| difference[b] > CONSISTENCY_TOLERANCE * k[b]) {
                return Err(
                    n.error("absorption is at odds with extinction × (1 − albedo); keep two of the three")
                );
            }
            Ok([Some(k), Some(o)])
        }
    }
}

/// `mode` and `[thermal]`; none in light mode.
pub(crate) fn read_mode(root: &TomlTable<'_>) -> Result<Option<Thermal>, InputError> {
    let thermal = root.value(&ROOT.mode)? == Some(1);
    let node = root.get(&ROOT.thermal);
    if !thermal {
        return match node {
            Some(n) => Err(n.error(
                "this table belongs to thermal mode; write mode = \"thermal\" at the top of the file",
            )),
            None => Ok(None),
        };
    }
    let mut band_fractions = node.map(|n| read_band_fractions(&n)).transpose()?.unwrap_or_default();
    let bands = root.source.bands();
    if let Some(limits) = bands.wavelengths().filter(|_| band_fractions.is_grey()) {
        if let Some(gap) = limits.windows(2).find(|w| w[0][1] < w[1][0]) {
            let [low, high] = [gap[0][1], gap[1][0]];
            return Err(root.error(format!(
                "the bands leave out {low} to {high} nm, where a body emits too; in thermal mode let each band begin where the one before it ends"
            )));
        }
        band_fractions = BandFractions::of_wavelengths(bands, root.source.block()).unwrap_or_default();
    }
    if bands.has_solar_band() && band_fractions.is_grey() && root.source.block() == 0 {
        match bands.infrared_count() {
            1 => band_fractions = BandFractions::constant(Bands::from_rgb([1.0, 0.0, 0.0])),
            // The grey gases of a model bring their fractions.
            _ if root.get(&ROOT.bands).is_none() => {}
            n => {
                return Err(root.error(format!(
                    "the scene has {n} bands and sunlight, but no fractions of the emission; write [thermal] with band_fractions or weights, or remove bands"
                )));
            }
        }
    }
    Ok(Some(Thermal { band_fractions, ..Thermal::default() }))
}

/// Band fractions: constant, polynomial in the temperature, or grey.
fn read_band_fractions(node: &TomlNode<'_>) -> Result<BandFractions, InputError> {
    let t = node.table(ThermalKeys::TABLE)?;
    let allow_partial = t.or_default(&THERMAL.allow_partial)?;
    match (t.get(&THERMAL.band_fractions), t.get(&THERMAL.weights)) {
        (Some(n), None) => {
            if let Some(r) = t.get(&THERMAL.range) {
                return Err(r.error("constant band fractions hold everywhere; remove this key"));
            }
            let s = n.bands_or_infrared(1.0, 0.0)?;
            // Sunlight and what fills up the last block emits nothing.
            let (_, window) = n.band_window();
            let of_band = |b: Band| vec![if b.index() < window.len() { s[b] } else { 0.0 }];
            Ok(BandFractions::GreyGases {
                coefficients: PerBand::from_fn(of_band),
                range: [1.0, 1.0],
                allow_partial,
                all_bands: None,
            })
        }
        (None, Some(n)) => {
            let range = t.require(&THERMAL.range)?.list()?;
            let [low, high] = range.as_slice() else {
                return Err(t.error("range has two temperatures; write range = [600, 2400]"));
            };
            let range = [(KELVIN.read)(low)?, (KELVIN.read)(high)?];
            let coefficients = read_polynomials(&n)?;
            Ok(BandFractions::GreyGases { coefficients, range, allow_partial, all_bands: None })
        }
        (Some(_), Some(n)) => Err(n.error("band_fractions and weights are both given; keep one of them")),
        (None, None) if t.get(&THERMAL.range).is_none() && !allow_partial => Ok(BandFractions::Grey),
        (None, None) => Err(
            t.error("neither band_fractions nor weights is given; write one of them, or remove this table")
        ),
    }
}

/// A list of coefficients for each band; one of them may be `"rest"`: 1 less the other polynomials. Returns those of the block that is read.
fn read_polynomials(node: &TomlNode<'_>) -> Result<PerBand<Vec<f64>>, InputError> {
    let (count, window) = node.band_window();
    let wanted = match count {
        3 => "give three lists [c0, c1, …], one a band; one of them may be \"rest\"".to_string(),
        _ => format!("give {count} lists [c0, c1, …], one a band; one of them may be \"rest\""),
    };
    let list = node.list()?;
    if list.len() != count {
        return Err(node.error(format!("this list has {} entries; {wanted}", list.len())));
    }
    let mut rest = None;
    let mut out: Vec<Vec<f64>> = vec![Vec::new(); count];
    for (band, n) in list.iter().enumerate() {
        if n.is_list() {
            out[band] = n.list()?.iter().map(|x| x.number()).collect::<Result<_, _>>()?;
            if out[band].is_empty() {
                return Err(n.error(format!("a band has no coefficients; {wanted}")));
            }
            continue;
        }
        n.choice(&["rest"])?;
        if rest.replace(band).is_some() {
            return Err(n.error(format!("two bands are the rest; {wanted}")));
        }
    }
    if let Some(band) = rest {
        let longest = out.iter().map(Vec::len).max().unwrap_or(0).max(1);
        let mut own = vec![0.0; longest];
        own[0] = 1.0;
        for other in &out {
            own.iter_mut().zip(other).for_each(|(o, c)| *o -= c);
        }
        out[band] = own;
    }
    // What fills up the last block emits nothing.
    let of_band = |b: Band| window.clone().nth(b.index()).map_or_else(|| vec![0.0], |k| out[k].clone());
    Ok(PerBand::from_fn(of_band))
}
