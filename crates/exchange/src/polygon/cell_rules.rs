//! Plates against plates in a medium, and plates against boxes, in any position: tensor Gauss rules on cells, proved.
//!
//! ```text
//! two plates       𝓕 = (1/π) ∬ e^{−κr} h_a(y) h_b(x) / r⁴ dA dA        h_a(y) the height of y over a's plane
//! plate and box    𝓕 = (1/π) ∬ e^{−κr} h_a(y) / r³ dA dV               r = |y − x|
//! ```
//!
//! Both zones are images of cubes (a triangle's with the Jacobian 1 − u, [`super::mapped_zone`]). A pair of cells that is far enough apart takes
//! Gauss–Legendre points; any other is cut in two, the longer cell of both, the pair with the widest enclosure first.
//!
//! **Proof.** One parameter s at a time becomes complex, on an ellipse around [0, 1] with semi-axes A, B, A² = B² + ¼; y − x moves along
//! an edge of length ℓ at most. Let D be the least distance of the two cells. A point s = ½ + A cosφ + iB sinφ lies Bsinφ beside the
//! interval where A|cosφ| ≤ ½, and then Re r² ≥ D² − B²ℓ²; elsewhere it lies beyond an end by A|cosφ| − ½, and with c = |cosφ|
//!
//! ```text
//! Re r² ≥ (D − (Ac − ½)ℓ)² − B²(1 − c²)ℓ²      as long as D ≥ (A − ½)ℓ: convex in c, least at c = A(D + ℓ/2)/((A² + B²)ℓ) or at an end.
//! ```
//!
//! With R the smaller of the two, positive, r is analytic, |r^{−q}| ≤ R^{−q/2} and |e^{−κr}| ≤ e^{−κ√R}; a height, at most H on the cell and
//! changing by
//! η along the edge, is at most H + η(A − ½). The rule's error follows ([`zonal_math::gauss_legendre::error_bound`]); those of the directions add,
//! the weights being positive.
//!
//! **Cells that are not integrated** have an enclosure. Two plates: e^{−κ r_max} 𝓕₀ … e^{−κD} 𝓕₀ with 𝓕₀ by the contour, where both are in front
//! of each other. Else from zero to the least of measure · sup of the kernel and the geometric bounds: 𝓕 ≤ the smaller area, 𝓕 ≤ 2V (half of all
//! directions see the plate), 𝓕 ≤ A · diameter of the box (no chord is longer).
//!
//! **Rounding**, ε = 2⁻⁵³: positions err by η = ([`PLACE_ROUNDINGS`] + 2 depth) ε L, L the lengths of the pair, so r by 4η/D relative, heights
//! by 4η; the rest is
//! products and sums, κr in the exponent.

use super::contour::{self, COPLANAR_BOUND, Contour};
use super::mapped_zone::{MappedZone, ParameterDirection, assert_valid_plate};
use crate::{AccuracyRequest, Factor, Method};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;
use zonal_math::{Bounded, Vec3, gauss_legendre, simd};
use zonal_scene::Plate;

/// Unit roundoff 2⁻⁵³.
const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;
/// Roundings of a position, relative to the pair's lengths, before any cut: differences, edges, products, sums.
const PLACE_ROUNDINGS: f64 = 16.0; // bound
/// Errors of r and of a height, in errors of a position: two positions, and the operations between.
const ERRORS_PER_PLACE_ERROR: f64 = 4.0; // bound
/// Roundings of products and sums, without the points of the sums.
const PRODUCT_ROUNDINGS: f64 = 64.0; // bound
/// Points along one direction and evaluations of a whole rule, at most; cells that need more are cut.
const MAX_POINTS_PER_DIRECTION: usize = 14;
const MAX_RULE_EVALUATIONS: u64 = 60_000;
/// Cells per pair, at most.
const MAX_CELLS: usize = 20_000;
/// Share of the tolerance for the rule of each cell, relative to its value.
const CELL_ERROR_SHARE: f64 = 0.4;
/// Widths of the candidate ellipses relative to the widest.
const ELLIPSE_FRACTIONS: [f64; 10] = [0.93, 0.82, 0.68, 0.52, 0.37, 0.25, 0.15, 0.08, 0.04, 0.015];

