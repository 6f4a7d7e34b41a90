//! Exchange along one line of frequencies: products with spectra, and the exchange of a line of voxels with the walls.
//!
//! With a linear basis a line has four components and each wall three. The exchange with a pair of opposite walls is split into parts even and odd
//! about the middle between them: every component of the voxels takes part in one of the two, so that a pair of components costs two products
//! instead of six.
//!
//! ```text
//!     ŵ_± = ŵ_low ± φ ŵ_high,   φ = e^{−2πi f (n−1)/N}         P̂ += Ŝ ŵ_±         û_± += Ŝ ŝ         ŵ_low = û_+ + û_−,   ŵ_high = φ* (û_+ − û_−)
//! ```

use std::ops::Range;
use zonal_fourier::Complex64;
use zonal_math::simd::{complex_parts, complex_parts_mut};

pub(super) const ZERO: Complex64 = Complex64 { re: 0.0, im: 0.0 };
/// Complex numbers in a line of the cache.
pub(super) const NUMBERS_PER_CACHE_LINE: usize = 4;

/// A frequency along the axis between a pair of walls.
#[derive(Clone, Copy)]
pub(super) struct FrequencyAcross {
    /// Shifts the low wall to the high one: φ.
    pub(super) phase: Complex64,
    /// Its weight in sums over the frequencies.
    pub(super) weight: f64,
}

/// Lines of a pair of opposite walls, by component of the patches: even and odd parts about the middle between the walls.
pub(super) struct WallPairLines {
    /// Radiation of the walls, ŵ_low ± e^{−2πi f (n−1)/N} ŵ_high.
    pub(super) sent: [Vec<Vec<Complex64>>; 2],
    /// Radiation of the voxels incident on the low wall.
    pub(super) met: [Vec<Vec<Complex64>>; 2],
}

/// Times i.
#[inline(always)]
pub(super) fn times_i(line: &mut [Complex64]) {
    line.iter_mut().for_each(|z| *z = Complex64::new(-z.im, z.re));
}

/// Times −i.
#[inline(always)]
pub(super) fn times_minus_i(line: &mut [Complex64]) {
    line.iter_mut().for_each(|z| *z = Complex64::new(z.im, -z.re));
}

/// Unfolds a spectrum, even or odd, from its first half, with a sign. Each value of `full` stands twice, for the real and for the imaginary part.
#[inline(always)]
pub(super) fn unfold(full: &mut [f64], half: &[f64], sign: f64, odd: bool) {
    let n = full.len() / 2;
    let other = if odd { -sign } else { sign };
    let (first, rest) = full.as_chunks_mut::<2>().0.split_at_mut(half.len());
    first.iter_mut().zip(half).for_each(|(x, h)| *x = [sign * h; 2]);
    rest.iter_mut().zip(half[..=n - half.len()].iter().rev()).for_each(|(x, h)| *x = [other * h; 2]);
}

/// Adds the products of a line with an unfolded spectrum.
#[inline(always)]
pub(super) fn add_product(sum: &mut [Complex64], line: &[Complex64], kernel: &[f64]) {
    let n = kernel.len();
    let (sum, line) = (&mut complex_parts_mut(sum)[..n], &complex_parts(line)[..n]);
    for i in 0..n {
        sum[i] += line[i] * kernel[i];
    }
}

/// Radiation of a line of voxels incident on the walls at its ends.
#[inline(always)]
pub(super) fn receive(kernel: &[f64], line: &[Complex64]) -> [Complex64; 2] {
    let mut sums = [ZERO; 2];
    for ((x, k), r) in line.iter().zip(kernel).zip(kernel.iter().rev()) {
        sums = [sums[0] + x * k, sums[1] + x * r];
    }
    sums
}

/// Adds the radiation of the walls at the ends of a line of voxels.
#[inline(always)]
pub(super) fn send(kernel: &[f64], line: &mut [Complex64], sent: [Complex64; 2]) {
    for ((x, k), r) in line.iter_mut().zip(kernel).zip(kernel.iter().rev()) {
        *x += sent[0] * k + sent[1] * r;
    }
}

/// Exchange of voxels with the walls across another axis in frequency space, by one component each.
#[inline(always)]
pub(super) fn exchange(
    line: &[Complex64],
    kernel: &[f64],
    added: &mut [Complex64],
    [low, high]: [&mut [Complex64]; 2],
    [from_low, from_high]: [&[Complex64]; 2],
    across: FrequencyAcross,
) {
    let FrequencyAcross { phase, weight } = across;
    let n = line.len();
    let (added, low, high) = (&mut added[..n], &mut low[..n], &mut high[..n]);
    let (kernel, from_low, from_high) = (&kernel.as_chunks::<2>().0[..n], &from_low[..n], &from_high[..n]);
    for i in 0..n {
        let u = line[i] * (kernel[i][0] * weight);
        low[i] += u;
        high[i] += u * phase.conj();
        added[i] += (from_low[i] + from_high[i] * phase) * kernel[i][0];
    }
}

impl WallPairLines {
    /// For a number of components of the patches and a length of the lines.
    pub(super) fn new(components: usize, length: usize) -> WallPairLines {
        let lines = || [(); 2].map(|_| vec![vec![ZERO; length]; components]);
        WallPairLines { sent: lines(), met: lines() }
    }
    /// Takes the spectra of the walls, given by component, into `place`, and forgets the incident radiation there. The odd part is multiplied by i, as the
    /// slope across the walls is.
    #[inline(always)]
    pub(super) fn load<'a>(
        &mut self,
        place: Range<usize>,
        sent: impl Fn(usize) -> [&'a [Complex64]; 2],
        phase: Complex64,
    ) {
        let [even, odd] = &mut self.sent;
        for (q, (even, odd)) in even.iter_mut().zip(odd).enumerate() {
            let [low, high] = sent(q);
            let own = even[place.clone()].iter_mut().zip(&mut odd[place.clone()]);
            for ((e, o), (l, h)) in own.zip(low.iter().zip(high)) {
                let shifted = h * phase;
                let difference = l - shifted;
                (*e, *o) = (l + shifted, Complex64::new(-difference.im, difference.re));
            }
        }
        self.met.iter_mut().flatten().for_each(|line| line[place.clone()].fill(ZERO));
    }
    /// Adds the incident radiation of component `q` in `place` to the low and the high wall.
    #[inline(always)]
    pub(super) fn store(
        &self,
        place: Range<usize>,
        q: usize,
        [low, high]: [&mut [Complex64]; 2],
        across: FrequencyAcross,
    ) {
        let FrequencyAcross { phase, weight } = across;
        let (even, odd) = (&self.met[0][q][place.clone()], &self.met[1][q][place]);
        for ((l, h), (e, o)) in low.iter_mut().zip(high).zip(even.iter().zip(odd)) {
            let (e, o) = (e * weight, Complex64::new(o.im, -o.re) * weight);
            *l += e + o;
            *h += (e - o) * phase.conj();
        }
    }
}
