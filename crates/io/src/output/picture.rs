//! Pictures for the eye as 8-bit sRGB PNG; how they are developed says [`tone`](super::tone).

use super::FileError;
use super::atomic::write_atomic;
use super::tone::{Tone, srgb_byte};
use crate::input::files;
use std::io::{BufRead, BufReader, Seek};
use std::path::Path;

/// Writes linear pixels (row 0 on top) as an 8-bit sRGB PNG; exposure, contrast and curve go into text chunks of these names.
pub fn write_png(
    path: &Path,
    width: usize,
    height: usize,
    linear: &[[f32; 3]],
    tone: &Tone,
) -> Result<(), FileError> {
    write_png_noted(path, (width, height), linear, tone, &[])
}

/// The same with text chunks of one's own: keyword and text, in Latin letters.
pub fn write_png_noted(
    path: &Path,
    (width, height): (usize, usize),
    linear: &[[f32; 3]],
    tone: &Tone,
    notes: &[(&str, &str)],
) -> Result<(), FileError> {
    check_size(path, width, height, linear.len())?;
    for (name, x) in [("exposure", tone.exposure), ("contrast", tone.contrast)] {
        if !(x.is_finite() && x > 0.0) {
            return Err(FileError::new(path, "", format!("the {name} is {x}; give a positive number")));
        }
    }
    let bytes: Vec<u8> =
        linear.iter().enumerate().flat_map(|(i, c)| tone.bytes(*c, i % width, i / width)).collect();
    let (exposure, contrast) = (format!("{}", tone.exposure), format!("{}", tone.contrast));
    let tones = [("exposure", exposure.as_str()), ("contrast", &contrast), ("curve", tone.curve.word())];
    write_png_bytes(path, (width, height), &bytes, &[&tones, notes].concat())
}

/// Writes 8-bit sRGB pixels, three bytes each, as they are, with text chunks: keyword and text, in Latin letters.
pub fn write_png_bytes(
    path: &Path,
    (width, height): (usize, usize),
    bytes: &[u8],
    notes: &[(&str, &str)],
) -> Result<(), FileError> {
    check_size(path, width, height, bytes.len() / 3)?;
    write_atomic(path, |out| {
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
    })
}

/// The text chunk of that keyword in a PNG; `None` where there is none, or where the file is not whole.
pub fn png_note(path: &Path, keyword: &str) -> Option<String> {
    png_note_from(BufReader::new(files::open(path).ok()?.0), keyword)
}

/// As [`png_note`], of what is read.
pub fn png_note_from(input: impl BufRead + Seek, keyword: &str) -> Option<String> {
    let mut reader = png::Decoder::new(input).read_info().ok()?;
    while reader.next_row().ok()?.is_some() {}
    reader.finish().ok()?;
    let texts = &reader.info().uncompressed_latin1_text;
    texts.iter().find(|t| t.keyword == keyword).map(|t| t.text.clone())
}

/// Linear values from 0 to 1 as the bytes of an 8-bit sRGB PNG file, rounded, for textures; `None` where the size is not that of the list.
pub fn encode_png(width: usize, height: usize, linear: &[[f32; 3]]) -> Option<Vec<u8>> {
    check_size(Path::new(""), width, height, linear.len()).ok()?;
    let bytes: Vec<u8> = linear.as_flattened().iter().map(|x| srgb_byte(*x)).collect();
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

/// Refuses pictures without pixels, too large ones, and lists of another length.
pub(super) fn check_size(path: &Path, width: usize, height: usize, pixels: usize) -> Result<(), FileError> {
    let fits = width.checked_mul(height) == Some(pixels);
    if pixels == 0 || !fits || width.max(height) > i32::MAX as usize {
        return Err(FileError::new(
            path,
            "",
            format!("{pixels} pixels do not make a picture of {width} × {height}"),
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_png_carries_its_exposure() {
        let dir = std::env::temp_dir().join(format!("zonal-png-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let path = dir.join("a.png");
        let tone = Tone { contrast: 1.2, ..Tone::filmic(1.5) };
        write_png_noted(&path, (4, 2), &[[0.1, 0.5, 2.0]; 8], &tone, &[("frame", "abc")]).unwrap();
        for (keyword, text) in
            [("exposure", "1.5"), ("contrast", "1.2"), ("curve", "filmic"), ("frame", "abc")]
        {
            assert_eq!(png_note(&path, keyword).as_deref(), Some(text));
        }
        assert_eq!(png_note(&path, "fame"), None);
        // A torn file has no notes.
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() - 30]).unwrap();
        assert_eq!(png_note(&path, "frame"), None);
        assert!(write_png(&path, 4, 2, &[[0.1; 3]; 7], &Tone::filmic(1.0)).is_err());
        assert!(write_png(&path, 4, 2, &[[0.1; 3]; 8], &Tone::filmic(0.0)).is_err());
        std::fs::remove_dir_all(&dir).unwrap();
    }
}