/// 𝓕 of two plates in a medium, m².
pub(super) fn plate_plate(a: &Plate, b: &Plate, kappa: f64, accuracy: AccuracyRequest) -> Factor {
    let d = b.origin - a.origin;
    run(MappedZone::plate(a, Vec3::ZERO), MappedZone::plate(b, d), kappa, accuracy)
}

/// 𝓕 = (1/π) ∬ e^{−κr} cosθ/r² dA dV of the front of a plate and the box from `lo` to `hi`, m³; `kappa` in 1/m. Grade proved.
///
/// The radius is at most tolerance · 𝓕 within the limit of evaluations: boxes that touch the plate or reach behind its plane take many cells and
/// may end
/// with a larger radius.
///
/// # Panics
/// On a plate without area, a box without volume, corners that are not finite, a `kappa` that is negative or not finite.
pub fn plate_cuboid(p: &Plate, lo: Vec3, hi: Vec3, kappa: f64, accuracy: AccuracyRequest) -> Factor {
    assert_valid_plate(p);
    let edge = hi - lo;
    assert!(
        lo.is_finite() && hi.is_finite() && edge.array().iter().all(|e| *e > 0.0),
        "not a box: {lo:?} {hi:?}"
    );
    assert!(kappa >= 0.0 && kappa.is_finite(), "extinction {kappa} 1/m");
    run(MappedZone::plate(p, Vec3::ZERO), MappedZone::cuboid(lo - p.origin, edge), kappa, accuracy)
}

/// A pair of cells with an enclosure of its 𝓕.
#[derive(Clone, Debug)]
struct CellPair {
    a: MappedZone,
    b: MappedZone,
    low: f64,
    high: f64,
    depth: u32,
}

impl CellPair {
    fn width(&self) -> f64 {
        self.high - self.low
    }
}

impl PartialEq for CellPair {
    fn eq(&self, o: &CellPair) -> bool {
        self.cmp(o) == Ordering::Equal
    }
}
impl Eq for CellPair {}
impl PartialOrd for CellPair {
    fn partial_cmp(&self, o: &CellPair) -> Option<Ordering> {
        Some(self.cmp(o))
    }
}
impl Ord for CellPair {
    fn cmp(&self, o: &CellPair) -> Ordering {
        let corner = |c: &CellPair| [c.a.corner.array(), c.b.corner.array()];
        let places = || {
            let (p, q) = (corner(self), corner(o));
            p.as_flattened().iter().zip(q.as_flattened()).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne())
        };
        self.width().total_cmp(&o.width()).then_with(|| places().unwrap_or(Ordering::Equal))
    }
}

/// State of the subdivision: integrals so far, and the open cells.
struct CellSearch {
    kappa: f64,
    tolerance: f64,
    /// L, m.
    lengths: f64,
    value: f64,
    radius: f64,
    evaluations: u64,
    open: BinaryHeap<CellPair>,
    /// Sums over the open cells.
    middle: f64,
    half: f64,
}

fn run(a: MappedZone, b: MappedZone, kappa: f64, accuracy: AccuracyRequest) -> Factor {
    let lengths = (b.corner - a.corner).length() + a.reach() + b.reach();
    let mut s = CellSearch {
        kappa,
        tolerance: accuracy.tolerance.max(1e-12),
        lengths,
        value: 0.0,
        radius: 0.0,
        evaluations: 0,
        open: BinaryHeap::new(),
        middle: 0.0,
        half: 0.0,
    };
    s.process(a, b, 0);
    let mut cells = 1;
    while !s.is_converged(accuracy.tolerance)
        && s.evaluations < accuracy.max_evaluations
        && cells < MAX_CELLS
        && let Some(c) = s.open.pop()
    {
        s.middle -= 0.5 * (c.low + c.high);
        s.half -= 0.5 * c.width();
        for (a, b) in bisect_longer(c.a, c.b) {
            s.process(a, b, c.depth + 1);
        }
        cells += 1;
    }
    // Sum again, since the running sums carry rounding errors.
    let (mut value, mut radius) = (s.value, s.radius);
    for c in s.open.into_sorted_vec() {
        value += 0.5 * (c.low + c.high);
        radius += 0.5 * c.width();
    }
    let radius = radius * (1.0 + 1e-9) + 2.0 * cells as f64 * UNIT_ROUNDOFF * value;
    Factor { bounded: Bounded::proved(value, radius), evaluations: s.evaluations, method: Method::Oblique }
}

