//! Exchange factors of axis-aligned boxes and rectangles by integration along rays, with an error bound.
//!
//! ```text
//! 𝓕 = (1/π) ∬ e^{−κr} [max(0, cosθ_a)] [max(0, cosθ_b)] / r² = (1/π) ∫ ω(t) |t|^p e^{−κ|t|} / |t|^{2+m} dt,   t = x_b − x_a
//! ```
//!
//! with m patches, p_k of them flat on axis k, and ω the product over the axes of the densities of t: where both boxes have
//! an extent, long ≥ short, a trapezoid of height `short`; 1 where one is flat; a fixed t where both are.
//! The densities are cut at their kinks and at zero and mirrored onto t ≥ 0; a product of three pieces is a cell [a, b].
//!
//! **Along a ray** t = s x the powers of s cancel and ω is a cubic between the points where the ray enters and leaves the cell:
//! its integral with e^{−κ|x|s} is a closed form (`ray_integral`). There remain two dimensions of the face by which the ray enters
//! (dV = s² x_k ds dx_j dx_i on the face t_k = a_k), or leaves where the cell has a corner at zero. A ray that enters by face k
//! leaves by the face whose b/x is least, so three regions without kinks make up a face:
//!
//! ```text
//! through k:  a_j ≤ x_j ≤ b_j a_k/b_k,   a_i ≤ x_i ≤ b_i a_k/b_k                           leaves at s = b_k/a_k
//! side j:     max(a_j, b_j a_k/b_k, a_i b_j/b_i) ≤ x_j ≤ b_j,   a_i ≤ x_i ≤ b_i x_j/b_j    leaves at s = b_j/x_j
//! side i:     the same with i and j exchanged.
//! ```
//!
//! Every length — of the ray in the cell, from the ray's ends to the cell's planes — is a sum of positive terms: distances from the
//! ends of the regions, which the tanh–sinh rule provides to relative accuracy, and constants computed in `DoubleDouble` from the
//! boxes' coordinates. So nothing cancels, however thin, far or close the boxes are.
//!
//! **Error**: the difference of the last two levels of the rule, summed over the regions, and the rounding: a term carries
//! at most about sixty roundings, and its exponential four for each unit of κr, doubled.

use crate::numerics::double_double::{DoubleDouble, difference};
use crate::numerics::tanh_sinh::{LEVEL_STEPS, QuadratureNode, SingularInterval, rule};

/// A box, or a rectangle: zero extent on the axis of its normal (axis, sign). Metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlignedBox {
    /// Lower corner.
    pub lo: [f64; 3],
    /// Upper corner.
    pub hi: [f64; 3],
    /// Axis and sign of a rectangle's normal.
    pub normal: Option<(usize, i8)>,
}

/// A factor and its error bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FactorValue {
    /// The factor, m⁴, m³ or m².
    pub value: f64,
    /// Bound of the error, in the same unit.
    pub error: f64,
}

/// A piece of an axis: [a, b] with a density that is linear from w[0] to w[1]; a = b where t is fixed.
#[derive(Clone, Copy, Debug)]
struct DensityPiece {
    a: DoubleDouble,
    b: DoubleDouble,
    w: [DoubleDouble; 2],
}

/// A density: pieces on t ≥ 0 and the power of t.
struct Density {
    pieces: Vec<DensityPiece>,
    power: i32,
}

/// The density of t on axis `k` in the direction `sign` (0: both).
fn density(a: &AlignedBox, b: &AlignedBox, k: usize, sign: i8) -> Density {
    let one = DoubleDouble::from(1.0);
    let d = |x: f64, y: f64| difference(x, y);
    let (la, lb) = (d(a.hi[k], a.lo[k]), d(b.hi[k], b.lo[k]));
    let (short, low) = (la.min(lb), d(b.lo[k], a.hi[k]));
    let (q, r) = (d(b.lo[k], a.lo[k]), d(b.hi[k], a.hi[k]));
    let high = d(b.hi[k], a.lo[k]);
    let power = !la.is_positive() as i32 + !lb.is_positive() as i32;
    let all = match power {
        2 => vec![DensityPiece { a: low, b: low, w: [one; 2] }],
        1 => vec![DensityPiece { a: low, b: high, w: [one; 2] }],
        _ => {
            let (p, s) = ([low, q.min(r), q.max(r), high], short);
            let z = DoubleDouble::ZERO;
            vec![
                DensityPiece { a: p[0], b: p[1], w: [z, s] },
                DensityPiece { a: p[1], b: p[2], w: [s, s] },
                DensityPiece { a: p[2], b: p[3], w: [s, z] },
            ]
        }
    };
    let mut pieces: Vec<DensityPiece> = vec![];
    for p in all {
        for (part, side) in split_at_zero(p, power == 2) {
            if sign == 0 || side == sign {
                add_piece(&mut pieces, part);
            }
        }
    }
    Density { pieces, power }
}

