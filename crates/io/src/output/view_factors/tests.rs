//! Every format is read back.

use super::{ViewFactorFormat, ViewFactorTable, write_view_factors};
use crate::output::npz::npy::ElementType;
use crate::output::npz::reader::NpzReader;
use std::path::{Path, PathBuf};

/// The arrays of a table.
struct OwnedTable {
    names: Vec<String>,
    areas: Vec<f64>,
    row_starts: Vec<u64>,
    columns: Vec<u32>,
    values: Vec<f64>,
    radii: Vec<f32>,
    sky: Vec<f64>,
}

impl OwnedTable {
    /// Three surfaces; the second sees the two others, these see the second only.
    fn new() -> OwnedTable {
        OwnedTable {
            names: vec!["=floor, hot".into(), "wand\u{1b} ü".into(), "roof".into()],
            areas: vec![2.0, 1.0 / 3.0, 1e7],
            row_starts: vec![0, 1, 3, 4],
            columns: vec![1, 0, 2, 1],
            values: vec![0.1234567890123, 0.7, 0.25, 8.333e-9],
            radii: vec![1e-6, f32::INFINITY, 2e-6, 0.0],
            sky: vec![0.8, 0.05, 0.9],
        }
    }

    fn table(&self) -> ViewFactorTable<'_> {
        ViewFactorTable {
            areas: &self.areas,
            emissivities: &[0.9, 0.001, 0.5],
            names: &self.names,
            row_starts: &self.row_starts,
            columns: &self.columns,
            values: &self.values,
            radii: &self.radii,
            sky: &self.sky,
            sky_radii: &[1e-3, 2e-3, 3e-3],
            ground: &[0.01, 0.02, 0.03],
            ground_radii: &[1e-4, 2e-4, 3e-4],
            defects: &[1e-5, -1e-5, 0.0],
            enclosure: true,
            scripted: false,
        }
    }

    /// F_ij, zero where no factor is stored.
    fn factor(&self, i: usize, j: usize) -> f64 {
        self.table().row(i).find(|e| e.0 == j).map_or(0.0, |e| e.1)
    }
}

fn write(format: ViewFactorFormat, table: &ViewFactorTable<'_>) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("factors");
    write_view_factors(&path, format, table).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "a temporary file remains");
    (folder, path)
}

fn written_text(format: ViewFactorFormat, table: &ViewFactorTable<'_>) -> String {
    let (_folder, path) = write(format, table);
    std::fs::read_to_string(path).unwrap()
}

fn numbers(line: &str) -> Vec<f64> {
    line.split(' ').map(|w| w.parse().unwrap()).collect()
}

#[test]
fn text_of_view3d_is_read_back() {
    let owned = OwnedTable::new();
    let text = written_text(ViewFactorFormat::View3dText, &owned.table());
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 3 + 3);
    assert_eq!(lines[0], "View3D 4.0.0 0 1 0 3          ");
    assert_eq!(lines[0].len(), 30);
    assert_eq!(lines[1], "2 0.333333 1e+07");
    for i in 0..3 {
        let row = numbers(lines[2 + i]);
        assert_eq!(row.len(), 3);
        assert!((0..3).all(|j| (row[j] - owned.factor(i, j)).abs() <= 0.5e-6), "{row:?}");
    }
    assert_eq!(lines[2], "0.000000 0.123457 0.000000");
    assert_eq!(lines[5], "0.900 0.001 0.500");
}

#[test]
fn binary_of_view3d_is_read_back() {
    let owned = OwnedTable::new();
    let (_folder, path) = write(ViewFactorFormat::View3dBinary, &owned.table());
    let bytes = std::fs::read(path).unwrap();
    assert_eq!(bytes.len(), 32 + 4 * (3 + 9 + 3));
    assert_eq!(&bytes[..32], b"View3D 4.0.0 1 1 0 3          \r\n");
    let singles: Vec<f32> = bytes[32..].as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    assert_eq!(singles[..3], [2.0, 1.0f32 / 3.0, 1e7]);
    let all = (0..9).map(|k| owned.factor(k / 3, k % 3) as f32);
    assert!(all.eq(singles[3..12].iter().copied()));
    assert_eq!(singles[12..], [0.9, 0.001, 0.5]);
}

#[test]
fn sparse_text_is_read_back_to_the_bit() {
    let mut owned = OwnedTable::new();
    owned.values[2] = 0.0;
    let text = written_text(ViewFactorFormat::SparseText, &owned.table());
    let entries: Vec<Vec<f64>> = text.lines().map(numbers).collect();
    let v = &owned.values;
    assert_eq!(entries, [vec![1.0, 2.0, v[0]], vec![2.0, 1.0, v[1]], vec![3.0, 2.0, v[3]]]);
}

