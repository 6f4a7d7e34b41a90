//! Temperatures, net powers and their errors from the incident flux.
//!
//! **Errors.** With the propagated errors δh' of `error_propagation`, δq = Σ_b m_b a_b δh'_b for a zone of known temperature and
//! δE = δq/Σ_b m_b a_b ψ_b, δT = T δE/(4E) for one of known power. Sums by name add up all errors as if they had one sign, and the power that the
//! solver left undistributed. The errors of a node follow from those of all zones of its links, δE = N Σ V m a δh' (header of `nodes`); a zone of it has
//! δq = m a (δh' + ψ δE).

use super::boundary_conditions::set_emissive_powers;
use super::heat_table::{self, ZoneSums};
use super::nodes::NodeZones;
use super::spectral_balance::{BlockZones, SpectralBalances};
use crate::balance::energy_balance::balance_zones;
use crate::context::zonal_solution::ZonalSolution;
use crate::distribution::sum_order::SharedZones;
use crate::errors::consistency;
use crate::errors::estimate::error_estimate;
use zonal_math::parallel;
use zonal_scene::thermal::blackbody_temperature;
use zonal_scene::{
    Band, Bands, Diagnostic, EnergyBalance, Fields, HeatReport, Scene, ThermalCondition, ThermalFields,
};

/// Residual of the balance, over the absorbed and the net powers of all zones, that rounding leaves.
const ROUNDING_OF_BALANCE: f64 = 1e-12;

/// Gives the zones the emission of the temperatures found, and adds temperatures, net powers and the table by name to the first block of bands. No
/// effect in light mode. Returns the residual of the heat balance, W, that the stated errors explain.
pub(crate) fn recover_temperatures(blocks: &mut [ZonalSolution]) -> f64 {
    let scenes: Vec<Scene> = blocks.iter().map(|t| t.scene.clone()).collect();
    if scenes[0].thermal().is_none() {
        return 0.0;
    }
    let parts = scenes.iter().zip(&*blocks).map(|(scene, t)| BlockZones { scene, zones: &t.zones });
    let balances = SpectralBalances::new(&parts.collect::<Vec<_>>());
    let n = balances.len();
    // Find E and q of every zone, and widen the errors by the residual of the balance.
    let surfaces: Vec<usize> = blocks[0].zones.patches.iter().map(|p| p.surface).collect();
    let nodes = NodeZones::new(&balances, &surfaces);
    let (found, of_nodes) = find_zones(&balances, nodes.as_ref(), blocks);
    let explained = widen_by_heat_balance(&balances, &found, blocks);
    // Convert them to temperatures and net powers with errors.
    let node_errors = nodes.as_ref().map_or_else(Vec::new, |n| node_errors(&balances, n, &of_nodes, blocks));
    let errors = zone_errors(&balances, &found, blocks, &node_errors);
    let heat = thermal_fields(&found, &errors);
    blocks[0].report.warnings.extend(undefined_temperatures(&balances, &heat));
    // Give the zones their emission, and recompute radiosity and balance.
    let energy = |i: usize| if found[i].0.is_nan() { 0.0 } else { found[i].0 };
    let of_block = |t: usize| (0..n).map(|i| balances.emissive_powers(t, i, energy(i))).collect();
    let emissive: Vec<Vec<Bands>> = (0..scenes.len()).map(of_block).collect();
    blocks.iter_mut().enumerate().for_each(|(t, own)| set_emission(&balances, t, own, &emissive[t]));
    // Sum by name.
    let sunlight = absorbed_sunlight(&balances, blocks);
    let of_zone = |i: usize, size: f64| {
        let ([dq, de], (e, q)) = (errors[i], found[i]);
        let emissive = if e >= 0.0 { [size, size * e, size * de] } else { [0.0; 3] };
        ZoneSums { size, emissive, power: [size * q, size * dq], sunlight: size * sunlight[i] }
    };
    let undistributed = undistributed_power(&balances, &emissive, blocks);
    blocks.iter_mut().for_each(estimate_errors);
    let radiated = |i: usize| balances.first(i).measure * found[i].1;
    let node_results = heat_table::nodes(nodes.as_ref(), &of_nodes, &node_errors, radiated);
    let rows = heat_table::rows(&scenes[0], &blocks[0].zones, undistributed, of_zone);
    let total = |power: fn(&EnergyBalance) -> Bands| balances.total(|t| power(&blocks[t].report.energy));
    let outside = [total(|e| e.incoming - e.escaped), total(|e| e.absorbed_backfaces)];
    blocks[0].report.heat = Some(HeatReport {
        rows,
        nodes: node_results,
        surroundings: outside[0],
        absorbed_backfaces: outside[1],
        emitters: balances.total(|t| blocks[t].emitters),
    });
    blocks[0].fields.heat = Some(heat);
    explained
}

/// Sets the errors in the report of a block from those of its fields.
fn estimate_errors(own: &mut ZonalSolution) {
    let (zones, fields) = (&own.zones, &own.fields);
    own.report.estimate = error_estimate(SharedZones::alone(zones), fields, own.report.estimate.grade);
    own.report.energy_error =
        consistency::power_errors(SharedZones::alone(zones), &own.report.energy, fields, |i| {
            fields.total_error(i)
        });
}

