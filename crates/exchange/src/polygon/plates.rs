//! Two plates: the cheapest method whose proved bound meets the demand.
//!
//! Unseen (one behind the other's plane or in it) → tensor Gauss rules with few points (`tensor.rs`) → contours (`contour.rs`).
//! With a medium → `oblique.rs`.
//!
//! Plates are taken in one fixed order whatever that of the arguments: 𝓕_ab and 𝓕_ba are the same bits.

use super::contour::{self, Contour};
use super::prepared::Prepared;
use super::tensor::{self, View};
use crate::{Demand, Factor, Method};
use std::cmp::Ordering;
use std::f64::consts::PI;
use zonal_math::Bounded;
use zonal_scene::Plate;

/// 2⁻⁵³.
const EPS: f64 = 0.5 * f64::EPSILON;
/// Roundings of a corner's place relative to the other plate.
const PLACE: f64 = 4.0; // bound
/// Bound of what is left of a plate that lies below a height η over the other's plane: irradiance 2 times a displacement 2η.
pub(super) const HIDDEN: f64 = 4.0; // bound
/// Rounds of the contour sum: the first has a rough value only.
const ROUNDS: usize = 3;

/// The wanted radius: max(relative · |𝓕|, absolute), m².
#[derive(Clone, Copy, Debug)]
pub(super) struct Goal {
    pub relative: f64,
    pub absolute: f64,
}

impl Goal {
    fn radius(&self, value: f64) -> f64 {
        (self.relative * value.abs()).max(self.absolute)
    }
}

/// 𝓕 = (1/π) ∬ e^{−κr} cosθ_a cosθ_b/r² dA dA of two plates, fronts facing, m²; `kappa` in 1/m. Grade proved.
///
/// The radius is at most tolerance · 𝓕 where rounding and the budget allow, else it says so by being larger.
///
/// # Panics
/// On a plate without area or with corners that are not finite, on a `kappa` that is negative or not finite.
pub fn plate_plate(a: &Plate, b: &Plate, kappa: f64, demand: Demand) -> Factor {
    check(a);
    check(b);
    assert!(kappa >= 0.0 && kappa.is_finite(), "extinction {kappa} 1/m");
    let (a, b) = if order(a, b) == Ordering::Greater { (b, a) } else { (a, b) };
    if kappa > 0.0 {
        return super::oblique::plate_plate(a, b, kappa, demand);
    }
    let goal = Goal { relative: demand.tolerance, absolute: 1e-300 };
    plain(&Prepared::new(a), &Prepared::new(b), goal)
}

/// Refuses plates without area or with numbers that are none.
pub(super) fn check(p: &Plate) {
    let finite = p.origin.is_finite() && p.e1.is_finite() && p.e2.is_finite();
    assert!(finite && p.area() > 0.0, "not a plate: {p:?}");
}

fn order(a: &Plate, b: &Plate) -> Ordering {
    let numbers = |p: &Plate| [p.origin, p.e1, p.e2].map(|v| v.array());
    let (x, y) = (numbers(a), numbers(b));
    let pairs = x.as_flattened().iter().zip(y.as_flattened());
    pairs.map(|(p, q)| p.total_cmp(q)).find(|o| o.is_ne()).unwrap_or((a.kind as u8).cmp(&(b.kind as u8)))
}

/// Two plates without a medium, in the order that the caller keeps.
pub(super) fn plain(a: &Prepared, b: &Prepared, goal: Goal) -> Factor {
    let view = View::of(a, b);
    if view.is_unseen() {
        return unseen(a, b, &view);
    }
    if view.is_uncut()
        && let Some(plan) = tensor::plan(a, b, &view, goal.relative, goal.absolute)
    {
        let sum = tensor::evaluate(a, b, &view, &plan);
        if sum.radius <= goal.radius(sum.value) {
            return factor(sum, Method::Oblique);
        }
    }
    by_contour(a, b, &view, goal)
}

fn factor(sum: contour::Sum, method: Method) -> Factor {
    Factor { bounded: Bounded::proved(sum.value, sum.radius), evaluations: sum.evaluations, method }
}

/// Zero; with what rounding leaves open where a plate lies in the other's plane.
fn unseen(a: &Prepared, b: &Prepared, view: &View) -> Factor {
    if view.over_a[2] < -view.eta || view.over_b[2] < -view.eta {
        return Factor::UNSEEN;
    }
    let moved = HIDDEN * view.eta * (perimeter(a) + perimeter(b));
    let gap = (view.d + b.centre - a.centre).length() - a.radius - b.radius - view.eta;
    let height = |h: &[f64; 3]| h[2].max(0.0) + 2.0 * view.eta;
    let apart = a.area * b.area * height(&view.over_a) * height(&view.over_b) / (PI * gap.powi(4));
    let radius = if gap > 0.0 { moved.min(1.001 * apart) } else { moved };
    Factor { bounded: Bounded::proved(0.0, radius), ..Factor::UNSEEN }
}

fn perimeter(p: &Prepared) -> f64 {
    (0..p.count).map(|k| (p.corners[(k + 1) % p.count] - p.corners[k]).length()).sum()
}

fn by_contour(a: &Prepared, b: &Prepared, view: &View, goal: Goal) -> Factor {
    let first = Contour { corners: a.corners[..a.count].to_vec(), displaced: PLACE * EPS * a.reach };
    let second = Contour {
        corners: b.corners[..b.count].iter().map(|c| *c + view.d).collect(),
        displaced: PLACE * EPS * (view.d.length() + b.reach),
    };
    let cut = (first.in_front(view.d, b.normal, view.eta), second.in_front(a.corners[0], a.normal, view.eta));
    let (Some(first), Some(second)) = cut else {
        return unseen(a, b, view);
    };
    let rough = tensor::rough(a, b, view);
    refine(&first, &second, goal, rough)
}

/// Contour sums with a wanted error that follows from the last value.
pub(super) fn refine(a: &Contour, b: &Contour, goal: Goal, rough: f64) -> Factor {
    let mut wanted = 0.3 * goal.radius(0.3 * rough);
    let mut evaluations = 0;
    for round in 1.. {
        let mut sum = contour::sum(a, b, wanted);
        evaluations += sum.evaluations;
        let goal = goal.radius(sum.value);
        if sum.radius <= goal || round == ROUNDS || wanted <= 0.3 * goal {
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
    fn the_constants_cover_their_counts() {
        // The difference of origins, the sum of edges, its sum with the difference.
        covers(PLACE, 1.0 + 1.0 + 1.0);
        // An irradiance of 1 for each of two plates off by the height and its error.
        covers(HIDDEN, 2.0 * (1.0 + 1.0));
    }
}
