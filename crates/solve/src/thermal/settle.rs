//! From what arrives to temperatures, net powers and their errors, zone by zone and by name.
//!
//! **Errors.** Of what arrives, δh is known from the factors for what the zones send out; but what they send out errs too. [`spread`] bounds
//! both: with M as in the linear equations (no entry negative), δu = t c M|δh| + M δu and δh' = |δh| + g δu/t. Then δq = Σ_b m_b a_b δh'_b of
//! a zone of known temperature, δE = δq/Σ_b m_b a_b ψ_b of one of known power, δT = T δE/(4E). Sums over a surface add all up as if they had one
//! sign, and the power that the solver left undistributed.

use super::coupled::{Powers, Turn};
use super::linear::{self, Keeper};
use super::local::{Local, Locals};
use crate::consistency;
use crate::energy;
use crate::engine::{Built, Site};
use rayon::prelude::*;
use zonal_scene::thermal::{black, temperature};
use zonal_scene::{
    Bands, Estimate, Fields, Group, Heat, HeatKind, HeatReport, HeatRow, Known, Note, Report, Scene, Zones,
    bands,
};

/// Share of what is absorbed below which a balance that is off is rounding.
const ROUNDING: f64 = 1e-12;
/// Residual of the errors' own solve, and its steps.
const ROUGHLY: f64 = 0.1;
const STEPS: usize = 200;
/// Its stage.
const STAGE: &str = "state-errors";

/// Puts into the errors of what arrives those of what the zones send out because of them.
pub(crate) fn spread(site: &Site, built: &Built, fields: &mut Fields, coupled: bool) {
    let table = Locals::new(site.scene, site.zones);
    let locals = table.all(site.zones);
    let (n, shares) = (site.zones.len(), &table.thermal.shares);
    let part = |i: usize| bands(|b| locals[i].part * fields.error[i][b]);
    // Of zones of known power the temperature is that of the radiosities found.
    let turns: Vec<Turn> = match coupled {
        true => (0..n)
            .into_par_iter()
            .map(|i| {
                Turn::of(&locals[i], shares, found(&locals[i], shares, arriving(&locals[i], fields, i)).0)
            })
            .collect(),
        false => Vec::new(),
    };
    let posed = |i: usize, h: Bands| {
        let (rho, _) = site.zones.response(i);
        bands(|b| rho[b] / locals[i].part * h[b])
    };
    let turn = |i: usize, h: Bands| turns.get(i).map_or_else(|| posed(i, h), |t| t.passed(h));
    let operator = built.operator.as_ref();
    let powers = Powers::new(operator, site.zones, &locals, shares.grey(), &[]);
    let source: Vec<Bands> = (0..n).into_par_iter().map(|i| powers.of(i, turn(i, part(i)))).collect();
    if linear::power(&source) == 0.0 {
        return;
    }
    let keeper = Keeper { vault: site.vault, stage: STAGE, number: 0, resumes: true };
    let passed = |u: &[Bands]| powers.passed(operator, u, turn);
    let end = linear::solve(passed, &source, source.clone(), (ROUGHLY, STEPS), &keeper);
    let more = powers.arriving(operator, &end.u);
    for (i, e) in fields.error.iter_mut().enumerate() {
        *e = bands(|b| e[b] + more[i][b].abs() / locals[i].part);
    }
}

/// h of a zone.
fn arriving(l: &Local, fields: &Fields, i: usize) -> Bands {
    bands(|b| l.part * (fields.incident[i][b] + fields.direct[i][b]))
}

/// E of a zone, and q; E is not a number where none is defined.
fn found(l: &Local, shares: &zonal_scene::Shares, h: Bands) -> (f64, f64) {
    match l.known {
        Known::Temperature(t) => (black(t), l.net(shares, black(t), h)),
        Known::Flux(q) | Known::Power(q) => (l.balanced(shares, q, h).unwrap_or(f64::NAN), q),
    }
}

/// Sums over zones of one name.
#[derive(Clone, Copy, Default)]
struct Sum {
    size: f64,
    /// Size of what has a temperature, and Σ E and Σ δE over it.
    warm: [f64; 3],
    power: [f64; 2],
}

