//! Growth of the zones between two solves, and the errors that their comparison does not cover.
//!
//! Cells grow by the minimum over the axes that have more than one; patches of a surface, and parts of a pane, by the root of the ratio of their
//! numbers. Parts that do not grow are equally coarse in both solves, and the difference of the solves does not show their error; they are reported. So are
//! zones that are too coarse for the asymptotic range: few or thick cells, patches much wider than the gap in front of them.

use zonal_math::Vec3;
use zonal_math::parallel;
use zonal_scene::{
    Bands, Diagnostic, EnergyBalance, HeatReport, HeatRow, HeatRowKind, Patch, Scene, VoxelGrid, ZoneBasis,
    Zones,
};
use zonal_transport::Transport;

/// Which zones the second solve has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SecondZones {
    Larger,
    Smaller,
}

/// The zones of the second solve, and the share of the area on smooth surfaces of few merged patches.
#[derive(Clone, Copy, Debug)]
pub(super) struct SecondZoneKind {
    pub second: SecondZones,
    pub few_groups_share: f64,
}

/// Growth below which zones count as unchanged.
const MIN_GROWTH: f64 = 1.2;

/// Minimum number of larger cells along an axis (of a grid with more than one), and maximum optical depth across them without slopes, for a
/// reliable estimate: beyond, known errors were up to ten times the estimate.
const MIN_LARGER_CELLS: usize = 3;
const MAX_CELL_THICKNESS: f64 = 1.0;
/// Minimum number of smaller cells along an axis.
const MIN_SMALLER_CELLS: usize = 4;

/// Patches wider than this multiple of the gap in front of them, on more than this share of the area, are too coarse.
const MAX_WIDTH_OVER_GAP: f64 = 2.0;
const MAX_WIDE_AREA_SHARE: f64 = 0.1;

/// Share of the area on smooth surfaces of few merged patches above which zones are few.
const MAX_FEW_GROUPS_SHARE: f64 = 0.1;

/// Factor on an estimate from few or thick zones, or from patches wider than the gap in front of them: known errors were up to ten times as large.
const SAFETY_FACTOR_LARGER: f64 = 10.0;
/// The same for an estimate from smaller zones.
const SAFETY_FACTOR_SMALLER: f64 = 3.0;

/// Share of the area with unchanged patches above which all errors are unknown, since the other zones receive their radiation.
const MAX_UNCHANGED_AREA_SHARE: f64 = 0.1;

/// Maximum number of names in a diagnostic.
const MAX_LISTED_NAMES: usize = 4;

/// Result of the comparison of two sets of zones.
pub(super) struct ZoneGrowth {
    /// Growth of the edges, or the reason why zones did not grow.
    pub ratio: Result<f64, String>,
    /// Errors that the comparison does not cover.
    pub notes: Vec<Diagnostic>,
    /// The unchanged surfaces and panes.
    pub sheets_note: Option<Diagnostic>,
    /// Parts of the scene that it does not cover.
    pub unchanged: UnchangedParts,
    /// Factor on the estimate: 1, or more for few or thick zones.
    pub safety_factor: f64,
}

/// A scene with its zones.
#[derive(Clone, Copy)]
pub(crate) struct DividedScene<'a> {
    pub scene: &'a Scene,
    pub zones: &'a Zones,
}

/// Parts of the scene with zones of the same size in both solves.
#[derive(Clone, Debug, Default)]
pub(super) struct UnchangedParts {
    /// Surfaces and panes, in the order of the scene.
    surfaces: Vec<bool>,
    panes: Vec<bool>,
    /// True if cells are unchanged.
    cells: bool,
    /// True if the cells or a large share of the patches are unchanged: then all errors are unknown.
    all: bool,
}

impl UnchangedParts {
    /// For each row of a table, whether its error is unknown.
    pub(super) fn of_rows(&self, table: &HeatReport) -> Vec<bool> {
        let (mut surfaces, mut panes) = (self.surfaces.iter(), self.panes.iter());
        let one = |row: &HeatRow| {
            let own = match row.kind {
                HeatRowKind::Surface => surfaces.next().is_none_or(|s| *s),
                HeatRowKind::Medium => false,
                HeatRowKind::Pane => panes.next().is_none_or(|s| *s),
            };
            own || self.all
        };
        table.rows.iter().map(one).collect()
    }

