//! The binary tree by binned surface-area heuristic, and its collapse into eight-wide nodes.
//!
//! A split of n boxes with surface S costs c_t + (S_l n_l + S_r n_r)/S plate tests; the cheapest of 16 bin borders on each axis
//! wins (Wald 2007). Where all centres coincide, or the tree gets deep, the list is halved.

use super::node::{EMPTY, LANES, LEAF, Node};

/// Plates of a leaf, which are tested side by side.
pub(super) const MAX_LEAF: usize = LANES;
const BINS: usize = 16;
const TRAVERSAL: f32 = 0.4;
/// Below this level lists are halved, so the depth is at most this plus 27.
const DEEP: usize = 40;
const FORK: usize = 8192;

/// A box in the tree's own coordinates, and whose it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    pub lo: [f32; 3],
    pub hi: [f32; 3],
    pub id: u32,
}

#[derive(Clone, Copy)]
struct Aabb {
    lo: [f32; 3],
    hi: [f32; 3],
}

impl Aabb {
    const NONE: Aabb = Aabb { lo: [f32::INFINITY; 3], hi: [f32::NEG_INFINITY; 3] };
    fn join(&mut self, lo: &[f32; 3], hi: &[f32; 3]) {
        for k in 0..3 {
            self.lo[k] = self.lo[k].min(lo[k]);
            self.hi[k] = self.hi[k].max(hi[k]);
        }
    }
    /// Half the surface.
    fn area(&self) -> f32 {
        let e: [f32; 3] = std::array::from_fn(|k| (self.hi[k] - self.lo[k]).max(0.0));
        e[0] * e[1] + e[1] * e[2] + e[2] * e[0]
    }
}

enum Tree {
    Leaf(Aabb, u32, u32),
    Fork(Aabb, Box<[Tree; 2]>),
}

impl Tree {
    fn bounds(&self) -> &Aabb {
        match self {
            Tree::Leaf(b, ..) | Tree::Fork(b, _) => b,
        }
    }
}

/// A tree of wide nodes over plates in leaf order.
#[derive(Default)]
pub(super) struct Built {
    pub nodes: Vec<Node>,
    /// First plate and number of plates of each leaf.
    pub leaves: Vec<(u32, u32)>,
    /// Nodes on the longest way down.
    pub depth: usize,
}

/// Builds the nodes over `items`, which end up in leaf order.
pub(super) fn build(items: &mut [Item]) -> Built {
    let mut built = Built::default();
    if !items.is_empty() {
        built.depth = widen(split(items, 0, 0), &mut built);
    }
    built
}

fn split(items: &mut [Item], first: usize, level: usize) -> Tree {
    let mut bounds = Aabb::NONE;
    items.iter().for_each(|i| bounds.join(&i.lo, &i.hi));
    if items.len() == 1 {
        return Tree::Leaf(bounds, first as u32, 1);
    }
    let leaf = (items.len() <= MAX_LEAF).then_some(blocks(items.len() as u32));
    let at = match cheapest(items, &bounds) {
        Some((cost, ..)) if leaf.is_some_and(|l| cost >= l) => {
            return Tree::Leaf(bounds, first as u32, items.len() as u32);
        }
        None if leaf.is_some() => return Tree::Leaf(bounds, first as u32, items.len() as u32),
        Some((_, axis, border, to_bin)) if level < DEEP => {
            partition(items, |i| bin(i, axis, to_bin) < border)
        }
        _ => halve(items),
    };
    let (l, r) = items.split_at_mut(at);
    let go = |part: &mut [Item], first| split(part, first, level + 1);
    let (l, r) = if l.len() + r.len() > FORK {
        rayon::join(|| go(l, first), || go(r, first + at))
    } else {
        (go(l, first), go(r, first + at))
    };
    Tree::Fork(bounds, Box::new([l, r]))
}

/// Leaves that hold n plates: they are tested eight at a time.
fn blocks(n: u32) -> f32 {
    n.div_ceil(MAX_LEAF as u32) as f32
}

fn centre2(i: &Item, axis: usize) -> f32 {
    i.lo[axis] + i.hi[axis]
}

fn bin(i: &Item, axis: usize, (low, scale): (f32, f32)) -> usize {
    (((centre2(i, axis) - low) * scale) as usize).min(BINS - 1)
}

