//! The discretization error: a second solve on zones about twice as large, or half as large, and how far apart the two are.
//!
//! Let Q(h) = Q + c h^p be a flux, a power or a temperature by zones of size h. Then, for p ≥ 1 and r > 1,
//!
//! ```text
//!     |Q(h) − Q| = |Q(h) − Q(rh)| / (r^p − 1)             ≤  |Q(h) − Q(rh)| / (r − 1)             of zones r times as large
//!     |Q(h) − Q| = |Q(h) − Q(h/r)| · r^p / (r^p − 1)      ≤  2 |Q(h) − Q(h/r)|                    of zones r ≥ 2 times as small
//! ```
//!
//! The last holds for p ≥ 1/log₂ r already: few zones, which are divided by four or eight, need not be on their way to Q.
//! Orders that are seen lie between 1.5 and 2 (`docs/validation.md`), so that the right-hand side is two to three times the error; for r = 2 and
//! p = 2 it is the grid convergence index of two grids. It is an estimate: where zones are so large that Q(rh) is not yet on its way to Q, it may
//! fail.
//!
//! Larger zones cost little, but zones that the geometry does not let grow tell nothing, and few or thick ones tell it badly. Then smaller ones
//! are taken instead, where the scene has few zones. Where these are too many as well, the errors of the surfaces and volumes that did not grow
//! are infinite, which stands for unknown, and of zones that are few or thick the estimate is multiplied by what it was too small at worst.
//!
//! r is how much an edge grows at least (module `grown`). Temperatures and powers that are given have no such error.

mod grown;
mod nearby;

use crate::pipeline::{self, Job};
use grown::Grown;
use zonal_scene::scene::ThickZones;
use zonal_scene::solution::Energy;
use zonal_scene::vault::STATE;
use zonal_scene::{
    Bands, Engine, Fields, HeatKind, HeatReport, HeatRow, Known, Note, Progress, Report, Scene, SceneError,
    Vault, Zones, Zoning, bands,
};
use zonal_transport::{Transport, build_zones};

/// The factor of a difference to smaller zones (header).
const SMALLER: f64 = 2.0;

/// By what zones are divided across for a solve on smaller ones, and how many these may be at most.
const DIVISIONS: [(usize, usize); 3] = [(8, 1000), (4, 1000), (2, MOST_ZONES)];
const MOST_ZONES: usize = 2500;
/// Where facets or panes stand between zones a pair costs several times as much, and so many times fewer zones are as many as are taken.
const FEWER_BETWEEN: usize = 3;

/// An error is no less than this share of the mean relative error of its kind: differences that pass through zero hide errors.
const MEAN_SHARE: f64 = 0.3;

/// Differences below this share of a number are rounding.
const ROUNDING: f64 = 1e-12;

/// True where a solve is to tell what its zones cost.
pub fn wanted(scene: &Scene) -> bool {
    scene.options().zoning_error.unwrap_or(scene.thermal().is_some())
}

/// A listener who is told which of two solves is at work.
struct Second<'a>(&'a dyn Progress, &'static str);

impl Progress for Second<'_> {
    fn begin(&self, stage: &str, total: u64) {
        self.0.begin(&format!("{} zones: {stage}", self.1), total);
    }
    fn advance(&self, steps: u64) {
        self.0.advance(steps);
    }
    fn end(&self) {
        self.0.end();
    }
}

/// A vault that keeps the second of two solves apart from the first; its stages serve this scene alone.
struct Apart<'a>(&'a dyn Vault, &'static str);

impl Apart<'_> {
    fn name(&self, stage: &str) -> String {
        format!("{STATE}{}-zones-{stage}", self.1)
    }
}

impl Vault for Apart<'_> {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        self.0.load(&self.name(stage))
    }
    fn save(&self, stage: &str, bytes: &[u8]) {
        self.0.save(&self.name(stage), bytes);
    }
    fn keeps(&self) -> bool {
        self.0.keeps()
    }
}

/// Solves the scene again on larger zones, or on smaller ones, by the same engine and with slopes if `slopes`, and puts into the report what
/// that tells; errors that it does not tell are infinite.
pub(crate) fn estimate(
    scene: &Scene,
    (zones, fields): (&Zones, &Fields),
    slopes: bool,
    report: &mut Report,
    job: &Job,
) {
    let mut zoning = match compared(scene, zones, slopes, report, job) {
        Ok(zoning) => zoning,
        Err(why) => {
            let text = format!("the discretization error is not known: {why}");
            report.warnings.push(Note::warning("discretization", text));
            unknown(scene, report)
        }
    };
    nearby::add(scene, zones, fields, report, &mut zoning);
    report.zoning = Some(zoning);
}

