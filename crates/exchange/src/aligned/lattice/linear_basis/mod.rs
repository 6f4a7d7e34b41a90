//! Tables of a grid for radiosity that varies linearly inside each cell.
//!
//! On a cell with centre c and edges e let φ₀ = 1 and φ_k = √12 (x_k − c_k)/e_k: orthonormal functions in the mean. The factor of
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
//! | [`AxisRelation::Extended`] | 0: φ₀φ₀ | 1 − x | x |
//! | | 1: φ₀ of the first, φ_k of the second | √3 x(1 − x) | −√3 x(1 − x) |
//! | | 2: φ_kφ_k | 1 − 3x + 2x³ | 1 − 3y + 2y³, y = 1 − x |
//! | [`AxisRelation::OffWall`], off a wall | 0, 1: φ₀, φ_k of the zone with an extent | 1, √3(2x − 1) | |
//! | [`AxisRelation::OppositeWalls`], wall to wall | 0 | 1 | |
//!
//! Terms 0 and 2 are even in d, term 1 is odd. So a table is a sum over the cells of t's own lattice: each is integrated once, by a Gauss rule for
//! all densities together, and contributes to the (up to eight) offsets around it. The one cell that touches t = 0 takes pyramid coordinates;
//! cells too near or too thick are cut.
//!
//! **Error.** The numbers of points (`rule_sizes.rs`) give a relative error of about 1e-11 of a cell, or 1e-8 where that is wanted
//! ([`TableAccuracy`]): estimated, and compared in tests with the proven tables for constant radiosity and by refinement. Cells beyond `MAX_OPTICAL_DEPTH` mean free paths are left out. Tables of periodic
//! grids are in `gaussian_sums.rs`. The images of a period of one cell are a row without end, of density one: slopes along it are zero by symmetry,
//! and so are their factors there.

mod rule_sizes;

use self::rule_sizes::{BASE_POINTS, MAX_POINTS};
use super::chunk_evaluator::ChunkEvaluator;
use super::gaussian_sums;
use super::pair_layout::{AxisRelation, LinearBasisPairs, TableAccuracy};
use crate::aligned::density_rules;
use zonal_math::gauss_legendre::{self, QuadratureRule};
use zonal_math::simd::{self, LANES};

/// Shares of a cell by density: `[x][y][z]`, for an axis between first the three terms above the offset, then those below.
type DensityShares = [[[f64; LANES]; 6]; 6];

// Limits of the cells of t that are integrated without further cuts, and the cost of a task.

/// Distance in mean free paths beyond which a cell is left out: e^{−36} of a row.
const MAX_OPTICAL_DEPTH: f64 = 36.0;
/// Planes of the lattice of t per task, and number of planes below which each is a task of its own.
const PLANES_PER_CHUNK: usize = 4;
const MIN_PLANES_OF_CHUNKS: usize = 32;
/// Tasks whose planes are in memory at a time.
const CHUNKS_IN_MEMORY: usize = 16;
/// Longest edge over nearest distance of an undivided cell.
const MAX_EDGE_OVER_DISTANCE: f64 = 1.25;
/// Longest over shortest edge of an undivided touching cell.
const MAX_TOUCHING_ASPECT: f64 = 1.5;
/// Largest optical depth along an edge of an undivided cell ([`LinearBasisPairs::optical_depths`]), mean free paths.
const MAX_CELL_DEPTH: f64 = 4.0;
/// Factor on this depth in the choice of points: e^{−κr} is curved along an edge across the ray.
const CURVATURE_FACTOR: f64 = 1.3;
/// Nested cuts of a cell, at most.
const MAX_CUTS: u32 = 60;

/// The entry to which a share is added along an axis: offset, first density, factors of even and odd terms.
#[derive(Clone, Copy)]
struct ShareTarget {
    slot: usize,
    first: usize,
    even: f64,
    odd: f64,
}

