//! Sample means and their standard errors.

use zonal_scene::{Bands, PerBand};

/// A mean over random samples and its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SampleEstimate {
    /// Mean.
    pub value: f64,
    /// Standard error of the mean.
    pub error: f64,
}

impl SampleEstimate {
    /// The distance of `x` from the mean in standard errors, after subtracting an absolute `slack`.
    pub fn z(&self, x: f64, slack: f64) -> f64 {
        let d = ((x - self.value).abs() - slack).max(0.0);
        if d == 0.0 { 0.0 } else { d / self.error.max(1e-300) }
    }
}

/// Running sums of samples, from which a [`SampleEstimate`] is made.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SampleStatistics {
    count: f64,
    sum: f64,
    squares: f64,
}

impl SampleStatistics {
    /// Adds a sample.
    pub(crate) fn add(&mut self, x: f64) {
        self.count += 1.0;
        self.sum += x;
        self.squares += x * x;
    }
    /// The mean of the samples and its standard error, times `scale`.
    pub(crate) fn estimate(&self, scale: f64) -> SampleEstimate {
        let mean = self.sum / self.count;
        let variance = (self.squares / self.count - mean * mean).max(0.0) / (self.count - 1.0).max(1.0);
        SampleEstimate { value: mean * scale, error: variance.sqrt() * scale.abs() }
    }
}

/// Adds one sample to the sums of each band.
pub(crate) fn add_sample(statistics: &mut PerBand<SampleStatistics>, x: Bands) {
    statistics.iter_mut().zip(x).for_each(|(s, x)| s.add(x));
}
