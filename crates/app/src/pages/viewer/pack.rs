//! The data file of the page: a JSON header and named arrays, little endian, compressed with gzip.
//!
//! ```text
//!     "ZONALVW1"   8 bytes
//!     n            u32: bytes of the header with trailing spaces, so that the arrays begin at a multiple of 8
//!     0            u32
//!     header       JSON; its "arrays" is { name: { type, offset, length } }
//!     arrays       each at a multiple of 8; offsets in bytes from the end of the header, lengths in values
//! ```
//!
//! Types: `u8`, `u16`, `u32`, `f32`, and `f16` (IEEE halves as u16). The checksum of gzip covers the whole file.

use flate2::{Compression, write::GzEncoder};
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use std::io::Write;

/// First bytes of the file.
pub const MAGIC: &[u8; 8] = b"ZONALVW1";

/// A data file that is being written.
#[derive(Default)]
pub struct Pack {
    header: Map<String, Value>,
    arrays: Map<String, Value>,
    bytes: Vec<u8>,
}

impl Pack {
    /// Sets a key of the header.
    pub fn set(&mut self, key: &str, value: Value) {
        self.header.insert(key.into(), value);
    }
    fn add(&mut self, name: &str, kind: &str, length: usize, bytes: &[u8]) {
        self.arrays
            .insert(name.into(), json!({ "type": kind, "offset": self.bytes.len(), "length": length }));
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(8), 0);
    }
    /// Adds values by their bytes.
    fn add_values<T: Copy + Sync, const N: usize>(
        &mut self,
        name: &str,
        kind: &str,
        values: &[T],
        bytes: impl Fn(T) -> [u8; N] + Sync,
    ) {
        let all: Vec<[u8; N]> = values.par_iter().map(|v| bytes(*v)).collect();
        self.add(name, kind, values.len(), all.as_flattened());
    }
    /// Adds bytes.
    pub fn u8(&mut self, name: &str, values: &[u8]) {
        self.add(name, "u8", values.len(), values);
    }
    /// Adds 16-bit integers.
    pub fn u16(&mut self, name: &str, values: &[u16]) {
        self.add_values(name, "u16", values, u16::to_le_bytes);
    }
    /// Adds 32-bit integers.
    pub fn u32(&mut self, name: &str, values: &[u32]) {
        self.add_values(name, "u32", values, u32::to_le_bytes);
    }
    /// Adds 32-bit floats.
    pub fn f32(&mut self, name: &str, values: &[f32]) {
        self.add_values(name, "f32", values, f32::to_le_bytes);
    }
    /// Adds 16-bit floats of values / `scale`.
    pub fn f16(&mut self, name: &str, values: &[f32], scale: f32) {
        self.add_values(name, "f16", values, |v: f32| half(v / scale).to_le_bytes());
    }
    /// The compressed file; `effort` is 1 for speed to 9 for size.
    ///
    /// # Errors
    /// If the compression fails.
    pub fn finish(mut self, effort: u32) -> std::io::Result<Vec<u8>> {
        self.header.insert("arrays".into(), Value::Object(self.arrays));
        let mut head = Value::Object(self.header).to_string().into_bytes();
        head.resize(head.len().next_multiple_of(8), b' ');
        let mut out = GzEncoder::new(Vec::new(), Compression::new(effort));
        out.write_all(MAGIC)?;
        out.write_all(&(head.len() as u32).to_le_bytes())?;
        out.write_all(&[0; 4])?;
        out.write_all(&head)?;
        out.write_all(&self.bytes)?;
        out.finish()
    }
}

/// The scale that maps the largest finite modulus to 2¹⁴, a quarter of the largest 16-bit float; 1 if all values are zero. Values down to 4e-9 of the largest
/// keep eleven bits; infinite values become about four times the largest.
pub fn scale_of(values: &[f32]) -> f32 {
    let largest = values.iter().map(|x| x.abs()).filter(|x| x.is_finite()).fold(0.0f32, f32::max);
    if largest > 0.0 { (largest / 16384.0).max(f32::MIN_POSITIVE) } else { 1.0 }
}

/// The nearest 16-bit float, ties to even. Larger values become the largest finite one, NaN becomes zero.
pub fn half(x: f32) -> u16 {
    if x.is_nan() {
        return 0;
    }
    let sign = (x.to_bits() >> 16 & 0x8000) as u16;
    let a = x.abs().min(65504.0);
    // Multiples of 2^-24 below 2^-14, else of 2^(e-10).
    let exponent = ((a.to_bits() >> 23) as i32 - 127).max(-14);
    let step = f32::from_bits(((exponent - 10 + 127) as u32) << 23);
    let units = (a / step).round_ties_even() as u32;
    sign | (units + ((exponent + 14) as u32) * 1024).min(0x7bff) as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    fn value(h: u16) -> f64 {
        let (e, m) = ((h >> 10 & 31) as i32, (h & 1023) as f64);
        let a = if e == 0 { m * 2f64.powi(-24) } else { (1024.0 + m) * 2f64.powi(e - 25) };
        if h & 0x8000 == 0 { a } else { -a }
    }

    #[test]
    fn half_rounds_to_nearest() {
        for h in 0..0x7c00u16 {
            assert_eq!(half(value(h) as f32), h);
            assert_eq!(half(-value(h) as f32), h | 0x8000);
            if h < 0x7bff {
                let between = 0.3 * value(h) + 0.7 * value(h + 1);
                assert_eq!(half(between as f32), h + 1, "{h}");
            }
        }
        assert_eq!(half(f32::INFINITY), 0x7bff);
        assert_eq!(half(f32::NAN), 0);
        assert_eq!(scale_of(&[f32::INFINITY, -3.0, 2.0]), 3.0 / 16384.0);
    }

    #[test]
    fn data_file_contains_header_and_arrays() {
        let mut p = Pack::default();
        p.set("name", "a room".into());
        p.u8("bytes", &[1, 2, 3]);
        p.f32("floats", &[1.5, -2.0]);
        p.f16("halves", &[3.0, 1.0], 2.0);
        let mut bytes = Vec::new();
        flate2::read::GzDecoder::new(&p.finish(1).unwrap()[..]).read_to_end(&mut bytes).unwrap();
        assert_eq!(&bytes[..8], MAGIC);
        let n = u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize;
        let head: Value = serde_json::from_slice(&bytes[16..16 + n]).unwrap();
        assert_eq!(head["name"], "a room");
        let at = |name: &str| 16 + n + head["arrays"][name]["offset"].as_u64().unwrap() as usize;
        assert_eq!(bytes[at("bytes")..][..3], [1, 2, 3]);
        assert_eq!(bytes[at("floats")..][..8], [1.5f32.to_le_bytes(), (-2.0f32).to_le_bytes()].concat());
        assert_eq!(bytes[at("halves")..][..4], [half(1.5).to_le_bytes(), half(0.5).to_le_bytes()].concat());
        assert!((at("halves") - 16 - n).is_multiple_of(8) && (16 + n).is_multiple_of(8));
    }
}
