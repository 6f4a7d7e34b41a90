//! Pictures for the eye: exposure, a filmic curve, sRGB, dither, PNG.
//!
//! ```text
//! v = sRGB(f(exposure · L))      f(x) = x                        for x ≤ k
//!                                f(x) = k + (1−k) t/(1+t)        for x > k,  t = (x−k)/(1−k)
//! ```
//!
//! with k = 0.25: the identity in the shadows, slope 1 at the knee, monotone, 1 at infinity, the same for every band, so that
//! grey stays grey and highlights run to white. The value at t = 1 (x = 1) is 0.625; four stops above it is 0.965.
//! sRGB is the piecewise curve of IEC 61966-2-1. The 8-bit value is ⌊255 v + d⌋ with d ∈ [0,1) Jimenez' interleaved gradient
//! noise of the pixel, shifted per band: no banding, the same bytes every time, exact black and white stay exact.

use super::FileError;
use super::atomic::write_atomic;
use std::path::Path;

const KNEE: f64 = 0.25;

/// How exposed values become displayed ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Curve {
    /// Identity in the shadows, a rational shoulder above a quarter; see the module's header.
    #[default]
    Filmic,
    /// Identity, clipped at 1.
    Linear,
}

impl Curve {
    /// The word that files and the command line use.
    pub fn word(self) -> &'static str {
        match self {
            Curve::Filmic => "filmic",
            Curve::Linear => "linear",
        }
    }
    /// Displayed linear value, 0 to 1, of an exposed value; negative and NaN give 0.
    pub fn apply(self, x: f64) -> f64 {
        let x = if x > 0.0 { x } else { 0.0 };
        match self {
            Curve::Linear => x.min(1.0),
            Curve::Filmic if x <= KNEE => x,
            Curve::Filmic if x == f64::INFINITY => 1.0,
            Curve::Filmic => {
                let t = (x - KNEE) / (1.0 - KNEE);
                KNEE + (1.0 - KNEE) * t / (1.0 + t)
            }
        }
    }
}

