//! Rays that only find out whether they leave the scene: the surroundings of a gather at a fraction of its cost.
//!
//! A zone that sees part of the surroundings has its largest variance from the fraction e of its rays that leave the scene. A further ray that tests
//! nothing else is several times cheaper than a sample. With the means v̄ and ē of n samples, and ē' of N such rays, the regression estimate
//! (Owen 2013, *Monte Carlo theory, methods and examples*, section 8.9)
//!
//! ```text
//! v = v̄ − c a (ē − ē')        a = N/(n + N)        c = Cov(v, e)/Var(e)
//! Var(v) = (Var(v) − 2 c a Cov(v, e) + c² a² Var(e))/n + c² a² Var(e')/N
//! ```
//!
//! has the mean of v for any c that does not depend on the same samples; c is that of a whole group of zones (`zone_groups`). As 0 ≤ e ≤ 1, ē (1 − ē) is an upper
//! bound of Var(e). At given work, with a sample as expensive as q rays, the variance is least for
//!
//! ```text
//! N/n = √(q c² Var(e)/(Var(v) − c² Var(e)))
//! ```
//!
//! In the first round the number of rays follows from the share of the surroundings that the *stored* rays of a group see, then from the moments of the
//! group: a number by the samples of the zone alone would bias its estimate.

use super::gather_error::ratio;
use super::single_precision::{self, SingleBands};
use super::zone_groups::ZoneGroups;
use crate::distribution::Message;
use crate::settings::stage_codec::{Decoder, Encoder};
use std::ops::Range;
use zonal_math::parallel;
use zonal_scene::Bands;

/// Numbers of rays.
struct EscapeParams {
    /// Rays over samples of a zone whose escape has the standard deviation 1, in the first round.
    rays_per_deviation: f64,
    /// Fewest rays for each sample in the first round: fewer reduce the variance too little.
    min_first_rays: f64,
    /// q: the cost of a sample over that of a ray.
    sample_cost: f64,
    /// Most rays for each sample.
    max_rays: f64,
}

const ESCAPE_PARAMS: EscapeParams =
    EscapeParams { rays_per_deviation: 16.0, min_first_rays: 3.0, sample_cost: 4.0, max_rays: 16.0 };
/// Row of a zone without such rays.
const NO_ROW: u32 = u32::MAX;

/// The groups of the patches and of the volume zones.
fn blocks(groups: &ZoneGroups) -> Vec<&[u32]> {
    [0, 1].into_iter().flat_map(|kind| groups.of_kind(kind)).collect()
}

/// The power of two nearest to a number of at least 0.7.
fn nearest_power(x: f64) -> u8 {
    1 << (x.log2().round() as u8)
}

/// Sums of a zone in one round.
pub(crate) struct EscapeSums {
    /// Σ e of the samples of each half.
    pub by_samples: [Bands; 2],
    /// Σ e' of the rays of each half.
    pub by_rays: [Bands; 2],
    /// Rays of each half.
    pub rays: usize,
    /// Σ v e of every column, over both halves.
    pub products: Vec<Bands>,
}

impl EscapeSums {
    /// Zeros, of this number of columns.
    pub(crate) fn new(columns: usize) -> EscapeSums {
        EscapeSums {
            by_samples: [Bands::ZERO; 2],
            by_rays: [Bands::ZERO; 2],
            rays: 0,
            products: vec![Bands::ZERO; columns],
        }
    }
}

/// The sums of all zones that have such rays; by default of none, where the gather does not sample the surroundings.
#[derive(Default)]
pub(crate) struct EscapeRays {
    columns: usize,
    /// Row of every zone.
    rows: Vec<u32>,
    /// Rays of each half so far, of every row.
    counts: Vec<u32>,
    /// Wanted rays for each sample, of every row.
    pub rays_per_sample: Vec<u8>,
    /// Of each row: Σ e of both halves, Σ e' of both halves, and Σ v e of every column.
    sums: Vec<SingleBands>,
}

/// Means of a zone: ē of its samples and ē' of its rays, for one half.
struct HalfOfRow {
    by_samples: Bands,
    by_rays: Bands,
}

