//! Textures from PNG and JPEG: sRGB (IEC 61966-2-1) to linear, without alpha; alpha as a map of its own.

pub(crate) mod alpha_map;

use crate::input::reading::error::FileFault;
use alpha_map::AlphaMap;
use std::io::Cursor;
use zonal_scene::Texture;
use zune_jpeg::zune_core::{bytestream::ZCursor, colorspace::ColorSpace, options::DecoderOptions};

/// Largest image file, bytes.
pub(crate) const MAX_IMAGE_FILE_BYTES: u64 = 512 << 20;
/// Largest number of pixels along one side.
const MAX_SIDE_PIXELS: usize = 16384;
/// Largest number of pixels of an image (12 bytes each in memory).
const MAX_IMAGE_PIXELS: usize = 1 << 26;
/// Bound on the pixels of a PNG by its size: deflate expands at most 1032-fold, and a pixel has a bit at least.
const MAX_PNG_PIXELS_PER_BYTE: usize = 8 * 1032;
/// Bound on the pixels of a JPEG by its size: a block of 8 × 8 pixels has a bit at least, and chroma blocks may be four times as wide
/// and high.
const MAX_JPEG_PIXELS_PER_BYTE: usize = 8 * 64 * 16;

/// Largest number of pixels for each byte of a file, and pixels that any file may have. A picture of one colour has more pixels a byte and is no larger
/// than 4096 × 4096.
const MAX_PIXELS_PER_BYTE: usize = 128;
const MIN_PIXELS_ALLOWANCE: usize = 1 << 24;

/// The numbers of an image that are alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum AlphaChannel {
    /// Its alpha channel.
    Alpha,
    /// Its red channel, as stored.
    Red,
    /// Its alpha channel if some pixel is not opaque there, otherwise the mean of its colours as stored.
    AlphaOrGrey,
}

/// Decodes an image by its first bytes; `file` names it in messages.
pub(crate) fn decode(file: &str, bytes: &[u8]) -> Result<Texture, FileFault> {
    decode_by_table(file, bytes, &srgb_decode_table())
}

/// As [`decode`], of a picture of numbers from 0 to 1 in place of colours.
pub(crate) fn decode_stored(file: &str, bytes: &[u8]) -> Result<Texture, FileFault> {
    decode_by_table(file, bytes, &std::array::from_fn(|i| i as f32 / 255.0))
}

fn decode_by_table(file: &str, bytes: &[u8], table: &[f32; 256]) -> Result<Texture, FileFault> {
    let (width, height, channels, data) = decode_bytes(file, bytes)?;
    let pixel = |p: &[u8]| match p {
        [r, g, b, ..] => [*r, *g, *b].map(|x| table[x as usize]),
        [grey, ..] => [table[*grey as usize]; 3],
        [] => [0.0; 3],
    };
    let pixels: Vec<[f32; 3]> = data.chunks_exact(channels).take(width * height).map(pixel).collect();
    Ok(Texture { width, height, pixels })
}

/// The alpha of an image; `file` names it in messages.
pub(crate) fn decode_alpha(file: &str, bytes: &[u8], channel: AlphaChannel) -> Result<AlphaMap, FileFault> {
    let (width, height, channels, data) = decode_bytes(file, bytes)?;
    let pixels = || data.chunks_exact(channels).take(width * height);
    let stored = matches!(channels, 2 | 4);
    let own = stored
        && match channel {
            AlphaChannel::Alpha => true,
            AlphaChannel::AlphaOrGrey => pixels().any(|p| p[channels - 1] < u8::MAX),
            AlphaChannel::Red => false,
        };
    let alpha = |p: &[u8]| match (own, channel) {
        (true, _) => p[channels - 1],
        (false, AlphaChannel::Red) => p[0],
        (false, AlphaChannel::Alpha) => u8::MAX,
        (false, AlphaChannel::AlphaOrGrey) => {
            let colours = &p[..channels - usize::from(stored)];
            (colours.iter().map(|x| u32::from(*x)).sum::<u32>() / colours.len() as u32) as u8
        }
    };
    Ok(AlphaMap::new(width, height, pixels().map(alpha).collect()))
}

