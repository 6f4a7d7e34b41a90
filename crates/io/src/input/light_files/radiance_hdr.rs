//! Pictures in the format of Radiance (.hdr, .pic): shared exponents, runs of equal bytes.
//!
//! A header of lines ends with an empty line; `EXPOSURE` factors have been applied to the pixels and are divided out. The resolution `-Y h +X w` follows, then the rows from the
//! top. A pixel of mantissas m and exponent e has the values (m + ½) 2^(e − 136), and 0 for e = 0 (Ward, "Real Pixels", Graphics Gems II, 1991). Rows hold pixels of four bytes, with
//! runs of equal pixels in old files; or, after the bytes 2, 2 and the width, the four components one after the other, each in runs of equal bytes and of other bytes.

use zonal_scene::Texture;

/// Largest number of pixels along one side, and of all.
const MAX_SIDE_PIXELS: usize = 32_767;
const MAX_PIXELS: usize = 1 << 26;
/// Largest number of pixels for each byte of a file: a run of four bytes stands for 255 pixels times its shift.
const MAX_PIXELS_PER_BYTE: usize = 255;
/// Widths of rows that may be stored by component.
const COMPONENT_WIDTHS: std::ops::RangeInclusive<usize> = 8..=MAX_SIDE_PIXELS;
/// Exponent of the unit of the mantissas.
const EXPONENT_BIAS: i32 = 136;

/// Decodes a picture; an error states the defect and the remedy.
pub(crate) fn decode(bytes: &[u8]) -> Result<Texture, String> {
    let mut input = Input { bytes };
    let exposure = read_header(&mut input)?;
    let [width, height] = read_resolution(&mut input)?;
    let count = width.saturating_mul(height);
    if count > MAX_PIXELS || count / MAX_PIXELS_PER_BYTE > bytes.len() {
        return Err(format!(
            "this picture declares {width} × {height} pixels, more than its {} bytes can hold; export it again",
            bytes.len()
        ));
    }
    let mut pixels = Vec::with_capacity(count);
    let mut row = vec![[0u8; 4]; width];
    for y in 0..height {
        read_row(&mut input, &mut row)
            .ok_or_else(|| format!("row {y} of this picture is cut short or damaged; export it again"))?;
        pixels.extend(row.iter().map(|p| value(*p).map(|v| (v / exposure) as f32)));
    }
    Ok(Texture { width, height, pixels })
}

/// The three values of a pixel.
fn value([r, g, b, e]: [u8; 4]) -> [f64; 3] {
    let unit = if e == 0 { 0.0 } else { (f64::from(i32::from(e) - EXPONENT_BIAS)).exp2() };
    [r, g, b].map(|m| (f64::from(m) + 0.5) * unit)
}

/// Bytes that are still to be read.
struct Input<'a> {
    bytes: &'a [u8],
}

impl<'a> Input<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (first, rest) = self.bytes.split_at_checked(n)?;
        self.bytes = rest;
        Some(first)
    }

    fn byte(&mut self) -> Option<u8> {
        self.take(1).map(|b| b[0])
    }

    /// The bytes before the next line feed.
    fn line(&mut self) -> Option<&'a str> {
        let end = self.bytes.iter().position(|b| *b == b'\n')?;
        let line = self.take(end + 1)?;
        std::str::from_utf8(&line[..end]).ok().map(|l| l.trim_end_matches('\r'))
    }
}

/// Reads the header up to its empty line: the product of the exposures.
fn read_header(input: &mut Input<'_>) -> Result<f64, String> {
    let mut exposure = 1.0;
    loop {
        let line = input.line().ok_or("the header of this picture has no end; export it again")?;
        if line.is_empty() {
            return Ok(exposure);
        }
        let (key, text) = line.split_once('=').unwrap_or((line, ""));
        match key.trim() {
            "FORMAT" if text.trim() != "32-bit_rle_rgbe" => {
                return Err(format!(
                    "the pixels of this picture are '{}'; convert it to 32-bit_rle_rgbe or to OpenEXR",
                    text.trim()
                ));
            }
            "EXPOSURE" => match text.trim().parse::<f64>() {
                Ok(x) if x.is_finite() && x > 0.0 => exposure *= x,
                _ => return Err(format!("EXPOSURE = {} is no number above 0; export it again", text.trim())),
            },
            _ => {}
        }
    }
}

/// Width and height.
fn read_resolution(input: &mut Input<'_>) -> Result<[usize; 2], String> {
    let wrong =
        "the resolution of this picture is not '-Y height +X width'; export it with its top row first";
    let line = input.line().ok_or(wrong)?;
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let ["-Y", height, "+X", width] = words.as_slice() else { return Err(wrong.into()) };
    let side = |t: &str| t.parse::<usize>().ok().filter(|n| (1..=MAX_SIDE_PIXELS).contains(n)).ok_or(wrong);
    Ok([side(width)?, side(height)?])
}

