//! Work that several processes share: the ranks of a distributed solve.
//!
//! Every rank holds the scene and its zones, and follows the same phases. Work on many items (zones, rows, tables) is cut into blocks of fixed size; rank r
//! of R does the blocks r, r + R, r + 2R, …, and every rank receives the results of all. Blocks that lie side by side cost about as much, so that no
//! forecast is needed.
//!
//! **Identical results.** An item never depends on the rank that computes it, and sums over items are formed on every rank from all of them, in one
//! order. So a solution has the same bits for any number of ranks, as for any number of threads.
//!
//! | module | content |
//! |---|---|
//! | `message` | bytes of the values that processes exchange |
//! | `sum_order`, `fixed_tree` | sums over the zones and over blocks in an order that no division changes |
//! | `zone_blocks` | blocks of the zones of a box, and their sums |
//! | `multivector` | vectors over the zones, several side by side |
//!
//! The edge of the program implements [`Communicator`], by MPI in the crate `zonal-mpi`. This crate knows [`SingleProcess`] alone.

pub(crate) mod fixed_tree;
mod message;
pub(crate) mod multivector;
pub(crate) mod sum_order;
pub(crate) mod zone_blocks;

pub(crate) use message::Message;

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use zonal_fourier::Complex64;
use zonal_math::parallel;
use zonal_math::simd::{complex_bytes, complex_bytes_mut};
use zonal_scene::Progress;

/// Part `part` of `parts` about equal parts of `0..n`.
pub(crate) fn part_of(n: usize, part: usize, parts: usize) -> Range<usize> {
    n * part / parts..n * (part + 1) / parts
}

/// The processes of a solve, which follow the same steps. Calls are collective: every rank makes the same ones in the same order.
pub trait Communicator: Sync {
    /// Number of this process, below [`Communicator::size`].
    fn rank(&self) -> usize;
    /// Number of processes.
    fn size(&self) -> usize;
    /// The bytes of every rank, in the order of the ranks.
    fn all_gather(&self, own: Vec<u8>) -> Vec<Vec<u8>>;
    /// Sends part r to rank r; the parts that were sent to this rank, in the order of the ranks.
    fn all_to_all(&self, parts: Vec<Vec<u8>>) -> Vec<Vec<u8>>;
    /// Fills `received` with the parts that other ranks send. Lengths are known on both sides, and buffers serve again: for messages of many bytes.
    fn exchange(&self, mut buffers: ExchangeBuffers) -> ExchangeBuffers {
        let mut rest = &buffers.sent[..];
        let mut part = |length: &usize| {
            let (own, further) = rest.split_at(*length);
            rest = further;
            complex_bytes(own).to_vec()
        };
        let received = self.all_to_all(buffers.sent_lengths.iter().map(&mut part).collect()).concat();
        complex_bytes_mut(&mut buffers.received).copy_from_slice(&received);
        buffers
    }
}

/// Complex numbers on their way between ranks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExchangeBuffers {
    /// The parts for all ranks, in their order.
    pub sent: Vec<Complex64>,
    /// Numbers of each of these parts.
    pub sent_lengths: Vec<usize>,
    /// The parts from all ranks, in their order.
    pub received: Vec<Complex64>,
    /// Numbers of each of these parts; their sum is the length of `received`.
    pub received_lengths: Vec<usize>,
}

/// Begins of the names of stages of a checkpoint that one rank computes and saves; all ranks have the others.
const STAGES_OF_ONE_RANK: [&str; 3] = ["views-", "rows-", "-part-"];

/// True for a stage of a checkpoint that only the rank has which computes it; other stages are the same on all ranks, and one of them saves them.
#[must_use]
pub fn is_stage_of_one_rank(stage: &str) -> bool {
    STAGES_OF_ONE_RANK.iter().any(|begin| stage.contains(begin))
}

/// One process.
#[derive(Clone, Copy, Debug, Default)]
pub struct SingleProcess;

impl Communicator for SingleProcess {
    fn rank(&self) -> usize {
        0
    }
    fn size(&self) -> usize {
        1
    }
    fn all_gather(&self, own: Vec<u8>) -> Vec<Vec<u8>> {
        vec![own]
    }
    fn all_to_all(&self, parts: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        parts
    }
}

/// Bytes and calls by which a process has sent messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SentMessages {
    /// Bytes to other processes; the same bytes to several count several times.
    pub bytes: u64,
    /// Collective calls.
    pub calls: u64,
}

/// Processes that count what they send.
pub struct CountedRanks<'a> {
    ranks: &'a dyn Communicator,
    bytes: AtomicU64,
    calls: AtomicU64,
}

