//! Exchange of plates and cuboids in any position, without a medium: the geometric factor and the moments of its distance.
//!
//! One of the two integrals is done in closed form ([`crate::solid_angle`]), so the other has a **bounded** integrand even where
//! the zones touch:
//!
//! plate–plate: 𝓕 = (1/π) ∫_a ω⊥(x; b) dA, ω⊥ the projected solid angle of b on a at x (at most π);
//! plate–cuboid: 𝓕 = (1/π) ∫_V ω(x; plate) dV, ω the solid angle of the plate's front (at most 2π).
//!
//! The outer integral runs over the smaller plate or over the cuboid, by Gauss points on pieces that are divided until two rules
//! agree; the error is **estimated**. Far pairs take the value at the centres.
//!
//! **Attenuation** enters by the first three moments of the distance under the kernel: ⟨e^{−κr}⟩ by the two-point Gauss rule with
//! these moments. Its nodes lie in the range of the distances, so that it stays between 0 and 1 for every κ.

use crate::aligned::DistanceCumulants;
use crate::solid_angle::{projected_solid_angle, solid_angle};
use std::f64::consts::PI;
use zonal_math::{Bounded, Vec3, gauss_legendre, vec3};
use zonal_scene::{Plate, PlateKind, Sides};

/// A geometric factor with the mean and the variance of the distance under its kernel.
#[derive(Clone, Copy, Debug)]
pub struct DistanceMoments {
    /// 𝓕 without attenuation: m² for plate–plate, m³ for plate–cuboid, m⁴ for cuboid–cuboid.
    pub factor: Bounded,
    /// Mean distance r̄, m.
    pub mean_distance: f64,
    /// Variance s² of the distance, m².
    pub variance: f64,
    /// Third cumulant of the distance, m³.
    pub third_cumulant: f64,
}

impl DistanceMoments {
    /// No exchange.
    pub const ZERO: DistanceMoments =
        DistanceMoments { factor: Bounded::ZERO, mean_distance: 0.0, variance: 0.0, third_cumulant: 0.0 };

    /// Moments from the sums of the kernel times 1, r, r², r³, and the error of the first.
    pub(crate) fn from_power_sums([f, fr, frr, frrr]: [f64; 4], error: f64) -> DistanceMoments {
        if f <= 0.0 {
            return DistanceMoments { factor: Bounded::estimated(0.0, error), ..DistanceMoments::ZERO };
        }
        let [m, m2, m3] = [fr, frr, frrr].map(|x| x / f);
        DistanceMoments {
            factor: Bounded::estimated(f, error),
            mean_distance: m,
            variance: (m2 - m * m).max(0.0),
            third_cumulant: m3 - m * (3.0 * m2 - 2.0 * m * m),
        }
    }

    /// ⟨e^{−κr}⟩, `kappa` in 1/m, between 0 and 1: nodes r̄ + s(γ/2 ± √(1 + γ²/4)) with the skewness γ.
    pub fn transmittance(&self, kappa: f64) -> f64 {
        let s = self.variance.max(0.0).sqrt();
        if s <= 1e-6 * self.mean_distance {
            return (-kappa * self.mean_distance).exp();
        }
        let half = 0.5 * self.third_cumulant / (s * s * s);
        let root = (1.0 + half * half).sqrt();
        // (half − root)(half + root) = −1; the weights are inverse to the distances from the mean.
        let (low, high) =
            if half > 0.0 { (-1.0 / (half + root), half + root) } else { (half - root, 1.0 / (root - half)) };
        let share = high / (high - low);
        let at = |x: f64| (-kappa * (self.mean_distance + s * x).max(0.0)).exp();
        share * at(low) + (1.0 - share) * at(high)
    }

    /// The factor and moments of the union of two disjoint parts.
    pub fn union(&self, other: &DistanceMoments) -> DistanceMoments {
        let raw = |m: &DistanceMoments| {
            let (f, mean) = (m.factor.value, m.mean_distance);
            let second = m.variance + mean * mean;
            [f, f * mean, f * second, f * (m.third_cumulant + mean * (3.0 * second - 2.0 * mean * mean))]
        };
        let (a, b) = (raw(self), raw(other));
        let factor = self.factor + other.factor;
        DistanceMoments {
            factor,
            ..DistanceMoments::from_power_sums(std::array::from_fn(|k| a[k] + b[k]), 0.0)
        }
    }
}

impl From<DistanceCumulants> for DistanceMoments {
    fn from(c: DistanceCumulants) -> DistanceMoments {
        DistanceMoments {
            factor: c.factor,
            mean_distance: c.mean_distance,
            variance: c.variance,
            third_cumulant: c.third_cumulant,
        }
    }
}