/// Reads a row of pixels; `None` if it is damaged.
fn read_row(input: &mut Input<'_>, row: &mut [[u8; 4]]) -> Option<()> {
    let by_component = input.bytes.first() == Some(&2)
        && input.bytes.get(1) == Some(&2)
        && input.bytes.get(2).is_some_and(|b| *b < 128)
        && COMPONENT_WIDTHS.contains(&row.len());
    if !by_component {
        return read_pixels(input, row);
    }
    let &[_, _, high, low] = input.take(4)? else { return None };
    if usize::from(high) << 8 | usize::from(low) != row.len() {
        return None;
    }
    (0..4).try_for_each(|k| read_component(input, row, k))
}

/// One component of a row in runs: more than 128 begins a run of equal bytes, others a number of bytes that follow.
fn read_component(input: &mut Input<'_>, row: &mut [[u8; 4]], k: usize) -> Option<()> {
    let mut x = 0;
    while x < row.len() {
        let count = input.byte()?;
        if count > 128 {
            let (n, v) = (usize::from(count - 128), input.byte()?);
            row.get_mut(x..x + n)?.iter_mut().for_each(|p| p[k] = v);
            x += n;
        } else {
            let values = input.take(usize::from(count))?;
            if values.is_empty() {
                return None;
            }
            row.get_mut(x..x + values.len())?.iter_mut().zip(values).for_each(|(p, v)| p[k] = *v);
            x += values.len();
        }
    }
    Some(())
}

/// A row pixel by pixel: the mantissas 1, 1, 1 repeat the pixel before, as often as the exponent says, in units that grow 256-fold with each such pixel in a row.
fn read_pixels(input: &mut Input<'_>, row: &mut [[u8; 4]]) -> Option<()> {
    let (mut x, mut shift) = (0, 0);
    while x < row.len() {
        let &[r, g, b, e] = input.take(4)? else { return None };
        if [r, g, b] == [1; 3] {
            let n = usize::from(e).checked_shl(shift)?;
            let before = *row.get(x.checked_sub(1)?)?;
            row.get_mut(x..x.checked_add(n)?)?.fill(before);
            (x, shift) = (x + n, shift + 8);
            if shift > 16 {
                return None;
            }
        } else {
            row[x] = [r, g, b, e];
            (x, shift) = (x + 1, 0);
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(resolution: &str, data: &[u8]) -> Vec<u8> {
        [b"#?RADIANCE\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\n\n", resolution.as_bytes(), b"\n", data].concat()
    }

    #[test]
    fn pixels_and_runs_of_both_kinds_are_read() {
        // m = 128 and e = 129 is (128.5)/128; half of it after the exposure.
        let unit = 128.5 / 128.0 / 2.0;
        let flat = decode(&file("-Y 1 +X 2", &[128, 0, 64, 129, 128, 128, 128, 0])).unwrap();
        let expected = [[unit, 0.5 / 256.0, 64.5 / 256.0], [0.0; 3]];
        for (p, q) in flat.pixels.iter().flatten().zip(expected.as_flattened()) {
            assert!((f64::from(*p) - q).abs() < 1e-7, "{p} {q}");
        }
        let old = decode(&file("-Y 1 +X 4", &[128, 128, 128, 129, 1, 1, 1, 3])).unwrap();
        assert!(old.pixels.iter().flatten().all(|v| (f64::from(*v) - unit).abs() < 1e-7), "{old:?}");
        let mut rows = Vec::new();
        for _ in 0..2 {
            rows.extend([2, 2, 0, 8, 136, 128, 3, 128, 128, 128, 133, 128, 136, 128, 136, 129]);
        }
        let new = decode(&file("-Y 2 +X 8", &rows)).unwrap();
        assert!(new.pixels.len() == 16 && new.pixels == vec![new.pixels[0]; 16], "{new:?}");
        assert_eq!(new.pixels[0], old.pixels[0]);
    }

    #[test]
    fn damaged_files_are_refused() {
        let rows = [2, 2, 0, 8, 136, 128, 136, 128, 136, 128, 136, 129];
        let whole = file("-Y 1 +X 8", &rows);
        assert!(decode(&whole).is_ok());
        (0..whole.len()).for_each(|cut| assert!(decode(&whole[..cut]).is_err(), "{cut}"));
        for (i, flip) in (0..whole.len()).flat_map(|i| [1, 0x55, 0xff].map(|f| (i, f))) {
            let mut hurt = whole.clone();
            hurt[i] ^= flip;
            let _ = decode(&hurt);
        }
        for (resolution, word) in [("+Y 1 +X 8", "top row"), ("-Y 30000 +X 30000", "bytes can hold")] {
            let e = decode(&file(resolution, &rows)).unwrap_err();
            assert!(e.contains(word), "{e}");
        }
        let xyz = b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n\0\0\0\0";
        assert!(decode(xyz).unwrap_err().contains("xyze"));
    }
}
