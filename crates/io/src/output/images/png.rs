//! Pictures as 8-bit sRGB PNG, tone mapped by [`ToneMapping`].

use super::size::check_size;
use super::tone::{ToneMapping, srgb_to_byte};
use crate::files;
use crate::output::atomic::write_atomic;
use crate::output::error::FileError;
use std::io::{self, BufRead, BufReader, Seek, Write};
use std::path::Path;

/// Writes linear pixels (row 0 on top) as an 8-bit sRGB PNG; exposure, contrast and curve become text chunks of these names.
///
/// # Errors
///
/// The size is not that of the list, exposure or contrast is not positive, or the file cannot be written.
///
/// ```
/// use zonal_io::output::{ToneMapping, read_png_text, write_png};
///
/// let path = std::env::temp_dir().join(format!("zonal-doc-{}.png", std::process::id()));
/// write_png(&path, 2, 1, &[[0.1, 0.2, 0.3], [1.0, 0.5, 0.0]], &ToneMapping::filmic(1.5))?;
/// assert_eq!(read_png_text(&path, "exposure").as_deref(), Some("1.5"));
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), zonal_io::output::FileError>(())
/// ```
pub fn write_png(
    path: &Path,
    width: usize,
    height: usize,
    linear: &[[f32; 3]],
    tone: &ToneMapping,
) -> Result<(), FileError> {
    write_png_with_text(path, width, height, linear, tone, &[])
}

/// As [`write_png`], with further text chunks: keyword and text, in Latin-1.
///
/// # Errors
///
/// As [`write_png`].
pub fn write_png_with_text(
    path: &Path,
    width: usize,
    height: usize,
    linear: &[[f32; 3]],
    tone: &ToneMapping,
    notes: &[(&str, &str)],
) -> Result<(), FileError> {
    let (bytes, tones) = exposed(path, width, height, linear, tone)?;
    let tones = tones.each_ref().map(|(keyword, text)| (*keyword, text.as_str()));
    write_png_bytes(path, width, height, &bytes, &[&tones, notes].concat())
}

/// As [`write_png`], into memory.
///
/// # Errors
///
/// As [`write_png`].
///
/// ```
/// use zonal_io::output::{ToneMapping, encode_picture_png};
///
/// let png = encode_picture_png(2, 1, &[[0.1, 0.2, 0.3], [1.0, 0.5, 0.0]], &ToneMapping::filmic(1.5))?;
/// assert!(png.starts_with(b"\x89PNG"));
/// # Ok::<(), zonal_io::output::FileError>(())
/// ```
pub fn encode_picture_png(
    width: usize,
    height: usize,
    linear: &[[f32; 3]],
    tone: &ToneMapping,
) -> Result<Vec<u8>, FileError> {
    let (bytes, tones) = exposed(Path::new("picture"), width, height, linear, tone)?;
    encode_png_bytes(
        width,
        height,
        &bytes,
        &tones.each_ref().map(|(keyword, text)| (*keyword, text.as_str())),
    )
}

/// As [`write_png_bytes`], into memory.
///
/// # Errors
///
/// As [`write_png_bytes`].
pub fn encode_png_bytes(
    width: usize,
    height: usize,
    bytes: &[u8],
    notes: &[(&str, &str)],
) -> Result<Vec<u8>, FileError> {
    let path = Path::new("picture");
    check_size(path, width, height, bytes.len() / 3)?;
    let mut out = Vec::new();
    encode(&mut out, width, height, bytes, notes).map_err(|e| FileError::new(path, "", e.to_string()))?;
    Ok(out)
}

