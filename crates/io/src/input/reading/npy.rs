//! Arrays in numpy's npy format, versions 1 to 3: three axes, C or Fortran order, any real type; lists and tables of one or two axes.
//!
//! The reader is written here rather than taken from a crate: every refusal names the file, the element and a remedy, and the declared
//! size is compared with the file's before memory is allocated.
//!
//! Reference: numpy.lib.format, NEP 1.

use super::error::FileFault;

/// Largest array file, bytes.
pub(crate) const MAX_ARRAY_FILE_BYTES: u64 = 4 << 30;

/// A three-dimensional array of finite values from 0, in the precision of its source.
#[derive(Debug)]
pub(crate) struct ScalarArray<'a> {
    pub(crate) shape: [usize; 3],
    order: AxisOrder,
    values: ArrayValues<'a>,
}

/// The axis that runs fastest in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AxisOrder {
    /// The last one.
    LastFastest,
    /// The first one.
    FirstFastest,
}

/// The elements of an array, its own or those of another program.
#[derive(Debug)]
pub(crate) enum ArrayValues<'a> {
    /// Values that single precision holds exactly.
    Owned(Vec<f32>),
    OwnedDouble(Vec<f64>),
    Single(&'a [f32]),
    Double(&'a [f64]),
}

impl ArrayValues<'_> {
    fn len(&self) -> usize {
        match self {
            ArrayValues::Owned(v) => v.len(),
            ArrayValues::OwnedDouble(v) => v.len(),
            ArrayValues::Single(v) => v.len(),
            ArrayValues::Double(v) => v.len(),
        }
    }
    fn at(&self, i: usize) -> f64 {
        match self {
            ArrayValues::Owned(v) => f64::from(v[i]),
            ArrayValues::OwnedDouble(v) => v[i],
            ArrayValues::Single(v) => f64::from(v[i]),
            ArrayValues::Double(v) => v[i],
        }
    }
}

impl<'a> ScalarArray<'a> {
    /// An array of values that were checked, with the last axis fastest.
    pub(crate) fn of_valid(shape: [usize; 3], values: ArrayValues<'static>) -> ScalarArray<'static> {
        ScalarArray { shape, order: AxisOrder::LastFastest, values }
    }
    /// Checks the shape and every value; `noun` names a value in messages.
    pub(crate) fn new(
        file: &str,
        shape: [usize; 3],
        order: AxisOrder,
        values: ArrayValues<'a>,
        noun: &str,
    ) -> Result<ScalarArray<'a>, FileFault> {
        let [nx, ny, nz] = shape;
        let count = shape.iter().try_fold(1usize, |n, d| n.checked_mul(*d));
        if count != Some(values.len()) || values.len() == 0 {
            let message = format!("the shape ({nx}, {ny}, {nz}) does not agree with {} values", values.len());
            return Err(FileFault::new(file, "", format!("{message}; give an array with all its elements")));
        }
        let array = ScalarArray { shape, order, values };
        // The first faulty element in C order.
        for i in 0..array.values.len() {
            let [x, y, z] = [i / (ny * nz), i / nz % ny, i % nz];
            let value = array.values.at(array.place(x, y, z));
            if !(value.is_finite() && value >= 0.0 && value <= f64::from(f32::MAX)) {
                let message = format!("{value} is no {noun}; give finite values from 0");
                return Err(FileFault::new(file, format!("[{x}, {y}, {z}]"), message));
            }
        }
        Ok(array)
    }
    fn place(&self, x: usize, y: usize, z: usize) -> usize {
        let [nx, ny, nz] = self.shape;
        match self.order {
            AxisOrder::LastFastest => (x * ny + y) * nz + z,
            AxisOrder::FirstFastest => (z * ny + y) * nx + x,
        }
    }
    /// The element at these indices.
    pub(crate) fn at(&self, x: usize, y: usize, z: usize) -> f64 {
        self.values.at(self.place(x, y, z))
    }
}

