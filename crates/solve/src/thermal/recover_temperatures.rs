//! Temperatures, net powers and their errors from the incident flux.
//!
//! **Errors.** With the propagated errors δh' of `error_propagation`, δq = Σ_b m_b a_b δh'_b for a zone of known temperature and
//! δE = δq/Σ_b m_b a_b ψ_b, δT = T δE/(4E) for one of known power. Sums by name add up all errors as if they had one sign, and the power that the
//! solver left undistributed.

use super::boundary_conditions::set_emissive_powers;
use super::heat_table::{self, ZoneSums};
use super::zone_balance::{ZoneBalance, ZoneBalances};
use crate::errors::consistency;
use crate::report::energy_balance::balance_zones;
use rayon::prelude::*;
use zonal_scene::thermal::blackbody_temperature;
use zonal_scene::{
    Band, BandFractions, Bands, Diagnostic, ErrorEstimate, Fields, LightGroup, Report, Scene,
    ThermalCondition, ThermalFields, Zones,
};

/// Residual of the balance, over the absorbed power, that rounding leaves.
const ROUNDING_OF_BALANCE: f64 = 1e-12;

/// Gives the zones the emission of the temperatures found, and adds temperatures, net powers and the table by name. No effect in light mode.
pub(crate) fn recover_temperatures(
    scene: &Scene,
    zones: &mut Zones,
    fields: &mut Fields,
    groups: &mut [LightGroup],
    report: &mut Report,
) {
    let Some(thermal) = scene.thermal() else { return };
    let fractions = &thermal.band_fractions;
    let balances = ZoneBalances::new(scene, zones).all(zones);
    let n = zones.len();
    // Find E and q of every zone, and widen the errors by the residual of the balance.
    let found: Vec<(f64, f64)> = (0..n)
        .into_par_iter()
        .map(|i| balances[i].emissive_and_net_power(fractions, balances[i].incident_flux(fields, i)))
        .collect();
    widen_by_heat_balance(&balances, fractions, &found, groups, (&*report, &mut *fields));
    // Convert them to temperatures and net powers with errors.
    let errors = zone_errors(&balances, fractions, &found, fields);
    let heat = thermal_fields(&found, &errors);
    report.warnings.extend(undefined_temperatures(&balances, fractions, &heat));
    // Give the zones their emission, and recompute radiosity and balance.
    let emissive: Vec<Bands> =
        found.iter().map(|x| fractions.emissive_powers(if x.0.is_nan() { 0.0 } else { x.0 })[0]).collect();
    set_emissive_powers(scene, zones, &emissive);
    let radiosity = |i: usize| {
        let (l, h) = (&balances[i], balances[i].incident_flux(fields, i));
        l.absorb * emissive[i] + l.reflect * h
    };
    fields.radiosity = (0..n).into_par_iter().map(radiosity).collect();
    report.energy = Default::default();
    for g in groups.iter_mut() {
        g.energy = balance_zones(scene, zones, &fields.incident, &g.energy);
        report.energy.add(&g.energy);
    }
    // Sum by name.
    let of_zone = |i: usize, size: f64| {
        let ([dq, de], (e, q)) = (errors[i], found[i]);
        let emissive = if e >= 0.0 { [size, size * e, size * de] } else { [0.0; 3] };
        ZoneSums { size, emissive, power: [size * q, size * dq] }
    };
    let undistributed = undistributed_power(&balances, fractions, &emissive, report);
    report.estimate = ErrorEstimate::of(fields, zones.voxel_offset(), report.estimate.grade);
    report.energy_error = consistency::power_errors(zones, &report.energy, fields, |i| fields.error[i]);
    let rows = heat_table::rows(scene, zones, undistributed, of_zone);
    report.heat = Some(heat_table::heat_report(rows, fractions, &report.energy));
    fields.heat = Some(heat);
}

/// Power that the solver left undistributed, W.
fn undistributed_power(
    balances: &[ZoneBalance],
    fractions: &BandFractions,
    emissive: &[Bands],
    report: &Report,
) -> f64 {
    let emitted = |i: usize| {
        let m = balances[i].absorption_weight();
        balances[i].measure * fractions.total(m * emissive[i].abs())
    };
    (0..balances.len()).map(emitted).sum::<f64>()
        * report.residuals.iter().filter_map(|r| r.last()).fold(0.0f64, |m, r| m.max(*r))
}

