//! The proximity development (section 3.1 of the paper): a patch B against all cells of the mesh of a smooth surface, from a few
//! reference points.
//!
//! ```text
//! 𝓕(B, A) = ∫_B ∫_A K du dv dy,   K = (m·d)(−N·d)/(π (d·d)²),   d = S(u, v) − y,   N = S_u × S_v (to the front),
//! ```
//!
//! m the unit normal of B. About a reference (u₀, v₀), u = u₀ + Xξ, v = v₀ + Zζ, everything is a power series in ξ, ζ, cut at total degree N:
//! S − S₀ from the surface's local form (`surface`), ρ = d·d = |y′|² − 2y′·(S − S₀) + |S − S₀|² with y′ = y − S₀, ρ⁻² by recurrence (`taylor`).
//! m·d does not depend on y, and N·d = N·(S − S₀) − N·y′, so a node y of the rule over B costs one recurrence and four sums,
//!
//! ```text
//! G = Σ w ρ⁻²,  G′ = Σ w y′ρ⁻²,   Σ w K = (m·d)(N·G′ − N·(S − S₀) G)/π,
//! ```
//!
//! whatever the number of cells; a cell costs (N+1)(N+2)/2 products with the exact integrals of ξ^pζ^q. On a plane, along a line, this is
//! the paper's strip with the Gegenbauer polynomials of λ = 2.
//!
//! **Truncation.** Let W bound |S − S₀| and M bound |K| on the polydisc |ξ|, |ζ| ≤ s. At a point with max(|ξ|, |ζ|) ≤ τ < s the function
//! λ ↦ K(λξ, λζ) is analytic and at most M for |λ| ≤ s/τ, so (Cauchy) the terms of degree above N are at most M θ^{N+1}/(1 − θ), θ = τ/s.
//! Let D = |y′| be least over B, and W = W₁ + W₂ with W₁ for the linear part of S − S₀, λ times a real vector, and W₂ for the rest. As for a plane, the
//! linear part alone leaves |d·d| ≥ (D − W₁)² (its zeros have |λ||w| = |d₀|), so **|d·d| ≥ (D − W₁)² − 2(D + W₁)W₂ − W₂²**. Or, with d = a + ib,
//! |d·d| ≥ a² − b² and |a − d₀|² + b² ≤ W² give **|d·d| ≥ (D − W)²** for W ≤ D/2 (the least of a² − b² is then at b = 0). The larger holds. Also
//! |m·d| ≤ |m·d₀| + W and |N·d| ≤ |N₀·d₀| + ΔN(|d₀| + W) + |N₀|W₂, as N₀ is normal to the linear part. M is their quotient. The s that serves a
//! cell best is taken from `SCALES`.
//!
//! **Quadrature** over B, Gauss–Legendre in two directions (collapsed on a triangle). Let y move along its plane by the complex multiple c f of an edge,
//! |c f| ≤ δ < D′, D′ the least real distance. d·d has its zeros at complex multiples of modulus |d|/|f|, so |d·d| ≥ (|d| − δ)²; m·d does not change. On the ellipse of semi-axes
//! a, b about the edge the distance to the edge is at most b|f|/2 = δ. So M′ = (m·d)^ N̂ (D″ + δ)/(π (D′ − δ)⁴), D″ the largest distance, times 1 + a for the weight of a triangle.
//!
//! **Rounding**: norms of the series (`taylor`) bound every product; the error of S₀ and of the nodes (`shake`) enters ρ, m·d and N·d.
//! Library sines and cosines are taken to be right to an ulp.
//!
//! **References**: a block of cells has one, in its middle, if the bound for the whole block is within the tolerance; else the block is
//! halved across its longer extent. A single cell that fails is too near: its radius says so or it is [`Cell::Near`].
//! **Horizon**: a cell must see all of B and be seen by all of it, but for what rounding leaves open (a wall that stands on the surface's
//! plane), which is in the radius. By bounds on the cell or on parts of it: cells that do not at all are
//! exactly zero; [`Cell::Horizon`] ones are left to another method, as K changes its sign there. What else stands between is not
//! asked: the surface itself, if it is not convex towards B, may.

mod develop;
mod sight;
mod surface;
mod taylor;

