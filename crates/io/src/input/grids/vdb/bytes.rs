//! A position in the bytes of a file: little-endian values, each read checked against the end.

use crate::input::reading::error::FileFault;

/// Reads from a position onward; every error names the byte.
#[derive(Clone)]
pub(crate) struct ByteCursor<'a> {
    file: &'a str,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> ByteCursor<'a> {
    pub(crate) fn new(file: &'a str, bytes: &'a [u8]) -> ByteCursor<'a> {
        ByteCursor { file, bytes, at: 0 }
    }
    pub(crate) fn fault(&self, message: impl std::fmt::Display) -> FileFault {
        FileFault::new(self.file, format!("byte {}", self.at), message)
    }
    pub(crate) fn position(&self) -> usize {
        self.at
    }
    pub(crate) fn length(&self) -> usize {
        self.bytes.len()
    }
    /// The same file at another position.
    pub(crate) fn seek(&self, at: i64) -> Result<ByteCursor<'a>, FileFault> {
        match usize::try_from(at) {
            Ok(at) if at <= self.bytes.len() => Ok(ByteCursor { at, ..self.clone() }),
            _ => Err(self.fault(format!("{at} is no place in this file; {SAVE_AGAIN}"))),
        }
    }
    pub(crate) fn take(&mut self, n: usize) -> Result<&'a [u8], FileFault> {
        let end = self.at.checked_add(n).filter(|end| *end <= self.bytes.len());
        let Some(end) = end else {
            return Err(self.fault(format!("the file is cut short; {SAVE_AGAIN}")));
        };
        let part = &self.bytes[self.at..end];
        self.at = end;
        Ok(part)
    }
    fn fixed<const N: usize>(&mut self) -> Result<[u8; N], FileFault> {
        let part = self.take(N)?;
        Ok(std::array::from_fn(|i| part[i]))
    }
    pub(crate) fn u8(&mut self) -> Result<u8, FileFault> {
        Ok(self.take(1)?[0])
    }
    pub(crate) fn u32(&mut self) -> Result<u32, FileFault> {
        self.fixed().map(u32::from_le_bytes)
    }
    pub(crate) fn i64(&mut self) -> Result<i64, FileFault> {
        self.fixed().map(i64::from_le_bytes)
    }
    pub(crate) fn f32(&mut self) -> Result<f32, FileFault> {
        self.fixed().map(f32::from_le_bytes)
    }
    pub(crate) fn f64(&mut self) -> Result<f64, FileFault> {
        self.fixed().map(f64::from_le_bytes)
    }
    /// Three doubles.
    pub(crate) fn vector(&mut self) -> Result<[f64; 3], FileFault> {
        Ok([self.f64()?, self.f64()?, self.f64()?])
    }
    /// Three whole numbers of four bytes.
    pub(crate) fn coordinates(&mut self) -> Result<[i64; 3], FileFault> {
        let mut one = || self.fixed().map(i32::from_le_bytes).map(i64::from);
        Ok([one()?, one()?, one()?])
    }
    /// A text after its length; bytes that are not UTF-8 are replaced.
    pub(crate) fn text(&mut self) -> Result<String, FileFault> {
        let n = self.u32()? as usize;
        Ok(String::from_utf8_lossy(self.take(n)?).into_owned())
    }
    /// `bits` bits in words of 64.
    pub(crate) fn mask(&mut self, bits: usize) -> Result<Vec<u64>, FileFault> {
        let words = self.take(bits / 8)?.chunks_exact(8);
        Ok(words.map(|w| u64::from_le_bytes(std::array::from_fn(|i| w[i]))).collect())
    }
}

/// The remedy for a damaged file.
pub(crate) const SAVE_AGAIN: &str = "save it again with the program that made it";

/// Bit `i` of a mask; false beyond its end.
pub(crate) fn bit(mask: &[u64], i: usize) -> bool {
    mask.get(i / 64).is_some_and(|w| w >> (i % 64) & 1 == 1)
}