impl EscapeRays {
    /// Rays of the patches and volume zones whose groups see part of the surroundings; `shares` holds the share of the rays of each zone that leave the
    /// scene.
    pub(crate) fn new(groups: &ZoneGroups, shares: &[f64], columns: usize) -> EscapeRays {
        let (mut per_sample, p) = (vec![0u8; shares.len()], &ESCAPE_PARAMS);
        for group in blocks(groups) {
            let share = group.iter().map(|i| shares[*i as usize]).sum::<f64>() / group.len() as f64;
            let rays = p.rays_per_deviation * (share * (1.0 - share)).max(0.0).sqrt();
            if rays >= p.min_first_rays {
                group.iter().for_each(|i| per_sample[*i as usize] = nearest_power(rays));
            }
        }
        let mut next = 0;
        let row = |rays: &u8| match rays {
            0 => NO_ROW,
            _ => {
                next += 1;
                next - 1
            }
        };
        let rows: Vec<u32> = per_sample.iter().map(row).collect();
        let rays_per_sample: Vec<u8> = per_sample.into_iter().filter(|r| *r > 0).collect();
        let sums = vec![SingleBands::default(); rays_per_sample.len() * (4 + columns)];
        EscapeRays { columns, rows, counts: vec![0; rays_per_sample.len()], rays_per_sample, sums }
    }

    fn row(&self, i: usize) -> Option<usize> {
        self.rows.get(i).filter(|r| **r != NO_ROW).map(|r| *r as usize)
    }

    /// Bytes of the row of zone `i` in messages.
    pub(crate) fn row_bytes(&self, i: usize) -> usize {
        if self.row(i).is_some() { 4 + 12 * (4 + self.columns) } else { 0 }
    }

    /// Appends the row of zone `i`.
    pub(crate) fn put_row(&self, i: usize, out: &mut Vec<u8>) {
        let Some(row) = self.row(i) else { return };
        self.counts[row].put(out);
        let width = 4 + self.columns;
        let sums = &self.sums[row * width..(row + 1) * width];
        sums.iter().for_each(|s| single_precision::words(*s).put(out));
    }

    /// Sets the row of zone `i` to that of [`EscapeRays::put_row`].
    pub(crate) fn take_row(&mut self, i: usize, bytes: &[u8]) {
        let Some(row) = self.row(i) else { return };
        let (count, sums) = bytes.split_at(4);
        self.counts[row] = u32::get(count);
        let width = 4 + self.columns;
        let own = &mut self.sums[row * width..(row + 1) * width];
        let values = sums.chunks_exact(12).map(|w| single_precision::from_words(Message::get(w)));
        own.iter_mut().zip(values).for_each(|(own, v)| *own = v);
    }

