//! The computation as a whole, and its result.

use crate::batches;
use crate::bounds::Bounds;
use crate::geometry::Geometry;
use crate::geometry::occluder_list;
use crate::image_choice::{choose_images, sky_nodes, unresolved_cells};
use crate::matrix::ExchangeRows;
use crate::matrix::closing::{close_rows, defects};
use crate::matrix::pairs::{NodePair, PairExchange, PairTraversal, TreatmentCounts, merge_images, round_up};
use crate::periods::PeriodicImages;
use crate::settings::{ErrorGoal, Openness, RowClosing, ViewFactorSettings};
use crate::sky::{SkyExchange, SkyTraversal, direction_cells};
use crate::stages;
use crate::strings;
use std::sync::atomic::{AtomicU64, Ordering};
use zonal_exchange::polygon::visible::ConvexPolygon;
use zonal_math::{Bounded, Grade, Vec3};
use zonal_scene::{CheckpointStore, Progress, SceneError};

/// Pairs of nodes at which the work is divided.
const MIN_TASKS: usize = 4096;
/// Rounds of division, at most.
const MAX_DIVISIONS: usize = 64;
/// Batches between checkpoints.
const BATCHES: usize = 48;
/// A defect beyond this number of row radii and the tolerance has another cause than numerical error.
const OPEN_ROW_RADII: f64 = 3.0;
/// Share of the requested absolute radius below which the exchange in unresolved directions is left out.
const OMITTED_REST: f64 = 0.01;
/// Bytes for a pair during the computation and in the rows.
const BYTES_PER_PAIR: u64 = 24 + 32;

/// Numbers of pairs by treatment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ViewFactorCounts {
    /// Facets.
    pub facets: usize,
    /// Obstructions: convex solids, and plates of merged coplanar facets.
    pub occluders: usize,
    /// Convex solids among them.
    pub solids: usize,
    /// Pairs of facets that face each other and were examined one by one.
    pub examined: u64,
    /// Pairs with nothing between them.
    pub unobstructed: u64,
    /// Pairs that one occluder hides.
    pub hidden: u64,
    /// Pairs whose visible part was integrated.
    pub partial: u64,
}

impl ViewFactorCounts {
    fn of(geometry: &Geometry, counts: &TreatmentCounts) -> ViewFactorCounts {
        ViewFactorCounts {
            facets: geometry.facets.len(),
            occluders: geometry.occluders.len(),
            solids: geometry.occluders.iter().filter(|o| !o.body.is_plate()).count(),
            examined: counts.facet_pairs,
            unobstructed: counts.unobstructed,
            hidden: counts.hidden,
            partial: counts.partial,
        }
    }
}

/// View factors of n facets: rows that are sparse, with error radii.
#[derive(Clone, Debug)]
pub struct ViewFactors {
    pub(crate) areas: Vec<f64>,
    pub(crate) rows: ExchangeRows,
    pub(crate) defects: Vec<f64>,
    pub(crate) open_rows: Vec<usize>,
    pub(crate) remaining_defect: f64,
    pub(crate) grade: Grade,
    /// Numbers of pairs.
    pub counts: ViewFactorCounts,
}

impl ViewFactors {
    /// The view factors of `facets` (at least one), which also hide each other; `obstructions` hide from both sides and exchange nothing.
    /// Facets exchange with their fronts.
    ///
    /// # Errors
    /// Settings that are not valid, results beyond the memory limit, an interruption by the observer.
    pub fn compute(
        facets: &[ConvexPolygon],
        obstructions: &[ConvexPolygon],
        settings: &ViewFactorSettings,
        progress: &dyn Progress,
        checkpoints: &dyn CheckpointStore,
    ) -> Result<ViewFactors, SceneError> {
        settings.check()?;
        if facets.is_empty() {
            return Err(SceneError::new("facets", "there is no facet; give at least one"));
        }
        let surface: Vec<u32> = (0..facets.len() as u32).collect();
        if let Some(f) =
            ViewFactors::by_strings(facets, &surface, facets.len(), obstructions, settings, progress)?
        {
            return Ok(f);
        }
        let mut geometry = Geometry::new(facets, obstructions);
        let extent = Bounds::of(
            &facets.iter().chain(obstructions).flat_map(|p| p.corners()).copied().collect::<Vec<_>>(),
        );
        let images = choose_images(&mut geometry, &extent, settings, progress)?;
        let run = Computation { geometry: &geometry, images: &images, settings, progress, checkpoints };
        let (counts, mut pairs) = run.pairs()?;
        let surroundings = run.surroundings()?;
        let unseen = run.unrepresented(&pairs, &surroundings)?;
        pairs.push(unseen);
        let rows = rows_of(facets.len(), &pairs, settings.surroundings, surroundings);
        drop(pairs);
        let areas: Vec<f64> = facets.iter().map(ConvexPolygon::area).collect();
        let is_estimated = counts.partial > 0 || images.any();
        Ok(ViewFactors::closed(areas, rows, settings, is_estimated, ViewFactorCounts::of(&geometry, &counts)))
    }

