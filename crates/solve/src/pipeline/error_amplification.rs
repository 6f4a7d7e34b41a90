//! Amplification of errors by reflection and scattering, in light mode.
//!
//! The errors of the factors make the incident field of a zone err by e at once. The zone reflects the error, and other zones receive it, also those whose own
//! factors are exact:
//!
//! ```text
//!     e_all = (I − K)⁻¹ e,        K: product with the exchange areas, times ρ or Ω
//! ```
//!
//! **Errors of factors** are independent from zone to zone: e_all with equal signs is limited by draws of random signs (`errors/random_signs.rs`). Where the largest
//! e, in a field that errs by rounding alone, bounds what all reflections make of it, no system is solved:
//!
//! ```text
//!     e_all − e ≤ e_max ρ_max / (1 − ρ_max)        since rows sum to one at most
//! ```
//!
//! **Closure defects.** A row that misses closure by the fraction d errs by e = |d| H at once. Rows with defects of one sign lose or create power in every
//! reflection, in a medium that scatters n times before it absorbs up to n e.
//!
//! Cost: up to three more columns of the iteration for each light group whose factors are sampled, one where rows miss closure. Heat propagates the errors of
//! powers by itself (`thermal/error_propagation.rs`), and a final gather has errors that contain those of the powers.

use crate::balance::closure::RowClosure;
use crate::context::SolveContext;
use crate::errors::closure_error::{error_of_fraction, missing_fraction};
use crate::errors::empty_rows::EmptyRows;
use crate::errors::propagation::errors_like;
use crate::errors::random_signs::ErrorReflection;
use crate::operator::ErrorModel;
use crate::pipeline::group_solve;
use crate::settings::zone_power::reflected_fraction;
use zonal_math::parallel;
use zonal_scene::{Band, Bands, Fields, LightGroup};

/// Defect of a row up to which amplification does not matter.
const NEGLIGIBLE_DEFECT: f64 = 1e-9;
/// Relative residual of amplified errors.
const RESIDUAL: f64 = 1e-3;

/// The parts of the rows that miss closure and that nothing explains, after any restoration; `fractions` are those of all defects. `None` if they do not
/// matter.
pub(crate) fn unclosed_fractions(
    context: &SolveContext,
    closure: &mut RowClosure,
    fractions: &[Bands],
) -> Option<Vec<Bands>> {
    let residuals = closure.residuals.take();
    let left = |i: usize| match &residuals {
        Some(left) => left.get(i).map_or(Bands::ZERO, |d| d.map(missing_fraction)),
        None => fractions[i],
    };
    let matters = |i: usize| left(i).abs().any(|d| d > NEGLIGIBLE_DEFECT);
    let matter = context.scene.thermal().is_none() && context.shared_zones().any(matters);
    matter.then(|| parallel::collect(fractions.len(), left))
}

/// Reflected errors, over the largest field, up to which their bound for equal signs is stated.
const NEGLIGIBLE_ERROR: f64 = 1e-6;
/// The same for the bound that no solve needs.
const ROUNDING_ERROR: f64 = 1e-8;

/// Adds to the errors of the incident fields that of the defects `fractions` after all reflections; that of rows which hold little is limited.
pub(crate) fn widen_by_defects(
    context: &SolveContext,
    operator: &dyn ErrorModel,
    fractions: &[Bands],
    empty_rows: &EmptyRows,
    fields: &mut Fields,
) {
    let (zones, n) = (context.zones, context.zones.len());
    let own = |i: usize| {
        let h = fields.incident[i];
        finite(empty_rows.limited(zones, i, h, fractions[i].abs().zip_map(h, error_of_fraction)))
    };
    let errors: Vec<Bands> = parallel::collect(n, own);
    let reflect = |sources: Vec<Bands>| all_reflections(context, operator, sources);
    let reflection = ErrorReflection { zones, unknowns: operator.len(), error: &errors, reflect: &reflect };
    let more = reflection.of_draw(0);
    parallel::for_each_pair(&mut fields.error, &more, |e, more| *e += or_unknown(*more));
}