    /// Sets unknown errors of powers to infinity.
    pub(super) fn widen(&self, energy: &mut EnergyBalance) {
        let unknown = |x: &mut Bands| *x = Bands::splat(f64::INFINITY);
        if self.all {
            *energy = energy.zip_map(energy, |_, _| f64::INFINITY);
            return;
        }
        let named = energy.absorbed_surfaces.iter_mut().zip(&self.surfaces);
        named.filter(|x| *x.1).for_each(|x| unknown(&mut x.0.1));
        if self.panes.iter().any(|s| *s) {
            unknown(&mut energy.absorbed_panes);
        }
    }
}

impl ZoneGrowth {
    /// No growth and no notes.
    pub(super) fn none() -> ZoneGrowth {
        ZoneGrowth {
            ratio: Err(String::new()),
            notes: Vec::new(),
            sheets_note: None,
            unchanged: UnchangedParts::default(),
            safety_factor: 1.0,
        }
    }

    /// Unchanged surfaces and panes, in the order of the scene; `None` if there are none, or if cells are unchanged too.
    pub(super) fn unchanged_sheets(&self) -> Option<[&[bool]; 2]> {
        let UnchangedParts { surfaces, panes, cells, .. } = &self.unchanged;
        let any = surfaces.iter().chain(panes).any(|x| *x);
        (any && !cells).then_some([surfaces, panes])
    }

    /// The reason why all errors are unknown, if cells are unchanged.
    pub(super) fn unchanged_cells(&self) -> Option<String> {
        self.notes.first().filter(|_| self.unchanged.cells).map(|n| n.text.clone())
    }

    /// Records that a solve on smaller zones covers the unchanged surfaces and panes.
    pub(super) fn cover_unchanged_parts(&mut self) {
        let UnchangedParts { surfaces, panes, all, .. } = &mut self.unchanged;
        surfaces.fill(false);
        panes.fill(false);
        *all = false;
        self.sheets_note = None;
    }

    /// True if the comparison covers all errors without reservation.
    pub(super) fn is_complete(&self) -> bool {
        self.ratio.is_ok() && self.notes.is_empty() && self.sheets_note.is_none()
    }

    /// Compares zones with larger ones on the same facets; `second` says which of the two belong to the second solve.
    pub(super) fn between(
        small: DividedScene,
        large: DividedScene,
        transport: &Transport,
        basis: ZoneBasis,
        SecondZoneKind { second, few_groups_share }: SecondZoneKind,
    ) -> ZoneGrowth {
        let DividedScene { scene, zones } = small;
        let mut notes: Vec<Diagnostic> = Vec::new();
        // Compare the cells.
        let cells = cell_growth(scene, large.scene).filter(|r| *r >= MIN_GROWTH);
        if let Some(grid) = scene.voxel_grid() {
            let unchanged = unchanged_cells(scene, grid, cells.is_none());
            notes.extend(unchanged.map(|text| Diagnostic::warning("discretization", text)));
        }
        // Compare the patches and panes.
        let sheets = SheetGrowth::new(scene, zones, large.zones);
        let mut unchanged = sheets.unchanged.clone();
        unchanged.cells = !notes.is_empty();
        unchanged.all = unchanged.cells;
        let area = |of: &dyn Fn(usize) -> bool| -> f64 {
            zones.patches.iter().filter(|p| of(p.surface)).map(|p| p.area).sum()
        };
        unchanged.all |= area(&|s| unchanged.surfaces[s]) > MAX_UNCHANGED_AREA_SHARE * area(&|_| true);
        let sheets_note = unchanged_sheets(&sheets.names);
        let none = || {
            notes
                .first()
                .or(sheets_note.as_ref())
                .map_or_else(|| "there are no zones".into(), |n| n.text.clone())
        };
        let ratio = [cells, sheets.ratio].into_iter().flatten().min_by(f64::total_cmp).ok_or_else(none);
        // Judge the reliability of the estimate.
        let why = unreliable_zones(small, large, &sheets, basis, second);
        let why = why.or((few_groups_share > MAX_FEW_GROUPS_SHARE).then_some(FEW_ZONES));
        let why = why.or_else(|| wide_patches(zones, transport));
        let safety_factor = match (why, second) {
            (Some(_), SecondZones::Smaller) => SAFETY_FACTOR_SMALLER,
            (Some(_), SecondZones::Larger) => SAFETY_FACTOR_LARGER,
            (None, _) => 1.0,
        };
        notes.extend(why.map(|why| {
            let text = format!(
                "the discretization errors are rough and multiplied by {safety_factor}: {why}; smaller zones give a better estimate"
            );
            // A note, since the stated error includes the factor.
            Diagnostic::note("rough-discretization", text)
        }));
        ZoneGrowth { ratio, notes, sheets_note, unchanged, safety_factor }
    }
}