    /// The factors of a number of `surfaces` by crossed strings: facet k is part of surface `surface[k]`. None if the geometry is not extruded along a period.
    pub(crate) fn by_strings(
        facets: &[ConvexPolygon],
        surface: &[u32],
        surfaces: usize,
        obstructions: &[ConvexPolygon],
        settings: &ViewFactorSettings,
        progress: &dyn Progress,
    ) -> Result<Option<ViewFactors>, SceneError> {
        settings.check()?;
        let made = strings::exchange(facets, surface, obstructions, settings, progress)?;
        let Some(made) = made else { return Ok(None) };
        let n = made.areas.len();
        let counts = ViewFactorCounts {
            facets: facets.len(),
            occluders: n,
            solids: 0,
            examined: made.pairs.len() as u64,
            unobstructed: 0,
            hidden: 0,
            partial: made.pairs.len() as u64,
        };
        let rows = rows_of(n, &[made.pairs], settings.surroundings, made.surroundings);
        let f = ViewFactors::closed(made.areas, rows, settings, true, counts);
        Ok(Some(f.combined(&made.surface, surfaces)))
    }

    /// The factors of rows, closed as the settings say.
    fn closed(
        areas: Vec<f64>,
        mut rows: ExchangeRows,
        settings: &ViewFactorSettings,
        is_estimated: bool,
        counts: ViewFactorCounts,
    ) -> ViewFactors {
        let relative: Vec<f64> = defects(&areas, &rows).iter().zip(&areas).map(|(d, a)| -d / a).collect();
        let open_rows = open_rows(&rows, &areas, &relative, settings.tolerance);
        let remaining_defect = match settings.closure {
            RowClosing::Restore => {
                let mut sums = areas.clone();
                open_rows.iter().for_each(|i| sums[*i] = rows.sum(*i));
                close_rows(&sums, &mut rows)
            }
            RowClosing::Keep => relative.iter().fold(0.0f64, |s, d| s.max(d.abs())),
        };
        let is_estimated = is_estimated
            || settings.closure == RowClosing::Restore
            || rows.sky.iter().chain(&rows.ground).any(|b| b.grade != Grade::Proved);
        let grade = if is_estimated { Grade::Estimated } else { Grade::Proved };
        ViewFactors { areas, rows, defects: relative, open_rows, remaining_defect, grade, counts }
    }

    /// Number of facets.
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// True without facets.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// Areas, m².
    pub fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// The reciprocal of an area, 1/m²; zero for a surface without an area.
    fn per_area(&self, i: usize) -> f64 {
        if self.areas[i] > 0.0 { 1.0 / self.areas[i] } else { 0.0 }
    }

    /// Number of factors that are not zero.
    pub fn entry_count(&self) -> usize {
        self.rows.len()
    }

