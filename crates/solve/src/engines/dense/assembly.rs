//! Assembly of the exchange areas of all pairs, in chunks of rows that are stages of a checkpoint.

use super::band_groups::BandGroups;
use super::dense_operator::DenseOperator;
use super::image_sums::ImageSums;
use super::packed_symmetric::PackedSymmetric;
use super::row_blocks::{RowBlocks, packed_length};
use crate::distribution::{Communicator, Execution, Message};
use crate::engines::dense::pair_radii::{PairRadii, radius_code};
use crate::settings::stage_codec::{Decoder, Encoder};
use rayon::prelude::*;
use std::ops::Range;
use zonal_exchange::pair::PairCounts;
use zonal_math::Grade;
use zonal_math::parallel;
use zonal_scene::{Band, Bands, CheckpointStore, PerBand, Progress};

/// Number of chunks of rows; fixed, so that sums do not depend on the number of threads.
const ROW_CHUNKS: usize = 256;

/// The rows of a chunk: for each row its entries in the matrix of every group of bands.
type ChunkRows<'a> = [Vec<&'a mut [f64]>];

/// Results of a chunk of rows beside its matrix entries.
#[derive(Default)]
struct RowChunk {
    counts: PairCounts,
    panes: Vec<Vec<Bands>>,
    /// Codes of the error radii, row by row.
    radii: Vec<u8>,
}

impl RowChunk {
    /// Encodes the chunk and its entries as a stage.
    fn encode(&self, rows: &ChunkRows) -> Vec<u8> {
        let mut encoder = Encoder::default();
        encoder.ints(&self.counts.numbers());
        rows.iter().flatten().for_each(|row| encoder.reals(row));
        encoder.int(self.panes.len());
        self.panes.iter().for_each(|row| encoder.bands(row));
        encoder.raw(&self.radii);
        encoder.bytes()
    }

    /// Decodes a stage of [`RowChunk::encode`] for the rows from `first`, and writes its entries into `rows`.
    fn decode(bytes: &[u8], rows: &mut ChunkRows, first: usize) -> Option<RowChunk> {
        let mut decoder = Decoder::new(bytes);
        let counts = decode_counts(&mut decoder)?;
        for row in rows.iter_mut().flatten() {
            let kept = decoder.reals().filter(|k| k.len() == row.len())?;
            row.copy_from_slice(&kept);
        }
        let panes: Option<Vec<Vec<Bands>>> = (0..decoder.int()?).map(|_| decoder.bands()).collect();
        let panes = panes?;
        // The rows of panes are the last ones; each is as long as its row number requires.
        let offset = first + rows.len() - panes.len().min(rows.len());
        let fit =
            panes.len() <= rows.len() && panes.iter().enumerate().all(|(k, p)| p.len() == offset + k + 1);
        let radii = decoder.raw()?.to_vec();
        let pairs = packed_length(first + rows.len()) - packed_length(first);
        (decoder.at_end() && fit && radii.len() == pairs).then_some(RowChunk { counts, panes, radii })
    }
}

fn decode_counts(decoder: &mut Decoder) -> Option<PairCounts> {
    decoder.ints()?.try_into().ok().map(PairCounts::from_numbers)
}

/// Computes chunks of rows.
struct RowAssembler<'a> {
    exchange: &'a ImageSums<'a>,
    /// Number of zones before the panes.
    shared: usize,
    /// The first band of each group.
    first_bands: Vec<Band>,
    checkpoints: &'a dyn CheckpointStore,
    progress: &'a dyn Progress,
}

