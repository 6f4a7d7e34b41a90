//! The discretization error: a second solve on zones about twice as large, or half as large, and the difference of the two.
//!
//! Let Q(h) = Q + c h^p be a flux, a power or a temperature with zones of size h. Then, for p ≥ 1 and r > 1 (Richardson extrapolation),
//!
//! ```text
//!     |Q(h) − Q| = |Q(h) − Q(rh)| / (r^p − 1)             ≤  |Q(h) − Q(rh)| / (r − 1)             for zones r times as large
//!     |Q(h) − Q| = |Q(h) − Q(h/r)| · r^p / (r^p − 1)      ≤  2 |Q(h) − Q(h/r)|                    for zones r ≥ 2 times as small
//! ```
//!
//! The last bound holds for p ≥ 1/log₂ r: a few zones, divided by four or eight, need not be in the asymptotic range.
//! Observed orders lie between 1.5 and 2 (`docs/validation.md`), so that the bound is two to three times the error; for r = 2 and
//! p = 2 it is the grid convergence index of two grids (Roache). It is an estimate and may fail if Q(rh) is not in the asymptotic range.
//!
//! Patches are no larger than their facets: the patches of neighbouring facets of a fine mesh are merged into larger zones (`merged_facets`), which needs no
//! new exchange areas. Larger zones are cheap, but zones that the geometry does not allow to grow give no estimate, and few or thick ones a poor one. Scenes with few zones
//! are then solved on smaller zones instead. If these are too many as well, a third solve divides the surfaces and panes that did not grow, on the larger zones of the
//! others; its difference to the second solve, twice, is added. If that has more zones than the first solve, the errors of the surfaces and volumes that did not grow are infinite,
//! which stands for unknown, and the estimate of few or thick zones is multiplied by the largest observed ratio of error and estimate.
//!
//! Light without a second solve has the estimate of `thick_scattering` where cells scatter over large optical depths.
//!
//! The differences are far larger than the errors of the iteration and of the factors, so that the second solve has looser ones, and computes no errors of its own
//! ([`crate::SolvePurpose::Comparison`]); what it errs by is added to the differences (`difference_error`). In small scenes both solves run at the same time.
//!
//! r is the minimum growth of an edge (`zone_growth`). Prescribed temperatures and powers have no such error. The second solve is passed in as
//! a function.

mod comparison;
mod difference_error;
mod error_floor;
mod estimate;
mod merged_facets;
mod near_surface_scattering;
mod prescribed_temperatures;
mod second_solve;
mod solve_method;
mod thick_scattering;
mod zone_growth;

pub(crate) use comparison::{SecondSolve, refined_zone_count, second_solve};
pub(crate) use estimate::{estimate, is_requested, state_thick_scattering};
pub(crate) use second_solve::InterruptionOnly;
pub(crate) use solve_method::{SolveMethod, basis_of};
pub(crate) use zone_growth::DividedScene;
