//! Two plates: the cheapest method whose proved bound meets the requested accuracy.
//!
//! Not visible (one behind the other's plane or in it) → tensor Gauss rules with few points (`tensor_rules.rs`) → contours (`contour.rs`).
//! With a medium → `cell_rules.rs`.
//!
//! Plates are processed in one canonical order, so that 𝓕_ab and 𝓕_ba are identical to the bit.

use super::cell_rules;
use super::contour::{self, COPLANAR_BOUND, Contour, ContourSum};
use super::mapped_zone::assert_valid_plate;
use super::plate_geometry::PlateGeometry;
use super::tensor_rules::{self, PlatePairGeometry};
use crate::{AccuracyRequest, Factor, Method};
use std::cmp::Ordering;
use std::f64::consts::PI;
use zonal_math::Bounded;
use zonal_scene::Plate;

/// Unit roundoff 2⁻⁵³.
const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;
/// Roundings of the position of a corner relative to the other plate.
const CORNER_ROUNDINGS: f64 = 4.0; // bound
/// Rounds of the contour sum, at most; the first starts from a rough value.
const MAX_CONTOUR_ROUNDS: usize = 3;

/// The requested radius: max(relative · |𝓕|, absolute), m².
#[derive(Clone, Copy, Debug)]
pub(super) struct RadiusGoal {
    pub relative: f64,
    pub absolute: f64,
}

impl RadiusGoal {
    fn radius(&self, value: f64) -> f64 {
        (self.relative * value.abs()).max(self.absolute)
    }
}

/// 𝓕 = (1/π) ∬ e^{−κr} cosθ_a cosθ_b/r² dA dA of two plates, fronts facing, m²; `kappa` in 1/m. Grade proved.
///
/// ```
/// use zonal_exchange::{AccuracyRequest, polygon::plate_plate};
/// use zonal_math::vec3;
/// use zonal_scene::Plate;
/// // Perpendicular unit squares with a common edge: the view factor of Howell's catalogue, C-14.
/// let floor = Plate::parallelogram(vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
/// let wall = Plate::parallelogram(vec3(0.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
/// let f = plate_plate(&floor, &wall, 0.0, AccuracyRequest::relative(1e-10)).bounded;
/// assert!((f.value - 0.200_043_776_075_4).abs() < 1e-10);
/// ```
///
/// The radius is at most tolerance · 𝓕 where rounding and the limit of evaluations allow, otherwise larger.
///
/// # Panics
/// On a plate without area or with corners that are not finite, on a `kappa` that is negative or not finite.
pub fn plate_plate(a: &Plate, b: &Plate, kappa: f64, accuracy: AccuracyRequest) -> Factor {
    assert_valid_plate(a);
    assert_valid_plate(b);
    assert!(kappa >= 0.0 && kappa.is_finite(), "extinction {kappa} 1/m");
    let (a, b) = if canonical_order(a, b) == Ordering::Greater { (b, a) } else { (a, b) };
    if kappa > 0.0 {
        return cell_rules::plate_plate(a, b, kappa, accuracy);
    }
    let goal = RadiusGoal { relative: accuracy.tolerance, absolute: 1e-300 };
    factor_without_medium(&PlateGeometry::new(a), &PlateGeometry::new(b), goal)
}

fn canonical_order(a: &Plate, b: &Plate) -> Ordering {
    let numbers = |p: &Plate| [p.origin, p.e1, p.e2].map(|v| v.array());
    let (x, y) = (numbers(a), numbers(b));
    let pairs = x.as_flattened().iter().zip(y.as_flattened());
    pairs.map(|(p, q)| p.total_cmp(q)).find(|o| o.is_ne()).unwrap_or((a.kind as u8).cmp(&(b.kind as u8)))
}

