//! The npy format, version 1.0: magic, a Python dictionary with type and shape, then a C-ordered little-endian array.

use std::borrow::Cow;

/// The element types of the arrays of this program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ElementType {
    /// `<f8`
    F64,
    /// `<f4`
    F32,
    /// `<i8`
    I64,
    /// `<i4`
    I32,
    /// `|u1`
    U8,
    /// `|Sn`: n bytes of text.
    Ascii(usize),
    /// `<Un`: n characters of four bytes, filled with zeros.
    Text(usize),
}

impl ElementType {
    /// numpy's name.
    pub(super) fn descr(self) -> Cow<'static, str> {
        match self {
            ElementType::F64 => "<f8".into(),
            ElementType::F32 => "<f4".into(),
            ElementType::I64 => "<i8".into(),
            ElementType::I32 => "<i4".into(),
            ElementType::U8 => "|u1".into(),
            ElementType::Ascii(n) => format!("|S{n}").into(),
            ElementType::Text(n) => format!("<U{n}").into(),
        }
    }
    /// Bytes of an element.
    pub(super) fn size(self) -> usize {
        match self {
            ElementType::F64 | ElementType::I64 => 8,
            ElementType::F32 | ElementType::I32 => 4,
            ElementType::U8 => 1,
            ElementType::Ascii(n) => n,
            ElementType::Text(n) => 4 * n,
        }
    }
}

/// The header of an array, padded so that the data start at a multiple of 64.
pub(crate) fn header(kind: ElementType, shape: &[usize]) -> Vec<u8> {
    let dims: Vec<String> = shape.iter().map(|d| format!("{d},")).collect();
    let mut text =
        format!("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", kind.descr(), dims.join(" "));
    while (10 + text.len() + 1) % 64 != 0 {
        text.push(' ');
    }
    text.push('\n');
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((text.len() as u16).to_le_bytes());
    out.extend(text.as_bytes());
    out
}

/// The shape and the data of a C-ordered array of `kind` whose size agrees with its shape.
pub(super) fn parse(bytes: &[u8], kind: ElementType) -> Result<(Vec<usize>, &[u8]), String> {
    let head = bytes.get(..10).ok_or("is cut short; copy or solve it again")?;
    if &head[..6] != b"\x93NUMPY" {
        return Err("is not an npy array; the file is damaged or comes from another program".into());
    }
    let (start, len) = match head[6] {
        1 => (10, u16::from_le_bytes([head[8], head[9]]) as usize),
        _ => return Err("has an npy version other than 1.0; save it with numpy.savez again".into()),
    };
    let text = bytes
        .get(start..start + len)
        .and_then(|t| std::str::from_utf8(t).ok())
        .ok_or("has a damaged npy header")?;
    let squeezed: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    if !squeezed.contains(&format!("'descr':'{}'", kind.descr())) {
        return Err(format!("has elements of another type than {}", kind.descr()));
    }
    if !squeezed.contains("'fortran_order':False") {
        return Err("is in Fortran order; save it in C order".into());
    }
    let shape = parse_shape(&squeezed).ok_or("has a shape that cannot be read")?;
    let data = &bytes[start + len..];
    let wanted = shape
        .iter()
        .try_fold(kind.size(), |n, &d| n.checked_mul(d))
        .ok_or("declares a shape that no machine can hold")?;
    if wanted != data.len() {
        return Err(format!(
            "declares {wanted} bytes but has {}; the file is cut short or damaged",
            data.len()
        ));
    }
    Ok((shape, data))
}

/// The shape that a header without blanks gives.
fn parse_shape(squeezed: &str) -> Option<Vec<usize>> {
    let rest = squeezed.split_once("'shape':(")?.1;
    let inside = rest.split_once(')')?.0;
    inside.split(',').filter(|d| !d.is_empty()).map(|d| d.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_are_aligned_and_round_trip() {
        for shape in [vec![], vec![3], vec![2, 3], vec![0, 3], vec![4, 5, 6, 3]] {
            let mut file = header(ElementType::F64, &shape);
            assert_eq!(file.len() % 64, 0);
            file.resize(file.len() + 8 * shape.iter().product::<usize>(), 0);
            assert_eq!(parse(&file, ElementType::F64).unwrap().0, shape);
            assert!(parse(&file, ElementType::I64).is_err());
            file.push(0);
            assert!(parse(&file, ElementType::F64).is_err());
        }
        assert!(parse(b"\x93NUM", ElementType::U8).is_err());
        let mut huge = header(ElementType::F64, &[usize::MAX, 3]);
        huge.push(0);
        assert!(parse(&huge, ElementType::F64).is_err());
    }
}
