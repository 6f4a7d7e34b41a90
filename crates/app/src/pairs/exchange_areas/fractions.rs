//! Band fractions as JSON: of the scene and of the kinds of cells.

use serde_json::{Value, json};
use std::sync::Arc;
use zonal_scene::{Band, BandFractions, PerBand};

/// The fractions of `bands` bands; null for a grey scene.
pub(super) fn fractions_json(blocks: &[BandFractions], bands: usize) -> Value {
    let (mut limits_nm, mut lists, mut outline) = (Vec::new(), Vec::new(), Value::Null);
    for fractions in blocks {
        match fractions {
            BandFractions::Grey => return Value::Null,
            // An infinite limit has no number.
            BandFractions::BlackBody { limits } => {
                limits_nm.extend(limits.iter().map(|l| l.map(|w| w.is_finite().then_some(w))));
            }
            BandFractions::GreyGases { coefficients, range, allow_partial, all_bands } => {
                lists.extend(coefficients.iter());
                outline = json!({
                    "range": range, "allow_partial": allow_partial, "positive_parts": all_bands.is_some(),
                });
            }
        }
    }
    limits_nm.truncate(bands);
    lists.truncate(bands);
    if lists.is_empty() {
        return json!({ "black_body_limits_nm": limits_nm });
    }
    outline["coefficients"] = json!(lists);
    outline
}

/// The fractions of all kinds of zones, each of all blocks of `bands` bands.
pub(super) fn read_kinds(state: &Value, bands: usize) -> Option<Vec<Vec<BandFractions>>> {
    let further = state["further_band_fractions"].as_array()?;
    std::iter::once(&state["band_fractions"]).chain(further).map(|v| read_fractions(v, bands)).collect()
}

/// The fractions of all blocks of `bands` bands.
fn read_fractions(v: &Value, bands: usize) -> Option<Vec<BandFractions>> {
    if v.is_null() {
        return Some(vec![BandFractions::Grey]);
    }
    let blocks = 0..bands.div_ceil(Band::count());
    let numbers = |v: &Value| v.as_array()?.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>();
    if let Some(limits) = v["black_body_limits_nm"].as_array() {
        let limit = |v: &Value| if v.is_null() { Some(f64::INFINITY) } else { v.as_f64() };
        let of_band = |v: &Value| {
            let [low, high] = [limit(&v[0])?, limit(&v[1])?];
            (0.0 <= low && low <= high).then_some([low, high])
        };
        let limits: Vec<[f64; 2]> = limits.iter().map(of_band).collect::<Option<_>>()?;
        // What fills up the last block emits nothing.
        let own = |t: usize, b: Band| limits.get(t * Band::count() + b.index()).copied();
        let of_block = |t: usize| PerBand::from_fn(|b| own(t, b).unwrap_or([f64::INFINITY; 2]));
        let is_complete = limits.len() == bands;
        return is_complete
            .then(|| blocks.map(|t| BandFractions::BlackBody { limits: of_block(t) }).collect());
    }
    let lists: Vec<Vec<f64>> = v["coefficients"].as_array()?.iter().map(numbers).collect::<Option<_>>()?;
    if lists.len() != bands {
        return None;
    }
    let range = numbers(&v["range"])?;
    let range = [*range.first()?, *range.get(1)?];
    let allow_partial = v["allow_partial"].as_bool()?;
    let has_positive_parts = v["positive_parts"].as_bool()?;
    let all: Option<Arc<[Vec<f64>]>> = has_positive_parts.then(|| lists.as_slice().into());
    let own = |t: usize, b: Band| lists.get(t * Band::count() + b.index()).cloned();
    let of_block = |t: usize| BandFractions::GreyGases {
        coefficients: PerBand::from_fn(|b| own(t, b).unwrap_or_else(|| vec![0.0])),
        range,
        allow_partial,
        all_bands: all.clone(),
    };
    Some(blocks.map(of_block).collect())
}
