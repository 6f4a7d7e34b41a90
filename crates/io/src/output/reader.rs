//! Reading arrays from an npz that anyone may have made.
//!
//! Deflate expands at most 1032-fold, so a file of n bytes cannot honestly hold more than about 1032 n: what is read is
//! charged against that budget, and memory grows with what was really decompressed, never with what was declared.

use super::FileError;
use super::npy::{self, Kind};
use crate::input::files;
use std::io::{BufReader, Read, Seek};
use std::path::{Path, PathBuf};
use zip::{CompressionMethod, ZipArchive};
use zonal_math::Vec3;
use zonal_scene::{Bands, Plate, PlateKind, Values};

/// Bytes of JSON and values in it that any file may have, and how many more a larger one.
const LARGEST_JSON: u64 = 16 << 20;
const JSON_BYTES: u64 = 4;
const MOST_VALUES: u64 = 500_000;
const BYTES_A_VALUE: u64 = 8;

/// An error, infinite where it is not known.
fn is_error(x: f64) -> bool {
    x >= 0.0
}

const NO_ERROR: &str = "an error is below 0 or not a number";

/// No fewer values than a text of JSON has: each but the first comes after a comma, a colon or an opening bracket, in a text or not.
fn values(json: &[u8]) -> u64 {
    1 + json.iter().filter(|b| matches!(b, b',' | b':' | b'[' | b'{')).count() as u64
}

/// A row a zone, or one for all.
pub(super) enum Rows {
    Same(Bands),
    Each(Vec<Bands>),
}

impl std::ops::Index<usize> for Rows {
    type Output = Bands;
    fn index(&self, i: usize) -> &Bands {
        match self {
            Rows::Same(x) => x,
            Rows::Each(list) => &list[i],
        }
    }
}

fn triple(c: [u8; 24]) -> Bands {
    let (a, _) = c.as_chunks::<8>();
    [f64::from_le_bytes(a[0]), f64::from_le_bytes(a[1]), f64::from_le_bytes(a[2])]
}

const LARGEST_EXPANSION: u64 = 1032;
const DAMAGED: &str = "the file is damaged or comes from another version; solve the scene again";

/// What an npz is read from.
pub(super) trait Input: Read + Seek {}

impl<T: Read + Seek> Input for T {}

pub(super) struct Npz<'a> {
    path: PathBuf,
    zip: ZipArchive<Box<dyn Input + 'a>>,
    size: u64,
    budget: u64,
}

