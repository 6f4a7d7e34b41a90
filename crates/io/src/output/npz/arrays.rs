//! Single arrays: read from any npz, written into npy and npz files.

use super::npy::{self, ElementType};
use super::reader::NpzReader;
use super::writer::NpzWriter;
use crate::output::atomic::write_atomic;
use crate::output::error::FileError;
use std::io::Write;
use std::path::Path;
use zonal_scene::BandSet;

/// Shape and values of the array `name` of an npz, in double or single precision.
///
/// # Errors
///
/// The file cannot be read, the array is absent or of another type, or a value is not finite.
///
/// ```
/// use zonal_io::output::{NamedArray, read_array, write_arrays};
///
/// let path = std::env::temp_dir().join(format!("zonal-doc-array-{}.npz", std::process::id()));
/// write_arrays(&path, None, &[NamedArray { name: "t", shape: vec![2, 1], values: &[300.0, 400.0] }])?;
/// assert_eq!(read_array(&path, "t")?, (vec![2, 1], vec![300.0, 400.0]));
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), zonal_io::output::FileError>(())
/// ```
pub fn read_array(path: &Path, name: &str) -> Result<(Vec<usize>, Vec<f64>), FileError> {
    NpzReader::open(path)?.numbers(name)
}

/// An npz that is read array by array.
pub struct ArrayFile(NpzReader<'static>);

impl ArrayFile {
    /// Opens an npz.
    ///
    /// # Errors
    ///
    /// The file cannot be read or is no npz.
    pub fn open(path: &Path) -> Result<ArrayFile, FileError> {
        Ok(ArrayFile(NpzReader::open(path)?))
    }
    /// True if there is an array of that name.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.0.has(name)
    }
    /// The text `about` of [`write_arrays`] as JSON.
    ///
    /// # Errors
    ///
    /// It is absent or no JSON.
    pub fn about(&mut self) -> Result<serde_json::Value, FileError> {
        self.0.json("about")
    }
    /// Shape and values of an array of doubles; values may be infinite.
    ///
    /// # Errors
    ///
    /// The array is absent or of another type, or a value is NaN.
    pub fn array(&mut self, name: &str) -> Result<(Vec<usize>, Vec<f64>), FileError> {
        self.0.numbers_or_infinity(name)
    }
    /// An error at an array of this file.
    #[must_use]
    pub fn error(&self, name: &str, message: &str) -> FileError {
        self.0.error(name, message)
    }
}

/// Writes an npy of doubles in C order.
///
/// # Errors
///
/// The file cannot be written.
pub fn write_array(path: &Path, shape: &[usize], values: &[f64]) -> Result<(), FileError> {
    write_atomic(path, |out| {
        out.write_all(&npy::header(ElementType::F64, shape))?;
        values.iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))
    })
}

/// A named array of double precision.
pub struct NamedArray<'a> {
    /// Its key in numpy.
    pub name: &'a str,
    /// Its shape.
    pub shape: Vec<usize>,
    /// Its values in C order, as many as the shape states.
    pub values: &'a [f64],
}

/// Writes arrays of doubles into one npz, not compressed, preceded by a text (key `about`, UTF-8 bytes) if one is given.
///
/// # Errors
///
/// The file cannot be written.
pub fn write_arrays(path: &Path, about: Option<&str>, arrays: &[NamedArray]) -> Result<(), FileError> {
    write_atomic(path, |out| {
        let mut npz = NpzWriter::new(out, &BandSet::default());
        if let Some(text) = about {
            npz.bytes("about", text.as_bytes())?;
        }
        for a in arrays {
            npz.grid(a.name, &a.shape, |i| a.values[i])?;
        }
        npz.finish()
    })
}

/// A named array of single precision.
pub struct NamedSingleArray<'a> {
    /// Its key in numpy.
    pub name: &'a str,
    /// Its shape.
    pub shape: Vec<usize>,
    /// Its values in C order, in consecutive pieces of one length.
    pub values: Vec<&'a [f32]>,
}

/// Writes arrays of single precision and a text (key `about`, UTF-8 bytes) into one npz, not compressed.
///
/// # Errors
///
/// The file cannot be written.
pub fn write_single_arrays(path: &Path, about: &str, arrays: &[NamedSingleArray]) -> Result<(), FileError> {
    write_atomic(path, |out| {
        let mut npz = NpzWriter::new(out, &BandSet::default());
        npz.bytes("about", about.as_bytes())?;
        for a in arrays {
            let length = a.values.first().map_or(0, |piece| piece.len());
            npz.singles(a.name, &a.shape, |i| a.values[i / length][i % length])?;
        }
        npz.finish()
    })
}