/// The sRGB transfer curve from 0…1 to 0…1.
pub fn srgb(x: f64) -> f64 {
    if x <= 0.0031308 {
        12.92 * x
    } else if x >= 1.0 {
        1.0
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

/// Relative luminance (Rec. 709 weights) of a linear colour.
pub fn luminance(c: [f32; 3]) -> f64 {
    0.2126 * c[0] as f64 + 0.7152 * c[1] as f64 + 0.0722 * c[2] as f64
}

/// An exposure that suits the picture: the log-mean luminance between the 2nd and the 98th percentile goes to 0.18, but the
/// 90th percentile is kept between 0.18 and 1.6. 1 for a black picture.
pub fn auto_exposure(linear: &[[f32; 3]]) -> f64 {
    let mut l: Vec<f64> =
        linear.iter().map(|&c| luminance(c)).filter(|x| x.is_finite() && *x > 0.0).collect();
    if l.is_empty() {
        return 1.0;
    }
    l.sort_by(f64::total_cmp);
    let at = |q: f64| ((l.len() - 1) as f64 * q) as usize;
    let middle = &l[at(0.02)..=at(0.98)];
    let mean = middle.iter().map(|x| x.ln()).sum::<f64>() / middle.len() as f64;
    let bright = l[at(0.9)];
    let exposure = (0.18 / mean.exp()).clamp(0.18 / bright, 1.6 / bright);
    if exposure.is_finite() && exposure > 0.0 { exposure } else { 1.0 }
}

fn dither(x: usize, y: usize, band: usize) -> f64 {
    let (x, y) = (x as f64 + 47.0 * band as f64, y as f64 + 17.0 * band as f64);
    let inner = 0.06711056 * x + 0.00583715 * y;
    let outer = 52.9829189 * (inner - inner.floor());
    outer - outer.floor()
}

/// The 8-bit value of a linear one at a pixel.
fn quantise(linear: f32, exposure: f64, curve: Curve, x: usize, y: usize, band: usize) -> u8 {
    let v = srgb(curve.apply(linear as f64 * exposure));
    (255.0 * v + dither(x, y, band)).floor().clamp(0.0, 255.0) as u8
}

/// Writes linear pixels (row 0 on top) as an 8-bit sRGB PNG; exposure and curve go into text chunks named `exposure` and `curve`.
pub fn write_png(
    path: &Path,
    width: usize,
    height: usize,
    linear: &[[f32; 3]],
    exposure: f64,
    curve: Curve,
) -> Result<(), FileError> {
    check_size(path, width, height, linear.len())?;
    if !(exposure.is_finite() && exposure > 0.0) {
        return Err(FileError::new(path, "", format!("the exposure is {exposure}; give a positive number")));
    }
    let mut bytes = Vec::with_capacity(3 * linear.len());
    for (i, c) in linear.iter().enumerate() {
        let (x, y) = (i % width, i / width);
        bytes.extend((0..3).map(|b| quantise(c[b], exposure, curve, x, y, b)));
    }
    write_atomic(path, |out| {
        let mut encoder = png::Encoder::new(out, width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.add_text_chunk("exposure".into(), format!("{exposure}"))?;
        encoder.add_text_chunk("curve".into(), curve.word().into())?;
        encoder.add_text_chunk("Software".into(), format!("zonal {}", env!("CARGO_PKG_VERSION")))?;
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&bytes)?;
        writer.finish()?;
        Ok(())
    })
}

/// Linear values from 0 to 1 as the bytes of an 8-bit sRGB PNG file, rounded, for textures; `None` where the size is not that of the list.
pub fn encode_png(width: usize, height: usize, linear: &[[f32; 3]]) -> Option<Vec<u8>> {
    check_size(Path::new(""), width, height, linear.len()).ok()?;
    let bytes: Vec<u8> = linear
        .as_flattened()
        .iter()
        .map(|x| (255.0 * srgb(*x as f64)).round().clamp(0.0, 255.0) as u8)
        .collect();
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
    fn the_curve_is_monotone_smooth_and_neutral_in_the_shadows() {
        assert_eq!(Curve::Filmic.apply(0.1), 0.1);
        let mut last = 0.0;
        for i in 0..4000 {
            let y = Curve::Filmic.apply(i as f64 * 0.01);
            assert!(y >= last && y - last <= 0.0100001 && y <= 1.0);
            last = y;
        }
        assert_eq!(Curve::Filmic.apply(f64::NAN), 0.0);
        assert_eq!(Curve::Filmic.apply(f64::INFINITY), 1.0);
    }

    #[test]
    fn dither_keeps_the_mean_and_the_ends() {
        let mean = |x: f32| {
            (0..64 * 64).map(|i| quantise(x, 1.0, Curve::Linear, i % 64, i / 64, 0) as f64).sum::<f64>()
                / 4096.0
        };
        assert_eq!(mean(0.0), 0.0);
        assert_eq!(mean(1.0), 255.0);
        let x = 0.2;
        assert!((mean(x as f32) - 255.0 * srgb(x)).abs() < 0.03);
    }

    #[test]
    fn exposure_follows_the_scene() {
        let a: Vec<[f32; 3]> = (1..1000).map(|i| [i as f32 * 0.001; 3]).collect();
        let b: Vec<[f32; 3]> = a.iter().map(|c| c.map(|x| 100.0 * x)).collect();
        let ratio = auto_exposure(&a) / auto_exposure(&b);
        assert!((ratio - 100.0).abs() < 1e-3);
        assert_eq!(auto_exposure(&[[0.0; 3]]), 1.0);
        assert_eq!(auto_exposure(&[[f32::NAN; 3]]), 1.0);
    }

    #[test]
    fn a_png_carries_its_exposure() {
        let dir = std::env::temp_dir().join(format!("zonal-png-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let path = dir.join("a.png");
        write_png(&path, 4, 2, &[[0.1, 0.5, 2.0]; 8], 1.5, Curve::Filmic).unwrap();
        let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
        let reader = png::Decoder::new(file).read_info().unwrap();
        let texts = &reader.info().uncompressed_latin1_text;
        assert!(texts.iter().any(|t| t.keyword == "exposure" && t.text == "1.5"));
        assert!(texts.iter().any(|t| t.keyword == "curve" && t.text == "filmic"));
        assert!(write_png(&path, 4, 2, &[[0.1; 3]; 7], 1.0, Curve::Filmic).is_err());
        std::fs::remove_dir_all(&dir).unwrap();
    }
}
