//! A scene in, a solution out: zones, exchange areas, surroundings, closure, direct light, iteration, balance.

use crate::closure;
use crate::dense::{self, Assembly, Dense};
use crate::direct;
use crate::energy;
use crate::forecast::{self, Forecast};
use crate::krylov::{self, Ended};
use crate::operator::Operator;
use crate::surroundings::Escape;
use std::f64::consts::PI;
use zonal_exchange::pair::{Counts, Exchange, Settings, VoxelFactors, strength};
use zonal_math::Grade;
use zonal_scene::{Bands, Fields, Progress, Report, Scene, SceneError, Solution, Zones, bands};
use zonal_transport::{Transport, build_zones};

/// Largest memory that the exchange areas may take unless the caller says otherwise, bytes.
pub const DEFAULT_MEMORY: u64 = 12 << 30;

/// Relative energy residual above which the report says so.
const POOR_BALANCE: f64 = 1e-3;

/// Rays a zone that measure what escapes; four times as many where as much light comes in that way.
fn escape_rays(scene: &Scene) -> usize {
    let tolerance = scene.options().tolerance;
    let shining = scene.surroundings().radiance != [0.0; 3];
    ((0.05 / (tolerance * tolerance)) as usize).clamp(256, 4096) * if shining { 4 } else { 1 }
}

/// Solves a scene with the dense engine; refuses with a reason when it would need more than `memory` bytes.
pub fn solve(scene: Scene, memory: u64, progress: &dyn Progress) -> Result<Solution, SceneError> {
    solve_with(scene, memory, Settings::default(), progress)
}

/// The same with the exchange of pairs computed as `settings` say.
pub fn solve_with(
    scene: Scene,
    memory: u64,
    settings: Settings,
    progress: &dyn Progress,
) -> Result<Solution, SceneError> {
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport)?;
    let forecast = Forecast::new(&scene, &zones, &transport);
    if forecast.bytes > memory {
        return Err(SceneError::new(
            "solve.patch_size",
            format!(
                "{} zones need {:.3} GB for their exchange areas, more than the {:.3} GB allowed; use larger patches or fewer cells, or allow more (--max-memory)",
                zones.len(),
                forecast.bytes as f64 / 1e9,
                memory as f64 / 1e9
            ),
        ));
    }
    let (fields, report) = solve_zones(&scene, &zones, &transport, settings, progress);
    drop(transport);
    Ok(Solution {
        zones,
        fields,
        groups: Vec::new(),
        report,
        scene_hash: String::new(),
        version: env!("CARGO_PKG_VERSION").to_string(),
        scene,
    })
}

/// Solves given zones.
pub fn solve_zones(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    settings: Settings,
    progress: &dyn Progress,
) -> (Fields, Report) {
    let options = scene.options();
    let exchange = Exchange::with_settings(scene, zones, transport, settings);
    let group = dense::groups(scene, transport.has_panes_between());
    let (mut operator, assembly) = Dense::assemble(&exchange, zones, group, progress);
    drop(exchange);
    let mut escape = Escape::measure(scene, zones, transport, escape_rays(scene), progress);
    let (closure, defects) = if options.restore_closure {
        closure::restore(&mut operator, zones, &mut escape)
    } else {
        closure::measure(&operator, zones, &escape)
    };
    let direct = direct::illuminate(scene, zones, transport, options.restore_closure, progress);
    let lit = direct.fields(zones.len());
    let sources = sources(scene, zones, &escape, &lit);
    let ended = krylov::solve(
        &operator,
        &sources.strengths,
        &sources.weights,
        options.residual,
        options.max_iterations,
        progress,
    );
    let fields = fields(zones, &operator, &ended, &sources, lit, &assembly, &defects);
    let balance = energy::balance(scene, zones, &fields, &ended.strengths, &escape, &direct);
    let mut warnings = forecast::warnings(scene, zones);
    if settings.voxels != VoxelFactors::Exact && assembly.counts.paper > 0 {
        warnings.push(
            "the factors of two voxels are those of the paper, for comparison: the errors stated here leave out what that costs".into(),
        );
    }
    if !escape.closed() {
        warnings.push("the scene is open: power escapes to the surroundings or onto black backs".into());
    }
    warnings.extend(direct.warnings().cloned());
    let off = balance.residual.iter().fold(0.0f64, |m, r| m.max(r.abs()));
    if off > POOR_BALANCE {
        warnings.push(format!(
            "the energy balance is off by {off:.1e}: restore closure, or ask for a smaller tolerance"
        ));
    }
    let mut closure = closure;
    closure.largest_change = closure.largest_change.map(|c| c.max(direct.largest_change()));
    let report = Report {
        status: ended.status,
        residuals: ended.residuals,
        closure,
        energy: balance,
        counts: counts(zones, &assembly.counts, escape.rays),
        warnings,
        grade: if escape.closed() { operator.grade() } else { Grade::Statistical },
        ..Report::default()
    };
    (fields, report)
}

