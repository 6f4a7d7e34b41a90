//! Plates against plates in a medium, and plates against boxes, in any position: tensor Gauss rules on cells, proved.
//!
//! ```text
//! two plates       𝓕 = (1/π) ∬ e^{−κr} h_a(y) h_b(x) / r⁴ dA dA        h_a(y) the height of y over a's plane
//! plate and box    𝓕 = (1/π) ∬ e^{−κr} h_a(y) / r³ dA dV               r = |y − x|
//! ```
//!
//! Both zones are images of cubes (a triangle's with the Jacobian 1 − u, [`super::body`]). A pair of cells that is far enough apart takes
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
//! With R the smaller of the two, positive, r is analytic, |r^{−q}| ≤ R^{−q/2} and |e^{−κr}| ≤ e^{−κ√R}; a height, at most H on the cell and changing by
//! η along the edge, is at most H + η(A − ½). The rule's error follows ([`zonal_math::gauss::error_bound`]); those of the directions add,
//! the weights being positive.
//!
//! **Cells that are not integrated** have an enclosure. Two plates: e^{−κ r_max} 𝓕₀ … e^{−κD} 𝓕₀ with 𝓕₀ by the contour, where both are in front
//! of each other. Else from zero to the least of measure · sup of the kernel and what geometry allows: 𝓕 ≤ the smaller area, 𝓕 ≤ 2V (half of all
//! directions see the plate), 𝓕 ≤ A · diameter of the box (no chord is longer).
//!
//! **Rounding**, ε = 2⁻⁵³: places err by η = ([`PLACE`] + 2 depth) ε L, L the lengths of the pair, so r by 4η/D relative, heights by 4η; the rest is
//! products and sums, κr in the exponent.

use super::body::{Body, Direction};
use super::contour::{self, Contour};
use super::plates::HIDDEN;
use crate::{Demand, Factor, Method};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;
use zonal_math::{Bounded, Vec3, gauss, simd};
use zonal_scene::Plate;

/// 2⁻⁵³.
const EPS: f64 = 0.5 * f64::EPSILON;
/// Roundings of a place, relative to the pair's lengths, before any cut: differences, edges, products, sums.
const PLACE: f64 = 16.0; // bound
/// Errors of r and of a height, in errors of a place: two places, and the operations between.
const DISTANCE: f64 = 4.0; // bound
/// Roundings of products and sums, without the points of the sums.
const PRODUCTS: f64 = 64.0; // bound
/// Points along one direction at most, and of a whole rule: beyond, cells are cut.
const MOST: usize = 14;
const MOST_EVALUATIONS: u64 = 60_000;
/// Cells of one pair at most.
const MOST_CELLS: usize = 20_000;
/// The share of the tolerance that each cell's rule may take of its own value.
const SHARE: f64 = 0.4;
/// Widths of the ellipse that are tried, relative to the widest.
const FRACTIONS: [f64; 10] = [0.93, 0.82, 0.68, 0.52, 0.37, 0.25, 0.15, 0.08, 0.04, 0.015];

/// 𝓕 of two plates in a medium, m².
pub(super) fn plate_plate(a: &Plate, b: &Plate, kappa: f64, demand: Demand) -> Factor {
    let d = b.origin - a.origin;
    run(Body::plate(a, Vec3::ZERO), Body::plate(b, d), kappa, demand)
}

/// 𝓕 = (1/π) ∬ e^{−κr} cosθ/r² dA dV of the front of a plate and the box from `lo` to `hi`, m³; `kappa` in 1/m. Grade proved.
///
/// The radius is at most tolerance · 𝓕 where the budget allows: boxes that touch the plate or reach behind its plane take many cells and end
/// with what they have.
///
/// # Panics
/// On a plate without area, a box without volume, corners that are not finite, a `kappa` that is negative or not finite.
pub fn plate_cuboid(p: &Plate, lo: Vec3, hi: Vec3, kappa: f64, demand: Demand) -> Factor {
    super::plates::check(p);
    let edge = hi - lo;
    assert!(
        lo.is_finite() && hi.is_finite() && edge.array().iter().all(|e| *e > 0.0),
        "not a box: {lo:?} {hi:?}"
    );
    assert!(kappa >= 0.0 && kappa.is_finite(), "extinction {kappa} 1/m");
    run(Body::plate(p, Vec3::ZERO), Body::cuboid(lo - p.origin, edge), kappa, demand)
}

