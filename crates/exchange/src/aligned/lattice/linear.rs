//! Tables of a grid for radiosity that varies linearly inside each cell.
//!
//! On a cell with centre c and edges e let φ₀ = 1 and φ_k = √12 (x_k − c_k)/e_k: functions of mean square one, square to each other. The factor of
//! component p of one cell and q of another
//!
//! ```text
//!     𝓕_pq(d) = (1/π) ∬ φ_p φ_q Π|t_k|^{p_k} e^{−κr} / r^{2+Σp}                  t = x_j − x_i,  r = |t|
//! ```
//!
//! depends on their offset d alone. As for constant radiosity the integrand depends on t only, and the densities of t are products, one factor an
//! axis. With τ = t/e − d, and x the place within the cell of the lattice of t that holds it:
//!
//! | along the axis | term | density for the cell above d (x = τ) | for the cell below (1 − x = −τ) |
//! |---|---|---|---|
//! | [`Along::Between`] | 0: φ₀φ₀ | 1 − x | x |
//! | | 1: φ₀ of the first, φ_k of the second | √3 x(1 − x) | −√3 x(1 − x) |
//! | | 2: φ_kφ_k | 1 − 3x + 2x³ | 1 − 3y + 2y³, y = 1 − x |
//! | [`Along::Depth`], off a wall | 0, 1: φ₀, φ_k of what has an extent | 1, √3(2x − 1) | |
//! | [`Along::Across`], wall to wall | 0 | 1 | |
//!
//! Terms 0 and 2 are even in d, term 1 is odd. So a table is a sum over the cells of t's own lattice: each is integrated once, by a Gauss rule for
//! all densities together, and gives its shares to the (up to eight) offsets around it. The one cell that touches t = 0 takes pyramid coordinates;
//! cells too near or too thick are cut.
//!
//! **Error.** Rules have points enough for a relative error of about 1e-11 of a cell (see [`points`]): estimated, and compared in tests with
//! the proven tables for constant radiosity and by refinement. Cells beyond [`DEPTH`] mean free paths are left out. Where the grid repeats itself
//! `gaussians.rs` has the tables. The images of a period of one cell are a row without end, of density one: slopes along it are zero by symmetry,
//! and so are their factors there.

use super::gaussians;
use super::images::Images;
use rayon::prelude::*;
use zonal_math::gauss;
use zonal_math::simd::{self, LANES};

/// How two zones lie along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Along {
    /// Both extend: the offset is the difference of their cells.
    Between,
    /// One is a patch across this axis, the other a cell that begins so many cells off it.
    Depth,
    /// Both are patches across this axis, with so many cells between them as the count says.
    Across,
}

/// The pairs of zones that a table is of.
#[derive(Clone, Copy, Debug)]
pub struct Linear<'a> {
    /// Edges of a cell, m.
    pub edges: [f64; 3],
    /// Offsets wanted along each axis; across, the number of cells between the walls.
    pub counts: [usize; 3],
    /// How the zones lie.
    pub along: [Along; 3],
    /// Extinction, 1/m.
    pub kappa: f64,
    /// How the grid repeats itself, if it does.
    pub images: &'a Images,
}

/// Shares of a cell by density: `[x][y][z]`, for an axis between first the three terms above the offset, then those below.
type Shares = [[[f64; LANES]; 6]; 6];

/// Mean free paths after which a cell is left out: e^{−36} of a row.
const DEPTH: f64 = 36.0;
/// Planes of the lattice of t that are worked on together.
const CHUNK: usize = 4;
/// Chunks whose planes are held at a time.
const HELD: usize = 16;
/// Points of the rules in pyramid coordinates.
const PYRAMID: usize = 20;
/// Longest edge over nearest distance of a cell that is integrated whole.
const NEAR: f64 = 1.25;
/// Longest over shortest edge of a touching cell that is integrated whole.
const ASPECT: f64 = 1.5;
/// Longest edge in mean free paths of a cell that is integrated whole.
const THICK: f64 = 4.0;
/// Cuts of a cell, one in another.
const MOST_CUTS: u32 = 60;

