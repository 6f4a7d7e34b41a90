//! The rows of a lower triangle in blocks of about equal numbers of entries, shared among processes, and sums over them.
//!
//! A sum over all blocks is formed along a binary tree of fixed shape: ((b₀ + b₁) + (b₂ + b₃)) + … . A process with the blocks b to e sums the largest
//! subtrees within them, at most two of each size, and sends these; every process completes the tree.

use crate::distribution::{Communicator, Message};
use std::collections::BTreeMap;
use std::ops::Range;

/// Depth of the tree.
const TREE_LEVELS: u32 = 5;
/// Number of blocks of rows; fixed, so that sums do not depend on the number of threads or processes.
pub(crate) const ROW_BLOCKS: usize = 1 << TREE_LEVELS;

/// Number of stored entries for `n` rows.
pub(crate) fn packed_length(n: usize) -> usize {
    n * (n + 1) / 2
}

/// A node of the tree: its level above the blocks, and its number in the level.
type TreeNode = (u32, usize);

/// The blocks of a triangle, and those that a process has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct RowBlocks {
    n: usize,
    own: Range<usize>,
}

impl RowBlocks {
    /// All blocks of `n` rows.
    pub(crate) fn all(n: usize) -> RowBlocks {
        RowBlocks { n, own: 0..ROW_BLOCKS }
    }

    /// The blocks of `n` rows that this process has.
    pub(crate) fn of_rank(n: usize, communicator: &dyn Communicator) -> RowBlocks {
        let (rank, size) = (communicator.rank(), communicator.size());
        let first = |r: usize| ROW_BLOCKS * r / size;
        RowBlocks { n, own: first(rank)..first(rank + 1) }
    }

    /// The rank that has block `b`.
    fn rank_of(b: usize, size: usize) -> usize {
        (0..size).rev().find(|r| ROW_BLOCKS * r / size <= b).unwrap_or(0)
    }

    /// Number of rows of the triangle.
    pub(crate) fn rows(&self) -> usize {
        self.n
    }

    /// The first row of block `b`, the number of rows for the end of the last one.
    fn edge(&self, b: usize) -> usize {
        if b >= ROW_BLOCKS {
            self.n
        } else {
            (self.n as f64 * (b as f64 / ROW_BLOCKS as f64).sqrt()) as usize
        }
    }

    /// The rows of block `b`.
    pub(crate) fn rows_of(&self, b: usize) -> Range<usize> {
        self.edge(b)..self.edge(b + 1)
    }

    /// The rank that keeps each row.
    pub(crate) fn ranks_of_rows(&self, size: usize) -> Vec<usize> {
        (0..ROW_BLOCKS)
            .flat_map(|b| std::iter::repeat_n(RowBlocks::rank_of(b, size), self.rows_of(b).len()))
            .collect()
    }

    /// The own blocks.
    pub(crate) fn own(&self) -> Range<usize> {
        self.own.clone()
    }

    /// The rows of the own blocks.
    pub(crate) fn own_rows(&self) -> Range<usize> {
        self.edge(self.own.start)..self.edge(self.own.end)
    }

    /// Number of entries of some rows.
    pub(crate) fn entries(&self, rows: Range<usize>) -> usize {
        packed_length(rows.end) - packed_length(rows.start)
    }

    /// The sum over all blocks of lists, of which `own` holds those of the own blocks; the list of a block is as long as its last row. Missing ends count as `zero`.
    pub(crate) fn sum<T: Message + Copy>(
        &self,
        own: Vec<Vec<T>>,
        communicator: &dyn Communicator,
        zero: T,
        add: impl Fn(T, T) -> T,
    ) -> Vec<T> {
        let mut known: BTreeMap<TreeNode, Vec<T>> = BTreeMap::new();
        known.extend(self.own.clone().map(|b| (0, b)).zip(own));
        if self.own != (0..ROW_BLOCKS) {
            let nodes = whole_subtrees(self.own.clone());
            let mut bytes = Vec::new();
            for &(level, k) in &nodes {
                let list = node_sum(&mut known, (level, k), &add);
                [u64::from(level), k as u64, list.len() as u64].put(&mut bytes);
                list.iter().for_each(|x| x.put(&mut bytes));
            }
            known.clear();
            communicator.all_gather(bytes).iter().for_each(|bytes| read_nodes(bytes, &mut known));
        }
        let mut sum = node_sum(&mut known, (TREE_LEVELS, 0), &add);
        sum.resize(self.n, zero);
        sum
    }
}

/// The largest subtrees within some blocks, in their order.
fn whole_subtrees(blocks: Range<usize>) -> Vec<TreeNode> {
    let (mut out, mut next) = (Vec::new(), blocks.start);
    while next < blocks.end {
        let fits = |level: &u32| next.is_multiple_of(1 << level) && next + (1 << level) <= blocks.end;
        let level = (0..=TREE_LEVELS).rev().find(fits).unwrap_or(0);
        out.push((level, next >> level));
        next += 1 << level;
    }
    out
}

/// The sum of the blocks below a node, from known ones.
fn node_sum<T: Copy>(
    known: &mut BTreeMap<TreeNode, Vec<T>>,
    (level, k): TreeNode,
    add: &impl Fn(T, T) -> T,
) -> Vec<T> {
    if let Some(list) = known.remove(&(level, k)) {
        return list;
    }
    if level == 0 {
        return Vec::new();
    }
    let lower = node_sum(known, (level - 1, 2 * k), add);
    let mut upper = node_sum(known, (level - 1, 2 * k + 1), add);
    if upper.is_empty() {
        return lower;
    }
    upper.iter_mut().zip(lower).for_each(|(u, l)| *u = add(l, *u));
    upper
}

/// Reads the nodes that a process sent.
fn read_nodes<T: Message>(bytes: &[u8], known: &mut BTreeMap<TreeNode, Vec<T>>) {
    let mut rest = bytes;
    while let Some((head, tail)) = rest.split_at_checked(<[u64; 3]>::size()) {
        let [level, k, length] = <[u64; 3]>::get(head);
        let (list, tail) = tail.split_at(length as usize * T::size());
        known.insert((level as u32, k as usize), list.chunks_exact(T::size()).map(T::get).collect());
        rest = tail;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::tests::on_ranks;

    #[test]
    fn blocks_cover_all_rows_and_every_block_has_one_rank() {
        for n in [0, 1, 5, 1000] {
            let blocks = RowBlocks::all(n);
            assert_eq!(blocks.own_rows(), 0..n);
            let rows: Vec<usize> = (0..ROW_BLOCKS).flat_map(|b| blocks.rows_of(b)).collect();
            assert_eq!(rows, (0..n).collect::<Vec<_>>());
        }
        for size in [1, 2, 3, 7, 32, 40] {
            let own = on_ranks(size, |c| RowBlocks::of_rank(10, c).own());
            for b in 0..ROW_BLOCKS {
                assert!(own[RowBlocks::rank_of(b, size)].contains(&b), "block {b} of {size} ranks");
            }
        }
    }

    #[test]
    fn subtrees_are_the_largest_within_the_blocks() {
        assert_eq!(whole_subtrees(0..32), [(5, 0)]);
        assert_eq!(whole_subtrees(0..16), [(4, 0)]);
        assert_eq!(whole_subtrees(10..21), [(1, 5), (2, 3), (2, 4), (0, 20)]);
        assert_eq!(whole_subtrees(4..4), []);
    }
}
