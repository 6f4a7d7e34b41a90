//! The zones of the second solve, and the errors that follow from it.

use super::difference_error::{DifferenceError, SecondSolveMargin};
use super::error_floor::ErrorFloor;
use super::merged_facets::merge_unchanged;
use super::prescribed_temperatures::{row_temperatures, temperature_error};
use super::second_solve::SecondSolveProgress;
use super::solve_method::SolveMethod;
use super::zone_growth::{DividedScene, SecondZoneKind, SecondZones, ZoneGrowth, divides_all};
use crate::settings::named_stages::{NamedStages, SolvePart};
use crate::settings::{SolvePurpose, SolveSettings};
use zonal_scene::{
    DiscretizationError, Engine, EvenExtension, Report, Scene, SceneError, SurfaceEmissivity, Thermal,
    ZoneBasis, Zones,
};
use zonal_transport::{Transport, build_zones};

/// Factor on the difference to smaller zones (module header).
const SMALLER_ZONES_FACTOR: f64 = 2.0;

/// Divisors of the zones for a solve on smaller ones, and the maximum number of these.
const DIVISIONS: [(usize, usize); 3] = [(8, 1000), (4, 1000), (2, MAX_SECOND_ZONES)];
const MAX_SECOND_ZONES: usize = 2500;
/// Smallest residual of a second solve. The power that it leaves undistributed is added to the differences (`difference_error`).
const MIN_SECOND_RESIDUAL: f64 = 1e-7;
/// Divisor of the patches of parts that did not grow.
const PARTS_DIVISION: usize = 2;
/// Reduction of the maximum if facets or panes occlude pairs, which then cost several times as much.
const OCCLUSION_COST: usize = 3;

/// Solves zones of a scene and returns the report of every block of its bands.
pub(crate) type SolveFn<'a> =
    dyn Fn(&Scene, Transport, Zones, &SolveSettings) -> Result<Vec<Report>, SceneError> + 'a;

fn text_of(e: SceneError) -> String {
    e.to_string()
}

/// The scene with the options of a second solve: engines and basis of the first one, a looser residual, and no discretization error.
fn second_scene(other: Scene, method: &SolveMethod) -> Result<Scene, String> {
    let changed = |(scene, engine): (Scene, &Engine)| {
        let mut options = scene.options().clone();
        options.engine = *engine;
        options.zone_basis = method.basis;
        options.discretization_error = Some(false);
        // Reflectances that follow temperatures stop changing at the residual, which is not reported.
        let follows = |t: &Thermal| t.emissivities.iter().any(SurfaceEmissivity::depends_on_temperature);
        if !scene.thermal().is_some_and(follows) {
            options.residual = options.residual.max(MIN_SECOND_RESIDUAL);
        }
        scene.with_options(options)
    };
    let blocks = other.blocks().zip(&method.engines).map(changed).collect::<Result<_, _>>();
    blocks.and_then(Scene::from_blocks).map_err(text_of)
}

/// A scene with other zones, and their growth.
struct ComparisonZones<'a> {
    scene: &'a Scene,
    transport: Transport<'a>,
    zones: Zones,
    growth: ZoneGrowth,
    second: SecondZones,
}