/// The reason if the larger of the two sets of zones, or the smaller one for a second solve on smaller zones, are few or thick.
fn unreliable_zones(
    small: DividedScene,
    large: DividedScene,
    sheets: &SheetGrowth,
    basis: ZoneBasis,
    second: SecondZones,
) -> Option<&'static str> {
    match second {
        SecondZones::Smaller => {
            let few = few_cells(small.scene, MIN_SMALLER_CELLS);
            few.or_else(|| thick_voxels(small.scene, small.zones, basis))
        }
        SecondZones::Larger => {
            let DividedScene { scene, zones } = large;
            let has_few_patches =
                sheets.names.is_empty() && small.scene.voxel_grid().is_none() && few_patches(scene, zones);
            let few = if has_few_patches { Some(FEW_ZONES) } else { few_cells(scene, MIN_LARGER_CELLS) };
            few.or_else(|| thick_voxels(scene, zones, basis))
        }
    }
}

/// Growth of patches and panes.
struct SheetGrowth {
    /// Growth of the edges of those that grew.
    ratio: Option<f64>,
    unchanged: UnchangedParts,
    /// Names of the unchanged surfaces and panes.
    names: Vec<String>,
}

impl SheetGrowth {
    fn new(scene: &Scene, zones: &Zones, others: &Zones) -> SheetGrowth {
        let mut unchanged = UnchangedParts::default();
        let (mut before, mut after, mut names) = (0, 0, Vec::new());
        for (k, (name, old, new, may_stay)) in sheet_counts(scene, zones, others).into_iter().enumerate() {
            let list =
                if k < scene.surfaces().len() { &mut unchanged.surfaces } else { &mut unchanged.panes };
            let grew = (old as f64 / new.max(1) as f64).sqrt() >= MIN_GROWTH;
            list.push(!grew && old > 0 && !may_stay);
            if grew {
                (before, after) = (before + old, after + new);
            } else if old > 0 && !may_stay {
                names.push(name);
            }
        }
        let ratio = (after > 0).then(|| (before as f64 / after as f64).sqrt());
        SheetGrowth { ratio, unchanged, names }
    }
}

/// The diagnostic of unchanged surfaces and panes.
fn unchanged_sheets(names: &[String]) -> Option<Diagnostic> {
    if names.is_empty() {
        return None;
    }
    let (listed, rest) = names.split_at(names.len().min(MAX_LISTED_NAMES));
    let more = if rest.is_empty() { String::new() } else { format!(" and {} more", rest.len()) };
    let text = format!(
        "the second solve has zones of the same size on {}{more}, and their errors are unknown: give them a smaller patch_size",
        listed.join(", ")
    );
    Some(Diagnostic::warning("discretization", text))
}

/// The minimum growth of cells along the axes that have more than one.
fn cell_growth(scene: &Scene, other: &Scene) -> Option<f64> {
    let dims = |s: &Scene| s.voxel_grid().map(VoxelGrid::dims);
    let (a, b) = (dims(scene)?, dims(other)?);
    let ratios = (0..3).filter(|&k| a[k] > 1).map(|k| a[k] as f64 / b[k] as f64);
    ratios.min_by(f64::total_cmp)
}

/// The reason why cells did not grow; along periodic axes a single cell is sufficient.
fn unchanged_cells(scene: &Scene, grid: &VoxelGrid, none_grew: bool) -> Option<String> {
    let single = (0..3).any(|k| grid.dims()[k] == 1 && !scene.endless_axes()[k]);
    if none_grew && grid.len() > 1 {
        return Some(
            "cells of known temperature lie beside cells of known heat, which cannot be merged: the discretization errors are unknown"
                .into(),
        );
    }
    single.then(|| "the medium has one cell across an axis: the discretization errors are unknown".into())
}

