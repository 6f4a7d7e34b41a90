//! H or G of every zone from the samples so far, smoothed, with stated errors.
//!
//! The share of smoothing is that of a group of zones (`half_smoothing`). A single zone may differ from its neighbours where most of its group does
//! not: with its own mean R, the smoothed value S and its standard error σ, the change S − R is limited to ±2 σ.

use super::escape_rays::EscapeControl;
use super::gather_error::{STATED_ERROR_FACTOR, ZoneVariances, inherited_errors, ratio, standard_errors};
use super::gather_sums::GatherSums;
use super::gather_task::{GatherTask, ranges_of_kinds};
use super::half_smoothing::{self, HalfMeans, SmoothedGroup};
use super::single_precision::{SingleBands, to_single};
use super::unmet_light::UnmetLight;
use super::zone_gather::Gatherer;
use super::zone_groups::GROUPS_TOGETHER;
use crate::settings::zone_power::fluence_factor;
use rayon::prelude::*;
use std::ops::Range;
use zonal_math::parallel;
use zonal_scene::{Band, Bands};

/// Change by smoothing over the standard error of a zone by its own samples above which it is limited.
const MAX_CREDIBLE_CHANGE: f64 = 2.0;

/// Fields of the samples so far.
pub(crate) struct GatheredFields {
    /// Value of every quantity: the groups, then their sum.
    pub values: Vec<Vec<Bands>>,
    /// Stated errors of the same.
    pub errors: Vec<Vec<Bands>>,
    /// Stated errors by the noise of the radiosities.
    pub inherited: Vec<Bands>,
    /// Values of the surroundings alone; empty where they are not sampled.
    pub sky: Vec<Bands>,
    /// Escape rays for each sample in the next round ([`super::escape_rays::EscapeRays::ratios`]).
    pub escape_ratios: Vec<u8>,
    /// Zones whose samples met no light.
    pub unmet: UnmetLight,
}

/// The sums of the samples, with the corrections of their means by escape rays.
struct Means<'a> {
    task: &'a GatherTask<'a>,
    sums: &'a GatherSums,
    control: EscapeControl<'a>,
}

impl Means<'_> {
    /// H or G over the mean of the samples of zone `i`.
    fn factor(&self, i: usize) -> f64 {
        fluence_factor(self.task.zones, i)
    }

    /// Mean of one half of column `c`.
    fn half(&self, i: usize, half: usize, c: usize) -> Bands {
        let sampled = self.sums.half(i, half, c) + (self.task.own)(i, c);
        self.factor(i) * (sampled + self.control.correction(i, half, c))
    }

    /// Mean of one half of the surroundings alone, of radiosity `sky`.
    fn half_of_sky(&self, i: usize, half: usize, sky: Bands) -> Bands {
        let sampled = self.sums.half(i, half, self.task.groups + 2);
        self.factor(i) * (sampled + self.control.correction_of_part(i, half, sky))
    }

    /// The variances of quantity `q`.
    fn variances(&self, i: usize, q: usize) -> ZoneVariances {
        let (square, more) = (self.factor(i) * self.factor(i), self.control.corrections(i, q));
        let [a, b] = [0, 1].map(|h| self.sums.half(i, h, q) + more[h]);
        let difference = 0.5 * (a - b);
        let of_samples = self.control.variance(i, q, [self.sums.mean(i, q), self.sums.variance(i, q)]);
        ZoneVariances { of_halves: square * difference * difference, of_samples: square * of_samples }
    }
}

impl GatheredFields {
    /// Zeros.
    pub(crate) fn new(task: &GatherTask) -> GatheredFields {
        let n = task.zones.len();
        let fields = || vec![vec![Bands::ZERO; n]; task.groups + 1];
        let sky = vec![Bands::ZERO; if task.sky.is_some() { n } else { 0 }];
        let inherited = vec![Bands::ZERO; n];
        GatheredFields {
            values: fields(),
            errors: fields(),
            inherited,
            sky,
            escape_ratios: Vec::new(),
            unmet: UnmetLight::default(),
        }
    }

