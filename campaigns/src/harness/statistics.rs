//! A field against a reference with noise of its own, z-scores, and interpolation between measured points.

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
    fn medians() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(median(Vec::new()), None);
        let values = [value(1.0, 0.0, 0.0, 0.5), value(1.0, 0.0, 0.0, 0.4), value(1.0, 0.0, 0.3, 0.4)];
        assert_eq!(median_ratio(&values), Some(0.4));
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
