//! View factors as an npz that `scipy.sparse.load_npz` reads as a matrix of compressed rows (CSR).
//!
//! | array | shape | contents |
//! |---|---|---|
//! | `format` | () | `csr` |
//! | `shape` | (2) | n, n |
//! | `data`, `indices`, `indptr` | (stored), (stored), (n + 1) | factors, columns, row starts |
//! | `radii` | (stored) | error radii of the factors, single precision |
//! | `areas`, `emissivities` | (n) | m², 1 |
//! | `sky`, `sky_radii`, `ground`, `ground_radii` | (n) | factors to sky and ground, and their error radii |
//! | `defects` | (n) | row sum minus one before closing |
//! | `names` | (n) | names, at most 256 characters of each |

use super::table::ViewFactorTable;
use crate::output::atomic::write_atomic;
use crate::output::error::FileError;
use crate::output::npz::writer::NpzWriter;
use std::path::Path;
use zonal_scene::{BandSet, printable};

/// Most characters of a name: every name of an array of numpy takes the space of the longest.
const MAX_NAME_CHARS: usize = 256;

/// Writes the npz.
pub(super) fn write(path: &Path, table: &ViewFactorTable<'_>) -> Result<(), FileError> {
    let n = table.len();
    write_atomic(path, |out| {
        let mut npz = NpzWriter::new(out, &BandSet::default());
        npz.ascii("format", "csr")?;
        npz.ints("shape", 2, |_| n)?;
        npz.reals("data", table.values.len(), |k| table.values[k])?;
        npz.short_ints("indices", table.columns.len(), |k| table.columns[k] as i32)?;
        npz.ints("indptr", table.row_starts.len(), |i| table.row_starts[i] as usize)?;
        npz.singles("radii", &[table.radii.len()], |k| table.radii[k])?;
        let columns = [
            ("areas", table.areas),
            ("emissivities", table.emissivities),
            ("sky", table.sky),
            ("sky_radii", table.sky_radii),
            ("ground", table.ground),
            ("ground_radii", table.ground_radii),
            ("defects", table.defects),
        ];
        for (name, values) in columns {
            npz.reals(name, values.len(), |i| values[i])?;
        }
        npz.texts("names", table.names, MAX_NAME_CHARS, printable)?;
        npz.finish()
    })
}
