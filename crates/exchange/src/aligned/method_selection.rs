//! Selection of the method for a pair of boxes: the cheapest whose **proved** bound meets the tolerance.
//!
//! By increasing cost: the moment series (`moment_series.rs`, a few hundred products), the closed form of two rectangles
//! (`closed_form.rs`, sixteen arcs and logarithms), Gauss rules of the densities (`density_rules.rs`, some tens of kernels), the reduced
//! integral in cells
//! (`cell_integration.rs`, hundreds to many thousands of kernels), which applies to every pair.

use super::density_rules::{DensityFamily, RulePlan};
use super::moment_series::{self, BoxPairMoments, FarPairs};
use super::reduced_pair::ReducedPair;
use super::{cell_integration, closed_form};
use crate::{Factor, Method};
use zonal_math::Bounded;

/// Smallest relative tolerance: below it rounding dominates every method.
pub(super) const FINEST_TOLERANCE: f64 = 1e-13;
/// Share of the tolerance for truncation and quadrature; rounding takes the rest.
pub(super) const TRUNCATION_SHARE: f64 = 0.75;

/// A method that is proved to meet the tolerance, with the data computed for that proof.
pub(super) enum SelectedMethod {
    /// The series, with its order and truncation.
    Moments(Box<BoxPairMoments>, FarPairs<1>, usize, [f64; 1]),
    /// The closed form, whose value costs no more than its bound.
    Closed(Bounded),
    /// Gauss rules of the densities.
    Density(DensityFamily, RulePlan<1>),
    /// The reduced integral in cells.
    Cells,
}

/// Selects the method of a pair.
pub(super) fn select_method(pair: &ReducedPair, kappa: f64, tolerance: f64) -> SelectedMethod {
    let centre = moment_series::centre_offset(pair);
    let lanes = centre.map(|c| [c]);
    let r2: f64 = centre.iter().map(|c| c * c).sum();
    let reach2: f64 = pair.0.iter().map(|a| 0.25 * (a.p[3] - a.p[0]).powi(2)).sum();
    let far = reach2 < moment_series::MAX_SIZE_OVER_DISTANCE * moment_series::MAX_SIZE_OVER_DISTANCE * r2;
    if kappa == 0.0 && far && tolerance >= moment_series::MIN_TOLERANCE {
        let shape = BoxPairMoments::of(pair);
        let far = FarPairs::new(&shape, &lanes);
        if let Some((order, truncation)) = moment_series::order(&shape, &far, TRUNCATION_SHARE * tolerance)
            && 1.1 * (truncation[0] + far.noise(&shape, order)[0]) <= tolerance
        {
            return SelectedMethod::Moments(Box::new(shape), far, order, truncation);
        }
    }
    if kappa == 0.0
        && let Some(f) = closed_form::factor(pair)
        && f.radius <= tolerance * (f.value - f.radius)
        && f.value > cell_integration::MIN_SAFE_VALUE
    {
        return SelectedMethod::Closed(f);
    }
    let alike = |long: f64, short: f64| short == 0.0 || long - short <= 2.0 * f64::EPSILON * long;
    if far && pair.0.iter().all(|a| alike(a.long, a.short)) {
        let grid = DensityFamily::new(pair.0.map(|a| (a.long, a.short)), kappa);
        if let Some(plan) = grid.plan(&lanes, TRUNCATION_SHARE * tolerance)
            && grid.rounding(r2.sqrt()) <= 0.2 * tolerance
        {
            return SelectedMethod::Density(grid, plan);
        }
    }
    SelectedMethod::Cells
}

/// The factor of a pair by the method of [`select_method`].
pub(super) fn factor_of(pair: &ReducedPair, kappa: f64, tolerance: f64) -> Factor {
    let tolerance = tolerance.clamp(FINEST_TOLERANCE, 0.1);
    match select_method(pair, kappa, tolerance) {
        SelectedMethod::Moments(shape, far, order, truncation) => {
            let (value, radius) = far.finish(&shape, order, &truncation);
            let checked = proved(value[0], radius[0], (order + 1) as u64, Method::Moments, tolerance);
            checked.unwrap_or_else(|| factor_by_cells(pair, kappa, tolerance))
        }
        SelectedMethod::Closed(bounded) => {
            Factor { bounded, evaluations: closed_form::EVALUATIONS, method: Method::ClosedForm }
        }
        SelectedMethod::Density(grid, plan) => {
            let (value, radius) = grid.integrate(&moment_series::centre_offset(pair).map(|c| [c]), &plan);
            let evaluations = plan.points.iter().product::<usize>() as u64;
            let checked = proved(value[0], radius[0], evaluations, Method::Gauss, tolerance);
            checked.unwrap_or_else(|| factor_by_cells(pair, kappa, tolerance))
        }
        SelectedMethod::Cells => factor_by_cells(pair, kappa, tolerance),
    }
}

/// The factor if its radius meets the tolerance; the bounds used for the selection are relative to estimates.
fn proved(value: f64, radius: f64, evaluations: u64, method: Method, tolerance: f64) -> Option<Factor> {
    let within = radius <= tolerance * value && value > cell_integration::MIN_SAFE_VALUE;
    within.then(|| Factor { bounded: Bounded::proved(value, radius), evaluations, method })
}

/// The reduced integral, cut into cells.
pub(super) fn factor_by_cells(pair: &ReducedPair, kappa: f64, tolerance: f64) -> Factor {
    let i = cell_integration::integrate::<1>(pair, kappa, tolerance);
    // Lengths whose squares underflow leave the value unknown.
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
