//! The binary tree of the hierarchy, by the binned surface area heuristic. [`super::collapse`] makes wide nodes of it.
//!
//! A split of n boxes with surface S costs c_t + (S_l n_l + S_r n_r)/S plate tests; the cheapest of 16 bin borders on each axis
//! is taken (Wald 2007). Where all centres coincide, or the tree gets deep, the list is halved.

use super::node::NODE_WIDTH;
use super::wide_cuts::WideCuts;

/// Most plates of a leaf, which are tested side by side.
pub(super) const MAX_LEAF_PLATES: usize = NODE_WIDTH;
/// Bins of the heuristic along an axis.
const SAH_BINS: usize = 16;
/// Cost c_t of the traversal of a node, in tests of eight plates.
const TRAVERSAL_COST: f32 = 0.4;
/// Level from which lists are halved: the depth is at most this plus 27.
const MEDIAN_SPLIT_LEVEL: usize = 40;
/// Lists longer than this are split in parallel.
const PARALLEL_BUILD_ITEMS: usize = 8192;

/// The box of a plate in the tree's coordinates, and the index of the plate.
#[derive(Clone, Copy, Debug)]
pub(super) struct BuildItem {
    pub lo: [f32; 3],
    pub hi: [f32; 3],
    /// Area of the plate in the tree's units.
    pub area: f32,
    pub id: u32,
}

#[derive(Clone, Copy)]
pub(super) struct Aabb {
    pub lo: [f32; 3],
    pub hi: [f32; 3],
}

impl Aabb {
    const EMPTY_BOX: Aabb = Aabb { lo: [f32::INFINITY; 3], hi: [f32::NEG_INFINITY; 3] };
    fn join(&mut self, lo: &[f32; 3], hi: &[f32; 3]) {
        for k in 0..3 {
            self.lo[k] = self.lo[k].min(lo[k]);
            self.hi[k] = self.hi[k].max(hi[k]);
        }
    }
    /// Half the surface area.
    pub(super) fn half_area(&self) -> f32 {
        let e: [f32; 3] = std::array::from_fn(|k| (self.hi[k] - self.lo[k]).max(0.0));
        e[0] * e[1] + e[1] * e[2] + e[2] * e[0]
    }
}

/// A node of the binary tree.
pub(super) enum BinaryNode {
    /// A leaf.
    Leaf(BinaryLeaf),
    /// An inner node.
    Fork(Box<BinaryFork>),
}

/// A leaf of the binary tree.
pub(super) struct BinaryLeaf {
    pub bounds: Aabb,
    /// Number of the first item.
    pub first: u32,
    /// Number of items.
    pub count: u32,
    /// Area of the plates in the tree's units.
    pub area: f32,
}

/// An inner node of the binary tree.
pub(super) struct BinaryFork {
    pub bounds: Aabb,
    pub children: [BinaryNode; 2],
    pub cuts: WideCuts,
}

impl BinaryNode {
    pub(super) fn bounds(&self) -> &Aabb {
        match self {
            BinaryNode::Leaf(leaf) => &leaf.bounds,
            BinaryNode::Fork(fork) => &fork.bounds,
        }
    }
    /// C(n, k) for k = 1, …, 7.
    fn costs(&self) -> [f32; NODE_WIDTH] {
        match self {
            BinaryNode::Leaf(leaf) => [leaf.bounds.half_area(); NODE_WIDTH],
            BinaryNode::Fork(fork) => fork.cuts.cost,
        }
    }
    /// The leaf of all `items`, the first of which is number `first` of all.
    fn leaf(items: &[BuildItem], bounds: Aabb, first: usize) -> BinaryNode {
        let area = items.iter().map(|i| i.area).sum();
        BinaryNode::Leaf(BinaryLeaf { bounds, first: first as u32, count: items.len() as u32, area })
    }
}

