//! Finished samples in a folder beside the output, so that an interrupted run continues.
//!
//! Samples are stored in blocks; a block that is absent or damaged is computed again. The key of the folder holds the scene of the first sample, the
//! varied numbers and the seed, but not the number of samples: a sample depends on its number only.

use super::sample::{Sample, SampleStatus};
use zonal_io::output::{CheckpointFolder, CheckpointState, FileError};
use zonal_scene::CheckpointStore;

/// A folder with blocks of samples.
pub(super) struct SampleStore(CheckpointFolder);

impl SampleStore {
    /// Begins in a folder, with the samples in it if they belong to the same data set, otherwise empty; true if the samples of another one were
    /// removed.
    ///
    /// # Errors
    /// If the folder cannot be written.
    pub(super) fn begin(folder: CheckpointFolder) -> Result<(SampleStore, bool), FileError> {
        folder.claim()?;
        let is_other = folder.state() == CheckpointState::Mismatched;
        if is_other {
            folder.clear();
        }
        folder.begin()?;
        Ok((SampleStore(folder), is_other))
    }

    fn stage(block: usize) -> String {
        format!("samples-{block:06}")
    }

    /// The samples of a block, if it has exactly `count`, each with no or with `length` numbers.
    pub(super) fn load(&self, block: usize, count: usize, length: usize) -> Option<Vec<Sample>> {
        let bytes = self.0.load(&Self::stage(block))?;
        let mut numbers = bytes.chunks_exact(8).map(|b| b.try_into().map(f64::from_le_bytes));
        let mut next = || numbers.next()?.ok();
        let mut samples = Vec::with_capacity(count);
        for _ in 0..count {
            let (status, energy_residual) = (SampleStatus::of(next()?), next()?);
            let own = if status == SampleStatus::Refused { 0 } else { length };
            let numbers = (0..own).map(|_| next()).collect::<Option<Vec<f64>>>()?;
            samples.push(Sample { status, energy_residual, numbers });
        }
        next().is_none().then_some(samples)
    }

    /// Stores the samples of a block.
    pub(super) fn save(&self, block: usize, samples: &[Sample]) {
        let numbers = samples.iter().flat_map(|s| {
            [f64::from(s.status as u8), s.energy_residual].into_iter().chain(s.numbers.iter().copied())
        });
        self.0.save(&Self::stage(block), &numbers.flat_map(f64::to_le_bytes).collect::<Vec<u8>>());
    }

    /// The error of the first block that could not be written, if any.
    pub(super) fn failure(&self) -> Option<FileError> {
        self.0.failure()
    }

    /// Removes the folder.
    pub(super) fn remove(self) {
        self.0.remove();
    }
}