/// Adds to the errors of the incident field of every group, and of all light, what reflection and scattering make of them; of all light at once where the
/// groups have no errors of their own.
pub(crate) fn widen_by_reflection(
    context: &SolveContext,
    operator: &dyn ErrorModel,
    fields: &mut Fields,
    groups: &mut [LightGroup],
) {
    if context.scene.thermal().is_some() {
        return;
    }
    if groups.iter().any(|g| g.error.is_empty()) {
        let more = reflected(context, operator, &fields.error, &|i| fields.incident[i]);
        parallel::for_each(&mut fields.error, |i, e| *e += more.of(i));
        return;
    }
    for group in groups {
        let mut own = group.errors(context.zones.len());
        let incident = |i: usize| group.incident_at(i);
        let more = reflected(context, operator, &own, &incident);
        parallel::for_each(&mut fields.error, |i, all| *all += more.of(i));
        parallel::for_each(&mut own, |i, own| *own += more.of(i));
        group.error = errors_like(&group.incident, &own, group.incident_scale);
    }
}

/// Errors of a field after reflection and scattering, W/m².
enum ReflectedErrors {
    /// One bound for all zones.
    Everywhere(Bands),
    OfZone(Vec<Bands>),
}

impl ReflectedErrors {
    fn of(&self, i: usize) -> Bands {
        match self {
            ReflectedErrors::Everywhere(bound) => *bound,
            ReflectedErrors::OfZone(errors) => errors[i],
        }
    }
}

/// What reflection and scattering make of the errors `own` of a field, W/m².
fn reflected(
    context: &SolveContext,
    operator: &dyn ErrorModel,
    own: &[Bands],
    incident: &(dyn Fn(usize) -> Bands + Sync),
) -> ReflectedErrors {
    let (zones, n, sums) = (context.zones, own.len(), context.shared_zones().order());
    let largest = |of: &(dyn Fn(usize) -> Bands + Sync)| {
        let all = parallel::reduce(n, Bands::ZERO, of, |m, x| m.zip_map(x, f64::max));
        sums.over_processes(all, |a: Bands, b: Bands| a.zip_map(b, f64::max))
    };
    let [most, field] = [largest(&|i| finite(own[i])), largest(&|i| incident(i).abs())];
    let reflectance = largest(&|i| reflected_fraction(zones, i));
    let bound =
        most.zip_map(
            reflectance,
            |e, rho| if e == 0.0 || rho == 0.0 { 0.0 } else { e * rho / (1.0 - rho).max(0.0) },
        );
    if Band::all().all(|b| bound[b] <= ROUNDING_ERROR * field[b]) {
        return ReflectedErrors::Everywhere(bound);
    }
    // An unknown error of a zone stays there: it has no amount that others could receive.
    let errors: Vec<Bands> = parallel::map(own, |e| finite(*e));
    // Reflect the errors with equal signs, and with random ones where they matter.
    let reflect = |sources: Vec<Bands>| all_reflections(context, operator, sources);
    let reflection = ErrorReflection { zones, unknowns: operator.len(), error: &errors, reflect: &reflect };
    let mut more = reflection.of_draw(0);
    let matters = largest(&|i| more[i]);
    let is_negligible = Band::all().all(|b| matters[b] <= NEGLIGIBLE_ERROR * field[b]);
    if !is_negligible && !sums.is_divided() {
        reflection.limit_by_random_signs(&mut more);
    }
    ReflectedErrors::OfZone(parallel::map(&more, |e| or_unknown(*e)))
}

/// Incident powers for the strengths `sources` after all reflections.
fn all_reflections(context: &SolveContext, operator: &dyn ErrorModel, sources: Vec<Bands>) -> Vec<Bands> {
    operator.apply(&group_solve::respond(context, operator, sources, RESIDUAL))
}

/// The amounts of an error that are known, else 0.
fn finite(error: Bands) -> Bands {
    error.map(|e| if e.is_finite() { e } else { 0.0 })
}

/// An error that is not a number is unknown.
fn or_unknown(error: Bands) -> Bands {
    error.map(|e| if e.is_nan() { f64::INFINITY } else { e })
}
