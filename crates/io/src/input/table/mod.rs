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
mod text;

pub use quantity::Quantity;

use super::error::{FileFault, InputError};
use super::vtk::{MAX_VTK_FILE_BYTES, VtkFile};
use super::{npy, suggestion};
use crate::files::FileSource;
use std::path::Path;

/// Largest text of a table, bytes.
const MAX_TABLE_FILE_BYTES: u64 = 1 << 30;
/// Columns that an error lists.
const MAX_LISTED_COLUMNS: usize = 40;

/// What the rows of a table stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowKeys {
    /// Their position.
    Position,
    /// A name in the first column.
    Name,
    /// A name in the first column if it holds no numbers, else their position.
    NameOrPosition,
}

/// One value for each row of a file, with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueTable {
    file: String,
    /// Names of the rows, for rows by name.
    names: Option<Vec<String>>,
    values: Vec<f64>,
    /// Line of each row; empty for files that are no text.
    lines: Vec<usize>,
}

impl ValueTable {
    /// The values, row by row, each in the range of its quantity.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }
    /// The names of the rows; none for rows by position.
    #[must_use]
    pub fn names(&self) -> Option<&[String]> {
        self.names.as_deref()
    }
    /// The file and the place of a row: its line, or its number from 1.
    fn place(&self, row: usize) -> String {
        match self.lines.get(row) {
            Some(line) => line.to_string(),
            None => format!("row {}", row + 1),
        }
    }
    pub(crate) fn fault(&self, row: usize, message: impl std::fmt::Display) -> FileFault {
        FileFault::new(&self.file, self.place(row), message)
    }
    /// An error at a row: the message states the defect and, after a semicolon, the remedy.
    #[must_use]
    pub fn error(&self, row: usize, message: &str) -> InputError {
        self.fault(row, message).into_error()
    }
    /// An error of the number of rows, at the last row: `wanted` are the `things` that need one row each.
    pub(crate) fn count_fault(&self, wanted: usize, things: &str) -> FileFault {
        let found = self.values.len();
        let message = format!(
            "the file has {found} rows of values, and there are {wanted} {things}; give one row for each, in their order"
        );
        self.fault(found.saturating_sub(1), message)
    }
    /// As [`ValueTable::error`], where the number of rows does not agree with the `wanted` number of `things`.
    #[must_use]
    pub fn count_error(&self, wanted: usize, things: &str) -> InputError {
        self.count_fault(wanted, things).into_error()
    }
}

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
    read_column(FileSource::Disk, path, &name, wanted).map_err(FileFault::into_error)
}

/// The column that is wanted of a file.
#[derive(Clone, Copy)]
pub(crate) struct WantedColumn<'a> {
    pub(crate) column: Option<&'a str>,
    pub(crate) quantity: Quantity,
    pub(crate) rows: RowKeys,
}

impl WantedColumn<'_> {
    /// The index of the wanted column among the named ones of `candidates`.
    fn choose(self, names: &[&str], candidates: &[usize]) -> Result<usize, String> {
        let listed = || {
            let list: Vec<&str> = candidates.iter().map(|k| names[*k]).take(MAX_LISTED_COLUMNS).collect();
            list.join(", ")
        };
        if let Some(wanted) = self.column {
            let exact = names.iter().position(|n| *n == wanted);
            let number =
                || wanted.parse::<usize>().ok().filter(|k| (1..=names.len()).contains(k)).map(|k| k - 1);
            return exact.or_else(number).ok_or_else(|| {
                let known = &names[..names.len().min(MAX_LISTED_COLUMNS)];
                format!("there is no column '{wanted}'; {}", suggestion::suggest(wanted, known))
            });
        }
        if let [only] = candidates {
            return Ok(*only);
        }
        let alias = |k: &&usize| self.quantity.has_column_name(names[**k]);
        match candidates.iter().find(alias) {
            Some(k) => Ok(*k),
            None if candidates.is_empty() => Err("the file has no column of values; add one".into()),
            None => Err(format!(
                "the file has several columns ({}); write column = \"…\" with one of them",
                listed()
            )),
        }
    }
}

/// Reads a column of a file; `file` names it in messages.
pub(crate) fn read_column(
    files: FileSource<'_>,
    path: &Path,
    file: &str,
    wanted: WantedColumn<'_>,
) -> Result<ValueTable, FileFault> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let fault = |message: String| FileFault::new(file, "", message);
    let limit = match extension.as_str() {
        "csv" | "txt" | "dat" => MAX_TABLE_FILE_BYTES,
        "npy" => npy::MAX_ARRAY_FILE_BYTES,
        "vtu" | "vtp" => MAX_VTK_FILE_BYTES,
        _ => return Err(fault("this kind of table is not read; give .csv, .npy, .vtu or .vtp".into())),
    };
    let bytes = files.read(path, limit).map_err(fault)?;
    let table = match extension.as_str() {
        "npy" => npy_column(file, &bytes, wanted)?,
        "vtu" | "vtp" => vtk_column(file, &bytes, wanted)?,
        _ => text::read(file, &bytes, wanted)?,
    };
    for (row, value) in table.values.iter().enumerate() {
        wanted.quantity.check(*value).map_err(|e| table.fault(row, e))?;
    }
    Ok(table)
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
    Ok(ValueTable { file: file.into(), names: None, values, lines: Vec::new() })
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
    Ok(ValueTable { file: file.into(), names: None, values, lines: Vec::new() })
}
