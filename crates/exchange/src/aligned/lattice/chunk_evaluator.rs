//! Evaluation of the chunks of a table: by the threads of this process, or shared by several processes.

use zonal_math::parallel;

/// Computes the chunks of a table. A chunk does not depend on who computes it, so that the bits of a table do not either.
pub trait ChunkEvaluator: Sync {
    /// True if this process computes all chunks.
    fn is_alone(&self) -> bool;
    /// The numbers that `chunk` gives for each of `0..chunks`, in this order.
    fn evaluate(&self, chunks: usize, chunk: &(dyn Fn(usize) -> Vec<f64> + Sync)) -> Vec<Vec<f64>>;
}

/// The threads of this process.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct OneProcess;

impl ChunkEvaluator for OneProcess {
    fn is_alone(&self) -> bool {
        true
    }
    fn evaluate(&self, chunks: usize, chunk: &(dyn Fn(usize) -> Vec<f64> + Sync)) -> Vec<Vec<f64>> {
        parallel::collect_tasks(chunks, chunk)
    }
}