/// Sunlight that every zone absorbs, W/m² or W/m³; 0 without.
fn absorbed_sunlight(balances: &SpectralBalances, blocks: &[ZonalSolution]) -> Vec<f64> {
    let bands = blocks[0].scene.bands();
    let of_zone = |i: usize| {
        let absorbed = |t: usize| {
            let own = bands.in_solar_band(t, 1.0);
            own * balances.zones[t][i].absorption_weight()
                * balances.first(i).incident_flux(&blocks[t].fields, i)
        };
        (0..blocks.len()).map(|t| absorbed(t).sum()).sum()
    };
    if bands.has_solar_band() {
        (0..balances.len()).map(of_zone).collect()
    } else {
        vec![0.0; balances.len()]
    }
}

/// E and q of every zone, and E of every node.
fn find_zones(
    balances: &SpectralBalances,
    nodes: Option<&NodeZones>,
    blocks: &[ZonalSolution],
) -> (Vec<(f64, f64)>, Vec<f64>) {
    let fields: Vec<&Fields> = blocks.iter().map(|t| &t.fields).collect();
    let incident = |t: usize, i: usize| balances.first(i).incident_flux(fields[t], i);
    let of_nodes = nodes.map_or_else(Vec::new, |nodes| nodes.found(balances, incident));
    let find = |i: usize| match balances.first(i).node {
        Some(k) => {
            let e = of_nodes[k as usize];
            (e, balances.weighted_total(i, |t| balances.emissive_powers(t, i, e) - incident(t, i)))
        }
        None => balances.emissive_and_net_power(i, |t| incident(t, i)),
    };
    (parallel::collect(balances.len(), find), of_nodes)
}

/// δE of every node with the emissive powers `e`, W/m².
fn node_errors(
    balances: &SpectralBalances,
    nodes: &NodeZones,
    e: &[f64],
    blocks: &[ZonalSolution],
) -> Vec<f64> {
    let fields: Vec<&Fields> = blocks.iter().map(|t| &t.fields).collect();
    let share = |t: usize, i: usize| balances.first(i).incident_share * fields[t].total_error(i);
    nodes.linearize(balances, e).response(&nodes.absorbed(balances, share))
}

/// Gives the zones of block `t` their emission, and recomputes radiosity and balance.
fn set_emission(balances: &SpectralBalances, t: usize, own: &mut ZonalSolution, emissive: &[Bands]) {
    set_emissive_powers(&own.scene, &mut own.zones, emissive);
    let (fields, zones) = (&own.fields, &balances.zones[t]);
    let radiosity = |i: usize| {
        let (l, h) = (&zones[i], zones[i].incident_flux(fields, i));
        l.absorb * emissive[i] + l.reflect * h
    };
    own.fields.radiosity = parallel::collect(zones.len(), radiosity);
    own.report.energy = Default::default();
    let incident = [own.fields.incident.as_slice(), &own.fields.direct];
    for g in own.groups.iter_mut() {
        g.energy =
            balance_zones(&own.scene, SharedZones::alone(&own.zones), incident, &g.energy, own.emitters);
        own.report.energy.add(&g.energy);
    }
}

/// Power that the solver left undistributed, W.
fn undistributed_power(
    balances: &SpectralBalances,
    emissive: &[Vec<Bands>],
    blocks: &[ZonalSolution],
) -> f64 {
    let emitted = |i: usize| balances.first(i).measure * balances.weighted_total(i, |t| emissive[t][i].abs());
    let residuals = blocks.iter().flat_map(|t| &t.report.residuals);
    (0..balances.len()).map(emitted).sum::<f64>()
        * residuals.filter_map(|r| r.last()).fold(0.0f64, |m, r| m.max(*r))
}

