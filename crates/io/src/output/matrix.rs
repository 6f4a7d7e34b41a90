//! Symmetric matrices as text: MatrixMarket files, and tables of pairs.
//!
//! Reference: Boisvert, Pozo and Remington, The Matrix Market Exchange Formats, NISTIR 5935 (1996).

use super::atomic::write_atomic;
use super::csv::csv_name;
use super::error::FileError;
use std::io::Write;
use std::path::Path;
use zonal_scene::printable_lines;

/// Writes a symmetric matrix of `n` rows in coordinate form: the entries of the lower half that are not zero, counted from 1. `comments` are lines of the
/// header.
///
/// # Errors
///
/// The file cannot be written.
pub fn write_matrix_market(
    path: &Path,
    comments: &[String],
    n: usize,
    matrix: &[f64],
) -> Result<(), FileError> {
    let entries = || {
        let rows = matrix.chunks_exact(n.max(1)).enumerate();
        rows.flat_map(|(i, row)| {
            row[..=i].iter().enumerate().map(move |(j, x)| (i, j, *x)).filter(|e| e.2 != 0.0)
        })
    };
    write_atomic(path, |out| {
        writeln!(out, "%%MatrixMarket matrix coordinate real symmetric")?;
        for line in comments {
            writeln!(out, "% {}", printable_lines(line).replace('\n', " "))?;
        }
        writeln!(out, "{n} {n} {}", entries().count())?;
        entries().try_for_each(|(i, j, x)| writeln!(out, "{} {} {x:e}", i + 1, j + 1))
    })
}

/// A symmetric matrix of a table of pairs.
pub struct PairColumn<'a> {
    /// Heading.
    pub name: &'a str,
    /// Matrices of all bands, one after the other, row by row.
    pub values: &'a [f64],
}

/// Writes a line for each unordered pair of zones of which some value is not zero: band, both zones (from 0), their names, and the values.
///
/// # Errors
///
/// The file cannot be written.
pub fn write_pairs_csv(
    path: &Path,
    names: &[String],
    name_of_zone: &[usize],
    columns: &[PairColumn],
) -> Result<(), FileError> {
    let names: Vec<String> = names.iter().map(|n| csv_name(n)).collect();
    let n = name_of_zone.len();
    let bands = columns.first().map_or(0, |c| c.values.len() / (n * n).max(1));
    write_atomic(path, |out| {
        write!(out, "band,zone_i,zone_j,name_i,name_j")?;
        columns.iter().try_for_each(|c| write!(out, ",{}", c.name))?;
        writeln!(out)?;
        for k in 0..bands * n * n {
            let (b, i, j) = (k / (n * n), k / n % n, k % n);
            if j > i || columns.iter().all(|c| c.values[k] == 0.0) {
                continue;
            }
            write!(out, "{b},{i},{j},{},{}", names[name_of_zone[i]], names[name_of_zone[j]])?;
            columns.iter().try_for_each(|c| write!(out, ",{:e}", c.values[k]))?;
            writeln!(out)?;
        }
        Ok(())
    })
}