    /// F from facet `i` to each facet that it sees, by number, with its error radius.
    ///
    /// # Panics
    /// On an index out of range.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, Bounded)> + '_ {
        let scale = self.per_area(i);
        let grade = self.grade;
        self.rows.entries(i).map(move |(j, b)| (j, Bounded { grade, ..b * scale }))
    }

    /// F from facet `i` to the directions above the horizon that meet nothing.
    ///
    /// # Panics
    /// On an index out of range.
    pub fn sky(&self, i: usize) -> Bounded {
        self.rows.sky[i] * self.per_area(i)
    }

    /// F from facet `i` to the directions below the horizon that meet nothing.
    ///
    /// # Panics
    /// On an index out of range.
    pub fn ground(&self, i: usize) -> Bounded {
        self.rows.ground[i] * self.per_area(i)
    }

    /// Σ_j F_ij + F_i,sky + F_i,ground − 1 before rows were closed.
    pub fn defects(&self) -> &[f64] {
        &self.defects
    }

    /// Rows whose defect is larger than their errors explain, in ascending order: their facets lie partly inside a solid, or see backs of
    /// facets. They are not made to sum to one.
    pub fn open_rows(&self) -> &[usize] {
        &self.open_rows
    }

    /// The largest |Σ F − 1| of the rows as they are now, without the open rows if rows were closed.
    pub fn remaining_defect(&self) -> f64 {
        self.remaining_defect
    }

    /// The sum of the error radii of row `i`.
    ///
    /// # Panics
    /// On an index out of range.
    pub fn row_radius(&self, i: usize) -> f64 {
        self.rows.sum_of_radii(i) * self.per_area(i)
    }

    /// Evidence for the radii: proved without any partly hidden pair or cell of directions and without closing, else estimated.
    pub fn grade(&self) -> Grade {
        self.grade
    }

    /// The factors as arrays; nothing is copied.
    pub fn into_rows(self) -> FactorRows {
        let per_area: Vec<f64> = (0..self.len()).map(|i| self.per_area(i)).collect();
        let scaled = |b: &[Bounded]| b.iter().zip(&per_area).map(|(b, s)| *b * *s).collect();
        let ExchangeRows { starts: row_starts, columns, mut values, mut radii, sky, ground } = self.rows;
        for (i, scale) in per_area.iter().enumerate() {
            for k in row_starts[i] as usize..row_starts[i + 1] as usize {
                values[k] *= scale;
                radii[k] = round_up(f64::from(radii[k]) * scale);
            }
        }
        let (sky, ground) = (scaled(&sky), scaled(&ground));
        let ViewFactors { areas, defects, .. } = self;
        FactorRows { row_starts, columns, values, radii, sky, ground, areas, defects }
    }

    /// The factors of unions of facets: `group` numbers the union of each facet, below `groups`. Radii add up. A union
    /// without a facet has an empty row.
    ///
    /// # Panics
    /// If `group` has another length than the facets, or numbers a union beyond `groups`.
    pub fn combined(&self, group: &[u32], groups: usize) -> ViewFactors {
        assert_eq!(group.len(), self.len(), "a union for each facet");
        let mut areas = vec![0.0; groups];
        let mut relative = vec![0.0; groups];
        for (i, g) in group.iter().enumerate() {
            areas[*g as usize] += self.areas[i];
            relative[*g as usize] += self.defects[i] * self.areas[i];
        }
        relative.iter_mut().zip(&areas).filter(|(_, a)| **a > 0.0).for_each(|(d, a)| *d /= a);
        let mut open_rows: Vec<usize> = self.open_rows.iter().map(|i| group[*i] as usize).collect();
        open_rows.sort_unstable();
        open_rows.dedup();
        ViewFactors {
            areas,
            rows: self.rows.combined(group, groups),
            defects: relative,
            open_rows,
            remaining_defect: self.remaining_defect,
            grade: self.grade,
            counts: self.counts,
        }
    }
}

/// View factors as arrays, row by row.
#[derive(Clone, Debug)]
pub struct FactorRows {
    /// First entry of each row, and the number of entries: n + 1 numbers.
    pub row_starts: Vec<u64>,
    /// Facet that receives, for each entry; ascending in each row.
    pub columns: Vec<u32>,
    /// F from the row's facet to the column's.
    pub values: Vec<f64>,
    /// Error radius of each value.
    pub radii: Vec<f32>,
    /// F to the directions above the horizon that meet nothing.
    pub sky: Vec<Bounded>,
    /// F to the directions below the horizon that meet nothing.
    pub ground: Vec<Bounded>,
    /// Areas, m².
    pub areas: Vec<f64>,
    /// Sum of each row minus one, before rows were closed.
    pub defects: Vec<f64>,
}

/// The rows of pairs in batches and of the surroundings.
fn rows_of(
    n: usize,
    pairs: &[Vec<PairExchange>],
    openness: Openness,
    surroundings: Vec<(u32, SkyExchange)>,
) -> ExchangeRows {
    let entries = pairs.iter().flatten().map(|p| {
        ((p.i, p.j), Bounded { value: p.value, radius: f64::from(p.radius), grade: Grade::Estimated })
    });
    let mut rows = ExchangeRows::new(n, entries);
    if openness == Openness::Open {
        for (f, s) in surroundings {
            (rows.sky[f as usize], rows.ground[f as usize]) = (s.sky, s.ground);
        }
    }
    rows
}

/// Rows whose relative defects their errors do not explain.
fn open_rows(rows: &ExchangeRows, areas: &[f64], defects: &[f64], tolerance: f64) -> Vec<usize> {
    let explained = |i: usize| OPEN_ROW_RADII * rows.sum_of_radii(i) / areas[i] + tolerance;
    (0..areas.len()).filter(|i| defects[*i].abs() > explained(*i)).collect()
}