/// No second solve: every error is infinite but those of what is given.
fn unknown(scene: &Scene, report: &Report) -> Zoning {
    let apart = |a: f64, b: f64| if a == 0.0 && b == 0.0 { 0.0 } else { f64::INFINITY };
    let given = report.heat.iter().flat_map(|table| table.rows.iter().zip(are_given(scene, table)));
    let heat = given.map(|(row, given)| [kelvin(row, given, f64::INFINITY), f64::INFINITY]);
    Zoning {
        zones: 0,
        ratio: f64::INFINITY,
        heat: heat.collect(),
        energy: report.energy.compared(&report.energy, apart),
        notes: Vec::new(),
    }
}

/// The error of a row's temperature: none where that is given, not a number where there is none.
fn kelvin(row: &HeatRow, given: bool, error: f64) -> f64 {
    match (given, row.temperature) {
        (true, _) => 0.0,
        (false, Some(_)) => error,
        (false, None) => f64::NAN,
    }
}

/// A scene on other zones than its own, and how the two compare.
struct Other<'a> {
    scene: &'a Scene,
    transport: Transport<'a>,
    zones: Zones,
    grown: Grown,
    /// True of smaller zones.
    finer: bool,
}

fn said(e: SceneError) -> String {
    e.to_string()
}

/// The scene with the settings of a second solve.
fn posed(other: Scene, report: &Report, slopes: bool) -> Result<Scene, String> {
    let mut options = other.options().clone();
    options.engine = Engine::ALL.into_iter().find(|e| e.word() == report.engine).unwrap_or_default();
    options.thick_zones = if slopes { ThickZones::Linear } else { ThickZones::Constant };
    options.zoning_error = Some(false);
    other.with_options(options).map_err(said)
}

impl<'a> Other<'a> {
    fn new(own: (&Scene, &Zones), other: &'a Scene, slopes: bool, finer: bool) -> Result<Other<'a>, String> {
        let transport = Transport::new(other);
        let zones = build_zones(other, &transport).map_err(said)?;
        let there = (other, &zones);
        let (small, large) = if finer { (there, own) } else { (own, there) };
        let grown = Grown::between(small, large, &transport, slopes, finer);
        Ok(Other { scene: other, transport, zones, grown, finer })
    }

    /// By how much fewer zones may be than where nothing stands between them.
    fn fewer(&self) -> usize {
        let between = self.transport.occluder_count() > 0 || self.transport.has_panes_between();
        if between { FEWER_BETWEEN } else { 1 }
    }

    /// Itself unless there are too many zones.
    fn few_enough(self) -> Result<Other<'a>, String> {
        if self.zones.len() * self.fewer() <= MOST_ZONES {
            Ok(self)
        } else {
            Err("smaller zones are too many".into())
        }
    }

    /// The errors that a solve on these zones tells.
    fn solved(self, scene: &Scene, report: &Report, job: &Job) -> Result<Zoning, String> {
        let Other { scene: other, transport, zones, grown, finer } = self;
        let ratio = grown.ratio?;
        let word = if finer { "smaller" } else { "larger" };
        let (progress, vault) = (Second(job.progress, word), Apart(job.vault, word));
        let second = Job { vault: &vault, initial: &[], progress: &progress, ..*job };
        let count = zones.len();
        let (_, other) = pipeline::settled(other, transport, zones, &second)
            .map_err(|e| format!("{word} zones do not serve ({e})"))?;
        let factor = grown.caution * if finer { SMALLER } else { 1.0 / (ratio - 1.0) };
        let apart = |a: f64, b: f64| differs(a, b) * factor;
        let least = Least::new(report, &other.report, &apart);
        let untold = |stuck: bool, error: f64| if stuck { f64::INFINITY } else { error };
        let tables = report.heat.iter().zip(&other.report.heat);
        let rows = tables.flat_map(|(own, other)| {
            let stuck = grown.stuck.of_rows(own);
            own.rows.iter().zip(&other.rows).zip(are_given(scene, own)).zip(stuck)
        });
        let heat = rows.map(|(((a, b), given), stuck)| {
            let [t, u] = [a, b].map(|row| row.temperature.unwrap_or(f64::NAN));
            let error = [least.kelvin(t, apart(t, u)), least.watts(a.power, apart(a.power, b.power))];
            // A power that is given has no error.
            let known = a.power_error == 0.0 && error[1] == 0.0;
            [kelvin(a, given, untold(stuck, error[0])), untold(stuck && !known, error[1])]
        });
        let mut energy = report.energy.compared(&other.report.energy, apart);
        least.widen(&mut energy, &report.energy);
        grown.stuck.widen(&mut energy);
        Ok(Zoning { zones: count, ratio, heat: heat.collect(), energy, notes: grown.notes })
    }
}

/// The least errors, from the mean relative errors of what is of one kind.
struct Least {
    kelvin: f64,
    watts: f64,
    energy: Bands,
}