/// The longer of the two cells cut in half.
fn bisect_longer(a: MappedZone, b: MappedZone) -> [(MappedZone, MappedZone); 2] {
    if a.longest() >= b.longest() { a.halves().map(|h| (h, b)) } else { b.halves().map(|h| (a, h)) }
}

/// The geometry of a pair of cells.
struct CellPairGeometry {
    /// Least and largest distance, m.
    near: f64,
    far: f64,
    /// Least and largest heights: of b over a's plane, and of a over b's where b is a plate.
    over_a: [f64; 2],
    over_b: Option<[f64; 2]>,
    /// Error of places, of heights.
    place: f64,
}

impl CellSearch {
    fn is_converged(&self, tolerance: f64) -> bool {
        self.radius + self.half * (1.0 + 1e-9) <= 0.98 * tolerance * (self.value + self.middle)
    }

    /// Integrates a pair of cells or keeps it with its enclosure.
    fn process(&mut self, a: MappedZone, b: MappedZone, depth: u32) {
        let view = self.pair_geometry(&a, &b, depth);
        let slack = ERRORS_PER_PLACE_ERROR * view.place;
        let heights = [Some(view.over_a), view.over_b];
        if heights.iter().flatten().any(|h| h[1] < -slack) {
            return;
        }
        let hidden = heights.iter().flatten().any(|h| h[1] <= slack);
        let front = heights.iter().flatten().all(|h| h[0] >= -slack);
        let supremum = self.upper_bound(&a, &b, &view, slack);
        if hidden {
            self.radius += supremum.min(coplanar_error(&a, &b, slack));
            return;
        }
        if front && let Some(rule) = self.plan(&a, &b, &view) {
            self.integrate(&a, &b, &view, &rule);
            return;
        }
        let (low, high) = self.enclosure(&a, &b, &view, front, supremum);
        self.middle += 0.5 * (low + high);
        self.half += 0.5 * (high - low);
        self.open.push(CellPair { a, b, low, high, depth });
    }

    fn pair_geometry(&self, a: &MappedZone, b: &MappedZone, depth: u32) -> CellPairGeometry {
        let place = (PLACE_ROUNDINGS + 2.0 * depth as f64) * UNIT_ROUNDOFF * self.lengths;
        let (near, far) = a.distances(b);
        let over_b = b.normal.map(|n| a.heights(n, b.corner));
        let normal = a.normal.unwrap_or(Vec3::ZERO);
        CellPairGeometry {
            near: near - ERRORS_PER_PLACE_ERROR * place,
            far: far + ERRORS_PER_PLACE_ERROR * place,
            over_a: b.heights(normal, a.corner),
            over_b,
            place,
        }
    }

    /// Power of r in the kernel.
    fn power(view: &CellPairGeometry) -> i32 {
        if view.over_b.is_some() { 4 } else { 3 }
    }

    /// Largest product of heights, heights within their rounding count as the rounding.
    fn heights(view: &CellPairGeometry, slack: f64) -> f64 {
        let top = |h: [f64; 2]| h[1].max(0.0) + slack;
        top(view.over_a) * view.over_b.map_or(1.0, top)
    }

    /// An upper bound of 𝓕.
    fn upper_bound(&self, a: &MappedZone, b: &MappedZone, view: &CellPairGeometry, slack: f64) -> f64 {
        let least = if b.normal.is_some() {
            a.measure.min(b.measure)
        } else {
            (2.0 * b.measure).min(a.measure * b.diameter())
        };
        if view.near <= 0.0 {
            return 1.000_001 * least;
        }
        let kernel = CellSearch::heights(view, slack) * view.near.powi(-CellSearch::power(view));
        1.000_001 * least.min(a.measure * b.measure * kernel / PI) * (-self.kappa * view.near).exp()
    }

