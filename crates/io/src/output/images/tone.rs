//! Tone mapping: exposure, contrast, a filmic curve, sRGB, ordered dither.
//!
//! ```text
//! x = e L (Y/0.18)^(c−1)         Y = luminance of e L; exposure e, contrast c, default 1
//! y = ½ f(x) + ½ [f(lo) + (x − lo)/(hi − lo) (f(hi) − f(lo))]      lo, hi: the smallest and the largest band of x
//! v = sRGB(y)                    f(x) = x                        for x ≤ k
//!                                f(x) = k + (1−k) t/(1+t)        for x > k,  t = (x−k)/(1−k)
//! ```
//!
//! with k = 0.25: the identity in the shadows, slope 1 at the knee, monotone, 1 at infinity. The value at t = 1 (x = 1) is 0.625; four
//! stops above it is 0.965. Grey stays grey and highlights tend to white. The curve of each band alone turns red to yellow and blue to
//! cyan; the bracket keeps the hue, which makes flames pink; y is the mean of both. Contrast pivots on middle grey and scales the bands
//! alike. sRGB is the piecewise curve of IEC 61966-2-1. The 8-bit value is
//! ⌊255 v + d⌋ with d ∈ [0,1) the interleaved gradient noise of the pixel (Jimenez 2014), shifted for each band: no banding,
//! deterministic, and exact black and white stay exact.

/// Exposed value k where the shoulder of the filmic curve begins.
const FILMIC_KNEE: f64 = 0.25;

/// Middle grey: the pivot of the contrast and the target of the automatic exposure.
const MIDDLE_GREY: f64 = 0.18;

/// The map from exposed to displayed values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ToneCurve {
    /// Identity in the shadows, a rational shoulder above a quarter; see the module's header.
    #[default]
    Filmic,
    /// Identity, clipped at 1.
    Linear,
}

impl ToneCurve {
    /// The name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            ToneCurve::Filmic => "filmic",
            ToneCurve::Linear => "linear",
        }
    }
    /// Displayed linear value, 0 to 1, of an exposed value; negative and NaN give 0.
    fn apply(self, x: f64) -> f64 {
        let x = if x > 0.0 { x } else { 0.0 };
        match self {
            ToneCurve::Linear => x.min(1.0),
            ToneCurve::Filmic if x <= FILMIC_KNEE => x,
            ToneCurve::Filmic if x == f64::INFINITY => 1.0,
            ToneCurve::Filmic => {
                let t = (x - FILMIC_KNEE) / (1.0 - FILMIC_KNEE);
                FILMIC_KNEE + (1.0 - FILMIC_KNEE) * t / (1.0 + t)
            }
        }
    }
}

impl ToneCurve {
    /// Displayed linear colour, 0 to 1, of an exposed one: the mean of the curve of each band and the curve that keeps the hue.
    pub fn colour(self, x: [f64; 3]) -> [f64; 3] {
        let y = x.map(|x| self.apply(x));
        let min = |c: [f64; 3]| c[0].min(c[1]).min(c[2]).max(0.0);
        let max = |c: [f64; 3]| c[0].max(c[1]).max(c[2]);
        let (lo, range) = (min(x), max(x) - min(x));
        if self == ToneCurve::Linear || !(range.is_finite() && range > 0.0) {
            return y;
        }
        let slope = (max(y) - min(y)) / range;
        [0, 1, 2].map(|b| 0.5 * (y[b] + min(y) + slope * (x[b].max(lo) - lo)))
    }
}

