//! Amplification of closure defects by reflection and scattering.
//!
//! A row that misses closure by the fraction d errs by e = |d| H at once. Its zone reflects the error, other zones receive it, and rows with defects of one
//! sign lose or create power in every reflection:
//!
//! ```text
//!     e_all = (I − K)⁻¹ e,        K: product with the exchange areas, times ρ or Ω
//! ```
//!
//! in a medium that scatters n times before it absorbs up to n e. Cost: one more column of the iteration, where rows miss closure. Heat propagates the errors
//! of powers by itself (`thermal/error_propagation.rs`).

use crate::errors::closure_error::{error_of_fraction, missing_fraction};
use crate::group_solve;
use crate::iteration::multivector::times;
use crate::operator::ErrorModel;
use crate::report::closure::RowClosure;
use crate::solve_context::SolveContext;
use zonal_exchange::pair::scaled_radiosity_coefficient;
use zonal_scene::{Bands, Fields};

/// Defect of a row up to which amplification does not matter.
const NEGLIGIBLE_DEFECT: f64 = 1e-9;
/// Relative residual of the amplified errors.
const RESIDUAL: f64 = 1e-3;

/// The parts of the rows that miss closure and that nothing explains, after any restoration; `fractions` are those of all defects. `None` if they do not
/// matter.
pub(crate) fn unclosed_fractions(
    context: &SolveContext,
    closure: &mut RowClosure,
    fractions: &[Bands],
) -> Option<Vec<Bands>> {
    let left = match closure.residuals.take() {
        Some(left) => left.into_iter().map(|d| d.map(missing_fraction)).collect(),
        None => fractions.to_vec(),
    };
    let matters = |i: usize| left.get(i).is_some_and(|d| d.abs().any(|d| d > NEGLIGIBLE_DEFECT));
    (context.scene.thermal().is_none() && context.shared_zones().any(matters)).then_some(left)
}

/// Adds to the errors of the incident fields that of the defects `fractions` after all reflections.
pub(crate) fn widen(
    context: &SolveContext,
    operator: &dyn ErrorModel,
    fractions: &[Bands],
    fields: &mut Fields,
) {
    let (zones, n) = (context.zones, context.zones.len());
    // An unknown error of a zone stays there: it has no amount that others could receive.
    let finite = |e: f64| if e.is_finite() { e } else { 0.0 };
    let own = |i: usize| fractions[i].abs().zip_map(fields.incident[i], error_of_fraction).map(finite);
    let errors: Vec<Bands> = (0..n).map(own).collect();
    let coefficients: Vec<Bands> = (0..n).map(|i| scaled_radiosity_coefficient(zones, i)).collect();
    let scattered: Vec<Bands> = (0..n).map(|i| zones.scattered(i, |k| errors[k])).collect();
    let sources = times(&coefficients, &scattered);
    let mut more = operator.apply(&group_solve::respond(context, operator, sources, RESIDUAL));
    more.truncate(n);
    for (i, (e, power)) in fields.error.iter_mut().zip(more).enumerate() {
        let amount = (power / zones.response(i).1).abs();
        *e += amount.map(|e| if e.is_nan() { f64::INFINITY } else { e });
    }
}
