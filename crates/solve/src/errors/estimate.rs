//! The relative error of a solution: over patches, and over volume zones.

use crate::distribution::sum_order::SharedZones;
use zonal_math::Grade;
use zonal_scene::{Bands, ErrorEstimate, Fields, SquareSums};

/// The estimate for the fields of some zones, those of other processes included.
pub(crate) fn error_estimate(zones: SharedZones, fields: &Fields, grade: Grade) -> ErrorEstimate {
    let patches = zones.patches.len();
    let value = |list: &[Bands], i: usize| list.get(i).copied().unwrap_or_default();
    let sums: [[Bands; 4]; 2] = zones.sum(|i| {
        let (error, incident) = (value(&fields.error, i), value(&fields.incident, i));
        let total_error = error + value(&fields.direct_error, i);
        let total = incident + value(&fields.direct, i);
        let own = [error, incident, total_error, total].map(|x| x * x);
        let none = [Bands::ZERO; 4];
        if i < patches { [own, none] } else { [none, own] }
    });
    let of = |[error, incident, total_error, total]: [Bands; 4]| SquareSums {
        error,
        incident,
        total_error,
        total,
    };
    ErrorEstimate::of_sums(sums.map(of), grade)
}
