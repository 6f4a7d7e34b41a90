//! Propagation of the errors of direct light to the reflected light and to the powers of the balance.
//!
//! With d the direct light of a zone, δ its error and K the product with the exchange areas, the first reflection errs by K(cρδ) if all errors have
//! one sign. The errors of shadow rays are independent from zone to zone, and limited by random signs (`errors/random_signs.rs`). With e₁ the error of the
//! first reflection and H the incident field after any number of reflections,
//!
//! ```text
//!     e₁ = K(cρδ) limited by random signs        independent errors
//!     e₁ = K(cρδ)                                errors of exchange areas
//!     e  = e₁ + 2 H √(Σ (wρδ)²) / Σ wρd + H φ
//! ```
//!
//! with w the area of a zone or κV: later reflections mix the zones and err as the power of the first reflection does. φ is the relative error
//! that all zones of a light have in common ([`LightField::common_error`]). Cost: one product for each light group, three with shadow rays.

use crate::context::SolveContext;
use crate::distribution::multivector::VectorEntry;
use crate::distribution::sum_order::SharedZones;
use crate::errors::propagation::errors_like;
use crate::errors::random_signs::{ERROR_MULTIPLE, ErrorReflection};
use crate::operator::ExchangeOperator;
use crate::right_hand_side::direct_light::light_field::{DirectLight, LightField};
use crate::right_hand_side::light_groups::SourceGroup;
use crate::settings::zone_power::{absorption_area, interception_area, reflected_fraction};
use zonal_math::parallel;
use zonal_scene::{Bands, EnergyBalance, Fields, LightGroup, Zones};

/// Error of the direct light of a group, W/m²; empty without direct light.
pub(crate) fn group_error(source: &SourceGroup, direct: &DirectLight) -> Vec<Bands> {
    let own: Vec<&LightField> = lights_of(source, direct).collect();
    let Some(first) = own.first() else { return Vec::new() };
    let one = |i: usize| own.iter().fold(Bands::ZERO, |s, l| s + l.error_of(i));
    parallel::collect(first.fields.len(), one)
}

fn lights_of<'a>(source: &'a SourceGroup, direct: &'a DirectLight) -> impl Iterator<Item = &'a LightField> {
    direct.lights.iter().enumerate().filter(|(l, _)| source.has_light(*l)).map(|(_, x)| x)
}

/// Error δ of the direct light of several lights at every zone, W/m²: independent errors add up by squares, errors of exchange areas by amounts.
fn combined_error(lights: &[&LightField], zones: usize) -> Vec<Bands> {
    let error = |i: usize| {
        let (mut square, mut sum) = (Bands::ZERO, Bands::ZERO);
        for l in lights {
            if l.by_exchange { sum += l.error[i] } else { square += l.error[i].map(|e| e.powi(2)) }
        }
        sum + square.sqrt()
    };
    parallel::collect(zones, error)
}

/// Error of the reflected light `incident` of a group, W/m², caused by the errors of its direct light; empty without direct light.
pub(crate) fn reflected_error(
    zones: SharedZones,
    operator: &dyn ExchangeOperator,
    source: &SourceGroup,
    direct: &DirectLight,
    incident: &(dyn Fn(usize) -> Bands + Sync),
) -> Vec<Bands> {
    let n = zones.len();
    let own: Vec<&LightField> = lights_of(source, direct).filter(|l| l.fields.len() == n).collect();
    if own.is_empty() {
        return Vec::new();
    }
    let sampled = own.iter().any(|l| !l.by_exchange);
    let error = combined_error(&own, n);
    let is_exact = !zones.any(|i| error[i] != Bands::ZERO);
    if is_exact && own.iter().all(|l| l.common_error == Bands::ZERO) {
        return Vec::new();
    }
    // Reflect the errors once with equal signs, and with random signs if they are independent.
    let reflect = |sources: Vec<Bands>| operator.apply(&sources);
    let unknowns = operator.len();
    let reflection = ErrorReflection { zones: &zones, unknowns, error: &error, reflect: &reflect };
    let mut first = reflection.of_draw(0);
    if sampled {
        reflection.limit_by_random_signs(&mut first);
    }
    let later = later_reflections(zones, &own, &error, sampled);
    let one = |i: usize| first[i] + later * incident(i).abs();
    parallel::collect(n, one)
}

/// Relative error of the incident field after more than one reflection, with the error that all zones have in common.
fn later_reflections(zones: SharedZones, own: &[&LightField], error: &[Bands], sampled: bool) -> Bands {
    let [errors, light, common]: [Bands; 3] = zones.sum(|i| {
        let weight = interception_area(&zones, i) * reflected_fraction(&zones, i);
        let first = weight * error[i];
        let light = Bands::from_fn(|b| own.iter().map(|l| l.fields[i][b]).sum());
        let common = Bands::from_fn(|b| own.iter().map(|l| l.common_error[b] * l.fields[i][b]).sum());
        [if sampled { first.map(|e| e.powi(2)) } else { first }, weight * light, weight * common]
    });
    Bands::from_fn(|b| {
        let first = if sampled { ERROR_MULTIPLE * errors[b].sqrt() } else { errors[b] };
        if light[b] > 0.0 { (first + common[b]) / light[b] } else { 0.0 }
    })
}

