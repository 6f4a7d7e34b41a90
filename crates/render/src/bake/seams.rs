//! Patches that share an edge share its vertices, so that no light of the background shines through.
//!
//! A vertex on the common edge of two patches, of one facet or of two, becomes a corner of both. Corners on an edge lie at dyadic fractions
//! of it from either side. Edges that coincide in part only are left: there a vertex may lie on an edge of the other side.

use super::light::Lights;
use super::tree::{SIDE, Tree};
use rayon::prelude::*;

/// Ends closer than this share of the scene's diagonal are one.
const SAME: f64 = 1e-7;

/// A side of a patch by its ends, in steps, the lesser first.
struct Edge {
    ends: [[i64; 3]; 2],
    tree: u32,
    side: u8,
    /// True where the patch runs along it from the greater end.
    reversed: bool,
}

/// Gives every patch the corners that its neighbours have on common edges.
pub(super) fn close(lights: &Lights, trees: &mut [Tree]) {
    let step = SAME * lights.s.scene.diagonal().max(1e-300);
    let sides = |(t, tree): (usize, &Tree)| {
        let (corners, n) = lights.s.zones.patches[tree.patch].plate.corners();
        let key = |k: usize| corners[k % n].array().map(|x| (x / step).round() as i64);
        let edge = move |k: usize| {
            let (a, b) = (key(k), key(k + 1));
            Edge { ends: [a.min(b), a.max(b)], tree: t as u32, side: k as u8, reversed: b < a }
        };
        (0..n).map(edge).collect::<Vec<_>>()
    };
    let mut edges: Vec<Edge> = trees.par_iter().enumerate().flat_map_iter(sides).collect();
    edges.par_sort_unstable_by_key(|e| (e.ends, e.tree, e.side));
    let mut more: Vec<Vec<(u8, Vec<i32>)>> = (0..trees.len()).map(|_| Vec::new()).collect();
    for common in edges.chunk_by(|a, b| a.ends == b.ends).filter(|c| c.len() > 1) {
        let from = |e: &Edge, t: i32| if e.reversed { SIDE - t } else { t };
        let mut all: Vec<i32> = Vec::new();
        for e in common {
            all.extend(trees[e.tree as usize].border(e.side).map(|t| from(e, t)));
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
    trees.par_iter_mut().zip(&more).for_each(|(tree, lists)| {
        for (side, list) in lists {
            list.iter().for_each(|t| tree.add_corner(lights, *side, *t));
        }
    });
}