/// Turns the zones back into those of the temperatures found, and adds temperatures, net powers and the table by name.
pub(crate) fn settle(
    scene: &Scene,
    zones: &mut Zones,
    fields: &mut Fields,
    groups: &mut [Group],
    report: &mut Report,
) {
    let Some(thermal) = scene.thermal() else { return };
    let shares = &thermal.shares;
    let locals = Locals::new(scene, zones).all(zones);
    let n = zones.len();
    let all: Vec<(f64, f64)> =
        (0..n).into_par_iter().map(|i| found(&locals[i], shares, arriving(&locals[i], fields, i))).collect();
    let missing = imbalance(&locals, shares, &all, groups);
    let explained = |i: usize| {
        let (l, m) = (&locals[i], locals[i].uptake());
        l.measure * shares.total(bands(|b| m[b] * l.part * fields.error[i][b]))
    };
    let known: f64 =
        (0..n).filter(|&i| matches!(locals[i].known, Known::Temperature(_))).map(explained).sum();
    widen(&locals, shares, missing - known - shares.total(report.energy_error.escaped), fields);
    // δq, or δE.
    let error = |i: usize| {
        let (l, e) = (&locals[i], fields.error[i]);
        let m = l.uptake();
        let q = shares.total(bands(|b| m[b] * l.part * e[b]));
        if matches!(l.known, Known::Temperature(_)) {
            return [q, 0.0];
        }
        let slope = shares.emissive(all[i].0.max(0.0))[1];
        [0.0, q / shares.total(bands(|b| m[b] * slope[b].max(0.0)))]
    };
    let errors: Vec<[f64; 2]> = (0..n).into_par_iter().map(error).collect();
    let kelvin = |e: f64, de: f64| if e > 0.0 { 0.25 * temperature(e) * de / e } else { f64::NAN };
    let heat = Heat {
        temperature: all.iter().map(|x| temperature(x.0)).collect(),
        temperature_error: all.iter().zip(&errors).map(|(x, d)| kelvin(x.0, d[1])).collect(),
        net: all.iter().map(|x| x.1).collect(),
        net_error: errors.iter().map(|d| d[0]).collect(),
    };
    report.warnings.extend(undefined(&locals, shares, &heat));
    let emissive: Vec<Bands> =
        all.iter().map(|x| shares.emissive(if x.0.is_nan() { 0.0 } else { x.0 })[0]).collect();
    super::physical(scene, zones, &emissive);
    let radiosity = |i: usize| {
        let (l, h) = (&locals[i], arriving(&locals[i], fields, i));
        bands(|k| l.absorb[k] * emissive[i][k] + l.reflect[k] * h[k])
    };
    fields.radiosity = (0..n).into_par_iter().map(radiosity).collect();
    report.energy = Default::default();
    for g in groups.iter_mut() {
        g.energy = energy::of_zones(scene, zones, &fields.incident, &g.energy);
        report.energy.add(&g.energy);
    }
    let of = |i: usize, size: f64| {
        let ([dq, de], (e, q)) = (errors[i], all[i]);
        let warm = if e >= 0.0 { [size, size * e, size * de] } else { [0.0; 3] };
        Sum { size, warm, power: [size * q, size * dq] }
    };
    let left: f64 = (0..n)
        .map(|i| {
            let m = locals[i].uptake();
            locals[i].measure * shares.total(bands(|b| m[b] * emissive[i][b].abs()))
        })
        .sum::<f64>()
        * report.residuals.iter().filter_map(|r| r.last()).fold(0.0f64, |m, r| m.max(*r));
    report.estimate = Estimate::of(fields, zones.voxel_offset(), report.estimate.grade);
    report.energy_error = consistency::of_powers(zones, &report.energy, fields, |i| fields.error[i]);
    report.heat = Some(table(scene, zones, report, shares, left, of));
    fields.heat = Some(heat);
}

/// What the net powers of all zones (found: E, q), of the surroundings and of black backs sum to, which would be 0, W.
fn imbalance(locals: &[Local], shares: &zonal_scene::Shares, found: &[(f64, f64)], groups: &[Group]) -> f64 {
    let zones: f64 = locals.iter().zip(found).map(|(l, x)| l.measure * x.1).sum();
    let away =
        |g: &Group| shares.total(bands(|b| g.energy.incoming[b] - g.energy.escaped[b] - g.energy.backs[b]));
    (zones + groups.iter().map(away).sum::<f64>()).abs()
}