pub use surface::Surface;
pub use taylor::MAX_ORDER;

use crate::{Demand, Factor, Method};
use sight::{HORIZON_DEPTH, Sight, distance, farthest, graze, seen, size, skew};
use std::f64::consts::PI;
use std::ops::Range;
use surface::{Local, Majorant};
use taylor::EPS;
use zonal_math::{Bounded, Vec3, gauss};
use zonal_scene::{Plate, PlateKind};

/// Polydiscs tried for Cauchy's estimate, relative to the block.
const SCALES: [f64; 14] = [1.15, 1.3, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 15.0, 25.0, 50.0];
/// Shares of the distance that y may move in the quadrature's bound.
const MOVES: [f64; 6] = [0.1, 0.2, 0.35, 0.5, 0.65, 0.8];
/// Points in a direction over B at most.
const MOST_POINTS: usize = 32;
/// |d·d| ≥ (D − W)² as long as W is at most this share of D.
const TWIST: f64 = 0.5;
/// Roundings of a point of the surface or of B, in ε of the lengths that it is summed from: sine and cosine (2 each), four products, four sums,
/// a node (2), and two for second orders.
const DATA: f64 = 2.0 * 2.0 + 4.0 + 4.0 + 2.0 + 2.0; // bound
/// What the arithmetic of the radii themselves may lose.
const SLACK: f64 = 1.0 + 1e-9;

/// Edges of the cells of a mesh in the parameters of its surface, ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Edges along u.
    pub u: Vec<f64>,
    /// Edges along v.
    pub v: Vec<f64>,
}

impl Mesh {
    /// A mesh of `n` by `m` equal cells between two corners (u, v).
    pub fn regular(lo: [f64; 2], hi: [f64; 2], n: usize, m: usize) -> Mesh {
        let edges =
            |k: usize, n: usize| (0..=n).map(|i| lo[k] + (hi[k] - lo[k]) * i as f64 / n as f64).collect();
        Mesh { u: edges(0, n), v: edges(1, m) }
    }

    /// Cells along u and along v.
    pub fn cells(&self) -> [usize; 2] {
        [self.u.len() - 1, self.v.len() - 1]
    }

    fn patch(&self, j: usize, k: usize) -> [[f64; 2]; 2] {
        self.part(&(j..j + 1), &(k..k + 1))
    }

    fn part(&self, js: &Range<usize>, ks: &Range<usize>) -> [[f64; 2]; 2] {
        [[self.u[js.start], self.u[js.end]], [self.v[ks.start], self.v[ks.end]]]
    }
}

/// What became of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    /// 𝓕 with its proven radius, m²; exactly zero for a cell that B does not see. `evaluations` is a share: those of the block by its cells.
    Factor(Factor),
    /// It sees a part of B, or cannot be told to see all of it: left to another method.
    Horizon,
    /// No polydisc fits between it and B, or the radius would exceed the value, or the budget was spent: left to another method.
    Near,
}

/// All cells of a mesh, with what it took.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Row by row: the cell (j, k) at j·(cells along v) + k.
    pub cells: Vec<Cell>,
    /// Blocks, each with a reference of its own.
    pub references: usize,
    /// Series that were computed: one for each node of B and each reference.
    pub evaluations: u64,
}

/// 𝓕 of `plate` and every cell of the mesh of `surface`, m², by developments of total degree `order`.
///
/// # Panics
/// On an order of zero or above [`MAX_ORDER`].
pub fn factors(surface: &Surface, mesh: &Mesh, plate: &Plate, order: usize, demand: &Demand) -> Row {
    assert!((1..=MAX_ORDER).contains(&order), "order {order}");
    let [n, m] = mesh.cells();
    let row = Row { cells: vec![Cell::Near; n * m], references: 0, evaluations: 0 };
    let largest = |e: &[f64]| e[0].abs().max(e[e.len() - 1].abs());
    let shake =
        skew(plate) * DATA * EPS * (surface.magnitude(largest(&mesh.u), largest(&mesh.v)) + size(plate));
    let mut job = Job { surface, mesh, plate, order, demand, shake, row };
    job.sight(0..n, 0..m);
    job.block(0..n, 0..m);
    job.row
}

