//! The mean of K over B as a power series about a reference, with norms that bound its roundings.

use super::error_constants::POINT_ROUNDINGS;
use super::plate_geometry::{coordinate_scale, edge_skew, plate_nodes};
use super::power_series::{self, MAX_ORDER, PowerSeries};
use super::reference::Reference;
use super::surface::{Derivative, SmoothSurface};
use crate::rounding::UNIT_ROUNDOFF;
use std::f64::consts::PI;
use zonal_scene::Plate;

/// The mean of K over B about a reference.
pub(super) struct KernelSeries {
    kernel: PowerSeries,
    magnitude: f64,
    error: f64,
}

/// The surface about a reference.
struct LocalSeries {
    /// S − S₀.
    shift: [PowerSeries; 3],
    /// N.
    normal: [PowerSeries; 3],
    /// |S − S₀|².
    square: PowerSeries,
    /// N·(S − S₀).
    along: PowerSeries,
}

impl KernelSeries {
    /// The development of the mean of K over B.
    pub(super) fn new(
        r: &Reference,
        surface: &SmoothSurface,
        plate: &Plate,
        order: usize,
        points: usize,
    ) -> KernelSeries {
        let (local, norms) = LocalSeries::new(r, surface, plate, order);
        local.integrate(r, plate, points, &norms)
    }
}

/// The series of the normal: `side` times the cross product of the two slopes.
fn normal_series(slopes: &[[PowerSeries; 3]; 2], side: f64, order: usize) -> [PowerSeries; 3] {
    std::array::from_fn(|a| {
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        let mut n = PowerSeries::zero(order);
        n.add_product(side, &slopes[0][b], &slopes[1][c]);
        n.add_product(-side, &slopes[0][c], &slopes[1][b]);
        n
    })
}

impl LocalSeries {
    /// The series of the surface about the reference, with their norms.
    fn new(
        r: &Reference,
        surface: &SmoothSurface,
        plate: &Plate,
        order: usize,
    ) -> (LocalSeries, SeriesNorms) {
        let half = r.half;
        let zero = || PowerSeries::zero(order);
        let (mut shift, mut slopes) =
            ([zero(), zero(), zero()], [[zero(), zero(), zero()], [zero(), zero(), zero()]]);
        let mut table = [[0.0; MAX_ORDER + 1]; 4];
        // Sums of moduli with the lengths of the summands: norms without cancellation.
        let (mut spread, mut slope) = (0.0, [0.0; 2]);
        for t in r.local.terms() {
            let [f, g, df, dg] = &mut table;
            t.f.coefficients(half[0], Derivative::Value, &mut f[..=order]);
            t.g.coefficients(half[1], Derivative::Value, &mut g[..=order]);
            t.f.coefficients(half[0], Derivative::First, &mut df[..=order]);
            t.g.coefficients(half[1], Derivative::First, &mut dg[..=order]);
            let c = t.c.array();
            for axis in 0..3 {
                shift[axis].add_outer(c[axis], f, g);
                slopes[0][axis].add_outer(c[axis], df, g);
                slopes[1][axis].add_outer(c[axis], f, dg);
            }
            let norm = |x: &[f64]| x[..=order].iter().map(|x| x.abs()).sum::<f64>();
            spread += t.size * norm(f) * norm(g);
            slope[0] += t.size * norm(df) * norm(g);
            slope[1] += t.size * norm(f) * norm(dg);
        }
        shift.iter_mut().for_each(|s| s.c[0] = 0.0);
        let normal = normal_series(&slopes, surface.side(), order);
        let (mut square, mut along) = (zero(), zero());
        for a in 0..3 {
            square.add_product(1.0, &shift[a], &shift[a]);
            along.add_product(1.0, &normal[a], &shift[a]);
        }
        let norms = SeriesNorms {
            shake: edge_skew(plate)
                * POINT_ROUNDINGS
                * UNIT_ROUNDOFF
                * (surface.magnitude(r.at[0], r.at[1]) + coordinate_scale(plate) + spread),
            shift: 3f64.sqrt() * spread,
            normal: 2.0 * 3f64.sqrt() * slope[0] * slope[1],
            terms: square.c.len() as f64,
            order: order as f64,
        };
        (LocalSeries { shift, normal, square, along }, norms)
    }

    /// Sums the recurrences over the nodes of B.
    fn integrate(&self, r: &Reference, plate: &Plate, points: usize, norms: &SeriesNorms) -> KernelSeries {
        let LocalSeries { shift, normal, square, along } = self;
        let order = square.order;
        let zero = || PowerSeries::zero(order);
        let (mut total, mut moments, mut h) = (zero(), [zero(), zero(), zero()], zero());
        let mut sums = NormSums::default();
        for (y, w) in plate_nodes(plate, points) {
            let y = y - r.s;
            let mut rho = square.clone();
            let parts = y.array();
            (0..3).for_each(|a| rho.add(-2.0 * parts[a], &shift[a]));
            rho.c[0] = y.length2();
            let own = rho.inverse_square(&mut h);
            total.add(w, &h);
            (0..3).for_each(|a| moments[a].add(w * parts[a], &h));
            sums.add(
                &NodeNorms { weight: w, distance: y.length(), rho: rho.norm(), h: h.norm(), own },
                norms,
            );
        }
        // (m·d)(N·G′ − N·(S − S₀) G)/π.
        let m = plate.normal();
        let (mut front, mut inner, mut kernel) = (zero(), zero(), zero());
        (0..3).for_each(|a| front.add(m.array()[a], &shift[a]));
        front.c[0] = m.dot(r.s - plate.origin);
        (0..3).for_each(|a| inner.add_product(1.0, &normal[a], &moments[a]));
        inner.add_product(-1.0, along, &total);
        kernel.add_product(1.0 / PI, &front, &inner);
        let (magnitude, error) = sums.finish(front.norm(), points as f64, norms);
        KernelSeries { kernel, magnitude, error }
    }
}

