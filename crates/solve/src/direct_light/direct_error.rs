//! Propagation of the errors of direct light to the reflected light and to the powers of the balance.
//!
//! With d the direct light of a zone, δ its error and K the product with the exchange areas, the first reflection errs by K(cρδ) if all errors have
//! one sign. The errors of shadow rays are independent from zone to zone; random signs ε = ±1 give K(cρεδ), whose mean square over zones and
//! draws is that of the error. With r the ratio of the root mean squares of both over a kind of zones (patches, volumes), e₁ the error of the first
//! reflection and H the incident field after any number of reflections,
//!
//! ```text
//!     e₁ = min( K(cρδ), max( rms over draws of K(cρεδ), 2 r K(cρδ) ) )        independent errors
//!     e₁ = K(cρδ)                                                             errors of exchange areas
//!     e  = e₁ + 2 H √(Σ (wρδ)²) / Σ wρd + H φ
//! ```
//!
//! with w the area of a zone or κV: later reflections mix the zones and err as the power of the first reflection does. φ is the relative error
//! that all zones of a light have in common ([`LightField::common_error`]). Cost: one product for each light group, three with shadow rays.

use super::light_field::{DirectLight, LightField};
use crate::errors::propagation::errors_like;
use crate::iteration::multivector;
use crate::light_groups::SourceGroup;
use crate::operator::ExchangeOperator;
use crate::solve_context::SolveContext;
use crate::zone_power::{absorption_area, interception_area, reflected_fraction};
use rayon::prelude::*;
use zonal_exchange::pair::scaled_radiosity_coefficient;
use zonal_math::low_discrepancy;
use zonal_scene::{Bands, EnergyBalance, Fields, LightGroup, Zones, bands};

/// Number of draws of signs; one for more than [`MAX_ZONES_FOR_DRAWS`] zones.
const SIGN_DRAWS: usize = 2;
const MAX_ZONES_FOR_DRAWS: usize = 100_000;
/// Bound of the error of a zone in multiples of the standard error.
const ERROR_MULTIPLE: f64 = 2.0;

/// Error of the direct light of a group, W/m²; empty without direct light.
pub(crate) fn group_error(source: &SourceGroup, direct: &DirectLight) -> Vec<Bands> {
    let own: Vec<&LightField> = lights_of(source, direct).collect();
    let Some(first) = own.first() else { return Vec::new() };
    let one = |i: usize| {
        own.iter().fold([0.0; 3], |s, l| {
            let e = l.error_of(i);
            bands(|b| s[b] + e[b])
        })
    };
    (0..first.fields.len()).into_par_iter().map(one).collect()
}

fn lights_of<'a>(source: &'a SourceGroup, direct: &'a DirectLight) -> impl Iterator<Item = &'a LightField> {
    direct.lights.iter().enumerate().filter(|(l, _)| source.has_light(*l)).map(|(_, x)| x)
}

/// Error δ of the direct light of several lights at every zone, W/m²: independent errors add up by squares, errors of exchange areas by amounts.
fn combined_error(lights: &[&LightField], zones: usize) -> Vec<Bands> {
    let error = |i: usize| {
        let (mut square, mut sum) = ([0.0; 3], [0.0; 3]);
        for l in lights {
            for b in 0..3 {
                match l.by_exchange {
                    true => sum[b] += l.error[i][b],
                    false => square[b] += l.error[i][b].powi(2),
                }
            }
        }
        bands(|b| sum[b] + square[b].sqrt())
    };
    (0..zones).into_par_iter().map(error).collect()
}

/// Error of the reflected light `incident` of a group, W/m², caused by the errors of its direct light; empty without direct light.
fn reflected_error(
    zones: &Zones,
    operator: &dyn ExchangeOperator,
    source: &SourceGroup,
    direct: &DirectLight,
    incident: &[Bands],
) -> Vec<Bands> {
    let n = zones.len();
    let own: Vec<&LightField> = lights_of(source, direct).filter(|l| l.fields.len() == n).collect();
    if own.is_empty() {
        return Vec::new();
    }
    let sampled = own.iter().any(|l| !l.by_exchange);
    let error = combined_error(&own, n);
    if error.par_iter().all(|e| *e == [0.0; 3]) && own.iter().all(|l| l.common_error == [0.0; 3]) {
        return Vec::new();
    }
    // Reflect the errors once with equal signs, and with random signs if they are independent.
    let reflection = ErrorReflection { zones, operator, error: &error };
    let mut first = reflection.of_draw(0);
    if sampled {
        reflection.limit_by_random_signs(&mut first);
    }
    let later = later_reflections(zones, &own, &error, sampled);
    let one = |i: usize| bands(|b| first[i][b] + later[b] * incident[i][b].abs());
    (0..n).into_par_iter().map(one).collect()
}

