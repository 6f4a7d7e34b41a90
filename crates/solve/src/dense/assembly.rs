//! Assembly of the exchange areas of all pairs, in chunks of rows that are stages of a checkpoint.

use super::band_groups::first_bands;
use super::dense_operator::DenseOperator;
use super::image_sums::ImageSums;
use super::packed_symmetric::{PackedSymmetric, packed_length};
use crate::errors::radii::{PairRadii, radius_code};
use crate::stage_codec::{Decoder, Encoder};
use rayon::prelude::*;
use zonal_exchange::pair::PairCounts;
use zonal_math::Grade;
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
        let c = &self.counts;
        let mut encoder = Encoder::default();
        encoder.ints(&[
            c.aligned,
            c.by_volume_method,
            c.general,
            c.estimated,
            c.cut,
            c.pane,
            c.facing_away,
            c.partial,
            c.rays,
        ]);
        rows.iter().flatten().for_each(|row| encoder.reals(row));
        encoder.int(self.panes.len());
        self.panes.iter().for_each(|row| encoder.bands(row));
        encoder.raw(&self.radii);
        encoder.bytes()
    }

    /// Decodes a stage of [`RowChunk::encode`] for the rows from `first`, and writes its entries into `rows`.
    fn decode(bytes: &[u8], rows: &mut ChunkRows, first: usize) -> Option<RowChunk> {
        let mut decoder = Decoder::new(bytes);
        let [aligned, by_volume_method, general, estimated, cut, pane, facing_away, partial, rays] =
            decoder.ints()?[..]
        else {
            return None;
        };
        let counts = PairCounts {
            aligned,
            by_volume_method,
            general,
            estimated,
            cut,
            pane,
            facing_away,
            partial,
            rays,
        };
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

impl DenseOperator {
    /// Computes the exchange areas of all pairs of `n` zones, the last of them `panes`, with counts by method. Every chunk of rows is a stage `rows-…` of `checkpoints`.
    pub(crate) fn assemble(
        exchange: &ImageSums,
        [n, panes]: [usize; 2],
        (group, count): (PerBand<usize>, usize),
        checkpoints: &dyn CheckpointStore,
        progress: &dyn Progress,
    ) -> (DenseOperator, PairCounts) {
        let shared = n - panes;
        let first_bands = first_bands((group, count));
        // Collect for each row its slices of all matrices.
        let mut matrices: Vec<PackedSymmetric> = (0..count).map(|_| PackedSymmetric::zeros(shared)).collect();
        let mut slots: Vec<Vec<&mut [f64]>> = (0..n).map(|_| Vec::with_capacity(count)).collect();
        for m in &mut matrices {
            for (i, row) in m.rows_mut().into_iter().enumerate() {
                slots[i].push(row);
            }
        }
        // Compute the chunks in parallel.
        progress.begin("exchange areas", packed_length(n) as u64);
        let assembler = RowAssembler { exchange, shared, first_bands, checkpoints, progress };
        let chunks: Vec<RowChunk> = row_chunks(&mut slots, n)
            .into_par_iter()
            .with_max_len(1)
            .map(|(first, rows)| assembler.chunk(first, rows))
            .collect();
        progress.end();
        // Merge them in the order of the rows.
        let mut counts = PairCounts::default();
        let mut radii = Vec::with_capacity(packed_length(n));
        let mut panes: PerBand<Vec<Vec<f64>>> = PerBand::default();
        for c in chunks.into_iter().rev() {
            counts.merge(c.counts);
            radii.extend(&c.radii);
            for row in &c.panes {
                Band::all().for_each(|b| panes[b].push(row.iter().map(|x| x[b]).collect()));
            }
        }
        let grade = if counts.all_proved() { Grade::Proved } else { Grade::Estimated };
        let radii = PairRadii::new(n, radii);
        (DenseOperator { n, shared, matrices, group, panes, scaling: None, radii, grade }, counts)
    }
}

/// Divides the rows into chunks of about equal numbers of entries: (first row, rows). The longest rows come first, so that the last tasks are short.
fn row_chunks<'a, 'b>(slots: &'a mut ChunkRows<'b>, n: usize) -> Vec<(usize, &'a mut ChunkRows<'b>)> {
    let mut rest = slots;
    let mut out = Vec::new();
    let mut first = 0;
    for c in 1..=ROW_CHUNKS {
        let end =
            if c == ROW_CHUNKS { n } else { (n as f64 * (c as f64 / ROW_CHUNKS as f64).sqrt()) as usize };
        if end > first {
            let (head, tail) = std::mem::take(&mut rest).split_at_mut(end - first);
            out.push((first, head));
            rest = tail;
            first = end;
        }
    }
    out.reverse();
    out
}
