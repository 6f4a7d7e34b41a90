//! Errors that a solution reveals itself: power that does not balance, negative fluxes and an iteration that ends widen the stated errors.
//!
//! With h_i the field incident on zone i (direct light included), e_i its stated error, a_i the absorption area of the zone
//! (`zone_power::absorption_area`), and R the residual of the energy balance, emitted + incoming − absorbed − escaped:
//!
//! ```text
//!     closure          e_i ≥ |d_i| h_i            d_i: unexplained closure defect over the sum of the row
//!     iteration        e_i += 10 r/(1−r) (h_i + mean h)   r: undistributed fraction of the power
//!     negative flux    e_i ≥ −h_i                  where h_i < 0 without a negative source
//!     balance          e_i += f h_i,   f = (|R| − Σ_j a_j e_j)⁺ / Σ_j a_j h_j
//! ```
//!
//! The last rule assumes that factors lose or create power in proportion to the power that they carry, and distributes the part of R that the
//! stated errors do not explain in that proportion. If nothing absorbs, the power that leaves the scene stands in the place of Σ_j a_j h_j: a field
//! that is false by f lets f times as much escape. If that is more than [`MAX_SHARE_OF_LEAVING`], or if nothing leaves either, the errors are unknown (infinite).
//! The error of a sum by name is the sum of the errors of its zones, as if they had one sign; that of the escaping power is the error that the
//! rest of the balance leaves open.

use super::closure_error::error_of_fraction;
use crate::distribution::sum_order::SharedZones;
use crate::settings::zone_power::{absorbed_power, absorption_area, interception_area};
use zonal_math::parallel;
use zonal_scene::{Bands, EnergyBalance, Fields, LightGroup, SolveStatus};

/// Assumed number of reflections of undistributed power at one zone.
const REFLECTIONS_OF_UNDISTRIBUTED_POWER: f64 = 10.0;

/// Share of the power that leaves a scene in which nothing absorbs, up to which a residual is spread over the fields: a larger one shows defects whose places
/// are not known.
pub(crate) const MAX_SHARE_OF_LEAVING: f64 = 0.01;
/// Residual of the balance, over the power given, that rounding leaves.
const ROUNDING_OF_BALANCE: f64 = 1e-12;

/// Raises every error to at least the error of the missing fraction of the row.
pub(crate) fn widen_by_closure(fractions: &[Bands], fields: &mut Fields) {
    let incident = &fields.incident;
    parallel::for_each(&mut fields.error, |i, e| {
        *e = e.zip_map(fractions[i].abs().zip_map(incident[i], error_of_fraction), widest);
    });
}

/// The larger of two errors; infinite if one is not a number.
fn widest(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}

/// Adds the error of the iteration: the undistributed power, of a zone's own field and of the mean of its kind. A fixed number of orders has none.
pub(crate) fn widen_by_residual(zones: SharedZones, groups: &[LightGroup], fields: &mut Fields) {
    // The iterate holds 1 − r of the power, the remainder r.
    let factor =
        |r: f64| if r < 1.0 { REFLECTIONS_OF_UNDISTRIBUTED_POWER * r / (1.0 - r) } else { f64::INFINITY };
    for g in groups {
        let factors =
            Bands::from_fn(
                |b| if g.status[b] == SolveStatus::FixedOrder { 0.0 } else { factor(g.residual[b]) },
            );
        if factors == Bands::ZERO {
            continue;
        }
        let h = |i: usize| g.incident_at(i).abs();
        let patches = zones.patches.len();
        let sizes = [patches, zones.total() - patches].map(|n| n.max(1) as f64);
        let means: [Bands; 2] = zones.sum(|i| {
            if i < patches { [h(i) / sizes[0], Bands::ZERO] } else { [Bands::ZERO, h(i) / sizes[1]] }
        });
        parallel::for_each(&mut fields.error, |i, e| {
            let mean = means[usize::from(i >= patches)];
            *e = (*e + factors * (h(i) + mean)).map(|e| widest(e, 0.0));
        });
    }
}

/// Raises every error to at least the amount by which a flux is negative.
pub(crate) fn widen_by_negative_flux(fields: &mut Fields) {
    parallel::for_each_pair(&mut fields.error, &fields.incident, |e, h| *e = e.zip_map(-*h, widest));
}