/// Right-hand sides: strengths of the sources, weights of the reflections, power from the surroundings.
struct Sources {
    strengths: Vec<Bands>,
    weights: Vec<Bands>,
    sky: Vec<Bands>,
}

/// ρ or Ω/4, and the measure (A or V) of zone i.
fn response(zones: &Zones, i: usize) -> (Bands, f64) {
    if i < zones.voxel_offset() {
        let p = &zones.patches[i];
        (p.reflectance, p.area)
    } else if i < zones.pane_offset() {
        let v = &zones.voxels[i - zones.voxel_offset()];
        (v.albedo.map(|o| 0.25 * o), v.volume)
    } else {
        let p = &zones.panes[i - zones.pane_offset()];
        (p.albedo.map(|o| 0.25 * o), p.area * p.thickness)
    }
}

/// Own emission as a radiosity: E, (1−Ω)E + q/(4κ).
fn emission(zones: &Zones, i: usize) -> Bands {
    if i < zones.voxel_offset() {
        zones.patches[i].emission
    } else if i < zones.pane_offset() {
        let v = &zones.voxels[i - zones.voxel_offset()];
        bands(|b| {
            let q = if v.extinction[b] > 0.0 { v.source[b] / (4.0 * v.extinction[b]) } else { 0.0 };
            (1.0 - v.albedo[b]) * v.emission[b] + q
        })
    } else {
        let p = &zones.panes[i - zones.pane_offset()];
        bands(|b| (1.0 - p.albedo[b]) * p.emission[b])
    }
}

fn sources(scene: &Scene, zones: &Zones, escape: &Escape, direct: &[Bands]) -> Sources {
    let sky = scene.surroundings().radiance.map(|l| PI * l);
    let mut s = Sources { strengths: Vec::new(), weights: Vec::new(), sky: Vec::new() };
    for i in 0..zones.len() {
        let (c, e, (rho, measure)) = (strength(zones, i), emission(zones, i), response(zones, i));
        let arriving = bands(|b| escape.sky[i][b] * sky[b]);
        s.strengths.push(bands(|b| c[b] * (e[b] + rho[b] * (direct[i][b] + arriving[b] / measure))));
        s.weights.push(bands(|b| c[b] * rho[b] / measure));
        s.sky.push(arriving);
    }
    s
}

fn fields(
    zones: &Zones,
    operator: &dyn Operator,
    ended: &Ended,
    sources: &Sources,
    direct: Vec<Bands>,
    assembly: &Assembly,
    defects: &[Bands],
) -> Fields {
    let arriving = operator.apply(&ended.strengths);
    let mut f = Fields { direct, ..Fields::default() };
    for i in 0..zones.len() {
        let (rho, measure) = response(zones, i);
        let incident = bands(|b| (arriving[i][b] + sources.sky[i][b]) / measure);
        let e = emission(zones, i);
        f.radiosity.push(bands(|b| e[b] + rho[b] * (incident[b] + f.direct[i][b])));
        f.error.push(bands(|b| incident[b] * (defects[i][b].abs() + assembly.noise[i])));
        f.incident.push(incident);
    }
    f
}

fn counts(zones: &Zones, c: &Counts, escape_rays: u64) -> Vec<(String, u64)> {
    let list = [
        ("zones", zones.len() as u64),
        ("patches", zones.patches.len() as u64),
        ("voxel zones", zones.voxels.len() as u64),
        ("pane zones", zones.panes.len() as u64),
        ("aligned pairs", c.aligned),
        ("voxel pairs by a formula of the paper", c.paper),
        ("pairs with a plate in any position", c.general),
        ("pairs with a cut voxel", c.cut),
        ("pairs with a pane", c.pane),
        ("pairs that face away", c.facing_away),
        ("pairs partly visible", c.partial),
        ("rays between zones", c.rays),
        ("rays to the surroundings", escape_rays),
    ];
    list.into_iter().map(|(k, v)| (k.to_string(), v)).collect()
}