impl<'a> CountedRanks<'a> {
    /// Counts what `ranks` send.
    pub fn new(ranks: &'a dyn Communicator) -> CountedRanks<'a> {
        CountedRanks { ranks, bytes: AtomicU64::new(0), calls: AtomicU64::new(0) }
    }
    /// What this process has sent so far.
    pub fn sent(&self) -> SentMessages {
        SentMessages { bytes: self.bytes.load(Ordering::Relaxed), calls: self.calls.load(Ordering::Relaxed) }
    }
    fn count(&self, bytes: usize) {
        self.bytes.fetch_add(bytes as u64, Ordering::Relaxed);
        self.calls.fetch_add(1, Ordering::Relaxed);
    }
    fn to_others<T>(&self, parts: &[T], bytes: impl Fn(&T) -> usize) -> usize {
        let others = parts.iter().enumerate().filter(|(r, _)| *r != self.rank());
        others.map(|(_, part)| bytes(part)).sum()
    }
}

impl Communicator for CountedRanks<'_> {
    fn rank(&self) -> usize {
        self.ranks.rank()
    }
    fn size(&self) -> usize {
        self.ranks.size()
    }
    fn all_gather(&self, own: Vec<u8>) -> Vec<Vec<u8>> {
        self.count(own.len() * (self.size() - 1));
        self.ranks.all_gather(own)
    }
    fn all_to_all(&self, parts: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        self.count(self.to_others(&parts, Vec::len));
        self.ranks.all_to_all(parts)
    }
    fn exchange(&self, buffers: ExchangeBuffers) -> ExchangeBuffers {
        self.count(self.to_others(&buffers.sent_lengths, |n| size_of::<Complex64>() * n));
        self.ranks.exchange(buffers)
    }
}

/// Who does the work, and who watches it.
#[derive(Clone, Copy)]
pub struct Execution<'a> {
    /// The processes that share the work.
    pub communicator: &'a dyn Communicator,
    /// Observer.
    pub progress: &'a dyn Progress,
}

impl<'a> Execution<'a> {
    /// One process.
    pub fn alone(progress: &'a dyn Progress) -> Execution<'a> {
        Execution { communicator: &SingleProcess, progress }
    }

    /// The sum of a number over all ranks.
    pub(crate) fn sum_of_ranks(&self, own: u64) -> u64 {
        let all = self.communicator.all_gather(own.to_le_bytes().to_vec());
        all.iter().map(|bytes| u64::get(bytes)).sum()
    }

    /// `items` items in blocks of `block`.
    pub(crate) fn blocks(&self, items: usize, block: usize) -> Blocks {
        Blocks::new(self.communicator, items, block)
    }
}

/// The division of a number of items among the ranks, in blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Blocks {
    items: usize,
    block: usize,
    rank: usize,
    size: usize,
}

impl Blocks {
    /// `items` items in blocks of `block`.
    pub(crate) fn new(communicator: &dyn Communicator, items: usize, block: usize) -> Blocks {
        Blocks { items, block, rank: communicator.rank(), size: communicator.size() }
    }

    /// Number of items.
    pub(crate) fn items(&self) -> usize {
        self.items
    }

    /// Number of blocks.
    pub(crate) fn count(&self) -> usize {
        self.items.div_ceil(self.block)
    }

    /// The items of block `b`.
    pub(crate) fn range(&self, b: usize) -> Range<usize> {
        b * self.block..((b + 1) * self.block).min(self.items)
    }

    /// The blocks of a rank.
    fn of_rank(&self, rank: usize) -> impl Iterator<Item = usize> + Clone + use<> {
        (rank..self.count()).step_by(self.size)
    }

    /// True if block `b` is of this rank.
    pub(crate) fn is_own_block(&self, b: usize) -> bool {
        b % self.size == self.rank
    }

    /// The number of an own item among the own items.
    pub(crate) fn place(&self, i: usize) -> usize {
        i / self.block / self.size * self.block + i % self.block
    }

    /// The blocks of this rank.
    pub(crate) fn own(&self) -> impl Iterator<Item = usize> + Clone + use<> {
        self.of_rank(self.rank)
    }

