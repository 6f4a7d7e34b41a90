//! Selection of the quadtree cells to split, until the interpolation error is below the tolerance, the cells are small enough, or the
//! vertices run out.
//!
//! The gain of a split is its error times the square root of the cell's area; the greatest gain comes first. Method: greedy adaptive
//! meshing of radiosity solutions (Cohen & Wallace, 1993).

use super::baked::BakeOptions;
use super::group_fields::GroupField;
use super::patch_quadtree::{PatchQuadtree, QuadtreeCell};
use super::vertex_lighting::VertexLighting;
use rayon::prelude::*;
use zonal_scene::{Patch, PlateKind, Progress};

/// Relative difference between the mean of a patch's points and its zone above which a feature lies between the points: larger than
/// the noise of the solver.
const MAX_MEAN_DIFFERENCE: f32 = 0.1;
/// Refinement ends where the remaining vertices are fewer than the allowed ones over this number.
const MIN_REMAINING_DIVISOR: usize = 50;

/// A cell whose interpolation error exceeds the tolerance.
struct SplitCandidate {
    /// Error times the square root of the area.
    gain: f64,
    tree: u32,
    cell: u32,
}

/// One tree a patch, unrefined.
pub(super) fn plant(
    lighting: &VertexLighting,
    groups: &[GroupField],
    options: &BakeOptions,
    progress: &dyn Progress,
) -> Vec<PatchQuadtree> {
    let patches = &lighting.solution.zones.patches;
    progress.begin("bake", patches.len() as u64);
    let trees = (0..patches.len()).into_par_iter().map(|i| {
        let mut tree = PatchQuadtree::new(i, patches[i].plate.kind);
        evaluate_cells(&mut tree, lighting, groups, options.tolerance);
        progress.advance(1);
        tree
    });
    let trees = trees.collect();
    progress.end();
    trees
}

/// The cells to split next, as far as there are vertices.
fn next_splits(
    trees: &[PatchQuadtree],
    lighting: &VertexLighting,
    options: &BakeOptions,
    max_vertices: usize,
) -> Vec<SplitCandidate> {
    let min_edge = options.min_edge.unwrap_or(1e-3 * lighting.solution.scene.diagonal()).max(1e-9);
    let candidates = find_candidates(trees, &lighting.solution.zones.patches, options.tolerance, min_edge);
    select_within_budget(candidates, trees, max_vertices)
}

/// True where trees can be refined within the vertices that the options allow.
pub(super) fn can_refine(trees: &[PatchQuadtree], lighting: &VertexLighting, options: &BakeOptions) -> bool {
    !next_splits(trees, lighting, options, options.max_vertices).is_empty()
}

/// Refines the trees up to `max_vertices`; false if no cell is split.
pub(super) fn refine(
    trees: &mut [PatchQuadtree],
    lighting: &VertexLighting,
    groups: &[GroupField],
    options: &BakeOptions,
    max_vertices: usize,
) -> bool {
    let mut is_finer = false;
    loop {
        let splits = next_splits(trees, lighting, options, max_vertices);
        if splits.is_empty() {
            return is_finer;
        }
        is_finer = true;
        let mut cells: Vec<Vec<u32>> = vec![Vec::new(); trees.len()];
        splits.iter().for_each(|w| cells[w.tree as usize].push(w.cell));
        trees.par_iter_mut().zip(&mut cells).filter(|(_, list)| !list.is_empty()).for_each(|(tree, list)| {
            list.sort_unstable();
            list.iter().for_each(|&i| tree.split(i as usize));
            evaluate_cells(tree, lighting, groups, options.tolerance);
        });
    }
}

/// Evaluates the interpolation error of the new cells of a patch.
fn evaluate_cells(
    tree: &mut PatchQuadtree,
    lighting: &VertexLighting,
    groups: &[GroupField],
    tolerance: f64,
) {
    for i in 0..tree.cells.len() {
        let p = tree.cells[i];
        if p.error < 0.0 {
            tree.cells[i].error = tree.interpolation_error(lighting, &p);
        }
    }
    let coarse = tree.cells.len() == 1
        || tree.cells.len() == 4 && tree.cells.iter().all(|p| p.size.abs() == tree.cells[0].size.abs());
    // Compare a coarse patch with the mean of its zone, to find features between its points.
    if coarse && lighting.value_count() > 1 {
        let difference = tree.mean_difference(lighting, &lighting.zone_means(groups, tree.patch));
        if difference > MAX_MEAN_DIFFERENCE.max(2.0 * tolerance as f32) {
            tree.cells.iter_mut().for_each(|p| p.error = p.error.max(difference));
        }
    }
}

/// The cells whose error exceeds the tolerance and whose edges exceed `min_edge`, m.
fn find_candidates(
    trees: &[PatchQuadtree],
    patches: &[Patch],
    tolerance: f64,
    min_edge: f64,
) -> Vec<SplitCandidate> {
    let of = |(t, tree): (usize, &PatchQuadtree)| {
        let patch = &patches[tree.patch];
        let plate = &patch.plate;
        let third = if tree.kind == PlateKind::Triangle { (plate.e2 - plate.e1).length() } else { 0.0 };
        let longest = plate.e1.length().max(plate.e2.length()).max(third);
        let qualifies = move |p: &QuadtreeCell| {
            p.error as f64 > tolerance
                && PatchQuadtree::is_divisible(p)
                && PatchQuadtree::edge(p, longest) > min_edge
        };
        let side = patch.area.sqrt();
        let candidate = move |(i, p): (usize, &QuadtreeCell)| SplitCandidate {
            gain: p.error as f64 * PatchQuadtree::edge(p, side),
            tree: t as u32,
            cell: i as u32,
        };
        tree.cells.iter().enumerate().filter(move |(_, p)| qualifies(p)).map(candidate).collect::<Vec<_>>()
    };
    trees.par_iter().enumerate().map(of).collect::<Vec<_>>().into_iter().flatten().collect()
}

/// The candidates for which there are vertices left, the greatest gain first.
fn select_within_budget(
    mut candidates: Vec<SplitCandidate>,
    trees: &[PatchQuadtree],
    max_vertices: usize,
) -> Vec<SplitCandidate> {
    if candidates.is_empty() {
        return candidates;
    }
    // A split adds five vertices inside, and the centre of each neighbour that had no hanging vertex.
    let cost = |w: &SplitCandidate| if trees[w.tree as usize].kind == PlateKind::Triangle { 6 } else { 9 };
    let used: usize = trees.par_iter().map(PatchQuadtree::vertex_count).sum();
    let mut left = max_vertices.saturating_sub(used);
    if candidates.iter().map(cost).sum::<usize>() <= left {
        return candidates;
    }
    if left < max_vertices / MIN_REMAINING_DIVISOR {
        return Vec::new();
    }
    candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain).then((a.tree, a.cell).cmp(&(b.tree, b.cell))));
    let mut fits = |w: &SplitCandidate| {
        let cost = cost(w);
        let fits = cost <= left;
        left = left.saturating_sub(cost);
        fits
    };
    let n = candidates.iter().take_while(|w| fits(w)).count();
    candidates.truncate(n);
    candidates
}