impl RowAssembler<'_> {
    /// The chunk of rows from `first`: loaded from its stage, or computed and saved.
    fn chunk(&self, first: usize, rows: &mut ChunkRows) -> RowChunk {
        let stage = format!("rows-{first}");
        let pane_rows = (first + rows.len()).saturating_sub(self.shared).min(rows.len());
        let kept = self.checkpoints.load(&stage).and_then(|b| RowChunk::decode(&b, rows, first));
        if let Some(chunk) = kept.filter(|c| c.panes.len() == pane_rows) {
            (first..first + rows.len()).for_each(|i| self.progress.advance(i as u64 + 1));
            return chunk;
        }
        let chunk = self.compute(first, rows);
        if self.checkpoints.keeps() {
            self.checkpoints.save(&stage, &chunk.encode(rows));
        }
        chunk
    }

    fn compute(&self, first: usize, rows: &mut ChunkRows) -> RowChunk {
        let mut chunk = RowChunk::default();
        for (k, row) in rows.iter_mut().enumerate() {
            let i = first + k;
            let mut pane = Vec::new();
            let pairs = self.exchange.row(i);
            for j in 0..=i {
                let f = self.exchange.pair_in_row(&pairs, j, &mut chunk.counts);
                if i < self.shared {
                    for (r, &b) in row.iter_mut().zip(&self.first_bands) {
                        r[j] = f.value[b];
                    }
                } else {
                    pane.push(f.value);
                }
                chunk.radii.push(radius_code(f.radius.into_iter().fold(0.0, f64::max)));
            }
            if i >= self.shared {
                chunk.panes.push(pane);
            }
            self.progress.advance(i as u64 + 1);
        }
        chunk
    }
}

/// A chunk of rows that a rank computes for all: its first row, the entries of each row in every matrix, and the rest.
struct ComputedChunk {
    first: usize,
    entries: Vec<Vec<Vec<f64>>>,
    chunk: RowChunk,
}

/// The rows that a rank stores: its blocks of the matrices and of the error radii, and the rows of all panes.
struct SharedRows {
    matrices: Vec<PackedSymmetric>,
    /// The blocks of the rows before the panes.
    blocks: RowBlocks,
    /// Codes of the error radii of these rows.
    radii: Vec<u8>,
    /// Rows of all panes, and the codes of their radii.
    panes: Vec<Vec<Bands>>,
    pane_radii: Vec<Vec<u8>>,
    counts: PairCounts,
}

impl<'a> DenseOperator<'a> {
    /// Computes the exchange areas of all pairs of `n` zones, the last of them `panes`, with counts by method. Every chunk of rows is a stage `rows-…` of `checkpoints`.
    pub(crate) fn assemble(
        exchange: &ImageSums,
        [n, panes]: [usize; 2],
        BandGroups { group, firsts }: BandGroups,
        checkpoints: &dyn CheckpointStore,
        execution: Execution<'a>,
    ) -> (DenseOperator<'a>, PairCounts) {
        let (shared, communicator, progress) = (n - panes, execution.communicator, execution.progress);
        let count = firsts.len();
        progress.begin("exchange areas", packed_length(n) as u64);
        let assembler = RowAssembler { exchange, shared, first_bands: firsts, checkpoints, progress };
        let rows = match communicator.size() {
            1 => assembler.all_rows(n, count),
            _ => assembler.shared_rows(n, count, communicator),
        };
        progress.end();
        let mut panes: PerBand<Vec<Vec<f64>>> = PerBand::default();
        for row in &rows.panes {
            Band::all().for_each(|b| panes[b].push(row.iter().map(|x| x[b]).collect()));
        }
        let grade = if rows.counts.all_proved() { Grade::Proved } else { Grade::Estimated };
        let radii = PairRadii::new(rows.blocks, rows.radii, rows.pane_radii);
        let operator = DenseOperator {
            communicator,
            n,
            shared,
            matrices: rows.matrices,
            group,
            panes,
            scaling: None,
            radii,
            weights: None,
            grade,
        };
        (operator, rows.counts)
    }
}