/// A pair of cells with an enclosure of its 𝓕.
#[derive(Clone, Debug)]
struct Cells {
    a: Body,
    b: Body,
    low: f64,
    high: f64,
    depth: u32,
}

impl Cells {
    fn width(&self) -> f64 {
        self.high - self.low
    }
}

impl PartialEq for Cells {
    fn eq(&self, o: &Cells) -> bool {
        self.cmp(o) == Ordering::Equal
    }
}
impl Eq for Cells {}
impl PartialOrd for Cells {
    fn partial_cmp(&self, o: &Cells) -> Option<Ordering> {
        Some(self.cmp(o))
    }
}
impl Ord for Cells {
    fn cmp(&self, o: &Cells) -> Ordering {
        let corner = |c: &Cells| [c.a.corner.array(), c.b.corner.array()];
        let places = || {
            let (p, q) = (corner(self), corner(o));
            p.as_flattened().iter().zip(q.as_flattened()).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne())
        };
        self.width().total_cmp(&o.width()).then_with(|| places().unwrap_or(Ordering::Equal))
    }
}

/// What the search has found.
struct Search {
    kappa: f64,
    tolerance: f64,
    /// L, m.
    lengths: f64,
    value: f64,
    radius: f64,
    evaluations: u64,
    open: BinaryHeap<Cells>,
    /// Sums over the open cells.
    middle: f64,
    half: f64,
}

fn run(a: Body, b: Body, kappa: f64, demand: Demand) -> Factor {
    let lengths = (b.corner - a.corner).length() + a.reach() + b.reach();
    let mut s = Search {
        kappa,
        tolerance: demand.tolerance.max(1e-12),
        lengths,
        value: 0.0,
        radius: 0.0,
        evaluations: 0,
        open: BinaryHeap::new(),
        middle: 0.0,
        half: 0.0,
    };
    s.take(a, b, 0);
    let mut cells = 1;
    while !s.done(demand.tolerance)
        && s.evaluations < demand.budget
        && cells < MOST_CELLS
        && let Some(c) = s.open.pop()
    {
        s.middle -= 0.5 * (c.low + c.high);
        s.half -= 0.5 * c.width();
        for (a, b) in halves(c.a, c.b) {
            s.take(a, b, c.depth + 1);
        }
        cells += 1;
    }
    // The running sums have rounded: once more, afresh.
    let (mut value, mut radius) = (s.value, s.radius);
    for c in s.open.into_sorted_vec() {
        value += 0.5 * (c.low + c.high);
        radius += 0.5 * c.width();
    }
    let radius = radius * (1.0 + 1e-9) + 2.0 * cells as f64 * EPS * value;
    Factor { bounded: Bounded::proved(value, radius), evaluations: s.evaluations, method: Method::Oblique }
}

/// The longer of the two cells cut in half.
fn halves(a: Body, b: Body) -> [(Body, Body); 2] {
    if a.longest() >= b.longest() { a.halves().map(|h| (h, b)) } else { b.halves().map(|h| (a, h)) }
}

/// What is known of a pair of cells.
struct View {
    /// Least and largest distance, m.
    near: f64,
    far: f64,
    /// Least and largest heights: of b over a's plane, and of a over b's where b is a plate.
    over_a: [f64; 2],
    over_b: Option<[f64; 2]>,
    /// Error of places, of heights.
    place: f64,
}

impl Search {
    fn done(&self, tolerance: f64) -> bool {
        self.radius + self.half * (1.0 + 1e-9) <= 0.98 * tolerance * (self.value + self.middle)
    }

    /// Integrates a pair of cells or keeps it with its enclosure.
    fn take(&mut self, a: Body, b: Body, depth: u32) {
        let view = self.view(&a, &b, depth);
        let slack = DISTANCE * view.place;
        let heights = [Some(view.over_a), view.over_b];
        if heights.iter().flatten().any(|h| h[1] < -slack) {
            return;
        }
        let hidden = heights.iter().flatten().any(|h| h[1] <= slack);
        let front = heights.iter().flatten().all(|h| h[0] >= -slack);
        let supremum = self.supremum(&a, &b, &view, slack);
        if hidden {
            self.radius += supremum.min(left_open(&a, &b, slack));
            return;
        }
        if front && let Some(rule) = self.plan(&a, &b, &view) {
            self.integrate(&a, &b, &view, &rule);
            return;
        }
        let (low, high) = self.enclosure(&a, &b, &view, front, supremum);
        self.middle += 0.5 * (low + high);
        self.half += 0.5 * (high - low);
        self.open.push(Cells { a, b, low, high, depth });
    }

