//! Propagation of the errors of factors, rows and sampled surroundings to the incident fields and to the powers of a solution.

use super::closure_error::error_of_fraction;
use crate::iteration::{IterationResult, multivector};
use crate::operator::ErrorModel;
use crate::surroundings::SurroundingsExchange;
use rayon::prelude::*;
use zonal_exchange::pair::closure_target;
use zonal_scene::{Bands, LightGroup, ZoneValues, Zones, bands};

/// Standard error of the power that escapes, from the independent rays of each zone, W a band.
pub(crate) fn escaped_power_error(
    zones: &Zones,
    surroundings: &SurroundingsExchange,
    results: &[IterationResult],
) -> Bands {
    if surroundings.is_closed() || surroundings.rays == 0 {
        return [0.0; 3];
    }
    let one = |i: usize| {
        let (t, sent) = (
            closure_target(zones, i),
            results.iter().fold([0.0; 3], |s, e| bands(|b| s[b] + e.strengths[i][b])),
        );
        let fraction = surroundings.escape_fraction_error(i, t);
        bands(|b| (fraction[b] * t * sent[b]).powi(2))
    };
    multivector::sum::<3>(zones.len(), one).map(f64::sqrt)
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
    let mut sum = vec![[0.0; 3]; zones.len()];
    for (group, result) in groups.iter_mut().zip(results) {
        let power = operator.error(&result.strengths).unwrap_or_else(|| vec![[0.0; 3]; zones.len()]);
        let one = |i: usize| {
            let (e, incident) = (power[i].map(|e| e / zones.response(i).1), group.incident.at(i));
            bands(|b| e[b] + error_of_fraction(fractions[i][b], incident[b] * group.incident_scale[b]))
        };
        let error: Vec<Bands> = (0..zones.len()).into_par_iter().map(one).collect();
        sum.iter_mut().zip(&error).for_each(|(s, e)| *s = bands(|b| s[b] + e[b]));
        group.error = errors_like(&group.incident, &error, group.incident_scale);
    }
    sum
}

/// Errors over `scale`, in the precision of `values`.
pub(crate) fn errors_like(values: &ZoneValues, errors: &[Bands], scale: Bands) -> ZoneValues {
    let own = |e: &Bands| bands(|b| e[b] / scale[b]);
    match values {
        ZoneValues::Double(_) => ZoneValues::Double(errors.iter().map(own).collect()),
        ZoneValues::Single(_) => {
            ZoneValues::Single(errors.iter().map(|e| own(e).map(|x| x as f32)).collect())
        }
    }
}