    /// The rows of `zones` zones by task: each task has `zones_per_task` consecutive zones, the last one the rest.
    pub(crate) fn by_tasks(&mut self, zones: usize, zones_per_task: usize) -> Vec<EscapeRows<'_>> {
        let width = 4 + self.columns;
        let (mut counts, mut sums) = (self.counts.as_mut_slice(), self.sums.as_mut_slice());
        let mut ratios = self.rays_per_sample.as_slice();
        let starts = (0..zones).step_by(zones_per_task);
        let rows_of = |first: usize| {
            let end = (first + zones_per_task).min(self.rows.len());
            let rows = &self.rows[first.min(end)..end];
            let number = rows.iter().filter(|r| **r != NO_ROW).count();
            let first_row = rows.iter().find(|r| **r != NO_ROW).map_or(0, |r| *r as usize);
            EscapeRows {
                first_zone: first,
                first_row,
                width,
                rows,
                ratios: ratios.split_off(..number).unwrap_or_default(),
                counts: counts.split_off_mut(..number).unwrap_or_default(),
                sums: sums.split_off_mut(..number * width).unwrap_or_default(),
            }
        };
        starts.map(rows_of).collect()
    }

    /// All rays so far.
    pub(crate) fn total(&self) -> u64 {
        self.counts.iter().map(|c| 2 * u64::from(*c)).sum()
    }

    /// The best rays for each sample of every row, from the moments of its group: `moments` gives c² Var(e) and Var(v) of a zone, of the sum of the columns
    /// over the bands.
    pub(crate) fn ratios(&self, groups: &ZoneGroups, moments: impl Fn(usize) -> [f64; 2] + Sync) -> Vec<u8> {
        let p = &ESCAPE_PARAMS;
        let ratio_of = |group: &&[u32]| {
            let zones = group.iter().map(|i| *i as usize).filter(|i| self.row(*i).is_some());
            let [explained, all] = zones.map(&moments).fold([0.0; 2], |s, m| [s[0] + m[0], s[1] + m[1]]);
            let rest = (all - explained).max(f64::MIN_POSITIVE);
            let rays = (p.sample_cost * explained.max(0.0) / rest).sqrt().min(p.max_rays);
            if rays >= 1.0 { nearest_power(rays) } else { 0 }
        };
        let blocks = blocks(groups);
        let ratios: Vec<u8> = parallel::map(&blocks, ratio_of);
        let mut of_rows = vec![0; self.counts.len()];
        for (group, ratio) in blocks.iter().zip(ratios) {
            group.iter().filter_map(|i| self.row(*i as usize)).for_each(|row| of_rows[row] = ratio);
        }
        of_rows
    }

    /// Sets all sums to zero.
    pub(crate) fn clear(&mut self) {
        self.sums.fill(SingleBands::default());
        self.counts.fill(0);
    }

    fn sum(&self, row: usize, k: usize) -> Bands {
        single_precision::to_double(self.sums[row * (4 + self.columns) + k])
    }

    /// ē and ē' of half `half` of a row, whose zone has `n` samples in each half.
    fn half(&self, row: usize, half: usize, n: f64) -> HalfOfRow {
        let rays = f64::from(self.counts[row].max(1));
        HalfOfRow { by_samples: self.sum(row, half) / n, by_rays: self.sum(row, 2 + half) / rays }
    }

    /// Writes the sums to a checkpoint.
    pub(crate) fn encode(&self, encoder: &mut Encoder) {
        let words = self.sums.iter().flat_map(|s| single_precision::words(*s));
        encoder.words(3 * self.sums.len(), words);
        encoder.words(self.counts.len(), self.counts.iter().copied());
    }

    /// Reads the sums of [`EscapeRays::encode`]; `None` where they are those of other zones.
    pub(crate) fn decode(&mut self, decoder: &mut Decoder) -> Option<()> {
        let words = decoder.words()?;
        let counts = decoder.words()?;
        if words.len() != 3 * self.sums.len() || counts.len() != self.counts.len() {
            return None;
        }
        self.counts.iter_mut().zip(counts).for_each(|(own, c)| *own = u32::from_le_bytes(*c));
        let sums =
            words.as_chunks::<3>().0.iter().map(|w| single_precision::from_words(w.map(u32::from_le_bytes)));
        self.sums.iter_mut().zip(sums).for_each(|(s, v)| *s = v);
        Some(())
    }
}

/// The rows of consecutive zones.
pub(crate) struct EscapeRows<'a> {
    first_zone: usize,
    first_row: usize,
    width: usize,
    rows: &'a [u32],
    ratios: &'a [u8],
    counts: &'a mut [u32],
    sums: &'a mut [SingleBands],
}

impl EscapeRows<'_> {
    /// Row of zone `i`, from the first of these.
    fn row(&self, i: usize) -> Option<usize> {
        self.rows.get(i - self.first_zone).filter(|r| **r != NO_ROW).map(|r| *r as usize - self.first_row)
    }

    /// Numbers of the rays that each half of zone `i` lacks where it has this number of samples; `None` without a row.
    pub(crate) fn wanted(&self, i: usize, samples: usize) -> Option<Range<usize>> {
        let row = self.row(i)?;
        let (now, wanted) = (self.counts[row] as usize, self.ratios[row] as usize * samples);
        Some(now..wanted.max(now))
    }

    /// Adds sums of zone `i`.
    pub(crate) fn add(&mut self, i: usize, more: &EscapeSums) {
        let Some(row) = self.row(i) else { return };
        let own = &mut self.sums[row * self.width..(row + 1) * self.width];
        let all = more.by_samples.iter().chain(&more.by_rays).chain(&more.products);
        own.iter_mut().zip(all).for_each(|(s, m)| single_precision::add_to(s, *m));
        self.counts[row] += more.rays as u32;
    }
}

/// The means of all zones with their escape rays.
pub(crate) struct EscapeControl<'a> {
    rays: &'a EscapeRays,
    /// Samples of each half of every zone.
    counts: &'a [usize],
    /// c of every column and row.
    coefficients: Vec<Vec<Bands>>,
}

