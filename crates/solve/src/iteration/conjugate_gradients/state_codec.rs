//! The state of conjugate gradients as a stage of a checkpoint.

use super::band_entry::BandEntry;
use super::column::{CgColumn, ColumnVectors};
use crate::iteration::divided_state::PartialState;
use crate::settings::stage_codec::{Decoder, Encoder};
use zonal_scene::SolveStatus;

/// Encodes the state as a stage, the number of bands first.
pub(super) fn encode_state<E: BandEntry<N>, const N: usize>(all: &[CgColumn<E, N>], next: usize) -> Vec<u8> {
    let mut encoder = Encoder::default();
    encoder.int(N);
    encoder.int(next);
    for c in all {
        for v in c.vectors.all() {
            encoder.reals(&v.iter().flat_map(|x| x.lanes()).collect::<Vec<f64>>());
        }
        encoder.reals(&c.rz);
        encoder.reals(&c.power);
        for b in 0..N {
            encoder.int(
                c.status[b]
                    .map_or(0, |s| 1 + SolveStatus::VARIANTS.iter().position(|x| *x == s).unwrap_or(0)),
            );
            encoder.reals(&c.residuals[b]);
            encoder.reals(&[c.best[b].0]);
            encoder.int(c.best[b].1);
        }
    }
    encoder.bytes()
}

/// The numbers of a column beside its vectors.
pub(super) type ColumnNumbers<const N: usize> =
    ([[f64; N]; 2], [Option<SolveStatus>; N], [Vec<f64>; N], [(f64, usize); N]);

/// Decodes a stage of [`encode_state`] for a number of columns and unknowns: P, r and p of each column in turn.
pub(super) fn decode_state<E: BandEntry<N>, const N: usize>(
    bytes: &[u8],
    columns: usize,
    unknowns: usize,
) -> Option<PartialState<E, Vec<ColumnNumbers<N>>>> {
    let mut decoder = Decoder::new(bytes);
    let (bands, next) = (decoder.int()?, decoder.int()?);
    if bands != N || next == 0 {
        return None;
    }
    let mut state = PartialState { vectors: Vec::new(), shared: Vec::new(), next };
    for _ in 0..columns {
        for _ in 0..3 {
            let flat = decoder.reals().filter(|flat| flat.len() == N * unknowns)?;
            state.vectors.push(flat.as_chunks::<N>().0.iter().map(|x| E::from_lanes(*x)).collect());
        }
        let sums = [decoder.reals()?.try_into().ok()?, decoder.reals()?.try_into().ok()?];
        let (mut status, mut residuals, mut best) = ([None; N], [const { Vec::new() }; N], [(0.0, 0); N]);
        for b in 0..N {
            let known = decoder.int()?;
            status[b] = if known == 0 { None } else { Some(*SolveStatus::VARIANTS.get(known - 1)?) };
            residuals[b] = decoder.reals()?;
            best[b] = (*decoder.reals()?.first()?, decoder.int()?);
        }
        state.shared.push((sums, status, residuals, best));
    }
    decoder.at_end().then_some(state)
}

/// The columns of a state, and the next iteration.
pub(super) fn columns_of<E: BandEntry<N>, const N: usize>(
    state: PartialState<E, Vec<ColumnNumbers<N>>>,
) -> (Vec<CgColumn<E, N>>, usize) {
    let column = |(([rz, power], status, residuals, best), of_column): (ColumnNumbers<N>, &[Vec<E>])| {
        let mut vectors = ColumnVectors(vec![[E::ZERO; 3]; of_column[0].len()]);
        vectors.all_mut().into_iter().zip(of_column).for_each(|(v, known)| v.copy_from_slice(known));
        CgColumn { vectors, rz, power, status, residuals, best }
    };
    (state.shared.into_iter().zip(state.vectors.chunks(3)).map(column).collect(), state.next)
}
