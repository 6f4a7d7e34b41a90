//! Errors of zones whose rows hold little or no power, in light mode.
//!
//! Such a row has no value from which the missing part could be judged (`closure_error`). The true row sums to one at most, so that the incident
//! field is at most that of surroundings as bright as the brightest zone:
//!
//! ```text
//!     H_i ≤ M,   G_i ≤ 4M,        M = max(B of the sky, max_j B_j + ρ_j e_j over the other zones,
//!                                         (B_i − ρ_i H_i)/(1 − ρ_i) of the zones in question)
//!     e_i ≤ max(H_i, M − H_i)
//! ```
//!
//! with the stated errors e_j of the other zones (of volume zones a quarter), and the albedo in the place of ρ for volume zones. H without direct light,
//! whose reflection B holds. Sources of transparent zones and negative sources have no such bound.

use crate::context::SolveContext;
use crate::distribution::sum_order::SharedZones;
use crate::errors::propagation::errors_like;
use crate::settings::zone_power::{fluence_factor, reflected_fraction};
use zonal_math::parallel;
use zonal_scene::{Bands, Fields, LightGroup, Zones};

/// Missing fraction of the power that a row holds, above which the brightest zone bounds the error.
const MOSTLY_EMPTY: f64 = 1.0;

/// Bounds of the incident fields of zones with rows that hold little power.
#[derive(Clone, Debug, Default)]
pub(crate) struct EmptyRows {
    /// Zones, and the bands in which most of the row is missing (1, else 0).
    zones: Vec<(usize, Bands)>,
    /// M, W/m².
    brightest: Bands,
}

impl EmptyRows {
    /// The zones of which more than half of the row is missing, for missing fractions relative to what the rows hold.
    pub(crate) fn of(context: &SolveContext, fractions: &[Bands]) -> EmptyRows {
        let light = context.scene.thermal().is_none() && !context.shared_zones().has_negative_source();
        if !light || context.zones.has_transparent_sources() {
            return EmptyRows::default();
        }
        let mostly = |d: &Bands| d.map(|d| if d > MOSTLY_EMPTY { 1.0 } else { 0.0 });
        if parallel::all(fractions, |d| mostly(d) == Bands::ZERO) {
            return EmptyRows::default();
        }
        let rows = fractions.iter().map(mostly).enumerate();
        EmptyRows { zones: rows.filter(|(_, m)| *m != Bands::ZERO).collect(), brightest: Bands::ZERO }
    }

    /// Determines M from the fields and the radiosity `sky` of the surroundings, and limits the errors of these rows in the fields and in the groups.
    pub(crate) fn limit(
        &mut self,
        zones: SharedZones,
        sky: Bands,
        fields: &mut Fields,
        groups: &mut [LightGroup],
    ) {
        if !zones.any(|i| self.missing(i) != Bands::ZERO) {
            return;
        }
        let own = (0..zones.len()).fold(sky, |most, i| {
            let (b, rho, missing) = (fields.radiosity[i], reflected_fraction(&zones, i), self.missing(i));
            let reflected = rho.zip_map(fields.error[i] / fluence_factor(&zones, i), product);
            let rest = (b - zones.scattered(i, |k| fields.incident[k])).zip_map(1.0 - rho, share);
            most.max(Bands::from_fn(|k| if missing[k] > 0.0 { rest[k] } else { b[k] + reflected[k] }))
        });
        self.brightest = zones.order().over_processes(own, Bands::max);
        for &(i, missing) in &self.zones {
            let bound = self.bound(&zones, i, fields.incident[i]);
            let e = fields.error[i];
            fields.error[i] = Bands::from_fn(|k| if missing[k] > 0.0 { e[k].min(bound[k]) } else { e[k] });
        }
        for group in groups.iter_mut().filter(|g| !g.error.is_empty() && !self.zones.is_empty()) {
            let mut errors = group.errors(zones.len());
            for &(i, _) in &self.zones {
                let bound = self.bound(&zones, i, group.incident_at(i));
                errors[i] = errors[i].zip_map(bound, f64::min);
            }
            group.error = errors_like(&group.incident, &errors, group.incident_scale);
        }
    }

    /// Largest error of the field `h` of zone `i`, W/m².
    fn bound(&self, zones: &Zones, i: usize, h: Bands) -> Bands {
        (fluence_factor(zones, i) * self.brightest).zip_map(h, |most, h| (most - h).max(h))
    }

    /// The error of the field of zone `i` that its closure defect causes, at most `error`.
    pub(crate) fn limited(&self, zones: &Zones, i: usize, h: Bands, error: Bands) -> Bands {
        if self.missing(i) == Bands::ZERO { error } else { error.zip_map(self.bound(zones, i, h), f64::min) }
    }

    /// 1 in the bands in which most of the row of zone `i` is missing.
    fn missing(&self, i: usize) -> Bands {
        self.zones.binary_search_by_key(&i, |z| z.0).map_or(Bands::ZERO, |k| self.zones[k].1)
    }
}

/// A product in which nothing reflects nothing of an unknown error.
fn product(rho: f64, e: f64) -> f64 {
    if rho == 0.0 { 0.0 } else { rho * e }
}

/// A radiosity over an absorbed fraction; nothing remains nothing.
fn share(b: f64, absorbed: f64) -> f64 {
    if b <= 0.0 { 0.0 } else { b / absorbed.max(0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Patch 1 is hidden from everything by its row; patch 0 is the brightest. In the second case patch 1 is white but for a tenth and emits.
    #[test]
    fn the_brightest_zone_bounds_an_empty_row() {
        for (emission, reflectance, most) in [(0.0, 0.9, 7.5), (3.0, 0.9, 30.0), (3.0, 1.0, f64::INFINITY)] {
            let mut zones = crate::distribution::sum_order::tests::zones([1, 1, 1]);
            zones.patches[0].reflectance = Bands::splat(0.5);
            zones.patches[1].reflectance = Bands::splat(reflectance);
            zones.patches[1].emission = Bands::splat(emission);
            let n = zones.len();
            let mut fields = Fields {
                radiosity: vec![Bands::splat(1.0); n],
                incident: vec![Bands::splat(0.5); n],
                error: vec![Bands::splat(0.25); n],
                ..Fields::default()
            };
            fields.radiosity[0] = Bands::splat(7.0);
            fields.error[0] = Bands::splat(1.0);
            fields.radiosity[1] = Bands::splat(emission);
            fields.incident[1] = Bands::ZERO;
            fields.error[1] = Bands::splat(f64::INFINITY);
            let mut rows = EmptyRows { zones: vec![(1, Bands::splat(1.0))], brightest: Bands::ZERO };
            rows.limit(SharedZones::alone(&zones), Bands::ZERO, &mut fields, &mut []);
            let error = fields.error[1].first();
            assert!((error - most).abs() <= 1e-12 * most || error == most, "{error} for {most}");
            assert_eq!(fields.error[2].first(), 0.25, "other zones keep their errors");
            assert_eq!(rows.limited(&zones, 1, Bands::ZERO, Bands::splat(0.125)).first(), 0.125);
        }
    }
}
