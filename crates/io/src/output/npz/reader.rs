//! Reading of arrays from an npz of unknown origin.
//!
//! Deflate expands at most 1032-fold, so that a file of n bytes holds at most about 1032 n: all that is read is charged against that
//! budget, and memory grows with the decompressed bytes, never with the declared ones.

use super::npy::{self, ElementType};
use crate::files;
use crate::output::error::FileError;
use std::io::{BufReader, Read, Seek};
use std::path::{Path, PathBuf};
use zip::{CompressionMethod, ZipArchive};
use zonal_math::Vec3;
use zonal_scene::{BandSet, Bands, FieldList, PerBand, Plate, PlateKind, ZoneValues};

/// Bytes of JSON that any file may have.
const BASE_JSON_BYTES: u64 = 16 << 20;
/// Further bytes of JSON for each byte of the file.
const JSON_BYTES_PER_FILE_BYTE: u64 = 4;
/// Values of JSON that any file may have.
const BASE_JSON_VALUES: u64 = 500_000;
/// Bytes of the file for each further value of JSON.
const FILE_BYTES_PER_JSON_VALUE: u64 = 8;

/// True for an error: from 0, infinite if unknown.
fn is_error(x: f64) -> bool {
    x >= 0.0
}

/// The message about a value that is no error.
const INVALID_ERROR: &str = "an error is below 0 or not a number";
/// The message about a value that is not finite.
const NOT_FINITE: &str = "a value is not a finite number";

/// A bound on the number of values of a JSON text: each but the first follows a comma, a colon or an opening bracket.
fn max_json_values(json: &[u8]) -> u64 {
    1 + json.iter().filter(|b| matches!(b, b',' | b':' | b'[' | b'{')).count() as u64
}

/// A row for each zone, or one for all.
pub(crate) enum ZoneRows<T> {
    Same(T),
    Each(Vec<T>),
}

impl<T> ZoneRows<T> {
    fn as_slice(&self) -> &[T] {
        match self {
            ZoneRows::Same(x) => std::slice::from_ref(x),
            ZoneRows::Each(list) => list,
        }
    }
}

impl<T> std::ops::Index<usize> for ZoneRows<T> {
    type Output = T;
    fn index(&self, i: usize) -> &T {
        match self {
            ZoneRows::Same(x) => x,
            ZoneRows::Each(list) => &list[i],
        }
    }
}

fn to_bands(rows: Vec<[f64; 3]>) -> Vec<Bands> {
    rows.into_iter().map(Bands::from_rgb).collect()
}

/// Three little-endian doubles.
fn decode_triple(c: [u8; 24]) -> [f64; 3] {
    let (a, _) = c.as_chunks::<8>();
    [f64::from_le_bytes(a[0]), f64::from_le_bytes(a[1]), f64::from_le_bytes(a[2])]
}

/// Largest expansion of deflate.
const MAX_DEFLATE_EXPANSION: u64 = 1032;
/// The remedy for a damaged file.
const DAMAGED: &str = "the file is damaged or comes from another version; solve the scene again";

/// A source of the bytes of an npz.
pub(crate) trait NpzInput: Read + Seek {}

impl<T: Read + Seek> NpzInput for T {}

/// An npz that is read entry by entry.
pub(crate) struct NpzReader<'a> {
    path: PathBuf,
    zip: ZipArchive<Box<dyn NpzInput + 'a>>,
    size: u64,
    /// Bytes that may still be read.
    budget: u64,
    /// The bands of the scene, and the block of them that is read.
    bands: (BandSet, usize),
}