    /// The items of this rank, in their order.
    pub(crate) fn own_items(&self) -> impl Iterator<Item = usize> + use<'_> {
        self.own().flat_map(|b| self.range(b))
    }

    /// Sends the bytes that `put` writes for the own items, and reads those of the other ranks by `take`, item by item, which returns how many it read. Items without bytes
    /// cost nothing.
    pub(crate) fn exchange(
        &self,
        communicator: &dyn Communicator,
        put: impl Fn(usize, &mut Vec<u8>),
        mut take: impl FnMut(usize, &[u8]) -> usize,
    ) {
        if self.size == 1 {
            return;
        }
        let mut own = Vec::new();
        self.own_items().for_each(|i| put(i, &mut own));
        let all = communicator.all_gather(own);
        for (rank, bytes) in all.iter().enumerate().filter(|(rank, _)| *rank != self.rank) {
            let mut read = 0;
            for i in self.of_rank(rank).flat_map(|b| self.range(b)) {
                read += take(i, &bytes[read..]);
            }
        }
    }

    /// The values of all items, of which this rank has those of its own items, in their order.
    pub(crate) fn gather<T: Message>(&self, communicator: &dyn Communicator, own: Vec<T>) -> Vec<T> {
        if self.size == 1 {
            return own;
        }
        let mut bytes = Vec::with_capacity(own.len() * T::size());
        own.iter().for_each(|x| x.put(&mut bytes));
        drop(own);
        let all = communicator.all_gather(bytes);
        let mut parts: Vec<_> = all.iter().map(|bytes| bytes.chunks_exact(T::size())).collect();
        let mut out = Vec::with_capacity(self.items);
        for b in 0..self.count() {
            let values = parts[b % self.size].by_ref();
            out.extend(values.take(self.range(b).len()).map(T::get));
        }
        out
    }

    /// The lists `f` of every item, each of a known length and computed on its rank by all threads.
    pub(crate) fn map_lists<T: Message + Clone>(
        &self,
        communicator: &dyn Communicator,
        length: impl Fn(usize) -> usize,
        f: impl Fn(usize) -> Vec<T> + Sync,
    ) -> Vec<Vec<T>> {
        let items: Vec<usize> = self.own_items().collect();
        self.gather_lists(communicator, length, parallel::map(&items, |i| f(*i)))
    }

    /// The lists of every item, each of a known length, of which this rank has those of its own items.
    pub(crate) fn gather_lists<T: Message + Clone>(
        &self,
        communicator: &dyn Communicator,
        length: impl Fn(usize) -> usize,
        own: Vec<Vec<T>>,
    ) -> Vec<Vec<T>> {
        if self.size == 1 {
            return own;
        }
        let mut lists: Vec<Vec<T>> = vec![Vec::new(); self.items];
        let put = |i: usize, out: &mut Vec<u8>| own[self.place(i)].iter().for_each(|x| x.put(out));
        let take = |i: usize, bytes: &[u8]| {
            let size = length(i) * T::size();
            lists[i] = bytes[..size].chunks_exact(T::size()).map(T::get).collect();
            size
        };
        self.exchange(communicator, put, take);
        self.own_items().zip(own).for_each(|(i, list)| lists[i] = list);
        lists
    }

    /// The lists `f` of every item, each of any length and computed on its rank by all threads.
    pub(crate) fn map_unequal_lists<T: Message + Clone>(
        &self,
        communicator: &dyn Communicator,
        f: &(dyn Fn(usize) -> Vec<T> + Sync),
    ) -> Vec<Vec<T>> {
        let items: Vec<usize> = self.own_items().collect();
        let own: Vec<Vec<T>> = parallel::collect_tasks(items.len(), |k| f(items[k]));
        let lengths = self.gather(communicator, own.iter().map(|list| list.len() as u64).collect());
        self.gather_lists(communicator, |i| lengths[i] as usize, own)
    }

    /// `f` of every item, each computed on its rank by all threads.
    pub(crate) fn map<T: Message>(
        &self,
        communicator: &dyn Communicator,
        f: impl Fn(usize) -> T + Sync,
    ) -> Vec<T> {
        if self.size == 1 {
            return parallel::collect(self.items, &f);
        }
        let items: Vec<usize> = self.own_items().collect();
        self.gather(communicator, parallel::map(&items, |i| f(*i)))
    }
}

#[cfg(test)]
#[path = "../../tests/common/thread_ranks.rs"]
pub(crate) mod thread_ranks;

#[cfg(test)]
mod tests {
    use super::thread_ranks::on_ranks;
    use super::*;
    use zonal_scene::Bands;

    #[test]
    fn every_rank_receives_all_values_in_their_order() {
        for (items, block) in [(0, 4), (1, 4), (10, 4), (23, 3), (64, 16)] {
            let of = |i: usize| [Bands::splat(i as f64), Bands::splat(-0.5)];
            let want: Vec<[Bands; 2]> = (0..items).map(of).collect();
            for size in [1, 2, 3, 7] {
                for found in on_ranks(size, |c| Blocks::new(c, items, block).map(c, of)) {
                    assert_eq!(found, want, "{items} items in blocks of {block} on {size} ranks");
                }
            }
        }
    }

    #[test]
    fn every_item_has_one_rank() {
        let (items, block, size) = (100, 7, 3);
        let of_rank = |c: &dyn Communicator| Blocks::new(c, items, block).own_items().collect::<Vec<_>>();
        let mut all = on_ranks(size, of_rank).concat();
        all.sort_unstable();
        assert_eq!(all, (0..items).collect::<Vec<_>>());
        on_ranks(size, |c| {
            let blocks = Blocks::new(c, items, block);
            blocks.own_items().enumerate().for_each(|(place, i)| assert_eq!(blocks.place(i), place));
        });
    }
}
