//! What the error of direct light costs the indirect light that it becomes.
//!
//! With d the direct light of a zone, δ its error and K the product with the exchange areas, the first reflection errs by K(cρδ) where all errors have
//! one sign. Shadow rays err independently from zone to zone, which random signs ε = ±1 show: K(cρεδ), whose mean square over zones and
//! draws is that of the error. With r the ratio of the root mean squares of both over a kind of zones (patches, volumes), e₁ the error of the first
//! reflection and H what arrives of the light after any number of them,
//!
//! ```text
//!     e₁ = min( K(cρδ), max( rms over draws of K(cρεδ), 2 r K(cρδ) ) )        independent errors
//!     e₁ = K(cρδ)                                                             errors of exchange areas
//!     e  = e₁ + 2 H √(Σ (wρδ)²) / Σ wρd + H φ
//! ```
//!
//! w is a zone's area or κV: later reflections mix the zones, and err as the power reflected first does. φ is the relative error that all
//! zones of a light share ([`crate::direct::Lit::shared`]).

use crate::direct::{Direct, Lit};
use crate::energy::{section, sent_back, uptake};
use crate::engine::Site;
use crate::groups::{Source, response};
use crate::operator::Operator;
use crate::pipeline::like;
use rayon::prelude::*;
use zonal_exchange::pair::strength;
use zonal_math::sequence;
use zonal_scene::solution::Energy;
use zonal_scene::{Bands, Fields, Group, Zones, bands};

/// Draws of signs; one where zones are more than [`MANY_ZONES`].
const DRAWS: usize = 2;
const MANY_ZONES: usize = 100_000;
/// Root mean squares that an error of a zone may reach.
const TWICE: f64 = 2.0;

/// Error of the direct light of a group, W/m²; none where it has no direct light.
pub(crate) fn of_group(source: &Source, direct: &Direct) -> Vec<Bands> {
    let own: Vec<&Lit> = lights(source, direct).collect();
    let Some(first) = own.first() else { return Vec::new() };
    let one = |i: usize| {
        own.iter().fold([0.0; 3], |s, l| {
            let e = l.error_of(i);
            bands(|b| s[b] + e[b])
        })
    };
    (0..first.fields.len()).into_par_iter().map(one).collect()
}

fn lights<'a>(source: &'a Source, direct: &'a Direct) -> impl Iterator<Item = &'a Lit> {
    direct.lights.iter().enumerate().filter(|(l, _)| source.has_light(*l)).map(|(_, x)| x)
}

/// What the errors of a group's direct light cost what arrives of it after reflection, `incident`, W/m²; none where it has no direct light.
pub(crate) fn propagated(
    zones: &Zones,
    operator: &dyn Operator,
    source: &Source,
    direct: &Direct,
    incident: &[Bands],
) -> Vec<Bands> {
    let n = zones.len();
    let own: Vec<&Lit> = lights(source, direct).filter(|l| l.fields.len() == n).collect();
    if own.is_empty() {
        return Vec::new();
    }
    let sampled = own.iter().any(|l| !l.by_exchange);
    // Independent errors of several lights add up by squares, all others by their amounts.
    let error = |i: usize| {
        let (mut square, mut sum) = ([0.0; 3], [0.0; 3]);
        for l in &own {
            for b in 0..3 {
                match l.by_exchange {
                    true => sum[b] += l.error[i][b],
                    false => square[b] += l.error[i][b].powi(2),
                }
            }
        }
        bands(|b| sum[b] + square[b].sqrt())
    };
    let error: Vec<Bands> = (0..n).into_par_iter().map(error).collect();
    if error.par_iter().all(|e| *e == [0.0; 3]) && own.iter().all(|l| l.shared == [0.0; 3]) {
        return Vec::new();
    }
    let reflected = |k: u64| {
        let mut s: Vec<Bands> = (0..n)
            .into_par_iter()
            .map(|i| {
                let (c, (rho, _)) = (strength(zones, i), response(zones, i));
                let sign = if k > 0 && sequence::hash(k << 48 | i as u64) & 1 == 1 { -1.0 } else { 1.0 };
                bands(|b| sign * c[b] * rho[b] * error[i][b])
            })
            .collect();
        s.resize(operator.len(), [0.0; 3]);
        let mut p = operator.apply(&s);
        p.truncate(n);
        p.par_iter_mut().enumerate().for_each(|(i, p)| *p = p.map(|p| p.abs() / response(zones, i).1));
        p
    };
    let mut first = reflected(0);
    if sampled {
        let draws = if n > MANY_ZONES { 1 } else { DRAWS };
        let mut mean = vec![[0.0; 3]; n];
        for k in 1..=draws {
            let one = reflected(k as u64);
            mean.par_iter_mut().zip(one).for_each(|(m, x)| *m = bands(|b| m[b] + x[b] * x[b] / draws as f64));
        }
        for range in [0..zones.voxel_offset(), zones.voxel_offset()..n] {
            let start = range.start;
            let sums: [f64; 6] = crate::columns::sum(range.len(), |k| {
                let (m, l) = (mean[start + k], first[start + k]);
                [m[0], m[1], m[2], l[0] * l[0], l[1] * l[1], l[2] * l[2]]
            });
            let ratio = bands(|b| if sums[3 + b] > 0.0 { (sums[b] / sums[3 + b]).sqrt() } else { 0.0 });
            first[range].par_iter_mut().enumerate().for_each(|(k, l)| {
                let m = mean[start + k];
                *l = bands(|b| l[b].min(m[b].sqrt().max(TWICE * ratio[b] * l[b])));
            });
        }
    }
    let later = later(zones, &own, &error, sampled);
    let one = |i: usize| bands(|b| first[i][b] + later[b] * incident[i][b].abs());
    (0..n).into_par_iter().map(one).collect()
}

