//! Columns of values by face, by zone, or by name, from CSV, npy, or the cell data of a VTK file.
//!
//! | extension | rows | column |
//! |---|---|---|
//! | `.csv`, `.txt`, `.dat` | one line each; a first line without numbers is a header | by name in the header, or by number from 1 |
//! | `.npy` | a list, or the rows of a table | by number from 1 |
//! | `.vtu`, `.vtp` | one cell each | an array of cell data, by name |
//!
//! Without a column, the file has one column of values, or one whose name is that of the quantity.

mod quantity;
pub(crate) mod spectrum;
mod text;
mod value_table;

pub use quantity::Quantity;
pub(crate) use value_table::WantedColumn;
pub use value_table::{RowKeys, ValueTable};

use super::memory_arrays;
use super::vtk::{MAX_VTK_FILE_BYTES, VtkFile};
use crate::files::FileSource;
use crate::input::reading::error::{FileFault, InputError};
use crate::input::reading::npy;
use crate::memory_arrays::MemoryArray;
use std::path::Path;
use value_table::MAX_LISTED_COLUMNS;

/// Largest text of a table, bytes.
const MAX_TABLE_FILE_BYTES: u64 = 1 << 30;

/// Reads a column of values from a file on disk.
///
/// # Errors
///
/// The file cannot be read, has no such column, or a value that is not a number or beyond the range of the quantity.
///
/// ```
/// use zonal_io::input::{Quantity, RowKeys, read_values};
///
/// let path = std::env::temp_dir().join(format!("zonal-doc-table-{}.csv", std::process::id()));
/// std::fs::write(&path, "face,T\n0,300\n1,400\n")?;
/// let table = read_values(&path, Some("T"), Quantity::Temperature, RowKeys::Position)?;
/// assert_eq!(table.values(), [300.0, 400.0]);
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_values(
    path: &Path,
    column: Option<&str>,
    quantity: Quantity,
    rows: RowKeys,
) -> Result<ValueTable, InputError> {
    let wanted = WantedColumn { column, quantity, rows };
    let name = path.display().to_string();
    read_column(FileSource::DISK, path, &name, wanted).map_err(FileFault::into_error)
}

/// Reads a column of a file; `file` names it in messages.
pub(crate) fn read_column(
    files: FileSource<'_>,
    path: &Path,
    file: &str,
    wanted: WantedColumn<'_>,
) -> Result<ValueTable, FileFault> {
    ColumnFile::read(files, path, file)?.column(wanted)
}

/// A file of columns that was read.
pub(crate) struct ColumnFile<'a> {
    /// Its name in messages.
    file: &'a str,
    contents: ColumnContents<'a>,
}

enum ColumnContents<'a> {
    Memory(MemoryArray<'a>),
    Npy(Vec<u8>),
    Vtk(Vec<u8>),
    Text(Vec<u8>),
}

impl<'a> ColumnFile<'a> {
    /// Reads a file; `file` names it in messages.
    pub(crate) fn read(
        files: FileSource<'a>,
        path: &Path,
        file: &'a str,
    ) -> Result<ColumnFile<'a>, FileFault> {
        if let Some(memory) = files.array(path) {
            return Ok(ColumnFile { file, contents: ColumnContents::Memory(memory) });
        }
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        let fault = |message: String| FileFault::new(file, "", message);
        let bytes = |limit| files.read(path, limit).map_err(fault);
        let contents = match extension.as_str() {
            "csv" | "txt" | "dat" => ColumnContents::Text(bytes(MAX_TABLE_FILE_BYTES)?),
            "npy" => ColumnContents::Npy(bytes(npy::MAX_ARRAY_FILE_BYTES)?),
            "vtu" | "vtp" => ColumnContents::Vtk(bytes(MAX_VTK_FILE_BYTES)?),
            _ => return Err(fault("this kind of table is not read; give .csv, .npy, .vtu or .vtp".into())),
        };
        Ok(ColumnFile { file, contents })
    }

    /// One of its columns.
    pub(crate) fn column(&self, wanted: WantedColumn<'_>) -> Result<ValueTable, FileFault> {
        let file = self.file;
        let table = match &self.contents {
            ColumnContents::Memory(memory) => {
                refuse_names(file, wanted)?;
                let values = memory_arrays::faces(memory, file)?;
                ValueTable { file: file.into(), names: None, values, lines: Vec::new(), is_array: true }
            }
            ColumnContents::Npy(bytes) => npy_column(file, bytes, wanted)?,
            ColumnContents::Vtk(bytes) => vtk_column(file, bytes, wanted)?,
            ColumnContents::Text(bytes) => text::read(file, bytes, wanted)?,
        };
        table.checked(wanted.quantity)
    }
}

/// Refuses files without names where rows have names.
fn refuse_names(file: &str, wanted: WantedColumn<'_>) -> Result<(), FileFault> {
    match wanted.rows {
        RowKeys::Name => {
            Err(FileFault::new(file, "", "this file has no names; give a .csv with the columns name, value"))
        }
        _ => Ok(()),
    }
}

fn npy_column(file: &str, bytes: &[u8], wanted: WantedColumn<'_>) -> Result<ValueTable, FileFault> {
    refuse_names(file, wanted)?;
    let (columns, values) = npy::parse_rows(file, bytes)?;
    let names: Vec<String> = (1..=columns.min(MAX_LISTED_COLUMNS)).map(|k| k.to_string()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let all: Vec<usize> = (0..names.len()).collect();
    let chosen = wanted.choose(&names, &all).map_err(|e| FileFault::new(file, "", e))?;
    let values = values.chunks_exact(columns.max(1)).map(|row| row[chosen]).collect();
    Ok(ValueTable { file: file.into(), names: None, values, lines: Vec::new(), is_array: false })
}

fn vtk_column(file: &str, bytes: &[u8], wanted: WantedColumn<'_>) -> Result<ValueTable, FileFault> {
    refuse_names(file, wanted)?;
    let vtk = VtkFile::parse(file, bytes)?;
    let names = vtk.cell_array_names();
    let all: Vec<usize> = (0..names.len()).collect();
    let chosen = wanted
        .choose(&names, &all)
        .map_err(|e| FileFault::new(file, "", format!("among the arrays of cell data {e}")))?;
    let values = vtk.cell_values(names[chosen])?;
    Ok(ValueTable { file: file.into(), names: None, values, lines: Vec::new(), is_array: false })
}