/// Both sides of a pane, the front of any other plate.
pub(crate) fn sides_of_pane(pane: Option<usize>) -> Sides {
    if pane.is_some() { Sides::Both } else { Sides::Front }
}

/// The cosine of a plate that exchanges by `sides`.
fn visible_cosine(sides: Sides, c: f64) -> f64 {
    if sides == Sides::Both { c.abs() } else { c.max(0.0) }
}

/// Running sums of the kernel and of its moments of distance.
#[derive(Clone, Copy, Default)]
struct PowerSums {
    /// Σ f, Σ f r, Σ f r², Σ f r³ of the kernel f.
    f: f64,
    fr: f64,
    frr: f64,
    frrr: f64,
    /// Estimated error of Σ f.
    error: f64,
}

impl PowerSums {
    /// Adds kernel f at distances of about r that scatter by the variance `all`, of which `along` lies along the line of sight.
    fn add_spread(&mut self, f: f64, r: f64, all: f64, along: f64) {
        self.f += f;
        self.fr += f * (r * r + 0.5 * (all - along) - 3.0 * along).max(0.25 * r * r) / r.max(1e-300);
        self.frr += f * (r * r + all - 6.0 * along).max(0.0625 * r * r);
        self.frrr += f * r * (r * r + 1.5 * (all + along) - 9.0 * along).max(0.015625 * r * r);
    }
    fn merge(&mut self, o: PowerSums) {
        self.f += o.f;
        self.fr += o.fr;
        self.frr += o.frr;
        self.frrr += o.frrr;
        self.error += o.error;
    }
    fn finish(self) -> DistanceMoments {
        let sums = [self.f, self.fr, self.frr, self.frrr].map(|x| x / PI);
        DistanceMoments::from_power_sums(sums, self.error / PI)
    }
}

/// Subdivisions of a piece, at most.
const MAX_SUBDIVISIONS: u32 = 5;

/// True where the distance of the centres, relative to the sizes, makes the error of the point formula less than `tolerance`.
///
/// The first neglected term of the kernel's expansion about the centres is at most ~2 (s_a² + s_b²)/(12 d²) · 3.
fn is_far(d2: f64, size_a: f64, size_b: f64, tolerance: f64) -> bool {
    d2 * tolerance > 0.5 * (size_a * size_a + size_b * size_b)
}

/// Evaluates `f` at an n×n Gauss rule on the plate: (point, area weight).
fn plate_points(p: &Plate, n: usize, mut f: impl FnMut(Vec3, f64)) {
    let (rule, area) = (gauss_legendre::rule(n), p.area());
    for (x, wx) in rule.nodes.iter().zip(&rule.weights) {
        for (y, wy) in rule.nodes.iter().zip(&rule.weights) {
            match p.kind {
                PlateKind::Parallelogram => f(p.at(*x, *y), wx * wy * area),
                // Collapsed square: u = x, v = (1 − x) y with Jacobian 1 − x, the triangle's area being a half.
                PlateKind::Triangle => f(p.at(*x, (1.0 - x) * y), wx * wy * 2.0 * (1.0 - x) * area),
            }
        }
    }
}

/// Adds the kernel of `q` seen from `at` with its moments of distance: a piece wider than its distance is divided into quarters first, and the
/// remaining extent enters by the covariance C of its points, along (n·Cn) and across the line of sight. The kernel falls like
/// h/r³ within a piece, which draws the mean distance nearer by 3 n·Cn/r.
fn add_plate_moments(
    q: &Plate,
    at: Vec3,
    weight: f64,
    depth: u32,
    kernel: &impl Fn(&Plate) -> f64,
    s: &mut PowerSums,
) {
    let d = q.centre() - at;
    let r2 = d.length2();
    let (p11, p22, p12) = (q.e1.length2(), q.e2.length2(), q.e1.dot(q.e2));
    if depth > 0 && r2 < p11 + p22 {
        q.quarters().iter().for_each(|p| add_plate_moments(p, at, weight, depth - 1, kernel, s));
        return;
    }
    let (x, y) = (q.e1.dot(d), q.e2.dot(d));
    let (all, along) = match q.kind {
        PlateKind::Parallelogram => ((p11 + p22) / 12.0, (x * x + y * y) / 12.0),
        PlateKind::Triangle => ((p11 + p22 - p12) / 18.0, (x * x + y * y - x * y) / 18.0),
    };
    s.add_spread(kernel(q) * weight, r2.sqrt(), all, if r2 > 0.0 { along / r2 } else { all });
}