/// Distributes the part of the balance's residual that neither the stated errors nor the error `lost` of the escaping power (W per band) explain.
pub(crate) fn widen_by_balance(zones: SharedZones, energy: &EnergyBalance, lost: Bands, fields: &mut Fields) {
    let missing = (energy.residual * (energy.emitted + energy.incoming)).abs();
    let explained = absorbed_power(zones, |i| fields.total_error(i));
    let absorbed = absorbed_power(zones, |i| total_incident(fields, i));
    let leaving = energy.escaped + energy.absorbed_backfaces;
    let fraction = Bands::from_fn(|b| {
        let given = energy.emitted[b] + energy.incoming[b];
        let excess = missing[b] - explained[b] - lost[b];
        if !missing[b].is_finite() {
            // Also if it is not a number.
            f64::INFINITY
        } else if excess <= ROUNDING_OF_BALANCE * given || explained[b].is_infinite() {
            0.0
        } else if absorbed[b] > 0.0 {
            excess / absorbed[b]
        } else if excess <= MAX_SHARE_OF_LEAVING * leaving[b] {
            excess / leaving[b]
        } else {
            f64::INFINITY
        }
    });
    distribute(fraction, fields);
}

/// Amount of the field incident on zone `i`, direct light included, W/m².
fn total_incident(fields: &Fields, i: usize) -> Bands {
    (fields.incident[i] + fields.direct_light(i)).abs()
}

/// Adds a fraction of the incident field to the error of every zone; an infinite fraction of 0 is infinite too.
pub(crate) fn distribute(fraction: Bands, fields: &mut Fields) {
    if fraction == Bands::ZERO {
        return;
    }
    for i in 0..fields.error.len() {
        let more = fraction.zip_map(total_incident(fields, i), error_of_fraction);
        fields.error[i] += more;
    }
}

/// Stated errors of the powers of a balance, W per band, for the `error` of each zone's incident field (W/m²).
///
/// Absorbed power: the sum of the errors of the zones. Incoming power: the root of the sum of squares, since each zone has rays of its own.
/// Escaping power: the errors of all other powers together. Emitted power has no error.
pub(crate) fn power_errors(
    zones: SharedZones,
    energy: &EnergyBalance,
    fields: &Fields,
    error: impl Fn(usize) -> Bands + Sync,
) -> EnergyBalance {
    let mut out = EnergyBalance {
        absorbed_surfaces: energy.absorbed_surfaces.iter().map(|s| (s.0.clone(), Bands::ZERO)).collect(),
        ..EnergyBalance::default()
    };
    for (i, p) in zones.patches.iter().enumerate() {
        out.absorbed_surfaces[p.surface].1 += absorption_area(&zones, i).zip_map(error(i), absorbed_error);
    }
    let of = |i: usize| absorption_area(&zones, i).zip_map(error(i), absorbed_error);
    out.absorbed_volumes = zones.sum_voxels(|k| of(zones.voxel_index(k)));
    out.absorbed_panes = (0..zones.panes.len()).fold(Bands::ZERO, |s, k| s + of(zones.pane_index(k)));
    let squares: Bands = zones.sum(|i| match fields.surroundings_error.get(i) {
        Some(error) => (interception_area(&zones, i) * *error).map(|e| e.powi(2)),
        None => Bands::ZERO,
    });
    out.incoming = squares.sqrt();
    let surfaces = out.absorbed_surfaces.iter().fold(Bands::ZERO, |s, x| s + x.1);
    let residual = energy.residual * (energy.emitted + energy.incoming);
    let all = surfaces + out.absorbed_volumes + out.absorbed_panes + out.incoming;
    let open = (all + residual.abs()).map(|e| widest(e, 0.0));
    // A power of exactly 0 has no error.
    let unless_zero =
        |power: Bands| power.zip_map(open, |power, error| if power == 0.0 { 0.0 } else { error });
    out.escaped = unless_zero(energy.escaped);
    out.absorbed_backfaces = unless_zero(energy.absorbed_backfaces);
    out
}

/// Amount of the residual of a balance that the stated errors of its powers explain, W per band, for the error `lost` of the escaping power: the errors of
/// [`power_errors`] of escaped power contain the residual and do not count.
pub(crate) fn explained_residual(stated: &EnergyBalance, lost: Bands) -> Bands {
    let absorbed = stated.absorbed_surfaces.iter().fold(Bands::ZERO, |s, x| s + x.1);
    absorbed + stated.absorbed_volumes + stated.absorbed_panes + stated.incoming + lost
}

/// Error of the power absorbed by a zone; 0 without absorption, also for an infinite error of its field.
fn absorbed_error(area: f64, error: f64) -> f64 {
    if area == 0.0 { 0.0 } else { widest(area * error, 0.0) }
}
