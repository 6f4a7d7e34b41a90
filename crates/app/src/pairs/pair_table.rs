//! Exchange factors of axis-aligned pairs with proved error bounds, from a table to a table.
//!
//! Input columns: kind (vv, sv, ss), bounds and normal of a, bounds and normal of b, kappa. A patch is a box of zero thickness with a normal such as `+x` or
//! `-z`; the normal of a voxel is empty. Output columns: those of the input, then value, error_bound, grade, method. `value` is (1/π) ∬ e^{−κr} cosines/r²,
//! in m² (ss), m³ (sv), m⁴ (vv).

use rayon::prelude::*;
use std::io::Read;
use std::path::Path;
use zonal_exchange::Factor;
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_io::output;
use zonal_math::{Bounded, vec3};
use zonal_report::Failure;
use zonal_scene::Progress;
use zonal_scene::limits::{MAX_COORDINATE, MAX_EXTINCTION};

/// Required columns, in the order of the reference tables.
const COLUMNS: [&str; 16] = [
    "kind", "a_x0", "a_x1", "a_y0", "a_y1", "a_z0", "a_z1", "a_normal", "b_x0", "b_x1", "b_y0", "b_y1",
    "b_z0", "b_z1", "b_normal", "kappa",
];
/// Smallest length of an edge, m.
const MIN_LENGTH: f64 = 1e-9;
/// Largest number of rows.
const MAX_ROWS: usize = 10_000_000;

/// Largest table, bytes.
const MAX_TABLE_BYTES: u64 = 8 << 30;
/// Longest line, bytes.
const MAX_LINE_BYTES: usize = 1 << 16;

/// A reader that fails on a line longer than [`MAX_LINE_BYTES`], since the CSV reader keeps a whole line in memory.
struct LineLimited<R> {
    input: R,
    length: usize,
}

impl<R: Read> Read for LineLimited<R> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let n = self.input.read(out)?;
        for byte in &out[..n] {
            self.length = if *byte == b'\n' { 0 } else { self.length + 1 };
            if self.length > MAX_LINE_BYTES {
                let message =
                    format!("a line is longer than {MAX_LINE_BYTES} bytes; this is not a table of pairs");
                return Err(std::io::Error::other(message));
            }
        }
        Ok(n)
    }
}

/// A pair of boxes or rectangles, and the extinction between them, 1/m.
struct CuboidPair {
    a: Cuboid,
    b: Cuboid,
    kappa: f64,
}

/// A table of pairs with their factors.
#[derive(Debug)]
pub struct PairFactorTable {
    /// The table as CSV.
    pub csv: Vec<u8>,
    /// Number of rows.
    pub pairs: usize,
    /// Number of pairs whose error bound exceeds the tolerance.
    pub missed: usize,
}

/// The factors of the table in a file (.csv).
///
/// # Errors
/// For tables that are not valid, and lengths too far apart for double precision.
pub fn factors_of_file(
    path: &Path,
    tolerance: f64,
    progress: &dyn Progress,
) -> Result<PairFactorTable, Failure> {
    let file = zonal_io::input::open_file(path, MAX_TABLE_BYTES)?;
    compute(&read_from(file, path)?, tolerance, progress, path)
}

/// The factors of a table in memory.
///
/// # Errors
/// As [`factors_of_file`].
pub fn factors_from_bytes(bytes: &[u8], tolerance: f64) -> Result<PairFactorTable, Failure> {
    let path = Path::new("memory");
    compute(&read_from(bytes, path)?, tolerance, &zonal_scene::NoProgress, path)
}

/// The factors of all pairs of a table; `path` names it in messages.
fn compute(
    table: &PairTable,
    tolerance: f64,
    progress: &dyn Progress,
    path: &Path,
) -> Result<PairFactorTable, Failure> {
    let PairTable { records, pairs, .. } = table;
    progress.begin("factors", pairs.len() as u64);
    let factors: Vec<Factor> = pairs
        .par_iter()
        .map(|p| {
            let f = geometric_factor(&p.a, &p.b, p.kappa, tolerance);
            progress.advance(1);
            f
        })
        .collect();
    progress.end();
    let is_finite = |f: &Bounded| f.value.is_finite() && f.radius.is_finite();
    if let Some(k) = factors.iter().position(|f| !is_finite(&f.bounded)) {
        let line = records[k].position().map_or(0, |p| p.line());
        let reason =
            "the lengths of this pair are too far apart for double precision; replace negligible ones by 0";
        return Err(Failure::in_file(path, format!("line {line}: {reason}")));
    }
    let csv = csv_table(table, &factors).map_err(|e| Failure::in_file(path, e))?;
    let missed = factors.iter().filter(|f| f.bounded.radius > tolerance * f.bounded.value.abs()).count();
    Ok(PairFactorTable { csv, pairs: factors.len(), missed })
}

/// The rows of a table with their factors, as CSV.
fn csv_table(table: &PairTable, factors: &[Factor]) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let mut out = csv::Writer::from_writer(Vec::new());
    let columns = table.header.iter().map(|c| output::csv_cell(c).into_owned());
    let added = ["value", "error_bound", "grade", "method"].map(String::from);
    out.write_record(columns.chain(added))?;
    for (record, f) in table.records.iter().zip(factors) {
        let cells = [
            format!("{:.17e}", f.bounded.value),
            format!("{:.3e}", f.bounded.radius * (1.0 + 1e-3)),
            f.bounded.grade.name().to_string(),
            f.method.name().to_string(),
        ];
        let own = record.iter().map(|c| output::csv_cell(c).into_owned());
        out.write_record(own.chain(cells))?;
    }
    Ok(out.into_inner()?)
}