impl Least {
    fn new(own: &Report, other: &Report, apart: &dyn Fn(f64, f64) -> f64) -> Least {
        let rows = || own.heat.iter().zip(&other.heat).flat_map(|(a, b)| a.rows.iter().zip(&b.rows));
        let share = |error: f64, all: f64| if all > 0.0 { MEAN_SHARE * error / all } else { 0.0 };
        let sum = |of: &dyn Fn(&HeatRow) -> f64| {
            let terms = rows().map(|(a, b)| (apart(of(a), of(b)), of(a).abs()));
            let (error, all) = terms.filter(|x| x.0 > 0.0).fold((0.0, 0.0), |s, x| (s.0 + x.0, s.1 + x.1));
            share(error, all)
        };
        let (a, b) = (&own.energy, &other.energy);
        let surfaces = a.absorbed_surfaces.iter().zip(&b.absorbed_surfaces).map(|(x, y)| (x.1, y.1));
        let rest = [(a.absorbed_volumes, b.absorbed_volumes), (a.absorbed_panes, b.absorbed_panes)];
        let all: Vec<_> = surfaces.chain(rest).collect();
        let energy = bands(|k| {
            share(all.iter().map(|x| apart(x.0[k], x.1[k])).sum(), all.iter().map(|x| x.0[k].abs()).sum())
        });
        let kelvin = sum(&|row| row.temperature.unwrap_or(0.0));
        Least { kelvin, watts: sum(&|row| row.power), energy }
    }

    /// An error of a temperature, K; of what does not err at all nothing is known to be wrong.
    fn kelvin(&self, value: f64, error: f64) -> f64 {
        if error > 0.0 { error.max(self.kelvin * value.abs()) } else { error }
    }

    /// An error of a power, W.
    fn watts(&self, value: f64, error: f64) -> f64 {
        if error > 0.0 { error.max(self.watts * value.abs()) } else { error }
    }

    /// Errors of powers of light.
    fn widen(&self, errors: &mut Energy, values: &Energy) {
        let wider = |e: &mut Bands, x: Bands| {
            *e = bands(|b| if e[b] > 0.0 { e[b].max(self.energy[b] * x[b].abs()) } else { e[b] });
        };
        errors
            .absorbed_surfaces
            .iter_mut()
            .zip(&values.absorbed_surfaces)
            .for_each(|(e, x)| wider(&mut e.1, x.1));
        wider(&mut errors.absorbed_volumes, values.absorbed_volumes);
        wider(&mut errors.absorbed_panes, values.absorbed_panes);
        wider(&mut errors.escaped, values.escaped);
        wider(&mut errors.backs, values.backs);
    }
}

/// Compares with larger zones where these tell all errors; else with smaller ones, where these are few enough; else with larger ones as far as
/// they tell.
fn compared(
    scene: &Scene,
    zones: &Zones,
    slopes: bool,
    report: &Report,
    job: &Job,
) -> Result<Zoning, String> {
    let own = (scene, zones);
    let coarser = posed(scene.coarser().map_err(said)?, report, slopes)?;
    let larger = Other::new(own, &coarser, slopes, false);
    if larger.as_ref().is_ok_and(|o| o.grown.tells_all()) {
        return larger?.solved(scene, report, job);
    }
    let fewer = larger.as_ref().map_or(FEWER_BETWEEN, Other::fewer);
    for n in divisions(scene, zones, fewer) {
        let finer = scene.finer(zones, n).map_err(said).and_then(|s| posed(s, report, slopes));
        let Ok(finer) = finer else { continue };
        let smaller = Other::new(own, &finer, slopes, true);
        let told = smaller.and_then(|o| o.few_enough()?.solved(scene, report, job));
        if let Ok(told) = told {
            return Ok(told);
        }
    }
    larger?.solved(scene, report, job)
}

/// By how much zones may be divided so that a solve on them takes next to no time, the most first; `fewer` is [`Other::fewer`].
fn divisions(scene: &Scene, zones: &Zones, fewer: usize) -> impl Iterator<Item = usize> {
    let serves = move |x: &(usize, usize)| divided(scene, zones, x.0).saturating_mul(fewer) <= x.1;
    DIVISIONS.into_iter().filter(serves).map(|x| x.0)
}

/// About how many zones there are when each is divided by `n` across.
fn divided(scene: &Scene, zones: &Zones, n: usize) -> usize {
    let sheets = zones.patches.len() + zones.panes.len();
    let axes = (0..3).filter(|&k| scene.voxmap().is_some_and(|m| m.dims()[k] > 1 || !scene.periodic()[k]));
    (n * n * sheets).saturating_add(n.pow(axes.count() as u32).saturating_mul(zones.voxels.len()))
}

/// About how many zones a second solve has where it takes smaller ones, which is where larger ones do not tell all.
pub(crate) fn smaller(scene: &Scene, zones: &Zones, slopes: bool) -> Option<usize> {
    divisions(scene, zones, 1).next()?;
    let coarser = scene.coarser();
    let larger = coarser.iter().find_map(|s| Other::new((scene, zones), s, slopes, false).ok());
    if larger.as_ref().is_some_and(|o| o.grown.tells_all()) {
        return None;
    }
    let n = divisions(scene, zones, larger.map_or(FEWER_BETWEEN, |o| o.fewer())).next()?;
    Some(divided(scene, zones, n))
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
