//! View factors as CSV and MatrixMarket.

use super::table::ViewFactorTable;
use crate::output::atomic::write_atomic;
use crate::output::csv::csv_name;
use crate::output::error::FileError;
use std::io::Write;
use std::path::Path;

/// Writes the columns from, to, name_from, name_to, factor, radius; each surface ends with its rows of sky and ground.
pub(super) fn write_csv(path: &Path, table: &ViewFactorTable<'_>) -> Result<(), FileError> {
    let names: Vec<String> = table.names.iter().map(|n| csv_name(n)).collect();
    write_atomic(path, |out| {
        writeln!(out, "from,to,name_from,name_to,factor,radius")?;
        for (i, name) in names.iter().enumerate() {
            for (j, f, radius) in table.row(i) {
                writeln!(out, "{i},{j},{name},{},{f:e},{radius:e}", names[j])?;
            }
            writeln!(out, "{i},sky,{name},sky,{:e},{:e}", table.sky[i], table.sky_radii[i])?;
            writeln!(out, "{i},ground,{name},ground,{:e},{:e}", table.ground[i], table.ground_radii[i])?;
        }
        Ok(())
    })
}

/// Writes all stored factors in coordinate form, counted from 1.
pub(super) fn write_matrix_market(path: &Path, table: &ViewFactorTable<'_>) -> Result<(), FileError> {
    let n = table.len();
    let kind = if table.scripted { "grey exchange factor (script F)" } else { "view factor" };
    write_atomic(path, |out| {
        writeln!(out, "%%MatrixMarket matrix coordinate real general")?;
        writeln!(out, "% Row i, column j: {kind} from surface i to surface j.")?;
        writeln!(
            out,
            "% Factors to the sky and to the ground are not in this file; .npz and .csv have them."
        )?;
        writeln!(out, "{n} {n} {}", table.values.len())?;
        for i in 0..n {
            table.row(i).try_for_each(|(j, f, _)| writeln!(out, "{} {} {f:e}", i + 1, j + 1))?;
        }
        Ok(())
    })
}