impl<'a> Npz<'a> {
    pub(super) fn open(path: &Path) -> Result<Npz<'static>, FileError> {
        let whole = |what: String| FileError::new(path, "", what);
        let (file, size) = files::open(path).map_err(&whole)?;
        Npz::new(path, Box::new(BufReader::new(file)), size)
    }

    /// Of `size` bytes; `path` names them in messages.
    pub(super) fn new(path: &Path, input: Box<dyn Input + 'a>, size: u64) -> Result<Npz<'a>, FileError> {
        let whole = |what: String| FileError::new(path, "", what);
        let zip = ZipArchive::new(input).map_err(|e| {
            whole(format!("is not a solution file, or it is cut short ({e}); solve the scene again"))
        })?;
        Ok(Npz { path: path.into(), zip, size, budget: size.saturating_mul(LARGEST_EXPANSION) })
    }

    /// An error at an entry of this file.
    pub(super) fn error(&self, entry: &str, what: impl Into<String>) -> FileError {
        FileError::new(&self.path, entry, what)
    }

    /// Charges memory that an entry of this file calls for beside its own length.
    pub(super) fn charge(&mut self, entry: &str, bytes: u64) -> Result<(), FileError> {
        match self.budget.checked_sub(bytes) {
            Some(rest) => {
                self.budget = rest;
                Ok(())
            }
            None => Err(self
                .error(entry, format!("calls for {bytes} bytes, more than this file can hold; {DAMAGED}"))),
        }
    }

    /// True where there is an array of that name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.zip.index_for_name(&format!("{name}.npy")).is_some()
    }

    fn raw(&mut self, name: &str) -> Result<Vec<u8>, FileError> {
        let path = self.path.clone();
        let error = |what: String| FileError::new(&path, name, what);
        let entry = self
            .zip
            .by_name(&format!("{name}.npy"))
            .map_err(|e| error(format!("cannot be found ({e}); {DAMAGED}")))?;
        if !matches!(entry.compression(), CompressionMethod::Stored | CompressionMethod::Deflated) {
            return Err(error("is packed in a way we do not read; save it with numpy.savez".into()));
        }
        let declared = entry.size();
        if declared > self.budget || declared / LARGEST_EXPANSION > entry.compressed_size() {
            let what = format!("declares {declared} bytes, more than this file can hold; {DAMAGED}");
            return Err(error(what));
        }
        // What is stored as it is lies in the file; what is packed has to prove its length.
        let known = entry.compression() == CompressionMethod::Stored && declared == entry.compressed_size();
        let mut bytes = Vec::new();
        let room = if known { declared.min(self.size) as usize + 1 } else { 0 };
        bytes.try_reserve_exact(room).map_err(|e| error(format!("does not fit into memory ({e})")))?;
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
    fn array<const N: usize, T>(
        &mut self,
        name: &str,
        kind: Kind,
        get: impl Fn([u8; N]) -> T,
    ) -> Result<(Vec<usize>, Vec<T>), FileError> {
        let bytes = self.raw(name)?;
        let (shape, data) = npy::parse(&bytes, kind).map_err(|e| self.error(name, e))?;
        let items = data.as_chunks::<N>().0;
        let mut out = Vec::new();
        let room = out.try_reserve_exact(items.len());
        room.map_err(|e| self.error(name, format!("does not fit into memory ({e})")))?;
        out.extend(items.iter().map(|c| get(*c)));
        Ok((shape, out))
    }

    fn check_shape(&self, name: &str, shape: &[usize], wanted: &[usize]) -> Result<(), FileError> {
        if shape == wanted {
            return Ok(());
        }
        Err(self.error(name, format!("has shape {shape:?} where {wanted:?} was expected; {DAMAGED}")))
    }

    /// A text of JSON that is as small as the file pays for: its values take many times as much memory as their text, and a text of the same
    /// few characters is packed a thousandfold. So its length and the number of its values are limited before anything is parsed.
    pub(super) fn json(&mut self, name: &str) -> Result<serde_json::Value, FileError> {
        let index = self.zip.index_for_name(&format!("{name}.npy"));
        let length = index.and_then(|i| self.zip.by_index_raw(i).ok()).map_or(0, |entry| entry.size());
        let fits = |npz: &Npz<'_>, what: &str, count: u64, most: u64| match count <= most {
            true => Ok(()),
            false => Err(
                npz.error(name, format!("has {count} {what}, more than the {most} that are read; {DAMAGED}"))
            ),
        };
        fits(self, "bytes", length, LARGEST_JSON.saturating_add(JSON_BYTES * self.size))?;
        let bytes = self.bytes(name, None)?;
        fits(self, "values", values(&bytes), MOST_VALUES.saturating_add(self.size / BYTES_A_VALUE))?;
        // Nesting is limited by the parser.
        serde_json::from_slice(&bytes)
            .map_err(|e| self.error(name, format!("is not JSON ({e}); solve the scene again")))
    }

    /// A list of bytes; of length `count` if given.
    pub(super) fn bytes(&mut self, name: &str, count: Option<usize>) -> Result<Vec<u8>, FileError> {
        let (shape, data) = self.array(name, Kind::U8, |[b]: [u8; 1]| b)?;
        self.check_shape(name, &shape, &[count.unwrap_or(data.len())])?;
        Ok(data)
    }

    /// A list of whole numbers from 0 to below `below`.
    pub(super) fn ints(
        &mut self,
        name: &str,
        count: Option<usize>,
        below: usize,
    ) -> Result<Vec<usize>, FileError> {
        let (shape, data) = self.array(name, Kind::I64, i64::from_le_bytes)?;
        self.check_shape(name, &shape, &[count.unwrap_or(data.len())])?;
        data.into_iter()
            .map(|n| usize::try_from(n).ok().filter(|&n| n < below))
            .collect::<Option<_>>()
            .ok_or_else(|| self.error(name, format!("an index is out of range (0 to {below}); {DAMAGED}")))
    }

    /// Finite numbers of any shape.
    pub(super) fn grid(&mut self, name: &str) -> Result<(Vec<usize>, Vec<f64>), FileError> {
        let (shape, data) = self.array(name, Kind::F64, f64::from_le_bytes)?;
        if data.iter().all(|x| x.is_finite()) {
            return Ok((shape, data));
        }
        Err(self.error(name, format!("a value is not a finite number; {DAMAGED}")))
    }

    /// Finite numbers of any shape, in double or single precision.
    pub(super) fn numbers(&mut self, name: &str) -> Result<(Vec<usize>, Vec<f64>), FileError> {
        let Ok((shape, data)) = self.array(name, Kind::F32, f32::from_le_bytes) else {
            return self.grid(name);
        };
        if data.iter().all(|x| x.is_finite()) {
            return Ok((shape, data.into_iter().map(f64::from).collect()));
        }
        Err(self.error(name, format!("a value is not a finite number; {DAMAGED}")))
    }

    /// A list of finite numbers.
    pub(super) fn reals(&mut self, name: &str, count: usize) -> Result<Vec<f64>, FileError> {
        let (shape, data) = self.grid(name)?;
        self.check_shape(name, &shape, &[count])?;
        Ok(data)
    }

    /// A list of numbers of which `sound` holds; NaN where there is none.
    pub(super) fn reals_or_nan(
        &mut self,
        name: &str,
        count: usize,
        sound: fn(f64) -> bool,
    ) -> Result<Vec<f64>, FileError> {
        let (shape, data) = self.array(name, Kind::F64, f64::from_le_bytes)?;
        self.check_shape(name, &shape, &[count])?;
        match data.iter().all(|x| x.is_nan() || sound(*x)) {
            true => Ok(data),
            false => Err(self.error(name, format!("a value is out of range; {DAMAGED}"))),
        }
    }

    /// A list of positive finite numbers.
    pub(super) fn positive(&mut self, name: &str, count: usize) -> Result<Vec<f64>, FileError> {
        let data = self.reals(name, count)?;
        if data.iter().all(|x| *x > 0.0) {
            return Ok(data);
        }
        Err(self.error(name, format!("a value is not positive; {DAMAGED}")))
    }

    /// Finite numbers of shape `[..shape, 3]`; the shape is free where none is given.
    pub(super) fn triples(&mut self, name: &str, shape: &[usize]) -> Result<Vec<Bands>, FileError> {
        let (found, data) = self.rows(name)?;
        self.check_shape(name, &found, &[shape, &[3]].concat())?;
        Ok(data)
    }

    /// Finite numbers, three and three, and their shape.
    fn rows(&mut self, name: &str) -> Result<(Vec<usize>, Vec<Bands>), FileError> {
        self.rows_of(name, f64::is_finite, "a value is not a finite number")
    }

    fn rows_of(
        &mut self,
        name: &str,
        sound: fn(f64) -> bool,
        else_what: &str,
    ) -> Result<(Vec<usize>, Vec<Bands>), FileError> {
        let (shape, data) = self.array(name, Kind::F64, triple)?;
        let whole = 3 * data.len() == shape.iter().product::<usize>();
        if whole && data.as_flattened().iter().all(|x| sound(*x)) {
            return Ok((shape, data));
        }
        Err(self.error(name, format!("{else_what}; {DAMAGED}")))
    }

    /// Errors of `count` zones, three and three, none below 0; infinite where they are not known. None at all are zeros.
    pub(super) fn errors(
        &mut self,
        name: &str,
        count: usize,
        may_lack: bool,
    ) -> Result<Vec<Bands>, FileError> {
        let (shape, data) = self.rows_of(name, is_error, NO_ERROR)?;
        if !(may_lack && shape == [0, 3]) {
            self.check_shape(name, &shape, &[count, 3])?;
        }
        Ok(data)
    }

    /// Errors of `count` zones, none below 0; infinite where they are not known.
    pub(super) fn error_list(&mut self, name: &str, count: usize) -> Result<Vec<f64>, FileError> {
        let (shape, data) = self.array(name, Kind::F64, f64::from_le_bytes)?;
        self.check_shape(name, &shape, &[count])?;
        match data.iter().all(|x| is_error(*x)) {
            true => Ok(data),
            false => Err(self.error(name, format!("{NO_ERROR}; {DAMAGED}"))),
        }
    }

    /// As [`Npz::triples`], or one row for all.
    pub(super) fn same_or_each(&mut self, name: &str, shape: &[usize]) -> Result<Rows, FileError> {
        let (found, data) = self.rows(name)?;
        if found == [vec![1; shape.len()], vec![3]].concat() {
            return Ok(Rows::Same(data[0]));
        }
        self.check_shape(name, &found, &[shape, &[3]].concat())?;
        Ok(Rows::Each(data))
    }

    /// As [`Npz::same_or_each`], none below 0 or above `max`.
    pub(super) fn bands(&mut self, name: &str, count: usize, max: f64) -> Result<Rows, FileError> {
        let data = self.same_or_each(name, &[count])?;
        let all = match &data {
            Rows::Same(x) => std::slice::from_ref(x),
            Rows::Each(list) => list,
        };
        if all.as_flattened().iter().all(|x| *x >= 0.0 && *x <= max) {
            return Ok(data);
        }
        Err(self.error(name, format!("a value is below 0 or above {max}; {DAMAGED}")))
    }

    /// The values of a light group over `count` zones; no rows for zeros.
    pub(super) fn values(&mut self, name: &str, count: usize) -> Result<Values, FileError> {
        self.values_of(name, count, f64::is_finite)
    }

    /// As [`Npz::values`], errors: none below 0, infinite where they are not known.
    pub(super) fn error_values(&mut self, name: &str, count: usize) -> Result<Values, FileError> {
        self.values_of(name, count, is_error)
    }

    fn values_of(&mut self, name: &str, count: usize, sound: fn(f64) -> bool) -> Result<Values, FileError> {
        let bytes = self.raw(name)?;
        let error = |npz: &Npz<'_>, e: String| npz.error(name, e);
        let (shape, finite, values) = match npy::parse(&bytes, Kind::F32) {
            Ok((shape, data)) => {
                let list: Vec<[f32; 3]> = data
                    .as_chunks::<12>()
                    .0
                    .iter()
                    .map(|c| [0, 4, 8].map(|k| f32::from_le_bytes([c[k], c[k + 1], c[k + 2], c[k + 3]])))
                    .collect();
                (shape, list.as_flattened().iter().all(|x| sound(f64::from(*x))), Values::Single(list))
            }
            Err(_) => {
                let (shape, data) = npy::parse(&bytes, Kind::F64).map_err(|e| error(self, e))?;
                let list: Vec<Bands> = data.as_chunks::<24>().0.iter().map(|c| triple(*c)).collect();
                (shape, list.as_flattened().iter().all(|x| sound(*x)), Values::Double(list))
            }
        };
        if !finite {
            return Err(error(
                self,
                format!("a value is not a finite number, or an error below 0; {DAMAGED}"),
            ));
        }
        let rows = if values.is_empty() { 0 } else { count };
        self.check_shape(name, &shape, &[rows, 3])?;
        Ok(values)
    }

    /// A list of points or directions.
    pub(super) fn vectors(&mut self, name: &str, count: usize) -> Result<Vec<Vec3>, FileError> {
        Ok(self.triples(name, &[count])?.into_iter().map(Vec3::from_array).collect())
    }

    /// A list of unit vectors.
    pub(super) fn units(&mut self, name: &str, count: usize) -> Result<Vec<Vec3>, FileError> {
        let data = self.vectors(name, count)?;
        if data.iter().all(|v| (v.length() - 1.0).abs() < 1e-6) {
            return Ok(data);
        }
        Err(self.error(name, format!("a direction is not a unit vector; {DAMAGED}")))
    }

    /// Plates with an area, as [`super::writer::Npz::plates`] wrote them; as many as there are kinds.
    pub(super) fn plates(&mut self, name: &str) -> Result<Vec<Plate>, FileError> {
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
        if kinds.iter().any(|k| *k > 1) || plates.iter().any(|p| !(p.area() > 0.0 && p.area().is_finite())) {
            let entry = format!("{name}_kind");
            return Err(self.error(&entry, format!("a plate has no area or no known kind; {DAMAGED}")));
        }
        Ok(plates)
    }

    /// A picture of shape `[height, width, 3]`, with width and height.
    pub(super) fn picture(&mut self, name: &str) -> Result<(usize, usize, Vec<[f32; 3]>), FileError> {
        let (shape, data) = self.array(name, Kind::F32, f32::from_le_bytes)?;
        match shape.as_slice() {
            &[height, width, 3] => Ok((width, height, data.as_chunks::<3>().0.to_vec())),
            _ => Err(self.error(name, format!("has shape {shape:?}, not [height, width, 3]; {DAMAGED}"))),
        }
    }
}
