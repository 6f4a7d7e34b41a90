//! Encodings of single values in JSON, for serde's `with`.
//!
//! A number that is not finite is written as null. Names are written as their words.
//!
//! **Bands.** The bands of a scene are stored in blocks of three, each with a document of its own. Values of bands are written as
//! `{"bands of a block": [a, b, c]}` first; [`join_blocks`] turns the documents of all blocks into one with a list over all bands, and tells where these
//! lists stand. With these places [`block_of_document`] takes one block out of the document.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error, ser::SerializeMap};
use serde_json::Value;
use std::collections::BTreeSet;
use zonal_math::{Grade, Vec3};
use zonal_scene::{BandSet, Bands, EnergyBalance, PerBand, SolveStatus, printable};

/// The key of values of bands before they are joined.
const BANDS_KEY: &str = "bands of a block";
/// The key of values of bands that every block reads as a whole.
const WHOLE_KEY: &str = "bands of the scene";

/// Places of lists over bands in a document: keys after slashes, with `*` for any element of a list.
pub(crate) type BandLists = BTreeSet<String>;

/// Values of a block of bands, marked for [`join_blocks`].
fn mark_bands<S: Serializer, T: Serialize>(key: &str, values: &[T], s: S) -> Result<S::Ok, S::Error> {
    let mut map = s.serialize_map(Some(1))?;
    map.serialize_entry(key, values)?;
    map.end()
}

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
        let key = [BANDS_KEY, WHOLE_KEY].into_iter().find(|key| blocks[0].get(key).is_some());
        if let Some(key) = key {
            if key == BANDS_KEY {
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

/// A text with control characters spelt out, since a file may contain any.
pub(crate) fn printable_text<'de, D: Deserializer<'de>>(d: D) -> Result<String, D::Error> {
    Ok(printable(&String::deserialize(d)?).into_owned())
}

/// The element of a list with a given name.
fn find_name<'de, D: Deserializer<'de>, T: Copy>(
    d: D,
    list: &[T],
    name: fn(T) -> &'static str,
) -> Result<T, D::Error> {
    let word = String::deserialize(d)?;
    let names: Vec<&str> = list.iter().map(|x| name(*x)).collect();
    let found = list.iter().copied().find(|x| name(*x) == word);
    found.ok_or_else(|| D::Error::custom(format!("must be one of {}", names.join(", "))))
}

/// A module that writes an enum as its name.
macro_rules! by_name {
    ($module:ident, $type:ty) => {
        /// The enum as its name.
        pub(crate) mod $module {
            use serde::{Deserializer, Serializer};

            pub(crate) fn serialize<S: Serializer>(x: &$type, s: S) -> Result<S::Ok, S::Error> {
                s.serialize_str(x.name())
            }
            pub(crate) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<$type, D::Error> {
                super::find_name(d, &<$type>::VARIANTS, <$type>::name)
            }
        }
    };
}

by_name!(severity, zonal_scene::Severity);
by_name!(heat_row_kind, zonal_scene::HeatRowKind);
by_name!(engine, zonal_scene::Engine);
by_name!(patch_rule, zonal_scene::PatchRule);
by_name!(light_grouping, zonal_scene::LightGrouping);
by_name!(zone_basis, zonal_scene::ZoneBasis);

/// A module that writes a list of a foreign type by the format of its elements.
macro_rules! list_of {
    ($visibility:vis $module:ident, $type:ty, $format:tt) => {
        /// A list of values in their format.
        $visibility mod $module {
            use super::*;
            use serde::{Deserializer, Serializer};

            #[derive(serde::Serialize, serde::Deserialize)]
            #[serde(transparent)]
            struct Entry(#[serde(with = $format)] $type);

            pub(crate) fn serialize<S: Serializer>(list: &[$type], s: S) -> Result<S::Ok, S::Error> {
                s.collect_seq(list.iter().cloned().map(Entry))
            }
            pub(crate) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Vec<$type>, D::Error> {
                let list = <Vec<Entry> as serde::Deserialize>::deserialize(d)?;
                Ok(list.into_iter().map(|e| e.0).collect())
            }
        }
    };
}
pub(crate) use list_of;

/// A grade as its word.
pub(crate) mod grade {
    use super::*;

    pub(crate) fn serialize<S: Serializer>(x: &Grade, s: S) -> Result<S::Ok, S::Error> {
        s.serialize_str(x.name())
    }
    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Grade, D::Error> {
        find_name(d, &[Grade::Proved, Grade::Estimated, Grade::Statistical], Grade::name)
    }
}

/// The status of each band as its name.
pub(crate) mod statuses {
    use super::*;

    pub(crate) fn serialize<S: Serializer>(list: &PerBand<SolveStatus>, s: S) -> Result<S::Ok, S::Error> {
        mark_bands(BANDS_KEY, &list.map(SolveStatus::name).into_rgb(), s)
    }
    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<PerBand<SolveStatus>, D::Error> {
        let names = <[String; 3]>::deserialize(d)?;
        let find = |name: &String| {
            let status = SolveStatus::VARIANTS.into_iter().find(|s| s.name() == name);
            status.ok_or_else(|| D::Error::custom(format!("'{name}' is not a status")))
        };
        let [a, b, c] = &names;
        Ok(PerBand::from_rgb([find(a)?, find(b)?, find(c)?]))
    }
}

/// Three coordinates.
pub(crate) mod vector {
    use super::*;

    pub(crate) fn serialize<S: Serializer>(v: &Vec3, s: S) -> Result<S::Ok, S::Error> {
        v.array().serialize(s)
    }
    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Vec3, D::Error> {
        <[f64; 3]>::deserialize(d).map(Vec3::from_array)
    }
}

/// Bands as three numbers.
pub(crate) mod bands {
    use super::*;

    pub(crate) fn serialize<S: Serializer>(x: &Bands, s: S) -> Result<S::Ok, S::Error> {
        mark_bands(BANDS_KEY, x.as_slice(), s)
    }
    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Bands, D::Error> {
        <[f64; 3]>::deserialize(d).map(Bands::from_rgb)
    }
}

/// Bands of which null reads as NaN.
pub(crate) mod nan_bands {
    use super::*;

    pub(crate) use super::bands::serialize;

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Bands, D::Error> {
        let list = <[Option<f64>; 3]>::deserialize(d)?;
        Ok(Bands::from_rgb(list.map(|x| x.unwrap_or(f64::NAN))))
    }
}

/// Errors of bands: null reads as infinite, which stands for unknown.
pub(crate) mod error_bands {
    use super::*;

    pub(crate) use super::bands::serialize;

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Bands, D::Error> {
        nan_bands::deserialize(d).map(|x| x.map(unknown))
    }
}

/// Factors of bands, from 0.
pub(crate) mod factors {
    use super::*;

    pub(crate) use super::bands::serialize;

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Bands, D::Error> {
        match bands::deserialize(d)? {
            f if f.all(|x| x.is_finite() && x >= 0.0) => Ok(f),
            _ => Err(D::Error::custom("a factor is below 0 or not finite")),
        }
    }
}

/// A number of which null reads as infinite.
pub(crate) fn infinite_if_null<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(d)?.unwrap_or(f64::INFINITY))
}

/// Lists of residuals of which null reads as NaN.
pub(crate) mod residual_lists {
    use super::*;

    pub(crate) fn serialize<S: Serializer>(lists: &PerBand<Vec<f64>>, s: S) -> Result<S::Ok, S::Error> {
        mark_bands(BANDS_KEY, lists.as_slice(), s)
    }
    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<PerBand<Vec<f64>>, D::Error> {
        let lists = <[Vec<Option<f64>>; 3]>::deserialize(d)?;
        let lists = PerBand::from_rgb(lists);
        Ok(lists.map(|list| list.into_iter().map(|x| x.unwrap_or(f64::NAN)).collect()))
    }
}

/// Polynomials of all bands of the scene.
pub(crate) mod polynomials {
    use super::*;

    pub(crate) fn serialize<S: Serializer>(lists: &[Vec<f64>], s: S) -> Result<S::Ok, S::Error> {
        mark_bands(WHOLE_KEY, lists, s)
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