/// A table of pairs: header, rows as text, rows as pairs.
struct PairTable {
    header: csv::StringRecord,
    records: Vec<csv::StringRecord>,
    pairs: Vec<CuboidPair>,
}

/// The table of pairs in `input`; `path` names it in messages.
fn read_from(input: impl Read, path: &Path) -> Result<PairTable, Failure> {
    let mut reader = csv::ReaderBuilder::new().from_reader(LineLimited { input, length: 0 });
    let header = reader.headers().map_err(|e| Failure::in_file(path, e))?.clone();
    let index: Vec<usize> = COLUMNS
        .iter()
        .map(|c| {
            header.iter().position(|h| h.trim() == *c).ok_or_else(|| {
                Failure::in_file(
                    path,
                    format!("line 1: there is no column '{c}'; the columns are {}", COLUMNS.join(",")),
                )
            })
        })
        .collect::<Result<_, _>>()?;
    let (mut records, mut pairs) = (Vec::new(), Vec::new());
    for record in reader.records() {
        let record = record.map_err(|e| Failure::in_file(path, e))?;
        let line = record.position().map_or(0, |p| p.line());
        if pairs.len() == MAX_ROWS {
            return Err(Failure::in_file(
                path,
                format!("line {line}: more than {MAX_ROWS} pairs; split the table"),
            ));
        }
        let cell = |k: usize| record.get(index[k]).unwrap_or("").trim();
        pairs.push(parse_pair(&cell).map_err(|e| {
            Failure::in_file(path, format!("line {line}, column {}: {}", e.column, e.reason))
        })?);
        records.push(record);
    }
    if pairs.is_empty() {
        return Err(Failure::in_file(path, "the table has no rows; add a line for each pair"));
    }
    Ok(PairTable { header, records, pairs })
}

/// A cell that is not valid.
struct CellError {
    column: &'static str,
    reason: String,
}

impl CellError {
    fn new(column: &'static str, reason: impl Into<String>) -> CellError {
        CellError { column, reason: reason.into() }
    }
}

/// A finite number.
fn parse_number(text: &str, column: &'static str) -> Result<f64, CellError> {
    let x: f64 = text.parse().map_err(|_| CellError::new(column, format!("'{text}' is not a number")))?;
    if x.is_finite() { Ok(x) } else { Err(CellError::new(column, format!("{x} is not finite"))) }
}

/// Axis and sign of a normal; none of an empty cell.
fn parse_normal(text: &str, column: &'static str) -> Result<Option<(usize, i8)>, CellError> {
    if text.is_empty() {
        return Ok(None);
    }
    let normal = text.split_at_checked(1).and_then(|(sign, axis)| {
        let sign = match sign {
            "+" => 1,
            "-" => -1,
            _ => return None,
        };
        Some((["x", "y", "z"].iter().position(|a| *a == axis)?, sign))
    });
    let message =
        || CellError::new(column, format!("'{text}' is not a direction; write +x, -x, +y, -y, +z or -z"));
    normal.map(Some).ok_or_else(message)
}

/// A box or rectangle from six bounds and a normal, from column `first` on.
fn parse_cuboid<'t>(cell: &impl Fn(usize) -> &'t str, first: usize) -> Result<Cuboid, CellError> {
    let mut v = [0.0; 6];
    for (k, x) in v.iter_mut().enumerate() {
        *x = parse_number(cell(first + k), COLUMNS[first + k])?;
    }
    let normal = parse_normal(cell(first + 6), COLUMNS[first + 6])?;
    let c = Cuboid { lo: vec3(v[0], v[2], v[4]), hi: vec3(v[1], v[3], v[5]), normal };
    let extent = c.extent().array();
    let in_range = |x: &f64| *x == 0.0 || (MIN_LENGTH..=MAX_COORDINATE).contains(&x.abs());
    if !v.iter().all(|x| x.abs() <= MAX_COORDINATE) || !extent.iter().all(in_range) {
        let reason = format!(
            "these bounds are out of range: lengths must lie between {MIN_LENGTH:e} and {MAX_COORDINATE:e}; choose another unit"
        );
        return Err(CellError::new(COLUMNS[first], reason));
    }
    if c.is_valid() {
        return Ok(c);
    }
    let reason = "these bounds are neither a voxel (x0 < x1, y0 < y1, z0 < z1, no normal) nor a patch (equal bounds on the axis of its normal only)";
    Err(CellError::new(COLUMNS[first], reason))
}

/// One row of the table.
fn parse_pair<'t>(cell: &impl Fn(usize) -> &'t str) -> Result<CuboidPair, CellError> {
    let (a, b) = (parse_cuboid(cell, 1)?, parse_cuboid(cell, 8)?);
    let kappa = parse_number(cell(15), "kappa")?;
    if kappa < 0.0 {
        return Err(CellError::new("kappa", format!("the extinction is {kappa}; it must not be negative")));
    }
    if kappa > MAX_EXTINCTION {
        let reason = format!("the extinction is {kappa:e}; it must not be above {MAX_EXTINCTION:e}");
        return Err(CellError::new("kappa", reason));
    }
    let surfaces = usize::from(a.normal.is_some()) + usize::from(b.normal.is_some());
    let kind = ["vv", "sv", "ss"][surfaces];
    if cell(0) != kind {
        let reason = format!("'{}' does not agree with the normals, which make it '{kind}'", cell(0));
        return Err(CellError::new("kind", reason));
    }
    Ok(CuboidPair { a, b, kappa })
}