/// Two plates without a medium, in the order of the caller.
pub(super) fn factor_without_medium(a: &PlateGeometry, b: &PlateGeometry, goal: RadiusGoal) -> Factor {
    let view = PlatePairGeometry::of(a, b);
    if view.is_unseen() {
        return unseen(a, b, &view);
    }
    if view.is_uncut()
        && let Some(plan) = tensor_rules::plan(a, b, &view, goal.relative, goal.absolute)
    {
        let sum = tensor_rules::evaluate(a, b, &view, &plan);
        if sum.radius <= goal.radius(sum.value) {
            return factor(sum, Method::Oblique);
        }
    }
    by_contour(a, b, &view, goal)
}

fn factor(sum: ContourSum, method: Method) -> Factor {
    Factor { bounded: Bounded::proved(sum.value, sum.radius), evaluations: sum.evaluations, method }
}

/// Zero, with the rounding error of a plate that lies in the plane of the other.
fn unseen(a: &PlateGeometry, b: &PlateGeometry, view: &PlatePairGeometry) -> Factor {
    if view.over_a[2] < -view.eta || view.over_b[2] < -view.eta {
        return Factor::NOT_VISIBLE;
    }
    let moved = COPLANAR_BOUND * view.eta * (perimeter(a) + perimeter(b));
    let gap = (view.d + b.centre - a.centre).length() - a.radius - b.radius - view.eta;
    let height = |h: &[f64; 3]| h[2].max(0.0) + 2.0 * view.eta;
    let apart = a.area * b.area * height(&view.over_a) * height(&view.over_b) / (PI * gap.powi(4));
    let radius = if gap > 0.0 { moved.min(1.001 * apart) } else { moved };
    Factor { bounded: Bounded::proved(0.0, radius), ..Factor::NOT_VISIBLE }
}

fn perimeter(p: &PlateGeometry) -> f64 {
    (0..p.count).map(|k| (p.corners[(k + 1) % p.count] - p.corners[k]).length()).sum()
}

fn by_contour(a: &PlateGeometry, b: &PlateGeometry, view: &PlatePairGeometry, goal: RadiusGoal) -> Factor {
    let first = Contour {
        corners: a.corners[..a.count].to_vec(),
        displaced: CORNER_ROUNDINGS * UNIT_ROUNDOFF * a.reach,
    };
    let second = Contour {
        corners: b.corners[..b.count].iter().map(|c| *c + view.d).collect(),
        displaced: CORNER_ROUNDINGS * UNIT_ROUNDOFF * (view.d.length() + b.reach),
    };
    let cut = (first.in_front(view.d, b.normal, view.eta), second.in_front(a.corners[0], a.normal, view.eta));
    let (Some(first), Some(second)) = cut else {
        return unseen(a, b, view);
    };
    let rough = tensor_rules::rough_value(a, b, view);
    refine(&first, &second, goal, rough)
}

/// Contour sums whose requested error follows from the last value.
pub(super) fn refine(a: &Contour, b: &Contour, goal: RadiusGoal, rough: f64) -> Factor {
    let mut wanted = 0.3 * goal.radius(0.3 * rough);
    let mut evaluations = 0;
    for round in 1.. {
        let mut sum = contour::sum(a, b, wanted);
        evaluations += sum.evaluations;
        let goal = goal.radius(sum.value);
        if sum.radius <= goal || round == MAX_CONTOUR_ROUNDS || wanted <= 0.3 * goal {
            sum.evaluations = evaluations;
            return factor(sum, Method::Contour);
        }
        wanted = 0.3 * goal;
    }
    unreachable!("the loop returns by its last round")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A constant covers its count, and half of it would not.
    fn covers(constant: f64, count: f64) {
        assert!(constant >= count && 0.5 * constant < count, "{constant} {count}");
    }

    #[test]
    fn rounding_constants_cover_their_counts() {
        // The difference of origins, the sum of edges, its sum with the difference.
        covers(CORNER_ROUNDINGS, 1.0 + 1.0 + 1.0);
    }
}