/// The first reflection of the errors of direct light.
struct ErrorReflection<'a> {
    zones: &'a Zones,
    operator: &'a dyn ExchangeOperator,
    /// δ, W/m².
    error: &'a [Bands],
}

impl ErrorReflection<'_> {
    /// |K(cρεδ)| over A or V, with equal signs for draw 0.
    fn of_draw(&self, draw: u64) -> Vec<Bands> {
        let (zones, n) = (self.zones, self.zones.len());
        let mut s: Vec<Bands> = (0..n)
            .into_par_iter()
            .map(|i| {
                let (c, (rho, _)) = (scaled_radiosity_coefficient(zones, i), zones.response(i));
                let is_negative = draw > 0 && low_discrepancy::split_mix64(draw << 48 | i as u64) & 1 == 1;
                let sign = if is_negative { -1.0 } else { 1.0 };
                bands(|b| sign * c[b] * rho[b] * self.error[i][b])
            })
            .collect();
        s.resize(self.operator.len(), [0.0; 3]);
        let mut p = self.operator.apply(&s);
        p.truncate(n);
        p.par_iter_mut().enumerate().for_each(|(i, p)| *p = p.map(|p| p.abs() / zones.response(i).1));
        p
    }

    /// Limits the errors `first` of equal signs by draws of random signs (module header).
    fn limit_by_random_signs(&self, first: &mut [Bands]) {
        let (zones, n) = (self.zones, self.zones.len());
        let draws = if n > MAX_ZONES_FOR_DRAWS { 1 } else { SIGN_DRAWS };
        let mut mean = vec![[0.0; 3]; n];
        for k in 1..=draws {
            let one = self.of_draw(k as u64);
            mean.par_iter_mut().zip(one).for_each(|(m, x)| *m = bands(|b| m[b] + x[b] * x[b] / draws as f64));
        }
        for range in [0..zones.voxel_offset(), zones.voxel_offset()..n] {
            let start = range.start;
            let sums: [f64; 6] = multivector::sum(range.len(), |k| {
                let (m, l) = (mean[start + k], first[start + k]);
                [m[0], m[1], m[2], l[0] * l[0], l[1] * l[1], l[2] * l[2]]
            });
            let ratio = bands(|b| if sums[3 + b] > 0.0 { (sums[b] / sums[3 + b]).sqrt() } else { 0.0 });
            first[range].par_iter_mut().enumerate().for_each(|(k, l)| {
                let m = mean[start + k];
                *l = bands(|b| l[b].min(m[b].sqrt().max(ERROR_MULTIPLE * ratio[b] * l[b])));
            });
        }
    }
}

/// Relative error of the incident field after more than one reflection, with the error that all zones have in common.
fn later_reflections(zones: &Zones, own: &[&LightField], error: &[Bands], sampled: bool) -> Bands {
    let sums: [f64; 9] = multivector::sum(error.len(), |i| {
        let (w, rho) = (interception_area(zones, i), reflected_fraction(zones, i));
        std::array::from_fn(|k| {
            let b = k % 3;
            let wr = w[b] * rho[b];
            let field = |l: &&LightField| l.fields[i][b];
            match k / 3 {
                0 if sampled => (wr * error[i][b]).powi(2),
                0 => wr * error[i][b],
                1 => wr * own.iter().map(field).sum::<f64>(),
                _ => wr * own.iter().map(|l| l.common_error[b] * field(l)).sum::<f64>(),
            }
        })
    });
    bands(|b| {
        let first = if sampled { ERROR_MULTIPLE * sums[b].sqrt() } else { sums[b] };
        if sums[3 + b] > 0.0 { (first + sums[6 + b]) / sums[3 + b] } else { 0.0 }
    })
}

