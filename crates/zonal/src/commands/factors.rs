//! `zonal factors`: proven exchange factors of axis-aligned pairs, from a table to a table.
//!
//! Columns in: kind (vv, sv, ss), the bounds of a with its normal, the bounds of b with its normal, kappa. A patch is a box of
//! zero thickness with a normal such as `+x` or `-z`; a voxel's normal is empty. Columns out: the same, and
//! value, error_bound, grade, method. `value` is (1/π) ∬ e^{−κr} cosines/r², in m² (ss), m³ (sv), m⁴ (vv).

use super::{Context, check_output};
use crate::failure::{note, say};
use crate::{Failure, meter::Meter};
use rayon::prelude::*;
use std::io::Read;
use std::path::{Path, PathBuf};
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_io::output;
use zonal_math::vec3;
use zonal_scene::Progress;
use zonal_scene::scene::{LARGEST_EXTINCTION, LARGEST_LENGTH};

/// Exchange factors of axis-aligned pairs.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Table of pairs (.csv): kind, a_x0 … a_z1, a_normal, b_x0 … b_z1, b_normal, kappa.
    pub pairs: PathBuf,
    /// Wanted relative error of each value.
    #[arg(long, default_value_t = 1e-8)]
    pub tolerance: f64,
    /// Table to write (.csv).
    #[arg(long, short)]
    pub output: PathBuf,
}

/// The columns that must be there, in the order of the reference tables.
pub const COLUMNS: [&str; 16] = [
    "kind", "a_x0", "a_x1", "a_y0", "a_y1", "a_z0", "a_z1", "a_normal", "b_x0", "b_x1", "b_y0", "b_y1",
    "b_z0", "b_z1", "b_normal", "kappa",
];
/// The shortest edge.
const SMALLEST_LENGTH: f64 = 1e-9;
/// The most rows that are read.
const MAX_ROWS: usize = 10_000_000;

/// The most bytes of a table, and of a line of it.
const MAX_FILE: u64 = 8 << 30;
const MAX_LINE: usize = 1 << 16;

/// Lines, none of them longer than [`MAX_LINE`]: a reader of records keeps the whole line.
struct Lines<R> {
    input: R,
    length: usize,
}

impl<R: Read> Read for Lines<R> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let n = self.input.read(out)?;
        for byte in &out[..n] {
            self.length = if *byte == b'\n' { 0 } else { self.length + 1 };
            if self.length > MAX_LINE {
                let what = format!("a line is longer than {MAX_LINE} bytes; this is no table of pairs");
                return Err(std::io::Error::other(what));
            }
        }
        Ok(n)
    }
}

struct Pair {
    a: Cuboid,
    b: Cuboid,
    kappa: f64,
}

/// Runs the command.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    if !(args.tolerance > 0.0 && args.tolerance < 1.0) {
        return Err(Failure::new("--tolerance: give a number between 0 and 1"));
    }
    check_output(&args.output, &["csv"])?;
    if let (Ok(a), Ok(b)) = (args.pairs.canonicalize(), args.output.canonicalize())
        && a == b
    {
        return Err(Failure::in_file(&args.output, "is the table of pairs itself; write to another file"));
    }
    let table = read(&args.pairs)?;
    let meter = Meter::new(context.quiet);
    let Valued { csv, pairs, missed } = values(&table, args.tolerance, &meter, (&args.pairs, &args.output))?;
    output::write_bytes(&args.output, &csv)?;
    if missed > 0 {
        note(&format!(
            "{missed} pair(s) cannot be had to {:e} in double precision; their error_bound says what was reached",
            args.tolerance
        ));
    }
    if context.json {
        say(&format!(
            "{}",
            serde_json::json!({ "pairs": pairs, "written": args.output.display().to_string() })
        ))?;
    } else {
        say(&format!("{pairs} pairs written: {}", args.output.display()))?;
    }
    Ok(())
}

/// A table of pairs with their values.
pub struct Valued {
    /// The table, CSV.
    pub csv: Vec<u8>,
    /// Its rows.
    pub pairs: usize,
    /// Those whose relative error is larger than was asked.
    pub missed: usize,
}

/// The values of a table's bytes, in memory.
pub fn values_from_bytes(bytes: &[u8], tolerance: f64) -> Result<Valued, Failure> {
    let path = Path::new("memory");
    values(&read_from(bytes, path)?, tolerance, &zonal_scene::Quiet, (path, path))
}