/// Relative error of what arrives after more than one reflection, and of what all zones share.
fn later(zones: &Zones, own: &[&Lit], error: &[Bands], sampled: bool) -> Bands {
    let sums: [f64; 9] = crate::columns::sum(error.len(), |i| {
        let (w, rho) = (section(zones, i), sent_back(zones, i));
        std::array::from_fn(|k| {
            let b = k % 3;
            let wr = w[b] * rho[b];
            let field = |l: &&Lit| l.fields[i][b];
            match k / 3 {
                0 if sampled => (wr * error[i][b]).powi(2),
                0 => wr * error[i][b],
                1 => wr * own.iter().map(field).sum::<f64>(),
                _ => wr * own.iter().map(|l| l.shared[b] * field(l)).sum::<f64>(),
            }
        })
    });
    bands(|b| {
        let first = if sampled { TWICE * sums[b].sqrt() } else { sums[b] };
        if sums[3 + b] > 0.0 { (first + sums[6 + b]) / sums[3 + b] } else { 0.0 }
    })
}

/// Adds what the errors of direct light cost what arrives of it to the errors of all light and of each group.
pub(crate) fn reach(site: &Site, operator: &dyn Operator, fields: &mut Fields, groups: &mut [Group]) {
    let zones = site.zones;
    for (source, group) in site.sources.iter().zip(groups) {
        let mut incident = vec![[0.0; 3]; zones.len()];
        group.incident.add_to(&mut incident, group.incident_scale);
        let more = propagated(zones, operator, source, site.direct, &incident);
        fields.error.iter_mut().zip(&more).for_each(|(f, e)| *f = bands(|b| f[b] + e[b]));
        if !more.is_empty() && !group.error.is_empty() {
            let mut own = vec![[0.0; 3]; zones.len()];
            group.error.add_to(&mut own, group.incident_scale);
            own.iter_mut().zip(&more).for_each(|(o, e)| *o = bands(|b| o[b] + e[b]));
            group.error = like(&group.incident, &own, group.incident_scale);
        }
    }
}

/// Standard error of the power that the lights send in or lose, as rays from them measure it, W.
pub(crate) fn of_lights(direct: &Direct) -> [Bands; 3] {
    let mut square = [[0.0; 3]; 3];
    for l in &direct.lights {
        for (s, e) in square.iter_mut().zip(l.power_error) {
            *s = bands(|b| s[b] + e[b] * e[b]);
        }
    }
    square.map(|s| s.map(f64::sqrt))
}

/// Adds the errors of direct light to those of the powers by name: independent errors of zones by squares, what they share and the errors of exchange
/// areas by amounts, [`TWICE`] the standard error.
pub(crate) fn add_to_powers(zones: &Zones, energy: &Energy, direct: &Direct, out: &mut Energy) {
    if direct.lights.is_empty() {
        return;
    }
    let mut all = [0.0; 3];
    let mut add = |row: &mut Bands, list: &mut dyn Iterator<Item = usize>| {
        let (mut square, mut sum) = ([0.0; 3], [0.0; 3]);
        for i in list {
            let a = uptake(zones, i);
            for l in &direct.lights {
                for b in 0..3 {
                    let own = a[b] * l.error[i][b];
                    match l.by_exchange {
                        true => sum[b] += own,
                        false => square[b] += own * own,
                    }
                    sum[b] += a[b] * l.shared[b] * l.fields[i][b].abs();
                }
            }
        }
        let more = bands(|b| sum[b] + TWICE * square[b].sqrt());
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
    let [sent, escaped, backs] = of_lights(direct);
    let came = energy.incoming != [0.0; 3];
    out.incoming = bands(|b| out.incoming[b] + if came { TWICE * sent[b] } else { 0.0 });
    let left = |error: Bands, power: Bands, own: Bands| {
        bands(|b| if power[b] == 0.0 { error[b] } else { error[b] + all[b] + TWICE * own[b] })
    };
    out.escaped = left(out.escaped, energy.escaped, escaped);
    out.backs = left(out.backs, energy.backs, backs);
}
