//! Subdivision of the octant of t into cells on which Gauss–Legendre rules converge fast.
//!
//! Cells that are large against their distance from t = 0, or optically thick, are cut. A cell whose proved upper bound is negligible is left out,
//! and the bound enters the radius. The cost is a midpoint estimate per cell.

use super::bernstein_ellipse;
use super::reduced_pair::{DensitySpan, ReducedPair};

/// The kernel t^power e^{−κ(r − r₀)} / r^q without its 1/π.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReducedKernel {
    /// Extinction, 1/m.
    pub kappa: f64,
    /// Distance r₀ that is taken out of the exponential, m.
    pub nearest: f64,
    /// Power of t on each axis.
    pub power: [i32; 3],
    /// Patches in the pair: q = 2 + patches.
    pub patches: i32,
}

impl ReducedKernel {
    /// The power of r in the denominator.
    pub(super) fn q(&self) -> i32 {
        2 + self.patches
    }
    /// e^{−κ(r − r₀)}.
    pub(super) fn decay(&self, r: f64) -> f64 {
        (-self.kappa * (r - self.nearest)).exp()
    }
    /// e^{−κ r₀}, the factor that [`ReducedKernel::decay`] omits.
    pub(super) fn decay_to_nearest(&self) -> f64 {
        (-self.kappa * self.nearest).exp()
    }
    /// The product of the powers of t.
    pub(super) fn numerator(&self, t: [f64; 3]) -> f64 {
        (0..3).map(|k| t[k].powi(self.power[k])).product()
    }
}

/// A product of three spans.
#[derive(Clone, Copy, Debug)]
pub(super) struct IntegrationCell {
    pub spans: [DensitySpan; 3],
    /// Bound of the relative errors of the spans' lo and len, in units of 2⁻⁵³.
    pub ulps: f64,
    /// Number of cuts that made the cell: each adds 4 · 2⁻⁵³ to the relative errors of the densities.
    pub cuts: f64,
}

impl IntegrationCell {
    /// A cell whose spans carry up to three roundings each.
    fn new(spans: [DensitySpan; 3]) -> IntegrationCell {
        IntegrationCell { spans, ulps: SPAN_ULPS, cuts: 1.0 }
    }

    /// True when the singular point t = 0 is a corner.
    pub(super) fn touches(&self) -> bool {
        self.spans.iter().all(|s| s.lo == 0.0)
    }
    /// Volume, the fixed axes left out.
    pub(super) fn volume(&self) -> f64 {
        self.spans.iter().filter(|s| s.len > 0.0).map(|s| s.len).product()
    }
    pub(super) fn lower(&self) -> [f64; 3] {
        self.spans.map(|s| s.lo)
    }
    pub(super) fn upper(&self) -> [f64; 3] {
        self.spans.map(|s| s.hi())
    }
    /// An upper bound of the density.
    pub(super) fn max_weight(&self) -> f64 {
        self.spans.iter().map(DensitySpan::max_weight).product()
    }
    /// The near part, of the given length along the axis, and the rest. A half is exact and its far corner one sum;
    /// the rest of another cut is a difference a − b with a > 1.5 b, which amplifies by (a + b)/(a − b) < 5.
    fn cut_at(&self, axis: usize, length: f64) -> (IntegrationCell, IntegrationCell) {
        let (near, far) = self.spans[axis].cut_at(length);
        let halved = near.len == far.len;
        let cuts = self.cuts + 1.0;
        let (mut n, mut f) = (IntegrationCell { cuts, ..*self }, IntegrationCell { cuts, ..*self });
        f.ulps = 1.0 + if halved { self.ulps } else { DIFFERENCE_AMPLIFICATION * self.ulps };
        (n.spans[axis], f.spans[axis]) = (near, far);
        (n, f)
    }

    /// Estimate of the integral by the midpoint rule, in pyramid coordinates where the cell touches zero.
    pub(super) fn midpoint_estimate(&self, kernel: &ReducedKernel) -> f64 {
        let w: f64 = self.spans.iter().map(|s| 0.5 * (s.w0 + s.w1)).product();
        let value = |t: [f64; 3], q: i32| {
            let r = norm(t);
            kernel.numerator(t) * kernel.decay(r) * r.powi(-q)
        };
        if !self.touches() {
            return self.volume() * w * value(self.spans.map(|s| s.lo + 0.5 * s.len), kernel.q());
        }
        let apex = |k: usize| {
            let t: [f64; 3] = std::array::from_fn(|j| self.spans[j].len * if j == k { 0.5 } else { 0.25 });
            value(t, kernel.q())
        };
        // At s = v = w = 1/2 the Jacobian is s² = 1/4.
        0.25 * self.volume() * w * (apex(0) + apex(1) + apex(2))
    }