impl<'a> EscapeControl<'a> {
    /// Determines c of every group of zones and column; `mean` gives the mean of the samples of a zone and column.
    pub(crate) fn new(
        rays: &'a EscapeRays,
        counts: &'a [usize],
        groups: &ZoneGroups,
        mean: impl Fn(usize, usize) -> Bands + Sync,
    ) -> EscapeControl<'a> {
        let mut coefficients = vec![vec![Bands::ZERO; rays.rays_per_sample.len()]; rays.columns];
        for (c, list) in coefficients.iter_mut().enumerate() {
            let of_group = |group: &&[u32]| {
                let (mut covariance, mut variance) = (Bands::ZERO, Bands::ZERO);
                for (i, row) in group.iter().filter_map(|i| Some((*i as usize, rays.row(*i as usize)?))) {
                    let n = 2.0 * counts[i] as f64;
                    let escaped = rays.sum(row, 0) + rays.sum(row, 1);
                    covariance += rays.sum(row, 4 + c) - escaped * mean(i, c);
                    variance += escaped * (Bands::ONE - escaped / n);
                }
                covariance.zip_map(variance, ratio)
            };
            let blocks = blocks(groups);
            let values: Vec<Bands> = parallel::map(&blocks, of_group);
            for (group, value) in blocks.iter().zip(values) {
                group.iter().filter_map(|i| rays.row(*i as usize)).for_each(|row| list[row] = value);
            }
        }
        EscapeControl { rays, counts, coefficients }
    }

    /// The share a of the rays of zone `i` in its estimate.
    fn share(&self, i: usize, row: usize) -> f64 {
        let rays = f64::from(self.rays.counts[row]);
        rays / (self.counts[i].max(1) as f64 + rays)
    }

    /// The correction −c a (ē − ē') of the mean of half `half` of zone `i` and column `c`, W/m².
    pub(crate) fn correction(&self, i: usize, half: usize, c: usize) -> Bands {
        self.rays.row(i).map_or(Bands::ZERO, |row| self.coefficients[c][row] * self.excess(i, row, half))
    }

    /// The correction of the surroundings alone, of radiosity `sky`: that of their c, W/m².
    pub(crate) fn correction_of_part(&self, i: usize, half: usize, sky: Bands) -> Bands {
        self.rays.row(i).map_or(Bands::ZERO, |row| sky * self.excess(i, row, half))
    }

    /// −a (ē − ē').
    fn excess(&self, i: usize, row: usize, half: usize) -> Bands {
        let HalfOfRow { by_samples, by_rays } = self.rays.half(row, half, self.counts[i].max(1) as f64);
        (by_rays - by_samples) * self.share(i, row)
    }

    /// The variance of the mean of both halves of zone `i` by its samples with the rays, from the `variance` without them; `q` is a column, or the number of
    /// columns for their sum, whose mean is `mean`.
    pub(crate) fn variance(&self, i: usize, q: usize, [mean, variance]: [Bands; 2]) -> Bands {
        let Some(row) = self.rays.row(i) else { return variance };
        let columns = if q < self.rays.columns { q..q + 1 } else { 0..self.rays.columns };
        let n = 2.0 * self.counts[i].max(1) as f64;
        let (c, product) = columns.fold((Bands::ZERO, Bands::ZERO), |(c, product), k| {
            (c + self.coefficients[k][row], product + self.rays.sum(row, 4 + k))
        });
        let (a, rays) = (self.share(i, row), 2.0 * f64::from(self.rays.counts[row].max(1)));
        let by_samples = (self.rays.sum(row, 0) + self.rays.sum(row, 1)) / n;
        let of_escape = self.variance_of_escape(i, row);
        let weight = c * a;
        let covariance = product / n - mean * by_samples;
        // The variance of v − c a e by the same samples as that of v.
        let sampled_escape = by_samples * (Bands::ONE - by_samples).map(|x| x.max(0.0));
        let of_samples = (variance * n - 2.0 * weight * covariance + weight * weight * sampled_escape) / n;
        of_samples.map(|v| v.max(0.0)) + weight * weight * of_escape / rays
    }

    /// The upper bound ē (1 − ē) of the variance of the escape of zone `i`.
    fn variance_of_escape(&self, i: usize, row: usize) -> Bands {
        let [a, b] = [0, 1].map(|half| self.rays.half(row, half, self.counts[i].max(1) as f64));
        let share = self.share(i, row);
        let mean =
            0.5 * (a.by_samples + b.by_samples) * (1.0 - share) + 0.5 * (a.by_rays + b.by_rays) * share;
        mean * (Bands::ONE - mean).map(|x| x.max(0.0))
    }

    /// c² Var(e) of a sample of zone `i`, of the sum of the columns over the bands; 0 without rays.
    pub(crate) fn explained_variance(&self, i: usize) -> f64 {
        let Some(row) = self.rays.row(i) else { return 0.0 };
        let c: Bands = self.coefficients.iter().map(|list| list[row]).sum();
        (c * c * self.variance_of_escape(i, row)).sum()
    }

    /// The corrections of the means of both halves of quantity `q`, W/m².
    pub(crate) fn corrections(&self, i: usize, q: usize) -> [Bands; 2] {
        [0, 1].map(|half| {
            if q < self.rays.columns {
                self.correction(i, half, q)
            } else {
                (0..self.rays.columns).map(|c| self.correction(i, half, c)).sum()
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::low_discrepancy::hash_to_unit;

    /// Samples of 256 zones, v = 1 + 3 e + noise with e = 1 in four of ten cases, and 8 rays for each of 8 samples of a half.
    fn sampled(seed: u64) -> (EscapeRays, Vec<[f64; 2]>, Vec<f64>) {
        const ZONES: usize = 256;
        let groups = ZoneGroups::of_patches(ZONES);
        let mut rays = EscapeRays::new(&groups, &vec![0.4; ZONES], 1);
        let mut number = seed << 32;
        let mut uniform = || {
            number += 1;
            hash_to_unit(number)
        };
        let (mut sums, mut variances) = (Vec::new(), Vec::new());
        for (zone, mut rows) in rays.by_tasks(ZONES, 1).into_iter().enumerate() {
            let (mut of_zone, mut values) = (EscapeSums::new(1), [0.0; 2]);
            let wanted = rows.wanted(zone, 8).expect("zones see the surroundings");
            let mut squares = 0.0;
            for half in 0..2 {
                for _ in 0..8 {
                    let e = f64::from(u8::from(uniform() < 0.4));
                    let v = 1.0 + 3.0 * e + 0.2 * (uniform() - 0.5);
                    of_zone.by_samples[half] += Bands::splat(e);
                    of_zone.products[0] += Bands::splat(v * e);
                    values[half] += v / 8.0;
                    squares += v * v / 16.0;
                }
                of_zone.rays = wanted.len();
                let escaped = wanted.clone().filter(|_| uniform() < 0.4).count();
                of_zone.by_rays[half] = Bands::splat(escaped as f64);
            }
            rows.add(zone, &of_zone);
            variances.push((squares - (0.5 * (values[0] + values[1])).powi(2)) / 16.0);
            sums.push(values);
        }
        (rays, sums, variances)
    }

    #[test]
    fn escape_rays_keep_the_mean_and_state_the_variance() {
        let groups = ZoneGroups::of_patches(256);
        let (mut mean, mut square, mut stated, mut without) = (0.0, 0.0, 0.0, 0.0);
        for seed in 1..=16 {
            let (rays, sums, variances) = sampled(seed);
            let counts = vec![8; sums.len()];
            let of = |i: usize| 0.5 * (sums[i][0] + sums[i][1]);
            let control = EscapeControl::new(&rays, &counts, &groups, |i, _| Bands::splat(of(i)));
            for i in 0..sums.len() {
                let more = control.corrections(i, 1).map(|b| b.first());
                let value = of(i) + 0.5 * (more[0] + more[1]);
                mean += value - 2.2;
                square += (value - 2.2).powi(2);
                without += (of(i) - 2.2).powi(2);
                let moments = [of(i), variances[i]].map(Bands::splat);
                stated += control.variance(i, 0, moments).first();
            }
        }
        let n = 16.0 * 256.0;
        let (mean, square, stated, without) = (mean / n, square / n, stated / n, without / n);
        assert!(mean.abs() < 4.0 * (square / n).sqrt(), "bias {mean} of {}", square.sqrt());
        assert!(square < without / 5.0, "{square} {without}");
        assert!((stated / square - 1.0).abs() < 0.2, "{stated} {square}");
    }

    #[test]
    fn rays_follow_the_moments_of_their_group() {
        let groups = ZoneGroups::of_patches(128);
        let rays = EscapeRays::new(&groups, &vec![0.5; 128], 1);
        // √(4 · 0.8/0.2) = 4 rays where escape explains four fifths of the variance, none where it explains a tenth.
        let ratios = rays.ratios(&groups, |i| if i < 64 { [0.8, 1.0] } else { [0.1, 1.0] });
        assert_eq!((ratios[3], ratios[100]), (4, 0));
        let none = EscapeRays::new(&groups, &vec![0.0; 128], 1);
        assert!(none.ratios(&groups, |_| [1.0; 2]).is_empty());
    }
}