#[test]
fn matrix_market_is_read_back_to_the_bit() {
    let mut owned = OwnedTable::new();
    let text = written_text(ViewFactorFormat::MatrixMarket, &owned.table());
    assert!(
        text.starts_with("%%MatrixMarket matrix coordinate real general\n% Row i, column j: view factor")
    );
    assert!(text.contains("% Factors to the sky"));
    let lines: Vec<&str> = text.lines().filter(|l| !l.starts_with('%')).collect();
    assert_eq!(lines[0], "3 3 4");
    assert_eq!(lines.len(), 5);
    for line in &lines[1..] {
        let entry = numbers(line);
        assert_eq!(entry[2], owned.factor(entry[0] as usize - 1, entry[1] as usize - 1));
    }
    owned.names.clear();
    let unfit = write_view_factors(Path::new("unfit.mtx"), ViewFactorFormat::MatrixMarket, &owned.table());
    let wanted = "unfit.mtx: names has 0 elements where 3 are wanted; give one for each";
    assert_eq!(unfit.unwrap_err().to_string(), wanted);
    assert!(!Path::new("unfit.mtx").exists());
}

#[test]
fn csv_has_a_line_for_each_factor_and_for_sky_and_ground() {
    let owned = OwnedTable::new();
    let text = written_text(ViewFactorFormat::Csv, &owned.table());
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    assert_eq!(reader.headers().unwrap(), vec!["from", "to", "name_from", "name_to", "factor", "radius"]);
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 4 + 2 * 3);
    let number = |row: usize, column: usize| rows[row][column].parse::<f64>().unwrap();
    assert_eq!(rows[0].iter().take(4).collect::<Vec<_>>(), ["0", "1", "'=floor, hot", "wand\\u001b ü"]);
    assert_eq!((number(0, 4), number(0, 5) as f32), (owned.values[0], 1e-6));
    assert_eq!(rows[1].iter().collect::<Vec<_>>(), ["0", "sky", "'=floor, hot", "sky", "8e-1", "1e-3"]);
    assert_eq!(&rows[2][1], "ground");
    assert_eq!((number(2, 4), number(2, 5)), (0.01, 1e-4));
    assert_eq!((number(3, 0), number(3, 1), number(3, 4), number(3, 5)), (1.0, 0.0, 0.7, f64::INFINITY));
}

#[test]
fn npz_has_the_arrays_of_scipy() {
    let owned = OwnedTable::new();
    let (_folder, path) = write(ViewFactorFormat::Npz, &owned.table());
    let mut npz = NpzReader::open(&path).unwrap();
    let (shape, format) = npz.array::<3, _>("format", ElementType::Ascii(3), |b| b).unwrap();
    assert_eq!((shape, format), (vec![], vec![*b"csr"]));
    assert_eq!(npz.ints("shape", Some(2), 10).unwrap(), [3, 3]);
    assert_eq!(npz.ints("indptr", Some(4), 10).unwrap(), [0, 1, 3, 4]);
    let (_, indices) = npz.array("indices", ElementType::I32, i32::from_le_bytes).unwrap();
    assert_eq!(indices, [1, 0, 2, 1]);
    assert_eq!(npz.reals("data", 4).unwrap(), owned.values);
    let (_, radii) = npz.array("radii", ElementType::F32, f32::from_le_bytes).unwrap();
    assert_eq!(radii, owned.radii);
    let table = owned.table();
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
        assert_eq!(npz.reals(name, 3).unwrap(), values, "{name}");
    }
    // The longest name has 12 characters, an escaped one among them.
    let (shape, names) = npz.array::<48, _>("names", ElementType::Text(12), |b| b).unwrap();
    let decode = |b: &[u8; 48]| {
        let codes = b.as_chunks::<4>().0.iter().map(|c| u32::from_le_bytes(*c)).filter(|c| *c != 0);
        codes.map(|c| char::from_u32(c).unwrap()).collect::<String>()
    };
    assert_eq!(shape, [3]);
    assert_eq!(names.iter().map(decode).collect::<Vec<_>>(), ["=floor, hot", "wand\\u001b ü", "roof"]);
}

#[test]
fn arrays_that_do_not_fit_are_refused() {
    let refusal = |change: fn(&mut OwnedTable)| {
        let mut owned = OwnedTable::new();
        change(&mut owned);
        owned.table().check().unwrap_err()
    };
    assert!(refusal(|t| t.columns[1] = 2).starts_with("the columns of row 1 do not ascend"));
    assert!(refusal(|t| t.columns[3] = 3).starts_with("the columns of row 2 do not ascend within 0 to 3"));
    assert!(refusal(|t| t.row_starts = vec![0, 3, 1, 4]).starts_with("row_starts does not run"));
    assert!(refusal(|t| t.row_starts = vec![0, 1, 3, 9]).starts_with("row_starts does not run from 0 to 4"));
    assert!(refusal(|t| t.row_starts = Vec::new()).starts_with("row_starts has 0 elements"));
    assert!(refusal(|t| t.radii = Vec::new()).starts_with("radii has 0 elements where 4"));
    assert!(OwnedTable::new().table().check().is_ok());
}

#[test]
fn a_table_without_surfaces_is_written() {
    let empty = ViewFactorTable {
        areas: &[],
        emissivities: &[],
        names: &[],
        row_starts: &[0],
        columns: &[],
        values: &[],
        radii: &[],
        sky: &[],
        sky_radii: &[],
        ground: &[],
        ground_radii: &[],
        defects: &[],
        enclosure: false,
        scripted: true,
    };
    assert_eq!(written_text(ViewFactorFormat::View3dText, &empty).lines().count(), 3);
    assert_eq!(written_text(ViewFactorFormat::SparseText, &empty), "");
    assert!(written_text(ViewFactorFormat::MatrixMarket, &empty).ends_with("\n0 0 0\n"));
}