    fn view(&self, a: &Body, b: &Body, depth: u32) -> View {
        let place = (PLACE + 2.0 * depth as f64) * EPS * self.lengths;
        let (near, far) = a.distances(b);
        let over_b = b.normal.map(|n| a.heights(n, b.corner));
        let normal = a.normal.unwrap_or(Vec3::ZERO);
        View {
            near: near - DISTANCE * place,
            far: far + DISTANCE * place,
            over_a: b.heights(normal, a.corner),
            over_b,
            place,
        }
    }

    /// Power of r in the kernel.
    fn power(view: &View) -> i32 {
        if view.over_b.is_some() { 4 } else { 3 }
    }

    /// Largest product of heights, those within their rounding counted as that.
    fn heights(view: &View, slack: f64) -> f64 {
        let top = |h: [f64; 2]| h[1].max(0.0) + slack;
        top(view.over_a) * view.over_b.map_or(1.0, top)
    }

    /// An upper bound of 𝓕.
    fn supremum(&self, a: &Body, b: &Body, view: &View, slack: f64) -> f64 {
        let least = if b.normal.is_some() {
            a.measure.min(b.measure)
        } else {
            (2.0 * b.measure).min(a.measure * b.diameter())
        };
        if view.near <= 0.0 {
            return 1.000_001 * least;
        }
        let kernel = Search::heights(view, slack) * view.near.powi(-Search::power(view));
        1.000_001 * least.min(a.measure * b.measure * kernel / PI) * (-self.kappa * view.near).exp()
    }

    fn enclosure(&mut self, a: &Body, b: &Body, view: &View, front: bool, supremum: f64) -> (f64, f64) {
        if !front || b.normal.is_none() || self.kappa == 0.0 {
            return (0.0, supremum);
        }
        let [first, second] =
            [a, b].map(|z| Contour { corners: z.corners(), displaced: DISTANCE * view.place });
        let f = contour::sum(&first, &second, 0.01 * self.tolerance * supremum);
        self.evaluations += f.evaluations;
        let low = (f.value - f.radius).max(0.0) * (-self.kappa * view.far).exp() * (1.0 - 1e-14);
        let high = (f.value + f.radius) * (-self.kappa * view.near.max(0.0)).exp() * (1.0 + 1e-14);
        (low.min(supremum), high.min(supremum).max(low.min(supremum)))
    }

    /// Points in each direction of a and of b, and the error they leave; None where the cells are to be cut.
    fn plan(&self, a: &Body, b: &Body, view: &View) -> Option<Rule> {
        if view.near <= 0.0 || DISTANCE * view.place > 1e-3 * view.near {
            return None;
        }
        let middle = (a.centre() - b.centre()).length();
        let mean = |h: [f64; 2]| (0.5 * (h[0] + h[1])).max(0.0);
        let rough = a.measure * b.measure / PI
            * mean(view.over_a)
            * view.over_b.map_or(1.0, mean)
            * middle.powi(-Search::power(view))
            * (-self.kappa * middle).exp();
        let (along_a, along_b) = (a.directions(), b.directions());
        let budget = SHARE * self.tolerance * rough / (along_a.len() + along_b.len()) as f64;
        let mut rule = Rule { points: [Vec::with_capacity(2), Vec::with_capacity(3)], error: 0.0 };
        for (k, directions) in [along_a, along_b].into_iter().enumerate() {
            for d in &directions {
                let (n, error) = self.points(a, b, view, k, d, budget)?;
                rule.points[k].push(n);
                rule.error += error;
            }
        }
        let cost: u64 = rule.points.iter().flatten().map(|n| *n as u64).product();
        (cost <= MOST_EVALUATIONS).then_some(rule)
    }

