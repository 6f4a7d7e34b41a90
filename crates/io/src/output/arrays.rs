//! Single arrays: one out of any npz, one into an npy; and plain bytes, whole or not at all.

use super::atomic::write_atomic;
use super::npy::{self, Kind};
use super::writer::Npz;
use super::{FileError, reader};
use std::io::Write;
use std::path::Path;

/// Shape and values of the array `name` of an npz, in double or single precision, all of them finite.
pub fn read_array(path: &Path, name: &str) -> Result<(Vec<usize>, Vec<f64>), FileError> {
    reader::Npz::open(path)?.numbers(name)
}

/// Writes an npy of doubles in C order.
pub fn write_array(path: &Path, shape: &[usize], values: &[f64]) -> Result<(), FileError> {
    write_atomic(path, |out| {
        out.write_all(&npy::header(Kind::F64, shape))?;
        values.iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))
    })
}

/// An array with a name: shape, and values in C order.
pub struct Named<'a> {
    /// Its key in numpy.
    pub name: &'a str,
    /// Its shape.
    pub shape: Vec<usize>,
    /// Its values, in C order, as many as the shape says.
    pub values: &'a [f64],
}

/// Writes arrays of doubles into one npz, not compressed, and first a text (key `about`, UTF-8 bytes) where there is one.
pub fn write_arrays(path: &Path, about: Option<&str>, arrays: &[Named]) -> Result<(), FileError> {
    write_atomic(path, |out| {
        let mut npz = Npz::new(out);
        if let Some(text) = about {
            npz.bytes("about", text.as_bytes())?;
        }
        for a in arrays {
            npz.grid(a.name, &a.shape, a.values.iter().copied())?;
        }
        npz.finish()
    })
}

/// An array of single precision with a name: shape, and values in C order.
pub struct NamedSingle<'a> {
    /// Its key in numpy.
    pub name: &'a str,
    /// Its shape.
    pub shape: Vec<usize>,
    /// Its values, in C order, in as many pieces as it is kept in.
    pub values: Vec<&'a [f32]>,
}

/// Writes arrays of single precision and one text (key `about`, UTF-8 bytes) into one npz, not compressed.
pub fn write_single_arrays(path: &Path, about: &str, arrays: &[NamedSingle]) -> Result<(), FileError> {
    write_atomic(path, |out| {
        let mut npz = Npz::new(out);
        npz.bytes("about", about.as_bytes())?;
        for a in arrays {
            npz.singles(a.name, &a.shape, a.values.iter().copied().flatten().copied())?;
        }
        npz.finish()
    })
}

/// Writes a file of these bytes.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    write_atomic(path, |out| out.write_all(bytes))
}