/// Errors of every zone: δq of a known temperature, or δE of a known power.
fn zone_errors(
    balances: &[ZoneBalance],
    fractions: &BandFractions,
    found: &[(f64, f64)],
    fields: &Fields,
) -> Vec<[f64; 2]> {
    let error = |i: usize| {
        let (l, e) = (&balances[i], fields.error[i]);
        let m = l.absorption_weight();
        let q = fractions.total(m * l.incident_share * e);
        if matches!(l.condition, ThermalCondition::Temperature(_)) {
            return [q, 0.0];
        }
        let slope = fractions.emissive_powers(found[i].0.max(0.0))[1];
        [0.0, q / fractions.total(m * slope.map(|s| s.max(0.0)))]
    };
    (0..balances.len()).into_par_iter().map(error).collect()
}

/// Temperatures and net powers with errors, from E and q of every zone and their errors.
fn thermal_fields(found: &[(f64, f64)], errors: &[[f64; 2]]) -> ThermalFields {
    let kelvin = |e: f64, de: f64| if e > 0.0 { 0.25 * blackbody_temperature(e) * de / e } else { f64::NAN };
    ThermalFields {
        temperature: found.iter().map(|x| blackbody_temperature(x.0)).collect(),
        temperature_error: found.iter().zip(errors).map(|(x, d)| kelvin(x.0, d[1])).collect(),
        net: found.iter().map(|x| x.1).collect(),
        net_error: errors.iter().map(|d| d[0]).collect(),
    }
}

/// Sum of the net powers of all zones (found: E, q), of the surroundings and of black backs, which is 0 in an exact balance, W.
fn imbalance(
    balances: &[ZoneBalance],
    fractions: &BandFractions,
    found: &[(f64, f64)],
    groups: &[LightGroup],
) -> f64 {
    let zones: f64 = balances.iter().zip(found).map(|(l, x)| l.measure * x.1).sum();
    let outside = |g: &LightGroup| {
        let e = &g.energy;
        fractions.total(e.incoming - e.escaped - e.absorbed_backfaces)
    };
    (zones + groups.iter().map(outside).sum::<f64>()).abs()
}

/// Distributes the residual of the heat balance beyond the stated errors, in proportion to the power absorbed by the zones of known temperature.
fn widen_by_heat_balance(
    balances: &[ZoneBalance],
    fractions: &BandFractions,
    found: &[(f64, f64)],
    groups: &[LightGroup],
    (report, fields): (&Report, &mut Fields),
) {
    // Zones of known power emit it in any case: a residual belongs to the zones of known temperature.
    let is_free = |l: &ZoneBalance| matches!(l.condition, ThermalCondition::Temperature(_));
    let explained = |i: usize| {
        let (l, m) = (&balances[i], balances[i].absorption_weight());
        l.measure * fractions.total(m * l.incident_share * fields.error[i])
    };
    let missing = imbalance(balances, fractions, found, groups);
    let known: f64 = (0..balances.len()).filter(|&i| is_free(&balances[i])).map(explained).sum();
    let excess = missing - known - fractions.total(report.energy_error.escaped);
    let absorbed = |i: usize, l: &ZoneBalance| {
        let (m, h) = (l.absorption_weight(), l.incident_flux(fields, i));
        l.measure * fractions.total(m * h.abs())
    };
    let all: f64 = balances.iter().enumerate().filter(|(_, l)| is_free(l)).map(|(i, l)| absorbed(i, l)).sum();
    // An excess that is NaN gives an unknown error.
    let fraction = match excess <= ROUNDING_OF_BALANCE * all {
        true => return,
        false if all > 0.0 && excess.is_finite() => excess / all,
        false => f64::INFINITY,
    };
    consistency::distribute(Bands::splat(fraction), fields);
}

/// Diagnostics of zones without a temperature.
fn undefined_temperatures(
    balances: &[ZoneBalance],
    fractions: &BandFractions,
    heat: &ThermalFields,
) -> Vec<Diagnostic> {
    const REASONS: [&str; 4] = [
        "zones neither absorb nor emit: their temperature is undefined",
        "zones emit in no band with a fraction of the emission: their temperature is undefined",
        "zones have no temperature: more heat is extracted than arrives; use smaller negative powers",
        "zones have no temperature: almost no radiation arrives; use a lower solve.residual",
    ];
    let emitting = fractions.emitting_bands();
    let mut counts = [0; 4];
    for (l, _) in balances.iter().zip(&heat.temperature).filter(|(_, t)| t.is_nan()) {
        let m = l.absorption_weight();
        let reason = match l.condition {
            _ if m == Bands::ZERO => 0,
            _ if !Band::all().any(|b| emitting[b] && m[b] > 0.0) => 1,
            ThermalCondition::Flux(q) | ThermalCondition::Power(q) if q < 0.0 => 2,
            _ => 3,
        };
        counts[reason] += 1;
    }
    let found = counts.iter().zip(REASONS).filter(|(n, _)| **n > 0);
    found.map(|(n, why)| Diagnostic::warning("no-temperature", format!("{n} {why}"))).collect()
}
