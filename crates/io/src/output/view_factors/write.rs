//! Writing of view factors in a chosen format.

use super::table::ViewFactorTable;
use super::{npz, text, view3d};
use crate::output::error::FileError;
use std::path::Path;

/// A file format of view factors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewFactorFormat {
    /// View3D's `out = 0`: header, areas, all n × n factors with six decimals, emissivities.
    View3dText,
    /// View3D's `out = 1`: a header of 32 bytes, then areas, all n × n factors and emissivities in single precision.
    View3dBinary,
    /// `out = 2` of uDALES's View3D: lines of row, column and factor above zero, counted from 1.
    SparseText,
    /// A matrix that `scipy.sparse.load_npz` reads, and arrays of errors, areas and names.
    Npz,
    /// A line for each factor: from, to (from 0, or sky, ground), their names, factor, radius.
    Csv,
    /// MatrixMarket, coordinate real general.
    MatrixMarket,
}

/// Writes view factors. Sparse text, CSV and MatrixMarket have all digits of the factors.
///
/// # Errors
///
/// The arrays do not fit together, or the file cannot be written.
///
/// ```
/// use zonal_io::output::{ViewFactorFormat, ViewFactorTable, write_view_factors};
///
/// let table = ViewFactorTable {
///     areas: &[1.0, 2.0],
///     emissivities: &[0.9, 0.9],
///     names: &["floor".to_string(), "lid".to_string()],
///     row_starts: &[0, 1, 2],
///     columns: &[1, 0],
///     values: &[0.5, 0.25],
///     radii: &[1e-6, 1e-6],
///     sky: &[0.5, 0.75],
///     sky_radii: &[1e-6, 1e-6],
///     ground: &[0.0, 0.0],
///     ground_radii: &[0.0, 0.0],
///     defects: &[0.0, 0.0],
///     enclosure: false,
///     scripted: false,
/// };
/// let path = std::env::temp_dir().join(format!("zonal-doc-factors-{}.txt", std::process::id()));
/// write_view_factors(&path, ViewFactorFormat::SparseText, &table)?;
/// assert_eq!(std::fs::read_to_string(&path).unwrap(), "1 2 5e-1\n2 1 2.5e-1\n");
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), zonal_io::output::FileError>(())
/// ```
pub fn write_view_factors(
    path: &Path,
    format: ViewFactorFormat,
    table: &ViewFactorTable<'_>,
) -> Result<(), FileError> {
    table.check().map_err(|message| FileError::new(path, "", message))?;
    match format {
        ViewFactorFormat::View3dText => view3d::write_text(path, table),
        ViewFactorFormat::View3dBinary => view3d::write_binary(path, table),
        ViewFactorFormat::SparseText => view3d::write_sparse_text(path, table),
        ViewFactorFormat::Npz => npz::write(path, table),
        ViewFactorFormat::Csv => text::write_csv(path, table),
        ViewFactorFormat::MatrixMarket => text::write_matrix_market(path, table),
    }
}
