//! The committed references: tables in `data/`, each with its provenance.

use zonal_report::Failure;

/// A printed number: its value, and half a unit of its last place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PrintedNumber {
    /// The number.
    pub value: f64,
    /// Half a unit of its last printed place.
    pub half: f64,
}

/// A table with a header line; lines that begin with `#` give the provenance.
pub(crate) struct ReferenceTable {
    name: &'static str,
    header: csv::StringRecord,
    rows: Vec<csv::StringRecord>,
}

/// A line of a table.
pub(crate) struct ReferenceRow<'t> {
    table: &'t ReferenceTable,
    record: &'t csv::StringRecord,
}

impl ReferenceTable {
    /// Reads the text of a table of this name.
    pub(crate) fn new(name: &'static str, text: &str) -> Result<ReferenceTable, Failure> {
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
        let broken = |e: csv::Error| Failure::new(format!("data/{name}: {e}"));
        let header = reader.headers().map_err(broken)?.clone();
        let rows = reader.records().collect::<Result<_, _>>().map_err(broken)?;
        Ok(ReferenceTable { name, header, rows })
    }

    /// Its lines.
    pub(crate) fn rows(&self) -> impl Iterator<Item = ReferenceRow<'_>> {
        self.rows.iter().map(|record| ReferenceRow { table: self, record })
    }
}

impl<'t> ReferenceRow<'t> {
    /// A cell as it stands there.
    pub(crate) fn text(&self, column: &str) -> Result<&'t str, Failure> {
        let at = self.table.header.iter().position(|h| h == column);
        let cell = at.and_then(|k| self.record.get(k));
        cell.ok_or_else(|| Failure::new(format!("data/{}: there is no column '{column}'", self.table.name)))
    }

    /// A number, with half a unit of its last place.
    pub(crate) fn printed(&self, column: &str) -> Result<PrintedNumber, Failure> {
        let text = self.text(column)?;
        printed(text).ok_or_else(|| {
            Failure::new(format!("data/{}, column {column}: '{text}' is not a number", self.table.name))
        })
    }

    /// A number, or nothing where the cell is empty.
    pub(crate) fn optional(&self, column: &str) -> Result<Option<PrintedNumber>, Failure> {
        if self.text(column)?.is_empty() { Ok(None) } else { self.printed(column).map(Some) }
    }

    /// The value of a number.
    pub(crate) fn number(&self, column: &str) -> Result<f64, Failure> {
        Ok(self.printed(column)?.value)
    }
}

fn printed(text: &str) -> Option<PrintedNumber> {
    let value: f64 = text.parse().ok()?;
    let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let places = mantissa.split_once('.').map_or(0, |(_, after)| after.len() as i32);
    let power: i32 = exponent.parse().ok()?;
    Some(PrintedNumber { value, half: 0.5 * 10f64.powi(power - places) })
}

/// The table of a file in `data/`, for the modules beside this one.
macro_rules! table {
    ($name:literal) => {
        $crate::validate::data::ReferenceTable::new(
            $name,
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/validate/data/", $name)),
        )
    };
}
pub(crate) use table;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_unit_of_the_last_place_is_read() {
        let half = |text: &str| printed(text).unwrap().half;
        assert!((half("0.1995") - 5e-5).abs() < 1e-18);
        assert!((half("-53.90") - 5e-3).abs() < 1e-15);
        assert!((half("7.7e-6") - 5e-8).abs() < 1e-20);
        assert!((half("9.6792433725516e-05") - 5e-19).abs() < 1e-30);
        assert_eq!((half("34"), half(".53")), (0.5, 0.005));
        assert_eq!(printed("x"), None);
    }

    #[test]
    fn rows_are_read_by_their_columns() {
        let t = ReferenceTable::new("t.csv", "# from nowhere\na,b\n1,2.50\n3,\n").unwrap();
        let rows: Vec<ReferenceRow> = t.rows().collect();
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[0].printed("b").unwrap(), PrintedNumber { value: 2.5, half: 0.005 });
        assert_eq!(rows[1].optional("b").unwrap(), None);
        assert!(rows[1].number("b").is_err() && rows[0].number("c").is_err());
    }
}
