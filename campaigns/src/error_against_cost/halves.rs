//! Values against two independent halves of a reference.
//!
//! With v the value, a and b the two halves, d the error and weights w, E(v − a)(v − b) = d²: the noise of the halves drops out, without an estimate of it.
//!
//! ```text
//! L2² = R = Σ w (v − a)(v − b) / Σ w a b        variance of R = n/(n − 1) Σ w² [(v − a)(v − b) − R a b]² / (Σ w a b)²
//! ```
//!
//! over n zones at random. The sum may be negative by chance where the error is far below the noise; L2 then counts as 0. The upper bound is
//! √(R + two standard errors).

use crate::harness::statistics::median;

/// Standard errors above the estimate at which the upper bound lies.
const BOUND_STANDARD_ERRORS: f64 = 2.0;
/// A stated error is compared with a true one up to this many standard errors of the reference.
const NOISE_STANDARD_ERRORS: f64 = 2.0;
/// Median of the square of a normal number of variance 1.
const MEDIAN_OF_NORMAL_SQUARE: f64 = 0.454_936;
/// Largest upper bound over the error of a point without a star.
const MAX_BOUND_RATIO: f64 = 1.5;

/// A value, its reference in two independent halves, and the error that the solver states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct HalvedValue {
    /// The value.
    pub value: f64,
    /// The halves of the reference.
    pub halves: [f64; 2],
    /// Standard error of the mean of the halves.
    pub noise: f64,
    /// The stated error.
    pub stated: f64,
    /// Area or volume of its zone, m² or m³.
    pub size: f64,
}

impl HalvedValue {
    /// (v − a)(v − b), whose mean is the square of the true error.
    fn squared_error(&self) -> f64 {
        (self.value - self.halves[0]) * (self.value - self.halves[1])
    }

    /// Difference to the mean of the halves.
    fn difference(&self) -> f64 {
        (self.value - 0.5 * (self.halves[0] + self.halves[1])).abs()
    }

    /// True where the value is within `factor` times its stated error, the noise of the reference included.
    fn is_within(&self, factor: f64) -> bool {
        self.difference() <= (factor * self.stated).hypot(NOISE_STANDARD_ERRORS * self.noise)
    }
}

/// How zones count in an L2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ZoneWeight {
    /// Each alike.
    Count,
    /// By area or volume.
    Size,
}

/// A relative L2 error and its upper bound.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct TotalError {
    /// The estimate.
    pub error: f64,
    /// The upper bound, at two standard errors of the square.
    pub upper: f64,
}

impl TotalError {
    /// The L2 of a list; 0 of a list without light.
    pub(crate) fn of(values: &[HalvedValue], weight: ZoneWeight) -> TotalError {
        let weight = |v: &HalvedValue| if weight == ZoneWeight::Count { 1.0 } else { v.size };
        let whole: f64 = values.iter().map(|v| weight(v) * v.halves[0] * v.halves[1]).sum();
        if whole <= 0.0 {
            return TotalError::default();
        }
        let square = values.iter().map(|v| weight(v) * v.squared_error()).sum::<f64>() / whole;
        let rest = |v: &HalvedValue| weight(v) * (v.squared_error() - square * v.halves[0] * v.halves[1]);
        let n = values.len() as f64;
        let variance = n / (n - 1.0).max(1.0) * values.iter().map(|v| rest(v).powi(2)).sum::<f64>();
        let upper = square + BOUND_STANDARD_ERRORS * variance.sqrt() / whole;
        TotalError { error: square.max(0.0).sqrt(), upper: upper.max(0.0).sqrt() }
    }

    /// The larger error, and the larger bound.
    pub(crate) fn max(self, other: TotalError) -> TotalError {
        TotalError { error: self.error.max(other.error), upper: self.upper.max(other.upper) }
    }

    /// True where the bound is far above the error: the noise of the reference, or of the choice of zones, is large.
    pub(crate) fn is_noisy(&self) -> bool {
        self.upper > MAX_BOUND_RATIO * self.error
    }
}