/// Decodes a PNG or JPEG image.
fn decode_bytes(file: &str, bytes: &[u8]) -> Result<DecodedImage, FileFault> {
    let fault = |message: String| FileFault::new(file, "", message);
    if bytes.is_empty() {
        return Err(fault("this picture is empty; export it again".into()));
    }
    let decoded = if bytes.starts_with(b"\x89PNG") {
        decode_png(bytes).map_err(fault)?
    } else if bytes.starts_with(b"\xff\xd8") {
        decode_jpeg(bytes).map_err(fault)?
    } else {
        return Err(fault("this is neither a PNG nor a JPEG picture; convert it to PNG".into()));
    };
    let (width, height, channels, data) = &decoded;
    if data.len() / channels < width * height {
        return Err(fault("this picture is cut short; export it again".into()));
    }
    Ok(decoded)
}

/// True if some pixel of an image is not opaque; false for an image that cannot be decoded.
pub(crate) fn has_alpha(bytes: &[u8]) -> bool {
    match decode_png(bytes) {
        Ok((.., channels @ (2 | 4), data)) => data.chunks_exact(channels).any(|p| p[channels - 1] < u8::MAX),
        _ => false,
    }
}

/// Width, height, channels, bytes.
type DecodedImage = (usize, usize, usize, Vec<u8>);

fn decode_png(bytes: &[u8]) -> Result<DecodedImage, String> {
    let broken = |e: png::DecodingError| format!("this PNG is damaged ({e}); export it again");
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(broken)?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    check_size(width, height)?;
    check_file_size(width * height, bytes.len(), MAX_PNG_PIXELS_PER_BYTE)?;
    let channels = reader.output_color_type().0.samples();
    let size = reader.output_buffer_size().ok_or("this picture is too large; make it smaller")?;
    let mut data = vec![0; size];
    reader.next_frame(&mut data).map_err(broken)?;
    Ok((width, height, channels, data))
}

fn decode_jpeg(bytes: &[u8]) -> Result<DecodedImage, String> {
    let broken = |e: zune_jpeg::errors::DecodeErrors| {
        let reason = e.to_string().replace('\n', " ");
        format!("this JPEG is damaged ({}); export it again", reason.trim())
    };
    let options = DecoderOptions::default()
        .set_max_width(MAX_SIDE_PIXELS)
        .set_max_height(MAX_SIDE_PIXELS)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = zune_jpeg::JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(broken)?;
    let info = decoder.info().ok_or("this JPEG has no header; export it again")?;
    let (width, height) = (info.width as usize, info.height as usize);
    check_size(width, height)?;
    check_file_size(width * height, bytes.len(), MAX_JPEG_PIXELS_PER_BYTE)?;
    let data = decoder.decode().map_err(broken)?;
    Ok((width, height, 3, data))
}

fn check_size(width: usize, height: usize) -> Result<(), String> {
    let pixels = width.saturating_mul(height);
    if width == 0 || height == 0 {
        return Err("this picture has no pixels; export it again".into());
    }
    if width > MAX_SIDE_PIXELS || height > MAX_SIDE_PIXELS || pixels > MAX_IMAGE_PIXELS {
        return Err(format!(
            "this picture has {width} × {height} pixels, more than are read ({MAX_SIDE_PIXELS} a side and {MAX_IMAGE_PIXELS} in all); make it smaller"
        ));
    }
    Ok(())
}

/// Refuses images that declare more pixels than their bytes can hold, before memory is allocated.
fn check_file_size(pixels: usize, bytes: usize, max_pixels_per_byte: usize) -> Result<(), String> {
    let justified = bytes.saturating_mul(MAX_PIXELS_PER_BYTE).saturating_add(MIN_PIXELS_ALLOWANCE);
    if pixels / max_pixels_per_byte > bytes || pixels > justified {
        return Err(format!(
            "this picture declares {pixels} pixels, which its {bytes} bytes cannot hold; export it again"
        ));
    }
    Ok(())
}

/// IEC 61966-2-1: the linear value of each of the 256 sRGB codes.
fn srgb_decode_table() -> [f32; 256] {
    std::array::from_fn(|i| {
        let s = i as f64 / 255.0;
        let linear = if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) };
        linear as f32
    })
}