/// The parts above and below zero with their signs, the latter mirrored.
fn split_at_zero(p: DensityPiece, fixed: bool) -> Vec<(DensityPiece, i8)> {
    let mirrored = |p: DensityPiece| DensityPiece { a: -p.b, b: -p.a, w: [p.w[1], p.w[0]] };
    if fixed {
        return if p.a.is_positive() {
            vec![(p, 1)]
        } else if (-p.a).is_positive() {
            vec![(mirrored(p), -1)]
        } else {
            vec![]
        };
    }
    if !(p.b - p.a).is_positive() {
        return vec![];
    }
    let z = DoubleDouble::ZERO;
    if !(-p.a).is_positive() {
        vec![(p, 1)]
    } else if !p.b.is_positive() {
        vec![(mirrored(p), -1)]
    } else {
        let w = (p.w[0] * p.b - p.w[1] * p.a) / (p.b - p.a);
        let below = DensityPiece { a: p.a, b: z, w: [p.w[0], w] };
        vec![(DensityPiece { a: z, w: [w, p.w[1]], ..p }, 1), (mirrored(below), -1)]
    }
}

/// Adds a piece, merged with a piece over the same interval.
fn add_piece(pieces: &mut Vec<DensityPiece>, p: DensityPiece) {
    match pieces.iter_mut().find(|o| o.a == p.a && o.b == p.b) {
        Some(o) => o.w = [o.w[0] + p.w[0], o.w[1] + p.w[1]],
        None => pieces.push(p),
    }
}

/// The sign of t on each axis (0: both); `None` when the two normals admit no t.
fn directions(a: &AlignedBox, b: &AlignedBox) -> Option<[i8; 3]> {
    let mut sign = [0i8; 3];
    if let Some((k, s)) = a.normal {
        sign[k] = s;
    }
    if let Some((k, s)) = b.normal {
        if sign[k] == s {
            return None;
        }
        sign[k] = -s;
    }
    Some(sign)
}

/// A product of three pieces, in `DoubleDouble` and rounded.
struct ProductCell {
    wa: [DoubleDouble; 3],
    wb: [DoubleDouble; 3],
    a: [f64; 3],
    b: [f64; 3],
    len: [f64; 3],
    w: [[f64; 2]; 3],
    power: [i32; 3],
    kappa: f64,
    /// 2 + m.
    q: i32,
}

/// A region of a cell that is integrated over two dimensions.
#[derive(Clone, Copy, Debug)]
enum CellRegion {
    /// Axis k is fixed: integration over the two others.
    Flat(usize),
    /// A corner at zero: rays that leave by face k.
    Corner(usize),
    /// Rays from face k to the one opposite.
    Through(usize),
    /// Rays from face k that leave by face j.
    Side(usize, usize),
}

impl ProductCell {
    fn new(pieces: [DensityPiece; 3], power: [i32; 3], kappa: f64) -> ProductCell {
        ProductCell {
            wa: pieces.map(|p| p.a),
            wb: pieces.map(|p| p.b),
            a: pieces.map(|p| p.a.rounded()),
            b: pieces.map(|p| p.b.rounded()),
            len: pieces.map(|p| (p.b - p.a).rounded()),
            w: pieces.map(|p| p.w.map(DoubleDouble::rounded)),
            power,
            kappa,
            q: 2 + power.iter().sum::<i32>(),
        }
    }

    fn regions(&self) -> Vec<CellRegion> {
        if let Some(k) = (0..3).find(|&k| self.len[k] == 0.0) {
            return vec![CellRegion::Flat(k)];
        }
        if self.a == [0.0; 3] {
            return vec![CellRegion::Corner(0), CellRegion::Corner(1), CellRegion::Corner(2)];
        }
        let mut out = vec![];
        for k in (0..3).filter(|&k| self.a[k] > 0.0) {
            let (j, i) = ((k + 1) % 3, (k + 2) % 3);
            out.extend([CellRegion::Through(k), CellRegion::Side(k, j), CellRegion::Side(k, i)]);
        }
        out
    }

