//! Smoothing of a gather over neighbouring zones, as far as two independent halves of its samples show that it helps.
//!
//! R_A and R_B are the means of two independent halves, S_A and S_B the same after a linear fit over a window of neighbours
//! (`regression_windows`). Over a group of zones (`zone_groups`), with Δ the difference of the halves and ⟨⟩ the mean,
//!
//! ```text
//! v_R = ⟨ΔR²⟩/4      v_S = ⟨ΔS²⟩/4      c = ⟨ΔR ΔS⟩/4      b² = ⟨(S_A − R_A)(S_B − R_B)⟩⁺
//! ```
//!
//! are the noise of both, their covariance and the squared bias of the fit: the halves are independent, so that noise drops out of the product. The
//! mixture R + λ (S − R) has the squared error
//!
//! ```text
//! (1 − λ)² v_R + λ² (v_S + b²) + 2 λ (1 − λ) c      least for λ = (v_R − c)/(v_R + v_S + b² − 2c), between 0 and 1
//! ```
//!
//! A group takes the window of the least error. The fits of a group share their neighbours, so that its few independent fits estimate v_S and b² poorly:
//! v_S is at least half of the share of v_R that it has over all groups of the kind, and b² is increased by a share of its standard error. The product of
//! two noisy differences is noisier still: unless b² of a group is significant by itself, it is joined with that of the neighbouring groups, and theirs with that of all groups of the kind. λ and window are the same for all bands and light groups, so that sums remain sums.

use super::gather_error::ratio;
use super::regression_windows::{RegressionWindow, RegressionWindows};
use super::single_precision::{SingleBands, to_double, to_single};
use rayon::prelude::*;
use zonal_scene::{Band, Bands};

/// Share of the noise that the mixture must remove before a group is smoothed: the estimates of one group vary.
const MIN_GAIN: f64 = 0.1;

/// The mean of both halves of a column at zone `i`.
pub(crate) fn mean_of_halves(column: &[Vec<SingleBands>; 2], i: usize) -> Bands {
    0.5 * (to_double(column[0][i]) + to_double(column[1][i]))
}

/// The means of both halves over the zones of some kinds, a column for each light group.
pub(crate) struct HalfMeans {
    /// Means of halves A and B of every column and zone.
    pub columns: Vec<[Vec<SingleBands>; 2]>,
    /// Means of both halves of a part of one of the columns, which is smoothed as they are; `None` without.
    pub part: Option<[Vec<SingleBands>; 2]>,
    /// Weight of every column, then of their sum, in the choice of λ: the inverse of its level, per band.
    pub weights: Vec<Bands>,
}

/// The smoothed values of a group of zones.
pub(crate) struct SmoothedGroup {
    /// Share of the smoothed value.
    pub lambda: f64,
    /// Values of every column and zone.
    pub values: Vec<Vec<Bands>>,
    /// Values of the part of a column; empty without.
    pub part: Vec<Bands>,
    /// Mean squared error of every column, then of their sum; without smoothing that of the halves.
    pub square_errors: Vec<Bands>,
    /// The part of it that the noise of the zone's own samples has.
    pub own_noise: Vec<Bands>,
}

/// Share of the standard error of the squared bias that is added to it.
const BIAS_ERROR_SHARE: f64 = 0.3;
/// Weight of the squared bias of neighbouring groups, and of all groups, over that of a group.
const NEIGHBOURS_WEIGHT: f64 = 3.0;
const ALL_GROUPS_WEIGHT: f64 = 3.0;
/// Squared bias of a group over its standard error from which it stands alone.
const SIGNIFICANT_DEVIATION: f64 = 2.0;
/// Most groups that are sampled for the noise and the squared bias of the fits of all groups.
const MAX_SAMPLED_GROUPS: usize = 256;
/// Least noise of a fit over that of the samples, relative to the same over all groups.
const MIN_NOISE_SHARE: f64 = 0.5;

/// The moments of a group for one window and quantity.
#[derive(Clone, Copy, Default)]
struct Moments {
    raw: Bands,
    smooth: Bands,
    both: Bands,
    bias: Bands,
    bias_squares: Bands,
}

impl Moments {
    fn add(&mut self, raw: [Bands; 2], smooth: [Bands; 2]) {
        let [dr, ds] = [0.5 * (raw[0] - raw[1]), 0.5 * (smooth[0] - smooth[1])];
        self.raw += dr * dr;
        self.smooth += ds * ds;
        self.both += dr * ds;
        let bias = (smooth[0] - raw[0]) * (smooth[1] - raw[1]);
        self.bias += bias;
        self.bias_squares += bias * bias;
    }

    /// Adds the moments of another group.
    fn add_all(&mut self, other: &Moments) {
        self.raw += other.raw;
        self.smooth += other.smooth;
        self.bias += other.bias;
        self.bias_squares += other.bias_squares;
    }

