//! What the size of the zones costs: a second solve on zones about twice as large, and how far apart the two are.
//!
//! Let Q(h) = Q + c h^p be a flux, a power or a temperature by zones of size h. Then
//!
//! ```text
//!     |Q(h) − Q| = |Q(h) − Q(rh)| / (r^p − 1)  ≤  |Q(h) − Q(rh)| / (r − 1)          p ≥ 1, r > 1
//! ```
//!
//! Orders that are seen lie between 1.5 and 2 (`docs/validation.md`), so that the right-hand side is two to three times the error; for r = 2 and
//! p = 2 it is the grid convergence index of two grids. It is an estimate: where zones are so large that Q(rh) is not yet on its way to Q, it may
//! fail, and of zones that the geometry does not let grow it knows nothing: the report names both.
//!
//! r is how much an edge grows at least (module `grown`). Temperatures and powers that are given have no such error.

mod grown;

use crate::pipeline::{self, Job};
use grown::Grown;
use zonal_scene::scene::ThickZones;
use zonal_scene::vault::STATE;
use zonal_scene::{
    Engine, HeatKind, HeatReport, HeatRow, Known, Note, Progress, Report, Scene, SceneError, Vault, Zones,
    Zoning,
};
use zonal_transport::{Transport, build_zones};

/// Differences below this share of a number are rounding.
const ROUNDING: f64 = 1e-12;

/// True where a solve is to tell what its zones cost.
pub fn wanted(scene: &Scene) -> bool {
    scene.options().zoning_error.unwrap_or(scene.thermal().is_some())
}

/// A listener who is told which of two solves is at work.
struct Second<'a>(&'a dyn Progress);

impl Progress for Second<'_> {
    fn begin(&self, stage: &str, total: u64) {
        self.0.begin(&format!("larger zones: {stage}"), total);
    }
    fn advance(&self, steps: u64) {
        self.0.advance(steps);
    }
    fn end(&self) {
        self.0.end();
    }
}

/// A vault that keeps the second of two solves apart from the first; its stages serve this scene alone.
struct Apart<'a>(&'a dyn Vault);

impl Apart<'_> {
    fn name(stage: &str) -> String {
        format!("{STATE}larger-zones-{stage}")
    }
}

impl Vault for Apart<'_> {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        self.0.load(&Apart::name(stage))
    }
    fn save(&self, stage: &str, bytes: &[u8]) {
        self.0.save(&Apart::name(stage), bytes);
    }
    fn keeps(&self) -> bool {
        self.0.keeps()
    }
}

/// Solves the scene again on larger zones, by the same engine and with slopes if `slopes`, and puts into the report what that tells.
pub(crate) fn estimate(scene: &Scene, zones: &Zones, slopes: bool, report: &mut Report, job: &Job) {
    match second(scene, zones, slopes, report, job) {
        Ok(zoning) => report.zoning = Some(zoning),
        Err(why) => {
            let text = format!("what the size of the zones costs is not known: {why}");
            report.warnings.push(Note::warning("discretization", text));
        }
    }
}

fn second(scene: &Scene, zones: &Zones, slopes: bool, report: &Report, job: &Job) -> Result<Zoning, String> {
    let of = |e: SceneError| format!("larger ones do not serve ({e})");
    let coarser = scene.coarser().map_err(of)?;
    let mut options = coarser.options().clone();
    options.engine = Engine::ALL.into_iter().find(|e| e.word() == report.engine).unwrap_or_default();
    options.thick_zones = if slopes { ThickZones::Linear } else { ThickZones::Constant };
    options.zoning_error = Some(false);
    let coarser = coarser.with_options(options).map_err(of)?;
    let transport = Transport::new(&coarser);
    let others = build_zones(&coarser, &transport).map_err(of)?;
    let grown = Grown::between((scene, zones), (&coarser, &others), &transport, slopes);
    let ratio = grown.ratio?;
    let (progress, vault) = (Second(job.progress), Apart(job.vault));
    let larger = Job { vault: &vault, initial: &[], progress: &progress, ..*job };
    let (_, other) = pipeline::settled(&coarser, transport, others, &larger).map_err(of)?;
    let apart = |a: f64, b: f64| differs(a, b) / (ratio - 1.0);
    let tables = report.heat.iter().zip(&other.report.heat);
    let heat = tables.flat_map(|(own, other)| own.rows.iter().zip(&other.rows).zip(are_given(scene, own)));
    let heat = heat.map(|((a, b), given)| {
        let kelvin = match (given, a.temperature, b.temperature) {
            (true, ..) => 0.0,
            (false, Some(a), Some(b)) => apart(a, b),
            _ => f64::NAN,
        };
        [kelvin, apart(a.power, b.power)]
    });
    Ok(Zoning {
        zones: grown.zones,
        ratio,
        heat: heat.collect(),
        energy: report.energy.compared(&other.report.energy, apart),
        notes: grown.notes.into_iter().map(|t| Note::warning("discretization", t)).collect(),
    })
}

/// Of each row of a table by name, whether the temperature of all that is in it is given.
fn are_given(scene: &Scene, table: &HeatReport) -> Vec<bool> {
    let warm = |k: &Known| matches!(k, Known::Temperature(_));
    let (surfaces, panes) = scene.thermal().map_or((&[][..], &[][..]), |t| (&t.surfaces[..], &t.panes[..]));
    let medium = || {
        let map = scene.voxmap()?;
        let cells = if map.is_uniform() { 1 } else { map.len() };
        Some((0..cells).all(|i| map.heat(i).is_some_and(|k| warm(&k))))
    };
    let (mut surfaces, mut panes) = (surfaces.iter(), panes.iter());
    let one = |row: &HeatRow| match row.kind {
        HeatKind::Surface => surfaces.next().is_some_and(warm),
        HeatKind::Medium => medium().unwrap_or(false),
        HeatKind::Pane => panes.next().is_some_and(warm),
    };
    table.rows.iter().map(one).collect()
}

/// |a − b|, 0 where that is rounding.
fn differs(a: f64, b: f64) -> f64 {
    let d = (a - b).abs();
    if d > ROUNDING * a.abs().max(b.abs()) { d } else { 0.0 }
}