/// One computation.
struct Computation<'a> {
    geometry: &'a Geometry,
    images: &'a PeriodicImages,
    settings: &'a ViewFactorSettings,
    progress: &'a dyn Progress,
    checkpoints: &'a dyn CheckpointStore,
}

impl Computation<'_> {
    fn goal(&self) -> ErrorGoal {
        self.settings.goal(self.geometry.facets.len())
    }

    fn traversal(&self) -> PairTraversal<'_> {
        PairTraversal::new(self.geometry, self.images, self.goal())
    }

    /// The pairs of nodes at which the work is divided; the same for every number of threads.
    fn tasks(&self) -> (TreatmentCounts, Vec<NodePair>) {
        let occluders = occluder_list::all(self.geometry, self.images);
        let mut top = self.traversal();
        let root = |block| NodePair { a: 0, b: 0, block, occluders: occluders.clone() };
        let mut tasks: Vec<NodePair> = self.images.half().into_iter().map(root).collect();
        for _ in 0..MAX_DIVISIONS {
            if tasks.len() >= MIN_TASKS {
                break;
            }
            let before = tasks.len();
            let mut divided = false;
            let mut next = Vec::with_capacity(3 * before);
            for task in tasks {
                match top.divide(&task) {
                    Some(parts) => {
                        divided = true;
                        next.extend(parts);
                    }
                    None => next.push(task),
                }
            }
            tasks = next;
            if !divided {
                break;
            }
        }
        (top.counts, tasks)
    }

    /// The pairs in batches: one vector would be copied as it grows.
    fn pairs(&self) -> Result<(TreatmentCounts, Vec<Vec<PairExchange>>), SceneError> {
        let (mut counts, tasks) = self.tasks();
        let n = self.geometry.facets.len();
        self.progress.begin("view factors", tasks.len() as u64);
        let found = AtomicU64::new(0);
        // Neighbouring tasks are alike: a batch takes every BATCHES-th one.
        let mut batches: Vec<Vec<&NodePair>> =
            (0..BATCHES.min(tasks.len())).map(|b| tasks.iter().skip(b).step_by(BATCHES).collect()).collect();
        let stage = |batch: usize| format!("view-factors-{batch}");
        let loaded = |b: usize| self.checkpoints.load(&stage(b)).and_then(|b| stages::decode_pairs(&b, n));
        let known: Vec<_> = (0..batches.len()).map(loaded).collect();
        for (batch, _) in batches.iter_mut().zip(&known).filter(|(_, known)| known.is_some()) {
            self.progress.advance(batch.len() as u64);
            batch.clear();
        }
        let finish = |batch: usize, results| {
            let made = self.merged(results)?;
            self.check_memory(found.load(Ordering::Relaxed))?;
            if self.checkpoints.keeps() {
                self.checkpoints.save(&stage(batch), &stages::encode_pairs(&made.0, &made.1));
            }
            Ok(made)
        };
        let made = batches::run(&batches, |task| self.pairs_of_task(task, &found), finish);
        let (mut pairs, mut total) = (Vec::new(), 0);
        for (known, made) in known.into_iter().zip(made) {
            let Some((part, list)) = known.map(Ok).or(made).transpose()? else { continue };
            counts.merge(part);
            total += list.len() as u64;
            pairs.push(list);
            self.check_memory(total)?;
        }
        self.progress.end();
        Ok((counts, pairs))
    }

    /// The pairs below two nodes; none once the computation is to stop. `found` counts those of all tasks.
    fn pairs_of_task(&self, task: &NodePair, found: &AtomicU64) -> (TreatmentCounts, Vec<PairExchange>) {
        let mut traversal = self.traversal();
        let within = found.load(Ordering::Relaxed) * BYTES_PER_PAIR <= self.settings.memory_limit;
        if within && !self.progress.is_interrupted() {
            traversal.visit(task);
            if self.images.any() {
                merge_images(&mut traversal.found);
            }
            found.fetch_add(traversal.found.len() as u64, Ordering::Relaxed);
        }
        self.progress.advance(1);
        (traversal.counts, traversal.found)
    }

    /// The pairs of all tasks of a batch.
    fn merged(
        &self,
        results: Vec<(TreatmentCounts, Vec<PairExchange>)>,
    ) -> Result<(TreatmentCounts, Vec<PairExchange>), SceneError> {
        if self.progress.is_interrupted() {
            return Err(SceneError::interrupted());
        }
        let mut counts = TreatmentCounts::default();
        let mut pairs = Vec::with_capacity(results.iter().map(|r| r.1.len()).sum());
        for (part, list) in results {
            counts.merge(part);
            pairs.extend(list);
        }
        if self.images.any() {
            merge_images(&mut pairs);
        }
        Ok((counts, pairs))
    }

    fn check_memory(&self, pairs: u64) -> Result<(), SceneError> {
        if pairs * BYTES_PER_PAIR <= self.settings.memory_limit {
            return Ok(());
        }
        let gigabytes = self.settings.memory_limit as f64 / 1e9;
        Err(SceneError::out_of_memory(
            "max_memory",
            format!(
                "{pairs} or more pairs see each other, which exceeds {gigabytes} GB; allow more memory, or give fewer facets"
            ),
        ))
    }

    /// Pairs with the bound of the exchange of their images that are not represented, value zero: min(U_i, U_j).
    fn unrepresented(
        &self,
        pairs: &[Vec<PairExchange>],
        surroundings: &[(u32, SkyExchange)],
    ) -> Result<Vec<PairExchange>, SceneError> {
        let n = self.geometry.facets.len();
        let mut unresolved = vec![0.0f64; n];
        surroundings.iter().for_each(|(f, s)| unresolved[*f as usize] += s.unresolved);
        let area = |i: usize| self.geometry.facets[i].polygon().area();
        let least = |i: usize| OMITTED_REST * self.goal().absolute * area(i);
        let rows: Vec<usize> = (0..n).filter(|i| unresolved[*i] > least(*i)).collect();
        let mut list = Vec::new();
        let known: u64 = pairs.iter().map(|p| p.len() as u64).sum();
        for (k, &i) in rows.iter().enumerate() {
            for &j in &rows[k + 1..] {
                let both = unresolved[i].min(unresolved[j]);
                let (p, q) = (self.geometry.facets[i].polygon(), self.geometry.facets[j].polygon());
                if self.may_face_images(p, q) {
                    let radius = round_up(both);
                    list.push(PairExchange { i: i as u32, j: j as u32, value: 0.0, radius });
                }
            }
            self.check_memory(known + list.len() as u64)?;
        }
        Ok(list)
    }

    /// False if no displacement makes two facets face each other.
    fn may_face_images(&self, p: &ConvexPolygon, q: &ConvexPolygon) -> bool {
        let repeats =
            |n: Vec3| (0..2).any(|k| self.images.periods[k] > 0.0 && n.array()[self.images.axes[k]] != 0.0);
        let rises = |p: &ConvexPolygon, q: &ConvexPolygon| {
            repeats(p.normal()) || q.corners().iter().any(|c| p.height(*c) > self.geometry.contact)
        };
        rises(p, q) && rises(q, p)
    }

    fn surroundings(&self) -> Result<Vec<(u32, SkyExchange)>, SceneError> {
        let nodes = sky_nodes(self.geometry);
        let cells = match self.settings.surroundings {
            Openness::Open => direction_cells(self.images),
            Openness::Closed => unresolved_cells(self.images),
        };
        if cells.is_empty() {
            return Ok(Vec::new());
        }
        let n = self.geometry.facets.len();
        self.progress.begin("surroundings", nodes.len() as u64);
        let mut batches: Vec<Vec<u32>> = (0..BATCHES.min(nodes.len()))
            .map(|b| nodes.iter().skip(b).step_by(BATCHES).copied().collect())
            .collect();
        let stage = |batch: usize| format!("surroundings-{batch}");
        let loaded =
            |b: usize| self.checkpoints.load(&stage(b)).and_then(|b| stages::decode_surroundings(&b, n));
        let known: Vec<_> = (0..batches.len()).map(loaded).collect();
        for (batch, _) in batches.iter_mut().zip(&known).filter(|(_, known)| known.is_some()) {
            self.progress.advance(batch.len() as u64);
            batch.clear();
        }
        let run = |node: &u32| {
            let idle = self.progress.is_interrupted();
            let traversal = SkyTraversal::new(self.geometry, self.images, self.goal(), self.settings.up);
            let made = if idle { Vec::new() } else { traversal.run(*node, &cells) };
            self.progress.advance(1);
            made
        };
        let finish = |batch: usize, results: Vec<Vec<(u32, SkyExchange)>>| {
            if self.progress.is_interrupted() {
                return Err(SceneError::interrupted());
            }
            let made = results.concat();
            if self.checkpoints.keeps() {
                self.checkpoints.save(&stage(batch), &stages::encode_surroundings(&made));
            }
            Ok(made)
        };
        let made = batches::run(&batches, run, finish);
        let mut all = Vec::with_capacity(n);
        for (known, made) in known.into_iter().zip(made) {
            all.extend(known.map(Ok).or(made).transpose()?.unwrap_or_default());
        }
        self.progress.end();
        Ok(all)
    }
}
