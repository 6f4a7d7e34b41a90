//! One column of a table, and the choice of it among the columns of a file.

use super::quantity::Quantity;
use crate::input::reading::error::{FileFault, InputError};
use crate::input::reading::suggestion;

/// Columns that an error lists.
pub(crate) const MAX_LISTED_COLUMNS: usize = 40;

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
    pub(crate) file: String,
    /// Names of the rows, for rows by name.
    pub(crate) names: Option<Vec<String>>,
    pub(crate) values: Vec<f64>,
    /// Line of each row; empty for files that are no text.
    pub(crate) lines: Vec<usize>,
    /// An array in memory in place of a file.
    pub(crate) is_array: bool,
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
    /// Refuses a value beyond the range of the quantity.
    pub(crate) fn checked(self, quantity: Quantity) -> Result<ValueTable, FileFault> {
        for (row, value) in self.values.iter().enumerate() {
            quantity.check(*value).map_err(|e| self.fault(row, e))?;
        }
        Ok(self)
    }
    /// The place of a row: its line, its number from 1, or the index of an element from 0.
    fn place(&self, row: usize) -> String {
        match self.lines.get(row) {
            Some(line) => line.to_string(),
            None if self.is_array => format!("[{row}]"),
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
        if self.is_array {
            let message = format!("the array has the shape ({found},), and there are {wanted} {things}");
            return FileFault::new(&self.file, "", format!("{message}; give one of shape ({wanted},)"));
        }
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

/// The column that is wanted of a file.
#[derive(Clone, Copy)]
pub(crate) struct WantedColumn<'a> {
    pub(crate) column: Option<&'a str>,
    pub(crate) quantity: Quantity,
    pub(crate) rows: RowKeys,
}

impl WantedColumn<'_> {
    /// The index of the wanted column among the named ones of `candidates`.
    pub(crate) fn choose(self, names: &[&str], candidates: &[usize]) -> Result<usize, String> {
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
