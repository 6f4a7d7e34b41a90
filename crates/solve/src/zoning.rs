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
//! fail, and of zones that the geometry does not let grow it knows nothing.
//!
//! r is the least growth of an edge: of cells along the axes that have more than one, of patches by the square root of their number.

use crate::forecast::thickness;
use crate::pipeline::{Job, solve_job};
use zonal_scene::scene::ThickZones;
use zonal_scene::solution::Energy;
use zonal_scene::{
    Engine, NoVault, Progress, Report, Scene, SceneError, Solution, Voxmap, Zones, Zoning, bands,
};

/// Zones that grow by less than this are as large as before.
const GROWN: f64 = 1.2;

/// The fewest of the larger cells along an axis, where it has more than one, and the most optical depths across them, that a fair estimate
/// without slopes takes: with fewer, or thicker ones, known errors were up to ten times what was estimated.
const FEWEST: usize = 3;
const THICKEST: f64 = 1.0;

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

/// Solves the scene again on larger zones, by the same engine and with slopes if `slopes`, and puts into the report what that tells.
pub(crate) fn estimate(scene: &Scene, zones: &Zones, slopes: bool, report: &mut Report, job: &Job) {
    match second(scene, zones, slopes, report, job) {
        Ok((zoning, notes)) => {
            report.zoning = Some(zoning);
            report.warnings.extend(notes);
        }
        Err(why) => report.warnings.push(format!("what the size of the zones costs is not known: {why}")),
    }
}

fn second(
    scene: &Scene,
    zones: &Zones,
    slopes: bool,
    report: &Report,
    job: &Job,
) -> Result<(Zoning, Vec<String>), String> {
    let of = |e: SceneError| format!("larger ones do not serve ({e})");
    let coarser = scene.coarser().map_err(of)?;
    let mut options = coarser.options().clone();
    options.engine = Engine::ALL.into_iter().find(|e| e.word() == report.engine).unwrap_or_default();
    options.thick_zones = if slopes { ThickZones::Linear } else { ThickZones::Constant };
    options.zoning_error = Some(false);
    let coarser = coarser.with_options(options).map_err(of)?;
    if grown_cells(scene, &coarser).is_none() && coarser.facets().is_empty() {
        return Err("the medium is one voxel; use more cells".into());
    }
    let progress = Second(job.progress);
    let larger = Job { vault: &NoVault, initial: &[], progress: &progress, ..*job };
    let other = solve_job(coarser, &larger).map_err(of)?;
    let grown = Grown::between(scene, zones, &other, slopes);
    let Some(ratio) = grown.ratio() else {
        return Err(
            "the geometry and the medium let none be larger; give a smaller patch_size, or more cells".into(),
        );
    };
    let factor = 1.0 / (ratio - 1.0);
    let apart = |a: f64, b: f64| factor * (a - b).abs();
    let energy = differences(&report.energy, &other.report.energy, factor);
    let heat = match (&report.heat, &other.report.heat) {
        (Some(own), Some(other)) => {
            let rows = own.rows.iter().zip(&other.rows);
            let kelvin = |t: Option<f64>| t.unwrap_or(f64::NAN);
            rows.map(|(a, b)| [apart(kelvin(a.temperature), kelvin(b.temperature)), apart(a.power, b.power)])
                .collect()
        }
        _ => Vec::new(),
    };
    Ok((Zoning { zones: other.zones.len(), ratio, heat, energy }, grown.notes()))
}

/// How much larger zones are, kind by kind; none where there are none, or where they are as large as before.
struct Grown {
    cells: Option<f64>,
    patches: Option<f64>,
    /// Whether there are cells, and patches, that could not grow.
    stuck: [bool; 2],
    /// Whether the larger zones are too few, or too thick, to be on their way to the answer.
    rough: bool,
}

/// The least growth of cells along the axes that have more than one.
fn grown_cells(scene: &Scene, other: &Scene) -> Option<f64> {
    let dims = |s: &Scene| s.voxmap().map(Voxmap::dims);
    let (a, b) = (dims(scene)?, dims(other)?);
    let ratios = (0..3).filter(|&k| a[k] > 1).map(|k| a[k] as f64 / b[k] as f64);
    ratios.min_by(f64::total_cmp)
}

impl Grown {
    fn between(scene: &Scene, zones: &Zones, other: &Solution, slopes: bool) -> Grown {
        let (other, others) = (&other.scene, &other.zones);
        let sheets = |z: &Zones| (z.patches.len() + z.panes.len()) as f64;
        let real = |r: &f64| *r >= GROWN;
        let patches = Some((sheets(zones) / sheets(others).max(1.0)).sqrt()).filter(real);
        let cells = grown_cells(scene, other).filter(real);
        // What repeats itself is one zone across for a reason.
        let free = !scene.is_periodic();
        let single = scene.voxmap().is_some_and(|v| v.dims().contains(&1));
        let few = match (scene.voxmap(), other.voxmap()) {
            (Some(a), Some(b)) => (0..3).any(|k| a.dims()[k] > 1 && b.dims()[k] < FEWEST),
            _ => others.patches.len() < 2 * other.facets().len(),
        };
        let rough = !slopes && (few || thickness(other, others) > THICKEST);
        Grown {
            cells,
            patches,
            stuck: [free && single, free && patches.is_none() && sheets(zones) > 0.0],
            rough,
        }
    }
    fn ratio(&self) -> Option<f64> {
        [self.cells, self.patches].into_iter().flatten().min_by(f64::total_cmp)
    }
    fn notes(&self) -> Vec<String> {
        let mut out = Vec::new();
        if self.stuck[0] {
            out.push(
                "the medium has one cell across an axis: what that costs is not in the errors of zones"
                    .into(),
            );
        }
        if self.stuck[1] {
            out.push(
                "patches are as large as the geometry lets them be: what that costs is not in the errors of zones"
                    .into(),
            );
        }
        if self.rough {
            out.push("zones are so large that their errors are themselves rough; use more cells, or a smaller patch_size".into());
        }
        out
    }
}

/// `factor` times how far powers are apart.
fn differences(a: &Energy, b: &Energy, factor: f64) -> Energy {
    let apart = |a: &[f64; 3], b: &[f64; 3]| bands(|k| factor * (a[k] - b[k]).abs());
    let surfaces = a.absorbed_surfaces.iter().zip(&b.absorbed_surfaces);
    Energy {
        emitted: apart(&a.emitted, &b.emitted),
        incoming: apart(&a.incoming, &b.incoming),
        absorbed_surfaces: surfaces.map(|(a, b)| (a.0.clone(), apart(&a.1, &b.1))).collect(),
        absorbed_volumes: apart(&a.absorbed_volumes, &b.absorbed_volumes),
        absorbed_panes: apart(&a.absorbed_panes, &b.absorbed_panes),
        escaped: apart(&a.escaped, &b.escaped),
        backs: apart(&a.backs, &b.backs),
        residual: [0.0; 3],
    }
}