    /// |x|^p/r^q and κ r at a point.
    fn kernel(&self, x: [f64; 3]) -> (f64, f64) {
        let r2 = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
        let r = r2.sqrt();
        let mut n = 1.0;
        for k in 0..3 {
            n *= match self.power[k] {
                0 => 1.0,
                1 => x[k],
                _ => x[k] * x[k],
            };
        }
        let n = match self.q {
            2 => n / r2,
            3 => n / (r2 * r),
            _ => n / (r2 * r2),
        };
        (n, self.kappa * r)
    }

    /// The density on an axis at these distances from the piece's ends.
    fn weight(&self, k: usize, below: f64, above: f64) -> f64 {
        (self.w[k][0] * above + self.w[k][1] * below) / self.len[k]
    }

    fn line(&self, lo: f64, len: f64, away: f64) -> SingularInterval {
        SingularInterval { lo, len, away, longest: MAX_PIECE_DEPTH / self.kappa }
    }

    fn integrate(&self, region: CellRegion, nodes: &[QuadratureNode]) -> f64 {
        match region {
            CellRegion::Flat(k) => self.flat(k, nodes),
            CellRegion::Corner(k) => self.corner(k, nodes),
            CellRegion::Through(k) => self.through(k, nodes),
            CellRegion::Side(k, j) => self.side(k, j, nodes),
        }
    }

    fn flat(&self, k: usize, nodes: &[QuadratureNode]) -> f64 {
        let (j, i) = ((k + 1) % 3, (k + 2) % 3);
        let outer = self.line(self.a[j], self.len[j], self.a[k].hypot(self.a[i]));
        outer.integrate(nodes, |y| {
            let inner = self.line(self.a[i], self.len[i], self.a[k].hypot(y.x));
            let sum = inner.integrate(nodes, |z| {
                let mut x = [0.0; 3];
                (x[k], x[j], x[i]) = (self.a[k], y.x, z.x);
                let (n, depth) = self.kernel(x);
                self.weight(i, z.below, z.above) * n * (-depth).exp()
            });
            self.weight(j, y.below, y.above) * sum
        })
    }

    fn corner(&self, k: usize, nodes: &[QuadratureNode]) -> f64 {
        let (j, i) = ((k + 1) % 3, (k + 2) % 3);
        let from = [self.w[k][0], self.w[j][0], self.w[i][0]];
        let outer = self.line(0.0, self.b[j], self.b[k]);
        let sum = outer.integrate(nodes, |y| {
            let wj = self.weight(j, y.below, y.above);
            let inner = self.line(0.0, self.b[i], self.b[k].hypot(y.x));
            inner.integrate(nodes, |z| {
                let mut x = [0.0; 3];
                (x[k], x[j], x[i]) = (self.b[k], y.x, z.x);
                let to = [self.w[k][1], wj, self.weight(i, z.below, z.above)];
                let (n, depth) = self.kernel(x);
                n * ray_integral(from, to, 0.0, depth)
            })
        });
        sum * self.b[k]
    }

    fn through(&self, k: usize, nodes: &[QuadratureNode]) -> f64 {
        let (j, i) = ((k + 1) % 3, (k + 2) % 3);
        let (a, b) = (&self.wa, &self.wb);
        let shrunk = |j: usize| (b[j] * a[k] / b[k] - a[j]).rounded();
        let (lj, li) = (shrunk(j), shrunk(i));
        if lj <= 0.0 || li <= 0.0 {
            return 0.0;
        }
        let excess = |j: usize| self.b[j] * self.len[k] / self.b[k];
        let (bj, bi) = (excess(j), excess(i));
        let (s, more) = (self.b[k] / self.a[k], self.len[k] / self.a[k]);
        let outer = self.line(self.a[j], lj, self.a[k].hypot(self.a[i]));
        let sum = outer.integrate(nodes, |y| {
            let wj = self.weight(j, y.below, bj + y.above);
            let vj = self.weight(j, y.below + more * y.x, s * y.above);
            let inner = self.line(self.a[i], li, self.a[k].hypot(y.x));
            inner.integrate(nodes, |z| {
                let mut x = [0.0; 3];
                (x[k], x[j], x[i]) = (self.a[k], y.x, z.x);
                let from = [self.w[k][0], wj, self.weight(i, z.below, bi + z.above)];
                let to = [self.w[k][1], vj, self.weight(i, z.below + more * z.x, s * z.above)];
                let (n, depth) = self.kernel(x);
                n * ray_integral(from, to, depth, depth * more)
            })
        });
        // a_k for the face, (s − 1) for the ray.
        sum * self.len[k]
    }