impl<'a> ComparisonZones<'a> {
    fn new(
        own: DividedScene,
        other: &'a Scene,
        basis: ZoneBasis,
        second: SecondZones,
    ) -> Result<ComparisonZones<'a>, String> {
        let transport = Transport::new(other);
        let mut zones = build_zones(other, &transport).map_err(text_of)?;
        let mut few_groups_share = 0.0;
        if second == SecondZones::Larger {
            let found = merge_unchanged(own.zones, &zones);
            (zones.merged, few_groups_share) = (found.merged, found.few_groups_share);
        }
        let others = DividedScene { scene: other, zones: &zones };
        let (small, large) = if second == SecondZones::Smaller { (others, own) } else { (own, others) };
        // Beside a symmetry plane a patch may face its own image.
        let kind = SecondZoneKind { second, few_groups_share };
        let growth = match EvenExtension::of(other).map_err(text_of)? {
            Some(extension) => {
                ZoneGrowth::between(small, large, &Transport::new(&extension.scene), basis, kind)
            }
            None => ZoneGrowth::between(small, large, &transport, basis, kind),
        };
        Ok(ComparisonZones { scene: other, transport, zones, growth, second })
    }

    /// Cost of a pair relative to an unoccluded one.
    fn pair_cost(&self) -> usize {
        let is_occluded = self.transport.occluder_count() > 0 || self.transport.has_interior_panes();
        if is_occluded { OCCLUSION_COST } else { 1 }
    }

    /// Itself, or an error if there are too many zones.
    fn limited(self) -> Result<ComparisonZones<'a>, String> {
        if self.zones.len() * self.pair_cost() <= MAX_SECOND_ZONES {
            Ok(self)
        } else {
            Err("smaller zones are too many".into())
        }
    }

    /// Number of zones with merged patches counted once.
    fn zone_count(&self) -> usize {
        self.zones.len() - self.zones.merged.removed()
    }

    /// The reports of a solve on these zones; `kind` names them.
    fn reports(
        self,
        kind: &'static str,
        settings: &SolveSettings,
        solve: &SolveFn,
    ) -> Result<Vec<Report>, String> {
        let progress = SecondSolveProgress { observer: settings.progress, kind };
        let checkpoints = NamedStages { store: settings.checkpoints, part: SolvePart::SecondSolve(kind) };
        let settings = SolveSettings {
            checkpoints: &checkpoints,
            initial_groups: &[],
            progress: &progress,
            purpose: SolvePurpose::Comparison,
            ..*settings
        };
        solve(self.scene, self.transport, self.zones, &settings)
            .map_err(|e| format!("the solve on {kind} zones failed ({e})"))
    }

    /// Solves on these zones. `divided` are the same zones with the parts divided that did not grow: a third solve on them estimates the errors of these parts.
    fn solve(
        mut self,
        settings: &SolveSettings,
        solve: &SolveFn,
        divided: Option<ComparisonZones>,
    ) -> Result<SecondSolve, String> {
        let ratio = self.growth.ratio.clone()?;
        // Where cells did not grow every error is unknown, whatever the second solve.
        if let Some(reason) = self.growth.unchanged_cells() {
            return Err(reason);
        }
        let second = self.second;
        let kind = if second == SecondZones::Smaller { "smaller" } else { "larger" };
        let mut growth = std::mem::replace(&mut self.growth, ZoneGrowth::none());
        let zones = self.zone_count();
        let reports = self.reports(kind, settings, solve)?;
        let third = divided.and_then(|d| d.reports("divided", settings, solve).ok());
        if third.is_some() {
            growth.cover_unchanged_parts();
        }
        Ok(SecondSolve { zones, ratio, second, growth, reports, third })
    }
}

/// A second solve, before it is compared with the first one.
pub(crate) struct SecondSolve {
    /// Number of its zones.
    zones: usize,
    /// The ratio of the sizes of the zones.
    ratio: f64,
    second: SecondZones,
    growth: ZoneGrowth,
    /// Its reports, one for each block of bands.
    reports: Vec<Report>,
    /// Those of a third solve.
    third: Option<Vec<Report>>,
}