/// 𝓕 of `plate` and one cell [[u₀, u₁], [v₀, v₁]] by tensor Gauss rules of `points` points in each of four directions, m²: the baseline. What is
/// behind either counts as zero. The radius is the difference to one point less: estimated.
pub fn direct(surface: &Surface, cell: [[f64; 2]; 2], plate: &Plate, points: usize) -> Factor {
    let sum = |n: usize| {
        let rule = gauss::rule(n);
        let nodes = nodes(plate, n);
        let (normal, mut sum) = (plate.normal(), 0.0);
        for (x, wx) in rule.nodes.iter().zip(&rule.weights) {
            for (z, wz) in rule.nodes.iter().zip(&rule.weights) {
                let (u, v) =
                    (cell[0][0] + x * (cell[0][1] - cell[0][0]), cell[1][0] + z * (cell[1][1] - cell[1][0]));
                let (s, slope) = (surface.at(u, v), surface.normal(u, v));
                for (y, w) in &nodes {
                    let d = s - *y;
                    sum +=
                        wx * wz * w * normal.dot(d).max(0.0) * (-slope.dot(d)).max(0.0) / d.length2().powi(2);
                }
            }
        }
        sum * plate.area() * (cell[0][1] - cell[0][0]) * (cell[1][1] - cell[1][0]) / PI
    };
    let (fine, coarse) = (sum(points), sum(points - 1));
    let evaluations = (points.pow(4) + (points - 1).pow(4)) as u64;
    Factor { bounded: Bounded::estimated(fine, (fine - coarse).abs()), evaluations, method: Method::Oblique }
}

/// Nodes of B and their weights, of sum one to quadrature.
fn nodes(plate: &Plate, n: usize) -> Vec<(Vec3, f64)> {
    let rule = gauss::rule(n);
    let mut out = Vec::with_capacity(n * n);
    for (s, ws) in rule.nodes.iter().zip(&rule.weights) {
        for (t, wt) in rule.nodes.iter().zip(&rule.weights) {
            out.push(match plate.kind {
                PlateKind::Parallelogram => (plate.at(*s, *t), ws * wt),
                PlateKind::Triangle => (plate.at(s * (1.0 - t), s * t), 2.0 * s * ws * wt),
            });
        }
    }
    out
}

struct Job<'a> {
    surface: &'a Surface,
    mesh: &'a Mesh,
    plate: &'a Plate,
    order: usize,
    demand: &'a Demand,
    /// Error of a point by rounding, m.
    shake: f64,
    row: Row,
}

/// A reference point with the extents of its block.
struct Reference {
    at: [f64; 2],
    half: [f64; 2],
    local: Local,
    s: Vec3,
    normal: Vec3,
    near: f64,
    far: f64,
    /// Largest |N₀·d₀| over B, and |m·d₀|.
    facing: f64,
    height: f64,
}

