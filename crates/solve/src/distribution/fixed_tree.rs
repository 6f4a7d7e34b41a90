//! Sums over blocks along a binary tree of fixed shape, ((b₀ + b₁) + (b₂ + b₃)) + …, whose bits do not depend on who has which blocks.
//!
//! A process with the blocks b to e sums the largest subtrees within them, at most two of each size, and sends these; the receiver completes the tree.

use std::collections::BTreeMap;
use std::ops::Range;

/// A node of the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct SubtreeRoot {
    /// Its level above the blocks.
    pub level: u32,
    /// Its number in the level.
    pub number: usize,
}

impl SubtreeRoot {
    /// A block.
    pub(crate) fn block(number: usize) -> SubtreeRoot {
        SubtreeRoot { level: 0, number }
    }

    /// The first block below the node.
    pub(crate) fn first_block(self) -> usize {
        self.number << self.level
    }
}

/// The root of the tree over some blocks.
pub(crate) fn root(blocks: usize) -> SubtreeRoot {
    SubtreeRoot { level: blocks.next_power_of_two().trailing_zeros(), number: 0 }
}

/// The largest subtrees within some of `count` blocks, in their order. A subtree may lack blocks beyond the last one.
pub(crate) fn whole_subtrees(blocks: Range<usize>, count: usize) -> Vec<SubtreeRoot> {
    let (mut out, mut next) = (Vec::new(), blocks.start);
    while next < blocks.end {
        let fits = |level: &u32| {
            let end = next + (1 << level);
            next.is_multiple_of(1 << level) && (end <= blocks.end || blocks.end == count)
        };
        let level = (0..=root(count).level).rev().find(fits).unwrap_or(0);
        out.push(SubtreeRoot { level, number: next >> level });
        next += 1 << level;
    }
    out
}

/// The sum of the blocks below a node, from known ones. A missing node counts as an empty list; the longer of two lists is the upper one.
pub(crate) fn node_sum<T: Copy>(
    known: &mut BTreeMap<SubtreeRoot, Vec<T>>,
    node: SubtreeRoot,
    add: &impl Fn(T, T) -> T,
) -> Vec<T> {
    if let Some(list) = known.remove(&node) {
        return list;
    }
    if node.level == 0 {
        return Vec::new();
    }
    let [lower, mut upper] = [0, 1].map(|half| {
        let child = SubtreeRoot { level: node.level - 1, number: 2 * node.number + half };
        node_sum(known, child, add)
    });
    if upper.is_empty() {
        return lower;
    }
    upper.iter_mut().zip(lower).for_each(|(u, l)| *u = add(l, *u));
    upper
}

/// Sums the largest subtrees within some of `count` blocks in place: the sum of a subtree is left in its first block. `values` are those of the blocks of the
/// range; `add` adds the second one to the first.
pub(crate) fn sum_subtrees_in_place<T>(
    values: &mut [T],
    blocks: Range<usize>,
    count: usize,
    add: impl Fn(&mut T, &T),
) {
    let first = blocks.start;
    for node in whole_subtrees(blocks.clone(), count) {
        let end = ((node.number + 1) << node.level).min(count);
        let own = &mut values[node.first_block() - first..end - first];
        for stride in (0..node.level).map(|l| 1 << l) {
            for pair in own.chunks_mut(2 * stride).filter(|pair| pair.len() > stride) {
                let (lower, upper) = pair.split_at_mut(stride);
                add(&mut lower[0], &upper[0]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subtrees_are_the_largest_within_the_blocks() {
        let subtrees = |blocks: Range<usize>, count: usize| -> Vec<(u32, usize)> {
            whole_subtrees(blocks, count).into_iter().map(|node| (node.level, node.number)).collect()
        };
        assert_eq!(subtrees(0..32, 32), [(5, 0)]);
        assert_eq!(subtrees(0..16, 32), [(4, 0)]);
        assert_eq!(subtrees(10..21, 32), [(1, 5), (2, 3), (2, 4), (0, 20)]);
        assert_eq!(subtrees(4..4, 32), []);
        assert_eq!(subtrees(0..5, 5), [(3, 0)]);
        assert_eq!(subtrees(3..5, 5), [(0, 3), (2, 1)]);
    }

    #[test]
    fn the_sum_does_not_depend_on_the_division() {
        let values = |blocks: Range<usize>| blocks.map(|b| vec![1.0 / (b as f64 + 0.7)]).collect::<Vec<_>>();
        let add = |a: &mut Vec<f64>, b: &Vec<f64>| a[0] += b[0];
        for count in [1, 2, 5, 8, 13, 32] {
            let mut all = values(0..count);
            sum_subtrees_in_place(&mut all, 0..count, count, add);
            for cut in 0..=count {
                let mut known = BTreeMap::new();
                for blocks in [0..cut, cut..count] {
                    let mut own = values(blocks.clone());
                    sum_subtrees_in_place(&mut own, blocks.clone(), count, add);
                    for node in whole_subtrees(blocks.clone(), count) {
                        known.insert(node, own[node.first_block() - blocks.start].clone());
                    }
                }
                let sum = node_sum(&mut known, root(count), &|a, b| a + b);
                assert_eq!(sum[0].to_bits(), all[0][0].to_bits(), "{count} blocks cut at {cut}");
            }
        }
    }
}