    fn side(&self, k: usize, j: usize, nodes: &[QuadratureNode]) -> f64 {
        let i = 3 - k - j;
        let (a, b) = (&self.wa, &self.wb);
        let (at_k, at_i) = (b[j] * a[k] / b[k], a[i] * b[j] / b[i]);
        let lo = a[j].max(at_k).max(at_i);
        let len = (b[j] - lo).rounded();
        if len <= 0.0 {
            return 0.0;
        }
        let above_a = (lo - a[j]).rounded().max(0.0);
        let above_k = (lo - at_k).rounded().max(0.0);
        let above_i = (lo - at_i).rounded().max(0.0);
        let slope = self.b[i] / self.b[j];
        let outer = self.line(lo.rounded(), len, 0.0);
        let sum = outer.integrate(nodes, |y| {
            let (s, more) = (self.b[j] / y.x, y.above / y.x);
            let wj = self.weight(j, above_a + y.below, y.above);
            let vk = self.weight(k, more * self.a[k], self.b[k] / y.x * (y.below + above_k));
            let inner = self.line(self.a[i], slope * (y.below + above_i), self.a[k].hypot(y.x));
            let sum = inner.integrate(nodes, |z| {
                let mut x = [0.0; 3];
                (x[k], x[j], x[i]) = (self.a[k], y.x, z.x);
                let from = [self.w[k][0], wj, self.weight(i, z.below, slope * y.above + z.above)];
                let to = [vk, self.w[j][1], self.weight(i, z.below + more * z.x, s * z.above)];
                let (n, depth) = self.kernel(x);
                n * ray_integral(from, to, depth, depth * more)
            });
            sum * more
        });
        sum * self.a[k]
    }

    /// κr of the cell's contribution: that of its nearest point, plus at most 40.
    fn depth(&self) -> f64 {
        let norm = |t: [f64; 3]| (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]).sqrt();
        let near = self.kappa * norm(self.a);
        (self.kappa * norm(self.b)).min(near + 40.0)
    }
}

/// Longest piece of an interval, in mean free paths.
const MAX_PIECE_DEPTH: f64 = 10.0;

/// Depth below which the series is used, and above which the closed form.
const SERIES_MAX_DEPTH: f64 = 3.0;

/// e^{−depth} ∫₀¹ Π_k ((1−σ) from_k + σ to_k) e^{−zσ} dσ.
///
/// The cubic in Bernstein form Σ_p B_p σ^p (1−σ)^{3−p} is integrated with the moments M_p = ∫ σ^p (1−σ)^{3−p} e^{−zσ} dσ.
fn ray_integral(from: [f64; 3], to: [f64; 3], depth: f64, z: f64) -> f64 {
    let ([f0, f1, f2], [t0, t1, t2]) = (from, to);
    let b = [
        f0 * f1 * f2,
        t0 * f1 * f2 + f0 * t1 * f2 + f0 * f1 * t2,
        t0 * t1 * f2 + t0 * f1 * t2 + f0 * t1 * t2,
        t0 * t1 * t2,
    ];
    if depth + z == 0.0 {
        return 0.25 * (b[0] + b[3]) + (b[1] + b[2]) / 12.0;
    }
    let (front, m) = if z < SERIES_MAX_DEPTH {
        ((-(depth + z)).exp(), moments_by_series(z))
    } else {
        ((-depth).exp(), moments_in_closed_form(z))
    };
    front * (b[0] * m[0] + b[1] * m[1] + b[2] * m[2] + b[3] * m[3])
}

/// e^z M_p(z) = Σ_n zⁿ/n! · p! (3−p+n)!/(4+n)! for 0 ≤ z ≤ [`SERIES_MAX_DEPTH`]: every term positive.
fn moments_by_series(z: f64) -> [f64; 4] {
    const SERIES_TERMS: usize = 32;
    const SERIES_COEFFICIENTS: [[f64; 4]; SERIES_TERMS] = {
        let mut c = [[0.0; 4]; SERIES_TERMS];
        let (mut n, mut factorial) = (0, 1.0);
        while n < SERIES_TERMS {
            let x = n as f64;
            if n > 0 {
                factorial *= x;
            }
            let p0 = 1.0 / (4.0 + x);
            let p1 = p0 / (3.0 + x);
            let p2 = 2.0 * p1 / (2.0 + x);
            let p3 = 3.0 * p2 / (1.0 + x);
            c[n] = [p0 / factorial, p1 / factorial, p2 / factorial, p3 / factorial];
            n += 1;
        }
        c
    };
    // The first omitted term is below 1e−18 of the sum.
    let terms = match z {
        z if z < 0.01 => 8,
        z if z < 0.2 => 13,
        z if z < 1.0 => 21,
        _ => SERIES_TERMS,
    };
    let mut m = [0.0; 4];
    for c in SERIES_COEFFICIENTS[..terms].iter().rev() {
        for p in 0..4 {
            m[p] = m[p] * z + c[p];
        }
    }
    m
}

