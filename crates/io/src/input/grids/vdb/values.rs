//! The values of a node: all or only the active ones; plain, zip or Blosc; floats, halves or doubles.
//!
//! | code | values that are not active |
//! |---|---|
//! | 0 | background |
//! | 1 | − background |
//! | 2 | one value, given |
//! | 3 | a mask says which are background and which − background |
//! | 4 | a mask says which are background and which a given value |
//! | 5 | a mask chooses between two given values |
//! | 6 | all values are stored |
//!
//! Codes 0 to 5 omit inactive values only with the flag ACTIVE; given values have full width.

use super::blosc;
use super::bytes::{ByteCursor, SAVE_AGAIN, bit};
use crate::input::reading::error::FileFault;
use crate::input::reading::npy::half_to_f64;
use std::io::Read;

/// Compression flags of a grid.
const FLAG_ZIP: u32 = 1;
const FLAG_ACTIVE: u32 = 2;
const FLAG_BLOSC: u32 = 4;
/// Code of a node that stores all values.
const CODE_ALL_VALUES: u8 = 6;

/// Type of the stored values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StoredPrecision {
    /// Full width.
    Full,
    /// Halves.
    Half,
}

/// Type of the tree's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TreePrecision {
    /// f32.
    Float,
    /// f64.
    Double,
}

/// Encoding of a grid's values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ValueCodec {
    flags: u32,
    stored: StoredPrecision,
    tree: TreePrecision,
    /// The grid's background value.
    pub(crate) background: f64,
}

impl ValueCodec {
    /// Reads the flags.
    pub(crate) fn read(
        c: &mut ByteCursor<'_>,
        stored: StoredPrecision,
        tree: TreePrecision,
    ) -> Result<ValueCodec, FileFault> {
        let flags = c.u32()?;
        if flags & !(FLAG_ZIP | FLAG_ACTIVE | FLAG_BLOSC) != 0 {
            return Err(c.fault(format!("the compression {flags} is not read; {SAVE_AGAIN}")));
        }
        Ok(ValueCodec { flags, stored, tree, background: 0.0 })
    }
    /// One value of full width.
    pub(crate) fn read_value(&self, c: &mut ByteCursor<'_>) -> Result<f64, FileFault> {
        if self.tree == TreePrecision::Double { c.f64() } else { c.f32().map(f64::from) }
    }
    /// Reads the `n` values of a node with active values `mask` into `out`.
    pub(crate) fn read_node(
        &self,
        c: &mut ByteCursor<'_>,
        n: usize,
        mask: &[u64],
        out: &mut Vec<f64>,
    ) -> Result<(), FileFault> {
        let code = c.u8()?;
        if code > CODE_ALL_VALUES {
            return Err(c.fault(format!("{code} is no code of a node; {SAVE_AGAIN}")));
        }
        let mut first = if code == 0 { self.background } else { -self.background };
        let mut second = self.background;
        if matches!(code, 2 | 4 | 5) {
            first = self.read_value(c)?;
        }
        if code == 5 {
            second = self.read_value(c)?;
        }
        let choice = if matches!(code, 3..=5) { c.mask(n)? } else { Vec::new() };
        let partial = self.flags & FLAG_ACTIVE != 0 && code != CODE_ALL_VALUES;
        let stored = if partial { mask.iter().map(|w| w.count_ones() as usize).sum() } else { n };
        out.clear();
        self.read_packed(c, stored, out)?;
        if stored == n {
            return Ok(());
        }
        let mut next = stored;
        out.resize(n, 0.0);
        // Spread from the end, so that no value is overwritten before it is moved.
        for i in (0..n).rev() {
            out[i] = if bit(mask, i) {
                next -= 1;
                out[next]
            } else if bit(&choice, i) {
                second
            } else {
                first
            };
        }
        Ok(())
    }
    /// Reads `n` packed values.
    fn read_packed(&self, c: &mut ByteCursor<'_>, n: usize, out: &mut Vec<f64>) -> Result<(), FileFault> {
        let half = self.stored == StoredPrecision::Half;
        let width = match (self.stored, self.tree) {
            (StoredPrecision::Half, _) => 2,
            (_, TreePrecision::Float) => 4,
            (_, TreePrecision::Double) => 8,
        };
        if n == 0 && half {
            return Ok(());
        }
        let size = n * width;
        let packed = self.flags & (FLAG_ZIP | FLAG_BLOSC);
        let unpacked;
        let bytes = if packed == 0 {
            c.take(size)?
        } else {
            match c.i64()? {
                // Incompressible data is stored plain, its length negated.
                length if length <= 0 && length.unsigned_abs() == size as u64 => c.take(size)?,
                length if length > 0 => {
                    let part = c.take(usize::try_from(length).unwrap_or(usize::MAX))?;
                    unpacked = if size == 0 {
                        Vec::new()
                    } else if packed & FLAG_BLOSC != 0 {
                        blosc::decode(part, size).map_err(|e| c.fault(format!("{e}; {SAVE_AGAIN}")))?
                    } else {
                        unzip(part, size)
                            .ok_or_else(|| c.fault(format!("the zipped data is damaged; {SAVE_AGAIN}")))?
                    };
                    &unpacked
                }
                length => {
                    return Err(c.fault(format!("{length} is no length for {size} bytes; {SAVE_AGAIN}")));
                }
            }
        };
        out.extend(bytes.chunks_exact(width).map(|b| match *b {
            [a, b] => half_to_f64(u16::from_le_bytes([a, b])),
            [a, b, c, d] => f64::from(f32::from_le_bytes([a, b, c, d])),
            _ => f64::from_le_bytes(std::array::from_fn(|i| b[i])),
        }));
        Ok(())
    }
}

/// Exactly `size` bytes out of a zlib stream.
fn unzip(part: &[u8], size: usize) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(size);
    flate2::read::ZlibDecoder::new(part).take(size as u64 + 1).read_to_end(&mut out).ok()?;
    (out.len() == size).then_some(out)
}