    fn enclosure(
        &mut self,
        a: &MappedZone,
        b: &MappedZone,
        view: &CellPairGeometry,
        front: bool,
        supremum: f64,
    ) -> (f64, f64) {
        if !front || b.normal.is_none() || self.kappa == 0.0 {
            return (0.0, supremum);
        }
        let [first, second] =
            [a, b].map(|z| Contour { corners: z.corners(), displaced: ERRORS_PER_PLACE_ERROR * view.place });
        let f = contour::sum(&first, &second, 0.01 * self.tolerance * supremum);
        self.evaluations += f.evaluations;
        let low = (f.value - f.radius).max(0.0) * (-self.kappa * view.far).exp() * (1.0 - 1e-14);
        let high = (f.value + f.radius) * (-self.kappa * view.near.max(0.0)).exp() * (1.0 + 1e-14);
        (low.min(supremum), high.min(supremum).max(low.min(supremum)))
    }

    /// Points in each direction of a and of b, and the error they leave; None where the cells are to be cut.
    fn plan(&self, a: &MappedZone, b: &MappedZone, view: &CellPairGeometry) -> Option<CellRule> {
        if view.near <= 0.0 || ERRORS_PER_PLACE_ERROR * view.place > 1e-3 * view.near {
            return None;
        }
        let middle = (a.centre() - b.centre()).length();
        let mean = |h: [f64; 2]| (0.5 * (h[0] + h[1])).max(0.0);
        let rough = a.measure * b.measure / PI
            * mean(view.over_a)
            * view.over_b.map_or(1.0, mean)
            * middle.powi(-CellSearch::power(view))
            * (-self.kappa * middle).exp();
        let (along_a, along_b) = (a.directions(), b.directions());
        let budget = CELL_ERROR_SHARE * self.tolerance * rough / (along_a.len() + along_b.len()) as f64;
        let mut rule = CellRule { points: [Vec::with_capacity(2), Vec::with_capacity(3)], error: 0.0 };
        for (k, directions) in [along_a, along_b].into_iter().enumerate() {
            // A motion of a changes its height over b, a motion of b its height over a; the other height stays.
            let heights = if k == 0 {
                CellHeights { moving: view.over_b, resting: Some(view.over_a), normal: b.normal }
            } else {
                CellHeights { moving: Some(view.over_a), resting: view.over_b, normal: a.normal }
            };
            let measures = a.measure * b.measure / PI;
            for d in &directions {
                let (n, error) = self.points_along(view, d, &heights, measures, budget)?;
                rule.points[k].push(n);
                rule.error += error;
            }
        }
        let cost: u64 = rule.points.iter().flatten().map(|n| *n as u64).product();
        (cost <= MAX_RULE_EVALUATIONS).then_some(rule)
    }

    /// The least number of points along direction `d` of one cell for an error within `budget`, and that error. `measures` is the product of both
    /// measures over π.
    fn points_along(
        &self,
        view: &CellPairGeometry,
        d: &ParameterDirection,
        heights: &CellHeights,
        measures: f64,
        budget: f64,
    ) -> Option<(usize, f64)> {
        let slack = ERRORS_PER_PLACE_ERROR * view.place;
        let top = |h: Option<[f64; 2]>| h.map_or(1.0, |h| h[1] + slack);
        let change = heights.normal.map_or(0.0, |n| d.change(n));
        let front = measures * top(heights.resting);
        let q = CellSearch::power(view) as f64;
        let mut best: Option<(usize, f64)> = None;
        for f in ELLIPSE_FRACTIONS {
            let width = f * view.near / d.length;
            let long = (width * width + 0.25).sqrt();
            let Some(square) = least_square(view.near, d.length, long, width) else { continue };
            let rho = 2.0 * (long + width);
            let height =
                if heights.moving.is_some() { top(heights.moving) + change * (long - 0.5) } else { 1.0 };
            let supremum =
                front * height * d.weight(long) * square.powf(-0.5 * q) * (-self.kappa * square.sqrt()).exp();
            let n = gauss_legendre::points_for(rho, supremum, budget);
            if n <= MAX_POINTS_PER_DIRECTION && best.is_none_or(|(m, _)| n < m) {
                best = Some((n, 1.000_001 * gauss_legendre::error_bound(n, rho, supremum)));
            }
        }
        best
    }