/// The bytes of a picture, and its exposure, contrast and curve as text chunks.
#[allow(clippy::type_complexity)]
fn exposed(
    path: &Path,
    width: usize,
    height: usize,
    linear: &[[f32; 3]],
    tone: &ToneMapping,
) -> Result<(Vec<u8>, [(&'static str, String); 3]), FileError> {
    check_size(path, width, height, linear.len())?;
    for (name, x) in [("exposure", tone.exposure), ("contrast", tone.contrast)] {
        if !(x.is_finite() && x > 0.0) {
            return Err(FileError::new(path, "", format!("the {name} is {x}; give a positive number")));
        }
    }
    let bytes: Vec<u8> =
        linear.iter().enumerate().flat_map(|(i, c)| tone.bytes(*c, i % width, i / width)).collect();
    let (exposure, contrast) = (tone.exposure.to_string(), tone.contrast.to_string());
    let tones = [("exposure", exposure), ("contrast", contrast), ("curve", tone.curve.name().to_string())];
    Ok((bytes, tones))
}

/// Writes 8-bit sRGB pixels, three bytes each, with text chunks: keyword and text, in Latin-1.
///
/// # Errors
///
/// The size is not that of the list, or the file cannot be written.
pub fn write_png_bytes(
    path: &Path,
    width: usize,
    height: usize,
    bytes: &[u8],
    notes: &[(&str, &str)],
) -> Result<(), FileError> {
    check_size(path, width, height, bytes.len() / 3)?;
    write_atomic(path, |out| encode(out, width, height, bytes, notes))
}

/// Writes a PNG of three bytes for each pixel with text chunks.
fn encode(
    out: impl Write,
    width: usize,
    height: usize,
    bytes: &[u8],
    notes: &[(&str, &str)],
) -> io::Result<()> {
    let mut encoder = png::Encoder::new(out, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    for (keyword, text) in notes {
        encoder.add_text_chunk(keyword.to_string(), text.to_string())?;
    }
    encoder.add_text_chunk("Software".into(), format!("zonal {}", env!("CARGO_PKG_VERSION")))?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()?;
    Ok(())
}

/// The text chunk of a keyword in a PNG; `None` if there is none or the file is truncated.
pub fn read_png_text(path: &Path, keyword: &str) -> Option<String> {
    read_png_text_from(BufReader::new(files::open(path).ok()?.0), keyword)
}

/// As [`read_png_text`], from a reader.
pub fn read_png_text_from(input: impl BufRead + Seek, keyword: &str) -> Option<String> {
    let mut reader = png::Decoder::new(input).read_info().ok()?;
    while reader.next_row().ok()?.is_some() {}
    reader.finish().ok()?;
    let texts = &reader.info().uncompressed_latin1_text;
    texts.iter().find(|t| t.keyword == keyword).map(|t| t.text.clone())
}

/// Linear values from 0 to 1 as the bytes of an 8-bit sRGB PNG file, rounded, for textures; `None` if the size is not that of the list.
pub fn encode_png(width: usize, height: usize, linear: &[[f32; 3]]) -> Option<Vec<u8>> {
    check_size(Path::new(""), width, height, linear.len()).ok()?;
    let bytes: Vec<u8> = linear.as_flattened().iter().map(|x| srgb_to_byte(*x)).collect();
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(&bytes).ok()?;
    writer.finish().ok()?;
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_png_carries_its_exposure_and_text() {
        let dir = std::env::temp_dir().join(format!("zonal-png-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let path = dir.join("a.png");
        let tone = ToneMapping { contrast: 1.2, ..ToneMapping::filmic(1.5) };
        write_png_with_text(&path, 4, 2, &[[0.1, 0.5, 2.0]; 8], &tone, &[("frame", "abc")]).unwrap();
        for (keyword, text) in
            [("exposure", "1.5"), ("contrast", "1.2"), ("curve", "filmic"), ("frame", "abc")]
        {
            assert_eq!(read_png_text(&path, keyword).as_deref(), Some(text));
        }
        assert_eq!(read_png_text(&path, "fame"), None);
        // A truncated file has no text.
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() - 30]).unwrap();
        assert_eq!(read_png_text(&path, "frame"), None);
        assert!(write_png(&path, 4, 2, &[[0.1; 3]; 7], &ToneMapping::filmic(1.0)).is_err());
        assert!(write_png(&path, 4, 2, &[[0.1; 3]; 8], &ToneMapping::filmic(0.0)).is_err());
        std::fs::remove_dir_all(&dir).unwrap();
    }
}