/// Subdivisions into quarters in [`add_plate_moments`].
const MAX_INNER_SUBDIVISIONS: u32 = 4;

fn agree_within(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * b.abs()
}

/// 𝓕 of two plates, fronts facing, m². `sides` of a and of b.
pub fn plate_plate(a: &Plate, b: &Plate, sides: [Sides; 2], tolerance: f64) -> DistanceMoments {
    let (sa, sb) = (a.diameter(), b.diameter());
    let d = b.centre() - a.centre();
    if is_far(d.length2(), sa, sb, tolerance) {
        return far_plates(a, b, sides, d);
    }
    let (outer, inner, sides) = if sa <= sb { (a, b, sides) } else { (b, a, [sides[1], sides[0]]) };
    let floor = tolerance * 1e-2 * outer.area();
    let mut sum = PowerSums::default();
    for piece in parts_beside_plane(outer, inner, sides[1]) {
        sum.merge(outer_plate(&piece, inner, sides, tolerance, floor, 0));
    }
    sum.finish()
}

/// The parts of `a` in front of the plane of `b` and, for both sides, behind it.
fn parts_beside_plane(a: &Plate, b: &Plate, sides: Sides) -> Vec<Plate> {
    let (corners, n) = a.corners();
    let (normal, eps) = (b.normal(), 1e-12 * (a.diameter() + b.diameter()));
    let h: Vec<f64> = corners[..n].iter().map(|c| normal.dot(*c - b.origin)).collect();
    let both = sides == Sides::Both;
    let behind = h.iter().any(|x| *x < -eps);
    if !behind || (both && !h.iter().any(|x| *x > eps)) {
        return vec![*a];
    }
    let mut out = Vec::new();
    for sign in if both { &[1.0, -1.0][..] } else { &[1.0][..] } {
        let mut polygon = Vec::with_capacity(5);
        for i in 0..n {
            let j = (i + 1) % n;
            let (p, q) = (sign * h[i], sign * h[j]);
            if p >= 0.0 {
                polygon.push(corners[i]);
            }
            if p * q < 0.0 {
                polygon.push(corners[i] + (corners[j] - corners[i]) * (p / (p - q)));
            }
        }
        let fan = (2..polygon.len()).map(|k| Plate::triangle(polygon[0], polygon[k - 1], polygon[k]));
        out.extend(fan.filter(|t| t.area() > 0.0));
    }
    out
}

fn far_plates(a: &Plate, b: &Plate, sides: [Sides; 2], d: Vec3) -> DistanceMoments {
    let r2 = d.length2();
    let ca = visible_cosine(sides[0], a.normal().dot(d));
    let cb = visible_cosine(sides[1], -b.normal().dot(d));
    let f = ca * cb / (PI * r2 * r2) * a.area() * b.area();
    let spread = (a.diameter().powi(2) + b.diameter().powi(2)) / r2;
    DistanceMoments {
        factor: Bounded::estimated(f, 0.5 * spread * f),
        mean_distance: r2.sqrt(),
        ..DistanceMoments::ZERO
    }
}

fn outer_plate(a: &Plate, b: &Plate, sides: [Sides; 2], tolerance: f64, floor: f64, depth: u32) -> PowerSums {
    let (na, nb) = (a.normal(), b.normal());
    let quarters = b.quarters();
    let sample = |n: usize| {
        let mut s = PowerSums::default();
        plate_points(a, n, |x, w| {
            let height = nb.dot(x - b.origin);
            if height <= 0.0 && sides[1] == Sides::Front {
                return;
            }
            // The quarters serve the moments of distance; their sum is the closed form of the whole.
            let kernel = |q: &Plate| {
                let f = projected_solid_angle(q, x, na);
                if sides[0] == Sides::Both { f + projected_solid_angle(q, x, -na) } else { f }
            };
            quarters.iter().for_each(|q| add_plate_moments(q, x, w, MAX_INNER_SUBDIVISIONS, &kernel, &mut s));
        });
        s
    };
    let (coarse, mut fine) = (sample(2), sample(3));
    fine.error = (fine.f - coarse.f).abs();
    if agree_within(coarse.f, fine.f, tolerance) || fine.error < floor || depth == MAX_SUBDIVISIONS {
        return fine;
    }
    let mut sum = PowerSums::default();
    for part in a.quarters() {
        sum.merge(outer_plate(&part, b, sides, tolerance, floor * 0.25, depth + 1));
    }
    sum
}