impl Job<'_> {
    fn index(&self, j: usize, k: usize) -> usize {
        j * self.mesh.cells()[1] + k
    }

    /// Tells which cells of a block are seen, all at once where that can be.
    fn sight(&mut self, js: Range<usize>, ks: Range<usize>) {
        let cell = js.len() * ks.len() == 1;
        let depth = if cell { 0 } else { HORIZON_DEPTH };
        let open = Factor { bounded: Bounded::ZERO, evaluations: 0, method: Method::Proximity };
        let word = match seen(self.surface, self.mesh.part(&js, &ks), self.plate, self.shake, depth) {
            Sight::Whole => Cell::Factor(open),
            Sight::Nothing => Cell::Factor(Factor::UNSEEN),
            Sight::Part if cell => Cell::Horizon,
            Sight::Part => {
                let middle = |r: &Range<usize>| (r.start + r.end) / 2;
                if js.len() >= ks.len() {
                    let at = middle(&js);
                    self.sight(js.start..at, ks.clone());
                    self.sight(at..js.end, ks);
                } else {
                    let at = middle(&ks);
                    self.sight(js.clone(), ks.start..at);
                    self.sight(js, at..ks.end);
                }
                return;
            }
        };
        for j in js {
            for k in ks.clone() {
                self.set(j, k, word);
            }
        }
    }

    /// Cells of a block that want a value.
    fn wanted(&self, js: &Range<usize>, ks: &Range<usize>) -> Vec<(usize, usize)> {
        let all = js.clone().flat_map(|j| ks.clone().map(move |k| (j, k)));
        let open = |c: &Cell| matches!(c, Cell::Factor(f) if f.method == Method::Proximity);
        all.filter(|(j, k)| open(&self.row.cells[self.index(*j, *k)])).collect()
    }

    fn block(&mut self, js: Range<usize>, ks: Range<usize>) {
        let cells = self.wanted(&js, &ks);
        if cells.is_empty() {
            return;
        }
        let reference = self.reference(&js, &ks);
        let done = self.develop(&reference, &cells);
        if done || js.len() * ks.len() == 1 {
            return;
        }
        // The longer extent is halved.
        let reach = |r: [f64; 2]| reference.local.majorant(r).reach;
        let along = reach([reference.half[0], 0.0]) >= reach([0.0, reference.half[1]]);
        if js.len() > 1 && (along || ks.len() == 1) {
            let middle = (js.start + js.end) / 2;
            self.block(js.start..middle, ks.clone());
            self.block(middle..js.end, ks);
        } else {
            let middle = (ks.start + ks.end) / 2;
            self.block(js.clone(), ks.start..middle);
            self.block(js, middle..ks.end);
        }
    }

    fn reference(&self, js: &Range<usize>, ks: &Range<usize>) -> Reference {
        let extent =
            |e: &[f64], r: &Range<usize>| (0.5 * (e[r.start] + e[r.end]), 0.5 * (e[r.end] - e[r.start]));
        let ((u, hu), (v, hv)) = (extent(&self.mesh.u, js), extent(&self.mesh.v, ks));
        let (s, normal) = (self.surface.at(u, v), self.surface.normal(u, v));
        let (corners, n) = self.plate.corners();
        let facing = corners[..n].iter().fold(0.0f64, |m, c| m.max(normal.dot(*c - s).abs()));
        let shake = self.shake;
        let far = farthest(self.plate, s) + shake;
        Reference {
            at: [u, v],
            half: [hu * SLACK, hv * SLACK],
            local: self.surface.local(u, v),
            s,
            normal,
            near: (distance(self.plate, s) - shake).max(0.0),
            far,
            facing: (facing + normal.length() * (shake + DATA * EPS * far)) * SLACK,
            height: (self.plate.normal().dot(s - self.plate.origin).abs() + shake) * SLACK,
        }
    }

    /// Develops about a reference and sets the cells; false, and nothing done or counted but the work, if some cell fails and parts of the block may fare better.
    fn develop(&mut self, r: &Reference, cells: &[(usize, usize)]) -> bool {
        let single = cells.len() == 1;
        let typical = self.typical(r);
        let discs = r.discs();
        let truncation = |tau: f64| remainder(&discs, tau, self.order);
        let wanted = 0.25 * self.demand.tolerance * typical;
        let m = r.local.majorant(r.half);
        if discs.is_empty() || m.reach >= r.near || (!single && exceeds(truncation(1.0), wanted)) {
            if single {
                cells.iter().for_each(|(j, k)| self.set(*j, *k, Cell::Near));
            }
            return false;
        }
        let (points, quadrature) = r.points(self.plate, &m, wanted);
        let quadrature = quadrature + r.clamp(&m, self.shake);
        if self.row.evaluations >= self.demand.budget {
            cells.iter().for_each(|(j, k)| self.set(*j, *k, Cell::Near));
            return true;
        }
        let sum = r.sum(self.surface, self.plate, self.order, points);
        self.row.evaluations += (points * points) as u64;
        let share = (points * points).div_ceil(cells.len()) as u64;
        let area = self.plate.area();
        let mut done = Vec::with_capacity(cells.len());
        for (j, k) in cells {
            let patch = self.mesh.patch(*j, *k);
            let (value, rounding, tau, size) = sum.over(r, patch);
            let radius = area * SLACK * (size * (truncation(tau) + quadrature) + rounding);
            let bounded =
                Bounded::proved(value * area, radius + DATA * EPS * skew(self.plate) * (value * area).abs());
            if !single && exceeds(bounded.radius, self.demand.radius(bounded.value)) {
                return false;
            }
            done.push(Factor { bounded, evaluations: share, method: Method::Proximity });
        }
        for ((j, k), f) in cells.iter().zip(done) {
            let good = f.bounded.radius <= f.bounded.value;
            self.set(*j, *k, if good { Cell::Factor(f) } else { Cell::Near });
        }
        self.row.references += 1;
        true
    }

    fn set(&mut self, j: usize, k: usize, cell: Cell) {
        let at = self.index(j, k);
        self.row.cells[at] = cell;
    }

    /// K at the reference and B's centre: what the bounds are weighed against before a value is known.
    fn typical(&self, r: &Reference) -> f64 {
        let d = r.s - self.plate.centre();
        self.plate.normal().dot(d).max(0.0) * (-r.normal.dot(d)).max(0.0) / (PI * d.length2().powi(2))
    }
}

