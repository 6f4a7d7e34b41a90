//! Which pieces of which patches to halve, until all are good, fine, or too many.

use super::BakeOptions;
use super::light::Lights;
use super::share::Share;
use super::tree::{Piece, Tree};
use rayon::prelude::*;
use zonal_scene::{Patch, PlateKind, Progress};

/// Difference between a patch's points and its zone that no noise of the solver explains.
const MISSED: f32 = 0.1;

/// A piece that should be halved.
struct Wish {
    /// Deviation times the square root of the area.
    gain: f64,
    tree: u32,
    piece: u32,
}

/// One tree a patch, refined.
pub(super) fn refine(
    lights: &Lights,
    shares: &[Share],
    options: &BakeOptions,
    progress: &dyn Progress,
) -> Vec<Tree> {
    let patches = &lights.s.zones.patches;
    let finest = options.finest.unwrap_or(1e-3 * lights.s.scene.diagonal()).max(1e-9);
    progress.begin("bake", patches.len() as u64);
    let mut trees: Vec<Tree> = (0..patches.len())
        .into_par_iter()
        .map(|i| {
            let mut tree = Tree::new(i, patches[i].plate.kind);
            judge(&mut tree, lights, shares, options.tolerance);
            progress.advance(1);
            tree
        })
        .collect();
    loop {
        let wishes = granted(wishes(&trees, patches, options.tolerance, finest), &trees, options.vertices);
        if wishes.is_empty() {
            break;
        }
        let mut mine: Vec<Vec<u32>> = vec![Vec::new(); trees.len()];
        wishes.iter().for_each(|w| mine[w.tree as usize].push(w.piece));
        trees.par_iter_mut().zip(&mut mine).filter(|(_, list)| !list.is_empty()).for_each(|(tree, list)| {
            list.sort_unstable();
            list.iter().for_each(|&i| tree.split(i as usize));
            judge(tree, lights, shares, options.tolerance);
        });
    }
    progress.end();
    trees
}

/// Finds how good the new pieces of a patch are.
fn judge(tree: &mut Tree, lights: &Lights, shares: &[Share], tolerance: f64) {
    for i in 0..tree.pieces.len() {
        let p = tree.pieces[i];
        if p.deviation < 0.0 {
            tree.pieces[i].deviation = tree.deviation(lights, &p);
        }
    }
    let coarse = tree.pieces.len() == 1
        || tree.pieces.len() == 4 && tree.pieces.iter().all(|p| p.size.abs() == tree.pieces[0].size.abs());
    if coarse && lights.values() > 1 {
        let missed = tree.missed(lights, &lights.of_zone(shares, tree.patch));
        if missed > MISSED.max(2.0 * tolerance as f32) {
            tree.pieces.iter_mut().for_each(|p| p.deviation = p.deviation.max(missed));
        }
    }
}

fn wishes(trees: &[Tree], patches: &[Patch], tolerance: f64, finest: f64) -> Vec<Wish> {
    let of = |(t, tree): (usize, &Tree)| {
        let patch = &patches[tree.patch];
        let plate = &patch.plate;
        let third = if tree.kind == PlateKind::Triangle { (plate.e2 - plate.e1).length() } else { 0.0 };
        let longest = plate.e1.length().max(plate.e2.length()).max(third);
        let wanted = move |p: &Piece| {
            p.deviation as f64 > tolerance && Tree::divisible(p) && Tree::edge(p, longest) > finest
        };
        let side = patch.area.sqrt();
        let wish = move |(i, p): (usize, &Piece)| Wish {
            gain: p.deviation as f64 * Tree::edge(p, side),
            tree: t as u32,
            piece: i as u32,
        };
        tree.pieces.iter().enumerate().filter(move |(_, p)| wanted(p)).map(wish).collect::<Vec<_>>()
    };
    trees.par_iter().enumerate().map(of).collect::<Vec<_>>().into_iter().flatten().collect()
}

/// Those for which there is room, the greatest gain first.
fn granted(mut wishes: Vec<Wish>, trees: &[Tree], most: usize) -> Vec<Wish> {
    if wishes.is_empty() {
        return wishes;
    }
    // Four corners and a centre, and a centre in each neighbour that had none.
    let cost = |w: &Wish| if trees[w.tree as usize].kind == PlateKind::Triangle { 6 } else { 9 };
    let used: usize = trees.par_iter().map(Tree::vertices).sum();
    let mut room = most.saturating_sub(used);
    if wishes.iter().map(cost).sum::<usize>() <= room {
        return wishes;
    }
    // What is left is not worth another round.
    if room < most / 50 {
        return Vec::new();
    }
    wishes.sort_by(|a, b| b.gain.total_cmp(&a.gain).then((a.tree, a.piece).cmp(&(b.tree, b.piece))));
    let mut fits = |w: &Wish| {
        let cost = cost(w);
        let yes = cost <= room;
        room = room.saturating_sub(cost);
        yes
    };
    let n = wishes.iter().take_while(|w| fits(w)).count();
    wishes.truncate(n);
    wishes
}
