//! Errors of incident fields from rows that do not close.
//!
//! A row with the relative defect −d sums to 1 − d and holds 1 − d of the incident power. If the missing part is like the rest, it is
//! d/(1 − d) of the part that the row holds, and unknown (infinite) if the row holds nothing.

use crate::balance::closure::RowClosure;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use zonal_exchange::pair::closure_target;
use zonal_math::parallel;
use zonal_scene::{Bands, Zones};

/// Closure defects within this multiple of the standard error of the escaping power are attributed to that error.
const EXPLAINED_DEVIATION: f64 = 2.0;
/// Sum of a row, over its target, at and below which it holds nothing.
const EMPTY_ROW: f64 = 1e-9;

/// The part of each row's defect that the errors of the factors do not explain, as a fraction of the incident power of the zone.
///
/// A defect has two causes: the error of the escaping power, which carries no light, and errors that the factors of a row have in common, which no
/// sum of squares shows. The excess over twice the former counts. After restoration of closure, the whole change of the row and its residual
/// defect count.
pub(crate) fn unexplained_fractions(
    zones: &Zones,
    closure: &RowClosure,
    surroundings: &SurroundingsExchange,
) -> Vec<Bands> {
    let explained = DefectExplanation::of(zones, closure, surroundings);
    parallel::collect(closure.defects.len(), |i| explained.unexplained_fraction(i, closure.defects[i]))
}

/// [`unexplained_fractions`] in the place of the defects, which the closure has no longer.
pub(crate) fn take_unexplained_fractions(
    zones: &Zones,
    closure: &mut RowClosure,
    surroundings: &SurroundingsExchange,
) -> Vec<Bands> {
    let mut out = std::mem::take(&mut closure.defects);
    let explained = DefectExplanation::of(zones, closure, surroundings);
    parallel::for_each(&mut out, |i, d| *d = explained.unexplained_fraction(i, *d));
    out
}

/// What explains defects of rows.
enum DefectExplanation<'a> {
    /// Nothing: closure was restored.
    Nothing,
    /// The error of the power that escapes from the zones.
    EscapingPower(&'a Zones, &'a SurroundingsExchange),
}

impl<'a> DefectExplanation<'a> {
    fn of(zones: &'a Zones, closure: &RowClosure, surroundings: &'a SurroundingsExchange) -> Self {
        if closure.summary.restored {
            DefectExplanation::Nothing
        } else {
            DefectExplanation::EscapingPower(zones, surroundings)
        }
    }

    /// The unexplained part of the defect of row `i`.
    fn unexplained_fraction(&self, i: usize, defect: Bands) -> Bands {
        let DefectExplanation::EscapingPower(zones, surroundings) = self else {
            return defect.map(missing_fraction);
        };
        let lost = surroundings.escape_fraction_error(i, closure_target(zones, i));
        defect.zip_map(lost, |defect, lost| {
            let excess = (defect.abs() - EXPLAINED_DEVIATION * lost).max(0.0);
            missing_fraction(excess.copysign(defect))
        })
    }
}

/// The error of an incident field `h` for a missing fraction; infinite if the fraction is, also for a field of 0.
pub(crate) fn error_of_fraction(fraction: f64, h: f64) -> f64 {
    if fraction.is_infinite() { f64::INFINITY } else { fraction * h.abs() }
}

/// The error of a row relative to the power that it holds, for a relative closure defect (negative if the row falls short).
pub(crate) fn missing_fraction(defect: f64) -> f64 {
    if defect <= -1.0 + EMPTY_ROW {
        f64::INFINITY
    } else if defect < 0.0 {
        -defect / (1.0 + defect)
    } else {
        defect
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_fraction_is_relative_to_the_power_that_the_row_holds() {
        assert_eq!(missing_fraction(0.25), 0.25);
        assert!(
            (missing_fraction(-0.2) - 0.25).abs() < 1e-15,
            "a fifth of the whole is a quarter of the rest"
        );
        assert_eq!(missing_fraction(-1.0), f64::INFINITY);
        assert_eq!(
            error_of_fraction(missing_fraction(-1.0), 0.0),
            f64::INFINITY,
            "an empty row has an unknown error"
        );
        assert_eq!(error_of_fraction(0.25, -2.0), 0.5);
    }
}
