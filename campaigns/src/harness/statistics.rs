//! Errors of a field against a reference that has noise of its own, z-scores, and interpolation between measured points.
//!
//! With x the field, t the reference and e its standard error, E(x − t)² = (x − t_exact)² + e². The noise is subtracted:
//!
//! ```text
//! L2 = √(Σ (d² − e²)/Σ t²), d = x − t        noise = √(Σ e²/Σ t²)
//! ```
//!
//! The sum over all zones may be negative by chance where the error is far below the noise; it then counts as 0.

use zonal_reference::SampleEstimate;

/// A value of a field, its reference with a standard error, and the error that the solver states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ComparedValue {
    /// The field.
    pub value: f64,
    /// The reference.
    pub reference: f64,
    /// Standard error of the reference.
    pub noise: f64,
    /// The stated error.
    pub stated: f64,
}

impl ComparedValue {
    /// |value − reference|.
    pub(crate) fn difference(&self) -> f64 {
        (self.value - self.reference).abs()
    }
}

/// A stated error covers the true one up to this factor.
const COVERED_FACTOR: f64 = 2.0;
/// Largest share of noise in a measured error that is not marked.
const MAX_NOISE_SHARE: f64 = 1.0 / 3.0;

/// An error with the noise of its reference, both relative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MeasuredError {
    /// The error, with the noise subtracted.
    pub error: f64,
    /// The noise of the reference.
    pub noise: f64,
}

impl MeasuredError {
    /// True where the noise is more than a third of the error.
    pub(crate) fn is_noisy(&self) -> bool {
        self.noise > MAX_NOISE_SHARE * self.error
    }

    /// The larger one by error.
    pub(crate) fn max(self, other: MeasuredError) -> MeasuredError {
        if other.error > self.error || (other.error == self.error && other.noise > self.noise) {
            other
        } else {
            self
        }
    }
}

/// Relative L2 error: root of the sum of squares over that of the reference; 0 for no values.
pub(crate) fn l2(values: &[ComparedValue]) -> MeasuredError {
    let sum = |f: fn(&ComparedValue) -> f64| values.iter().map(f).sum::<f64>();
    let whole = sum(|v| v.reference * v.reference);
    if whole <= 0.0 {
        return MeasuredError::default();
    }
    let (apart, noise) = (sum(|v| v.difference().powi(2)), sum(|v| v.noise * v.noise));
    MeasuredError { error: ((apart - noise).max(0.0) / whole).sqrt(), noise: (noise / whole).sqrt() }
}

/// The median; `None` for no values.
pub(crate) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    match n {
        0 => None,
        _ if n % 2 == 1 => Some(values[n / 2]),
        _ => Some(0.5 * (values[n / 2 - 1] + values[n / 2])),
    }
}

/// The median of stated over true error among the values that differ.
pub(crate) fn median_ratio(values: &[ComparedValue]) -> Option<f64> {
    median(values.iter().filter(|v| v.difference() > 0.0).map(|v| v.stated / v.difference()).collect())
}

/// The share of values that differ from the reference by at most twice their stated error and the noise, in quadrature; `None` for no values.
pub(crate) fn covered(values: &[ComparedValue]) -> Option<f64> {
    let inside = |v: &&ComparedValue| v.difference() <= COVERED_FACTOR * v.stated.hypot(v.noise);
    (!values.is_empty()).then(|| values.iter().filter(inside).count() as f64 / values.len() as f64)
}

/// Differences in standard errors: their mean, root mean square and largest.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ZScores {
    /// How many.
    pub n: usize,
    /// Mean.
    pub mean: f64,
    /// Root mean square.
    pub rms: f64,
    /// Largest modulus.
    pub max: f64,
    /// Sum of ours over sum of theirs, less 1.
    pub bias: f64,
}

impl ZScores {
    /// Compares pairs of means; those without any error on their side are passed over.
    pub(crate) fn new(pairs: impl Iterator<Item = (SampleEstimate, SampleEstimate)>) -> ZScores {
        let (mut s, mut sums) = (ZScores::default(), [0.0; 2]);
        for (ours, theirs) in pairs.filter(|p| p.1.error > 0.0) {
            let z = (ours.value - theirs.value) / ours.error.hypot(theirs.error);
            s.n += 1;
            s.mean += z;
            s.rms += z * z;
            s.max = s.max.max(z.abs());
            sums = [sums[0] + ours.value, sums[1] + theirs.value];
        }
        let n = s.n.max(1) as f64;
        (s.mean, s.rms, s.bias) = (s.mean / n, (s.rms / n).sqrt(), sums[0] / sums[1] - 1.0);
        s
    }
}