    /// A proved upper bound of the integral.
    ///
    /// Either volume × the largest density, numerator and 1/r^q e^{−κr}; or, since numerator ≤ r^m and e ≤ 1, the
    /// integral of 1/r² over a slab of thickness δ (the smallest edge) and a quarter disc of radius D (the cell's
    /// farthest distance): ∫₀^δ (π/4) ln(1 + D²/x²) dx ≤ (π/2) δ (ln(D/δ) + 3/2).
    pub(super) fn upper_bound(&self, kernel: &ReducedKernel) -> f64 {
        let near = norm(self.lower());
        let far = self.upper();
        let plain = self.volume()
            * kernel.numerator(far)
            * near.powi(-kernel.q())
            * kernel.decay(near.max(kernel.nearest));
        if self.spans.iter().any(|s| s.len == 0.0) {
            return BOUND_ROUNDING * self.max_weight() * plain;
        }
        let thin = self.spans.iter().map(|s| s.len).fold(f64::INFINITY, f64::min);
        let slab = slab(thin, norm(far)) * kernel.decay(near.max(kernel.nearest));
        // A NaN in `plain` (0/0 at a touching corner) loses against `slab`.
        BOUND_ROUNDING * self.max_weight() * slab.min(plain)
    }

    /// The axis along which the cell must be cut before it is integrated, and the length of the near part.
    fn cut_position(&self, kernel: &ReducedKernel) -> Option<(usize, f64)> {
        if self.touches() {
            self.cut_touching(kernel)
        } else {
            self.cut_apart(kernel).map(|k| (k, 0.5 * self.spans[k].len))
        }
    }

    /// Pyramid coordinates converge fast for edges of similar length and of few mean free paths. A long edge is halved while it stays
    /// long, then cut to the shortest: halving alone may not terminate.
    fn cut_touching(&self, kernel: &ReducedKernel) -> Option<(usize, f64)> {
        let len = self.spans.map(|s| s.len);
        let longest = (0..3).fold(0, |m, k| if len[k] > len[m] { k } else { m });
        let shortest = len.iter().copied().fold(f64::INFINITY, f64::min);
        let half = 0.5 * len[longest];
        if len[longest] > MAX_TOUCHING_ASPECT * shortest {
            Some((longest, if half > MAX_TOUCHING_ASPECT * shortest { half } else { shortest }))
        } else {
            (kernel.kappa * len[longest] > MAX_TOUCHING_DEPTH).then_some((longest, half))
        }
    }

    /// The axis of the cut of a separated cell: by the distance of the nearest singularity, then by the variation of κr along a direction.
    fn cut_apart(&self, kernel: &ReducedKernel) -> Option<usize> {
        let lo2 = self.spans.map(|s| s.lo * s.lo);
        let (mut narrowest, mut rho) = (0, f64::INFINITY);
        let (mut thickest, mut depth) = (0, 0.0);
        for k in (0..3).filter(|&k| self.spans[k].len > 0.0) {
            let DensitySpan { lo, len, .. } = self.spans[k];
            let c2 = lo2[(k + 1) % 3] + lo2[(k + 2) % 3];
            let r = bernstein_ellipse::widest_rho(lo, len, c2);
            if r < rho {
                (narrowest, rho) = (k, r);
            }
            let (from, to) = (c2 + lo * lo, c2 + (lo + len) * (lo + len));
            let d = kernel.kappa * (to.sqrt() - from.sqrt());
            if d > depth {
                (thickest, depth) = (k, d);
            }
        }
        if rho < MIN_ELLIPSE_PARAMETER {
            Some(narrowest)
        } else {
            (depth > MAX_DEPTH_VARIATION).then_some(thickest)
        }
    }
}

/// Bound of ∫ 1/r² over a slab of thickness `thin` and a quarter disc of radius `far` ≥ √3 `thin`:
/// (π/2) thin (ln(far/thin) + 3/2).
fn slab(thin: f64, far: f64) -> f64 {
    SLAB_FACTOR * thin * ((far / thin).ln() + SLAB_CONSTANT)
}

/// The slab's factor π/2.
const SLAB_FACTOR: f64 = std::f64::consts::FRAC_PI_2; // bound
/// The slab's constant term.
const SLAB_CONSTANT: f64 = 1.5; // bound
/// The rounding of an upper bound itself.
const BOUND_ROUNDING: f64 = 1.000_001; // bound
/// Roundings in lo and len of a span: a difference of coordinates, one of lengths, a sum.
const SPAN_ULPS: f64 = 3.0; // bound
/// (a + b)/(a − b) for a ≥ `MAX_TOUCHING_ASPECT` b: amplification of relative errors by a difference.
const DIFFERENCE_AMPLIFICATION: f64 = 5.0; // bound

// Limits of the cells that are integrated without further cuts.

/// Longest over shortest edge of an undivided touching cell.
const MAX_TOUCHING_ASPECT: f64 = 1.5;
/// Longest edge of an undivided touching cell, mean free paths.
const MAX_TOUCHING_DEPTH: f64 = 4.0;
/// Largest variation of κr along an edge of a separated cell.
const MAX_DEPTH_VARIATION: f64 = 6.0;
/// Smallest ellipse parameter ϱ of a direction of an undivided cell.
const MIN_ELLIPSE_PARAMETER: f64 = 3.0;
/// Leaves, at most; further cells stay undivided with the radius that they have.
const MAX_LEAVES: usize = 400_000;