impl RowAssembler<'_> {
    /// All rows by this process alone.
    fn all_rows(&self, n: usize, count: usize) -> SharedRows {
        // Collect for each row its slices of all matrices.
        let mut matrices: Vec<PackedSymmetric> =
            (0..count).map(|_| PackedSymmetric::zeros(self.shared)).collect();
        let mut slots: Vec<Vec<&mut [f64]>> = (0..n).map(|_| Vec::with_capacity(count)).collect();
        for m in &mut matrices {
            for (i, row) in m.rows_mut().into_iter().enumerate() {
                slots[i].push(row);
            }
        }
        // Compute the chunks in parallel, the longest rows first, so that the last tasks are short.
        let mut rest = slots.as_mut_slice();
        let take = |rows: Range<usize>| {
            let (head, tail) = std::mem::take(&mut rest).split_at_mut(rows.len());
            rest = tail;
            (rows.start, head)
        };
        let mut chunks: Vec<(usize, &mut ChunkRows)> = row_chunks(n).map(take).collect();
        chunks.reverse();
        let chunks: Vec<RowChunk> =
            chunks.into_par_iter().with_max_len(1).map(|(first, rows)| self.chunk(first, rows)).collect();
        // Merge them in the order of the rows.
        let mut rows = SharedRows {
            matrices,
            blocks: RowBlocks::all(self.shared),
            radii: Vec::with_capacity(packed_length(n)),
            panes: Vec::new(),
            pane_radii: Vec::new(),
            counts: PairCounts::default(),
        };
        for c in chunks.into_iter().rev() {
            rows.counts.merge(c.counts);
            rows.radii.extend(&c.radii);
            rows.panes.extend(c.panes);
        }
        let codes = rows.radii.split_off(packed_length(self.shared));
        let mut rest = codes.as_slice();
        for i in self.shared..n {
            let (row, tail) = rest.split_at(i + 1);
            rows.pane_radii.push(row.to_vec());
            rest = tail;
        }
        rows
    }

    /// The rows of this rank: each rank computes chunks over the whole triangle, and sends rows to the ranks that keep them.
    fn shared_rows(&self, n: usize, count: usize, communicator: &dyn Communicator) -> SharedRows {
        let mut own: Vec<Range<usize>> =
            row_chunks(n).skip(communicator.rank()).step_by(communicator.size()).collect();
        own.reverse();
        let computed: Vec<ComputedChunk> =
            parallel::collect_tasks(own.len(), |k| self.computed_chunk(own[k].clone(), count));
        let blocks = RowBlocks::of_rank(self.shared, communicator);
        let mut messages = RowMessages::new(communicator.size(), &blocks);
        computed.into_iter().for_each(|chunk| messages.add(chunk, self.shared));
        let mut matrices: Vec<PackedSymmetric> =
            (0..count).map(|_| PackedSymmetric::zeros_of(blocks.clone())).collect();
        fill_matrices(&mut matrices, &blocks, &communicator.all_to_all(messages.entries));
        let radii = joined_radii(&blocks, &communicator.all_to_all(messages.codes));
        let (panes, pane_radii) = joined_panes(self.shared, n, &communicator.all_gather(messages.panes));
        let mut encoder = Encoder::default();
        encoder.ints(&messages.counts.numbers());
        let mut counts = PairCounts::default();
        let all = communicator.all_gather(encoder.bytes());
        all.iter().filter_map(|bytes| decode_counts(&mut Decoder::new(bytes))).for_each(|c| counts.merge(c));
        SharedRows { matrices, blocks, radii, panes, pane_radii, counts }
    }

    /// A chunk of rows in memory of its own.
    fn computed_chunk(&self, rows: Range<usize>, count: usize) -> ComputedChunk {
        let of_row = |i: usize| if i < self.shared { vec![vec![0.0; i + 1]; count] } else { Vec::new() };
        let mut entries: Vec<Vec<Vec<f64>>> = rows.clone().map(of_row).collect();
        let mut slots: Vec<Vec<&mut [f64]>> =
            entries.iter_mut().map(|row| row.iter_mut().map(Vec::as_mut_slice).collect()).collect();
        let chunk = self.chunk(rows.start, &mut slots);
        ComputedChunk { first: rows.start, entries, chunk }
    }
}

/// Messages of a rank with the rows that it computed: entries and radii to the ranks that keep them, panes and counts to all. Each row follows its number.
struct RowMessages {
    rank_of_row: Vec<usize>,
    entries: Vec<Vec<u8>>,
    codes: Vec<Vec<u8>>,
    panes: Vec<u8>,
    counts: PairCounts,
}