/// Blocks of `size` × `size` pixels of a picture `width` across in one band, each with the standard error of its mean.
pub(crate) fn blocks(mean: &[f64], error: &[f64], width: usize, size: usize) -> Vec<SampleEstimate> {
    let (across, down) = (width / size, mean.len() / width / size);
    let block = |k: usize| {
        let first = (k / across * width + k % across) * size;
        let pixels = (0..size * size).map(|p| first + p / size * width + p % size);
        let n = (size * size) as f64;
        let (sum, squares) = pixels.fold((0.0, 0.0), |s, p| (s.0 + mean[p], s.1 + error[p] * error[p]));
        SampleEstimate { value: sum / n, error: squares.sqrt() / n }
    };
    (0..across * down).map(block).collect()
}

/// A measured point: cost and error.
pub(crate) type CostPoint = [f64; 2];

/// The cost at which a series reaches an error, interpolated between logarithms; `None` outside the errors that the series has. Points
/// that another one beats in both cost and error are left out.
pub(crate) fn cost_at(series: &[CostPoint], error: f64) -> Option<f64> {
    let front = front(series);
    let pair = front.windows(2).find(|w| w[1][1] <= error && error <= w[0][1])?;
    let [[c0, e0], [c1, e1]] = [pair[0], pair[1]];
    let part = if e0 > e1 { (e0 / error).ln() / (e0 / e1).ln() } else { 0.0 };
    Some((c0.ln() + part * (c1 / c0).ln()).exp())
}

/// The points that no other point beats in cost and error, by ascending cost and falling error.
pub(crate) fn front(series: &[CostPoint]) -> Vec<CostPoint> {
    let mut sorted: Vec<CostPoint> = series.iter().copied().filter(|p| p[0] > 0.0 && p[1] > 0.0).collect();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut out: Vec<CostPoint> = Vec::new();
    for p in sorted {
        if out.last().is_none_or(|last| p[1] < last[1]) {
            out.push(p);
        }
    }
    out
}

/// The cost ratio of a halved tolerance between two tolerances and their costs: (c/C)^(ln 2/ln(T/t)).
pub(crate) fn ratio_of_halving(coarse: [f64; 2], fine: [f64; 2]) -> f64 {
    (fine[1] / coarse[1]).powf(std::f64::consts::LN_2 / (coarse[0] / fine[0]).ln())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(value: f64, reference: f64, noise: f64, stated: f64) -> ComparedValue {
        ComparedValue { value, reference, noise, stated }
    }

    #[test]
    fn noise_is_subtracted_from_the_error() {
        // Differences of 5 with a noise of 3 leave 4.
        let values = [value(105.0, 100.0, 3.0, 1.0), value(95.0, 100.0, 3.0, 1.0)];
        let e = l2(&values);
        assert!((e.error - 0.04).abs() < 1e-12 && (e.noise - 0.03).abs() < 1e-12);
        assert!(e.is_noisy());
        assert_eq!(l2(&[value(100.0, 100.0, 1.0, 0.0)]).error, 0.0);
        assert!(!MeasuredError { error: 0.04, noise: 0.01 }.is_noisy());
    }

    #[test]
    fn medians_and_coverage() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(median(Vec::new()), None);
        let values = [value(1.0, 0.0, 0.0, 0.5), value(1.0, 0.0, 0.0, 0.4), value(1.0, 0.0, 0.3, 0.4)];
        assert_eq!(covered(&values), Some(2.0 / 3.0));
        assert_eq!(median_ratio(&values), Some(0.4));
        assert_eq!(covered(&[]), None);
    }

    #[test]
    fn costs_are_interpolated_between_logarithms() {
        let series = [[1.0, 0.1], [100.0, 0.001], [50.0, 0.2]];
        assert!((cost_at(&series, 0.01).unwrap() - 10.0).abs() < 1e-9);
        assert!((cost_at(&series, 0.1).unwrap() - 1.0).abs() < 1e-9);
        assert_eq!(cost_at(&series, 0.2), None);
        assert_eq!(cost_at(&series, 0.0005), None);
        assert_eq!(front(&series), vec![[1.0, 0.1], [100.0, 0.001]]);
    }

    #[test]
    fn halving_is_independent_of_the_step() {
        assert!((ratio_of_halving([0.2, 1.0], [0.1, 3.0]) - 3.0).abs() < 1e-12);
        assert!((ratio_of_halving([0.2, 1.0], [0.05, 9.0]) - 3.0).abs() < 1e-12);
    }
}
