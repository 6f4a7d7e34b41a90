//! Values of bands in documents (serde).
//!
//! A value of a block of bands is written as a map of one entry, [`BLOCK_KEY`] and the list of its bands, so that the lists of all blocks of a scene can be
//! joined; read is the list alone.

use crate::bands::Bands;
use crate::bands::band::PerBand;
use serde::{Deserialize, Deserializer, Serialize, Serializer, ser::SerializeMap};

/// The key of the bands of a block.
pub const BLOCK_KEY: &str = "bands of a block";

impl<T: Serialize> Serialize for PerBand<T> {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        let mut map = s.serialize_map(Some(1))?;
        map.serialize_entry(BLOCK_KEY, self.as_slice())?;
        map.end()
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for PerBand<T> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<PerBand<T>, D::Error> {
        <[T; 3]>::deserialize(d).map(PerBand::from_rgb)
    }
}

/// Bands of which null reads as NaN, since JSON has no numbers that are not finite.
///
/// # Errors
/// If the value is no list of as many numbers as a block has bands.
pub fn nan_bands<'de, D: Deserializer<'de>>(d: D) -> Result<Bands, D::Error> {
    Ok(PerBand::<Option<f64>>::deserialize(d)?.map(|x| x.unwrap_or(f64::NAN)))
}