/// Where a share goes along an axis: the offset, which of the densities, and what even and odd terms are multiplied by.
#[derive(Clone, Copy)]
struct Goal {
    slot: usize,
    first: usize,
    even: f64,
    odd: f64,
}

/// A box in the octant of t, m.
#[derive(Clone, Copy)]
struct Piece {
    lo: [f64; 3],
    len: [f64; 3],
}

impl Piece {
    fn nearest(&self) -> f64 {
        self.lo.iter().map(|x| x * x).sum::<f64>().sqrt()
    }
    fn longest(&self) -> usize {
        (0..3).fold(0, |m, k| if self.len[k] > self.len[m] { k } else { m })
    }
    /// The half towards zero and the other.
    fn halves(&self, k: usize) -> [Piece; 2] {
        let (mut low, mut high) = (*self, *self);
        low.len[k] *= 0.5;
        high.len[k] = low.len[k];
        high.lo[k] += low.len[k];
        [low, high]
    }
}

/// Points an axis for a cell whose longest edge is `ratio` of its nearest distance and `depth` mean free paths: densities take three of the 2n
/// degrees, for the kernel ϱ^{−(2n−3)} is left (ϱ = 4/ratio + 2 at least, see `density.rs`) and the remainder of e^{−depth·x}, both about 1e-11.
fn points(ratio: f64, depth: f64) -> usize {
    let of_distance = match ratio {
        r if r <= 0.025 => 4,
        r if r <= 0.1 => 5,
        r if r <= 0.25 => 6,
        r if r <= 0.45 => 7,
        r if r <= 0.65 => 8,
        r if r <= 0.9 => 10,
        _ => MOST,
    };
    let of_depth = match depth {
        d if d <= 0.07 => 4,
        d if d <= 0.3 => 5,
        d if d <= 0.9 => 6,
        d if d <= 1.8 => 7,
        d if d <= 2.7 => 8,
        _ => 10,
    };
    of_distance.max(of_depth)
}

