//! Bloom: glare that lens and eye scatter over the picture.
//!
//! ```text
//! L' = (1 − s) L + s Σ_k w_k G_k ∗ L        σ_k = 2^k σ_0,  w_k ∝ 0.8^k,  Σ w_k = 1
//! ```
//!
//! Glare that falls with the inverse square of the distance has equal power in every octave; this one falls a little faster. Each Gaussian G_k
//! is the previous one blurred again (variances add), three times by a box along rows and columns (Wells, PAMI 1986) whose fractional
//! ends make its variance exact. Light beyond a border is mirrored back: the blur is a symmetric matrix whose rows and columns sum to
//! one, so that a uniform picture stays uniform up to its edges and the mean is conserved. Cost: linear in pixels, for each octave.

use crate::image::Image;
use rayon::prelude::*;
use zonal_math::parallel;

// Shape of the glare.

/// σ_0, widths of the picture.
const MIN_SIGMA: f64 = 0.0015;
/// The largest σ_k, widths of the picture.
const MAX_SIGMA: f64 = 0.06;
/// w_{k+1} / w_k.
const OCTAVE_RATIO: f64 = 0.8;

/// Box filters that approximate one Gaussian.
const BOXES_PER_BLUR: usize = 3;

type LinearColour = [f64; 3];

/// The picture with the share `strength`, 0 to 1, of its light scattered. The mean is conserved; pixels that are not finite scatter nothing.
///
/// ```
/// use zonal_render::{Image, bloom};
///
/// let mut image = Image { width: 64, height: 48, pixels: vec![[0.0; 3]; 64 * 48] };
/// image.pixels[24 * 64 + 32] = [100.0; 3];
/// let glare = bloom(&image, 0.2);
/// let total = |image: &Image| image.pixels.iter().map(|p| p[0] as f64).sum::<f64>();
/// assert!((total(&glare) / total(&image) - 1.0).abs() < 1e-6);
/// assert!(glare.pixels[24 * 64 + 40][0] > 0.0);
/// ```
pub fn bloom(image: &Image, strength: f64) -> Image {
    if strength.is_nan() || strength <= 0.0 || image.pixels.is_empty() {
        return image.clone();
    }
    let strength = strength.min(1.0);
    let finite = |p: &[f32; 3]| p.map(|x| if x.is_finite() { x as f64 } else { 0.0 });
    let mut blurred: Vec<LinearColour> = image.pixels.iter().map(finite).collect();
    let mut glare = vec![[0.0; 3]; blurred.len()];
    let (mut sigma, mut before) = (MIN_SIGMA * image.width as f64, 0.0);
    let octaves = (MAX_SIGMA / MIN_SIGMA).log2().round() as usize + 1;
    let total: f64 = (0..octaves).map(|k| OCTAVE_RATIO.powi(k as i32)).sum();
    for k in 0..octaves {
        blurred = blur(blurred, image.width, (sigma * sigma - before * before).sqrt());
        let share = OCTAVE_RATIO.powi(k as i32) / total;
        parallel::for_each_pair(&mut glare, &blurred, |g, x| (0..3).for_each(|b| g[b] += share * x[b]));
        (before, sigma) = (sigma, 2.0 * sigma);
    }
    let mixed = |(p, g): (&[f32; 3], &LinearColour)| {
        [0, 1, 2].map(|b| ((1.0 - strength) * p[b] as f64 + strength * g[b].max(0.0)) as f32)
    };
    Image { pixels: image.pixels.iter().zip(&glare).map(mixed).collect(), ..*image }
}

/// Blurred along rows and columns with the standard deviation `sigma`, pixels.
fn blur(pixels: Vec<LinearColour>, width: usize, sigma: f64) -> Vec<LinearColour> {
    let height = pixels.len() / width;
    let along = |lines: &mut [LinearColour], length: usize| {
        lines.par_chunks_mut(length).for_each_init(Vec::new, |sums, line| box_blur(line, sigma, sums));
    };
    let mut rows = pixels;
    along(&mut rows, width);
    let mut columns = transposed(&rows, width);
    along(&mut columns, height);
    transposed(&columns, height)
}

/// The picture with rows and columns exchanged.
fn transposed(pixels: &[LinearColour], width: usize) -> Vec<LinearColour> {
    let height = pixels.len() / width;
    (0..width).into_par_iter().flat_map_iter(|x| (0..height).map(move |y| pixels[y * width + x])).collect()
}

/// A line blurred by boxes of half width `m` + 1/2, in which the pixels at the distance m + 1 count by the share `end`:
/// the variance is (Σ_{|i| ≤ m} i² + 2 end (m+1)²)/(2m + 1 + 2 end).
fn box_blur(line: &mut [LinearColour], sigma: f64, sums: &mut Vec<LinearColour>) {
    let n = line.len();
    let variance = sigma * sigma / BOXES_PER_BLUR as f64;
    // Take the widest box of whole pixels with at most this variance, m(m+1)/3, and at most as wide as the line and its mirror image.
    let m = ((0.25 + 3.0 * variance).sqrt() - 0.5).floor().max(0.0);
    let end = (variance * (2.0 * m + 1.0) - m * (m + 1.0) * (2.0 * m + 1.0) / 3.0)
        / (2.0 * ((m + 1.0) * (m + 1.0) - variance));
    let (m, end) = if m as usize + 1 > n { (n - 1, 1.0) } else { (m as usize, end.clamp(0.0, 1.0)) };
    let weight = 1.0 / (2.0 * m as f64 + 1.0 + 2.0 * end);
    for _ in 0..BOXES_PER_BLUR {
        // Sum the line with its mirror images on both sides, from the pixel −(m + 1) on.
        let at = |i: isize| line[mirrored(i, n)];
        sums.clear();
        sums.push([0.0; 3]);
        let mut sum = [0.0; 3];
        for i in -(m as isize) - 1..(n + m + 1) as isize {
            let p = at(i);
            (0..3).for_each(|b| sum[b] += p[b]);
            sums.push(sum);
        }
        let out: Vec<LinearColour> = (0..n)
            .map(|i| {
                let ends = (at(i as isize - m as isize - 1), at((i + m + 1) as isize));
                [0, 1, 2].map(|b| {
                    weight * (sums[i + 2 * m + 2][b] - sums[i + 1][b] + end * (ends.0[b] + ends.1[b]))
                })
            })
            .collect();
        line.copy_from_slice(&out);
    }
}

