//! Arrays in numpy's npy format, versions 1 to 3: three axes, C or Fortran order, any real type.
//!
//! Reference: numpy.lib.format, NEP 1.

use super::error::Fault;

/// The largest array file, bytes.
pub(crate) const MAX_FILE: u64 = 4 << 30;

/// A three-dimensional array; `values` run with the last axis fastest.
#[derive(Debug)]
pub(crate) struct Array {
    pub(crate) shape: [usize; 3],
    pub(crate) values: Vec<f32>,
}

/// Reads a file's bytes. The size that the header declares is compared with the file's before memory is taken; `word` names
/// what a value is.
pub(crate) fn parse(file: &str, bytes: &[u8], word: &str) -> Result<Array, Fault> {
    let fault = |what: String| Fault::new(file, "header", what);
    let cut = || fault("the file is cut short; save it again with numpy.save".into());
    if !bytes.starts_with(b"\x93NUMPY") {
        return Err(fault("this is not an npy array; save it with numpy.save".into()));
    }
    let number = |range: std::ops::Range<usize>| {
        let little = |n: usize, b: &u8| n << 8 | *b as usize;
        bytes.get(range).map(|b| b.iter().rev().fold(0, little)).ok_or_else(cut)
    };
    let (start, length) = match bytes.get(6) {
        Some(1) => (10, number(8..10)?),
        Some(2 | 3) => (12, number(8..12)?),
        _ => {
            return Err(fault("this npy version is not read; save it with numpy.save".into()));
        }
    };
    let text = bytes.get(start..start + length).ok_or_else(cut)?;
    let text = String::from_utf8_lossy(text);
    let text: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    let (kind, size, big) = element(&text).map_err(fault)?;
    let shape = shape(&text).map_err(fault)?;
    let data = &bytes[start + length..];
    let count = shape.iter().try_fold(1usize, |n, d| n.checked_mul(*d));
    let wanted = count.and_then(|n| n.checked_mul(size));
    let [nx, ny, nz] = shape;
    if wanted != Some(data.len()) {
        return Err(fault(format!(
            "the shape ({nx}, {ny}, {nz}) does not agree with the {} bytes of data; save the array again",
            data.len()
        )));
    }
    if data.is_empty() {
        return Err(fault(format!("the shape ({nx}, {ny}, {nz}) has no elements; save an array with some")));
    }
    let fortran = if text.contains("'fortran_order':True") {
        true
    } else if text.contains("'fortran_order':False") {
        false
    } else {
        return Err(fault("fortran_order is neither True nor False; save it with numpy.save".into()));
    };
    let mut values = Vec::with_capacity(data.len() / size);
    for i in 0..data.len() / size {
        let at = if fortran {
            let (x, y, z) = (i / (ny * nz), i / nz % ny, i % nz);
            (z * ny + y) * nx + x
        } else {
            i
        };
        let value = value(kind, big, &data[at * size..(at + 1) * size]);
        if !(value.is_finite() && value >= 0.0 && value <= f32::MAX as f64) {
            let (x, y, z) = (i / (ny * nz), i / nz % ny, i % nz);
            return Err(Fault::new(
                file,
                format!("[{x}, {y}, {z}]"),
                format!("{value} is no {word}; give finite values from 0"),
            ));
        }
        values.push(value as f32);
    }
    Ok(Array { shape, values })
}

/// Kind letter, bytes an element, big-endian.
fn element(header: &str) -> Result<(char, usize, bool), String> {
    let odd = |d: &str| format!("elements of type '{d}' are not read; convert with array.astype('f4')");
    let descr = header
        .split_once("'descr':")
        .and_then(|(_, rest)| rest.strip_prefix('\'')?.split_once('\''))
        .map(|(d, _)| d)
        .ok_or_else(|| odd("a structure"))?;
    let big = descr.starts_with('>');
    let kind = match descr.trim_start_matches(['<', '>', '|', '=']) {
        "b1" => ('u', 1),
        "u1" => ('u', 1),
        "u2" => ('u', 2),
        "u4" => ('u', 4),
        "u8" => ('u', 8),
        "i1" => ('i', 1),
        "i2" => ('i', 2),
        "i4" => ('i', 4),
        "i8" => ('i', 8),
        "f2" => ('f', 2),
        "f4" => ('f', 4),
        "f8" => ('f', 8),
        _ => return Err(odd(descr)),
    };
    Ok((kind.0, kind.1, big))
}

fn shape(header: &str) -> Result<[usize; 3], String> {
    let odd = || "the shape cannot be read; save it with numpy.save".to_string();
    let inside = header.split_once("'shape':(").and_then(|(_, rest)| rest.split_once(')')).ok_or_else(odd)?.0;
    let dims: Result<Vec<usize>, _> = inside.split(',').filter(|d| !d.is_empty()).map(str::parse).collect();
    let dims = dims.map_err(|_| odd())?;
    <[usize; 3]>::try_from(dims.as_slice())
        .map_err(|_| format!("the array has {} axes; give one of shape [nx, ny, nz]", dims.len()))
}

fn value(kind: char, big: bool, bytes: &[u8]) -> f64 {
    let push = |n: u64, b: &u8| n << 8 | *b as u64;
    let bits = if big { bytes.iter().fold(0, push) } else { bytes.iter().rev().fold(0, push) };
    let unused = 64 - 8 * bytes.len() as u32;
    match (kind, bytes.len()) {
        ('f', 2) => half(bits as u16),
        ('f', 4) => f32::from_bits(bits as u32) as f64,
        ('f', _) => f64::from_bits(bits),
        ('i', _) => ((bits << unused) as i64 >> unused) as f64,
        _ => bits as f64,
    }
}

/// IEEE 754 binary16.
pub(crate) fn half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 != 0 { -1.0 } else { 1.0 };
    let (exponent, fraction) = ((bits >> 10 & 31) as i32, (bits & 1023) as f64);
    match exponent {
        0 => sign * fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => sign * f64::INFINITY,
        31 => f64::NAN,
        _ => sign * (1.0 + fraction / 1024.0) * 2f64.powi(exponent - 15),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_and_integers() {
        assert_eq!(half(0x3c00), 1.0);
        assert_eq!(half(0xc500), -5.0);
        assert_eq!(half(0x0001), 2f64.powi(-24));
        assert_eq!(half(0x7bff), 65504.0);
        assert!(half(0x7e00).is_nan() && half(0x7c00).is_infinite());
        assert_eq!(value('i', false, &[0xfe, 0xff]), -2.0);
        assert_eq!(value('i', true, &[0x01, 0x00]), 256.0);
        assert_eq!(value('u', false, &[0xff]), 255.0);
        assert_eq!(value('f', true, &1.5f64.to_be_bytes()), 1.5);
    }
}
