//! Bloom: light that lens and eye scatter over the picture.
//!
//! ```text
//! L' = (1 − s) L + s Σ_k w_k G_k ∗ L        σ_k = 2^k σ_0,  w_k ∝ 0.8^k,  Σ w_k = 1
//! ```
//!
//! A glare that falls as the inverse square of the distance has the same light in every octave; this falls a little faster. Each G_k is
//! the one before blurred again (variances add), three times by a box along rows and columns, whose ends count in part so that its
//! variance is exact. What would fall beyond a border is mirrored back: the blur is a symmetric matrix whose rows and columns sum to one, so
//! that an even picture stays even up to its edges, and no light is lost.

use crate::Image;
use rayon::prelude::*;

/// σ_0 and the largest σ_k, in widths of the picture.
const SPREAD: (f64, f64) = (0.0015, 0.06);

/// w_{k+1} / w_k.
const FALL: f64 = 0.8;

/// Boxes a blur.
const BOXES: usize = 3;

type Colour = [f64; 3];

/// The picture with the share `strength`, 0 to 1, of its light scattered. Its mean is kept; pixels that are not numbers scatter nothing.
pub fn bloom(image: &Image, strength: f64) -> Image {
    if strength.is_nan() || strength <= 0.0 || image.pixels.is_empty() {
        return image.clone();
    }
    let strength = strength.min(1.0);
    let clean = |p: &[f32; 3]| p.map(|x| if x.is_finite() { x as f64 } else { 0.0 });
    let mut blurred: Vec<Colour> = image.pixels.iter().map(clean).collect();
    let mut glare = vec![[0.0; 3]; blurred.len()];
    let (mut sigma, mut before) = (SPREAD.0 * image.width as f64, 0.0);
    let octaves = (SPREAD.1 / SPREAD.0).log2().round() as usize + 1;
    let total: f64 = (0..octaves).map(|k| FALL.powi(k as i32)).sum();
    for k in 0..octaves {
        blurred = blur(blurred, image.width, (sigma * sigma - before * before).sqrt());
        let share = FALL.powi(k as i32) / total;
        glare.par_iter_mut().zip(&blurred).for_each(|(g, x)| (0..3).for_each(|b| g[b] += share * x[b]));
        (before, sigma) = (sigma, 2.0 * sigma);
    }
    let mixed = |(p, g): (&[f32; 3], &Colour)| {
        [0, 1, 2].map(|b| ((1.0 - strength) * p[b] as f64 + strength * g[b].max(0.0)) as f32)
    };
    Image { pixels: image.pixels.iter().zip(&glare).map(mixed).collect(), ..*image }
}

/// Blurred along rows and columns with the standard deviation `sigma`, pixels.
fn blur(pixels: Vec<Colour>, width: usize, sigma: f64) -> Vec<Colour> {
    let height = pixels.len() / width;
    let along = |lines: &mut [Colour], length: usize| {
        lines.par_chunks_mut(length).for_each_init(Vec::new, |room, line| boxes(line, sigma, room));
    };
    let mut rows = pixels;
    along(&mut rows, width);
    let mut columns = turned(&rows, width);
    along(&mut columns, height);
    turned(&columns, height)
}

/// Columns as rows.
fn turned(pixels: &[Colour], width: usize) -> Vec<Colour> {
    let height = pixels.len() / width;
    (0..width).into_par_iter().flat_map_iter(|x| (0..height).map(move |y| pixels[y * width + x])).collect()
}