/// Builds the binary tree over `items`, the first of which is number `first` of all.
pub(super) fn split(items: &mut [BuildItem], first: usize, level: usize) -> BinaryNode {
    let mut bounds = Aabb::EMPTY_BOX;
    items.iter().for_each(|i| bounds.join(&i.lo, &i.hi));
    if items.len() == 1 {
        return BinaryNode::leaf(items, bounds, first);
    }
    let leaf_cost = (items.len() <= MAX_LEAF_PLATES).then_some(block_count(items.len() as u32));
    // Choose a leaf, the cheapest bin border, or the median.
    let at = match cheapest_split(items, &bounds) {
        Some(split) if leaf_cost.is_some_and(|l| split.cost >= l) => {
            return BinaryNode::leaf(items, bounds, first);
        }
        None if leaf_cost.is_some() => return BinaryNode::leaf(items, bounds, first),
        Some(BinSplit { binning, border, .. }) if level < MEDIAN_SPLIT_LEVEL => {
            partition(items, |i| binning.bin(i) < border)
        }
        _ => split_at_median(items),
    };
    let (l, r) = items.split_at_mut(at);
    let build = |part: &mut [BuildItem], first| split(part, first, level + 1);
    let (l, r) = if l.len() + r.len() > PARALLEL_BUILD_ITEMS {
        rayon::join(|| build(l, first), || build(r, first + at))
    } else {
        (build(l, first), build(r, first + at))
    };
    let cuts = WideCuts::new(bounds.half_area(), &l.costs(), &r.costs());
    BinaryNode::Fork(Box::new(BinaryFork { bounds, children: [l, r], cuts }))
}

/// Blocks of eight that hold n plates, as a cost.
fn block_count(n: u32) -> f32 {
    n.div_ceil(MAX_LEAF_PLATES as u32) as f32
}

/// Twice the centre of a box on an axis.
fn twice_centre(i: &BuildItem, axis: usize) -> f32 {
    i.lo[axis] + i.hi[axis]
}

/// Bins of equal width along an axis.
#[derive(Clone, Copy)]
struct Binning {
    axis: usize,
    /// Twice the smallest centre of an item.
    low: f32,
    /// Bins per length, over 2.
    scale: f32,
}

impl Binning {
    /// Bin of an item.
    fn bin(&self, i: &BuildItem) -> usize {
        (((twice_centre(i, self.axis) - self.low) * self.scale) as usize).min(SAH_BINS - 1)
    }
}

/// A split at the border before a bin.
#[derive(Clone, Copy)]
struct BinSplit {
    cost: f32,
    binning: Binning,
    border: usize,
}

/// The cheapest split; `None` when all centres coincide.
fn cheapest_split(items: &[BuildItem], bounds: &Aabb) -> Option<BinSplit> {
    let mut best: Option<BinSplit> = None;
    for axis in 0..3 {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for i in items {
            low = low.min(twice_centre(i, axis));
            high = high.max(twice_centre(i, axis));
        }
        let scale = SAH_BINS as f32 / (high - low);
        if !(scale.is_finite() && scale > 0.0) {
            continue;
        }
        let binning = Binning { axis, low, scale };
        let mut bins = [(Aabb::EMPTY_BOX, 0u32); SAH_BINS];
        for i in items {
            let b = &mut bins[binning.bin(i)];
            b.0.join(&i.lo, &i.hi);
            b.1 += 1;
        }
        let mut right = [(0.0f32, 0u32); SAH_BINS];
        let mut sum = (Aabb::EMPTY_BOX, 0);
        for k in (1..SAH_BINS).rev() {
            sum.0.join(&bins[k].0.lo, &bins[k].0.hi);
            sum.1 += bins[k].1;
            right[k] = (sum.0.half_area(), sum.1);
        }
        let mut left = (Aabb::EMPTY_BOX, 0);
        for k in 1..SAH_BINS {
            left.0.join(&bins[k - 1].0.lo, &bins[k - 1].0.hi);
            left.1 += bins[k - 1].1;
            if left.1 == 0 || right[k].1 == 0 {
                continue;
            }
            let share = left.0.half_area() * block_count(left.1) + right[k].0 * block_count(right[k].1);
            let cost = TRAVERSAL_COST + share / bounds.half_area().max(1e-30);
            if best.is_none_or(|b| cost < b.cost) {
                best = Some(BinSplit { cost, binning, border: k });
            }
        }
    }
    best
}

/// Stable partition: moves the items that satisfy `left` to the front; returns their number.
fn partition(items: &mut [BuildItem], left: impl Fn(&BuildItem) -> bool) -> usize {
    let tail: Vec<BuildItem> = items.iter().filter(|i| !left(i)).copied().collect();
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

/// Splits the list at the median along the axis on which the centres spread most.
fn split_at_median(items: &mut [BuildItem]) -> usize {
    let spread = |axis: usize| {
        let c = items.iter().map(|i| twice_centre(i, axis));
        c.clone().fold(f32::NEG_INFINITY, f32::max) - c.fold(f32::INFINITY, f32::min)
    };
    let axis = (0..3).max_by(|&a, &b| spread(a).total_cmp(&spread(b))).unwrap_or(0);
    items.sort_by(|a, b| twice_centre(a, axis).total_cmp(&twice_centre(b, axis)).then(a.id.cmp(&b.id)));
    items.len() / 2
}
