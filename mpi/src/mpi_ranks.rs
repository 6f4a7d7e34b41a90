//! The ranks of MPI as a `Communicator`.
//!
//! MPI is called by one thread, the main one, which serves the requests of the solve: so MPI needs no support of threads beyond `MPI_THREAD_FUNNELED`, and the
//! communicator of the solve may be shared by its threads. Counts of MPI are 32-bit integers; longer messages are sent in rounds.

use mpi::datatype::{Partition, PartitionMut};
use mpi::traits::CommunicatorCollectives;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Instant;
use zonal_math::simd::{complex_parts, complex_parts_mut};
use zonal_solve::distribution::{Communicator, ExchangeBuffers};

/// Most bytes that a rank receives in one call of MPI.
const MAX_RECEIVED_BYTES: usize = 1 << 30;

/// One list of bytes for each rank.
type Parts = Vec<Vec<u8>>;

/// A collective operation of the solve.
enum Request {
    AllGather(Vec<u8>, Sender<Parts>),
    AllToAll(Parts, Sender<Parts>),
    Exchange(ExchangeBuffers, Sender<ExchangeBuffers>),
}

/// The processes of MPI, for the threads of a solve.
pub(crate) struct MpiRanks {
    rank: usize,
    size: usize,
    requests: Mutex<Sender<Request>>,
    /// Microseconds from requests to their replies.
    microseconds: AtomicU64,
}

/// The end of the thread that calls MPI.
pub(crate) struct MpiServer {
    requests: Receiver<Request>,
}

/// The two ends, for a communicator of MPI.
pub(crate) fn mpi_ranks(world: &impl mpi::traits::Communicator) -> (MpiRanks, MpiServer) {
    let (sender, requests) = channel();
    let (rank, size) = (world.rank() as usize, world.size() as usize);
    (
        MpiRanks { rank, size, requests: Mutex::new(sender), microseconds: AtomicU64::new(0) },
        MpiServer { requests },
    )
}

impl MpiServer {
    /// Serves the requests until the [`MpiRanks`] are dropped.
    pub(crate) fn serve(self, world: &impl CommunicatorCollectives) {
        for request in self.requests {
            // A receiver that is gone has ended with an error of its own.
            match request {
                Request::AllGather(own, reply) => drop(reply.send(all_gather(world, &own))),
                Request::AllToAll(parts, reply) => drop(reply.send(all_to_all(world, &parts))),
                Request::Exchange(buffers, reply) => drop(reply.send(exchange(world, buffers))),
            }
        }
    }
}

impl MpiRanks {
    /// Seconds from requests to their replies: messages, and the time that other ranks needed to take part.
    pub(crate) fn seconds_in_messages(&self) -> f64 {
        self.microseconds.load(Ordering::Relaxed) as f64 * 1e-6
    }

    /// Sends a request to the thread of MPI and waits for the reply.
    fn request<T>(&self, request: impl FnOnce(Sender<T>) -> Request) -> T {
        let (sender, reply) = channel();
        let start = Instant::now();
        let sent = self.requests.lock().is_ok_and(|requests| requests.send(request(sender)).is_ok());
        let received = if sent { reply.recv().ok() } else { None };
        self.microseconds.fetch_add(start.elapsed().as_micros() as u64, Ordering::Relaxed);
        received.expect("the thread of MPI serves requests as long as a solve runs")
    }
}

impl Communicator for MpiRanks {
    fn rank(&self) -> usize {
        self.rank
    }
    fn size(&self) -> usize {
        self.size
    }
    fn all_gather(&self, own: Vec<u8>) -> Parts {
        self.request(|reply| Request::AllGather(own, reply))
    }
    fn all_to_all(&self, parts: Parts) -> Parts {
        self.request(|reply| Request::AllToAll(parts, reply))
    }
    fn exchange(&self, buffers: ExchangeBuffers) -> ExchangeBuffers {
        self.request(|reply| Request::Exchange(buffers, reply))
    }
}

/// The part of round `round` of `bytes`, at most `limit` bytes in a round.
fn part_of_round(bytes: &[u8], round: usize, limit: usize) -> &[u8] {
    let start = (round * limit).min(bytes.len());
    &bytes[start..(start + limit).min(bytes.len())]
}

/// Length of the part of round `round` of `length` bytes.
fn length_of_round(length: usize, round: usize, limit: usize) -> usize {
    length.saturating_sub(round * limit).min(limit)
}

/// Counts and displacements of lists of these lengths, one after the other.
fn layout(lengths: &[usize]) -> (Vec<i32>, Vec<i32>) {
    let counts: Vec<i32> = lengths.iter().map(|l| *l as i32).collect();
    let mut next = 0;
    let displacement = |c: &i32| {
        next += c;
        next - c
    };
    let displacements = counts.iter().map(displacement).collect();
    (counts, displacements)
}

/// A buffer with a place in memory, also if it is empty: MPI gives some addresses, which an empty list may have, a meaning of their own.
fn placed(mut buffer: Vec<u8>) -> Vec<u8> {
    buffer.reserve(1);
    buffer
}

/// Appends the lists that lie one after the other in `buffer` to those of `out`.
fn append(out: &mut Parts, buffer: &[u8], lengths: &[usize]) {
    let mut start = 0;
    for (out, length) in out.iter_mut().zip(lengths) {
        out.extend_from_slice(&buffer[start..start + length]);
        start += length;
    }
}

