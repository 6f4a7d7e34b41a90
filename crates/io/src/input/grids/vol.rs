//! Mitsuba's grid volumes, version 3, of one channel of floats, or of three: red, green and blue.
//!
//! | bytes | contents |
//! |---|---|
//! | 0..4 | `VOL`, the number 3 |
//! | 4..24 | five whole numbers: type (1 = float), nx, ny, nz, channels (1 or 3) |
//! | 24..48 | the box in the file's own coordinates: minimum and maximum, floats |
//! | 48.. | floats, little-endian, channels fastest, then x |
//!
//! Reference: Mitsuba 3, gridvolume.

use crate::input::reading::error::FileFault;
use crate::input::reading::npy::{ArrayValues, ScalarArray};
use zonal_math::{Vec3, vec3};

/// Bytes of the header.
const HEADER_BYTES: usize = 48;

/// True for the bytes of a grid volume.
pub(crate) fn is_vol(bytes: &[u8]) -> bool {
    bytes.starts_with(b"VOL")
}

/// An array for each channel, and their box; `noun` names a value in messages. The declared size is compared with the file's before memory is allocated.
pub(crate) fn parse(
    file: &str,
    bytes: &[u8],
    noun: &str,
) -> Result<(Vec<ScalarArray<'static>>, (Vec3, Vec3)), FileFault> {
    let fault = |message: String| FileFault::new(file, "header", message);
    if bytes.len() < HEADER_BYTES || bytes[3] != 3 {
        return Err(fault("this is not a grid volume of version 3; save it again".into()));
    }
    let word = |k: usize| [0, 1, 2, 3].map(|i| bytes[4 + 4 * k + i]);
    let [kind, nx, ny, nz, channels] = [0, 1, 2, 3, 4].map(|k| u32::from_le_bytes(word(k)));
    if kind != 1 || !matches!(channels, 1 | 3) {
        return Err(fault(format!(
            "values of type {kind} with {channels} channels are not read; save one or three channels of floats (type 1)"
        )));
    }
    let shape = [nx, ny, nz].map(|n| n as usize);
    let size = shape.iter().try_fold(4 * channels as usize, |n, d| n.checked_mul(*d));
    let data = &bytes[HEADER_BYTES..];
    if size != Some(data.len()) || data.is_empty() {
        return Err(fault(format!(
            "the shape ({nx}, {ny}, {nz}) does not agree with the {} bytes of data; save the volume again",
            data.len()
        )));
    }
    let corner = |k: usize| {
        let [x, y, z] = [0, 1, 2].map(|i| f64::from(f32::from_le_bytes(word(5 + 3 * k + i))));
        vec3(x, y, z)
    };
    let (min, max) = (corner(0), corner(1));
    if !(0..3).all(|k| max[k] > min[k] && (max[k] - min[k]).is_finite()) {
        return Err(fault(
            "the file's box has no volume; give min and max in a file with a sound box".into(),
        ));
    }
    let channel = |c: usize| read_channel(file, data, shape, c, channels as usize, noun);
    let arrays = (0..channels as usize).map(channel).collect::<Result<Vec<_>, _>>()?;
    Ok((arrays, (min, max)))
}

/// Channel number `channel` of `channels`, in C order.
fn read_channel(
    file: &str,
    data: &[u8],
    shape: [usize; 3],
    channel: usize,
    channels: usize,
    noun: &str,
) -> Result<ScalarArray<'static>, FileFault> {
    let [nx, ny, nz] = shape;
    let mut values = Vec::with_capacity(nx * ny * nz);
    for i in 0..nx * ny * nz {
        let (x, y, z) = (i / (ny * nz), i / nz % ny, i % nz);
        let at = 4 * (((z * ny + y) * nx + x) * channels + channel);
        let value = f32::from_le_bytes([0, 1, 2, 3].map(|k| data[at + k]));
        if !(value.is_finite() && value >= 0.0) {
            let message = format!("{value} is no {noun}; give finite values from 0");
            return Err(FileFault::new(file, format!("[{x}, {y}, {z}]"), message));
        }
        values.push(value);
    }
    Ok(ScalarArray::of_valid(shape, ArrayValues::Owned(values)))
}
