//! Linear pictures as OpenEXR: f32 channels R, G, B are written; f16, f32 or u32 are read. Scalar fields have one channel, Y, and the
//! attribute `comments` with quantity and unit, `temperature [K]`.

use super::size::check_size;
use crate::files;
use crate::output::atomic::write_atomic;
use crate::output::error::FileError;
use exr::meta::MetaData;
use exr::prelude::*;
use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek};
use std::path::Path;

/// Largest number of pixels of a picture.
const MAX_EXR_PIXELS: usize = 1 << 26;

/// Largest number of pixels for each byte of a file.
const MAX_PIXELS_PER_BYTE: usize = 4096;

/// A linear picture, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct RgbImage {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Linear values, row by row.
    pub pixels: std::vec::Vec<[f32; 3]>,
}

/// Writes linear pixels (row 0 on top) as f32 channels R, G, B.
///
/// # Errors
///
/// The size is not that of the list, or the file cannot be written.
///
/// ```
/// use zonal_io::output::{read_exr, write_exr};
///
/// let path = std::env::temp_dir().join(format!("zonal-doc-{}.exr", std::process::id()));
/// write_exr(&path, 2, 1, &[[0.1, 0.2, 0.3], [1e6, 0.5, 0.0]])?;
/// assert_eq!(read_exr(&path)?.pixels[1], [1e6, 0.5, 0.0]);
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), zonal_io::output::FileError>(())
/// ```
pub fn write_exr(
    path: &Path,
    width: usize,
    height: usize,
    linear: &[[f32; 3]],
) -> std::result::Result<(), FileError> {
    check_size(path, width, height, linear.len())?;
    let channels = SpecificChannels::rgb(|p: Vec2<usize>| {
        let c = linear[p.y() * width + p.x()];
        (c[0], c[1], c[2])
    });
    let image = Image::from_encoded_channels((width, height), Encoding::SMALL_FAST_LOSSLESS, channels);
    write_atomic(path, |out| {
        image.write().non_parallel().to_buffered(out).map_err(|e| io::Error::other(e.to_string()))
    })
}

/// Reads the R, G, B channels of the first layer that has them.
///
/// # Errors
///
/// The file cannot be read, has no such layer, or declares more pixels than it can hold.
pub fn read_exr(path: &Path) -> std::result::Result<RgbImage, FileError> {
    read_rgb(path, file_length(path), || open_buffered(path))
}

/// As [`read_exr`], from a file's bytes.
///
/// # Errors
///
/// As [`read_exr`].
pub fn read_exr_from_bytes(bytes: &[u8]) -> std::result::Result<RgbImage, FileError> {
    read_rgb(Path::new("memory"), bytes.len(), || Ok(Cursor::new(bytes)))
}

fn read_rgb<R: Read + Seek>(
    path: &Path,
    size: usize,
    open: impl Fn() -> std::result::Result<R, FileError>,
) -> std::result::Result<RgbImage, FileError> {
    let broken = |e: exr::error::Error| {
        let message = format!("cannot be read as an OpenEXR picture with channels R, G, B ({e})");
        FileError::new(path, "", message)
    };
    check_pixels(path, size, open()?, &broken)?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| RgbImage {
                width: size.width(),
                height: size.height(),
                pixels: vec![[0.0; 3]; size.width() * size.height()],
            },
            |picture: &mut RgbImage, p, (r, g, b): (f32, f32, f32)| {
                let i = p.y() * picture.width + p.x();
                picture.pixels[i] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(open()?)
        .map_err(broken)?;
    Ok(image.layer_data.channel_data.pixels)
}

/// The values of one quantity, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct ScalarImage {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Values, row by row; NaN for pixels without a value.
    pub values: std::vec::Vec<f32>,
    /// Name of the quantity.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
}

