//! The rows of a lower triangle in blocks of about equal numbers of entries, shared among processes, and sums over them.
//!
//! A sum over all blocks is formed along a tree (`fixed_tree.rs`): every process sends the sums of its subtrees and completes the tree.

use crate::distribution::fixed_tree::{SubtreeRoot, node_sum, root, whole_subtrees};
use crate::distribution::{Communicator, Message};
use std::collections::BTreeMap;
use std::ops::Range;

/// Number of blocks of rows; fixed, so that sums do not depend on the number of threads or processes.
pub(crate) const ROW_BLOCKS: usize = 32;

/// Number of stored entries for `n` rows.
pub(crate) fn packed_length(n: usize) -> usize {
    n * (n + 1) / 2
}

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
        let mut known: BTreeMap<SubtreeRoot, Vec<T>> = BTreeMap::new();
        known.extend(self.own.clone().map(SubtreeRoot::block).zip(own));
        if self.own != (0..ROW_BLOCKS) {
            let nodes = whole_subtrees(self.own.clone(), ROW_BLOCKS);
            let mut bytes = Vec::new();
            for node in nodes {
                let list = node_sum(&mut known, node, &add);
                [u64::from(node.level), node.number as u64, list.len() as u64].put(&mut bytes);
                list.iter().for_each(|x| x.put(&mut bytes));
            }
            known.clear();
            communicator.all_gather(bytes).iter().for_each(|bytes| read_nodes(bytes, &mut known));
        }
        let mut sum = node_sum(&mut known, root(ROW_BLOCKS), &add);
        sum.resize(self.n, zero);
        sum
    }
}

/// Reads the nodes that a process sent.
fn read_nodes<T: Message>(bytes: &[u8], known: &mut BTreeMap<SubtreeRoot, Vec<T>>) {
    let mut rest = bytes;
    while let Some((head, tail)) = rest.split_at_checked(<[u64; 3]>::size()) {
        let [level, number, length] = <[u64; 3]>::get(head);
        let (list, tail) = tail.split_at(length as usize * T::size());
        let node = SubtreeRoot { level: level as u32, number: number as usize };
        known.insert(node, list.chunks_exact(T::size()).map(T::get).collect());
        rest = tail;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::thread_ranks::on_ranks;

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
}