fn values(
    (header, records, pairs): &Table,
    tolerance: f64,
    progress: &dyn Progress,
    (input, target): (&Path, &Path),
) -> Result<Valued, Failure> {
    progress.begin("factors", pairs.len() as u64);
    let values: Vec<_> = pairs
        .par_iter()
        .map(|p| {
            let f = geometric_factor(&p.a, &p.b, p.kappa, tolerance);
            progress.advance(1);
            f
        })
        .collect();
    progress.end();
    let finite = |f: &zonal_math::Bounded| f.value.is_finite() && f.radius.is_finite();
    if let Some(k) = values.iter().position(|f| !finite(&f.bounded)) {
        let line = records[k].position().map_or(0, |p| p.line());
        let what =
            "the lengths of this pair are too far apart for double precision; write 0 for what is nothing";
        return Err(Failure::in_file(input, format!("line {line}: {what}")));
    }
    let mut out = csv::Writer::from_writer(Vec::new());
    let broken = |e: csv::Error| Failure::in_file(target, e);
    let columns = header.iter().map(|c| output::csv_cell(c).into_owned());
    let found = ["value", "error_bound", "grade", "method"].map(String::from);
    out.write_record(columns.chain(found)).map_err(broken)?;
    for (record, f) in records.iter().zip(&values) {
        let cells = [
            format!("{:.17e}", f.bounded.value),
            format!("{:.3e}", f.bounded.radius * (1.0 + 1e-3)),
            f.bounded.grade.word().to_string(),
            f.method.word().to_string(),
        ];
        let own = record.iter().map(|c| output::csv_cell(c).into_owned());
        out.write_record(own.chain(cells)).map_err(broken)?;
    }
    let csv = out.into_inner().map_err(|e| Failure::in_file(target, e))?;
    let missed = values.iter().filter(|f| f.bounded.radius > tolerance * f.bounded.value.abs()).count();
    Ok(Valued { csv, pairs: values.len(), missed })
}

type Table = (csv::StringRecord, Vec<csv::StringRecord>, Vec<Pair>);

fn read(path: &Path) -> Result<Table, Failure> {
    read_from(zonal_io::input::open_file(path, MAX_FILE)?, path)
}

/// The table that `input` holds; `path` names it in messages.
fn read_from(input: impl Read, path: &Path) -> Result<Table, Failure> {
    let mut reader = csv::ReaderBuilder::new().from_reader(Lines { input, length: 0 });
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
        pairs.push(pair(&cell).map_err(|(column, what)| {
            Failure::in_file(path, format!("line {line}, column {column}: {what}"))
        })?);
        records.push(record);
    }
    if pairs.is_empty() {
        return Err(Failure::in_file(path, "the table has no rows; add a line for each pair"));
    }
    Ok((header, records, pairs))
}

type Wrong = (&'static str, String);

fn real(text: &str, column: &'static str) -> Result<f64, Wrong> {
    let x: f64 = text.parse().map_err(|_| (column, format!("'{text}' is not a number")))?;
    if x.is_finite() { Ok(x) } else { Err((column, format!("{x} is not finite"))) }
}

fn cuboid<'t>(cell: &impl Fn(usize) -> &'t str, first: usize) -> Result<Cuboid, Wrong> {
    let mut v = [0.0; 6];
    for (k, x) in v.iter_mut().enumerate() {
        *x = real(cell(first + k), COLUMNS[first + k])?;
    }
    let column = COLUMNS[first + 6];
    let normal = match cell(first + 6) {
        "" => None,
        text => {
            let (sign, axis) =
                text.split_at_checked(1).ok_or((column, format!("'{text}' is no direction")))?;
            let sign = match sign {
                "+" => 1,
                "-" => -1,
                _ => {
                    return Err((
                        column,
                        format!("'{text}' is no direction; write +x, -x, +y, -y, +z or -z"),
                    ));
                }
            };
            let axis = ["x", "y", "z"].iter().position(|a| *a == axis);
            Some((
                axis.ok_or((column, format!("'{text}' is no direction; write +x, -x, +y, -y, +z or -z")))?,
                sign,
            ))
        }
    };
    let c = Cuboid { lo: vec3(v[0], v[2], v[4]), hi: vec3(v[1], v[3], v[5]), normal };
    let extent = c.extent().array();
    let fair = |x: &f64| *x == 0.0 || (SMALLEST_LENGTH..=LARGEST_LENGTH).contains(&x.abs());
    if !v.iter().all(|x| x.abs() <= LARGEST_LENGTH) || !extent.iter().all(fair) {
        let range = format!("lengths must lie between {SMALLEST_LENGTH:e} and {LARGEST_LENGTH:e}");
        return Err((COLUMNS[first], format!("these bounds are out of range: {range}; choose another unit")));
    }
    if c.is_valid() {
        return Ok(c);
    }
    let wanted = "a voxel needs x0 < x1, y0 < y1, z0 < z1 and no normal; a patch equal bounds on its normal's axis only";
    Err((COLUMNS[first], format!("these bounds are no box: {wanted}")))
}

fn pair<'t>(cell: &impl Fn(usize) -> &'t str) -> Result<Pair, Wrong> {
    let (a, b) = (cuboid(cell, 1)?, cuboid(cell, 8)?);
    let kappa = real(cell(15), "kappa")?;
    if kappa < 0.0 {
        return Err(("kappa", format!("the extinction is {kappa}; it must not be negative")));
    }
    if kappa > LARGEST_EXTINCTION {
        return Err((
            "kappa",
            format!("the extinction is {kappa:e}; it must not be above {LARGEST_EXTINCTION:e}"),
        ));
    }
    let kind = match (a.normal.is_some(), b.normal.is_some()) {
        (false, false) => "vv",
        (true, true) => "ss",
        _ => "sv",
    };
    if cell(0) != kind {
        return Err(("kind", format!("'{}' does not fit the normals, which make it '{kind}'", cell(0))));
    }
    Ok(Pair { a, b, kappa })
}