/// Reads a file's bytes; `noun` names a value in messages. The declared size is compared with the file's before memory is allocated.
pub(crate) fn parse(file: &str, bytes: &[u8], noun: &str) -> Result<ScalarArray<'static>, FileFault> {
    let fault = |message: String| FileFault::new(file, "header", message);
    // Read the header.
    let (text, data) = split_header(bytes).map_err(|e| fault(e.into()))?;
    let element = ElementFormat::parse(&text).map_err(fault)?;
    let shape = parse_shape(&text).map_err(fault)?;
    let shape = <[usize; 3]>::try_from(shape.as_slice())
        .map_err(|_| fault(format!("the array has {} axes; give one of shape [nx, ny, nz]", shape.len())))?;
    let [nx, ny, nz] = shape;
    // Compare the declared size with the file's.
    let count = shape.iter().try_fold(1usize, |n, d| n.checked_mul(*d));
    let wanted = count.and_then(|n| n.checked_mul(element.size));
    let Some(data) = wanted.and_then(|n| data.get(..n)) else {
        return Err(fault(format!(
            "the shape ({nx}, {ny}, {nz}) does not agree with the {} bytes of data; save the array again",
            data.len()
        )));
    };
    if data.is_empty() {
        return Err(fault(format!("the shape ({nx}, {ny}, {nz}) has no elements; save an array with some")));
    }
    let fortran = text.contains("'fortran_order':True");
    if !fortran && !text.contains("'fortran_order':False") {
        return Err(fault("fortran_order is neither True nor False; save it with numpy.save".into()));
    }
    // Read the values in C order.
    let size = element.size;
    let value_at = |i: usize| {
        let [x, y, z] = [i / (ny * nz), i / nz % ny, i % nz];
        let at = if fortran { (z * ny + y) * nx + x } else { i };
        let value = element.value(&data[at * size..(at + 1) * size]);
        if !(value.is_finite() && value >= 0.0 && value <= f32::MAX as f64) {
            let message = format!("{value} is no {noun}; give finite values from 0");
            return Err(FileFault::new(file, format!("[{x}, {y}, {z}]"), message));
        }
        Ok(value)
    };
    let indices = 0..data.len() / size;
    let values = if element.is_exact_in_single_precision() {
        ArrayValues::Owned(indices.map(|i| Ok(value_at(i)? as f32)).collect::<Result<_, _>>()?)
    } else {
        ArrayValues::OwnedDouble(indices.map(value_at).collect::<Result<_, _>>()?)
    };
    Ok(ScalarArray::of_valid(shape, values))
}

/// A note about bytes behind the elements of an array of three axes that [`parse`] has read.
pub(crate) fn trailing_note(file: &str, bytes: &[u8]) -> Option<String> {
    let (text, data) = split_header(bytes).ok()?;
    let size = ElementFormat::parse(&text).ok()?.size;
    let count = parse_shape(&text).ok()?.iter().try_fold(size, |n, d| n.checked_mul(*d))?;
    let excess = data.len().checked_sub(count).filter(|n| *n > 0)?;
    Some(format!("{file}: {excess} byte(s) behind the elements of the array were not read"))
}

/// The dictionary of a file's header, without blanks, and the bytes of the data.
fn split_header(bytes: &[u8]) -> Result<(String, &[u8]), &'static str> {
    const CUT_SHORT: &str = "the file is cut short; save it again with numpy.save";
    if !bytes.starts_with(b"\x93NUMPY") {
        return Err("this is not an npy array; save it with numpy.save");
    }
    let number = |range: std::ops::Range<usize>| {
        let little_endian = |n: usize, b: &u8| n << 8 | *b as usize;
        bytes.get(range).map(|b| b.iter().rev().fold(0, little_endian)).ok_or(CUT_SHORT)
    };
    let (start, length) = match bytes.get(6) {
        Some(1) => (10, number(8..10)?),
        Some(2 | 3) => (12, number(8..12)?),
        _ => return Err("this npy version is not read; save it with numpy.save"),
    };
    let text = String::from_utf8_lossy(bytes.get(start..start + length).ok_or(CUT_SHORT)?);
    Ok((text.chars().filter(|c| !c.is_whitespace()).collect(), &bytes[start + length..]))
}

/// The type of an element.
#[derive(Clone, Copy)]
pub(crate) struct ElementFormat {
    /// `u`, `i` or `f`.
    pub(crate) kind: char,
    /// Bytes of an element.
    pub(crate) size: usize,
    pub(crate) big_endian: bool,
}