    /// Joins the squared bias with that of other groups together, `all`, in proportion to the noise, unless its own is significant.
    fn support_bias(&mut self, all: &Moments, weight: f64) {
        for b in Band::all() {
            let (own, variance) = (self.bias[b], self.bias_squares[b]);
            if own > SIGNIFICANT_DEVIATION * variance.sqrt() {
                continue;
            }
            let share = weight * ratio(self.raw[b], all.raw[b]);
            self.bias[b] = (own + share * all.bias[b]) / (1.0 + weight);
            self.bias_squares[b] =
                (variance + share * share * all.bias_squares[b]) / ((1.0 + weight) * (1.0 + weight));
        }
    }

    /// The squared bias with its uncertainty.
    fn squared_bias(&self) -> Bands {
        self.bias.map(|b| b.max(0.0)) + BIAS_ERROR_SHARE * self.bias_squares.sqrt()
    }

    fn error(&self, lambda: f64) -> Bands {
        let (l, r) = (lambda, 1.0 - lambda);
        (r * r * self.raw + l * l * (self.smooth + self.squared_bias()) + 2.0 * l * r * self.both)
            .map(|e| e.max(0.0))
    }
}

/// Values of both halves of a column.
type Halves = [Vec<SingleBands>; 2];

/// The smoothed halves of the zones of a group by one window level, for every column.
type SmoothedHalves = Vec<Halves>;

/// The fit of a group over the windows of one level.
struct GroupFit {
    halves: SmoothedHalves,
    /// Moments of every column, then of their sum.
    moments: Vec<Moments>,
}

/// Smooths neighbouring groups of zones of one kind: patches, volume zones, or panes, which have no neighbours. The squared biases of all groups
/// together support that of each.
pub(crate) fn smooth_groups(
    windows: &RegressionWindows,
    means: &HalfMeans,
    groups: &[&[u32]],
    all_groups: &[LevelMoments],
) -> Vec<SmoothedGroup> {
    let fit = |group: &&[u32], level: usize| {
        let halves = smoothed_halves(windows, &means.columns, group, level);
        let mut moments = moments_of(means, &halves, group);
        let least = MIN_NOISE_SHARE * all_groups[level].noise_share;
        moments.iter_mut().for_each(|m| m.smooth = m.smooth.max(least * m.raw));
        GroupFit { halves, moments }
    };
    // The fits of every level, for every group.
    let mut levels: Vec<Vec<GroupFit>> =
        (0..all_groups.len()).map(|level| groups.iter().map(|group| fit(group, level)).collect()).collect();
    for (fits, of_all) in levels.iter_mut().zip(all_groups) {
        for q in 0..means.columns.len() + 1 {
            let mut all = Moments::default();
            fits.iter().for_each(|f| all.add_all(&f.moments[q]));
            all.support_bias(&of_all.moments[q], ALL_GROUPS_WEIGHT);
            fits.iter_mut().for_each(|f| f.moments[q].support_bias(&all, NEIGHBOURS_WEIGHT));
        }
    }
    let of_group = |k: usize| levels.iter().map(|fits| &fits[k]).collect::<Vec<_>>();
    let smoothed = |(k, group): (usize, &&[u32])| {
        mixture(means, group, &of_group(k), &|column, level| {
            smoothed_halves(windows, std::slice::from_ref(column), group, level).swap_remove(0)
        })
    };
    groups.iter().enumerate().map(smoothed).collect()
}

/// λ and the weighted squared error of the mixture of a group with a fit.
fn best_share(means: &HalfMeans, moments: &[Moments]) -> (f64, f64) {
    let total = |part: fn(&Moments) -> Bands| -> f64 {
        let weight = |q: usize| means.weights[q];
        moments.iter().enumerate().map(|(q, m)| (weight(q) * weight(q) * part(m)).sum()).sum()
    };
    let (raw, fit, both) = (total(|m| m.raw), total(|m| m.smooth), total(|m| m.both));
    let bias = total(Moments::squared_bias);
    let lambda = ratio(raw - both, raw + fit + bias - 2.0 * both).clamp(0.0, 1.0);
    let r = 1.0 - lambda;
    let error = r * r * raw + lambda * lambda * (fit + bias) + 2.0 * lambda * r * both;
    (lambda, error / ((1.0 - MIN_GAIN) * raw).max(f64::MIN_POSITIVE))
}

/// The mixture of a group with the fit of the least error. `fit_part` fits the part of a column at a level.
fn mixture(
    means: &HalfMeans,
    group: &[u32],
    fits: &[&GroupFit],
    fit_part: &dyn Fn(&Halves, usize) -> Halves,
) -> SmoothedGroup {
    let count = group.len() as f64;
    let (mut best, mut least) = (None, 1.0);
    for (level, fit) in fits.iter().enumerate() {
        let (lambda, error) = best_share(means, &fit.moments);
        if error < least {
            (best, least) = (Some((lambda, level)), error);
        }
    }
    let Some((lambda, level)) = best else {
        let unsmoothed =
            |column: &Halves| group.iter().map(|i| mean_of_halves(column, *i as usize)).collect();
        let noise: Vec<Bands> = raw_noise(means, group).into_iter().map(|e| e / count).collect();
        return SmoothedGroup {
            lambda: 0.0,
            values: means.columns.iter().map(unsmoothed).collect(),
            part: means.part.as_ref().map(unsmoothed).unwrap_or_default(),
            own_noise: noise.clone(),
            square_errors: noise,
        };
    };
    let GroupFit { halves, moments } = fits[level];
    let mixed = |column: &Halves, fit: &Halves| {
        let value = |k: usize| {
            mean_of_halves(column, group[k] as usize) * (1.0 - lambda) + lambda * mean_of_halves(fit, k)
        };
        (0..group.len()).map(value).collect()
    };
    SmoothedGroup {
        lambda,
        values: means.columns.iter().zip(halves).map(|(column, fit)| mixed(column, fit)).collect(),
        part: means.part.iter().flat_map(|part| mixed(part, &fit_part(part, level))).collect(),
        square_errors: moments.iter().map(|m| m.error(lambda) / count).collect(),
        own_noise: moments.iter().map(|m| (1.0 - lambda).powi(2) * m.raw / count).collect(),
    }
}