/// A box in the octant of t, m.
#[derive(Clone, Copy)]
struct OctantBox {
    lo: [f64; 3],
    len: [f64; 3],
}

impl OctantBox {
    fn nearest(&self) -> f64 {
        self.lo.iter().map(|x| x * x).sum::<f64>().sqrt()
    }
    fn longest(&self) -> usize {
        (0..3).fold(0, |m, k| if self.len[k] > self.len[m] { k } else { m })
    }
    /// The half towards zero and the other half.
    fn halves(&self, k: usize) -> [OctantBox; 2] {
        let (mut low, mut high) = (*self, *self);
        low.len[k] *= 0.5;
        high.len[k] = low.len[k];
        high.lo[k] += low.len[k];
        [low, high]
    }
}

impl LinearBasisPairs<'_> {
    /// The table of each of `terms` (numbers of densities along the three axes), by `[d₀][d₁][d₂]`, m⁴, m³ or m². Across, the count is one.
    ///
    /// # Panics
    /// On an edge that is not positive and finite, an extinction that is negative or infinite.
    pub fn tables(&self, terms: &[[usize; 3]], evaluator: &dyn ChunkEvaluator) -> Vec<Vec<f64>> {
        assert!(self.edges.iter().all(|e| *e > 0.0 && e.is_finite()), "edges {:?}", self.edges);
        assert!(self.kappa >= 0.0 && self.kappa.is_finite(), "extinction {} 1/m", self.kappa);
        if self.images.is_periodic() {
            return gaussian_sums::tables(self, terms, evaluator);
        }
        let [n0, n1, n2] = self.slots();
        let mut out = vec![vec![0.0; n0 * n1 * n2]; terms.len()];
        let firsts: Vec<usize> = (0..n0).step_by(self.planes_per_chunk()).collect();
        for some in firsts.chunks(CHUNKS_IN_MEMORY) {
            let done = evaluator.evaluate(some.len(), &|k| self.compute_planes(some[k], terms).concat());
            for (&first, planes) in some.iter().zip(done) {
                for (raw, plane) in planes.chunks(terms.len() * n1 * n2).enumerate() {
                    self.add_plane(first + raw, plane, terms, &mut out);
                }
            }
        }
        out
    }

    fn planes_per_chunk(&self) -> usize {
        if self.slots()[0] < MIN_PLANES_OF_CHUNKS { 1 } else { PLANES_PER_CHUNK }
    }

    /// The entries to which the shares of cell `i` along axis `k` are added.
    fn targets(&self, k: usize, i: usize) -> Vec<ShareTarget> {
        match self.along[k] {
            AxisRelation::OppositeWalls => vec![ShareTarget { slot: 0, first: 0, even: 1.0, odd: 1.0 }],
            AxisRelation::OffWall => vec![ShareTarget { slot: i, first: 0, even: 1.0, odd: 1.0 }],
            AxisRelation::Extended => [(i, 0), (i + 1, 3)]
                .into_iter()
                .flat_map(|(d, first)| self.targets_of_offset(k, d, first))
                .collect(),
        }
    }

    /// The places of an offset d ≥ 0 and of −d along axis `k`.
    fn targets_of_offset(&self, k: usize, d: usize, first: usize) -> Vec<ShareTarget> {
        // The cells on both sides of zero are mirrored in each other.
        let own = if d == 0 { (2.0, 0.0) } else { (1.0, 1.0) };
        let goal = ShareTarget { slot: d, first, even: own.0, odd: own.1 };
        (d < self.counts[k]).then_some(goal).into_iter().collect()
    }

    /// Adds a plane of offset `raw` along the first axis to its places.
    fn add_plane(&self, raw: usize, plane: &[f64], terms: &[[usize; 3]], out: &mut [Vec<f64>]) {
        let targets = match self.along[0] {
            AxisRelation::Extended => self.targets_of_offset(0, raw, 0),
            _ => self.targets(0, raw).into_iter().filter(|g| g.slot < self.slots()[0]).collect(),
        };
        for ((plane, term), out) in plane.chunks(plane.len() / terms.len()).zip(terms).zip(out) {
            for g in &targets {
                let by = if self.is_odd(0, term[0]) { g.odd } else { g.even };
                let to = &mut out[g.slot * plane.len()..(g.slot + 1) * plane.len()];
                to.iter_mut().zip(plane).for_each(|(o, x)| *o += by * x);
            }
        }
    }

    fn is_odd(&self, k: usize, term: usize) -> bool {
        self.along[k] == AxisRelation::Extended && term == 1
    }

    /// Some planes of the lattice of t: their shares by raw offset along the first axis and term.
    fn compute_planes(&self, first: usize, terms: &[[usize; 3]]) -> Vec<Vec<f64>> {
        let last = (first + self.planes_per_chunk()).min(self.slots()[0]);
        let [_, n1, n2] = self.slots();
        let above = usize::from(self.along[0] == AxisRelation::Extended);
        let mut planes = vec![vec![0.0; n1 * n2]; (last - first + above) * terms.len()];
        let targets: [Vec<Vec<ShareTarget>>; 2] =
            [1, 2].map(|k| (0..self.slots()[k]).map(|i| self.targets(k, i)).collect());
        for i in first..last {
            for (j, goals1) in targets[0].iter().enumerate() {
                for (k, goals2) in targets[1].iter().enumerate() {
                    let Some(shares) = self.cell_shares([i, j, k]) else { continue };
                    for piece in 0..=above {
                        let at = (i - first + piece) * terms.len();
                        let planes = &mut planes[at..at + terms.len()];
                        for (plane, term) in planes.iter_mut().zip(terms) {
                            let shares = &shares[3 * piece + term[0]];
                            let (odd1, odd2) = (self.is_odd(1, term[1]), self.is_odd(2, term[2]));
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

    /// The shares of one cell of the lattice of t; none beyond the largest optical depth.
    fn cell_shares(&self, at: [usize; 3]) -> Option<Box<DensityShares>> {
        let mut piece = OctantBox { lo: [0.0; 3], len: [0.0; 3] };
        for k in 0..3 {
            let (lo, len) = match self.along[k] {
                AxisRelation::OppositeWalls => (self.counts[k] as f64 * self.edges[k], 0.0),
                _ => (at[k] as f64 * self.edges[k], self.edges[k]),
            };
            (piece.lo[k], piece.len[k]) = (lo, len);
        }
        if self.kappa * piece.nearest() > MAX_OPTICAL_DEPTH {
            return None;
        }
        let mut shares = Box::new([[[0.0; LANES]; 6]; 6]);
        self.integrate_box(piece, piece.lo, 0, &mut shares);
        // 1/π, and the lengths that make integrals over t of means over cells.
        let front = std::f64::consts::FRAC_1_PI
            * (0..3)
                .map(|k| if self.along[k] == AxisRelation::Extended { self.edges[k] } else { 1.0 })
                .product::<f64>();
        shares.as_flattened_mut().as_flattened_mut().iter_mut().for_each(|x| *x *= front);
        Some(shares)
    }

    /// Integrates a box inside the cell at `origin`, cut until the limits hold.
    fn integrate_box(&self, piece: OctantBox, origin: [f64; 3], cuts: u32, shares: &mut DensityShares) {
        let k = piece.longest();
        let (near, long, depths) = (piece.nearest(), piece.len[k], self.optical_depths(&piece));
        if cuts < MAX_CUTS {
            let shortest = piece.len.iter().copied().fold(f64::INFINITY, f64::min);
            let unfit = if near == 0.0 {
                long > MAX_TOUCHING_ASPECT * shortest
            } else {
                long > MAX_EDGE_OVER_DISTANCE * near
            };
            let deepest = (0..3).fold(0, |m, k| if depths[k] > depths[m] { k } else { m });
            if unfit || depths[deepest] > MAX_CELL_DEPTH {
                return piece.halves(if unfit { k } else { deepest }).into_iter().for_each(|half| {
                    if self.kappa * half.nearest() <= MAX_OPTICAL_DEPTH {
                        self.integrate_box(half, origin, cuts + 1, shares);
                    }
                });
            }
        }
        if near == 0.0 {
            (0..3).for_each(|apex| simd::run(PyramidWork { pairs: self, piece, apex, shares: &mut *shares }));
        } else {
            let points = depths.map(|depth| self.accuracy.points(long / near, CURVATURE_FACTOR * depth));
            simd::run(TensorWork { pairs: self, piece, origin, points, shares });
        }
    }

    /// Bounds of the change of κr along each edge of a box: the slope of r along axis k is t_k/r, largest at the far end nearest to the axis.
    fn optical_depths(&self, piece: &OctantBox) -> [f64; 3] {
        [0, 1, 2].map(|k| {
            let mut at = piece.lo;
            at[k] += piece.len[k];
            let r = at.iter().map(|x| x * x).sum::<f64>().sqrt();
            if piece.len[k] == 0.0 { 0.0 } else { self.kappa * piece.len[k] * (at[k] / r) }
        })
    }

    /// The densities along axis `k` at the place `x` within the cell.
    #[inline(always)]
    fn densities(&self, k: usize, x: f64) -> [f64; 6] {
        let root3 = 3.0f64.sqrt();
        match self.along[k] {
            AxisRelation::Extended => {
                let y = 1.0 - x;
                let odd = root3 * x * y;
                [y, odd, 1.0 - 3.0 * x + 2.0 * x * x * x, x, -odd, 1.0 - 3.0 * y + 2.0 * y * y * y]
            }
            AxisRelation::OffWall => [1.0, root3 * (2.0 * x - 1.0), 0.0, 0.0, 0.0, 0.0],
            AxisRelation::OppositeWalls => [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        }
    }
}

/// Room for the points of two axes, in whole lanes.
const PLANE_LANES: usize = (MAX_POINTS * MAX_POINTS).div_ceil(LANES);

/// The integral over one box by a product of Gauss rules.
struct TensorWork<'a, 'b> {
    pairs: &'a LinearBasisPairs<'b>,
    piece: OctantBox,
    origin: [f64; 3],
    points: [usize; 3],
    shares: &'a mut DensityShares,
}

/// The nodes of a tensor rule on a box.
struct DensityNodes {
    /// Nodes per axis.
    count: [usize; 3],
    /// Squared coordinates, m².
    square: [[f64; MAX_POINTS]; 3],
    /// Densities times weights, with the numerator's power of t.
    density: [[[f64; LANES]; MAX_POINTS]; 3],
}

impl simd::SimdKernel for TensorWork<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn evaluate(self) {
        let used = self.pairs.along.map(density_count);
        let patches: i32 = self.pairs.power().iter().sum();
        let nodes = self.nodes();
        // Lay the squared distances of a plane of nodes out in lanes.
        let [nx, ny, nz] = nodes.count;
        let square = &nodes.square;
        let mut plane = [[square[1][0] + square[2][0]; LANES]; PLANE_LANES];
        for j in 0..ny {
            for k in 0..nz {
                let m = j * nz + k;
                plane[m / LANES][m % LANES] = square[1][j] + square[2][k];
            }
        }
        let groups = (ny * nz).div_ceil(LANES);
        let mut value = [[0.0; LANES]; PLANE_LANES];
        for i in 0..nx {
            for g in 0..groups {
                value[g] = self.kernel(patches, square[0][i], &plane[g]);
            }
            let lines = contract_plane(&nodes.density[1][..ny], &nodes.density[2][..nz], &value, used[1]);
            for e in 0..used[0] {
                for f in 0..used[1] {
                    for l in 0..LANES {
                        self.shares[e][f][l] += nodes.density[0][i][e] * lines[f][l];
                    }
                }
            }
        }
    }
}

impl TensorWork<'_, '_> {
    #[inline(always)]
    fn nodes(&self) -> DensityNodes {
        let (pairs, piece, power) = (self.pairs, &self.piece, self.pairs.power());
        let mut count = [1; 3];
        let mut square = [[0.0; MAX_POINTS]; 3];
        let mut density = [[[0.0; LANES]; MAX_POINTS]; 3];
        for k in 0..3 {
            if piece.len[k] > 0.0 {
                count[k] = self.points[k];
            }
            let rule = gauss_legendre::rule(count[k]);
            for i in 0..count[k] {
                let t = piece.lo[k] + piece.len[k] * rule.nodes[i];
                let length = if piece.len[k] > 0.0 { piece.len[k] } else { 1.0 };
                square[k][i] = t * t;
                let by = rule.weights[i] * length * density_rules::power(t, power[k]);
                let d = pairs.densities(k, (t - self.origin[k]) / pairs.edges[k]);
                for f in 0..6 {
                    density[k][i][f] = by * d[f];
                }
            }
        }
        DensityNodes { count, square, density }
    }

    /// e^{−κr}/r^{2+m} for m = `patches` at squared distances `square` + `plane`.
    #[inline(always)]
    fn kernel(&self, patches: i32, square: f64, plane: &[f64; LANES]) -> [f64; LANES] {
        let mut r2 = [0.0; LANES];
        for l in 0..LANES {
            r2[l] = square + plane[l];
        }
        let mut r = [0.0; LANES];
        for l in 0..LANES {
            r[l] = r2[l].sqrt();
        }
        let mut v = [0.0; LANES];
        for l in 0..LANES {
            v[l] = density_rules::shell(patches, r2[l]);
        }
        if self.pairs.kappa > 0.0 {
            let e = simd::exp(r.map(|r| -self.pairs.kappa * r));
            for l in 0..LANES {
                v[l] *= e[l];
            }
        }
        v
    }
}

/// Sums a plane of kernel values against the densities of its two axes, of which the first has `used` densities.
#[inline(always)]
fn contract_plane(
    first: &[[f64; LANES]],
    second: &[[f64; LANES]],
    value: &[[f64; LANES]],
    used: usize,
) -> [[f64; LANES]; 6] {
    let (mut lines, n) = ([[0.0; LANES]; 6], second.len());
    for (j, first) in first.iter().enumerate() {
        let mut line = [0.0; LANES];
        for (k, second) in second.iter().enumerate() {
            let m = j * n + k;
            let v = value[m / LANES][m % LANES];
            for l in 0..LANES {
                line[l] += v * second[l];
            }
        }
        for f in 0..used {
            for l in 0..LANES {
                lines[f][l] += first[f] * line[l];
            }
        }
    }
    lines
}

/// Lanes of the nodes of the base of a pyramid.
const BASE_LANES: usize = (BASE_POINTS * BASE_POINTS).div_ceil(LANES);

/// The integral over one pyramid of a box with a corner at zero, with the apex there and its base across axis a = `apex`: t_a = ℓ_a s, t_b = ℓ_b s v and
/// t_c = ℓ_c s w with the Jacobian ℓ_a ℓ_b ℓ_c s². All powers of s cancel: with Q = r/s the kernel is a function of v and w times e^{−κ s Q}.
struct PyramidWork<'a, 'b> {
    pairs: &'a LinearBasisPairs<'b>,
    piece: OctantBox,
    apex: usize,
    shares: &'a mut DensityShares,
}

impl simd::SimdKernel for PyramidWork<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn evaluate(self) {
        let kappa = self.pairs.kappa;
        let depth = kappa * self.piece.len.iter().map(|l| l * l).sum::<f64>().sqrt();
        let accuracy = self.pairs.accuracy;
        let rule = gauss_legendre::rule(accuracy.radial_points(MAX_CELL_DEPTH, depth));
        let base = gauss_legendre::rule(accuracy.base_points());
        let (count, groups) = (base.nodes.len(), base.nodes.len().pow(2).div_ceil(LANES));
        let axes @ [a, b, c] = [0, 1, 2].map(|k| (self.apex + k) % 3);
        let used = axes.map(|k| density_count(self.pairs.along[k]));
        let [shape, depth] = self.base(base, [b, c]);
        let mut value = shape;
        let mut own: DensityShares = [[[0.0; LANES]; 6]; 6];
        for (s, weight) in rule.nodes.iter().zip(&rule.weights) {
            if kappa > 0.0 {
                for g in 0..groups {
                    let e = simd::exp(depth[g].map(|x| x * s));
                    for l in 0..LANES {
                        value[g][l] = shape[g][l] * e[l];
                    }
                }
            }
            let [first, second] = [b, c].map(|k| {
                let mut density = [[0.0; LANES]; BASE_POINTS];
                for (density, u) in density.iter_mut().zip(&base.nodes) {
                    density[..6].copy_from_slice(&self.densities(k, s * u));
                }
                density
            });
            let lines = contract_plane(&first[..count], &second[..count], &value, used[1]);
            let along = self.densities(a, *s);
            for e in 0..used[0] {
                for f in 0..used[1] {
                    for l in 0..LANES {
                        own[e][f][l] += weight * along[e] * lines[f][l];
                    }
                }
            }
        }
        for (e, f, l) in (0..6).flat_map(|e| (0..6).flat_map(move |f| (0..6).map(move |l| (e, f, l)))) {
            let mut at = [0; 3];
            (at[a], at[b], at[c]) = (e, f, l);
            self.shares[at[0]][at[1]][at[2]] += own[e][f][l];
        }
    }
}

impl PyramidWork<'_, '_> {
    /// The densities along axis `k` at the part `u` of the edge of the box.
    #[inline(always)]
    fn densities(&self, k: usize, u: f64) -> [f64; 6] {
        self.pairs.densities(k, self.piece.len[k] * u / self.pairs.edges[k])
    }

    /// Weights times numerator and Q^{−q}, and −κQ, at the nodes of the base, whose axes are `b` and `c`. Padding has weights of zero.
    #[inline(always)]
    fn base(&self, rule: &QuadratureRule, [b, c]: [usize; 2]) -> [[[f64; LANES]; BASE_LANES]; 2] {
        let (n, len, power) = (rule.nodes.len(), self.piece.len, self.pairs.power());
        let patches: i32 = power.iter().sum();
        let volume: f64 = len.iter().product();
        let [mut shape, mut depth] = [[[0.0; LANES]; BASE_LANES]; 2];
        for (m, (v, w)) in (0..n).flat_map(|j| (0..n).map(move |k| (j, k))).enumerate() {
            let mut t = len;
            t[b] *= rule.nodes[v];
            t[c] *= rule.nodes[w];
            let square: f64 = t.iter().map(|t| t * t).sum();
            let r_power = density_rules::shell(patches, square);
            let up: f64 = (0..3).map(|k| density_rules::power(t[k], power[k])).product();
            let weight = volume * rule.weights[v] * rule.weights[w];
            shape[m / LANES][m % LANES] = weight * up * r_power;
            depth[m / LANES][m % LANES] = -self.pairs.kappa * square.sqrt();
        }
        [shape, depth]
    }
}

/// Number of densities of an axis.
fn density_count(along: AxisRelation) -> usize {
    match along {
        AxisRelation::Extended => 6,
        AxisRelation::OffWall => 2,
        AxisRelation::OppositeWalls => 1,
    }
}

#[cfg(test)]
mod tests;