/// The median of stated over true error; `None` where the noise of the reference hides the true one.
///
/// The median of the squares of differences to the mean of both halves is that of normal numbers of the variance d² + e², with e the noise; that of e² is
/// subtracted.
pub(crate) fn median_ratio(values: &[HalvedValue]) -> Option<f64> {
    let square = |v: &HalvedValue| {
        (v.difference().powi(2) - MEDIAN_OF_NORMAL_SQUARE * v.noise * v.noise) / (v.stated * v.stated)
    };
    let squares = values.iter().map(square).filter(|x| !x.is_nan());
    median(squares.collect()).filter(|m| *m > 0.0).map(|m| m.sqrt().recip())
}

/// The share of values within `factor` times their stated error; `None` for no values.
pub(crate) fn share_within(values: &[HalvedValue], factor: f64) -> Option<f64> {
    let inside = values.iter().filter(|v| v.is_within(factor)).count();
    (!values.is_empty()).then(|| inside as f64 / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_reference::Rng;

    /// Values of 1 with an error of 4 % and halves with a noise of 10 %.
    fn noisy(count: usize, stated: f64) -> Vec<HalvedValue> {
        let mut rng = Rng::new(5);
        // A sum of twelve uniform numbers is nearly normal and has the variance 1.
        let mut number = |deviation: f64| deviation * ((0..12).map(|_| rng.uniform()).sum::<f64>() - 6.0);
        let one = |_| HalvedValue {
            value: 1.0 + number(0.04),
            halves: [1.0 + number(0.1), 1.0 + number(0.1)],
            noise: 0.1 / 2f64.sqrt(),
            stated,
            size: 1.0,
        };
        (0..count).map(one).collect()
    }

    #[test]
    fn noise_of_halves_drops_out() {
        let e = TotalError::of(&noisy(20_000, 0.0), ZoneWeight::Count);
        assert!((e.error - 0.04).abs() < 0.003, "{e:?}");
        assert!(e.upper > 0.04 && e.upper < 0.045, "{e:?}");
        // Bounds of few zones are wide, and hold the true error in most samples.
        let held = noisy(5_000, 0.0)
            .chunks(100)
            .filter(|c| {
                let e = TotalError::of(c, ZoneWeight::Count);
                assert!(e.upper > e.error);
                e.upper >= 0.04
            })
            .count();
        assert!((45..=50).contains(&held), "{held} of 50");
    }

    #[test]
    fn weights_count_by_size() {
        let zone =
            |value: f64, size: f64| HalvedValue { value, halves: [1.0; 2], size, ..HalvedValue::default() };
        let values = [zone(1.5, 1.0), zone(1.0, 99.0)];
        assert!((TotalError::of(&values, ZoneWeight::Count).error - 0.125f64.sqrt()).abs() < 1e-12);
        assert!((TotalError::of(&values, ZoneWeight::Size).error - 0.05).abs() < 1e-12);
        assert_eq!(TotalError::of(&[], ZoneWeight::Count), TotalError::default());
    }

    #[test]
    fn ratios_see_through_noise() {
        // The median of |x| of normal numbers is 0.6745 standard deviations.
        let ratio = median_ratio(&noisy(20_000, 0.08)).unwrap();
        assert!((ratio - 0.08 / (0.04 * 0.6745)).abs() < 0.3, "{ratio}");
        let hidden =
            HalvedValue { value: 1.0, halves: [0.9, 1.1], noise: 0.1, stated: 0.1, ..HalvedValue::default() };
        assert_eq!(median_ratio(&[hidden]), None);
    }

    #[test]
    fn shares_include_the_noise() {
        let zone =
            |stated: f64, noise: f64| HalvedValue { value: 1.0, halves: [0.0; 2], noise, stated, size: 1.0 };
        let values = [zone(0.5, 0.0), zone(0.4, 0.0), zone(0.4, 0.31)];
        assert_eq!(share_within(&values, 2.0), Some(2.0 / 3.0));
        assert_eq!(share_within(&values, 1.0), Some(0.0));
        assert_eq!(share_within(&[], 2.0), None);
    }
}
