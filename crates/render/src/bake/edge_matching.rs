//! Matching of edges: patches that share an edge share its vertices, so that no background shows through.
//!
//! A vertex on the common edge of two patches, of one facet or of two, becomes a corner of both. Corners on an edge lie at dyadic fractions
//! of it from either side. Edges that coincide only in part are not matched: there a vertex may lie on an edge of the other side.

use super::patch_quadtree::{LATTICE_SIDE, PatchQuadtree};
use super::vertex_lighting::VertexLighting;
use rayon::prelude::*;
use zonal_math::parallel;

/// Distance, scene diagonals, below which two ends of edges coincide.
const COINCIDENCE_TOLERANCE: f64 = 1e-7;

/// A side of a patch by its ends, in steps of the tolerance, the lesser first.
struct PatchEdge {
    ends: [[i64; 3]; 2],
    tree: u32,
    side: u8,
    /// True where the patch runs along it from the greater end.
    reversed: bool,
}

/// Gives every patch the corners that its neighbours have on common edges.
pub(super) fn match_edges(lighting: &VertexLighting, trees: &mut [PatchQuadtree]) {
    let step = COINCIDENCE_TOLERANCE * lighting.solution.scene.diagonal().max(1e-300);
    let sides = |(t, tree): (usize, &PatchQuadtree)| {
        let (corners, n) = lighting.solution.zones.patches[tree.patch].plate.corners();
        let key = |k: usize| corners[k % n].array().map(|x| (x / step).round() as i64);
        let edge = move |k: usize| {
            let (a, b) = (key(k), key(k + 1));
            PatchEdge { ends: [a.min(b), a.max(b)], tree: t as u32, side: k as u8, reversed: b < a }
        };
        (0..n).map(edge).collect::<Vec<_>>()
    };
    let mut edges: Vec<PatchEdge> = trees.par_iter().enumerate().flat_map_iter(sides).collect();
    edges.par_sort_unstable_by_key(|e| (e.ends, e.tree, e.side));
    // Collect the corners that any side has on each common edge.
    let mut more: Vec<Vec<(u8, Vec<i32>)>> = (0..trees.len()).map(|_| Vec::new()).collect();
    for common in edges.chunk_by(|a, b| a.ends == b.ends).filter(|c| c.len() > 1) {
        let from = |e: &PatchEdge, t: i32| if e.reversed { LATTICE_SIDE - t } else { t };
        let mut all: Vec<i32> = Vec::new();
        for e in common {
            all.extend(trees[e.tree as usize].corners_on_side(e.side).map(|t| from(e, t)));
        }
        all.sort_unstable();
        all.dedup();
        if all.is_empty() {
            continue;
        }
        for e in common {
            more[e.tree as usize].push((e.side, all.iter().map(|t| from(e, *t)).collect()));
        }
    }
    parallel::for_each(trees, |i, tree| {
        for (side, list) in &more[i] {
            list.iter().for_each(|t| tree.add_corner(lighting, *side, *t));
        }
    });
}