/// 𝓕 of a plate and the cuboid from `lo` to `hi`, m³. `sides` of the plate.
pub fn plate_cuboid(p: &Plate, lo: Vec3, hi: Vec3, sides: Sides, tolerance: f64) -> DistanceMoments {
    let (size_p, edge) = (p.diameter(), hi - lo);
    let d = p.centre() - (lo + hi) * 0.5;
    if is_far(d.length2(), size_p, edge.length(), tolerance) {
        let r2 = d.length2();
        let c = -p.normal().dot(d);
        let c = visible_cosine(sides, c);
        let f = c / (PI * r2 * r2.sqrt()) * p.area() * edge.product();
        let spread = (size_p * size_p + edge.length2()) / r2;
        return DistanceMoments {
            factor: Bounded::estimated(f, 0.5 * spread * f),
            mean_distance: r2.sqrt(),
            ..DistanceMoments::ZERO
        };
    }
    let floor = tolerance * 1e-2 * edge.product().min(p.area() * edge.length());
    if sides == Sides::Both {
        return outer_cuboid(p, lo, edge, sides, tolerance, floor, 0).finish();
    }
    let Some((lo, hi)) = in_front(p, lo, hi) else {
        return DistanceMoments::ZERO;
    };
    outer_cuboid(p, lo, hi - lo, sides, tolerance, floor, 0).finish()
}

/// The bounds of that part of a box that lies in front of a plate's plane.
fn in_front(p: &Plate, lo: Vec3, hi: Vec3) -> Option<(Vec3, Vec3)> {
    let corner = |k: usize| {
        vec3(
            if k & 1 > 0 { hi.x } else { lo.x },
            if k & 2 > 0 { hi.y } else { lo.y },
            if k & 4 > 0 { hi.z } else { lo.z },
        )
    };
    let height = |x: Vec3| p.normal().dot(x - p.origin);
    let mut bounds: Option<(Vec3, Vec3)> = None;
    let mut offer = |x: Vec3| {
        let (a, b) = bounds.unwrap_or((x, x));
        bounds = Some((a.min(x), b.max(x)));
    };
    for k in 0..8 {
        let (x, h) = (corner(k), height(corner(k)));
        if h >= 0.0 {
            offer(x);
        }
        for bit in [1, 2, 4] {
            let (y, g) = (corner(k ^ bit), height(corner(k ^ bit)));
            if h > 0.0 && g < 0.0 {
                offer(x + (y - x) * (h / (h - g)));
            }
        }
    }
    bounds.filter(|(a, b)| (*b - *a).product() > 0.0)
}

fn outer_cuboid(
    p: &Plate,
    lo: Vec3,
    edge: Vec3,
    sides: Sides,
    tolerance: f64,
    floor: f64,
    depth: u32,
) -> PowerSums {
    let quarters = p.quarters();
    let volume = edge.product();
    let sample = |n: usize| {
        let (rule, mut s) = (gauss_legendre::rule(n), PowerSums::default());
        for (x, wx) in rule.nodes.iter().zip(&rule.weights) {
            for (y, wy) in rule.nodes.iter().zip(&rule.weights) {
                for (z, wz) in rule.nodes.iter().zip(&rule.weights) {
                    let at = lo + edge.scale(vec3(*x, *y, *z));
                    add_point(p, &quarters, at, sides, wx * wy * wz * volume, &mut s);
                }
            }
        }
        s
    };
    // Boxes are divided less often than plates, unless they are larger than the plate.
    let most = MAX_SUBDIVISIONS - 2
        + (edge.length() * (1 << depth) as f64 / p.diameter()).log2().clamp(0.0, 4.0) as u32;
    let (coarse, mut fine) = (sample(1), sample(2));
    fine.error = (fine.f - coarse.f).abs() * 0.25;
    let height = |x: Vec3| p.normal().dot(x - p.origin);
    let reach = 0.5 * edge.scale(p.normal()).array().iter().map(|x| x.abs()).sum::<f64>();
    // A box cut by the plane of the plate is divided at least once: its integrand has a kink.
    let cut = depth == 0 && sides == Sides::Front && height(lo + edge * 0.5) < 0.99 * reach;
    if !cut && (depth > 0 || agree_within(coarse.f, fine.f, tolerance)) && fine.error <= tolerance * fine.f
        || !cut && fine.error < floor
        || depth >= most
    {
        return fine;
    }
    let (half, mut sum) = (edge * 0.5, PowerSums::default());
    for k in 0..8 {
        let corner = lo + half.scale(vec3((k >> 2) as f64, (k >> 1 & 1) as f64, (k & 1) as f64));
        sum.merge(outer_cuboid(p, corner, half, sides, tolerance, floor * 0.125, depth + 1));
    }
    sum
}

