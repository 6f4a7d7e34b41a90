//! Which formula serves a pair of boxes: the cheapest whose **proven** bound meets the tolerance.
//!
//! From cheap to dear: the moments' series (`moments.rs`, a few hundred products), the closed form of two rectangles
//! (`closed.rs`, sixteen arcs and logarithms), Gauss rules of the densities (`density.rs`, some tens of kernels), the reduced integral in cells
//! (`integrate.rs`, hundreds to many thousands of kernels), which serves everything.

use super::density::{Grid, Plan};
use super::moments::{self, Far, Shape};
use super::reduced::Reduced;
use super::{FINEST, closed, integrate};
use crate::{Factor, Method};
use zonal_math::Bounded;

/// The shares of the tolerance that truncation and quadrature may take: rounding has the rest.
pub(super) const SHARE: f64 = 0.75;

/// A method that is proved to serve, with what the judge already knows.
pub(super) enum Admitted {
    /// The series, with its order and what it leaves.
    Moments(Box<Shape>, Far<1>, usize, [f64; 1]),
    /// The closed form, which costs no more than its bound.
    Closed(Bounded),
    /// Gauss rules of the densities.
    Density(Grid, Plan<1>),
    /// The reduced integral in cells.
    Cells,
}

/// The one place that chooses.
pub(super) fn admissible(pair: &Reduced, kappa: f64, tolerance: f64) -> Admitted {
    let centre = moments::centre(pair);
    let lanes = centre.map(|c| [c]);
    let r2: f64 = centre.iter().map(|c| c * c).sum();
    let reach2: f64 = pair.0.iter().map(|a| 0.25 * (a.p[3] - a.p[0]).powi(2)).sum();
    let far = reach2 < moments::RATIO * moments::RATIO * r2;
    if kappa == 0.0 && far && tolerance >= moments::FINEST {
        let shape = Shape::of(pair);
        let far = Far::new(&shape, &lanes);
        if let Some((order, truncation)) = moments::order(&shape, &far, SHARE * tolerance)
            && 1.1 * (truncation[0] + far.noise(&shape, order)[0]) <= tolerance
        {
            return Admitted::Moments(Box::new(shape), far, order, truncation);
        }
    }
    if kappa == 0.0
        && let Some(f) = closed::factor(pair)
        && f.radius <= tolerance * (f.value - f.radius)
        && f.value > integrate::TINY
    {
        return Admitted::Closed(f);
    }
    let alike = |long: f64, short: f64| short == 0.0 || long - short <= 2.0 * f64::EPSILON * long;
    if far && pair.0.iter().all(|a| alike(a.long, a.short)) {
        let grid = Grid::new(pair.0.map(|a| (a.long, a.short)), kappa);
        if let Some(plan) = grid.plan(&lanes, SHARE * tolerance)
            && grid.rounding(r2.sqrt()) <= 0.2 * tolerance
        {
            return Admitted::Density(grid, plan);
        }
    }
    Admitted::Cells
}

/// The factor of a pair by the method that [`admissible`] names.
pub(super) fn factor_of(pair: &Reduced, kappa: f64, tolerance: f64) -> Factor {
    let tolerance = tolerance.clamp(FINEST, 0.1);
    match admissible(pair, kappa, tolerance) {
        Admitted::Moments(shape, far, order, truncation) => {
            let (value, radius) = far.finish(&shape, order, &truncation);
            let checked = proved(value[0], radius[0], (order + 1) as u64, Method::Moments, tolerance);
            checked.unwrap_or_else(|| by_cells(pair, kappa, tolerance))
        }
        Admitted::Closed(bounded) => Factor { bounded, evaluations: closed::TERMS, method: Method::Closed },
        Admitted::Density(grid, plan) => {
            let (value, radius) = grid.integrate(&moments::centre(pair).map(|c| [c]), &plan);
            let evaluations = plan.points.iter().product::<usize>() as u64;
            let checked = proved(value[0], radius[0], evaluations, Method::Gauss, tolerance);
            checked.unwrap_or_else(|| by_cells(pair, kappa, tolerance))
        }
        Admitted::Cells => by_cells(pair, kappa, tolerance),
    }
}

/// The factor if its radius is as wanted: the bounds above were relative to estimates.
fn proved(value: f64, radius: f64, evaluations: u64, method: Method, tolerance: f64) -> Option<Factor> {
    let enough = radius <= tolerance * value && value > integrate::TINY;
    enough.then(|| Factor { bounded: Bounded::proved(value, radius), evaluations, method })
}

/// The reduced integral, cut into cells.
pub(super) fn by_cells(pair: &Reduced, kappa: f64, tolerance: f64) -> Factor {
    let i = integrate::integrate::<1>(pair, kappa, tolerance);
    // Lengths whose squares underflow leave nothing that is known.
    let known = i.value[0].is_finite() && i.radius.is_finite();
    Factor {
        bounded: if known {
            Bounded::proved(i.value[0], i.radius)
        } else {
            Bounded::estimated(0.0, f64::INFINITY)
        },
        evaluations: i.evaluations,
        method: if i.touching { Method::Pyramid } else { Method::Gauss },
    }
}