/// How the errors of reflected direct light join those of the engine.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum ErrorSum {
    /// By amounts.
    Linear,
    /// By squares: the engine samples each zone by itself, independently of the shadow rays.
    Independent,
}

/// Adds the errors of reflected light caused by direct light to the errors of all light and of each group.
pub(crate) fn propagate_to_groups(
    context: &SolveContext,
    operator: &dyn ExchangeOperator,
    sum: ErrorSum,
    fields: &mut Fields,
    groups: &mut [LightGroup],
) {
    let zones = context.shared_zones();
    for (source, group) in context.sources.iter().zip(groups) {
        let incident = |i: usize| group.incident_at(i);
        let more = reflected_error(zones, operator, source, context.direct, &incident);
        let join = |a: &mut Bands, b: &Bands| match sum {
            ErrorSum::Linear => *a += *b,
            ErrorSum::Independent => *a = a.hypot(*b),
        };
        fields.error.iter_mut().zip(&more).for_each(|(f, e)| join(f, e));
        if !more.is_empty() && !group.error.is_empty() {
            let mut own = group.errors(zones.len());
            own.iter_mut().zip(&more).for_each(|(o, e)| join(o, e));
            group.error = errors_like(&group.incident, &own, group.incident_scale);
        }
    }
}

/// Standard errors of the powers that the lights send in, lose to the outside and lose on black backs, by rays from the lights, W.
pub(crate) fn light_power_errors(direct: &DirectLight) -> [Bands; 3] {
    let mut square = [Bands::ZERO; 3];
    for l in &direct.lights {
        for (s, e) in square.iter_mut().zip(l.power_error) {
            *s += e * e;
        }
    }
    square.map(Bands::sqrt)
}

/// Error of the power that some zones absorb of the direct light, W: independent errors by squares, [`ERROR_MULTIPLE`] times; common errors and
/// errors of exchange areas by amounts.
fn absorbed_power_error([square, sum]: [Bands; 2]) -> Bands {
    sum + ERROR_MULTIPLE * square.sqrt()
}

/// The terms of [`absorbed_power_error`] of zone `i`: squares of independent errors, and other errors.
fn absorbed_power_errors(zones: &Zones, direct: &DirectLight, i: usize) -> [Bands; 2] {
    let (mut square, mut sum) = (Bands::ZERO, Bands::ZERO);
    let a = absorption_area(zones, i);
    for l in &direct.lights {
        let own = a * l.error[i];
        if l.by_exchange {
            sum += own
        } else {
            square += own * own
        }
        sum += a * l.common_error * l.fields[i].abs();
    }
    [square, sum]
}

/// Adds the errors of direct light to the errors of the powers of a balance.
pub(crate) fn add_to_power_errors(
    zones: SharedZones,
    energy: &EnergyBalance,
    direct: &DirectLight,
    out: &mut EnergyBalance,
) {
    if direct.lights.is_empty() {
        return;
    }
    // Absorbed powers by name.
    let mut all = Bands::ZERO;
    let mut add = |row: &mut Bands, sums: [Bands; 2]| {
        let more = absorbed_power_error(sums);
        *row += more;
        all += more;
    };
    let errors = |i: usize| absorbed_power_errors(&zones, direct, i);
    let mut of_surface = vec![[Bands::ZERO; 2]; out.absorbed_surfaces.len()];
    let add_errors = |sums: &mut [Bands; 2], i: usize| *sums = sums.plus(errors(i));
    zones.patches.iter().enumerate().for_each(|(i, p)| add_errors(&mut of_surface[p.surface], i));
    out.absorbed_surfaces.iter_mut().zip(of_surface).for_each(|(row, sums)| add(&mut row.1, sums));
    add(&mut out.absorbed_volumes, zones.sum_voxels(|k| errors(zones.voxel_index(k))));
    let mut of_panes = [Bands::ZERO; 2];
    (0..zones.panes.len()).for_each(|k| add_errors(&mut of_panes, zones.pane_index(k)));
    add(&mut out.absorbed_panes, of_panes);
    // Powers exchanged with the outside.
    let [sent, escaped, backs] = light_power_errors(direct);
    let enters = energy.incoming != Bands::ZERO;
    out.incoming += if enters { ERROR_MULTIPLE * sent } else { Bands::ZERO };
    let leaving = |error: Bands, power: Bands, own: Bands| {
        Bands::from_fn(
            |b| if power[b] == 0.0 { error[b] } else { error[b] + all[b] + ERROR_MULTIPLE * own[b] },
        )
    };
    out.escaped = leaving(out.escaped, energy.escaped, escaped);
    out.absorbed_backfaces = leaving(out.absorbed_backfaces, energy.absorbed_backfaces, backs);
}
