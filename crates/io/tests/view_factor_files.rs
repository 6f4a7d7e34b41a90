//! View factors written through the public interface.

use crate::support;

use support::Folder;
use zonal_io::output::{ViewFactorFormat, ViewFactorTable, read_array, write_view_factors};

const FORMATS: [ViewFactorFormat; 6] = [
    ViewFactorFormat::View3dText,
    ViewFactorFormat::View3dBinary,
    ViewFactorFormat::SparseText,
    ViewFactorFormat::Npz,
    ViewFactorFormat::Csv,
    ViewFactorFormat::MatrixMarket,
];

/// Two parallel unit squares at unit distance.
fn table<'a>(names: &'a [String], columns: &'a [u32]) -> ViewFactorTable<'a> {
    ViewFactorTable {
        areas: &[1.0, 1.0],
        emissivities: &[0.9, 0.8],
        names,
        row_starts: &[0, 1, 2],
        columns,
        values: &[0.199_824_895_698_387_46, 0.199_824_895_698_387_46],
        radii: &[1e-9, 1e-9],
        sky: &[0.800_175_104_301_612_5, 0.4],
        sky_radii: &[1e-9, 1e-3],
        ground: &[0.0, 0.400_175_104_301_612_5],
        ground_radii: &[0.0, 1e-3],
        defects: &[0.0, 1e-4],
        enclosure: false,
        scripted: false,
    }
}

#[test]
fn arrays_of_an_npz_are_read_back() {
    let folder = Folder::new();
    let path = folder.path().join("f.npz");
    let names = ["floor".to_string(), "lid".to_string()];
    let table = table(&names, &[1, 0]);
    write_view_factors(&path, ViewFactorFormat::Npz, &table).unwrap();
    let columns = [("data", table.values), ("areas", table.areas), ("sky", table.sky)];
    let errors = [("ground_radii", table.ground_radii), ("defects", table.defects)];
    for (name, values) in columns.into_iter().chain(errors) {
        assert_eq!(read_array(&path, name).unwrap(), (vec![2], values.to_vec()), "{name}");
    }
}

#[test]
fn refused_tables_leave_the_old_file() {
    let names = ["floor".to_string(), "lid".to_string()];
    for format in FORMATS {
        let folder = Folder::new().with("f", "old");
        let path = folder.path().join("f");
        let error = write_view_factors(&path, format, &table(&names, &[1, 2])).unwrap_err().to_string();
        assert!(error.ends_with("the columns of row 1 do not ascend within 0 to 2; sort them"), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        write_view_factors(&path, format, &table(&names, &[1, 0])).unwrap();
        assert_ne!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
