//! Linear pictures as OpenEXR: f32 out; f16, f32 or u32 channels R, G, B in. Fields of single values have one channel, Y, and the attribute
//! `comments` with quantity and unit, `temperature [K]`.

use super::FileError;
use super::atomic::write_atomic;
use super::picture::check_size;
use crate::input::files;
use exr::meta::MetaData;
use exr::prelude::*;
use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek};
use std::path::Path;

/// The most pixels a picture may have.
const MAX_PIXELS: usize = 1 << 26;

/// A linear picture, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Linear values, row by row.
    pub pixels: std::vec::Vec<[f32; 3]>,
}

/// Writes linear pixels (row 0 on top) as f32 channels R, G, B.
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
pub fn read_exr(path: &Path) -> std::result::Result<Picture, FileError> {
    rgb(path, length(path), || open(path))
}

/// As [`read_exr`], of a file's bytes.
pub fn read_exr_from_bytes(bytes: &[u8]) -> std::result::Result<Picture, FileError> {
    rgb(Path::new("memory"), bytes.len(), || Ok(Cursor::new(bytes)))
}

fn rgb<R: Read + Seek>(
    path: &Path,
    size: usize,
    open: impl Fn() -> std::result::Result<R, FileError>,
) -> std::result::Result<Picture, FileError> {
    let broken = |e: exr::error::Error| {
        let what = format!("cannot be read as an OpenEXR picture with channels R, G, B ({e})");
        FileError::new(path, "", what)
    };
    check(path, size, open()?, &broken)?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| Picture {
                width: size.width(),
                height: size.height(),
                pixels: vec![[0.0; 3]; size.width() * size.height()],
            },
            |picture: &mut Picture, p, (r, g, b): (f32, f32, f32)| {
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

/// Values of one quantity, pixel by pixel, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldPicture {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Values, row by row; not a number where there is none.
    pub values: std::vec::Vec<f32>,
    /// What they are.
    pub quantity: String,
    /// Their unit.
    pub unit: String,
}

/// Writes a field as the f32 channel Y.
pub fn write_exr_field(path: &Path, field: &FieldPicture) -> std::result::Result<(), FileError> {
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

/// Reads what [`write_exr_field`] wrote.
pub fn read_exr_field(path: &Path) -> std::result::Result<FieldPicture, FileError> {
    single(path, length(path), || open(path))
}

/// As [`read_exr_field`], of a file's bytes.
pub fn read_exr_field_from_bytes(bytes: &[u8]) -> std::result::Result<FieldPicture, FileError> {
    single(Path::new("memory"), bytes.len(), || Ok(Cursor::new(bytes)))
}

fn single<R: Read + Seek>(
    path: &Path,
    size: usize,
    open: impl Fn() -> std::result::Result<R, FileError>,
) -> std::result::Result<FieldPicture, FileError> {
    let broken = |e: exr::error::Error| {
        FileError::new(path, "", format!("cannot be read as an OpenEXR field with the channel Y ({e})"))
    };
    check(path, size, open()?, &broken)?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required("Y")
        .collect_pixels(
            |size, _| (size.width(), vec![0.0f32; size.width() * size.height()]),
            |(width, values): &mut (usize, std::vec::Vec<f32>), p, (y,): (f32,)| {
                values[p.y() * *width + p.x()] = y;
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(open()?)
        .map_err(broken)?;
    let comments = image.layer_data.attributes.comments.map_or(String::new(), |t| t.to_string());
    let (quantity, unit) = comments.strip_suffix(']').and_then(|c| c.rsplit_once(" [")).unwrap_or(("", ""));
    let (quantity, unit) = (quantity.to_string(), unit.to_string());
    let (width, values) = image.layer_data.channel_data.pixels;
    Ok(FieldPicture { width, height: values.len() / width.max(1), values, quantity, unit })
}

fn length(path: &Path) -> usize {
    std::fs::metadata(path).map_or(0, |m| m.len() as usize)
}

fn open(path: &Path) -> std::result::Result<BufReader<File>, FileError> {
    let opened = files::open(path).map(|(file, _)| BufReader::new(file));
    opened.map_err(|what| FileError::new(path, "", what))
}

/// Refuses files that declare more pixels than they can hold.
fn check(
    path: &Path,
    size: usize,
    input: impl Read + Seek,
    broken: &impl Fn(exr::error::Error) -> FileError,
) -> std::result::Result<(), FileError> {
    let meta = MetaData::read_from_buffered(input, false).map_err(broken)?;
    for header in &meta.headers {
        let count = header.layer_size.width().saturating_mul(header.layer_size.height());
        if count > MAX_PIXELS || count > size.saturating_mul(4096) {
            let what =
                format!("declares {count} pixels, which its {size} bytes cannot hold; the file is damaged");
            return Err(FileError::new(path, "", what));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exr_round_trips_and_broken_ones_are_refused() {
        let dir = std::env::temp_dir().join(format!("zonal-exr-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let path = dir.join("a.exr");
        let pixels: std::vec::Vec<[f32; 3]> =
            (0..35).map(|i| [i as f32 * 0.1, 1e-8, 1e6 + i as f32]).collect();
        write_exr(&path, 7, 5, &pixels).unwrap();
        assert_eq!(read_exr(&path).unwrap(), Picture { width: 7, height: 5, pixels });
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
    fn a_field_round_trips_with_its_unit_and_is_no_picture() {
        let dir = std::env::temp_dir().join(format!("zonal-exr-field-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let path = dir.join("a.exr");
        let values: std::vec::Vec<f32> = (0..12).map(|i| 400.0 + i as f32 / 3.0).collect();
        let mut field =
            FieldPicture { width: 4, height: 3, values, quantity: "temperature".into(), unit: "K".into() };
        write_exr_field(&path, &field).unwrap();
        assert_eq!(read_exr_field(&path).unwrap(), field);
        assert!(read_exr(&path).is_err());
        write_exr(&path, 4, 3, &[[1.0; 3]; 12]).unwrap();
        assert!(read_exr_field(&path).is_err());
        field.values[5] = f32::NAN;
        write_exr_field(&path, &field).unwrap();
        assert!(read_exr_field(&path).unwrap().values[5].is_nan());
        field.values.pop();
        assert!(write_exr_field(&path, &field).is_err());
        std::fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn the_reference_pictures_are_read() {
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