impl SecondSolve {
    /// The errors of the first solve, of which `reports` are the reports of all blocks of bands.
    pub(super) fn errors(self, scene: &Scene, reports: &[&Report]) -> Vec<DiscretizationError> {
        let SecondSolve { zones, ratio, second, growth, reports: others, third } = self;
        let factor = growth.safety_factor
            * if second == SecondZones::Smaller { SMALLER_ZONES_FACTOR } else { 1.0 / (ratio - 1.0) };
        let margin = SecondSolveMargin::of(&others);
        let third = third.map(|reports| (margin.plus(SecondSolveMargin::of(&reports)), reports));
        let of_block = |(t, (report, other)): (usize, (&&Report, &Report))| {
            let error = DifferenceError { factor, margin };
            let floor = ErrorFloor::new(report, other, &error);
            let mut heat = heat_errors(scene, report, other, &growth, &error, &floor);
            let mut energy = report.energy.zip_map(&other.energy, |a, b| error.of_powers(a, b));
            floor.widen(&mut energy, &report.energy);
            growth.unchanged.widen(&mut energy);
            if let Some((margin, reports)) = &third {
                let more = DifferenceError { factor: SMALLER_ZONES_FACTOR, margin: *margin };
                add_differences(&mut heat, other, &reports[t], &more);
                let more = other.energy.zip_map(&reports[t].energy, |a, b| more.of_powers(a, b));
                energy = energy.zip_map(&more, |a, b| a + b);
            }
            DiscretizationError { zones, ratio, heat, energy, notes: Vec::new() }
        };
        let mut errors: Vec<DiscretizationError> =
            reports.iter().zip(&others).enumerate().map(of_block).collect();
        errors[0].notes = growth.sheets_note.into_iter().chain(growth.notes).collect();
        errors
    }
}

/// Adds the differences of two solves to errors of temperature (K) and net power (W) of each row; an error of 0 of a temperature that is the same in both stays 0.
fn add_differences(heat: &mut [[f64; 2]], a: &Report, b: &Report, more: &DifferenceError) {
    let tables = a.heat.iter().zip(&b.heat);
    let rows = tables.flat_map(|(a, b)| a.rows.iter().zip(&b.rows));
    for (error, (a, b)) in heat.iter_mut().zip(rows) {
        if let Some((t, u)) = a.temperature.zip(b.temperature) {
            error[0] += more.of_temperatures(t, u);
        }
        error[1] += more.of_powers(a.power, b.power);
    }
}

/// Errors of temperature (K) and net power (W) of each row of the heat table.
fn heat_errors(
    scene: &Scene,
    report: &Report,
    other: &Report,
    growth: &ZoneGrowth,
    error: &DifferenceError,
    floor: &ErrorFloor,
) -> Vec<[f64; 2]> {
    let or_unknown = |is_unknown: bool, error: f64| if is_unknown { f64::INFINITY } else { error };
    let tables = report.heat.iter().zip(&other.heat);
    let rows = tables.flat_map(|(own, other)| {
        let unknown = growth.unchanged.of_rows(own);
        own.rows.iter().zip(&other.rows).zip(row_temperatures(scene, own)).zip(unknown)
    });
    let heat = rows.map(|(((a, b), is_prescribed), is_unknown)| {
        let [t, u] = [a, b].map(|row| row.temperature.unwrap_or(f64::NAN));
        let errors = [
            floor.temperature(t, error.of_temperatures(t, u)),
            floor.power(a.power, error.of_powers(a.power, b.power)),
        ];
        // A prescribed power has no error.
        let is_known = a.power_error == 0.0 && errors[1] == 0.0;
        [
            temperature_error(a, is_prescribed, or_unknown(is_unknown, errors[0])),
            or_unknown(is_unknown && !is_known, errors[1]),
        ]
    });
    heat.collect()
}