/// True unless `x` is a number of at most `limit`.
fn exceeds(x: f64, limit: f64) -> bool {
    x.partial_cmp(&limit).is_none_or(|o| o.is_gt())
}

/// M θ^{N+1}/(1 − θ) at its best.
fn remainder(discs: &[(f64, f64)], tau: f64, order: usize) -> f64 {
    let term = |(s, m): &(f64, f64)| {
        let theta = tau / s;
        m * theta.powi(order as i32 + 1) / (1.0 - theta)
    };
    discs.iter().map(term).fold(f64::INFINITY, f64::min) * SLACK
}

impl Reference {
    /// (s, M) of the polydiscs that fit.
    fn discs(&self) -> Vec<(f64, f64)> {
        let disc = |s: f64| {
            let m = self.local.majorant(self.half.map(|h| h * s));
            let [reach, linear, rest] = [m.reach, m.linear, m.rest].map(|x| x * SLACK);
            let twisted = if reach <= TWIST * self.near { (self.near - reach).powi(2) } else { 0.0 };
            let straight = if linear < self.near {
                (self.near - linear).powi(2) - 2.0 * (self.near + linear) * rest - rest * rest
            } else {
                0.0
            };
            let square = twisted.max(straight) / SLACK;
            (square > 0.0).then(|| {
                let facing = self.facing + m.bend * (self.far + reach) + self.normal.length() * rest;
                (s, (self.height + reach) * facing / (PI * square * square) * SLACK)
            })
        };
        SCALES.iter().filter_map(|s| disc(*s)).collect()
    }

    /// Where a cell sees B or is seen by it along the surface, to rounding, K may be negative for what is behind: a bound of its modulus there.
    fn clamp(&self, m: &Majorant, shake: f64) -> f64 {
        let reach = m.reach * SLACK;
        let (near, far) = (self.near - reach, self.far + reach);
        let tilt = graze(m.normal, shake, far);
        let either = shake * m.normal * far + tilt * (self.height + reach) + shake * tilt;
        2.0 * either * SLACK / (PI * near.powi(4))
    }

    /// Points in a direction over B for an error of K's mean of `wanted`, and the bound that they have.
    fn points(&self, plate: &Plate, m: &Majorant, wanted: f64) -> (usize, f64) {
        let (near, far) = (self.near - m.reach * SLACK, self.far + m.reach * SLACK);
        let front = (self.height + m.reach * SLACK) * m.normal / PI;
        let triangle = plate.kind == PlateKind::Triangle;
        let across = if triangle { (plate.e2 - plate.e1).length() } else { plate.e2.length() };
        let along = if triangle { plate.e1.length().max(plate.e2.length()) } else { plate.e1.length() };
        let one = |n: usize, length: f64, weighted: bool| {
            let bound = |share: &f64| {
                let delta = share * near;
                let b = 2.0 * delta / (length * SLACK);
                let a = (1.0 + b * b).sqrt();
                let m = front * (far + delta) / (near - delta).powi(4);
                gauss::error_bound(n, a + b, m * if weighted { 1.0 + a } else { 1.0 })
            };
            MOVES.iter().map(bound).fold(f64::INFINITY, f64::min)
        };
        let error = |n: usize| (one(n, along, triangle) + one(n, across, false)) * SLACK;
        let n = (2..MOST_POINTS).find(|n| error(*n) <= wanted).unwrap_or(MOST_POINTS);
        (n, error(n))
    }
}

#[cfg(test)]
#[path = "proximity/tests.rs"]
mod tests;
