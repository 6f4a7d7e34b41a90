//! Wide nodes from the binary tree; [`super::wide_cuts`] chooses the lanes.
//!
//! **Order of lanes.** An any-hit query visits the lanes that it meets in their order, until it is occluded. With p the chance that a
//! line which meets a lane's box is occluded within, and c the cost of the visit, the expected cost is least in the order of falling
//! p/c. A leaf has p = A/(S/2), A the area of its plates, at most 1; a node has p = 1 − Π (1 − s p) over its lanes, s the surface of a
//! lane relative to the node's. This p of a node treats its lanes as independent; measured rates (peers/embree) are up to 5 % higher
//! in the order of falling p/c², which is used.

use super::build::{Aabb, BinaryLeaf, BinaryNode, BuildItem, split};
use super::node::{EMPTY_NODE, LEAF_FLAG, NODE_WIDTH, WideNode};
use super::wide_cuts::NODE_COST;
use std::ops::Range;

/// Wide nodes over plates in leaf order.
#[derive(Default)]
pub(super) struct WideTree {
    pub nodes: Vec<WideNode>,
    /// Plates of each leaf.
    pub leaves: Vec<Range<u32>>,
    /// Nodes on the longest path from the root.
    pub depth: usize,
}

/// Builds the nodes over `items`, which end up in leaf order.
pub(super) fn build(items: &mut [BuildItem]) -> WideTree {
    let mut tree = WideTree::default();
    if !items.is_empty() {
        let root = Lane::of(split(items, 0, 0));
        tree.nodes.push(EMPTY_NODE);
        tree.depth = store(root, 0, &mut tree);
    }
    tree
}

/// The content of a lane of a wide node.
enum LaneContent {
    Leaf(BinaryLeaf),
    Node(Vec<Lane>),
}

/// A lane of a wide node.
struct Lane {
    bounds: Aabb,
    content: LaneContent,
    /// Chance that a line which meets the box is occluded within.
    occlusion: f32,
    /// Expected cost of a visit.
    cost: f32,
}

impl Lane {
    fn of(node: BinaryNode) -> Lane {
        let bounds = *node.bounds();
        let fork = match node {
            BinaryNode::Leaf(leaf) => {
                let occlusion = (leaf.area / bounds.half_area().max(1e-30)).min(1.0);
                return Lane { bounds, content: LaneContent::Leaf(leaf), occlusion, cost: 1.0 };
            }
            BinaryNode::Fork(fork) => fork,
        };
        let mut lanes = Vec::with_capacity(NODE_WIDTH);
        let j = usize::from(fork.cuts.left[NODE_WIDTH]);
        let [l, r] = fork.children;
        cut(l, j, &mut lanes);
        cut(r, NODE_WIDTH - j, &mut lanes);
        // p/c²
        let rank = |l: &Lane| l.occlusion / (l.cost * l.cost);
        lanes.sort_by(|a, b| rank(b).total_cmp(&rank(a)));
        let (mut free, mut cost) = (1.0, NODE_COST);
        for lane in &lanes {
            let share = (lane.bounds.half_area() / bounds.half_area().max(1e-30)).min(1.0);
            cost += free * share * lane.cost;
            free *= 1.0 - share * lane.occlusion;
        }
        Lane { bounds, content: LaneContent::Node(lanes), occlusion: 1.0 - free, cost }
    }
}

/// Appends a binary node as at most `count` lanes.
fn cut(node: BinaryNode, count: usize, lanes: &mut Vec<Lane>) {
    let fork = match node {
        BinaryNode::Fork(fork) => fork,
        leaf => return lanes.push(Lane::of(leaf)),
    };
    let count = (2..=count).rev().find(|&k| fork.cuts.left[k] > 0);
    let Some(count) = count else { return lanes.push(Lane::of(BinaryNode::Fork(fork))) };
    let j = usize::from(fork.cuts.left[count]);
    let [l, r] = fork.children;
    cut(l, j, lanes);
    cut(r, count - j, lanes);
}

/// Writes the wide node of `lane` at index `here`, and appends the nodes below; returns their depth. The children of a node are
/// neighbours in memory.
fn store(lane: Lane, here: usize, tree: &mut WideTree) -> usize {
    let lanes = match lane.content {
        LaneContent::Node(lanes) => lanes,
        LaneContent::Leaf(_) => vec![lane],
    };
    let mut inner = Vec::with_capacity(NODE_WIDTH);
    for (k, lane) in lanes.into_iter().enumerate() {
        for axis in 0..3 {
            tree.nodes[here].bounds[axis][k] = lane.bounds.lo[axis];
            tree.nodes[here].bounds[axis + 3][k] = lane.bounds.hi[axis];
        }
        tree.nodes[here].child[k] = match &lane.content {
            LaneContent::Leaf(leaf) => {
                tree.leaves.push(leaf.first..leaf.first + leaf.count);
                LEAF_FLAG | (tree.leaves.len() - 1) as u32
            }
            LaneContent::Node(_) => {
                tree.nodes.push(EMPTY_NODE);
                inner.push((lane, tree.nodes.len() - 1));
                (tree.nodes.len() - 1) as u32
            }
        };
    }
    let below = inner.into_iter().map(|(lane, at)| store(lane, at, tree)).max();
    1 + below.unwrap_or(0)
}