/// Index of the pixel at `i` when the line of `n` is mirrored at its borders: … 1 0 | 0 1 … n−1 | n−1 n−2 …
fn mirrored(i: isize, n: usize) -> usize {
    let i = i.rem_euclid(2 * n as isize) as usize;
    if i < n { i } else { 2 * n - 1 - i }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: usize, height: usize, f: impl Fn(usize, usize) -> f32) -> Image {
        let pixels = (0..width * height).map(|i| [f(i % width, i / width); 3]).collect();
        Image { width, height, pixels }
    }

    fn light(i: &Image) -> f64 {
        i.pixels.iter().map(|p| p[1] as f64).sum()
    }

    #[test]
    fn zero_strength_returns_the_picture_to_the_bit() {
        let a = image(7, 5, |x, y| if x == 3 { f32::NAN } else { 0.1 * y as f32 });
        let same = |b: &Image| {
            a.pixels.iter().flatten().zip(b.pixels.iter().flatten()).all(|(x, y)| x.to_bits() == y.to_bits())
        };
        assert!(same(&bloom(&a, 0.0)) && same(&bloom(&a, -1.0)) && same(&bloom(&a, f64::NAN)));
    }

    // Guards (pictures): bloom conserves light and uniform pictures.
    #[test]
    fn bloom_conserves_light_everywhere() {
        for (w, h) in [(64, 40), (40, 64), (5, 3), (1, 9), (1, 1), (301, 2)] {
            for (x0, y0) in [(0, 0), (w - 1, h / 2), (w / 2, h - 1), (w / 2, h / 2)] {
                let a = image(w, h, |x, y| if (x, y) == (x0, y0) { 1000.0 } else { 0.01 * (x + y) as f32 });
                for strength in [0.05, 0.5, 1.0] {
                    let b = bloom(&a, strength);
                    assert!((light(&b) / light(&a) - 1.0).abs() < 1e-6, "{w}×{h} {x0} {y0}");
                    assert!(b.pixels.iter().flatten().all(|x| *x >= 0.0));
                }
            }
        }
    }

    #[test]
    fn uniform_picture_stays_uniform_to_its_edges() {
        let b = bloom(&image(90, 50, |_, _| 0.7), 1.0);
        assert!(b.pixels.iter().flatten().all(|x| (x / 0.7 - 1.0).abs() < 1e-6));
    }

    #[test]
    fn glare_of_a_point_is_symmetric_and_decreases() {
        let (n, c) = (401, 200);
        let b = bloom(&image(n, n, |x, y| if (x, y) == (c, c) { 1.0 } else { 0.0 }), 0.3);
        let at = |x: usize, y: usize| b.pixels[y * n + x][0] as f64;
        assert!(at(c, c) > 0.7 && at(c, c) < 0.8);
        for r in 1..190 {
            let four = [at(c + r, c), at(c - r, c), at(c, c + r), at(c, c - r)];
            assert!(four.iter().all(|x| (x - four[0]).abs() < 1e-4 * four[0] + 1e-12), "{r}: {four:?}");
            assert!(four[0] < at(c + r - 1, c) || four[0] < 1e-12, "{r}");
        }
        // The glare is round: equal on the diagonal and on the axis.
        for (r, d) in [(10, 7), (24, 17), (41, 29)] {
            let far = (d as f64 * 2f64.sqrt() / r as f64).ln();
            assert!((at(c + d, c + d) / at(c + r, c)).ln().abs() < 0.15 + 3.0 * far.abs(), "{r}");
        }
        // It is wide: a twentieth of the scattered light lies beyond a twentieth of the width.
        let away = |x: usize, y: usize| (x as f64 - c as f64).hypot(y as f64 - c as f64) > 0.05 * n as f64;
        let far: f64 = (0..n * n).filter(|i| away(i % n, i / n)).map(|i| at(i % n, i / n)).sum();
        assert!(far > 0.05 * 0.3, "{far}");
    }

    #[test]
    fn box_blur_has_the_requested_variance() {
        for sigma in [0.3, 1.0, 2.5, 9.0] {
            let mut line = vec![[0.0; 3]; 201];
            line[100] = [1.0; 3];
            box_blur(&mut line, sigma, &mut Vec::new());
            let variance: f64 = line.iter().enumerate().map(|(i, p)| (i as f64 - 100.0).powi(2) * p[0]).sum();
            assert!((variance / (sigma * sigma) - 1.0).abs() < 1e-9, "{sigma}: {variance}");
        }
    }
}