    fn integrate(&mut self, a: &MappedZone, b: &MappedZone, view: &CellPairGeometry, rule: &CellRule) {
        let sum = simd::run(KernelSumWork {
            a: a.points(&rule.points[0]),
            b: b.points(&rule.points[1]),
            normals: [a.normal.unwrap_or(Vec3::ZERO), b.normal.unwrap_or(Vec3::ZERO)],
            corners: [a.corner, b.corner],
            two: b.normal.is_some(),
            kappa: self.kappa,
        });
        let value = sum * a.measure * b.measure / PI;
        let counts: Vec<u64> = rule.points.iter().map(|p| p.iter().map(|n| *n as u64).product()).collect();
        let q = CellSearch::power(view) as f64;
        let slack = ERRORS_PER_PLACE_ERROR * view.place;
        let relative = (q / view.near + self.kappa) * slack
            + (PRODUCT_ROUNDINGS + (counts[0] + counts[1]) as f64 + 8.0 * (1.0 + self.kappa * view.far))
                * UNIT_ROUNDOFF;
        let ([_, top_a], top_b) = (view.over_a, view.over_b.map(|h| h[1]));
        let heights = top_b.map_or(slack, |top_b| slack * (top_a + top_b + slack));
        let moved =
            a.measure * b.measure / PI * heights * view.near.powf(-q) * (-self.kappa * view.near).exp();
        self.value += value;
        self.radius += rule.error + 1.01 * (value.abs() * relative + moved);
        self.evaluations += counts[0] * counts[1];
    }
}

/// Bound of the rounding error where one zone lies in the plane of the other: two plates as in [`super::plate_pair`]; of a box, a slab as thick
/// as the
/// heights' error, seen from half of all directions.
fn coplanar_error(a: &MappedZone, b: &MappedZone, slack: f64) -> f64 {
    if b.normal.is_some() {
        COPLANAR_BOUND * 2.0 * slack * 2.0 * (a.reach() + b.reach())
    } else {
        2.0 * 2.0 * slack * b.diameter() * b.diameter()
    }
}

/// R of the header; None where it is not positive.
fn least_square(near: f64, length: f64, long: f64, width: f64) -> Option<f64> {
    if near < (long - 0.5) * length {
        return None;
    }
    let beside = near * near - (width * length).powi(2);
    let at = |c: f64| (near - (long * c - 0.5) * length).powi(2) - (width * length).powi(2) * (1.0 - c * c);
    let c = long * (near + 0.5 * length) / ((long * long + width * width) * length);
    let square = (1.0 - 1e-12) * beside.min(at(c.clamp(0.5 / long, 1.0)));
    (square > 0.0).then_some(square)
}

/// Heights of two cells, of which one moves, over the planes of each other; `None` for a box, which has no plane.
struct CellHeights {
    /// Bounds of the height of the moving cell over the plane of the resting cell, m.
    moving: Option<[f64; 2]>,
    /// Bounds of the height of the resting cell over the plane of the moving cell, m.
    resting: Option<[f64; 2]>,
    /// Normal of the resting cell.
    normal: Option<Vec3>,
}

/// Points along the directions of both cells, and the error that they leave.
struct CellRule {
    points: [Vec<usize>; 2],
    error: f64,
}

/// The double sum of the kernel over two sets of points.
struct KernelSumWork {
    a: Vec<(Vec3, f64)>,
    b: Vec<(Vec3, f64)>,
    normals: [Vec3; 2],
    corners: [Vec3; 2],
    two: bool,
    kappa: f64,
}

const LANES: usize = simd::LANES;

