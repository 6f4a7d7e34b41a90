//! Encodings of single values in JSON, for serde's `with`.
//!
//! A number that is not finite is written as null. Names are written as their words.
//!
//! **Bands.** The bands of a scene are stored in blocks of three, each with a document of its own. Values of bands are written as
//! `{"bands of a block": [a, b, c]}` first; [`join_blocks`] turns the documents of all blocks into one with a list over all bands, and tells where these
//! lists stand. With these places [`block_of_document`] takes one block out of the document.

use serde::{Deserialize, Deserializer, Serializer, de::Error, ser::SerializeMap};
use serde_json::Value;
use std::collections::BTreeSet;
use zonal_math::Grade;
use zonal_scene::encoding::{BLOCK_KEY, nan_bands};
use zonal_scene::{BandSet, Bands, EnergyBalance, PerBand};

/// The key of values of bands that every block reads as a whole.
const WHOLE_KEY: &str = "bands of the scene";

/// Places of lists over bands in a document: keys after slashes, with `*` for any element of a list.
pub(crate) type BandLists = BTreeSet<String>;

/// One document out of those of the blocks of a scene: values of bands become lists over all bands, whose places are returned; all else is that of the
/// first block.
pub(crate) fn join_blocks(bands: &BandSet, blocks: Vec<Value>) -> (Value, BandLists) {
    let counts = (0..bands.block_count()).map(|t| bands.window(t).len()).collect();
    let mut joining = Joining { counts, lists: BandLists::new() };
    let document = joining.join(&blocks.iter().collect::<Vec<_>>(), "");
    (document, joining.lists)
}

struct Joining {
    /// Number of bands of each block.
    counts: Vec<usize>,
    lists: BandLists,
}

impl Joining {
    fn join(&mut self, blocks: &[&Value], place: &str) -> Value {
        let key = [BLOCK_KEY, WHOLE_KEY].into_iter().find(|key| blocks[0].get(key).is_some());
        if let Some(key) = key {
            if key == BLOCK_KEY {
                self.lists.insert(place.to_string());
            }
            let values = |t: usize| blocks[t].get(key).and_then(Value::as_array);
            let own = |t: usize| values(t).into_iter().flatten().take(self.counts[t]).cloned();
            return (0..blocks.len()).flat_map(own).collect();
        }
        match blocks[0] {
            Value::Object(map) => {
                let mut member = |key: &String| -> Value {
                    let of: Vec<_> = blocks.iter().map(|t| t.get(key).unwrap_or(&Value::Null)).collect();
                    self.join(&of, &format!("{place}/{key}"))
                };
                map.keys().map(|key| (key.clone(), member(key))).collect()
            }
            Value::Array(list) => {
                let place = format!("{place}/*");
                let mut element = |k: usize| -> Value {
                    let of: Vec<_> = blocks.iter().map(|t| t.get(k).unwrap_or(&Value::Null)).collect();
                    self.join(&of, &place)
                };
                (0..list.len()).map(&mut element).collect()
            }
            other => other.clone(),
        }
    }
}

/// The document of one block of bands, with three values in each list over bands; what fills up the last block is the last band.
///
/// # Errors
/// The place of a list that does not have one value for each band.
pub(crate) fn block_of_document(
    document: &Value,
    lists: &BandLists,
    bands: &BandSet,
    block: usize,
) -> Result<Value, String> {
    fn walk(
        v: &Value,
        place: &str,
        of_list: &impl Fn(&str, &[Value]) -> Option<Result<Value, String>>,
    ) -> Result<Value, String> {
        match v {
            Value::Object(map) => {
                let member = |(key, v): (&String, &Value)| {
                    Ok((key.clone(), walk(v, &format!("{place}/{key}"), of_list)?))
                };
                map.iter().map(member).collect()
            }
            Value::Array(list) => of_list(place, list).unwrap_or_else(|| {
                let place = format!("{place}/*");
                list.iter().map(|v| walk(v, &place, of_list)).collect()
            }),
            other => Ok(other.clone()),
        }
    }
    walk(document, "", &|place, list| {
        lists.contains(place).then(|| match bands.of_block(block, list) {
            Some(values) => Ok(values.to_vec().into()),
            None => {
                let (path, found) = (place.trim_start_matches('/').replace('/', "."), list.len());
                Err(format!("{path}: a list has {found} values where there are {} bands", bands.count()))
            }
        })
    })
}

/// Decodes a value at a path of the document; an error names the path of the field.
pub(crate) fn decode_at<'v, T: Deserialize<'v>>(path: &str, v: &'v Value) -> Result<T, String> {
    serde_path_to_error::deserialize(v).map_err(|e| {
        let inner = e.path().to_string();
        let dot = if path.is_empty() || inner.starts_with(['.', '[']) { "" } else { "." };
        let field = if inner == "." { path.to_string() } else { format!("{path}{dot}{inner}") };
        format!("{field}: {}", e.inner())
    })
}

/// A grade as its word.
pub(crate) mod grade {
    use super::*;

    pub(crate) fn serialize<S: Serializer>(x: &Grade, s: S) -> Result<S::Ok, S::Error> {
        s.serialize_str(x.name())
    }
    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Grade, D::Error> {
        let word = String::deserialize(d)?;
        let grades = [Grade::Proved, Grade::Estimated, Grade::Statistical];
        let names = || format!("must be one of {}", grades.map(Grade::name).join(", "));
        grades.into_iter().find(|g| g.name() == word).ok_or_else(|| D::Error::custom(names()))
    }
}

/// Errors of bands: null reads as infinite, which stands for unknown.
pub(crate) fn error_bands<'de, D: Deserializer<'de>>(d: D) -> Result<Bands, D::Error> {
    nan_bands(d).map(|x| x.map(unknown))
}

/// Factors of bands, from 0.
pub(crate) fn factors<'de, D: Deserializer<'de>>(d: D) -> Result<Bands, D::Error> {
    match Bands::deserialize(d)? {
        f if f.all(|x| x.is_finite() && x >= 0.0) => Ok(f),
        _ => Err(D::Error::custom("a factor is below 0 or not finite")),
    }
}

/// A number of which null reads as infinite.
pub(crate) fn infinite_if_null<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(d)?.unwrap_or(f64::INFINITY))
}

/// Lists of residuals of which null reads as NaN.
pub(crate) fn residual_lists<'de, D: Deserializer<'de>>(d: D) -> Result<PerBand<Vec<f64>>, D::Error> {
    let lists = PerBand::<Vec<Option<f64>>>::deserialize(d)?;
    Ok(lists.map(|list| list.into_iter().map(|x| x.unwrap_or(f64::NAN)).collect()))
}

/// Polynomials of all bands of the scene.
pub(crate) mod polynomials {
    use super::*;

    pub(crate) fn serialize<S: Serializer>(lists: &[Vec<f64>], s: S) -> Result<S::Ok, S::Error> {
        let mut map = s.serialize_map(Some(1))?;
        map.serialize_entry(WHOLE_KEY, lists)?;
        map.end()
    }
    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Vec<Vec<f64>>, D::Error> {
        Vec::deserialize(d)
    }
}

/// An error that was written as null is unknown: infinite.
fn unknown(error: f64) -> f64 {
    if error.is_nan() { f64::INFINITY } else { error }
}

/// The errors of a balance, of which NaN stands for unknown; the residual is 0.
pub(crate) fn unknown_energy_errors(errors: EnergyBalance) -> EnergyBalance {
    errors.zip_map(&errors, |x, _| unknown(x))
}
