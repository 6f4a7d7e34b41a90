//! Propagation of the errors of factors, rows and sampled surroundings to the incident fields and to the powers of a solution.

use super::closure_error::error_of_fraction;
use crate::distribution::multivector;
use crate::iteration::IterationResult;
use crate::operator::ErrorModel;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use zonal_exchange::pair::closure_target;
use zonal_math::parallel;
use zonal_scene::{Bands, LightGroup, ZoneValues, Zones};

/// Standard error of the power that escapes, from the independent rays of each zone, W per band.
pub(crate) fn escaped_power_error(
    zones: &Zones,
    surroundings: &SurroundingsExchange,
    results: &[IterationResult],
) -> Bands {
    if surroundings.is_closed() || surroundings.rays == 0 {
        return Bands::ZERO;
    }
    let one = |i: usize| {
        let (t, sent) =
            (closure_target(zones, i), results.iter().fold(Bands::ZERO, |s, e| s + e.strengths[i]));
        let fraction = surroundings.escape_fraction_error(i, t);
        (fraction * t * sent).map(|e| e.powi(2))
    };
    multivector::sum(zones.len(), one).sqrt()
}

/// Estimated error of the incident field of every zone, W/m², from the errors of the factors and the unexplained closure defects `fractions`,
/// group by group.
///
/// The errors are stored in the groups. The result is their sum, which is no less than the error of all groups together.
pub(crate) fn propagate_factor_errors(
    zones: &Zones,
    operator: &dyn ErrorModel,
    fractions: &[Bands],
    results: &[IterationResult],
    groups: &mut [LightGroup],
) -> Vec<Bands> {
    let mut sum = vec![Bands::ZERO; zones.len()];
    for (group, result) in groups.iter_mut().zip(results) {
        let power = operator.error(&result.strengths).unwrap_or_else(|| vec![Bands::ZERO; zones.len()]);
        let one = |i: usize| {
            let (e, incident) = (power[i] / zones.response(i).1, group.incident.at(i));
            e + fractions[i].zip_map(incident * group.incident_scale, error_of_fraction)
        };
        let error: Vec<Bands> = parallel::collect(zones.len(), one);
        sum.iter_mut().zip(&error).for_each(|(s, e)| *s += e);
        group.error = errors_like(&group.incident, &error, group.incident_scale);
    }
    sum
}

/// Errors over `scale`, in the precision of `values`.
pub(crate) fn errors_like(values: &ZoneValues, errors: &[Bands], scale: Bands) -> ZoneValues {
    let own = |e: &Bands| e / scale;
    match values {
        ZoneValues::Double(_) => ZoneValues::Double(errors.iter().map(own).collect()),
        ZoneValues::Single(_) => {
            ZoneValues::Single(errors.iter().map(|e| own(e).map(|x| x as f32)).collect())
        }
    }
}