    /// Determines the fields of the kinds of zones that have new samples: the patches, and the volume zones with the panes.
    pub(crate) fn update(
        &mut self,
        gatherer: &Gatherer,
        task: &GatherTask,
        sums: &GatherSums,
        changed: [bool; 2],
    ) {
        let mean = |i: usize, c: usize| sums.mean(i, c);
        let control = EscapeControl::new(&sums.escape, &sums.counts, task.zone_groups, mean);
        let means = Means { task, sums, control };
        for (range, _) in ranges_of_kinds(task.zones).into_iter().zip(changed).filter(|(_, c)| *c) {
            let halves = half_means(&means, range.clone());
            for kind in (0..3).filter(|k| range.contains(&task.zone_groups.kinds()[*k].start)) {
                self.measure_errors(&means, kind);
                self.smooth(task, &halves, kind);
                self.measure_inherited_errors(&means, kind);
                self.unmet.contain(gatherer, task, sums, kind, &self.values, &mut self.errors);
            }
        }
        let moments = |i: usize| {
            let variance = 2.0 * sums.counts[i] as f64 * sums.variance(i, task.groups);
            [means.control.explained_variance(i), variance.sum()]
        };
        self.escape_ratios = sums.escape.ratios(task.zone_groups, moments);
    }

    /// The standard errors of every quantity of the zones of a kind, without smoothing.
    fn measure_errors(&mut self, means: &Means, kind: usize) {
        let order = means.task.zone_groups.order_of_kind(kind);
        for (q, errors) in self.errors.iter_mut().enumerate() {
            let variances: Vec<ZoneVariances> = parallel::map(order, |i| means.variances(*i as usize, q));
            let standard = standard_errors(&variances);
            order.iter().zip(standard).for_each(|(i, e)| errors[*i as usize] = e);
        }
    }

    /// The errors by the noise of the radiosities.
    fn measure_inherited_errors(&mut self, means: &Means, kind: usize) {
        let (order, groups) = (means.task.zone_groups.order_of_kind(kind), means.task.groups);
        let noise = |i: &u32| means.factor(*i as usize) * means.sums.mean(*i as usize, groups + 1);
        let noise: Vec<Bands> = parallel::map(order, noise);
        let values: Vec<Bands> = parallel::map(order, |i| self.values[groups][*i as usize]);
        let inherited = inherited_errors(&noise, &values);
        let all = order.iter().zip(inherited);
        all.for_each(|(i, e)| self.inherited[*i as usize] = STATED_ERROR_FACTOR * e);
    }

    /// Smooths all groups of zones of a kind. The errors are the standard errors of the zones by their own samples before, and the stated errors after.
    fn smooth(&mut self, task: &GatherTask, means: &HalfMeans, kind: usize) {
        let (groups, blocks) = (task.groups, task.zone_groups.of_kind(kind));
        let of_all = match kind {
            2 => Vec::new(),
            _ => half_smoothing::level_moments(task.windows, means, &blocks),
        };
        let chunks: Vec<&[&[u32]]> = blocks.chunks(GROUPS_TOGETHER).collect();
        let zone_values = |chunk: usize| {
            let smoothed = half_smoothing::smooth_groups(task.windows, means, chunks[chunk], &of_all);
            let of_group = |(block, group): (&&[u32], SmoothedGroup)| {
                let zones = block.iter().enumerate();
                zones
                    .flat_map(|(k, i)| self.smoothed_zone(means, &group, k, *i as usize))
                    .collect::<Vec<Bands>>()
            };
            chunks[chunk].iter().zip(smoothed).flat_map(of_group).collect::<Vec<Bands>>()
        };
        let width = 2 * (groups + 1) + usize::from(means.part.is_some());
        let zones_of = |chunk: usize| chunks[chunk].iter().map(|block| block.len()).sum::<usize>();
        let division = task.execution.blocks(chunks.len(), 1);
        let lengths = |chunk: usize| width * zones_of(chunk);
        let smoothed = division.map_lists(task.execution.communicator, lengths, zone_values);
        let order = chunks.iter().flat_map(|chunk| chunk.iter()).flat_map(|block| block.iter());
        for (i, of_zone) in order.zip(smoothed.iter().flat_map(|list| list.chunks_exact(width))) {
            let (values, rest) = of_zone.split_at(groups + 1);
            let (errors, part) = rest.split_at(groups + 1);
            let i = *i as usize;
            self.values.iter_mut().zip(values).for_each(|(list, v)| list[i] = *v);
            self.errors.iter_mut().zip(errors).for_each(|(list, e)| list[i] = *e);
            self.sky.get_mut(i).into_iter().zip(part).for_each(|(sky, v)| *sky = *v);
        }
    }