/// Shares out the power that a balance of heat misses beyond what stated errors explain, in proportion to what the zones
/// of known temperature absorb.
fn widen(locals: &[Local], shares: &zonal_scene::Shares, excess: f64, fields: &mut Fields) {
    let taken = |i: usize, l: &Local| {
        let (m, h) = (l.uptake(), arriving(l, fields, i));
        l.measure * shares.total(bands(|b| m[b] * h[b].abs()))
    };
    // Zones of known power give it, whatever is wrong: what is missing is missing from the others.
    let open = |l: &Local| matches!(l.known, Known::Temperature(_));
    let all: f64 = locals.iter().enumerate().filter(|(_, l)| open(l)).map(|(i, l)| taken(i, l)).sum();
    // Not a number is unknown.
    let share = match excess <= ROUNDING * all {
        true => return,
        false if all > 0.0 && excess.is_finite() => excess / all,
        false => f64::INFINITY,
    };
    consistency::share_out([share; 3], fields);
}

/// What to say of zones without a temperature.
fn undefined(locals: &[Local], shares: &zonal_scene::Shares, heat: &Heat) -> Vec<Note> {
    const WHY: [&str; 4] = [
        "zones neither absorb nor emit: their temperature is undefined",
        "zones emit in no band that has a share of the emission: their temperature is undefined",
        "zones have no temperature: more heat is taken from them than arrives; give less negative powers",
        "zones have no temperature: next to nothing arrives at them; give a lower solve.residual",
    ];
    let shining = shares.shining();
    let mut counts = [0; 4];
    for (l, _) in locals.iter().zip(&heat.temperature).filter(|(_, t)| t.is_nan()) {
        let m = l.uptake();
        let why = match l.known {
            _ if m == [0.0; 3] => 0,
            _ if !(0..3).any(|b| shining[b] && m[b] > 0.0) => 1,
            Known::Flux(q) | Known::Power(q) if q < 0.0 => 2,
            _ => 3,
        };
        counts[why] += 1;
    }
    let told = counts.iter().zip(WHY).filter(|(n, _)| **n > 0);
    told.map(|(n, why)| Note::warning("no-temperature", format!("{n} {why}"))).collect()
}

fn table(
    scene: &Scene,
    zones: &Zones,
    report: &Report,
    shares: &zonal_scene::Shares,
    left: f64,
    of: impl Fn(usize, f64) -> Sum,
) -> HeatReport {
    let row = |name: &str, kind: HeatKind, list: &mut dyn Iterator<Item = (usize, f64)>| {
        let s = list.map(|(i, size)| of(i, size)).fold(Sum::default(), |s, x| Sum {
            size: s.size + x.size,
            warm: [0, 1, 2].map(|k| s.warm[k] + x.warm[k]),
            power: [0, 1].map(|k| s.power[k] + x.power[k]),
        });
        let [size, e, de] = s.warm;
        let mean = (size > 0.0).then(|| temperature(e / size));
        HeatRow {
            name: name.to_string(),
            kind,
            size: s.size,
            temperature: mean,
            temperature_error: mean.map(|t| if e > 0.0 { 0.25 * t * de / e } else { 0.0 }),
            power: s.power[0],
            // Of a surface whose power is known no solver takes any.
            power_error: s.power[1] + if s.power[1] > 0.0 { left } else { 0.0 },
        }
    };
    let mut by_surface: Vec<Vec<(usize, f64)>> = vec![Vec::new(); scene.surfaces().len()];
    zones.patches.iter().enumerate().for_each(|(i, p)| by_surface[p.surface].push((i, p.area)));
    let mut rows: Vec<HeatRow> = scene
        .surfaces()
        .iter()
        .zip(by_surface)
        .map(|(s, list)| row(&s.name, HeatKind::Surface, &mut list.into_iter()))
        .collect();
    if !zones.voxels.is_empty() {
        let first = zones.voxel_offset();
        let mut list = zones.voxels.iter().enumerate().map(|(k, v)| (first + k, v.volume));
        rows.push(row("medium", HeatKind::Medium, &mut list));
    }
    for (k, pane) in scene.panes().iter().enumerate() {
        let (first, own) = (zones.pane_offset(), zones.panes.iter().enumerate().filter(|(_, p)| p.pane == k));
        let mut list = own.map(|(j, p)| (first + j, p.area * p.thickness));
        rows.push(row(&pane.name, HeatKind::Pane, &mut list));
    }
    let e = &report.energy;
    HeatReport {
        rows,
        surroundings: shares.total(bands(|b| e.incoming[b] - e.escaped[b])),
        backs: shares.total(e.backs),
    }
}