/// The sRGB transfer curve from 0…1 to 0…1.
pub(crate) fn encode_srgb(x: f64) -> f64 {
    if x <= 0.0031308 {
        12.92 * x
    } else if x >= 1.0 {
        1.0
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

/// The byte of a linear value from 0 to 1 in 8-bit sRGB, rounded.
pub fn srgb_to_byte(x: f32) -> u8 {
    (255.0 * encode_srgb(x as f64)).round().clamp(0.0, 255.0) as u8
}

/// Relative luminance (Rec. 709 weights) of a linear colour.
pub(crate) fn luminance(c: [f32; 3]) -> f64 {
    0.2126 * c[0] as f64 + 0.7152 * c[1] as f64 + 0.0722 * c[2] as f64
}

/// Automatic exposure: the log-mean luminance between the 2nd and the 98th percentile goes to 0.18, but the
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

/// The dither threshold of a band of a pixel, in [0, 1).
fn dither_threshold(x: usize, y: usize, band: usize) -> f64 {
    let (x, y) = (x as f64 + 47.0 * band as f64, y as f64 + 17.0 * band as f64);
    let inner = 0.06711056 * x + 0.00583715 * y;
    let outer = 52.9829189 * (inner - inner.floor());
    outer - outer.floor()
}

/// Parameters of tone mapping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToneMapping {
    /// Factor on the radiance, (m² sr)/W.
    pub exposure: f64,
    /// Exponent of the luminance relative to middle grey; 1 for none.
    pub contrast: f64,
    /// The tone curve.
    pub curve: ToneCurve,
}

impl ToneMapping {
    /// The filmic curve, contrast 1.
    pub fn filmic(exposure: f64) -> ToneMapping {
        ToneMapping { exposure, contrast: 1.0, curve: ToneCurve::Filmic }
    }
    /// The linear curve, clipped at 1, contrast 1.
    pub fn linear(exposure: f64) -> ToneMapping {
        ToneMapping { curve: ToneCurve::Linear, ..ToneMapping::filmic(exposure) }
    }
    /// The displayed sRGB values, 0 to 1, of a linear colour.
    fn display_value(&self, linear: [f32; 3]) -> [f64; 3] {
        let gain = self.exposure * self.contrast_gain(self.exposure * luminance(linear));
        self.curve.colour(linear.map(|x| x as f64 * gain)).map(encode_srgb)
    }
    /// The factor of the contrast at an exposed luminance.
    fn contrast_gain(&self, luminance: f64) -> f64 {
        let valid = luminance.is_finite() && luminance > 0.0;
        if self.contrast == 1.0 || !valid { 1.0 } else { (luminance / MIDDLE_GREY).powf(self.contrast - 1.0) }
    }
    /// The three bytes of a pixel of column `x` and row `y`.
    pub(super) fn bytes(&self, linear: [f32; 3], x: usize, y: usize) -> [u8; 3] {
        let v = self.display_value(linear);
        [0, 1, 2].map(|b| (255.0 * v[b] + dither_threshold(x, y, b)).floor().clamp(0.0, 255.0) as u8)
    }
    /// Number of pixels with a band within half a step of the brightest byte.
    pub fn count_clipped(&self, linear: &[[f32; 3]]) -> usize {
        linear.iter().filter(|c| self.display_value(**c).iter().any(|v| *v >= 254.5 / 255.0)).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_filmic_curve_is_monotone_smooth_and_the_identity_in_shadows() {
        assert_eq!(ToneCurve::Filmic.apply(0.1), 0.1);
        let mut last = 0.0;
        for i in 0..4000 {
            let y = ToneCurve::Filmic.apply(i as f64 * 0.01);
            assert!(y >= last && y - last <= 0.0100001 && y <= 1.0);
            last = y;
        }
        assert_eq!(ToneCurve::Filmic.apply(f64::NAN), 0.0);
        assert_eq!(ToneCurve::Filmic.apply(f64::INFINITY), 1.0);
    }

    // Guards (pictures): dither leaves no bands.
    /// A ramp of a hundredth of the range across 256 pixels, about three steps: each 8 × 8 block keeps its mean.
    #[test]
    fn dither_leaves_no_bands_in_a_ramp() {
        let tone = ToneMapping::filmic(1.0);
        for (from, to) in [(0.002f32, 0.003f32), (0.1, 0.103), (0.5, 0.52), (6.0, 7.0)] {
            let at = |x: usize| from + (to - from) * x as f32 / 256.0;
            for block in 0..32 * 4 {
                let (x0, y0) = (block % 32 * 8, block / 32 * 8);
                for b in 0..3 {
                    let (mut shown, mut exact) = (0.0, 0.0);
                    for i in 0..64 {
                        let (x, y) = (x0 + i % 8, y0 + i / 8);
                        shown += tone.bytes([at(x); 3], x, y)[b] as f64 / 64.0;
                        exact += 255.0 * tone.display_value([at(x); 3])[b] / 64.0;
                    }
                    assert!((shown - exact).abs() < 0.12, "{from}: block {block}, {shown} for {exact}");
                }
            }
        }
    }

    #[test]
    fn dither_keeps_exact_black_and_white() {
        let tone = ToneMapping::linear(1.0);
        for i in 0..4096 {
            assert_eq!(tone.bytes([0.0; 3], i % 64, i / 64), [0; 3]);
            assert_eq!(tone.bytes([1.0, 2.0, f32::INFINITY], i % 64, i / 64), [255; 3]);
            assert_eq!(tone.bytes([-1.0, f32::NAN, 0.0], i % 64, i / 64), [0; 3]);
        }
        assert_eq!(tone.count_clipped(&[[0.0; 3], [0.99; 3], [0.2, 1.0, 0.2], [5.0; 3]]), 2);
        assert_eq!(ToneMapping::filmic(1.0).count_clipped(&[[16.0; 3]]), 0);
    }

    #[test]
    fn contrast_pivots_on_grey_and_keeps_hues() {
        let (flat, hard) =
            (ToneMapping::linear(1.0), ToneMapping { contrast: 1.5, ..ToneMapping::linear(1.0) });
        let same = |a: [f64; 3], b: [f64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-6);
        assert!(same(flat.display_value([0.18; 3]), hard.display_value([0.18; 3])));
        assert!(flat.display_value([0.05; 3])[0] > hard.display_value([0.05; 3])[0]);
        assert!(flat.display_value([0.4; 3])[0] < hard.display_value([0.4; 3])[0]);
        let c = [0.3f32, 0.1, 0.05];
        let gain = hard.contrast_gain(luminance(c)) as f32;
        assert!(same(hard.display_value(c), flat.display_value(c.map(|x| gain * x))));
        assert_eq!(hard.display_value([0.0; 3]), [0.0; 3]);
    }

    /// Hues of bright coloured glass, up to two stops above white, turn by less than a sixth of the way to the next primary.
    #[test]
    fn the_shoulder_keeps_hues() {
        // Degrees where red is the largest band and blue the smallest.
        let hue = |c: [f64; 3]| 60.0 * (c[1] - c[2]) / (c[0] - c[2]);
        for c in [[4.0, 0.5, 0.2], [2.0, 1.0, 0.1], [1.0, 0.3, 0.05], [4.0, 3.0, 0.5]] {
            let shown = ToneCurve::Filmic.colour(c);
            assert!((hue(shown) - hue(c)).abs() < 10.0, "{c:?}: {} to {}", hue(c), hue(shown));
            assert!(shown[0] > shown[1] && shown[1] > shown[2]);
            assert_eq!(shown[0], ToneCurve::Filmic.apply(c[0]));
        }
        let bright = ToneCurve::Filmic.colour([400.0, 50.0, 20.0]);
        assert!(bright.iter().all(|x| *x > 0.9 && *x <= 1.0), "{bright:?}");
        for (same, f) in [([0.2, 0.1, 0.05], 0.2), ([2.0; 3], ToneCurve::Filmic.apply(2.0))] {
            let shown = ToneCurve::Filmic.colour(same);
            assert!((shown[0] - f).abs() < 1e-15 && (shown[1] / same[1] - shown[0] / same[0]).abs() < 1e-12);
        }
        for odd in [[f64::NAN, 1.0, 2.0], [f64::INFINITY, 1.0, 0.0], [-1.0, -2.0, 0.5]] {
            assert!(ToneCurve::Filmic.colour(odd).iter().all(|x| (0.0..=1.0).contains(x)), "{odd:?}");
        }
    }

    #[test]
    fn automatic_exposure_scales_with_the_scene_and_ignores_outliers() {
        let a: Vec<[f32; 3]> = (1..1000).map(|i| [i as f32 * 0.001; 3]).collect();
        let b: Vec<[f32; 3]> = a.iter().map(|c| c.map(|x| 100.0 * x)).collect();
        let ratio = auto_exposure(&a) / auto_exposure(&b);
        assert!((ratio - 100.0).abs() < 1e-3);
        assert_eq!(auto_exposure(&[[0.0; 3]]), 1.0);
        assert_eq!(auto_exposure(&[[f32::NAN; 3]]), 1.0);
        // A hundredth of the pixels very bright, or NaN.
        for spark in [1e6, f32::INFINITY, f32::NAN] {
            let mut sparks = a.clone();
            sparks.extend([[spark; 3]; 10]);
            assert!((auto_exposure(&sparks) / auto_exposure(&a) - 1.0).abs() < 0.03, "{spark}");
        }
    }
}