/// Writes a scalar field as the f32 channel Y.
///
/// # Errors
///
/// The size is not that of the list, or the file cannot be written.
pub fn write_exr_field(path: &Path, field: &ScalarImage) -> std::result::Result<(), FileError> {
    check_size(path, field.width, field.height, field.values.len())?;
    let channels = SpecificChannels::build()
        .with_channel("Y")
        .with_pixel_fn(|p: Vec2<usize>| (field.values[p.y() * field.width + p.x()],));
    let mut image =
        Image::from_encoded_channels((field.width, field.height), Encoding::SMALL_FAST_LOSSLESS, channels);
    image.layer_data.attributes.comments =
        Some(format!("{} [{}]", field.quantity, field.unit).as_str().into());
    write_atomic(path, |out| {
        image.write().non_parallel().to_buffered(out).map_err(|e| io::Error::other(e.to_string()))
    })
}

fn file_length(path: &Path) -> usize {
    std::fs::metadata(path).map_or(0, |m| m.len() as usize)
}

fn open_buffered(path: &Path) -> std::result::Result<BufReader<File>, FileError> {
    let opened = files::open(path).map(|(file, _)| BufReader::new(file));
    opened.map_err(|message| FileError::new(path, "", message))
}

/// Refuses files that declare more pixels than they can hold.
fn check_pixels(
    path: &Path,
    size: usize,
    input: impl Read + Seek,
    broken: &impl Fn(exr::error::Error) -> FileError,
) -> std::result::Result<(), FileError> {
    let meta = MetaData::read_from_buffered(input, false).map_err(broken)?;
    for header in &meta.headers {
        let count = header.layer_size.width().saturating_mul(header.layer_size.height());
        if count > MAX_EXR_PIXELS || count > size.saturating_mul(MAX_PIXELS_PER_BYTE) {
            let message =
                format!("declares {count} pixels, which its {size} bytes cannot hold; the file is damaged");
            return Err(FileError::new(path, "", message));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_round_trip_and_truncated_ones_are_refused() {
        let dir = std::env::temp_dir().join(format!("zonal-exr-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let path = dir.join("a.exr");
        let pixels: std::vec::Vec<[f32; 3]> =
            (0..35).map(|i| [i as f32 * 0.1, 1e-8, 1e6 + i as f32]).collect();
        write_exr(&path, 7, 5, &pixels).unwrap();
        assert_eq!(read_exr(&path).unwrap(), RgbImage { width: 7, height: 5, pixels });
        let bytes = std::fs::read(&path).unwrap();
        for cut in (0..bytes.len()).step_by(7) {
            std::fs::write(&path, &bytes[..cut]).unwrap();
            assert!(read_exr(&path).is_err());
        }
        for i in 0..bytes.len() {
            let mut hurt = bytes.clone();
            hurt[i] ^= 0x55;
            std::fs::write(&path, &hurt).unwrap();
            let _ = read_exr(&path);
        }
        std::fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn scalar_fields_keep_their_values_and_unit_and_are_no_pictures() {
        let dir = std::env::temp_dir().join(format!("zonal-exr-field-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let path = dir.join("a.exr");
        let mut values: std::vec::Vec<f32> = (0..12).map(|i| 400.0 + i as f32 / 3.0).collect();
        values[5] = f32::NAN;
        let mut field =
            ScalarImage { width: 4, height: 3, values, quantity: "temperature".into(), unit: "K".into() };
        write_exr_field(&path, &field).unwrap();
        let layer = read_first_flat_layer_from_file(&path).unwrap().layer_data;
        assert_eq!(layer.attributes.comments.unwrap().to_string(), "temperature [K]");
        let found = layer.channel_data.list[0].sample_data.values_as_f32();
        assert!(found.zip(&field.values).all(|(x, y)| x.to_bits() == y.to_bits()));
        assert!(read_exr(&path).is_err());
        field.values.pop();
        assert!(write_exr_field(&path, &field).is_err());
        std::fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn reference_pictures_are_read() {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/mitsuba-refs/cbox_vacuum.exr");
        if !path.exists() {
            eprintln!("skipped: {} is missing", path.display());
            return;
        }
        let p = read_exr(&path).unwrap();
        assert!(p.width == 128 && p.pixels.iter().flatten().all(|x| x.is_finite()));
        assert!(p.pixels.iter().flatten().any(|x| *x > 0.1));
    }
}
