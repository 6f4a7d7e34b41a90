//! View3D's formats of results.
//!
//! The header is `View3D VERSION out encl emit n`, filled with blanks to 30 characters; a line end follows in text, a carriage return and a line feed in
//! the binary format. Rows are factors from one surface; areas, factors and emissivities of the binary format are little-endian single-precision numbers.

use super::table::ViewFactorTable;
use crate::output::atomic::write_atomic;
use crate::output::error::FileError;
use std::io::{self, Write};
use std::path::Path;

/// Version of View3D whose formats these are.
const FORMAT_VERSION: &str = "4.0.0";
/// Characters of the header before its line end.
const HEADER_CHARS: usize = 30;
/// Significant digits of areas.
const AREA_DIGITS: i32 = 6;

/// The header of View3D's format `out`, without its line end.
fn header(out: u8, table: &ViewFactorTable<'_>) -> String {
    let (encl, emit, n) = (u8::from(table.enclosure), u8::from(table.scripted), table.len());
    format!("{:<HEADER_CHARS$}", format!("View3D {FORMAT_VERSION} {out} {encl} {emit} {n}"))
}

/// Writes the text format.
pub(super) fn write_text(path: &Path, table: &ViewFactorTable<'_>) -> Result<(), FileError> {
    write_atomic(path, |out| {
        writeln!(out, "{}", header(0, table))?;
        write_line(out, table.areas.iter().map(|a| six_digits(*a)))?;
        for i in 0..table.len() {
            write_line(out, full_row(table, i).map(|f| format!("{f:.6}")))?;
        }
        write_line(out, table.emissivities.iter().map(|e| format!("{e:.3}")))
    })
}

/// Writes the binary format.
pub(super) fn write_binary(path: &Path, table: &ViewFactorTable<'_>) -> Result<(), FileError> {
    write_atomic(path, |out| {
        write!(out, "{}\r\n", header(1, table))?;
        write_singles(out, table.areas.iter().copied())?;
        for i in 0..table.len() {
            write_singles(out, full_row(table, i))?;
        }
        write_singles(out, table.emissivities.iter().copied())
    })
}

/// Writes sparse text; factors of zero are left out.
pub(super) fn write_sparse_text(path: &Path, table: &ViewFactorTable<'_>) -> Result<(), FileError> {
    write_atomic(path, |out| {
        for i in 0..table.len() {
            for (j, f, _) in table.row(i).filter(|entry| entry.1 != 0.0) {
                writeln!(out, "{} {} {f:e}", i + 1, j + 1)?;
            }
        }
        Ok(())
    })
}

/// All n factors of a row.
fn full_row<'a>(table: &ViewFactorTable<'a>, i: usize) -> impl Iterator<Item = f64> + use<'a> {
    let mut stored = table.row(i).peekable();
    (0..table.len()).map(move |j| stored.next_if(|entry| entry.0 == j).map_or(0.0, |entry| entry.1))
}

/// Writes numbers in single precision.
fn write_singles(out: &mut impl Write, mut values: impl Iterator<Item = f64>) -> io::Result<()> {
    values.try_for_each(|x| out.write_all(&(x as f32).to_le_bytes()))
}

/// Writes words with one blank between them.
fn write_line(out: &mut impl Write, words: impl Iterator<Item = String>) -> io::Result<()> {
    for (k, word) in words.enumerate() {
        let blank = if k == 0 { "" } else { " " };
        write!(out, "{blank}{word}")?;
    }
    writeln!(out)
}

/// A number as C's `%g`: six significant digits, without zeros at the end; an exponent below 1e-4 and from 1e6.
fn six_digits(x: f64) -> String {
    let scientific = format!("{x:.*e}", AREA_DIGITS as usize - 1);
    let Some((mantissa, exponent)) = scientific.split_once('e') else { return scientific };
    let exponent: i32 = exponent.parse().unwrap_or_default();
    let without_zeros = |text: &str| {
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_string()
        } else {
            text.to_string()
        }
    };
    if (-4..AREA_DIGITS).contains(&exponent) {
        return without_zeros(&format!("{x:.*}", (AREA_DIGITS - 1 - exponent) as usize));
    }
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{}e{sign}{:02}", without_zeros(mantissa), exponent.abs())
}

#[cfg(test)]
mod tests {
    use super::six_digits;

    #[test]
    fn areas_are_written_as_by_printf() {
        let cases = [
            (1.0, "1"),
            (0.0, "0"),
            (12.5, "12.5"),
            (1.0 / 3.0, "0.333333"),
            (123_456.0, "123456"),
            (999_999.5, "1e+06"),
            (1_234_567.0, "1.23457e+06"),
            (0.000_123_456_78, "0.000123457"),
            (0.000_012_3, "1.23e-05"),
            (100.0, "100"),
        ];
        for (x, wanted) in cases {
            assert_eq!(six_digits(x), wanted, "{x}");
        }
    }
}