/// Solves on larger zones if they cover all errors; else on smaller ones if these are few enough; else on larger ones as far as possible, and on
/// smaller ones of the parts that did not grow. `method` is that of the first solve, on zones `own`.
///
/// # Errors
/// If no zones give an estimate.
pub(crate) fn second_solve(
    own: DividedScene,
    method: &SolveMethod,
    settings: &SolveSettings,
    solve: &SolveFn,
) -> Result<SecondSolve, String> {
    let (DividedScene { scene, zones }, basis) = (own, method.basis);
    let coarser = second_scene(scene.coarsened().map_err(text_of)?, method)?;
    let larger = ComparisonZones::new(own, &coarser, basis, SecondZones::Larger);
    if larger.as_ref().is_ok_and(|o| o.growth.is_complete()) {
        return larger?.solve(settings, solve, None);
    }
    let pair_cost = larger.as_ref().map_or(OCCLUSION_COST, ComparisonZones::pair_cost);
    for n in divisions(scene, zones, pair_cost) {
        let finer = scene.refined(zones, n).map_err(text_of).and_then(|s| second_scene(s, method));
        let Ok(finer) = finer else { continue };
        let smaller = ComparisonZones::new(own, &finer, basis, SecondZones::Smaller);
        let found = smaller.and_then(|o| o.limited()?.solve(settings, solve, None));
        if let Ok(found) = found {
            return Ok(found);
        }
    }
    let larger = larger?;
    let divided = divided_scene(&larger, method);
    let divided = divided.as_ref().and_then(|s| divided_zones(&larger, zones, s));
    larger.solve(settings, solve, divided)
}

/// The scene of larger zones with the patches of unchanged surfaces and panes divided; `None` if all surfaces, panes and cells grew.
fn divided_scene(larger: &ComparisonZones, method: &SolveMethod) -> Option<Scene> {
    let unchanged = larger.growth.unchanged_sheets()?;
    let divided = larger.scene.with_divided_patches(&larger.zones, unchanged, PARTS_DIVISION).ok()?;
    second_scene(divided, method).ok()
}

/// Its zones, if they are few: as those of the first solve, or of any second one.
fn divided_zones<'a>(
    larger: &ComparisonZones,
    zones: &Zones,
    scene: &'a Scene,
) -> Option<ComparisonZones<'a>> {
    let transport = Transport::new(scene);
    let mut others = build_zones(scene, &transport).ok()?;
    others.merged = merge_unchanged(zones, &others).merged;
    let growth = ZoneGrowth::none();
    let out = ComparisonZones { scene, transport, zones: others, growth, second: SecondZones::Larger };
    let sheets = larger.growth.unchanged_sheets()?;
    let divides = divides_all(scene, [&larger.zones, &out.zones], sheets);
    let is_cheap =
        out.zone_count() <= zones.len() || out.zone_count() * larger.pair_cost() <= MAX_SECOND_ZONES;
    (divides && is_cheap).then_some(out)
}

/// Divisors of the zones for which a second solve is cheap, the largest first; `pair_cost` is [`ComparisonZones::pair_cost`].
fn divisions(scene: &Scene, zones: &Zones, pair_cost: usize) -> impl Iterator<Item = usize> {
    let is_cheap =
        move |x: &(usize, usize)| divided_count(scene, zones, x.0).saturating_mul(pair_cost) <= x.1;
    DIVISIONS.into_iter().filter(is_cheap).map(|x| x.0)
}

/// Expected number of zones if each is divided by `n` along its edges.
fn divided_count(scene: &Scene, zones: &Zones, n: usize) -> usize {
    let sheets = zones.patches.len() + zones.panes.len();
    let divides = |k: usize| scene.voxel_grid().is_some_and(|m| m.dims()[k] > 1 || !scene.endless_axes()[k]);
    let axes = (0..3).filter(|&k| divides(k));
    (n * n * sheets).saturating_add(n.pow(axes.count() as u32).saturating_mul(zones.voxels.len()))
}

/// Expected number of zones of a second solve on smaller zones; `None` if it uses larger ones.
pub(crate) fn refined_zone_count(scene: &Scene, zones: &Zones, basis: ZoneBasis) -> Option<usize> {
    divisions(scene, zones, 1).next()?;
    let (own, coarser) = (DividedScene { scene, zones }, scene.coarsened());
    let larger = coarser.iter().find_map(|s| ComparisonZones::new(own, s, basis, SecondZones::Larger).ok());
    if larger.as_ref().is_some_and(|o| o.growth.is_complete()) {
        return None;
    }
    let n = divisions(scene, zones, larger.map_or(OCCLUSION_COST, |o| o.pair_cost())).next()?;
    Some(divided_count(scene, zones, n))
}