impl Linear<'_> {
    /// The table of each of `terms` (numbers of densities along the three axes), by `[d₀][d₁][d₂]`, m⁴, m³ or m². Across, the count is one.
    ///
    /// # Panics
    /// On an edge that is not positive and finite, an extinction that is negative or infinite.
    pub fn tables(&self, terms: &[[usize; 3]]) -> Vec<Vec<f64>> {
        assert!(self.edges.iter().all(|e| *e > 0.0 && e.is_finite()), "edges {:?}", self.edges);
        assert!(self.kappa >= 0.0 && self.kappa.is_finite(), "extinction {} 1/m", self.kappa);
        if self.images.any() {
            return gaussians::tables(self, terms);
        }
        let [n0, n1, n2] = self.slots();
        let mut out = vec![vec![0.0; n0 * n1 * n2]; terms.len()];
        let firsts: Vec<usize> = (0..self.slots()[0]).step_by(CHUNK).collect();
        for some in firsts.chunks(HELD) {
            let done: Vec<Vec<Vec<f64>>> =
                some.par_iter().with_max_len(1).map(|&first| self.chunk(first, terms)).collect();
            for (&first, planes) in some.iter().zip(done) {
                for (raw, plane) in planes.chunks(terms.len()).enumerate() {
                    self.put(first + raw, plane, terms, &mut out);
                }
            }
        }
        out
    }

    /// Cells of the lattice of t that [`Linear::tables`] integrates; offsets, where the grid repeats itself.
    pub fn work(&self) -> f64 {
        self.slots().iter().map(|n| *n as f64).product()
    }

    pub(super) fn slots(&self) -> [usize; 3] {
        std::array::from_fn(|k| if self.along[k] == Along::Across { 1 } else { self.counts[k] })
    }

    /// Where the shares of cell `i` along axis `k` go.
    fn goals(&self, k: usize, i: usize) -> Vec<Goal> {
        match self.along[k] {
            Along::Across => vec![Goal { slot: 0, first: 0, even: 1.0, odd: 1.0 }],
            Along::Depth => vec![Goal { slot: i, first: 0, even: 1.0, odd: 1.0 }],
            Along::Between => {
                [(i, 0), (i + 1, 3)].into_iter().flat_map(|(d, first)| self.places(k, d, first)).collect()
            }
        }
    }

    /// The places of an offset d ≥ 0 and of −d along axis `k`.
    fn places(&self, k: usize, d: usize, first: usize) -> Vec<Goal> {
        // The cells on both sides of zero are mirrored in each other.
        let own = if d == 0 { (2.0, 0.0) } else { (1.0, 1.0) };
        let goal = Goal { slot: d, first, even: own.0, odd: own.1 };
        (d < self.counts[k]).then_some(goal).into_iter().collect()
    }

    /// Adds a plane of offset `raw` along the first axis to its places.
    fn put(&self, raw: usize, plane: &[Vec<f64>], terms: &[[usize; 3]], out: &mut [Vec<f64>]) {
        let goals = match self.along[0] {
            Along::Between => self.places(0, raw, 0),
            _ => self.goals(0, raw).into_iter().filter(|g| g.slot < self.slots()[0]).collect(),
        };
        for ((plane, term), out) in plane.iter().zip(terms).zip(out) {
            for g in &goals {
                let by = if self.odd(0, term[0]) { g.odd } else { g.even };
                let to = &mut out[g.slot * plane.len()..(g.slot + 1) * plane.len()];
                to.iter_mut().zip(plane).for_each(|(o, x)| *o += by * x);
            }
        }
    }

    fn odd(&self, k: usize, term: usize) -> bool {
        self.along[k] == Along::Between && term == 1
    }

    /// Some planes of the lattice of t: their shares by raw offset along the first axis and term.
    fn chunk(&self, first: usize, terms: &[[usize; 3]]) -> Vec<Vec<f64>> {
        let last = (first + CHUNK).min(self.slots()[0]);
        let [_, n1, n2] = self.slots();
        let above = usize::from(self.along[0] == Along::Between);
        let mut planes = vec![vec![0.0; n1 * n2]; (last - first + above) * terms.len()];
        let goals: [Vec<Vec<Goal>>; 2] =
            [1, 2].map(|k| (0..self.slots()[k]).map(|i| self.goals(k, i)).collect());
        for i in first..last {
            for (j, goals1) in goals[0].iter().enumerate() {
                for (k, goals2) in goals[1].iter().enumerate() {
                    let Some(shares) = self.cell([i, j, k]) else { continue };
                    for piece in 0..=above {
                        let at = (i - first + piece) * terms.len();
                        let planes = &mut planes[at..at + terms.len()];
                        for (plane, term) in planes.iter_mut().zip(terms) {
                            let shares = &shares[3 * piece + term[0]];
                            let (odd1, odd2) = (self.odd(1, term[1]), self.odd(2, term[2]));
                            for g1 in goals1 {
                                let by = if odd1 { g1.odd } else { g1.even };
                                let shares = &shares[g1.first + term[1]];
                                for g2 in goals2 {
                                    let by = by * if odd2 { g2.odd } else { g2.even };
                                    plane[g1.slot * n2 + g2.slot] += by * shares[g2.first + term[2]];
                                }
                            }
                        }
                    }
                }
            }
        }
        planes
    }

    /// The shares of one cell of the lattice of t; none out of reach.
    fn cell(&self, at: [usize; 3]) -> Option<Box<Shares>> {
        let mut piece = Piece { lo: [0.0; 3], len: [0.0; 3] };
        for k in 0..3 {
            let (lo, len) = match self.along[k] {
                Along::Across => (self.counts[k] as f64 * self.edges[k], 0.0),
                _ => (at[k] as f64 * self.edges[k], self.edges[k]),
            };
            (piece.lo[k], piece.len[k]) = (lo, len);
        }
        if self.kappa * piece.nearest() > DEPTH {
            return None;
        }
        let mut shares = Box::new([[[0.0; LANES]; 6]; 6]);
        self.divide(piece, piece.lo, 0, &mut shares);
        // 1/π, and the lengths that make integrals over t of means over cells.
        let front = std::f64::consts::FRAC_1_PI
            * (0..3)
                .map(|k| if self.along[k] == Along::Between { self.edges[k] } else { 1.0 })
                .product::<f64>();
        shares.as_flattened_mut().as_flattened_mut().iter_mut().for_each(|x| *x *= front);
        Some(shares)
    }

    /// Cuts a piece of the cell at `origin` until it is integrated whole.
    fn divide(&self, piece: Piece, origin: [f64; 3], cuts: u32, shares: &mut Shares) {
        let k = piece.longest();
        let (near, long) = (piece.nearest(), piece.len[k]);
        if cuts < MOST_CUTS {
            let shortest = piece.len.iter().copied().fold(f64::INFINITY, f64::min);
            let unfit = if near == 0.0 { long > ASPECT * shortest } else { long > NEAR * near };
            if unfit || self.kappa * long > THICK {
                return piece.halves(k).into_iter().for_each(|half| {
                    if self.kappa * half.nearest() <= DEPTH {
                        self.divide(half, origin, cuts + 1, shares);
                    }
                });
            }
        }
        if near == 0.0 {
            self.pyramids(piece, shares);
        } else {
            let n = points(long / near, self.kappa * long);
            simd::run(Tensor { of: self, piece, origin, n, shares });
        }
    }

    /// The number of patches in a pair.
    pub(super) fn patches(&self) -> usize {
        self.power().iter().sum::<i32>() as usize
    }

    fn power(&self) -> [i32; 3] {
        self.along.map(|a| match a {
            Along::Between => 0,
            Along::Depth => 1,
            Along::Across => 2,
        })
    }

    /// The densities along axis `k` at the place `x` within the cell.
    #[inline(always)]
    fn densities(&self, k: usize, x: f64) -> [f64; 6] {
        let root3 = 3.0f64.sqrt();
        match self.along[k] {
            Along::Between => {
                let y = 1.0 - x;
                let odd = root3 * x * y;
                [y, odd, 1.0 - 3.0 * x + 2.0 * x * x * x, x, -odd, 1.0 - 3.0 * y + 2.0 * y * y * y]
            }
            Along::Depth => [1.0, root3 * (2.0 * x - 1.0), 0.0, 0.0, 0.0, 0.0],
            Along::Across => [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        }
    }

    /// A piece that touches zero, a corner of the cell at zero.
    fn pyramids(&self, piece: Piece, shares: &mut Shares) {
        let (rule, power) = (gauss::rule(PYRAMID), self.power());
        let q = 2 + power.iter().sum::<i32>();
        let volume: f64 = piece.len.iter().product();
        let nodes = || rule.nodes.iter().zip(&rule.weights);
        for apex in 0..3 {
            let [b, c] = [(apex + 1) % 3, (apex + 2) % 3];
            for (s, ws) in nodes() {
                for (v, wv) in nodes() {
                    for (w, ww) in nodes() {
                        let mut t = piece.len.map(|l| l * s);
                        t[b] *= v;
                        t[c] *= w;
                        let r = t.iter().map(|t| t * t).sum::<f64>().sqrt();
                        let up: f64 = (0..3).map(|k| t[k].powi(power[k])).product();
                        let value = volume * ws * wv * ww * s * s * up * r.powi(-q) * (-self.kappa * r).exp();
                        let [x, y, z]: [[f64; 6]; 3] =
                            std::array::from_fn(|k| self.densities(k, t[k] / self.edges[k]));
                        for (plane, x) in shares.iter_mut().zip(x) {
                            for (line, y) in plane.iter_mut().zip(y) {
                                let by = value * x * y;
                                line.iter_mut().zip(z).for_each(|(o, z)| *o += by * z);
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The most points of an axis.
const MOST: usize = 12;
/// Room for the points of two axes, in whole lanes.
const PLANE: usize = (MOST * MOST).div_ceil(LANES);

/// One piece by a product of Gauss rules.
struct Tensor<'a, 'b> {
    of: &'a Linear<'b>,
    piece: Piece,
    origin: [f64; 3],
    n: usize,
    shares: &'a mut Shares,
}

impl simd::Work for Tensor<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn go(self) {
        let Tensor { of, piece, origin, n, shares } = self;
        let power = of.power();
        let used = of.along.map(|a| match a {
            Along::Between => 6,
            Along::Depth => 2,
            Along::Across => 1,
        });
        let patches: i32 = power.iter().sum();
        // Nodes, weights with the numerator's share, and densities times weights.
        let mut count = [1; 3];
        let mut square = [[0.0; MOST]; 3];
        let mut density = [[[0.0; LANES]; MOST]; 3];
        for k in 0..3 {
            if piece.len[k] > 0.0 {
                count[k] = n;
            }
            let rule = gauss::rule(count[k]);
            for i in 0..count[k] {
                let t = piece.lo[k] + piece.len[k] * rule.nodes[i];
                let length = if piece.len[k] > 0.0 { piece.len[k] } else { 1.0 };
                let up = match power[k] {
                    0 => 1.0,
                    1 => t,
                    _ => t * t,
                };
                square[k][i] = t * t;
                let by = rule.weights[i] * length * up;
                let d = of.densities(k, (t - origin[k]) / of.edges[k]);
                for f in 0..6 {
                    density[k][i][f] = by * d[f];
                }
            }
        }
        let [nx, ny, nz] = count;
        let groups = (ny * nz).div_ceil(LANES);
        let mut plane = [[square[1][0] + square[2][0]; LANES]; PLANE];
        for j in 0..ny {
            for k in 0..nz {
                let m = j * nz + k;
                plane[m / LANES][m % LANES] = square[1][j] + square[2][k];
            }
        }
        let mut value = [[0.0; LANES]; PLANE];
        for i in 0..nx {
            for g in 0..groups {
                let mut r2 = [0.0; LANES];
                for l in 0..LANES {
                    r2[l] = square[0][i] + plane[g][l];
                }
                let mut r = [0.0; LANES];
                for l in 0..LANES {
                    r[l] = r2[l].sqrt();
                }
                let mut v = [0.0; LANES];
                for l in 0..LANES {
                    v[l] = match patches {
                        0 => 1.0 / r2[l],
                        1 => 1.0 / (r2[l] * r[l]),
                        _ => 1.0 / (r2[l] * r2[l]),
                    };
                }
                if of.kappa > 0.0 {
                    let e = simd::exp(r.map(|r| -of.kappa * r));
                    for l in 0..LANES {
                        v[l] *= e[l];
                    }
                }
                value[g] = v;
            }
            let mut lines = [[0.0; LANES]; 6];
            for j in 0..ny {
                let mut line = [0.0; LANES];
                for k in 0..nz {
                    let m = j * nz + k;
                    let v = value[m / LANES][m % LANES];
                    for l in 0..LANES {
                        line[l] += v * density[2][k][l];
                    }
                }
                for f in 0..used[1] {
                    for l in 0..LANES {
                        lines[f][l] += density[1][j][f] * line[l];
                    }
                }
            }
            for e in 0..used[0] {
                for f in 0..used[1] {
                    for l in 0..LANES {
                        shares[e][f][l] += density[0][i][e] * lines[f][l];
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