/// Errors of every zone: δq of a known temperature, δE of a known power, both of a zone with a node or convection. `node_errors` are δE of the nodes.
fn zone_errors(
    balances: &SpectralBalances,
    found: &[(f64, f64)],
    blocks: &[ZonalSolution],
    node_errors: &[f64],
) -> Vec<[f64; 2]> {
    let fields: Vec<&Fields> = blocks.iter().map(|t| &t.fields).collect();
    let error = |i: usize| {
        let l = balances.first(i);
        let q = balances.total(|t| {
            balances.zones[t][i].absorption_weight() * l.incident_share * fields[t].total_error(i)
        });
        if matches!(l.condition, ThermalCondition::Temperature(_)) {
            return [q, 0.0];
        }
        let e = found[i].0.max(0.0);
        let slope = |t: usize| balances.fractions(t, i).emissive_powers(e)[1].map(|s| s.max(0.0));
        let emitted = balances.weighted_total(i, slope);
        if let Some(k) = l.node {
            let error = node_errors[k as usize];
            return [q + emitted * error, error];
        }
        let convected = l.convected(e)[1];
        // A zone that neither absorbs nor gives heat has a known net power, and no temperature.
        if q == 0.0 && emitted + convected == 0.0 {
            return [0.0; 2];
        }
        let error = q / (emitted + convected);
        [convected * error, error]
    };
    parallel::collect(balances.len(), error)
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

/// Power that leaves the scene or ends on black backs, W.
fn leaving_power(balances: &SpectralBalances, blocks: &[ZonalSolution]) -> f64 {
    let of = |g: usize| {
        balances.total(|t| blocks[t].groups[g].energy.escaped + blocks[t].groups[g].energy.absorbed_backfaces)
    };
    (0..blocks[0].groups.len()).map(of).sum()
}

/// Sum of the net powers of all zones (found: E, q), of the surroundings, of emitters and of black backs, which is 0 in an exact balance, W.
fn imbalance(balances: &SpectralBalances, found: &[(f64, f64)], blocks: &[ZonalSolution]) -> f64 {
    let zones: f64 = found.iter().enumerate().map(|(i, x)| balances.first(i).measure * x.1).sum();
    let outside = |g: usize| {
        balances.total(|t| {
            let e = &blocks[t].groups[g].energy;
            e.incoming - e.escaped - e.absorbed_backfaces
        })
    };
    let emitters = balances.total(|t| blocks[t].emitters);
    (zones + emitters + (0..blocks[0].groups.len()).map(outside).sum::<f64>()).abs()
}

/// Distributes the residual of the heat balance beyond the stated errors, in proportion to the power absorbed by the zones of known temperature, or to the power
/// that leaves the scene if there are none. Returns the residual that the stated errors explain, W.
fn widen_by_heat_balance(
    balances: &SpectralBalances,
    found: &[(f64, f64)],
    blocks: &mut [ZonalSolution],
) -> f64 {
    // Zones of known power emit it in any case: a residual belongs to the zones of known temperature, of nodes and with convection.
    let is_free = |i: &usize| {
        let l = balances.first(*i);
        matches!(l.condition, ThermalCondition::Temperature(_)) || l.node.is_some() || l.convection.is_some()
    };
    let (fraction, explained) = {
        let blocks = &*blocks;
        let explained = |i: usize| {
            let l = balances.first(i);
            let error = |t: usize| l.incident_share * blocks[t].fields.total_error(i);
            l.measure * balances.total(|t| balances.zones[t][i].absorption_weight() * error(t))
        };
        let missing = imbalance(balances, found, blocks);
        let known: f64 = (0..balances.len()).filter(is_free).map(explained).sum();
        let explained = known + balances.total(|t| blocks[t].report.energy_error.escaped);
        let excess = missing - explained;
        let absorbed = |i: usize| {
            let l = balances.first(i);
            l.measure * balances.weighted_total(i, |t| l.incident_flux(&blocks[t].fields, i).abs())
        };
        let all = match (0..balances.len()).filter(is_free).map(absorbed).sum() {
            0.0 => match leaving_power(balances, blocks) {
                leaving if excess <= consistency::MAX_SHARE_OF_LEAVING * leaving => leaving,
                _ => 0.0,
            },
            all => all,
        };
        let net = |i: usize| balances.first(i).measure * found[i].1.abs();
        let exchanged: f64 = (0..balances.len()).map(|i| absorbed(i) + net(i)).sum();
        // An excess that is NaN gives an unknown error.
        if excess <= ROUNDING_OF_BALANCE * exchanged {
            return explained;
        }
        let is_known = all > 0.0 && excess.is_finite();
        (if is_known { excess / all } else { f64::INFINITY }, explained)
    };
    blocks.iter_mut().for_each(|t| consistency::distribute(Bands::splat(fraction), &mut t.fields));
    explained
}

/// Diagnostics of zones without a temperature.
fn undefined_temperatures(balances: &SpectralBalances, heat: &ThermalFields) -> Vec<Diagnostic> {
    const REASONS: [&str; 4] = [
        "zones neither absorb nor emit: their temperature is undefined",
        "zones emit in no band with a fraction of the emission: their temperature is undefined",
        "zones have no temperature: more heat is extracted than arrives; use smaller negative powers",
        "zones have no temperature: almost no radiation arrives; use a lower solve.residual",
    ];
    let mut counts = [0; 4];
    for i in (0..balances.len()).filter(|&i| heat.temperature[i].is_nan()) {
        let blocks = 0..balances.blocks();
        let weight = |t: usize| balances.zones[t][i].absorption_weight();
        let emits = |t: usize| {
            let emitting = balances.fractions(t, i).emitting_bands();
            Band::all().any(|b| emitting[b] && weight(t)[b] > 0.0)
        };
        let reason = match balances.first(i).condition {
            _ if blocks.clone().all(|t| weight(t) == Bands::ZERO) => 0,
            _ if !blocks.clone().any(emits) => 1,
            ThermalCondition::Flux(q) | ThermalCondition::Power(q) if q < 0.0 => 2,
            _ => 3,
        };
        counts[reason] += 1;
    }
    let found = counts.iter().zip(REASONS).filter(|(n, _)| **n > 0);
    found.map(|(n, why)| Diagnostic::warning("no-temperature", format!("{n} {why}"))).collect()
}