    /// The values of zone `i`, number `k` of its group, after smoothing: of every light group and their sum, the stated errors of the same, and the surroundings alone
    /// where they are sampled.
    fn smoothed_zone(&self, means: &HalfMeans, group: &SmoothedGroup, k: usize, i: usize) -> Vec<Bands> {
        let groups = means.columns.len();
        let own: Vec<Bands> = means.columns.iter().map(|c| half_smoothing::mean_of_halves(c, i)).collect();
        let change: Bands = (0..groups).map(|c| group.values[c][k] - own[c]).sum();
        let share = credible_share(change, self.errors[groups][i]);
        let mixed = |own: Bands, smoothed: Bands| positive(own + share * (smoothed - own));
        let mut out: Vec<Bands> = (0..groups).map(|c| mixed(own[c], group.values[c][k])).collect();
        out.push(out.iter().fold(Bands::ZERO, |sum, v| sum + *v));
        for (q, errors) in self.errors.iter().enumerate() {
            let mut error = errors[i];
            join_errors(group, q, share, &mut error);
            out.push(error);
        }
        let part = means.part.iter();
        out.extend(part.map(|part| mixed(half_smoothing::mean_of_halves(part, i), group.part[k])));
        out
    }
}

/// The share of the change of a zone by smoothing that its standard error supports: a change beyond [`MAX_CREDIBLE_CHANGE`] of it is the bias of a zone that
/// differs from its neighbours.
fn credible_share(change: Bands, standard_error: Bands) -> f64 {
    let of_band = |b: Band| MAX_CREDIBLE_CHANGE * ratio(standard_error[b], change[b].abs());
    Band::all().filter(|b| change[*b] != 0.0).map(of_band).fold(1.0, f64::min)
}

/// Corrections by escape rays may leave little less than zero.
fn positive(v: Bands) -> Bands {
    v.map(|v| v.max(0.0))
}

/// The halves of every light group over a range of zones, with their weights.
fn half_means(means: &Means, range: Range<usize>) -> HalfMeans {
    let (n, groups) = (means.task.zones.len(), means.task.groups);
    let filled = |mean: &(dyn Fn(usize) -> Bands + Sync)| {
        let mut list = vec![SingleBands::default(); n];
        let zones = list[range.clone()].par_iter_mut().zip(range.clone());
        zones.for_each(|(v, i)| *v = to_single(mean(i)));
        list
    };
    let half = |c: usize, h: usize| filled(&|i| means.half(i, h, c));
    let columns: Vec<[Vec<SingleBands>; 2]> = (0..groups).map(|c| [half(c, 0), half(c, 1)]).collect();
    let part = means.task.sky.map(|sky| [0, 1].map(|h| filled(&|i| means.half_of_sky(i, h, sky.radiosity))));
    let of_column = |c: &[Vec<SingleBands>; 2], i: usize| half_smoothing::mean_of_halves(c, i);
    let mut weights: Vec<Bands> =
        columns.iter().map(|c| weight_of(range.clone(), &|i| of_column(c, i))).collect();
    weights.push(weight_of(range.clone(), &|i| columns.iter().map(|c| of_column(c, i)).sum::<Bands>()));
    HalfMeans { columns, part, weights }
}

/// Inverse root mean square of a field over a range of zones.
fn weight_of(range: Range<usize>, field: &dyn Fn(usize) -> Bands) -> Bands {
    let count = range.len().max(1) as f64;
    let square = range.fold(Bands::ZERO, |s, i| s + field(i) * field(i));
    half_smoothing::inverse((square / count).sqrt())
}

/// Turns the standard error of a zone into its stated error after smoothing, of which it takes this share: the part of the zone's own samples keeps its size,
/// the rest is that of the group.
fn join_errors(group: &SmoothedGroup, q: usize, share: f64, error: &mut Bands) {
    let own = 1.0 - share * group.lambda;
    let rest = (group.square_errors[q] - group.own_noise[q]).map(|e| e.max(0.0));
    *error = STATED_ERROR_FACTOR * (own * own * *error * *error + rest).sqrt();
}