    /// The least number of points along one direction of cell `side` (0: a, 1: b) for an error within `budget`.
    fn points(
        &self,
        a: &Body,
        b: &Body,
        view: &View,
        side: usize,
        d: &Direction,
        budget: f64,
    ) -> Option<(usize, f64)> {
        let slack = DISTANCE * view.place;
        // Moving a changes its height over b; moving b changes its height over a. The other height stays.
        let (moving, normal) =
            if side == 0 { (view.over_b, b.normal) } else { (Some(view.over_a), a.normal) };
        let resting = if side == 0 { Some(view.over_a) } else { view.over_b };
        let top = |h: Option<[f64; 2]>| h.map_or(1.0, |h| h[1] + slack);
        let change = normal.map_or(0.0, |n| d.change(n));
        let front = a.measure * b.measure / PI * top(resting);
        let q = Search::power(view) as f64;
        let mut best: Option<(usize, f64)> = None;
        for f in FRACTIONS {
            let width = f * view.near / d.length;
            let long = (width * width + 0.25).sqrt();
            let Some(square) = least_square(view.near, d.length, long, width) else { continue };
            let rho = 2.0 * (long + width);
            let height = if moving.is_some() { top(moving) + change * (long - 0.5) } else { 1.0 };
            let supremum =
                front * height * d.weight(long) * square.powf(-0.5 * q) * (-self.kappa * square.sqrt()).exp();
            let n = gauss::points_for(rho, supremum, budget);
            if n <= MOST && best.is_none_or(|(m, _)| n < m) {
                best = Some((n, 1.000_001 * gauss::error_bound(n, rho, supremum)));
            }
        }
        best
    }

    fn integrate(&mut self, a: &Body, b: &Body, view: &View, rule: &Rule) {
        let sum = simd::run(Sum {
            a: a.points(&rule.points[0]),
            b: b.points(&rule.points[1]),
            normals: [a.normal.unwrap_or(Vec3::ZERO), b.normal.unwrap_or(Vec3::ZERO)],
            corners: [a.corner, b.corner],
            two: b.normal.is_some(),
            kappa: self.kappa,
        });
        let value = sum * a.measure * b.measure / PI;
        let counts: Vec<u64> = rule.points.iter().map(|p| p.iter().map(|n| *n as u64).product()).collect();
        let q = Search::power(view) as f64;
        let slack = DISTANCE * view.place;
        let relative = (q / view.near + self.kappa) * slack
            + (PRODUCTS + (counts[0] + counts[1]) as f64 + 8.0 * (1.0 + self.kappa * view.far)) * EPS;
        let ([_, top_a], top_b) = (view.over_a, view.over_b.map(|h| h[1]));
        let heights = top_b.map_or(slack, |top_b| slack * (top_a + top_b + slack));
        let moved =
            a.measure * b.measure / PI * heights * view.near.powf(-q) * (-self.kappa * view.near).exp();
        self.value += value;
        self.radius += rule.error + 1.01 * (value.abs() * relative + moved);
        self.evaluations += counts[0] * counts[1];
    }
}

/// Bound of what rounding leaves open where one zone lies in the other's plane: two plates as in [`super::plates`]; of a box, a slab as thick as the
/// heights' error, seen from half of all directions.
fn left_open(a: &Body, b: &Body, slack: f64) -> f64 {
    if b.normal.is_some() {
        HIDDEN * 2.0 * slack * 2.0 * (a.reach() + b.reach())
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

/// Points along the directions of both cells, and the error that they leave.
struct Rule {
    points: [Vec<usize>; 2],
    error: f64,
}

/// The double sum of the kernel over two sets of points.
struct Sum {
    a: Vec<(Vec3, f64)>,
    b: Vec<(Vec3, f64)>,
    normals: [Vec3; 2],
    corners: [Vec3; 2],
    two: bool,
    kappa: f64,
}

const LANES: usize = simd::LANES;

impl simd::Work for Sum {
    type Output = f64;
    #[inline(always)]
    fn go(self) -> f64 {
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
    fn the_constants_are_their_counts() {
        // A place: difference of origins 1, edge and node 2, product 1, two sums 2, weights of cuts 2, each in three components of lengths that add up to
        // twice L at most.
        assert_eq!(PLACE, 2.0 * (1.0 + 2.0 + 1.0 + 2.0 + 2.0));
        // Two places, and as much again for the difference and its length or its product with a normal.
        assert_eq!(DISTANCE, 2.0 * (1.0 + 1.0));
        // r² 6, its powers 8, the quotient 2, exponential 4, weights of five rules 20, their products 10, the front 4, sums of lanes 8 and π 2.
        assert_eq!(PRODUCTS, 6.0 + 8.0 + 2.0 + 4.0 + 20.0 + 10.0 + 4.0 + 8.0 + 2.0);
    }

    #[test]
    fn the_square_stays_below_every_point_of_the_ellipse() {
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