fn add_point(p: &Plate, quarters: &[Plate; 4], at: Vec3, sides: Sides, weight: f64, s: &mut PowerSums) {
    let height = p.normal().dot(at - p.origin);
    if height <= 0.0 && sides == Sides::Front {
        return;
    }
    quarters.iter().for_each(|q| {
        add_plate_moments(q, at, weight, MAX_INNER_SUBDIVISIONS, &|q| solid_angle(q, at).abs(), s)
    });
}

/// A plate and points in free space, each with the volume that it represents: 𝓕 = (1/π) Σ ω V, with moments of distance. `error` is the relative
/// error
/// of the points as a quadrature of the space.
pub(crate) fn plate_and_points(
    p: &Plate,
    points: impl Iterator<Item = (Vec3, f64)>,
    sides: Sides,
    error: f64,
) -> DistanceMoments {
    let (quarters, mut s) = (p.quarters(), PowerSums::default());
    points.for_each(|(at, volume)| add_point(p, &quarters, at, sides, volume, &mut s));
    s.error = error * s.f;
    s.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_square(z: f64) -> Plate {
        Plate::parallelogram(vec3(0.0, 0.0, z), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0))
    }

    #[test]
    fn opposite_and_touching_squares_match_the_closed_forms() {
        let floor = unit_square(0.0);
        let m = plate_plate(&floor, &unit_square(1.0).flipped(), [Sides::Front; 2], 1e-6);
        assert!((m.factor.value - 0.199_824_895_698_39).abs() < 1e-6);
        let wall = Plate::parallelogram(Vec3::ZERO, vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
        let m = plate_plate(&floor, &wall, [Sides::Front; 2], 1e-4);
        assert!((m.factor.value - 0.200_043_776_075_4).abs() < 2e-4 * 0.2, "{:?}", m);
    }

    #[test]
    fn two_triangles_sum_to_square() {
        let floor = unit_square(0.0);
        let top = unit_square(0.7).flipped();
        let (c, _) = top.corners();
        let whole = plate_plate(&floor, &top, [Sides::Front; 2], 1e-6).factor.value;
        let parts: f64 = [Plate::triangle(c[0], c[1], c[2]), Plate::triangle(c[0], c[2], c[3])]
            .iter()
            .map(|t| plate_plate(t, &floor, [Sides::Front; 2], 1e-6).factor.value)
            .sum();
        assert!((whole - parts).abs() < 1e-5 * whole);
    }

    #[test]
    fn cube_and_its_faces_close() {
        // Thin medium: the six walls of a cube take 4 V from a unit of volume.
        let o = Vec3::ZERO;
        let faces = [
            Plate::parallelogram(o, vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)),
            Plate::parallelogram(vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), vec3(0.0, 1.0, 0.0)),
        ];
        let f: f64 =
            faces.iter().map(|p| plate_cuboid(p, o, Vec3::ONE, Sides::Front, 1e-4).factor.value).sum();
        assert!((f - 4.0 / 3.0).abs() < 5e-4, "{f}");
    }

    #[test]
    fn union_of_parts_has_moments_of_whole() {
        let (lo, middle, hi) = (vec3(2.0, -1.0, 0.5), vec3(2.6, 1.5, 1.5), vec3(3.0, 1.5, 1.5));
        let part = |lo, hi| plate_cuboid(&unit_square(0.0), lo, hi, Sides::Front, 1e-7);
        let whole = part(lo, hi);
        let both = part(lo, middle).union(&part(vec3(middle.x, lo.y, lo.z), hi));
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-4 * b.abs(), "{a} {b}");
        close(both.factor.value, whole.factor.value);
        close(both.mean_distance, whole.mean_distance);
        close(both.variance, whole.variance);
        assert!(
            (both.third_cumulant - whole.third_cumulant).abs() < 1e-3 * whole.variance.powf(1.5),
            "{both:?} {whole:?}"
        );
    }

    #[test]
    fn back_of_plate_exchanges_only_with_both_sides() {
        let p = unit_square(0.0);
        let (lo, hi) = (vec3(0.0, 0.0, -2.0), vec3(1.0, 1.0, -1.0));
        assert_eq!(plate_cuboid(&p, lo, hi, Sides::Front, 1e-3).factor.value, 0.0);
        assert!(plate_cuboid(&p, lo, hi, Sides::Both, 1e-3).factor.value > 0.0);
    }
}