/// Sum of v_R over a group, of every column, then of their sum.
fn raw_noise(means: &HalfMeans, group: &[u32]) -> Vec<Bands> {
    let own: SmoothedHalves = means
        .columns
        .iter()
        .map(|c| [0, 1].map(|h| group.iter().map(|i| c[h][*i as usize]).collect()))
        .collect();
    moments_of(means, &own, group).into_iter().map(|m| m.raw).collect()
}

/// The fits of one window level over all zones of a kind.
pub(crate) struct LevelMoments {
    /// Noise of the fits over that of the samples, by the sum of the columns.
    noise_share: f64,
    /// Moments of every column, then of their sum.
    moments: Vec<Moments>,
}

/// The fits of every window level over all zones of a kind, by a sample of the groups.
pub(crate) fn level_moments(
    windows: &RegressionWindows,
    means: &HalfMeans,
    groups: &[&[u32]],
) -> Vec<LevelMoments> {
    let Some(first) = groups.first() else { return Vec::new() };
    let of_level = |level: usize| {
        let of_group = |group: &&[u32]| {
            moments_of(means, &smoothed_halves(windows, &means.columns, group, level), group)
        };
        let step = groups.len().div_ceil(MAX_SAMPLED_GROUPS);
        let parts: Vec<Vec<Moments>> = groups.par_iter().step_by(step).map(of_group).collect();
        let mut moments = vec![Moments::default(); means.columns.len() + 1];
        for part in &parts {
            moments.iter_mut().zip(part).for_each(|(all, m)| all.add_all(m));
        }
        let noise_share = moments.last().map_or(0.0, |m| ratio(m.smooth.sum(), m.raw.sum()));
        LevelMoments { noise_share, moments }
    };
    (0..first.first().map_or(0, |i| windows.levels(*i as usize))).map(of_level).collect()
}

/// The halves of all columns fitted at the zones of a group; a zone without a window keeps its own.
fn smoothed_halves(
    windows: &RegressionWindows,
    columns: &[Halves],
    group: &[u32],
    level: usize,
) -> SmoothedHalves {
    let mut out: SmoothedHalves =
        columns.iter().map(|_| [Vec::with_capacity(group.len()), Vec::with_capacity(group.len())]).collect();
    for i in group.iter().map(|i| *i as usize) {
        let window: Option<RegressionWindow> = windows.window(i, level);
        for (column, out) in columns.iter().zip(&mut out) {
            for (half, out) in column.iter().zip(out) {
                out.push(match &window {
                    None => half[i],
                    Some(w) => {
                        let mut sum = Bands::ZERO;
                        w.for_each(|j, l| sum += l * to_double(half[j]));
                        // Lit neighbours are separated from a zone that no sample lights.
                        let own = mean_of_halves(column, i);
                        let fit = sum.zip_map(own, |v, own| if own > 0.0 { v.max(0.0) } else { 0.0 });
                        to_single(fit)
                    }
                });
            }
        }
    }
    out
}

/// Sums of the moments of every column, then of their sum.
fn moments_of(means: &HalfMeans, smooth: &SmoothedHalves, group: &[u32]) -> Vec<Moments> {
    let mut out = vec![Moments::default(); means.columns.len() + 1];
    for (k, i) in group.iter().map(|i| *i as usize).enumerate() {
        let (mut raw_sum, mut smooth_sum) = ([Bands::ZERO; 2], [Bands::ZERO; 2]);
        for (c, (column, smooth)) in means.columns.iter().zip(smooth).enumerate() {
            let (raw, fit) =
                ([0, 1].map(|h| to_double(column[h][i])), [0, 1].map(|h| to_double(smooth[h][k])));
            out[c].add(raw, fit);
            for h in 0..2 {
                raw_sum[h] += raw[h];
                smooth_sum[h] += fit[h];
            }
        }
        out[means.columns.len()].add(raw_sum, smooth_sum);
    }
    out
}

/// The inverse of a level, per band.
pub(crate) fn inverse(level: Bands) -> Bands {
    Bands::from_fn(|b: Band| if level[b] > 0.0 { 1.0 / level[b] } else { 0.0 })
}