/// A line blurred by boxes of half width `m` + 1/2, in which the pixels at the distance m + 1 count by the share `end`:
/// the variance is (Σ_{|i| ≤ m} i² + 2 end (m+1)²)/(2m + 1 + 2 end).
fn boxes(line: &mut [Colour], sigma: f64, sums: &mut Vec<Colour>) {
    let n = line.len();
    let wanted = sigma * sigma / BOXES as f64;
    // The widest of whole pixels with no more than this variance, m(m+1)/3; no wider than the line and its mirror image.
    let m = ((0.25 + 3.0 * wanted).sqrt() - 0.5).floor().max(0.0);
    let end = (wanted * (2.0 * m + 1.0) - m * (m + 1.0) * (2.0 * m + 1.0) / 3.0)
        / (2.0 * ((m + 1.0) * (m + 1.0) - wanted));
    let (m, end) = if m as usize + 1 > n { (n - 1, 1.0) } else { (m as usize, end.clamp(0.0, 1.0)) };
    let weight = 1.0 / (2.0 * m as f64 + 1.0 + 2.0 * end);
    for _ in 0..BOXES {
        // Sums of the line with its mirror images on both sides, from the pixel −(m + 1) on.
        let at = |i: isize| line[mirrored(i, n)];
        sums.clear();
        sums.push([0.0; 3]);
        let mut sum = [0.0; 3];
        for i in -(m as isize) - 1..(n + m + 1) as isize {
            let p = at(i);
            (0..3).for_each(|b| sum[b] += p[b]);
            sums.push(sum);
        }
        let out: Vec<Colour> = (0..n)
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

/// The pixel that stands at `i` when the line of `n` is mirrored at its borders: … 1 0 | 0 1 … n−1 | n−1 n−2 …
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
    fn no_strength_is_the_picture_to_the_bit() {
        let a = image(7, 5, |x, y| if x == 3 { f32::NAN } else { 0.1 * y as f32 });
        let same = |b: &Image| {
            a.pixels.iter().flatten().zip(b.pixels.iter().flatten()).all(|(x, y)| x.to_bits() == y.to_bits())
        };
        assert!(same(&bloom(&a, 0.0)) && same(&bloom(&a, -1.0)) && same(&bloom(&a, f64::NAN)));
    }

    #[test]
    fn light_is_kept_wherever_it_is() {
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
    fn an_even_picture_stays_even_to_its_edges() {
        let b = bloom(&image(90, 50, |_, _| 0.7), 1.0);
        assert!(b.pixels.iter().flatten().all(|x| (x / 0.7 - 1.0).abs() < 1e-6));
    }

    #[test]
    fn a_point_is_symmetric_and_falls() {
        let (n, c) = (401, 200);
        let b = bloom(&image(n, n, |x, y| if (x, y) == (c, c) { 1.0 } else { 0.0 }), 0.3);
        let at = |x: usize, y: usize| b.pixels[y * n + x][0] as f64;
        assert!(at(c, c) > 0.7 && at(c, c) < 0.8);
        for r in 1..190 {
            let four = [at(c + r, c), at(c - r, c), at(c, c + r), at(c, c - r)];
            assert!(four.iter().all(|x| (x - four[0]).abs() < 1e-4 * four[0] + 1e-12), "{r}: {four:?}");
            assert!(four[0] < at(c + r - 1, c) || four[0] < 1e-12, "{r}");
        }
        // Round: as bright on the diagonal as on the axis, where there is light.
        for (r, d) in [(10, 7), (24, 17), (41, 29)] {
            let far = (d as f64 * 2f64.sqrt() / r as f64).ln();
            assert!((at(c + d, c + d) / at(c + r, c)).ln().abs() < 0.15 + 3.0 * far.abs(), "{r}");
        }
        // It is wide: a twentieth of what is scattered lies farther than a twentieth of the width.
        let away = |x: usize, y: usize| (x as f64 - c as f64).hypot(y as f64 - c as f64) > 0.05 * n as f64;
        let far: f64 = (0..n * n).filter(|i| away(i % n, i / n)).map(|i| at(i % n, i / n)).sum();
        assert!(far > 0.05 * 0.3, "{far}");
    }

    #[test]
    fn boxes_have_the_variance_asked_for() {
        for sigma in [0.3, 1.0, 2.5, 9.0] {
            let mut line = vec![[0.0; 3]; 201];
            line[100] = [1.0; 3];
            boxes(&mut line, sigma, &mut Vec::new());
            let variance: f64 = line.iter().enumerate().map(|(i, p)| (i as f64 - 100.0).powi(2) * p[0]).sum();
            assert!((variance / (sigma * sigma) - 1.0).abs() < 1e-9, "{sigma}: {variance}");
        }
    }
}
