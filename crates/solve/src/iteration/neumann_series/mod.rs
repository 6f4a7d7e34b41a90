//! Partial sums of the Neumann series: light of a fixed number of scattering orders.
//!
//! s_k = s⁰ + w g s_{k−1}: N orders hold the light of at most N path segments between zones. After the N − 1 steps here, the incident field is
//! the N-th product. Cost: one product an order.

use super::linear_system::{IterationResult, LinearSystem, source_power};
use crate::distribution::multivector::MultiVector;
use crate::settings::stage_codec::{Decoder, Encoder};
use zonal_math::parallel;
use zonal_scene::{Band, Bands, CheckpointStore, NoCheckpoints, PerBand, Progress, SolveStatus};

/// Name of the stage.
const STAGE: &str = "state-sweeps";

/// Orders between two saved states.
const CHECKPOINT_INTERVAL: usize = 10;

/// `orders` − 1 steps of the Neumann series from the sources, fewer if the observer interrupts them. The state is saved in `checkpoints` as stage
/// `state-sweeps`.
pub(crate) fn solve(
    system: &LinearSystem,
    sources: &[Vec<Bands>],
    orders: usize,
    checkpoints: &dyn CheckpointStore,
    progress: &dyn Progress,
) -> Vec<IterationResult> {
    let all: Vec<IterationResult> = sources
        .iter()
        .map(|s| IterationResult {
            strengths: s.clone(),
            status: PerBand::splat(SolveStatus::FixedOrder),
            residuals: Default::default(),
            power: source_power(system.targets, s, system.sums),
        })
        .collect();
    progress.begin("sweeping", orders as u64);
    // Processes that have some planes alone begin again.
    let checkpoints = if system.sums.is_divided() { &NoCheckpoints } else { checkpoints };
    let kept = checkpoints.load(STAGE).and_then(|b| decode_state(&b, &all)).filter(|s| s.1 <= orders);
    let (mut all, first) = kept.unwrap_or((all, 1));
    progress.advance(first as u64 - 1);
    for order in first..=orders {
        if progress.is_interrupted() {
            break;
        }
        let now: MultiVector = all.iter().map(|e| e.strengths.clone()).collect();
        let products = system.operator.apply_many(&now);
        for ((e, g), s0) in all.iter_mut().zip(&products).zip(sources) {
            let next = |i: usize| s0[i] + system.weights[i] * g[i];
            // The residual is the power that the next order would add.
            let left = system.sums.sum(s0.len(), |i| {
                let n = next(i);
                system.targets[i] * (n - e.strengths[i]).abs()
            });
            for b in Band::all() {
                e.residuals[b].push(if e.power[b] > 0.0 { left[b] / e.power[b] } else { 0.0 });
            }
            if order < orders {
                e.strengths = parallel::collect(s0.len(), next);
            }
        }
        if checkpoints.keeps() && order < orders && order % CHECKPOINT_INTERVAL == 0 {
            checkpoints.save(STAGE, &encode_state(&all, order + 1));
        }
        progress.advance(1);
    }
    progress.end();
    all
}

fn encode_state(all: &[IterationResult], next: usize) -> Vec<u8> {
    let mut encoder = Encoder::default();
    encoder.int(next);
    for e in all {
        encoder.bands(&e.strengths);
        e.residuals.iter().for_each(|r| encoder.reals(r));
    }
    encoder.bytes()
}

/// Decodes a stage of [`encode_state`] with the status and power of `initial`: the results, and the next order.
fn decode_state(bytes: &[u8], initial: &[IterationResult]) -> Option<(Vec<IterationResult>, usize)> {
    let mut decoder = Decoder::new(bytes);
    let next = decoder.int()?;
    let mut all = Vec::new();
    for f in initial {
        let strengths = decoder.bands().filter(|s| s.len() == f.strengths.len())?;
        let mut residuals = PerBand::default();
        for b in Band::all() {
            residuals[b] = decoder.reals()?;
        }
        all.push(IterationResult { strengths, residuals, status: f.status, power: f.power });
    }
    (decoder.at_end() && next > 0).then_some((all, next))
}

#[cfg(test)]
mod tests;