type Border = (f32, usize, usize, (f32, f32));

/// Cost, axis, bin border and binning of the cheapest split; none when all centres coincide.
fn cheapest(items: &[Item], bounds: &Aabb) -> Option<Border> {
    let mut best: Option<Border> = None;
    for axis in 0..3 {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for i in items {
            low = low.min(centre2(i, axis));
            high = high.max(centre2(i, axis));
        }
        let scale = BINS as f32 / (high - low);
        if !(scale.is_finite() && scale > 0.0) {
            continue;
        }
        let mut bins = [(Aabb::NONE, 0u32); BINS];
        for i in items {
            let b = &mut bins[bin(i, axis, (low, scale))];
            b.0.join(&i.lo, &i.hi);
            b.1 += 1;
        }
        let mut right = [(0.0f32, 0u32); BINS];
        let mut sum = (Aabb::NONE, 0);
        for k in (1..BINS).rev() {
            sum.0.join(&bins[k].0.lo, &bins[k].0.hi);
            sum.1 += bins[k].1;
            right[k] = (sum.0.area(), sum.1);
        }
        let mut left = (Aabb::NONE, 0);
        for k in 1..BINS {
            left.0.join(&bins[k - 1].0.lo, &bins[k - 1].0.hi);
            left.1 += bins[k - 1].1;
            if left.1 == 0 || right[k].1 == 0 {
                continue;
            }
            let share = left.0.area() * blocks(left.1) + right[k].0 * blocks(right[k].1);
            let cost = TRAVERSAL + share / bounds.area().max(1e-30);
            if best.is_none_or(|b| cost < b.0) {
                best = Some((cost, axis, k, (low, scale)));
            }
        }
    }
    best
}

/// Moves the items that `left` picks to the front, both parts in their old order; returns their number.
fn partition(items: &mut [Item], left: impl Fn(&Item) -> bool) -> usize {
    let tail: Vec<Item> = items.iter().filter(|i| !left(i)).copied().collect();
    let mut n = 0;
    for k in 0..items.len() {
        if left(&items[k]) {
            items[n] = items[k];
            n += 1;
        }
    }
    items[n..].copy_from_slice(&tail);
    n
}

/// Halves the list along the axis on which the centres spread most.
fn halve(items: &mut [Item]) -> usize {
    let spread = |axis: usize| {
        let c = items.iter().map(|i| centre2(i, axis));
        c.clone().fold(f32::NEG_INFINITY, f32::max) - c.fold(f32::INFINITY, f32::min)
    };
    let axis = (0..3).max_by(|&a, &b| spread(a).total_cmp(&spread(b))).unwrap_or(0);
    items.sort_by(|a, b| centre2(a, axis).total_cmp(&centre2(b, axis)).then(a.id.cmp(&b.id)));
    items.len() / 2
}

/// Appends the wide node of `tree`; returns the depth below it. Lanes run from large to small boxes: a large one blocks
/// more segments, so looking for any hit starts there.
fn widen(tree: Tree, built: &mut Built) -> usize {
    let mut lanes = vec![tree];
    while lanes.len() < LANES {
        let widest = (0..lanes.len())
            .filter(|&k| matches!(lanes[k], Tree::Fork(..)))
            .max_by(|&a, &b| lanes[a].bounds().area().total_cmp(&lanes[b].bounds().area()));
        let Some(k) = widest else { break };
        if let Tree::Fork(_, two) = lanes.swap_remove(k) {
            lanes.extend(*two);
        }
    }
    lanes.sort_by(|a, b| b.bounds().area().total_cmp(&a.bounds().area()));
    let here = built.nodes.len();
    built.nodes.push(EMPTY);
    let mut depth = 0;
    for (lane, tree) in lanes.into_iter().enumerate() {
        for axis in 0..3 {
            built.nodes[here].bounds[axis][lane] = tree.bounds().lo[axis];
            built.nodes[here].bounds[axis + 3][lane] = tree.bounds().hi[axis];
        }
        built.nodes[here].child[lane] = match tree {
            Tree::Leaf(_, first, count) => {
                built.leaves.push((first, count));
                LEAF | (built.leaves.len() - 1) as u32
            }
            fork => {
                let next = built.nodes.len() as u32;
                depth = depth.max(widen(fork, built));
                next
            }
        };
    }
    depth + 1
}
