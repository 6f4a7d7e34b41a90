//! One array of a VTK file: its attributes, and its values in any encoding.
//!
//! ```text
//!     plain        length in bytes, values
//!     compressed   number of blocks n, size of a block, size of the last block (0 if whole), n compressed sizes, n blocks
//! ```
//!
//! Lengths are words of 32 or 64 bits, by `header_type`.

use super::byte_source::ByteSource;
use super::xml::Tag;
use crate::input::reading::npy::ElementFormat;
use flate2::read::ZlibDecoder;
use std::io::Read;

/// Largest expansion of deflate, and the bytes that any block may have.
const MAX_DEFLATE_EXPANSION: usize = 1032;
const MIN_BLOCK_ALLOWANCE: usize = 1024;
/// Most values of an array for each byte of its file, and the values that any array may have. Arrays of a mesh with points on a regular grid have
/// about four values a byte when compressed; a value takes eight bytes of memory.
const MAX_VALUES_PER_FILE_BYTE: usize = 16;
const MIN_VALUES_ALLOWANCE: usize = 1 << 14;

/// How the arrays of a file are encoded.
#[derive(Default)]
pub(crate) struct Encoding {
    big_endian: bool,
    /// Bytes of a length: 4 or 8.
    word: usize,
    compressed: bool,
    /// Offset of the first byte of the appended data, and whether they are base64.
    appended: Option<(usize, bool)>,
}

impl Encoding {
    /// Reads the attributes of the root.
    pub(crate) fn read(&mut self, root: &Tag) -> Result<(), String> {
        self.big_endian = root.attribute("byte_order") == Some("BigEndian");
        self.word = match root.attribute("header_type") {
            None | Some("UInt32") => 4,
            Some("UInt64") => 8,
            Some(other) => return Err(format!("lengths of type {other} are not read; save the file again")),
        };
        self.compressed = match root.attribute("compressor") {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                return Err(format!(
                    "data compressed by {other} are not read; save with zlib, or without compression"
                ));
            }
        };
        Ok(())
    }

    /// Finds the appended data behind their tag: they follow an underscore.
    pub(crate) fn find_appended(&mut self, tag: &Tag, bytes: &[u8], from: usize) {
        let base64 = tag.attribute("encoding") == Some("base64");
        let mark = bytes[from..].iter().position(|b| *b == b'_');
        self.appended = mark.map(|k| (from + k + 1, base64));
    }
}

/// The attributes of an array.
pub(crate) struct ArrayEntry {
    pub(crate) name: String,
    pub(crate) components: usize,
    kind: String,
    format: String,
    /// Byte in the appended data.
    offset: Option<usize>,
    /// Offset of the text of the element.
    text: usize,
}

impl ArrayEntry {
    pub(crate) fn of(tag: &Tag, text: usize) -> ArrayEntry {
        let of = |name: &str| tag.attribute(name).unwrap_or("").to_string();
        let components = tag.attribute("NumberOfComponents").and_then(|n| n.trim().parse().ok());
        ArrayEntry {
            name: of("Name"),
            // VTK writes 0 for one component in places.
            components: components.filter(|n| *n > 0).unwrap_or(1),
            kind: of("type"),
            format: of("format"),
            offset: tag.attribute("offset").and_then(|n| n.trim().parse().ok()),
            text,
        }
    }

    /// All values, as doubles: `wanted` of them. The number is checked before any value is decoded.
    pub(crate) fn decode(&self, file: &[u8], encoding: &Encoding, wanted: usize) -> Result<Vec<f64>, String> {
        let limit = file.len().saturating_mul(MAX_VALUES_PER_FILE_BYTE).saturating_add(MIN_VALUES_ALLOWANCE);
        if wanted > limit {
            return Err(format!(
                "{wanted} values are declared, more than the {} bytes of the file can justify; save the file again, with less compression",
                file.len()
            ));
        }
        let number = element_format(&self.kind, encoding.big_endian)?;
        let text = file.get(self.text..).unwrap_or(&[]);
        let source = match (self.format.as_str(), encoding.appended) {
            ("ascii", _) => return check_count(read_text(text)?, wanted),
            ("binary", _) => ByteSource::Base64(text),
            ("appended", Some((start, base64))) => {
                let at = self.offset.and_then(|o| start.checked_add(o)).and_then(|a| file.get(a..));
                let data = at.ok_or("the offset of this array lies beyond the file; save the file again")?;
                if base64 { ByteSource::Base64(data) } else { ByteSource::Raw(data) }
            }
            ("appended", None) => return Err("the file has no appended data; save the file again".into()),
            (other, _) => {
                return Err(format!("the format '{other}' is not read; save the file as ascii or binary"));
            }
        };
        let check = |bytes: usize| check_bytes(bytes, number.size, wanted);
        let bytes = if encoding.compressed {
            unpack(source, encoding, &check)?
        } else {
            plain(source, encoding, &check)?
        };
        check(bytes.len())?;
        let values: Vec<f64> = bytes.chunks_exact(number.size).map(|c| number.value(c)).collect();
        // Doubles hold whole numbers up to 2⁵³; larger ones would be rounded in silence.
        match values.iter().find(|x| number.kind != 'f' && x.abs() >= MAX_WHOLE_NUMBER) {
            Some(x) => Err(format!("the whole number {x:e} is out of range (2^53); mend the file")),
            None => Ok(values),
        }
    }
}