impl ElementFormat {
    /// The type that a header's dictionary names.
    fn parse(header: &str) -> Result<ElementFormat, String> {
        let unread =
            |d: &str| format!("elements of type '{d}' are not read; convert with array.astype('f4')");
        let descr = header
            .split_once("'descr':")
            .and_then(|(_, rest)| rest.strip_prefix('\'')?.split_once('\''))
            .map(|(d, _)| d)
            .ok_or_else(|| unread("a structure"))?;
        let (kind, size) = match descr.trim_start_matches(['<', '>', '|', '=']) {
            "b1" | "u1" => ('u', 1),
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
            _ => return Err(unread(descr)),
        };
        Ok(ElementFormat { kind, size, big_endian: descr.starts_with('>') })
    }

    /// True if single precision holds every value of the type: floats of up to four bytes, integers of up to two.
    fn is_exact_in_single_precision(self) -> bool {
        self.size <= if self.kind == 'f' { 4 } else { 2 }
    }

    /// The value of an element's bytes.
    pub(crate) fn value(self, bytes: &[u8]) -> f64 {
        let push = |n: u64, b: &u8| n << 8 | *b as u64;
        let bits =
            if self.big_endian { bytes.iter().fold(0, push) } else { bytes.iter().rev().fold(0, push) };
        let unused = 64 - 8 * bytes.len() as u32;
        match (self.kind, bytes.len()) {
            ('f', 2) => half_to_f64(bits as u16),
            ('f', 4) => f32::from_bits(bits as u32) as f64,
            ('f', _) => f64::from_bits(bits),
            ('i', _) => ((bits << unused) as i64 >> unused) as f64,
            _ => bits as f64,
        }
    }
}

/// The shape that a header's dictionary gives.
fn parse_shape(header: &str) -> Result<Vec<usize>, String> {
    let unreadable = || "the shape cannot be read; save it with numpy.save".to_string();
    let inside =
        header.split_once("'shape':(").and_then(|(_, rest)| rest.split_once(')')).ok_or_else(unreadable)?.0;
    let dims: Result<Vec<usize>, _> = inside.split(',').filter(|d| !d.is_empty()).map(str::parse).collect();
    dims.map_err(|_| unreadable())
}

/// A list of n numbers, or a table of n rows in C order: the number of columns, and the numbers row by row. They may be any number, NaN included.
pub(crate) fn parse_rows(file: &str, bytes: &[u8]) -> Result<(usize, Vec<f64>), FileFault> {
    let fault = |message: String| FileFault::new(file, "header", message);
    let (text, data) = split_header(bytes).map_err(|e| fault(e.into()))?;
    let element = ElementFormat::parse(&text).map_err(fault)?;
    let shape = parse_shape(&text).map_err(fault)?;
    let (rows, columns) = match shape[..] {
        [n] => (n, 1),
        [n, k] => (n, k),
        _ => {
            return Err(fault(format!(
                "the array has {} axes; give a list, or a table of rows and columns",
                shape.len()
            )));
        }
    };
    if text.contains("'fortran_order':True") && columns > 1 && rows > 1 {
        return Err(fault("the table is in Fortran order; save numpy.ascontiguousarray(array)".into()));
    }
    if rows.checked_mul(columns).and_then(|n| n.checked_mul(element.size)) != Some(data.len()) {
        return Err(fault(format!(
            "the shape ({rows}, {columns}) does not agree with the {} bytes of data; save the array again",
            data.len()
        )));
    }
    Ok((columns, data.chunks_exact(element.size).map(|c| element.value(c)).collect()))
}

/// The value of IEEE 754 binary16 bits.
pub(crate) fn half_to_f64(bits: u16) -> f64 {
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
    fn halves_and_integers_have_their_values() {
        assert_eq!(half_to_f64(0x3c00), 1.0);
        assert_eq!(half_to_f64(0xc500), -5.0);
        assert_eq!(half_to_f64(0x0001), 2f64.powi(-24));
        assert_eq!(half_to_f64(0x7bff), 65504.0);
        assert!(half_to_f64(0x7e00).is_nan() && half_to_f64(0x7c00).is_infinite());
        let value = |descr: &str, bytes: &[u8]| {
            ElementFormat::parse(&format!("'descr':'{descr}'")).unwrap().value(bytes)
        };
        assert_eq!(value("<i2", &[0xfe, 0xff]), -2.0);
        assert_eq!(value(">i2", &[0x01, 0x00]), 256.0);
        assert_eq!(value("|u1", &[0xff]), 255.0);
        assert_eq!(value(">f8", &1.5f64.to_be_bytes()), 1.5);
    }
}
