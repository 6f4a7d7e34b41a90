//! One mesh at several tolerances, compared with its reference.

use zonal_math::{Bounded, Grade};
use zonal_reference::Rng;
use zonal_reference::crossed_strings::{self, Wall};
use zonal_reference::random_meshes::{MESH_KINDS, RandomMesh, RandomSection, SECTION_KINDS};
use zonal_reference::visible_views::{OracleFactor, OracleRow, VisibleScene};
use zonal_scene::{NoCheckpoints, NoProgress};
use zonal_view_factors::{FacetSet, RowClosing, ViewFactorSettings, ViewFactors};

/// Smallest tolerance for which the reference of meshes in space with hidden parts is accurate enough.
const LEAST_SPATIAL_TOLERANCE: f64 = 1e-4;
/// The same for empty rooms.
const LEAST_EMPTY_TOLERANCE: f64 = 1e-7;
/// The same for cross-sections as triangles, but for one of this many turns: many evaluations at a small tolerance take long.
const LEAST_COARSE_TOLERANCE: f64 = 1e-4;
const TURNS_OF_FINE: u64 = 5;
/// Error of the spatial reference relative to the least tolerance.
const REFERENCE_SHARE: f64 = 0.01;
/// Divided triangles of the spatial reference for a row, at most: fewer in meshes of many facets, whose views cost more.
const MAX_TRIANGLES: usize = 800;
const MAX_TRIANGLE_VIEWS: usize = 40_000;
/// Share of the smaller area below which factors are left out, relative to the tolerance.
const OMITTED: f64 = 1.0 / 500.0;
/// Meshes of each turn: one of each kind in space, and this many cross-sections of each kind.
const SECTIONS_PER_TURN: usize = 3;
const MESHES_PER_TURN: usize = MESH_KINDS.len() + 2 * SECTIONS_PER_TURN * SECTION_KINDS.len();

/// A mesh of the campaign.
#[derive(Clone, Debug)]
pub(crate) struct RandomCase {
    index: u64,
    seed: u64,
    /// Number in the list of kinds: those in space, then cross-sections as rectangles, then as triangles.
    kind: usize,
}

/// One factor against its reference.
#[derive(Clone, Debug)]
pub(crate) struct FactorCheck {
    pub mesh: u64,
    pub kind: String,
    pub tolerance: f64,
    pub what: String,
    pub proved: bool,
    pub ours: f64,
    pub radius: f64,
    pub exact: f64,
    pub error: f64,
}

impl FactorCheck {
    /// |difference| beyond the error of the reference, relative to the radius.
    pub(crate) fn ratio(&self) -> f64 {
        let beyond = (self.ours - self.exact).abs() - self.error;
        if beyond <= 0.0 { 0.0 } else { beyond / self.radius.max(f64::MIN_POSITIVE) }
    }

    /// True if the reference is accurate enough to tell a wrong radius.
    pub(crate) fn is_sharp(&self) -> bool {
        self.error <= self.radius.max(0.02 * self.tolerance)
    }
}

impl std::fmt::Display for FactorCheck {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let FactorCheck { mesh, kind, tolerance, what, ours, radius, exact, error, .. } = self;
        let grade = if self.proved { "proved" } else { "estimated" };
        write!(
            f,
            "mesh {mesh} ({kind}), tolerance {tolerance:e}, {what}: {ours:e} ± {radius:e} ({grade}), not {exact:e} ± {error:e}"
        )
    }
}

impl RandomCase {
    /// The mesh of a number.
    pub(crate) fn new(seed: u64, index: u64) -> RandomCase {
        let place = (index % MESHES_PER_TURN as u64) as usize;
        let kind = match place.checked_sub(MESH_KINDS.len()) {
            None => place,
            Some(k) => MESH_KINDS.len() + k % (2 * SECTION_KINDS.len()),
        };
        RandomCase { index, seed: seed.wrapping_mul(1_000_003).wrapping_add(index), kind }
    }

    /// All factors of the mesh at the tolerances that its reference allows.
    pub(crate) fn check(&self, tolerances: &[f64]) -> Vec<FactorCheck> {
        let mut rng = Rng::new(self.seed);
        // Cross-sections as triangles are computed at all tolerances in some turns.
        let fine = (self.index / MESHES_PER_TURN as u64).is_multiple_of(TURNS_OF_FINE);
        let reference = match self.kind.checked_sub(MESH_KINDS.len()) {
            None => in_space(self.kind, tolerances.iter().copied().fold(1.0, f64::min), &mut rng),
            Some(k) => section(k / 2, k % 2 == 1, fine, &mut rng),
        };
        let mut checks = Vec::new();
        for &tolerance in tolerances.iter().filter(|t| **t >= 0.99 * reference.least_tolerance) {
            let closure = if rng.uniform() < 0.25 { RowClosing::Restore } else { RowClosing::Keep };
            let settings =
                ViewFactorSettings { tolerance, closure, periods: reference.periods, ..Default::default() };
            let f = reference.set.compute(&settings, &NoProgress, &NoCheckpoints).expect("a valid mesh");
            let f = f.combined(&reference.groups, reference.rows.len());
            compare(self.index, &reference, tolerance, &f, &mut checks);
        }
        checks
    }
}

