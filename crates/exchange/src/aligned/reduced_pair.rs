//! Reduction of two boxes to the density of t = x_b − x_a, axis by axis, in the positive octant.
//!
//! On an axis where both boxes have an extent, long ≥ short > 0, the density of t is the trapezoid with
//! breakpoints p₀ < p₁ ≤ p₂ < p₃, rising over `short`, level at height `short` over `long − short`, falling over
//! `short`. Where one extent is zero it is 1 on [p₀, p₃] of width `long`; where both are zero t is fixed at p₀.
//! Breakpoints and widths have **relative errors of about one ulp each**, so that the nodes of every quadrature, lo + u·len with
//! all terms positive, have small relative errors at any distance of the boxes.

use super::cuboid::Cuboid;

/// A piece of an axis, t ∈ [lo, lo + len] with lo ≥ 0 and a density linear from `w0` to `w1`, both ≥ 0.
/// `len` = 0 where t is fixed.
#[derive(Clone, Copy, Debug)]
pub(super) struct DensitySpan {
    pub lo: f64,
    pub len: f64,
    pub w0: f64,
    pub w1: f64,
}

impl DensitySpan {
    pub(super) fn hi(&self) -> f64 {
        self.lo + self.len
    }
    pub(super) fn max_weight(&self) -> f64 {
        self.w0.max(self.w1)
    }
    /// The near part, of the given length, and the rest.
    pub(super) fn cut_at(&self, length: f64) -> (DensitySpan, DensitySpan) {
        let rest = self.len - length;
        let w = (self.w0 * rest + self.w1 * length) / self.len;
        let near = DensitySpan { len: length, w1: w, ..*self };
        let far = DensitySpan { lo: self.lo + length, len: rest, w0: w, w1: self.w1 };
        (near, far)
    }
}

/// (from, to, width, weight at from, weight at to).
type TrapezoidPiece = (f64, f64, f64, f64, f64);

/// The density of t on one axis: the extents of the two boxes and the breakpoints.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisDensity {
    pub long: f64,
    pub short: f64,
    pub p: [f64; 4],
}

impl AxisDensity {
    /// The power of |t| in the numerator of the kernel: the number of boxes that are flat on this axis.
    pub(super) fn power(&self) -> i32 {
        (self.long == 0.0) as i32 + (self.short == 0.0) as i32
    }

    /// The density of −t.
    pub(super) fn reflected(&self) -> AxisDensity {
        let [a, b, c, d] = self.p;
        AxisDensity { p: [-d, -c, -b, -a], ..*self }
    }

    /// The pieces of the density and their number.
    fn pieces(&self) -> ([TrapezoidPiece; 3], usize) {
        let AxisDensity { long, short, p } = *self;
        const NO_PIECE: TrapezoidPiece = (0.0, 0.0, 0.0, 0.0, 0.0);
        match self.power() {
            2 => ([(p[0], p[0], 0.0, 1.0, 1.0), NO_PIECE, NO_PIECE], 1),
            1 => ([(p[0], p[3], long, 1.0, 1.0), NO_PIECE, NO_PIECE], 1),
            _ => {
                let rise = (p[0], p[1], short, 0.0, short);
                let level = (p[1], p[2], long - short, short, short);
                let fall = (p[2], p[3], short, short, 0.0);
                if long > short { ([rise, level, fall], 3) } else { ([rise, fall, NO_PIECE], 2) }
            }
        }
    }

    /// The pieces cut at zero and folded onto t ≥ 0, and their multiplicity. With a flat box on this axis
    /// (cosine factor) only t > 0 counts; a density even in t is folded into twice its positive half.
    pub(super) fn spans(&self) -> (Vec<DensitySpan>, f64) {
        let cut = self.power() > 0;
        let even = !cut && self.p[0] == -self.p[3] && self.p[1] == -self.p[2];
        let mut spans = Vec::with_capacity(4);
        let (pieces, count) = self.pieces();
        for &(from, to, len, w0, w1) in &pieces[..count] {
            if from >= 0.0 {
                spans.push(DensitySpan { lo: from, len, w0, w1 });
            } else if to <= 0.0 {
                if !cut && !even {
                    spans.push(DensitySpan { lo: -to, len, w0: w1, w1: w0 });
                }
            } else {
                let w = (w0 * to + w1 * -from) / (to - from);
                spans.push(DensitySpan { lo: 0.0, len: to, w0: w, w1 });
                if !cut && !even {
                    spans.push(DensitySpan { lo: 0.0, len: -from, w0: w, w1: w0 });
                }
            }
        }
        (spans, if even { 2.0 } else { 1.0 })
    }
}

/// The three densities of a pair whose flat boxes, if any, face positive t.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReducedPair(pub [AxisDensity; 3]);

impl ReducedPair {
    /// The number of patches in the pair.
    pub(super) fn patches(&self) -> i32 {
        self.0.iter().map(AxisDensity::power).sum()
    }
    /// False if a patch of the pair has the other box behind it or in its plane.
    pub(super) fn is_visible(&self) -> bool {
        self.0.iter().all(|a| a.power() == 0 || a.p[3] > 0.0)
    }
}

/// The sign that t must have on each axis (0 on axes without a normal), or `None` when two normals disagree.
pub(super) fn orientation(a: Option<(usize, i8)>, b: Option<(usize, i8)>) -> Option<[i8; 3]> {
    let mut sign = [0i8; 3];
    if let Some((axis, s)) = a {
        sign[axis] = s;
    }
    if let Some((axis, s)) = b {
        if sign[axis] == s {
            return None;
        }
        sign[axis] = -s;
    }
    Some(sign)
}

/// Breakpoints below this share of the longer extent are rounding noise of coordinates that should be zero: they change the integral by
/// less than its rounding, and their squares underflow.
const MIN_RELATIVE_BREAKPOINT: f64 = 1e-60;

/// The reduced pair of two boxes, straight from their coordinates (one rounding per length and breakpoint);
/// `None` when the boxes are not visible from each other.
pub(super) fn reduce(a: &Cuboid, b: &Cuboid) -> Option<ReducedPair> {
    let sign = orientation(a.normal, b.normal)?;
    let density = |k: usize| {
        let (la, lb) = (a.hi[k] - a.lo[k], b.hi[k] - b.lo[k]);
        let (q, r) = (b.lo[k] - a.lo[k], b.hi[k] - a.hi[k]);
        let p = [b.lo[k] - a.hi[k], q.min(r), q.max(r), b.hi[k] - a.lo[k]];
        let mut d = AxisDensity { long: la.max(lb), short: la.min(lb), p };
        // Where both are flat the breakpoint is their distance, which is never zero.
        if d.power() < 2 {
            let least = MIN_RELATIVE_BREAKPOINT * d.long;
            d.p = d.p.map(|p| if p.abs() < least { 0.0 } else { p });
        }
        if sign[k] < 0 { d.reflected() } else { d }
    };
    let reduced = ReducedPair([density(0), density(1), density(2)]);
    reduced.is_visible().then_some(reduced)
}
