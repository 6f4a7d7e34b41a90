//! Tables as text: values separated by commas, semicolons, tabs or blanks; lines that begin with `#` are comments.

use super::value_table::{RowKeys, ValueTable, WantedColumn};
use crate::input::reading::error::FileFault;
use csv::{ReaderBuilder, StringRecord, Trim};

/// Columns of counters, which are no values.
const COUNTERS: [&str; 5] = ["face", "zone", "index", "cell", "id"];

/// Reads a column of a text.
pub(crate) fn read(file: &str, bytes: &[u8], wanted: WantedColumn<'_>) -> Result<ValueTable, FileFault> {
    let (header, rows) = records(file, bytes)?;
    let fault = |message: &str| FileFault::new(file, "", message);
    let first = rows.first().ok_or_else(|| fault("the file has no rows of values; add one for each face"))?;
    let width = header.as_ref().map_or(first.len(), |h| h.len());
    for r in &rows {
        if r.len() != width {
            let message =
                format!("this line has {} values where {width} are expected; mend the line", r.len());
            return Err(FileFault::new(file, line(r), message));
        }
    }
    // The first column holds names if no cell of it is a number.
    let has_names = rows.iter().all(|r| number(&r[0]).is_none());
    let by_name = match wanted.rows {
        RowKeys::Position => false,
        RowKeys::Name if !has_names => {
            return Err(FileFault::new(
                file,
                line(first),
                "the first column holds numbers, not names; give the columns name, value",
            ));
        }
        RowKeys::Name => true,
        RowKeys::NameOrPosition => has_names,
    };
    // Choose the column.
    let numbered: Vec<String> = (1..=width).map(|k| k.to_string()).collect();
    let names: Vec<&str> = match &header {
        Some(h) => h.iter().collect(),
        None => numbered.iter().map(String::as_str).collect(),
    };
    let is_value = |k: &usize| {
        let is_counter =
            header.is_some() && width > 1 && COUNTERS.contains(&names[*k].to_lowercase().as_str());
        !(is_counter || *k == 0 && has_names)
    };
    let candidates: Vec<usize> = (0..width).filter(is_value).collect();
    let place = if header.is_some() { "1" } else { "" };
    let chosen = wanted.choose(&names, &candidates).map_err(|e| FileFault::new(file, place, e))?;
    // Read its values.
    let value = |r: &StringRecord| {
        number(&r[chosen]).ok_or_else(|| {
            FileFault::new(
                file,
                line(r),
                format!("'{}' is not a number; give one in column '{}'", &r[chosen], names[chosen]),
            )
        })
    };
    Ok(ValueTable {
        is_array: false,
        file: file.into(),
        names: by_name.then(|| rows.iter().map(|r| r[0].to_string()).collect()),
        values: rows.iter().map(value).collect::<Result<_, _>>()?,
        lines: rows.iter().map(line).collect(),
    })
}

/// The header, if there is one, and the other records.
fn records(file: &str, bytes: &[u8]) -> Result<(Option<StringRecord>, Vec<StringRecord>), FileFault> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .delimiter(delimiter(bytes))
        .trim(Trim::All)
        .from_reader(bytes);
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| {
            let at = e.position().map_or(String::new(), |p| p.line().to_string());
            FileFault::new(
                file,
                at,
                "this line is not UTF-8 text of separated values; save the file as UTF-8",
            )
        })?;
        // A line of blanks is no row.
        if record.iter().any(|cell| !cell.is_empty()) {
            rows.push(record);
        }
    }
    let is_header = rows.first().is_some_and(|r| r.iter().all(|cell| number(cell).is_none()));
    let header = is_header.then(|| rows.remove(0));
    Ok((header, rows))
}

/// The separator: the first of semicolon, tab and comma that occurs in the first line that is no comment.
fn delimiter(bytes: &[u8]) -> u8 {
    let mut lines =
        bytes.split(|b| *b == b'\n').filter(|l| !l.starts_with(b"#") && !l.trim_ascii().is_empty());
    let first = lines.next().unwrap_or(&[]);
    [b';', b'\t', b','].into_iter().find(|d| first.contains(d)).unwrap_or(b',')
}

fn number(cell: &str) -> Option<f64> {
    cell.parse().ok()
}

fn line(record: &StringRecord) -> usize {
    record.position().map_or(0, |p| p.line() as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::tables::Quantity;

    fn table(text: &str, column: Option<&str>, rows: RowKeys) -> Result<ValueTable, String> {
        let wanted = WantedColumn { column, quantity: Quantity::Temperature, rows };
        read("t.csv", text.as_bytes(), wanted).map_err(|e| e.to_string())
    }

    #[test]
    fn columns_are_found_by_name_number_and_quantity() {
        let values = |text: &str, column| table(text, column, RowKeys::Position).unwrap().values().to_vec();
        let wanted = vec![300.0, 400.0];
        for (text, column) in [
            ("300\n400\n", None),
            ("# faces\n\n300\n400", None),
            ("T\n300\n400\n", None),
            ("face,T\n0,300\n1,400\n", None),
            ("q;temperature_K\n1;300\n2;400", None),
            ("T,hot\n1,300\n2,400\n", Some("hot")),
            ("1\t300\n2\t400\n", Some("2")),
            ("\u{feff}\"a, b\",c\n300,1\n400,2", Some("a, b")),
        ] {
            assert_eq!(values(text, column), wanted, "{text}");
        }
        let named = table("name,T\nwalls,300\n\"lid, hot\",400\n", None, RowKeys::NameOrPosition).unwrap();
        assert_eq!((named.names().unwrap()[1].as_str(), named.values()), ("lid, hot", &wanted[..]));
        let named = table("walls,300\nlid,400\n", None, RowKeys::Name).unwrap();
        assert_eq!((named.names().unwrap()[0].as_str(), named.values()), ("walls", &wanted[..]));
    }

    #[test]
    fn wrong_tables_name_line_and_remedy() {
        for (text, column, wanted) in [
            ("", None, "t.csv: the file has no rows"),
            ("a,b\n1,2\n", None, "t.csv:1: the file has several columns (a, b); write column"),
            ("temp,b\n1,2\n", Some("tmp"), "t.csv:1: there is no column 'tmp'; did you mean 'temp'?"),
            ("T\n300\nhot\n", None, "t.csv:3: 'hot' is not a number"),
            ("a,T\n1,300\n2\n", None, "t.csv:3: this line has 1 values where 2"),
        ] {
            let e = table(text, column, RowKeys::Position).unwrap_err();
            assert!(e.starts_with(wanted), "{e}");
        }
        assert!(table("1,300\n", None, RowKeys::Name).unwrap_err().contains("numbers, not names"));
    }
}
