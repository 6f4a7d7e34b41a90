//! `mode = "thermal"`: what surfaces, panes and the medium know of temperature and heat, and the shares of the emission.
//!
//! Keys of the other mode are refused with a word on where they belong, wherever they stand.

use super::error::InputError;
use super::node::{Node, Table};
use zonal_scene::thermal::{LARGEST_POWER, LARGEST_TEMPERATURE, power_out_of_range};
use zonal_scene::{Bands, Known, Shares, Thermal, bands};

/// Keys of surfaces that belong to thermal mode.
const WALL: [&str; 4] = ["temperature", "heat_flux", "net_power", "emissivity"];
/// Keys of volumes that belong to thermal mode.
pub(crate) const VOLUME: [&str; 2] = ["temperature", "heat_source"];
/// Keys that belong to light mode.
const LIGHT: [&str; 4] = ["emission", "texture", "source", "radiance"];
/// How far reflectance and emissivity may be from 1 in sum.
const ROUNDING: f64 = 1e-9;

/// Refuses the keys of a table that belong to the other mode.
pub(crate) fn check_mode(t: &Table<'_>, thermal: bool) -> Result<(), InputError> {
    let (wrong, mend) = match thermal {
        true => (
            &LIGHT[..],
            "this key belongs to mode = \"light\"; in thermal mode give temperatures and emissivities, or heat",
        ),
        false => (
            &WALL[..3],
            "this key belongs to thermal mode; write mode = \"thermal\" at the top of the file, or remove it",
        ),
    };
    let found =
        wrong.iter().find_map(|k| t.get(k)).or_else(|| if thermal { None } else { t.get("heat_source") });
    match found {
        Some(n) => Err(n.error(mend)),
        None => Ok(()),
    }
}

/// Kelvin.
pub(crate) fn kelvin(n: Node<'_>) -> Result<f64, InputError> {
    match n.number()? {
        t if t > 0.0 && t <= LARGEST_TEMPERATURE => Ok(t),
        t => Err(n.error(format!("{t} K is out of range; give kelvin above 0 (0 °C is 273.15)"))),
    }
}

/// W, W/m² or W/m³ of net power.
fn watts(n: &Node<'_>) -> Result<f64, InputError> {
    match n.number()? {
        q if q.abs() <= LARGEST_POWER => Ok(q),
        q => Err(n.error(power_out_of_range(q))),
    }
}

/// Exactly one of some keys, or none.
fn one<'a>(t: &Table<'a>, keys: &[&str]) -> Result<Option<(usize, Node<'a>)>, InputError> {
    let mut given = keys.iter().enumerate().filter_map(|(k, key)| Some((k, t.get(key)?)));
    let first = given.next();
    if let (Some(_), Some((_, n))) = (&first, given.next()) {
        let list = keys.join(", ");
        return Err(n.error(format!("more than one of {list} is given; keep the one that is known")));
    }
    Ok(first)
}

/// What a surface's table knows.
pub(crate) fn wall(t: &Table<'_>) -> Result<Option<Known>, InputError> {
    let Some((k, n)) = one(t, &WALL[..3])? else { return Ok(None) };
    Ok(Some(match k {
        0 => Known::Temperature(kelvin(n)?),
        1 => Known::Flux(watts(&n)?),
        _ => Known::Power(watts(&n)?),
    }))
}

/// What a volume's table knows; arrays from files are none of it.
pub(crate) fn volume(t: &Table<'_>) -> Result<Option<Known>, InputError> {
    match one(t, &VOLUME)? {
        Some((_, n)) if n.is_table() => Ok(None),
        Some((0, n)) => Ok(Some(Known::Temperature(kelvin(n)?))),
        Some((_, n)) => Ok(Some(Known::Flux(watts(&n)?))),
        None => Ok(None),
    }
}

/// ρ, from `reflectance` or `emissivity`.
pub(crate) fn reflectance(t: &Table<'_>) -> Result<Option<Bands>, InputError> {
    let given = t.read("reflectance", |n| n.bands(1.0))?;
    let Some(n) = t.get("emissivity") else { return Ok(given) };
    let own = n.bands(1.0)?.map(|e| 1.0 - e);
    match given {
        Some(r) if (0..3).any(|b| (r[b] - own[b]).abs() > ROUNDING) => {
            Err(n.error("emissivity and reflectance are at odds: they sum to 1; keep one of them"))
        }
        _ => Ok(Some(own)),
    }
}