/// Whole numbers below this one are exact as doubles.
const MAX_WHOLE_NUMBER: f64 = 9_007_199_254_740_992.0;

/// Compares the bytes of an array with the wanted number of values.
fn check_bytes(bytes: usize, size: usize, wanted: usize) -> Result<(), String> {
    if !bytes.is_multiple_of(size) {
        return Err("the data are no whole number of values; save the file again".into());
    }
    wrong_count(bytes / size, wanted)
}

fn check_count(values: Vec<f64>, wanted: usize) -> Result<Vec<f64>, String> {
    wrong_count(values.len(), wanted).map(|()| values)
}

fn wrong_count(found: usize, wanted: usize) -> Result<(), String> {
    if found == wanted {
        Ok(())
    } else {
        Err(format!("the array has {found} values where {wanted} are declared; save the file again"))
    }
}

/// Numbers in a text, up to the next tag.
fn read_text(text: &[u8]) -> Result<Vec<f64>, String> {
    let end = text.iter().position(|b| *b == b'<').unwrap_or(text.len());
    let text = std::str::from_utf8(&text[..end])
        .map_err(|_| "the values are not a text; save the file again".to_string())?;
    let number = |w: &str| w.parse::<f64>().map_err(|_| format!("'{w}' is no number; mend the file"));
    text.split_whitespace().map(number).collect()
}

/// The word number `k` of a header.
fn word(header: &[u8], k: usize, encoding: &Encoding) -> Result<usize, String> {
    let bytes = &header[k * encoding.word..(k + 1) * encoding.word];
    let push = |n: u64, b: &u8| n << 8 | u64::from(*b);
    let n = if encoding.big_endian { bytes.iter().fold(0, push) } else { bytes.iter().rev().fold(0, push) };
    usize::try_from(n).map_err(|_| "a length is too large; save the file again".into())
}

/// The number of bytes `a + b c`, or an error for a length beyond all memory.
fn length(a: usize, b: usize, c: usize) -> Result<usize, String> {
    let sum = b.checked_mul(c).and_then(|x| x.checked_add(a));
    sum.ok_or_else(|| "a length is too large; save the file again".into())
}

/// Values that are not compressed; `check` is passed their number of bytes before they are copied.
fn plain(
    source: ByteSource<'_>,
    encoding: &Encoding,
    check: &dyn Fn(usize) -> Result<(), String>,
) -> Result<Vec<u8>, String> {
    let n = word(&source.first(encoding.word)?, 0, encoding)?;
    source.check(length(encoding.word, n, 1)?)?;
    check(n)?;
    let mut all = source.first(length(encoding.word, n, 1)?)?;
    Ok(all.split_off(encoding.word))
}

/// Values in blocks of zlib; `check` is passed the declared number of bytes before any block is unpacked.
fn unpack(
    source: ByteSource<'_>,
    encoding: &Encoding,
    check: &dyn Fn(usize) -> Result<(), String>,
) -> Result<Vec<u8>, String> {
    let w = encoding.word;
    let blocks = word(&source.first(w)?, 0, encoding)?;
    if blocks == 0 {
        return Ok(Vec::new());
    }
    let header = source.first(length(3 * w, blocks, w)?)?;
    let (size, last) = (word(&header, 1, encoding)?, word(&header, 2, encoding)?);
    let packed: Vec<usize> = (0..blocks).map(|k| word(&header, 3 + k, encoding)).collect::<Result<_, _>>()?;
    let declared = length(if last > 0 { last } else { size }, blocks - 1, size)?;
    check(declared)?;
    let total = packed.iter().try_fold(header.len(), |n, p| length(n, *p, 1))?;
    let all = source.first(total)?;
    let (mut out, mut at) = (Vec::new(), header.len());
    for (k, p) in packed.iter().enumerate() {
        let wanted = if k + 1 == blocks && last > 0 { last } else { size };
        if wanted > length(MIN_BLOCK_ALLOWANCE, *p, MAX_DEFLATE_EXPANSION)? {
            return Err("a block declares more bytes than it can hold; save the file again".into());
        }
        let before = out.len();
        let mut block = ZlibDecoder::new(&all[at..at + p]).take(wanted as u64 + 1);
        block
            .read_to_end(&mut out)
            .map_err(|e| format!("a block cannot be unpacked ({e}); save the file again"))?;
        if out.len() - before != wanted {
            return Err("a block has another length than declared; save the file again".into());
        }
        at += p;
    }
    Ok(out)
}

/// The type of the values of an array.
fn element_format(name: &str, big_endian: bool) -> Result<ElementFormat, String> {
    let (kind, size) = match name {
        "Float32" => ('f', 4),
        "Float64" => ('f', 8),
        "Int8" => ('i', 1),
        "Int16" => ('i', 2),
        "Int32" => ('i', 4),
        "Int64" => ('i', 8),
        "UInt8" => ('u', 1),
        "UInt16" => ('u', 2),
        "UInt32" => ('u', 4),
        "UInt64" => ('u', 8),
        other => return Err(format!("values of type {other} are not read; give numbers")),
    };
    Ok(ElementFormat { kind, size, big_endian })
}