impl<'a> NpzReader<'a> {
    pub(crate) fn open(path: &Path) -> Result<NpzReader<'static>, FileError> {
        let error = |message: String| FileError::new(path, "", message);
        let (file, size) = files::open(path).map_err(&error)?;
        NpzReader::new(path, Box::new(BufReader::new(file)), size)
    }

    /// Of `size` bytes; `path` names them in messages.
    pub(crate) fn new(
        path: &Path,
        input: Box<dyn NpzInput + 'a>,
        size: u64,
    ) -> Result<NpzReader<'a>, FileError> {
        let error = |message: String| FileError::new(path, "", message);
        let zip = ZipArchive::new(input).map_err(|e| {
            error(format!("is not a solution file, or it is cut short ({e}); solve the scene again"))
        })?;
        Ok(NpzReader {
            path: path.into(),
            zip,
            size,
            budget: size.saturating_mul(MAX_DEFLATE_EXPANSION),
            bands: (BandSet::default(), 0),
        })
    }

    /// Reads one block of bands from arrays with a column for each band, from the first array on.
    pub(crate) fn set_block(&mut self, bands: BandSet, block: usize) {
        self.bands = (bands, block);
        self.budget = self.size.saturating_mul(MAX_DEFLATE_EXPANSION);
    }

    /// Number of bands: columns of arrays of bands.
    fn band_count(&self) -> usize {
        self.bands.0.count()
    }

    /// The block that is read, out of rows of all bands.
    fn block_of_rows<T: Copy>(
        &self,
        name: &str,
        shape: &[usize],
        data: Vec<T>,
    ) -> Result<Vec<[T; 3]>, FileError> {
        let (bands, block) = &self.bands;
        match shape.last() {
            // One column stands for all bands.
            Some(1) => Ok(data.into_iter().map(|x| [x; 3]).collect()),
            Some(columns) if *columns == bands.count() => {
                Ok(data.chunks_exact(*columns).filter_map(|row| bands.of_block(*block, row)).collect())
            }
            _ => {
                let count = bands.count();
                let message =
                    format!("has shape {shape:?} where rows of {count} bands were expected; {DAMAGED}");
                Err(self.error(name, message))
            }
        }
    }

    /// An error at an entry of this file.
    pub(crate) fn error(&self, entry: &str, message: impl Into<String>) -> FileError {
        FileError::new(&self.path, entry, message)
    }

    /// Charges memory that an entry requires besides its own length.
    pub(crate) fn charge(&mut self, entry: &str, bytes: u64) -> Result<(), FileError> {
        match self.budget.checked_sub(bytes) {
            Some(rest) => {
                self.budget = rest;
                Ok(())
            }
            None => Err(self
                .error(entry, format!("calls for {bytes} bytes, more than this file can hold; {DAMAGED}"))),
        }
    }

    /// True if there is an array of that name.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.zip.index_for_name(&format!("{name}.npy")).is_some()
    }

    /// The bytes of an entry.
    fn raw(&mut self, name: &str) -> Result<Vec<u8>, FileError> {
        let path = self.path.clone();
        let error = |message: String| FileError::new(&path, name, message);
        let entry = self
            .zip
            .by_name(&format!("{name}.npy"))
            .map_err(|e| error(format!("cannot be found ({e}); {DAMAGED}")))?;
        if !matches!(entry.compression(), CompressionMethod::Stored | CompressionMethod::Deflated) {
            return Err(error("is packed in a way we do not read; save it with numpy.savez".into()));
        }
        let declared = entry.size();
        if declared > self.budget || declared / MAX_DEFLATE_EXPANSION > entry.compressed_size() {
            let message = format!("declares {declared} bytes, more than this file can hold; {DAMAGED}");
            return Err(error(message));
        }
        // Reserve memory for stored bytes only: packed ones have not proved their length.
        let is_stored =
            entry.compression() == CompressionMethod::Stored && declared == entry.compressed_size();
        let mut bytes = Vec::new();
        let reserved = if is_stored { declared.min(self.size) as usize + 1 } else { 0 };
        bytes.try_reserve_exact(reserved).map_err(|e| error(format!("does not fit into memory ({e})")))?;
        entry
            .take(declared + 1)
            .read_to_end(&mut bytes)
            .map_err(|e| error(format!("cannot be unpacked ({e}); {DAMAGED}")))?;
        if bytes.len() as u64 != declared {
            return Err(error(format!("has another length than declared; {DAMAGED}")));
        }
        self.budget -= declared;
        Ok(bytes)
    }

    /// Elements of `N` bytes, with their shape.
    pub(crate) fn array<const N: usize, T>(
        &mut self,
        name: &str,
        kind: ElementType,
        get: impl Fn([u8; N]) -> T,
    ) -> Result<(Vec<usize>, Vec<T>), FileError> {
        let bytes = self.raw(name)?;
        let (shape, data) = npy::parse(&bytes, kind).map_err(|e| self.error(name, e))?;
        let items = data.as_chunks::<N>().0;
        let mut out = Vec::new();
        let reserved = out.try_reserve_exact(items.len());
        reserved.map_err(|e| self.error(name, format!("does not fit into memory ({e})")))?;
        out.extend(items.iter().map(|c| get(*c)));
        Ok((shape, out))
    }

    fn check_shape(&self, name: &str, shape: &[usize], wanted: &[usize]) -> Result<(), FileError> {
        if shape == wanted {
            return Ok(());
        }
        Err(self.error(name, format!("has shape {shape:?} where {wanted:?} was expected; {DAMAGED}")))
    }

    /// Refuses an array of bands whose shape is neither `[..wanted, bands]` nor `[..wanted, 1]`.
    fn check_band_shape(&self, name: &str, shape: &[usize], wanted: &[usize]) -> Result<(), FileError> {
        if shape == [wanted, &[1]].concat() {
            return Ok(());
        }
        self.check_shape(name, shape, &[wanted, &[self.band_count()]].concat())
    }

    /// Refuses an array of which some value is not valid.
    fn check_values(&self, name: &str, are_valid: bool, message: &str) -> Result<(), FileError> {
        if are_valid { Ok(()) } else { Err(self.error(name, format!("{message}; {DAMAGED}"))) }
    }

    /// A JSON document. Its length and the number of its values are limited by the size of the file before it is parsed: values take many
    /// times the memory of their text, and a repetitive text is packed a thousandfold.
    pub(crate) fn json(&mut self, name: &str) -> Result<serde_json::Value, FileError> {
        let index = self.zip.index_for_name(&format!("{name}.npy"));
        let length = index.and_then(|i| self.zip.by_index_raw(i).ok()).map_or(0, |entry| entry.size());
        let check = |npz: &NpzReader<'_>, noun: &str, count: u64, limit: u64| {
            if count <= limit {
                Ok(())
            } else {
                Err(npz.error(
                    name,
                    format!("has {count} {noun}, more than the {limit} that are read; {DAMAGED}"),
                ))
            }
        };
        check(self, "bytes", length, BASE_JSON_BYTES.saturating_add(JSON_BYTES_PER_FILE_BYTE * self.size))?;
        let bytes = self.bytes(name, None)?;
        check(
            self,
            "values",
            max_json_values(&bytes),
            BASE_JSON_VALUES.saturating_add(self.size / FILE_BYTES_PER_JSON_VALUE),
        )?;
        // Nesting is limited by the parser.
        serde_json::from_slice(&bytes)
            .map_err(|e| self.error(name, format!("is not JSON ({e}); solve the scene again")))
    }

    /// A list of bytes; of length `count` if given.
    pub(crate) fn bytes(&mut self, name: &str, count: Option<usize>) -> Result<Vec<u8>, FileError> {
        let (shape, data) = self.array(name, ElementType::U8, |[b]: [u8; 1]| b)?;
        self.check_shape(name, &shape, &[count.unwrap_or(data.len())])?;
        Ok(data)
    }

    /// A list of whole numbers from 0 to below `below`.
    pub(crate) fn ints(
        &mut self,
        name: &str,
        count: Option<usize>,
        below: usize,
    ) -> Result<Vec<usize>, FileError> {
        let (shape, data) = self.array(name, ElementType::I64, i64::from_le_bytes)?;
        self.check_shape(name, &shape, &[count.unwrap_or(data.len())])?;
        data.into_iter()
            .map(|n| usize::try_from(n).ok().filter(|&n| n < below))
            .collect::<Option<_>>()
            .ok_or_else(|| self.error(name, format!("an index is out of range (0 to {below}); {DAMAGED}")))
    }

    /// Finite numbers of any shape.
    pub(crate) fn grid(&mut self, name: &str) -> Result<(Vec<usize>, Vec<f64>), FileError> {
        let (shape, data) = self.array(name, ElementType::F64, f64::from_le_bytes)?;
        self.check_values(name, data.iter().all(|x| x.is_finite()), NOT_FINITE)?;
        Ok((shape, data))
    }

    /// Numbers of any shape, infinite ones included.
    pub(crate) fn numbers_or_infinity(&mut self, name: &str) -> Result<(Vec<usize>, Vec<f64>), FileError> {
        let (shape, data) = self.array(name, ElementType::F64, f64::from_le_bytes)?;
        self.check_values(name, data.iter().all(|x| !x.is_nan()), "a value is not a number")?;
        Ok((shape, data))
    }

    /// Finite numbers of any shape, in double or single precision.
    pub(crate) fn numbers(&mut self, name: &str) -> Result<(Vec<usize>, Vec<f64>), FileError> {
        let Ok((shape, data)) = self.array(name, ElementType::F32, f32::from_le_bytes) else {
            return self.grid(name);
        };
        self.check_values(name, data.iter().all(|x| x.is_finite()), NOT_FINITE)?;
        Ok((shape, data.into_iter().map(f64::from).collect()))
    }

    /// A list of finite numbers.
    pub(crate) fn reals(&mut self, name: &str, count: usize) -> Result<Vec<f64>, FileError> {
        let (shape, data) = self.grid(name)?;
        self.check_shape(name, &shape, &[count])?;
        Ok(data)
    }

    /// A list of numbers that are NaN or satisfy `is_valid`.
    pub(crate) fn reals_or_nan(
        &mut self,
        name: &str,
        count: usize,
        is_valid: fn(f64) -> bool,
    ) -> Result<Vec<f64>, FileError> {
        let (shape, data) = self.array(name, ElementType::F64, f64::from_le_bytes)?;
        self.check_shape(name, &shape, &[count])?;
        let are_valid = data.iter().all(|x| x.is_nan() || is_valid(*x));
        self.check_values(name, are_valid, "a value is out of range")?;
        Ok(data)
    }

    /// A list of positive finite numbers.
    pub(crate) fn positive(&mut self, name: &str, count: usize) -> Result<Vec<f64>, FileError> {
        let data = self.reals(name, count)?;
        self.check_values(name, data.iter().all(|x| *x > 0.0), "a value is not positive")?;
        Ok(data)
    }

    /// As [`NpzReader::positive`], or one number for all.
    pub(crate) fn positive_or_one(&mut self, name: &str, count: usize) -> Result<ZoneRows<f64>, FileError> {
        let (shape, data) = self.grid(name)?;
        self.check_values(name, data.iter().all(|x| *x > 0.0), "a value is not positive")?;
        if shape == [1] {
            return Ok(ZoneRows::Same(data[0]));
        }
        self.check_shape(name, &shape, &[count])?;
        Ok(ZoneRows::Each(data))
    }

    /// Finite numbers of shape `[..shape, 3]`.
    fn triples(&mut self, name: &str, shape: &[usize]) -> Result<Vec<[f64; 3]>, FileError> {
        let (found, data) = self.rows(name)?;
        self.check_shape(name, &found, &[shape, &[3]].concat())?;
        Ok(data)
    }

    /// A field of `count` zones: finite, or errors from 0, infinite if unknown. Optional fields may have no rows.
    pub(crate) fn field(&mut self, field: &FieldList, count: usize) -> Result<Vec<Bands>, FileError> {
        let (shape, data) = if field.is_error {
            self.band_rows_of(field.name, is_error, INVALID_ERROR)?
        } else {
            self.band_rows_of(field.name, f64::is_finite, NOT_FINITE)?
        };
        let bands = self.band_count();
        if !(field.is_optional && shape == [0, bands]) {
            self.check_band_shape(field.name, &shape, &[count])?;
        }
        Ok(to_bands(data))
    }

    /// Rows of all bands, each valid, with the shape of the array: the block that is read.
    fn band_rows_of(
        &mut self,
        name: &str,
        is_valid: fn(f64) -> bool,
        message: &str,
    ) -> Result<(Vec<usize>, Vec<[f64; 3]>), FileError> {
        let (shape, data) = self.array(name, ElementType::F64, f64::from_le_bytes)?;
        // Rows of equal bands take thrice the memory of their file.
        self.charge(name, 16 * data.len() as u64)?;
        self.check_values(name, data.iter().all(|x| is_valid(*x)), message)?;
        let rows = self.block_of_rows(name, &shape, data)?;
        Ok((shape, rows))
    }

    /// Finite numbers in rows of three, and their shape.
    fn rows(&mut self, name: &str) -> Result<(Vec<usize>, Vec<[f64; 3]>), FileError> {
        self.rows_of(name, f64::is_finite, NOT_FINITE)
    }

    fn rows_of(
        &mut self,
        name: &str,
        is_valid: fn(f64) -> bool,
        message: &str,
    ) -> Result<(Vec<usize>, Vec<[f64; 3]>), FileError> {
        let (shape, data) = self.array(name, ElementType::F64, decode_triple)?;
        let whole = 3 * data.len() == shape.iter().product::<usize>();
        self.check_values(name, whole && data.as_flattened().iter().all(|x| is_valid(*x)), message)?;
        Ok((shape, data))
    }

    /// Errors of `count` zones: from 0, infinite if unknown.
    pub(crate) fn error_list(&mut self, name: &str, count: usize) -> Result<Vec<f64>, FileError> {
        let (shape, data) = self.array(name, ElementType::F64, f64::from_le_bytes)?;
        self.check_shape(name, &shape, &[count])?;
        self.check_values(name, data.iter().all(|x| is_error(*x)), INVALID_ERROR)?;
        Ok(data)
    }

    /// As [`NpzReader::triples`], or one row for all.
    pub(crate) fn same_or_each(
        &mut self,
        name: &str,
        shape: &[usize],
    ) -> Result<ZoneRows<[f64; 3]>, FileError> {
        let (found, data) = self.rows(name)?;
        self.one_or_all(name, shape, 3, &found, data)
    }

    /// One row for all, or one for each element of a shape; arrays have `columns` columns.
    fn one_or_all(
        &self,
        name: &str,
        shape: &[usize],
        columns: usize,
        found: &[usize],
        data: Vec<[f64; 3]>,
    ) -> Result<ZoneRows<[f64; 3]>, FileError> {
        if found == [vec![1; shape.len()], vec![columns]].concat() {
            return Ok(ZoneRows::Same(data[0]));
        }
        self.check_shape(name, found, &[shape, &[columns]].concat())?;
        Ok(ZoneRows::Each(data))
    }

    /// As [`NpzReader::same_or_each`], of bands.
    pub(crate) fn band_rows(&mut self, name: &str, shape: &[usize]) -> Result<ZoneRows<Bands>, FileError> {
        let (found, data) = self.band_rows_of(name, f64::is_finite, NOT_FINITE)?;
        let columns = if found.last() == Some(&1) { 1 } else { self.band_count() };
        Ok(match self.one_or_all(name, shape, columns, &found, data)? {
            ZoneRows::Same(x) => ZoneRows::Same(Bands::from_rgb(x)),
            ZoneRows::Each(list) => ZoneRows::Each(to_bands(list)),
        })
    }

    /// As [`NpzReader::band_rows`], none below 0 or above `max`.
    pub(crate) fn bands_up_to(
        &mut self,
        name: &str,
        count: usize,
        max: f64,
    ) -> Result<ZoneRows<Bands>, FileError> {
        let data = self.band_rows(name, &[count])?;
        let are_valid = data.as_slice().iter().flatten().all(|x| *x >= 0.0 && *x <= max);
        self.check_values(name, are_valid, &format!("a value is below 0 or above {max}"))?;
        Ok(data)
    }

    /// The values of a light group over `count` zones; no rows for zeros.
    pub(crate) fn values(&mut self, name: &str, count: usize) -> Result<ZoneValues, FileError> {
        self.values_of(name, count, f64::is_finite)
    }

    /// As [`NpzReader::values`], for errors: from 0, infinite if unknown.
    pub(crate) fn error_values(&mut self, name: &str, count: usize) -> Result<ZoneValues, FileError> {
        self.values_of(name, count, is_error)
    }

    fn values_of(
        &mut self,
        name: &str,
        count: usize,
        is_valid: fn(f64) -> bool,
    ) -> Result<ZoneValues, FileError> {
        let bytes = self.raw(name)?;
        let (shape, valid, values) = match npy::parse(&bytes, ElementType::F32) {
            Ok((shape, data)) => {
                let list: Vec<f32> = data.as_chunks::<4>().0.iter().map(|c| f32::from_le_bytes(*c)).collect();
                let valid = list.iter().all(|x| is_valid(f64::from(*x)));
                let rows = self.block_of_rows(name, &shape, list)?;
                (shape, valid, ZoneValues::Single(rows.into_iter().map(PerBand::from_rgb).collect()))
            }
            Err(_) => {
                let (shape, data) = npy::parse(&bytes, ElementType::F64).map_err(|e| self.error(name, e))?;
                let list: Vec<f64> = data.as_chunks::<8>().0.iter().map(|c| f64::from_le_bytes(*c)).collect();
                let valid = list.iter().all(|x| is_valid(*x));
                let rows = self.block_of_rows(name, &shape, list)?;
                (shape, valid, ZoneValues::Double(to_bands(rows)))
            }
        };
        self.check_values(name, valid, "a value is not a finite number, or an error below 0")?;
        let rows = if values.is_empty() { 0 } else { count };
        if rows > 0 {
            self.check_band_shape(name, &shape, &[rows])?;
        } else {
            self.check_shape(name, &shape, &[rows, self.band_count()])?;
        }
        Ok(values)
    }

    /// A list of points or directions.
    pub(crate) fn vectors(&mut self, name: &str, count: usize) -> Result<Vec<Vec3>, FileError> {
        Ok(self.triples(name, &[count])?.into_iter().map(Vec3::from_array).collect())
    }

    /// A list of unit vectors.
    pub(crate) fn units(&mut self, name: &str, count: usize) -> Result<Vec<Vec3>, FileError> {
        let data = self.vectors(name, count)?;
        let are_units = data.iter().all(|v| (v.length() - 1.0).abs() < 1e-6);
        self.check_values(name, are_units, "a direction is not a unit vector")?;
        Ok(data)
    }

    /// Plates, as [`super::writer::NpzWriter::plates`] writes them; each has an area.
    pub(crate) fn plates(&mut self, name: &str) -> Result<Vec<Plate>, FileError> {
        let kinds = self.bytes(&format!("{name}_kind"), None)?;
        let n = kinds.len();
        let origin = self.vectors(&format!("{name}_origin"), n)?;
        let e1 = self.vectors(&format!("{name}_e1"), n)?;
        let e2 = self.vectors(&format!("{name}_e2"), n)?;
        let plates: Vec<Plate> = (0..n)
            .map(|i| Plate {
                origin: origin[i],
                e1: e1[i],
                e2: e2[i],
                kind: if kinds[i] == 0 { PlateKind::Triangle } else { PlateKind::Parallelogram },
            })
            .collect();
        let are_valid =
            kinds.iter().all(|k| *k <= 1) && plates.iter().all(|p| p.area() > 0.0 && p.area().is_finite());
        self.check_values(&format!("{name}_kind"), are_valid, "a plate has no area or no known kind")?;
        Ok(plates)
    }

    /// A picture of shape `[height, width, 3]`, with width and height.
    pub(crate) fn picture(&mut self, name: &str) -> Result<(usize, usize, Vec<[f32; 3]>), FileError> {
        let (shape, data) = self.array(name, ElementType::F32, f32::from_le_bytes)?;
        match shape.as_slice() {
            &[height, width, 3] => Ok((width, height, data.as_chunks::<3>().0.to_vec())),
            _ => Err(self.error(name, format!("has shape {shape:?}, not [height, width, 3]; {DAMAGED}"))),
        }
    }
}