impl RowMessages {
    fn new(size: usize, blocks: &RowBlocks) -> RowMessages {
        RowMessages {
            rank_of_row: blocks.ranks_of_rows(size),
            entries: vec![Vec::new(); size],
            codes: vec![Vec::new(); size],
            panes: Vec::new(),
            counts: PairCounts::default(),
        }
    }

    /// Adds a chunk; rows from `shared` on are those of panes.
    fn add(&mut self, ComputedChunk { first, entries, chunk }: ComputedChunk, shared: usize) {
        self.counts.merge(chunk.counts);
        let mut radii = chunk.radii.as_slice();
        let mut panes = chunk.panes.iter();
        for (k, row) in entries.iter().enumerate() {
            let i = first + k;
            let (own_radii, rest) = radii.split_at(i + 1);
            radii = rest;
            if i >= shared {
                (i as u64).put(&mut self.panes);
                panes.next().into_iter().flatten().for_each(|x| x.put(&mut self.panes));
                self.panes.extend(own_radii);
                continue;
            }
            let rank = self.rank_of_row[i];
            (i as u64).put(&mut self.codes[rank]);
            self.codes[rank].extend(own_radii);
            (i as u64).put(&mut self.entries[rank]);
            row.iter().flatten().for_each(|x| x.put(&mut self.entries[rank]));
        }
    }
}

/// Writes received rows into the matrices of a rank.
fn fill_matrices(matrices: &mut [PackedSymmetric], blocks: &RowBlocks, received: &[Vec<u8>]) {
    let (first, count) = (blocks.own_rows().start, matrices.len());
    let mut slots: Vec<Vec<&mut [f64]>> = matrices.iter_mut().map(PackedSymmetric::rows_mut).collect();
    for bytes in received {
        let mut rest = bytes.as_slice();
        while let Some((head, tail)) = rest.split_at_checked(8) {
            let i = u64::get(head) as usize;
            let (row, tail) = tail.split_at(8 * count * (i + 1));
            for (slot, numbers) in slots.iter_mut().zip(row.chunks_exact(8 * (i + 1))) {
                let values = numbers.chunks_exact(8).map(f64::get);
                slot[i - first].iter_mut().zip(values).for_each(|(x, v)| *x = v);
            }
            rest = tail;
        }
    }
}

/// The codes of the radii of the own rows, row by row, from received rows.
fn joined_radii(blocks: &RowBlocks, received: &[Vec<u8>]) -> Vec<u8> {
    let before = packed_length(blocks.own_rows().start);
    let mut radii = vec![0; blocks.entries(blocks.own_rows())];
    for bytes in received {
        let mut rest = bytes.as_slice();
        while let Some((head, tail)) = rest.split_at_checked(8) {
            let i = u64::get(head) as usize;
            let (row, tail) = tail.split_at(i + 1);
            let start = packed_length(i) - before;
            radii[start..start + i + 1].copy_from_slice(row);
            rest = tail;
        }
    }
    radii
}

/// The rows of all panes and the codes of their radii, in their order.
fn joined_panes(shared: usize, n: usize, received: &[Vec<u8>]) -> (Vec<Vec<Bands>>, Vec<Vec<u8>>) {
    let (mut panes, mut radii) = (vec![Vec::new(); n - shared], vec![Vec::new(); n - shared]);
    for bytes in received {
        let mut rest = bytes.as_slice();
        while let Some((head, tail)) = rest.split_at_checked(8) {
            let i = u64::get(head) as usize;
            let (row, tail) = tail.split_at((i + 1) * Bands::size());
            panes[i - shared] = row.chunks_exact(Bands::size()).map(Bands::get).collect();
            let (codes, tail) = tail.split_at(i + 1);
            radii[i - shared] = codes.to_vec();
            rest = tail;
        }
    }
    (panes, radii)
}

/// The chunks of `n` rows, of about equal numbers of entries.
fn row_chunks(n: usize) -> impl Iterator<Item = Range<usize>> {
    let edge = move |c: usize| match c {
        ROW_CHUNKS => n,
        _ => (n as f64 * (c as f64 / ROW_CHUNKS as f64).sqrt()) as usize,
    };
    (0..ROW_CHUNKS).map(move |c| edge(c)..edge(c + 1)).filter(|rows| !rows.is_empty())
}