/// A mesh with what is known of it.
struct Reference {
    kind: String,
    set: FacetSet,
    /// Surface of each facet in the compared rows.
    groups: Vec<u32>,
    rows: Vec<ReferenceRow>,
    periods: [Option<f64>; 2],
    least_tolerance: f64,
}

struct ReferenceRow {
    area: f64,
    facets: Vec<OracleFactor>,
    /// Sky and ground.
    around: Option<[OracleFactor; 2]>,
}

/// A mesh in space, with a reference for tolerances down to `least`.
fn in_space(kind: usize, least: f64, rng: &mut Rng) -> Reference {
    let mesh = RandomMesh::new(kind, rng);
    let least_tolerance =
        if MESH_KINDS[kind] == "empty rooms" { LEAST_EMPTY_TOLERANCE } else { LEAST_SPATIAL_TOLERANCE };
    let least_tolerance = least_tolerance.max(least);
    let scene = VisibleScene::new(&mesh.facets, &mesh.covers);
    let triangles = (MAX_TRIANGLE_VIEWS / (mesh.facets.len() * mesh.facets.len())).clamp(20, MAX_TRIANGLES);
    let row = |(i, row): (usize, OracleRow)| ReferenceRow {
        area: scene.area(i),
        facets: row.facets,
        around: Some([row.sky, row.ground]),
    };
    let rows =
        scene.rows(REFERENCE_SHARE * least_tolerance, triangles).into_iter().enumerate().map(row).collect();
    let mut set = FacetSet::new();
    mesh.facets.iter().for_each(|c| _ = set.add_surface(c));
    let groups = (0..mesh.facets.len() as u32).collect();
    Reference { kind: MESH_KINDS[kind].into(), set, groups, rows, periods: [None; 2], least_tolerance }
}

/// A cross-section as rectangles, or as triangles, down to [`LEAST_COARSE_TOLERANCE`] unless `fine`.
fn section(kind: usize, parts: bool, fine: bool, rng: &mut Rng) -> Reference {
    let section = RandomSection::new(kind, rng);
    let length = |w: &Wall| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]);
    let exact = |value: f64| OracleFactor { value, error: 1e-11 };
    let rows = crossed_strings::view_factors(&section.walls)
        .into_iter()
        .zip(&section.walls)
        .map(|(f, w)| ReferenceRow {
            area: length(w) * section.period,
            facets: f.into_iter().map(exact).collect(),
            around: None,
        })
        .collect();
    let mut set = FacetSet::new();
    section.facets(parts).iter().for_each(|c| _ = set.add_surface(c));
    let count = section.walls.len() as u32 * if parts { 2 } else { 1 };
    let groups = (0..count).map(|k| if parts { k / 2 } else { k }).collect();
    let form = if parts { "triangles" } else { "rectangles" };
    Reference {
        kind: format!("{}, {form}", SECTION_KINDS[kind]),
        set,
        groups,
        rows,
        periods: [None, Some(section.period)],
        least_tolerance: if parts && !fine { LEAST_COARSE_TOLERANCE } else { 0.0 },
    }
}

fn compare(mesh: u64, reference: &Reference, tolerance: f64, f: &ViewFactors, checks: &mut Vec<FactorCheck>) {
    let proved = f.grade() == Grade::Proved;
    for (i, row) in reference.rows.iter().enumerate() {
        let found: std::collections::BTreeMap<usize, Bounded> = f.row(i).collect();
        let mut add = |what: String, ours: Bounded, exact: &OracleFactor| {
            checks.push(FactorCheck {
                mesh,
                kind: reference.kind.clone(),
                tolerance,
                what,
                proved,
                ours: ours.value,
                radius: ours.radius,
                exact: exact.value,
                error: exact.error,
            });
        };
        for (j, exact) in row.facets.iter().enumerate().filter(|(j, _)| *j != i) {
            let smaller = row.area.min(reference.rows[j].area);
            let omitted = Bounded::estimated(0.0, OMITTED * tolerance * smaller / row.area);
            add(format!("{i} to {j}"), found.get(&j).copied().unwrap_or(omitted), exact);
        }
        if let Some([sky, ground]) = &row.around {
            add(format!("{i} to the sky"), f.sky(i), sky);
            add(format!("{i} to the ground"), f.ground(i), ground);
        }
    }
}
