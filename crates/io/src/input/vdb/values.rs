//! The values of a node: as they are, or only the active ones, plain, zip or Blosc; floats, halves or doubles.
//!
//! | code | values that are not active |
//! |---|---|
//! | 0 | background |
//! | 1 | − background |
//! | 2 | one value, given |
//! | 3 | a mask says which are background and which − background |
//! | 4 | a mask says which are background and which a given value |
//! | 5 | a mask chooses between two given values |
//! | 6 | all values are kept |
//!
//! Only with the flag ACTIVE do codes 0 to 5 leave values out; given values have full width.

use super::blosc;
use super::bytes::{Cursor, SAVE_AGAIN, bit};
use crate::input::error::Fault;
use crate::input::npy::half;
use std::io::Read;

const ZIP: u32 = 1;
const ACTIVE: u32 = 2;
const BLOSC: u32 = 4;
const ALL: u8 = 6;

/// How a grid's values are written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coding {
    flags: u32,
    /// Kept as halves.
    pub(crate) half: bool,
    /// The tree's values are doubles.
    pub(crate) double: bool,
    /// The grid's background value.
    pub(crate) background: f64,
}

impl Coding {
    /// Reads the flags.
    pub(crate) fn read(c: &mut Cursor<'_>, half: bool, double: bool) -> Result<Coding, Fault> {
        let flags = c.u32()?;
        if flags & !(ZIP | ACTIVE | BLOSC) != 0 {
            return Err(c.fault(format!("the compression {flags} is not read; {SAVE_AGAIN}")));
        }
        Ok(Coding { flags, half, double, background: 0.0 })
    }
    /// One value of full width.
    pub(crate) fn one(&self, c: &mut Cursor<'_>) -> Result<f64, Fault> {
        if self.double { c.f64() } else { c.f32().map(f64::from) }
    }
    /// The `n` values of a node whose active ones are in `mask`, into `out`.
    pub(crate) fn node(
        &self,
        c: &mut Cursor<'_>,
        n: usize,
        mask: &[u64],
        out: &mut Vec<f64>,
    ) -> Result<(), Fault> {
        let code = c.u8()?;
        if code > ALL {
            return Err(c.fault(format!("{code} is no code of a node; {SAVE_AGAIN}")));
        }
        let mut first = if code == 0 { self.background } else { -self.background };
        let mut second = self.background;
        if matches!(code, 2 | 4 | 5) {
            first = self.one(c)?;
        }
        if code == 5 {
            second = self.one(c)?;
        }
        let choice = if matches!(code, 3..=5) { c.mask(n)? } else { Vec::new() };
        let partial = self.flags & ACTIVE != 0 && code != ALL;
        let kept = if partial { mask.iter().map(|w| w.count_ones() as usize).sum() } else { n };
        out.clear();
        self.plain(c, kept, out)?;
        if kept == n {
            return Ok(());
        }
        let mut next = kept;
        out.resize(n, 0.0);
        // From the end, so that no value is overwritten before it has moved.
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
    /// `n` values as the file packs them.
    fn plain(&self, c: &mut Cursor<'_>, n: usize, out: &mut Vec<f64>) -> Result<(), Fault> {
        let width = if self.half { 2 } else { 4 << u32::from(self.double) };
        if n == 0 && self.half {
            return Ok(());
        }
        let size = n * width;
        let packed = self.flags & (ZIP | BLOSC);
        let unpacked;
        let bytes = if packed == 0 {
            c.take(size)?
        } else {
            match c.i64()? {
                // Data that would not shrink is kept as it is, its length negated.
                length if length <= 0 && length.unsigned_abs() == size as u64 => c.take(size)?,
                length if length > 0 => {
                    let part = c.take(usize::try_from(length).unwrap_or(usize::MAX))?;
                    unpacked = if size == 0 {
                        Vec::new()
                    } else if packed & BLOSC != 0 {
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
            [a, b] => half(u16::from_le_bytes([a, b])),
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