/// κ and Ω, from `extinction`, `albedo` and `absorption` = κ(1 − Ω).
pub(crate) fn extinction(t: &Table<'_>) -> Result<[Option<Bands>; 2], InputError> {
    let kappa = t.read("extinction", |n| n.bands(f64::INFINITY))?;
    // An array from a file fills in later.
    let albedo = match t.get("albedo") {
        Some(n) if !n.is_table() => Some(n.bands(1.0)?),
        _ => None,
    };
    let Some(n) = t.get("absorption") else { return Ok([kappa, albedo]) };
    let own = n.bands(f64::INFINITY)?;
    if t.get("albedo").is_some_and(|a| a.is_table()) {
        return Err(n.error("beside an albedo from a file the absorption follows from the extinction; give the extinction instead"));
    }
    match (kappa, albedo) {
        (None, None) => Ok([Some(own), Some([0.0; 3])]),
        (Some(k), None) => {
            if (0..3).any(|b| own[b] > k[b]) {
                return Err(n.error("the absorption exceeds the extinction; give no more than that"));
            }
            let albedo = bands(|b| if k[b] > 0.0 { 1.0 - own[b] / k[b] } else { 0.0 });
            Ok([Some(k), Some(albedo)])
        }
        (None, Some(o)) => {
            if (0..3).any(|b| o[b] == 1.0) {
                return Err(n.error("at an albedo of 1 the absorption does not tell the extinction; give extinction and albedo"));
            }
            Ok([Some(bands(|b| own[b] / (1.0 - o[b]))), Some(o)])
        }
        (Some(k), Some(o)) => {
            let off = |b: usize| (k[b] * (1.0 - o[b]) - own[b]).abs() > ROUNDING * k[b];
            match (0..3).any(off) {
                true => {
                    Err(n
                        .error("absorption is at odds with extinction × (1 − albedo); keep two of the three"))
                }
                false => Ok([Some(k), Some(o)]),
            }
        }
    }
}

/// `mode` and `[thermal]`: nothing in light mode.
pub(crate) fn mode(root: &Table<'_>) -> Result<Option<Thermal>, InputError> {
    let thermal = root.read("mode", |n| n.choice(&["light", "thermal"]))? == Some(1);
    let node = root.get("thermal");
    if !thermal {
        return match node {
            Some(n) => Err(n.error(
                "this table belongs to thermal mode; write mode = \"thermal\" at the top of the file",
            )),
            None => Ok(None),
        };
    }
    let shares = node.map(|n| shares(&n)).transpose()?.unwrap_or_default();
    Ok(Some(Thermal { shares, ..Thermal::default() }))
}

fn shares(node: &Node<'_>) -> Result<Shares, InputError> {
    let t = node.table(&["shares", "weights", "range", "left_out"])?;
    let left_out = t.read("left_out", |n| n.boolean())?.unwrap_or(false);
    match (t.get("shares"), t.get("weights")) {
        (Some(n), None) => {
            if let Some(r) = t.get("range") {
                return Err(r.error("constant shares hold everywhere; remove this key"));
            }
            let s = n.bands(1.0)?;
            Ok(Shares::Weights { coefficients: s.map(|s| vec![s]), range: [1.0, 1.0], left_out })
        }
        (None, Some(n)) => {
            let range =
                t.need("range", "range = [600, 2400] (kelvin, where the polynomials hold)")?.list()?;
            let [low, high] = range.as_slice() else {
                return Err(t.error("range has two temperatures; write range = [600, 2400]"));
            };
            let range = [kelvin(low.clone())?, kelvin(high.clone())?];
            Ok(Shares::Weights { coefficients: polynomials(&n)?, range, left_out })
        }
        (Some(_), Some(n)) => Err(n.error("shares and weights are both given; keep one of them")),
        (None, None) if t.get("range").is_none() && !left_out => Ok(Shares::Grey),
        (None, None) => {
            Err(t.error("neither shares nor weights is given; write one of them, or remove this table"))
        }
    }
}

/// Three lists of coefficients; one of them may be `"rest"`.
fn polynomials(node: &Node<'_>) -> Result<[Vec<f64>; 3], InputError> {
    const WANTED: &str = "give three lists [c0, c1, …], one a band; one of them may be \"rest\"";
    let list = node.list()?;
    let [a, b, c] = list.as_slice() else {
        return Err(node.error(format!("this list has {} entries; {WANTED}", list.len())));
    };
    let mut rest = None;
    let mut out: [Vec<f64>; 3] = Default::default();
    for (k, n) in [a, b, c].into_iter().enumerate() {
        if n.is_list() {
            out[k] = n.list()?.iter().map(|x| x.number()).collect::<Result<_, _>>()?;
            if out[k].is_empty() {
                return Err(n.error(format!("a band has no coefficients; {WANTED}")));
            }
            continue;
        }
        n.choice(&["rest"])?;
        if rest.replace(k).is_some() {
            return Err(n.error(format!("two bands are the rest; {WANTED}")));
        }
    }
    if let Some(k) = rest {
        let longest = out.iter().map(Vec::len).max().unwrap_or(0).max(1);
        let mut own = vec![0.0; longest];
        own[0] = 1.0;
        for other in &out {
            own.iter_mut().zip(other).for_each(|(o, c)| *o -= c);
        }
        out[k] = own;
    }
    Ok(out)
}