/// M_p(z) for z ≥ [`SERIES_MAX_DEPTH`] from G_p = ∫ σ^p e^{−zσ} dσ = p!/z^{p+1} (1 − e^{−z} Σ_{i≤p} z^i/i!); the cancellation loses less than a digit.
fn moments_in_closed_form(z: f64) -> [f64; 4] {
    let (e, y) = ((-z).exp(), 1.0 / z);
    let (s1, s2) = (1.0 + z, 0.5 * z * z);
    let s3 = z * z * z / 6.0;
    let g0 = y * (1.0 - e);
    let g1 = y * y * (1.0 - e * s1);
    let g2 = 2.0 * y * y * y * (1.0 - e * (s1 + s2));
    let g3 = 6.0 * y * y * y * y * (1.0 - e * (s1 + s2 + s3));
    [(g0 - 3.0 * g1) + (3.0 * g2 - g3), (g1 - 2.0 * g2) + g3, g2 - g3, g3]
}

/// Roundings of a term without attenuation.
const ROUNDINGS_PER_TERM: f64 = 64.0;
/// Roundings per unit of κr.
const ROUNDINGS_PER_DEPTH: f64 = 8.0;
/// Two levels agree when they differ by less, relative to the region plus the mean of all regions.
const LEVEL_AGREEMENT: f64 = 4e-15;
/// The level of the first estimate.
const FIRST_LEVEL: usize = 1;

/// The factor of two valid boxes for extinction `kappa` ≥ 0 (1/m), to a relative error of about 1e−14.
pub fn factor(a: &AlignedBox, b: &AlignedBox, kappa: f64) -> FactorValue {
    factor_to(a, b, kappa, 0.0)
}

/// [`factor`] to about a relative `tolerance`, which saves time; the error bound is the one reached.
pub fn factor_to(a: &AlignedBox, b: &AlignedBox, kappa: f64, tolerance: f64) -> FactorValue {
    let zero = FactorValue { value: 0.0, error: 0.0 };
    let Some(sign) = directions(a, b) else {
        return zero;
    };
    let axes = [0, 1, 2].map(|k| density(a, b, k, sign[k]));
    // Estimate every region at the first level.
    let mut work = vec![];
    for &x in &axes[0].pieces {
        for &y in &axes[1].pieces {
            for &z in &axes[2].pieces {
                let power = [axes[0].power, axes[1].power, axes[2].power];
                let cell = std::rc::Rc::new(ProductCell::new([x, y, z], power, kappa));
                for region in cell.regions() {
                    let first = cell.integrate(region, rule(FIRST_LEVEL));
                    if first > 0.0 {
                        work.push((cell.clone(), region, first));
                    }
                }
            }
        }
    }
    let total: f64 = work.iter().map(|w| w.2).sum();
    // Refine every region.
    let mean = total / work.len().max(1) as f64;
    let (mut sum, mut error) = (DoubleDouble::ZERO, 0.0);
    for (cell, region, first) in work {
        let (value, difference) = refine(&cell, region, first, mean, LEVEL_AGREEMENT.max(0.5 * tolerance));
        sum = sum + DoubleDouble::from(value);
        let roundings = ROUNDINGS_PER_TERM + ROUNDINGS_PER_DEPTH * cell.depth();
        error += difference + roundings * 0.5 * f64::EPSILON * value;
    }
    let scale = std::f64::consts::FRAC_1_PI;
    FactorValue { value: sum.rounded() * scale, error: error * scale * 1.000_001 }
}

/// Raises the level until two levels agree; returns the finer value and their difference.
fn refine(cell: &ProductCell, region: CellRegion, first: f64, mean: f64, tolerance: f64) -> (f64, f64) {
    let (mut value, mut difference) = (first, f64::INFINITY);
    for level in FIRST_LEVEL + 1..LEVEL_STEPS.len() {
        let finer = cell.integrate(region, rule(level));
        (difference, value) = ((finer - value).abs(), finer);
        if difference <= tolerance * (value + mean) {
            break;
        }
    }
    (value, difference)
}

#[cfg(test)]
#[path = "factors_tests.rs"]
mod tests;
