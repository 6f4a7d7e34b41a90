//! Distributions of the varied numbers of a scene.
//!
//! | text | distribution |
//! |---|---|
//! | `LOW:HIGH` | uniform |
//! | `log:LOW:HIGH` | uniform in the logarithm |
//! | `normal:MEAN:DEVIATION` | Gaussian |
//! | `A,B,C` | one of the numbers, all equally likely |
//! | `A` | constant |

use zonal_math::low_discrepancy::{hash_to_unit, split_mix64};

/// A distribution of one number.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Distribution {
    /// Between two numbers.
    Uniform(f64, f64),
    /// Between two positive numbers, uniform in the logarithm.
    Logarithmic(f64, f64),
    /// Mean and standard deviation.
    Normal(f64, f64),
    /// One of several numbers.
    Choice(Vec<f64>),
}

impl Distribution {
    /// Reads a distribution.
    ///
    /// # Errors
    /// What is wrong, and what to write.
    pub(super) fn parse(text: &str) -> Result<Distribution, String> {
        let number = |t: &str| match t.trim().parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => Err(format!(
                "'{t}' is no number; write LOW:HIGH, log:LOW:HIGH, normal:MEAN:DEVIATION or numbers with commas"
            )),
        };
        let pair = |a: &str, b: &str| Ok::<_, String>((number(a)?, number(b)?));
        let parts: Vec<&str> = text.split(':').collect();
        match parts[..] {
            [list] => {
                Ok(Distribution::Choice(list.split(',').map(number).collect::<Result<Vec<f64>, _>>()?))
            }
            ["normal", mean, deviation] => match pair(mean, deviation)? {
                (mean, deviation) if deviation >= 0.0 => Ok(Distribution::Normal(mean, deviation)),
                (_, deviation) => Err(format!("the deviation is {deviation}; give one from 0")),
            },
            ["log", low, high] => match pair(low, high)? {
                (low, high) if low > 0.0 && low <= high => Ok(Distribution::Logarithmic(low, high)),
                (low, high) => {
                    Err(format!("{low}:{high} is no range of positive numbers; give the lower one first"))
                }
            },
            [low, high] => match pair(low, high)? {
                (low, high) if low <= high => Ok(Distribution::Uniform(low, high)),
                (low, high) => Err(format!("{low}:{high} is no range; give the lower number first")),
            },
            _ => Err(
                "this is no distribution; write LOW:HIGH, log:LOW:HIGH, normal:MEAN:DEVIATION or numbers with commas"
                    .into(),
            ),
        }
    }
    /// The number at `u`, uniform in (0, 1); `more` is a second such number.
    fn at(&self, u: f64, more: f64) -> f64 {
        match self {
            Distribution::Uniform(low, high) => low + (high - low) * u,
            Distribution::Logarithmic(low, high) => {
                (low.ln() + (high / low).ln() * u).exp().clamp(*low, *high)
            }
            Distribution::Normal(mean, deviation) => {
                mean + deviation * (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * more).cos()
            }
            Distribution::Choice(list) => list[((u * list.len() as f64) as usize).min(list.len() - 1)],
        }
    }
    /// Sample `sample` of varied number `number`: a function of these and of the seed only.
    pub(super) fn sample(&self, seed: u64, sample: usize, number: usize) -> f64 {
        let own = split_mix64(split_mix64(seed) ^ (number as u64).rotate_left(32)) ^ sample as u64;
        // A number in (0, 1): its logarithm is finite.
        let unit = |k: u64| (1.0 - hash_to_unit(split_mix64(own).wrapping_add(k))).clamp(1e-12, 1.0 - 1e-12);
        self.at(unit(0), unit(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_have_the_mean_and_the_range_of_their_distribution() {
        let n = 20_000;
        for (text, mean, range) in [
            ("2:4", 3.0, [2.0, 4.0]),
            ("log:1:100", 99.0 / 100f64.ln(), [1.0, 100.0]),
            ("normal:5:2", 5.0, [-7.0, 17.0]),
            ("1,2,6", 3.0, [1.0, 6.0]),
            ("7", 7.0, [7.0, 7.0]),
        ] {
            let d = Distribution::parse(text).unwrap();
            let all: Vec<f64> = (0..n).map(|i| d.sample(3, i, 1)).collect();
            let found = all.iter().sum::<f64>() / n as f64;
            let variance = all.iter().map(|x| (x - found).powi(2)).sum::<f64>() / n as f64;
            assert!((found - mean).abs() <= 5.0 * (variance / n as f64).sqrt(), "{text}: {found}");
            assert!(all.iter().all(|x| (range[0]..=range[1]).contains(x)), "{text}");
            if text == "normal:5:2" {
                assert!((variance.sqrt() - 2.0).abs() < 0.05, "{variance}");
            }
            // Other seeds and other numbers give other samples.
            let others = [d.sample(4, 0, 1), d.sample(3, 0, 2), d.sample(3, 1, 1)];
            assert!(range[0] == range[1] || others.iter().any(|x| *x != all[0]));
        }
    }

    #[test]
    fn wrong_distributions_are_refused() {
        for (text, message) in [
            ("4:2", "lower number first"),
            ("log:0:1", "positive"),
            ("normal:1:-1", "from 0"),
            ("a:b", "'a' is no number"),
            ("1,,2", "'' is no number"),
            ("1:2:3:4", "no distribution"),
            ("inf", "no number"),
        ] {
            assert!(Distribution::parse(text).unwrap_err().contains(message), "{text}");
        }
    }
}