pub(super) fn norm(t: [f64; 3]) -> f64 {
    (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]).sqrt()
}

/// The cells of a pair, ready to be integrated.
pub(super) struct CellSubdivision {
    pub kernel: ReducedKernel,
    /// Cells with their estimated integrals.
    pub leaves: Vec<(IntegrationCell, f64)>,
    /// Sum of the estimated integrals.
    pub total: f64,
    /// Proved upper bound of the integrals left out.
    pub dropped: f64,
    /// Multiplicity of the sum from folded axes.
    pub multiplicity: f64,
}

/// Cuts the density of a pair into cells. A cell below the share `negligible` of the estimates so far is left out.
pub(super) fn subdivide(pair: &ReducedPair, kappa: f64, negligible: f64) -> CellSubdivision {
    let [(x, mx), (y, my), (z, mz)] = [pair.0[0].spans(), pair.0[1].spans(), pair.0[2].spans()];
    let least = |s: &[DensitySpan]| s.iter().map(|s| s.lo).fold(f64::INFINITY, f64::min);
    let kernel = ReducedKernel {
        kappa,
        nearest: norm([least(&x), least(&y), least(&z)]),
        power: pair.0.map(|a| a.power()),
        patches: pair.patches(),
    };
    let mut stack = Vec::with_capacity(x.len() * y.len() * z.len() + 32);
    for &sx in &x {
        for &sy in &y {
            for &sz in &z {
                let cell = IntegrationCell::new([sx, sy, sz]);
                stack.push((cell, cell.midpoint_estimate(&kernel)));
            }
        }
    }
    stack.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut division = CellSubdivision {
        kernel,
        leaves: Vec::with_capacity(stack.len()),
        total: 0.0,
        dropped: 0.0,
        multiplicity: mx * my * mz,
    };
    while let Some((cell, weight)) = stack.pop() {
        division.process(cell, weight, negligible, &mut stack);
    }
    division
}

impl CellSubdivision {
    /// Leaves a cell out, keeps it as a leaf, or cuts it in two (the nearer half is processed first).
    fn process(
        &mut self,
        cell: IntegrationCell,
        weight: f64,
        negligible: f64,
        stack: &mut Vec<(IntegrationCell, f64)>,
    ) {
        let kernel = self.kernel;
        // Only a cell with a small estimate can have a negligible bound.
        let light = negligible * self.total;
        if weight <= light {
            let bound = cell.upper_bound(&kernel);
            if bound <= light {
                self.dropped += bound;
                return;
            }
        }
        let room = self.leaves.len() + stack.len() < MAX_LEAVES;
        match cell.cut_position(&kernel) {
            Some((axis, length)) if room => {
                let (near, far) = cell.cut_at(axis, length);
                stack.push((far, far.midpoint_estimate(&kernel)));
                stack.push((near, near.midpoint_estimate(&kernel)));
            }
            _ => {
                self.total += weight;
                self.leaves.push((cell, weight));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_4;

    #[test]
    fn slab_bound_is_above_integral() {
        let mut tightest: f64 = 0.0;
        for i in 0..60 {
            let (thin, far) = (1.0, 3f64.sqrt() * 1.5f64.powi(i));
            // ∫₀^δ (π/4) ln(1 + D²/x²) dx in closed form.
            let exact =
                FRAC_PI_4 * (thin * (1.0 + far * far / (thin * thin)).ln() + 2.0 * far * (thin / far).atan());
            assert!(exact <= slab(thin, far), "{far}");
            tightest = tightest.max(exact / slab(thin, far));
        }
        assert!(tightest > 0.9, "{tightest}");
    }

    #[test]
    fn cell_upper_bound_is_sharp_for_flat_integrand() {
        // Far away the integrand is all but constant: the bound is no more than the integral, rounded up.
        let span = |lo: f64| DensitySpan { lo, len: 1e-9 * lo, w0: 0.7, w1: 0.7 };
        let cell = IntegrationCell::new([span(1.0), span(2.0), span(2.0)]);
        let kernel = ReducedKernel { kappa: 0.0, nearest: 3.0, power: [0; 3], patches: 0 };
        let exact = cell.volume() * 0.7f64.powi(3) / 9.0;
        let bound = cell.upper_bound(&kernel);
        assert!(bound > exact && bound < 1.000_01 * exact, "{bound} {exact}");
    }

    /// A length of a level piece is a difference of two differences; a piece cut at zero, a sum of one; each carries one rounding of its own.
    #[test]
    fn rounding_constants_cover_their_counts() {
        let (difference, of_lengths, sum) = (1.0, 1.0, 1.0);
        let counted = [
            (SPAN_ULPS, difference + of_lengths + sum),
            (DIFFERENCE_AMPLIFICATION, (MAX_TOUCHING_ASPECT + 1.0) / (MAX_TOUCHING_ASPECT - 1.0)),
        ];
        for (constant, derived) in counted {
            assert!(constant >= derived * (1.0 - f64::EPSILON), "{constant} {derived}");
        }
    }
}