impl simd::SimdKernel for KernelSumWork {
    type Output = f64;
    #[inline(always)]
    fn evaluate(self) -> f64 {
        // Lanes of b: x, y, z, weight times the height over a's plane.
        let mut lanes = vec![[[0.0; LANES]; 4]; self.b.len().div_ceil(LANES)];
        for (k, (p, w)) in self.b.iter().enumerate() {
            let h = self.normals[0].dot(*p - self.corners[0]);
            let cell = &mut lanes[k / LANES];
            for (row, x) in cell.iter_mut().zip([p.x, p.y, p.z, w * h]) {
                row[k % LANES] = x;
            }
        }
        // Lanes without a point: the last point's place, no weight.
        if let (Some(last), Some((p, _))) = (lanes.last_mut(), self.b.last()) {
            for l in (self.b.len() - 1) % LANES + 1..LANES {
                (last[0][l], last[1][l], last[2][l]) = (p.x, p.y, p.z);
            }
        }
        let mut total = 0.0;
        for (x, w) in &self.a {
            let front = if self.two { w * self.normals[1].dot(*x - self.corners[1]) } else { *w };
            let mut sums = [0.0; LANES];
            for cell in &lanes {
                let mut r2 = [0.0; LANES];
                for l in 0..LANES {
                    let (dx, dy, dz) = (cell[0][l] - x.x, cell[1][l] - x.y, cell[2][l] - x.z);
                    r2[l] = dx * dx + dy * dy + dz * dz;
                }
                let mut f = [0.0; LANES];
                for l in 0..LANES {
                    let q = if self.two { r2[l] * r2[l] } else { r2[l] * r2[l].sqrt() };
                    f[l] = cell[3][l] / q;
                }
                if self.kappa > 0.0 {
                    let mut x = [0.0; LANES];
                    for l in 0..LANES {
                        x[l] = -self.kappa * r2[l].sqrt();
                    }
                    let e = simd::exp(x);
                    for l in 0..LANES {
                        f[l] *= e[l];
                    }
                }
                for l in 0..LANES {
                    sums[l] += f[l];
                }
            }
            total += front
                * (((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7])));
        }
        total
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_constants_equal_their_counts() {
        // A place: difference of origins 1, edge and node 2, product 1, two sums 2, weights of cuts 2, each in three components of lengths that
        // add up to
        // twice L at most.
        assert_eq!(PLACE_ROUNDINGS, 2.0 * (1.0 + 2.0 + 1.0 + 2.0 + 2.0));
        // Two places, and as much again for the difference and its length or its product with a normal.
        assert_eq!(ERRORS_PER_PLACE_ERROR, 2.0 * (1.0 + 1.0));
        // r² 6, its powers 8, the quotient 2, exponential 4, weights of five rules 20, their products 10, the front 4, sums of lanes 8 and π 2.
        assert_eq!(PRODUCT_ROUNDINGS, 6.0 + 8.0 + 2.0 + 4.0 + 20.0 + 10.0 + 4.0 + 8.0 + 2.0);
    }

    #[test]
    fn least_square_bounds_squared_distance_on_ellipse() {
        for (near, length, share) in [(1.0, 1.0, 0.9), (0.3, 2.0, 0.5), (5.0, 1.0, 0.95), (0.01, 1.0, 0.3)] {
            let width: f64 = share * near / length;
            let long = (width * width + 0.25f64).sqrt();
            let Some(square) = least_square(near, length, long, width) else { continue };
            // The edge along x in front of the origin at its nearest, in every direction.
            for k in 0..200 {
                let phi = k as f64 * 0.01 * PI;
                let (x, y) = (0.5 + long * phi.cos(), width * phi.sin());
                for turn in 0..40 {
                    let a = turn as f64 * 0.025 * PI;
                    // t(s) = t₀ + s·length·(cos a, sin a), its least distance from 0 over [0, 1] being `near`.
                    let foot = if a.cos() >= 0.0 { near } else { near - length * a.cos() };
                    let (tx, ty) = (foot + x * length * a.cos(), x * length * a.sin());
                    let real = tx * tx + ty * ty - (y * length).powi(2);
                    assert!(
                        square <= real * (1.0 + 1e-9) + 1e-12,
                        "{near} {length} {phi} {a}: {square} {real}"
                    );
                }
            }
        }
    }
}