/// True if the zones `new` divide every one of these surfaces and panes, `old` being zones that do not.
pub(super) fn divides_all(scene: &Scene, [old, new]: [&Zones; 2], [surfaces, panes]: [&[bool]; 2]) -> bool {
    let is_divided = |(_, new, old, _): (String, usize, usize, bool)| {
        (new as f64 / old.max(1) as f64).sqrt() >= MIN_GROWTH
    };
    let counts = sheet_counts(scene, new, old).into_iter();
    counts.zip(surfaces.iter().chain(panes)).all(|(count, wanted)| !wanted || is_divided(count))
}

/// For each surface and pane: its name, the number of its zones before and after, and whether it may stay undivided: across periodic axes the
/// radiation is uniform.
fn sheet_counts(scene: &Scene, zones: &Zones, others: &Zones) -> Vec<(String, usize, usize, bool)> {
    let surfaces = |z: &Zones| {
        let mut out = vec![0; scene.surfaces().len()];
        z.patches.iter().for_each(|p| out[p.surface] += 1);
        let merged = z.merged.groups().iter();
        merged.for_each(|g| out[z.patches[g[0] as usize].surface] -= g.len() - 1);
        out
    };
    let panes = |z: &Zones| {
        let mut out = vec![0; scene.panes().len()];
        z.panes.iter().for_each(|p| out[p.pane] += 1);
        out
    };
    let mut free = vec![scene.endless_axes() != [false; 3]; scene.surfaces().len()];
    zones.patches.iter().for_each(|p| free[p.surface] &= is_periodic_across(scene, p.normal));
    let names = scene.surfaces().iter().map(|s| &s.name);
    let counts = surfaces(zones).into_iter().zip(surfaces(others)).zip(free);
    let walls = names.zip(counts).map(|(n, ((a, b), free))| (n.clone(), a, b, free));
    let mut free = vec![scene.endless_axes() != [false; 3]; scene.panes().len()];
    zones.panes.iter().for_each(|p| free[p.pane] &= is_periodic_across(scene, p.normal));
    let counts = panes(zones).into_iter().zip(panes(others)).zip(free);
    let glass = scene.panes().iter().zip(counts).map(|(p, ((a, b), free))| (p.name.clone(), a, b, free));
    walls.chain(glass).collect()
}

/// True if a scene is periodic along both axes across a normal.
fn is_periodic_across(scene: &Scene, normal: Vec3) -> bool {
    (0..3).all(|k| scene.endless_axes()[k] || normal[k].abs() > 1.0 - 1e-9)
}

/// Reason of an estimate from few zones.
const FEW_ZONES: &str = "zones are few";

/// True if facets have fewer than two patches on average, without those whose patches are merged.
fn few_patches(scene: &Scene, zones: &Zones) -> bool {
    let merged: usize = zones.merged.groups().iter().map(Vec::len).sum();
    let count = |n: usize| n.saturating_sub(merged);
    merged == 0 && zones.patches.len() < 2 * scene.facets().len()
        || count(zones.patches.len()) < 2 * count(scene.facets().len())
}

/// The reason if a scene has fewer than `least` cells along an axis.
fn few_cells(scene: &Scene, least: usize) -> Option<&'static str> {
    let has_few = |grid: &VoxelGrid| (0..3).any(|k| grid.dims()[k] < least && !scene.endless_axes()[k]);
    scene.voxel_grid().is_some_and(has_few).then_some(FEW_ZONES)
}

/// The reason if voxels without slopes are optically thick.
fn thick_voxels(scene: &Scene, zones: &Zones, basis: ZoneBasis) -> Option<&'static str> {
    let is_thick =
        basis != ZoneBasis::Linear && zones.voxels.max_thickness(scene.voxel_grid()) > MAX_CELL_THICKNESS;
    is_thick.then_some("voxels are thick")
}

/// The reason if patches are much wider than the gap in front of them.
fn wide_patches(zones: &Zones, transport: &Transport) -> Option<&'static str> {
    let width = |p: &Patch| p.plate.e1.length().max(p.plate.e2.length());
    let is_wide = |p: &Patch| {
        let reach = width(p) / MAX_WIDTH_OVER_GAP;
        transport.closest_hit(p.plate.centre(), p.normal, 1e-6 * reach, reach).is_some()
    };
    let is_wide: Vec<bool> = parallel::map(&zones.patches, is_wide);
    let all: f64 = zones.patches.iter().map(|p| p.area).sum();
    let wide: f64 = zones.patches.iter().zip(is_wide).filter(|x| x.1).map(|x| x.0.area).sum();
    (wide > MAX_WIDE_AREA_SHARE * all).then_some("patches are wider than twice the gap before them")
}