/// Adds the errors of reflected light caused by direct light to the errors of all light and of each group.
pub(crate) fn propagate_to_groups(
    context: &SolveContext,
    operator: &dyn ExchangeOperator,
    fields: &mut Fields,
    groups: &mut [LightGroup],
) {
    let zones = context.zones;
    for (source, group) in context.sources.iter().zip(groups) {
        let mut incident = vec![[0.0; 3]; zones.len()];
        group.incident.add_to(&mut incident, group.incident_scale);
        let more = reflected_error(zones, operator, source, context.direct, &incident);
        fields.error.iter_mut().zip(&more).for_each(|(f, e)| *f = bands(|b| f[b] + e[b]));
        if !more.is_empty() && !group.error.is_empty() {
            let mut own = vec![[0.0; 3]; zones.len()];
            group.error.add_to(&mut own, group.incident_scale);
            own.iter_mut().zip(&more).for_each(|(o, e)| *o = bands(|b| o[b] + e[b]));
            group.error = errors_like(&group.incident, &own, group.incident_scale);
        }
    }
}

/// Standard errors of the powers that the lights send in, lose to the outside and lose on black backs, by rays from the lights, W.
pub(crate) fn light_power_errors(direct: &DirectLight) -> [Bands; 3] {
    let mut square = [[0.0; 3]; 3];
    for l in &direct.lights {
        for (s, e) in square.iter_mut().zip(l.power_error) {
            *s = bands(|b| s[b] + e[b] * e[b]);
        }
    }
    square.map(|s| s.map(f64::sqrt))
}

/// Error of the power that some zones absorb of the direct light, W: independent errors by squares, [`ERROR_MULTIPLE`] times; common errors and
/// errors of exchange areas by amounts.
fn absorbed_power_error(zones: &Zones, direct: &DirectLight, list: &mut dyn Iterator<Item = usize>) -> Bands {
    let (mut square, mut sum) = ([0.0; 3], [0.0; 3]);
    for i in list {
        let a = absorption_area(zones, i);
        for l in &direct.lights {
            for b in 0..3 {
                let own = a[b] * l.error[i][b];
                match l.by_exchange {
                    true => sum[b] += own,
                    false => square[b] += own * own,
                }
                sum[b] += a[b] * l.common_error[b] * l.fields[i][b].abs();
            }
        }
    }
    bands(|b| sum[b] + ERROR_MULTIPLE * square[b].sqrt())
}

/// Adds the errors of direct light to the errors of the powers of a balance.
pub(crate) fn add_to_power_errors(
    zones: &Zones,
    energy: &EnergyBalance,
    direct: &DirectLight,
    out: &mut EnergyBalance,
) {
    if direct.lights.is_empty() {
        return;
    }
    // Absorbed powers by name.
    let mut all = [0.0; 3];
    let mut add = |row: &mut Bands, list: &mut dyn Iterator<Item = usize>| {
        let more = absorbed_power_error(zones, direct, list);
        *row = bands(|b| row[b] + more[b]);
        all = bands(|b| all[b] + more[b]);
    };
    let mut of_surface = vec![Vec::new(); out.absorbed_surfaces.len()];
    zones.patches.iter().enumerate().for_each(|(i, p)| of_surface[p.surface].push(i));
    for (row, list) in out.absorbed_surfaces.iter_mut().zip(of_surface) {
        add(&mut row.1, &mut list.into_iter());
    }
    add(&mut out.absorbed_volumes, &mut (zones.voxel_offset()..zones.pane_offset()));
    add(&mut out.absorbed_panes, &mut (zones.pane_offset()..zones.len()));
    // Powers exchanged with the outside.
    let [sent, escaped, backs] = light_power_errors(direct);
    let enters = energy.incoming != [0.0; 3];
    out.incoming = bands(|b| out.incoming[b] + if enters { ERROR_MULTIPLE * sent[b] } else { 0.0 });
    let leaving = |error: Bands, power: Bands, own: Bands| {
        bands(|b| if power[b] == 0.0 { error[b] } else { error[b] + all[b] + ERROR_MULTIPLE * own[b] })
    };
    out.escaped = leaving(out.escaped, energy.escaped, escaped);
    out.absorbed_backfaces = leaving(out.absorbed_backfaces, energy.absorbed_backfaces, backs);
}