/// Norms of a block's series and of their errors.
struct SeriesNorms {
    /// Error of a point of the surface or of B, m.
    shake: f64,
    /// ‖S − S₀‖, m.
    shift: f64,
    /// ‖N‖, m².
    normal: f64,
    /// Coefficients of a series.
    terms: f64,
    order: f64,
}

/// One node of B.
struct NodeNorms {
    /// Weight of the node.
    weight: f64,
    /// |y′|, m.
    distance: f64,
    /// ‖ρ‖.
    rho: f64,
    /// ‖ρ⁻²‖.
    h: f64,
    /// The recurrence's own error.
    own: f64,
}

/// Norms and errors summed over the nodes of B.
#[derive(Default)]
struct NormSums {
    /// Σ w ‖h‖ and Σ w |y′| ‖h‖ with their errors.
    total: f64,
    total_error: f64,
    moment: f64,
    moment_error: f64,
}

/// Roundings in a coefficient of the surface's series, besides two for each power: the local form's vector (ten at most, sines and
/// cosines two each), two functions' last powers, a product with the vector, the sum of eight terms.
pub(super) const COEFFICIENT_ROUNDINGS: f64 = 10.0 + 2.0 + 2.0 + 8.0; // bound
/// Roundings in a sum of products besides one for each term: factors (2), a weight and its point (4), π (2), an area (2), second orders (2).
pub(super) const SUM_ROUNDINGS: f64 = 2.0 + 4.0 + 2.0 + 2.0 + 2.0; // bound

impl NormSums {
    /// Adds one node.
    fn add(&mut self, node: &NodeNorms, s: &SeriesNorms) {
        let NodeNorms { weight: w, distance: y, rho, h, own } = *node;
        let d = 3f64.sqrt() * y + s.shift;
        let source = (2.0 * s.order + COEFFICIENT_ROUNDINGS) * UNIT_ROUNDOFF;
        let off = 2.0 * d * (s.shake + source * s.shift)
            + s.shake * s.shake
            + (3.0 * s.terms + SUM_ROUNDINGS) * UNIT_ROUNDOFF * d * d;
        // |(ρ+δ)⁻² − ρ⁻²| ≤ c ‖(ρ+δ)⁻²‖ ‖ρ⁻²‖, c = 2‖ρ‖‖δ‖ + ‖δ‖².
        let c = (2.0 * rho + off) * off * (h + own);
        let error = own + if c < 0.5 { c / (1.0 - c) * (h + own) } else { f64::INFINITY };
        self.total += w * h;
        self.total_error += w * error;
        self.moment += w * y * h;
        self.moment_error += w * (y * error + s.shake * (h + error));
    }

    /// ‖K‖ without cancellation, and the bound of its error.
    fn finish(&self, front: f64, points: f64, s: &SeriesNorms) -> (f64, f64) {
        // Two products make N, three more N·(S − S₀), four N·G′ − N·(S − S₀) G; a coefficient of one has fewer terms than the series.
        let sums = (points * points + (2.0 + 3.0 + 4.0) * s.terms + SUM_ROUNDINGS) * UNIT_ROUNDOFF;
        let source = (4.0 * s.order + 2.0 * COEFFICIENT_ROUNDINGS) * UNIT_ROUNDOFF;
        let inner = s.normal * (self.moment + s.shift * self.total);
        let inner_error = s.normal * (self.moment_error + s.shift * self.total_error)
            + (2.0 * source + sums) * inner
            + s.normal * s.shake * self.total;
        // A point's error, that of the normal, and as much for the products.
        let front_error = 4.0 * s.shake + source * s.shift + SUM_ROUNDINGS * UNIT_ROUNDOFF * front;
        let magnitude = front * inner / PI;
        let error = (front + front_error) * inner_error + front_error * inner;
        (magnitude, error / PI + (s.terms + SUM_ROUNDINGS) * UNIT_ROUNDOFF * magnitude)
    }
}

impl KernelSeries {
    /// ∫ over a cell, the bound of its rounding, the cell's reach in units of the block and its size in (u, v).
    pub(super) fn over(&self, r: &Reference, cell: [[f64; 2]; 2]) -> (f64, f64, f64, f64) {
        let order = self.kernel.order;
        let place = |k: usize| cell[k].map(|e| (e - r.at[k]) / r.half[k]);
        let (x, z) = (place(0), place(1));
        let (fx, fz) =
            (power_series::power_means(x[0], x[1], order), power_series::power_means(z[0], z[1], order));
        let mut mean = 0.0;
        for n in 0..=order {
            for q in 0..=n {
                mean += self.kernel.c[power_series::coefficient_index(n - q, q)] * fx[n - q] * fz[q];
            }
        }
        let sides = cell.map(|e| e[1] - e[0]);
        let size = sides[0] * sides[1];
        let sums = (self.kernel.c.len() as f64 + 6.0 * order as f64 + SUM_ROUNDINGS) * UNIT_ROUNDOFF;
        // An edge off by two roundings of its place moves as much of the cell.
        let edges = 8.0 * UNIT_ROUNDOFF * (r.half[0] * sides[1] + r.half[1] * sides[0]);
        let rounding = size * (self.error + sums * self.magnitude) + edges * self.magnitude;
        let tau = [x, z].iter().flatten().fold(0.0f64, |t, e| t.max(e.abs()));
        (mean * size, rounding, tau, size)
    }
}