fn all_gather(world: &impl CommunicatorCollectives, own: &[u8]) -> Parts {
    let size = world.size() as usize;
    let mut lengths = vec![0u64; size];
    world.all_gather_into(&[own.len() as u64][..], &mut lengths[..]);
    let limit = (MAX_RECEIVED_BYTES / size).max(1);
    let mut out: Parts = lengths.iter().map(|l| Vec::with_capacity(*l as usize)).collect();
    let rounds = lengths.iter().map(|l| (*l as usize).div_ceil(limit)).max().unwrap_or(0);
    for round in 0..rounds {
        let received: Vec<usize> =
            lengths.iter().map(|l| length_of_round(*l as usize, round, limit)).collect();
        let (counts, displacements) = layout(&received);
        let mut buffer = placed(vec![0u8; received.iter().sum()]);
        let mut target = PartitionMut::new(&mut buffer[..], counts, displacements);
        let sent = part_of_round(own, round, limit);
        if sent.is_empty() {
            world.all_gather_varcount_into(&placed(Vec::new())[..], &mut target)
        } else {
            world.all_gather_varcount_into(sent, &mut target)
        }
        append(&mut out, &buffer, &received);
    }
    out
}

/// An exchange whose lengths are known, without copies.
fn exchange(world: &impl CommunicatorCollectives, mut buffers: ExchangeBuffers) -> ExchangeBuffers {
    // Pairs of numbers of eight bytes; no batch of planes comes near the limit of 32-bit counts.
    let in_numbers = |lengths: &[usize]| layout(&lengths.iter().map(|n| 2 * n).collect::<Vec<_>>());
    let (counts, displacements) = in_numbers(&buffers.sent_lengths);
    let (received_counts, received_displacements) = in_numbers(&buffers.received_lengths);
    buffers.sent.reserve(1);
    buffers.received.reserve(1);
    let source = Partition::new(complex_parts(&buffers.sent), counts, displacements);
    let mut target =
        PartitionMut::new(complex_parts_mut(&mut buffers.received), received_counts, received_displacements);
    world.all_to_all_varcount_into(&source, &mut target);
    buffers
}

fn all_to_all(world: &impl CommunicatorCollectives, parts: &[Vec<u8>]) -> Parts {
    let size = world.size() as usize;
    let lengths: Vec<u64> = parts.iter().map(|p| p.len() as u64).collect();
    let mut incoming = vec![0u64; size];
    world.all_to_all_into(&lengths[..], &mut incoming[..]);
    let limit = (MAX_RECEIVED_BYTES / size).max(1);
    // All ranks take part in as many rounds as the longest message of any rank needs.
    let longest = parts.iter().map(Vec::len).max().unwrap_or(0) as u64;
    let mut all_longest = vec![0u64; size];
    world.all_gather_into(&[longest][..], &mut all_longest[..]);
    let rounds = (all_longest.iter().max().copied().unwrap_or(0) as usize).div_ceil(limit);
    let mut out: Parts = incoming.iter().map(|l| Vec::with_capacity(*l as usize)).collect();
    for round in 0..rounds {
        let of_round: Vec<&[u8]> = parts.iter().map(|p| part_of_round(p, round, limit)).collect();
        let sent = placed(of_round.concat());
        let in_round = |lengths: &[u64]| -> Vec<usize> {
            lengths.iter().map(|l| length_of_round(*l as usize, round, limit)).collect()
        };
        let (counts, displacements) = layout(&in_round(&lengths));
        let source = Partition::new(&sent[..], counts, displacements);
        let received = in_round(&incoming);
        let (counts, displacements) = layout(&received);
        let mut buffer = placed(vec![0u8; received.iter().sum()]);
        let mut target = PartitionMut::new(&mut buffer[..], counts, displacements);
        world.all_to_all_varcount_into(&source, &mut target);
        append(&mut out, &buffer, &received);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_cover_a_message_once() {
        let bytes: Vec<u8> = (0..23).collect();
        for limit in [1, 5, 23, 100] {
            let rounds = bytes.len().div_ceil(limit);
            let parts: Vec<&[u8]> = (0..rounds + 1).map(|r| part_of_round(&bytes, r, limit)).collect();
            assert_eq!(parts.concat(), bytes);
            let lengths: Vec<usize> =
                (0..rounds + 1).map(|r| length_of_round(bytes.len(), r, limit)).collect();
            assert_eq!(lengths, parts.iter().map(|p| p.len()).collect::<Vec<_>>());
        }
    }

    #[test]
    fn empty_buffers_have_a_place() {
        // The address of an empty list without memory is its alignment, and some libraries give the address 1 a meaning.
        let buffer = placed(Vec::new());
        assert!(buffer.as_ptr().addr() > 16);
    }

    #[test]
    fn lists_lie_one_after_the_other() {
        assert_eq!(layout(&[3, 0, 2]), (vec![3, 0, 2], vec![0, 3, 3]));
        let mut out = vec![vec![9], Vec::new(), Vec::new()];
        append(&mut out, &[1, 2, 3, 4, 5], &[3, 0, 2]);
        assert_eq!(out, [vec![9, 1, 2, 3], vec![], vec![4, 5]]);
    }
}
