//! The final gather: rounds of samples for every zone, until the estimated error meets the tolerance.
//!
//! The first round takes as many samples of every patch, and half as many of every volume zone. Each further round reduces the error by at most a given factor. Its samples go where they
//! reduce the relative error of the field most: with the standard deviation σ_i of one sample of zone i,
//!
//! ```text
//! Σ e_i² = Σ σ_i²/n_i → min at given Σ n_i        ⇒        n_i ∝ σ_i
//! ```
//!
//! among the patches, and among the volume zones, each until they meet the tolerance; rounded to powers of two, since the sequences are balanced there, and never fewer than before.

use super::escape_rays::{EscapeRays, EscapeSums};
use super::gather_error::{EQUAL_WEIGHT_MULTIPLE, ratio};
use super::gather_sums::GatherSums;
use super::gather_task::{GatherTask, kind_of, ranges_of_kinds};
use super::gathered_fields::GatheredFields;
use super::point_zoning;
use super::zone_gather::{DirectReading, GatherScratch, GatheredSky, Gatherer, SampleRange, SampleSums};
use crate::engines::rays::stored_rays::padded_bands::widened;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::ops::Range;
use zonal_math::parallel;
use zonal_scene::{Band, Bands, ErrorParts, Zones};

// Numbers of samples and the steps of their growth.

/// Samples of each half of a patch, of a volume zone in the medium, and of a pane, in the first round.
const FIRST_SAMPLES: [usize; 3] = [8, 4, 32];
/// Most samples of each half of a zone.
const MAX_SAMPLES: usize = 1 << 15;
/// Most rounds.
const MAX_ROUNDS: usize = 10;
/// Variance falls as the number of samples to the power of this.
const VARIANCE_EXPONENT: f64 = 1.15;
/// Most samples of a zone over the mean number that a round would give every zone.
const MAX_OVER_MEAN: f64 = 4.0;
/// Largest growth of the mean number of samples in a round.
const MAX_GROWTH: f64 = 8.0;
/// Share of the tolerance that the noise of the gather aims at.
const NOISE_SHARE: f64 = 0.85;
/// Least share that remains for the noise where other errors are large.
const MIN_NOISE_SHARE: f64 = 0.4;
/// Noise over the other errors where these alone exceed the tolerance: less noise would change little.
const NOISE_OVER_LARGE_ERRORS: f64 = 0.6;
/// Samples of a zone for each node of its cut, and the least and most nodes.
const SAMPLES_PER_CUT_NODE: usize = 1;
const CUT_NODES: [usize; 2] = [64, 256];

/// Expected samples of a zone for a tolerance: the geometric mean over rooms with and without obstacles, models, the small church and Sponza at
/// tolerances of 0.01 to 0.1. Single scenes differ by a factor of five.
pub(crate) fn expected_samples(tolerance: f64) -> f64 {
    tolerance.powf(-1.6).clamp(2.0 * FIRST_SAMPLES[1] as f64, 2.0 * MAX_SAMPLES as f64)
}

/// Zones of one task.
const ZONES_PER_TASK: usize = 16;
/// Tasks that one thread takes at a time: rounds may have samples in few places.
const TASKS_AT_A_TIME: usize = 16;
/// Volume zones in a row whose connections are aimed together.
const VOXELS_AIMED_TOGETHER: usize = 8;

/// The result of a gather.
pub(crate) struct Gathered {
    /// H or G of every light group without the surroundings themselves, W/m².
    pub columns: Vec<Vec<Bands>>,
    /// H or G of the surroundings themselves, where the gather samples them, W/m²; otherwise empty. Its error is in that of the groups.
    pub sky: Vec<Bands>,
    /// Stated error of each group, W/m².
    pub column_errors: Vec<Vec<Bands>>,
    /// Stated error of their sum, W/m².
    pub error: Vec<Bands>,
    /// Relative error of the sum, or of an equally weighted sum over its multiple, the larger; without the error of the surroundings.
    pub relative_error: f64,
    /// The parts of the error of the patches, and of the volume zones and panes.
    pub parts: [ErrorParts; 2],
    /// Samples of all zones.
    pub samples: u64,
    /// Rays that only found out whether they leave the scene.
    escape_rays: u64,
}

impl Gathered {
    /// The result of the last round.
    fn new(task: &GatherTask, fields: GatheredFields, goal: &Goal, sums: &GatherSums) -> Gathered {
        let GatheredFields { mut values, mut errors, inherited, mut sky, .. } = fields;
        // The error by zoning is in proportion to the field.
        let zoning = |q: usize, i: usize| {
            let left = sums.changes.as_ref().map(|c| c.zoning_left(q, sums.direct)[kind_of(task.zones, i)]);
            left.unwrap_or_default()
        };
        let mut error = errors.pop().unwrap_or_default();
        let sum = values.pop().unwrap_or_default();
        parallel::for_each(&mut error, |i, e| {
            let of_zones = zoning(task.groups, i) * (sum[i] + task.known_radiation(i)[0]);
            let inherited = inherited.get(i).copied().unwrap_or_default();
            *e = e.hypot(inherited).hypot(of_zones).hypot(task.error_by_thickness(i));
        });
        // Each group inherits its share of the errors of the radiosities.
        for (q, (errors, column)) in errors.iter_mut().zip(&values).enumerate() {
            parallel::for_each(errors, |i, e| {
                let common = inherited.get(i).copied().unwrap_or_default().hypot(task.error_by_thickness(i));
                let share = column[i].zip_map(sum[i], ratio);
                *e = e.hypot(common * share).hypot(zoning(q, i) * column[i]);
            });
        }
        if let Some(of_sky) = task.sky {
            separate(&mut values[of_sky.column], &mut sky);
        }
        Gathered {
            columns: values,
            sky,
            column_errors: errors,
            error,
            parts: goal.parts,
            relative_error: goal
                .parts
                .iter()
                .map(|p| p.sampling.hypot(p.radiosities).hypot(p.zoning))
                .fold(0.0, f64::max),
            samples: 2 * sums.counts.iter().map(|c| *c as u64).sum::<u64>(),
            escape_rays: sums.escape.total(),
        }
    }

    /// Rays that may have left the scene.
    pub(crate) fn rays(&self) -> u64 {
        self.samples + self.escape_rays
    }
}

/// Gathers until the tolerance is met, or the samples are at their maximum.
pub(crate) fn gather(mut gatherer: Gatherer, task: &GatherTask) -> Gathered {
    let of_sky = |sky: &GatheredSky| EscapeRays::new(task.zone_groups, &sky.shares, task.groups);
    let escape = task.sky.map(of_sky).unwrap_or_default();
    let mut sums = GatherSums::load(task, escape);
    if sums.round == 0 {
        take_first_samples(&mut gatherer, task, &mut sums);
    } else if let Some(changes) = &sums.changes {
        point_zoning::add_changes(changes, &mut gatherer, task);
    }
    let gatherer = &gatherer;
    let mut fields = GatheredFields::new(task);
    let mut changed = [true; 2];
    let goal = loop {
        fields.update(gatherer, task, &sums, changed);
        sums.escape.rays_per_sample = std::mem::take(&mut fields.escape_ratios);
        let goal = Goal::of(task, &fields, &sums);
        let more = goal.samples(task, &sums, &fields);
        match more.filter(|_| sums.round < MAX_ROUNDS && !task.execution.progress.is_interrupted()) {
            Some(wanted) => {
                changed = ranges_of_kinds(task.zones).map(|r| wanted[r.clone()] != sums.counts[r]);
                take_samples(gatherer, task, &wanted, &mut sums);
                save(task, &sums);
            }
            None => break goal,
        }
    };
    Gathered::new(task, fields, &goal, &sums)
}

/// Takes a part out of a field. Noise may raise the part over the whole.
fn separate(whole: &mut [Bands], part: &mut [Bands]) {
    parallel::for_each_pair(part, whole, |part, whole| *part = part.min(*whole));
    parallel::for_each_pair(whole, part, |whole, part| *whole -= *part);
}

/// Takes the first samples. Where direct light can be read at points they have both readings, and decide how further samples read it.
fn take_first_samples(gatherer: &mut Gatherer, task: &GatherTask, sums: &mut GatherSums) {
    let first = |i: usize| FIRST_SAMPLES[task.zones.kind(i) as usize];
    let wanted: Vec<usize> = (0..task.zones.len()).map(first).collect();
    if !gatherer.can_read_points() {
        take_samples(gatherer, task, &wanted, sums);
        return save(task, sums);
    }
    sums.direct = [DirectReading::AtPoints; 2];
    sums.begin(task.quantities() + task.groups + 1);
    take_samples(gatherer, task, &wanted, sums);
    let mut more = wanted.clone();
    while let Some(growth) = point_zoning::choose_readings(task, sums) {
        if task.execution.progress.is_interrupted() {
            return;
        }
        more.iter_mut().for_each(|n| *n *= growth);
        take_samples(gatherer, task, &more, sums);
    }
    if let Some(changes) = sums.changes.take_if(|c| !c.columns.is_empty()) {
        // The samples so far are those of other radiosities.
        point_zoning::add_changes(&changes, gatherer, task);
        sums.begin(task.quantities());
        sums.changes = Some(changes);
        take_samples(gatherer, task, &wanted, sums);
    }
    save(task, sums);
}

/// Saves a round; an interrupted one lacks samples.
fn save(task: &GatherTask, sums: &GatherSums) {
    if !task.execution.progress.is_interrupted() {
        sums.save(task.checkpoints);
    }
}

/// Takes samples of every zone up to the wanted number of each half.
fn take_samples(gatherer: &Gatherer, task: &GatherTask, wanted: &[usize], sums: &mut GatherSums) {
    let (quantities, direct) = (sums.quantities, sums.direct);
    let (progress, communicator) = (task.execution.progress, task.execution.communicator);
    progress.begin("gather", task.zones.len() as u64);
    let blocks = task.execution.blocks(task.zones.len(), ZONES_PER_TASK);
    let before = sums.counts.clone();
    let tasks = sums
        .sums
        .par_chunks_mut(2 * quantities * ZONES_PER_TASK)
        .zip(sums.counts.par_chunks_mut(ZONES_PER_TASK))
        .zip(sums.escape.by_tasks(task.zones.len(), ZONES_PER_TASK))
        .enumerate()
        .with_max_len(TASKS_AT_A_TIME);
    let own = tasks.filter(|(number, _)| blocks.is_own_block(*number));
    own.for_each_init(GatherScratch::default, |scratch, (number, ((sums, counts), mut escape))| {
        if progress.is_interrupted() {
            return;
        }
        let zones = counts.len() as u64;
        let mut aimed = 0..0;
        for (k, (sums, count)) in sums.chunks_mut(2 * quantities).zip(counts).enumerate() {
            let zone = number * ZONES_PER_TASK + k;
            let numbers = *count..wanted[zone].max(*count);
            if numbers.is_empty() {
                continue;
            }
            if !aimed.contains(&zone) {
                aimed = aimed_together(task.zones, zone);
                gatherer.aim(aimed.clone(), cut_nodes(numbers.len()), scratch);
            }
            let rays = escape.wanted(zone, numbers.end);
            *count = numbers.end;
            let mut of_zone = EscapeSums::new(task.groups);
            let samples = SampleRange { zone, half: 0, numbers, direct: direct[kind_of(task.zones, zone)] };
            add_samples_of_zone(gatherer, task, &samples, rays, scratch, sums, &mut of_zone);
            escape.add(zone, &of_zone);
        }
        progress.advance(zones);
    });
    sums.exchange(&blocks, communicator, &before, wanted);
    progress.end();
    sums.round += 1;
}

/// Adds the samples of these numbers of both halves of a zone, and the rays that only find out whether they leave the scene.
fn add_samples_of_zone(
    gatherer: &Gatherer,
    task: &GatherTask,
    samples: &SampleRange,
    rays: Option<Range<usize>>,
    scratch: &mut GatherScratch,
    sums: &mut [SampleSums],
    escape: &mut EscapeSums,
) {
    let quantities = sums.len() / 2;
    for (half, sums) in sums.chunks_mut(quantities).enumerate() {
        let range = SampleRange { half, ..samples.clone() };
        escape.by_samples[half] =
            add_samples(gatherer, task, range.clone(), scratch, sums, &mut escape.products);
        if let Some(numbers) = rays.clone() {
            escape.rays = numbers.len();
            escape.by_rays[half] = gatherer.escapes(SampleRange { numbers, ..range }, scratch);
        }
    }
}

/// Nodes of the cut of a zone that is to take `samples` samples of each half.
fn cut_nodes(samples: usize) -> usize {
    let [least, most] = CUT_NODES;
    (2 * samples / SAMPLES_PER_CUT_NODE).clamp(least, most)
}

/// The zones whose connections are aimed with those of zone `i`, from it on. The result depends on the zones alone.
fn aimed_together(zones: &Zones, i: usize) -> Range<usize> {
    let [_, volumes, _] = zones.ranges_of_kinds();
    if !volumes.contains(&i) {
        return i..i + 1;
    }
    let end = (i / VOXELS_AIMED_TOGETHER + 1) * VOXELS_AIMED_TOGETHER;
    i..end.min(volumes.end)
}

/// Adds the samples of one half of a zone to its sums, and the products of every column with the escape of the rays to `products`; returns the sum of the
/// latter.
fn add_samples(
    gatherer: &Gatherer,
    task: &GatherTask,
    range: SampleRange,
    scratch: &mut GatherScratch,
    sums: &mut [SampleSums],
    products: &mut [Bands],
) -> Bands {
    let (groups, plain) = (task.groups, task.quantities());
    let (mut added, mut escapes) = (vec![[Bands::ZERO; 2]; sums.len()], Bands::ZERO);
    // In the first round the values with direct light at points are quantities of their own, after the others.
    let at_points = range.direct == DirectReading::AtPoints;
    let both = added.len() > plain;
    let mut add = |q: usize, v: Bands| {
        added[q][0] += v;
        added[q][1] += v * v;
    };
    gatherer.samples(range, scratch, |sample| {
        let (sky, mut all, mut all_at_points) = (sample.sky(), Bands::ZERO, Bands::ZERO);
        for (c, product) in products.iter_mut().enumerate() {
            let mut v = widened(sample.value(c));
            if at_points {
                let changed = v + widened(sample.change(c));
                if both {
                    add(plain + c, changed);
                    all_at_points += changed;
                } else {
                    v = changed;
                }
            }
            add(c, v);
            all += v;
            *product += v * sky.escaped;
        }
        add(groups, all);
        if both {
            add(plain + groups, all_at_points);
        }
        add(groups + 1, widened(sample.value(groups)));
        if task.sky.is_some() {
            add(groups + 2, sky.radiosity);
        }
        escapes += sky.escaped;
    });
    sums.iter_mut().zip(added).for_each(|(s, a)| s.add(a));
    escapes
}

/// Root mean square of a field over a range of zones.
fn root_mean_square(range: Range<usize>, field: impl Fn(usize) -> Bands) -> Bands {
    let count = range.len().max(1) as f64;
    (range.fold(Bands::ZERO, |sum, i| sum + field(i) * field(i)) / count).sqrt()
}

/// Root mean square of quantity `q` over each kind of zones, with the known radiation in the sum of the groups.
fn levels(task: &GatherTask, fields: &GatheredFields, q: usize) -> [Bands; 2] {
    ranges_of_kinds(task.zones).map(|range| {
        let more = |i: usize| if q == task.groups { task.known_radiation(i)[0] } else { Bands::ZERO };
        let of_samples = root_mean_square(range.clone(), |i| fields.values[q][i] + more(i));
        if of_samples.iter().all(|s| *s > 0.0) {
            return of_samples;
        }
        let unmet = root_mean_square(range, |i| fields.unmet.level(q, i));
        of_samples.zip_map(unmet, |met, unmet| if met > 0.0 { met } else { unmet })
    })
}

/// The errors of a round and what they should become, of patches and of volume zones.
struct Goal {
    /// The parts of the relative error; that of sampling is the larger of that of the sum, and of an equally weighted sum over its multiple.
    parts: [ErrorParts; 2],
    /// The relative noise wanted.
    wanted: [f64; 2],
    /// Root mean square of each quantity and kind of zones, per band.
    levels: Vec<[Bands; 2]>,
}

impl Goal {
    fn of(task: &GatherTask, fields: &GatheredFields, sums: &GatherSums) -> Goal {
        let ranges = ranges_of_kinds(task.zones);
        let levels: Vec<[Bands; 2]> = (0..task.groups + 1).map(|q| levels(task, fields, q)).collect();
        let relative = |error: &dyn Fn(usize) -> Bands, level: [Bands; 2]| {
            [0, 1].map(|kind| {
                let rms = root_mean_square(ranges[kind].clone(), error);
                rms.zip_map(level[kind], ratio).max_element()
            })
        };
        let all = levels[task.groups];
        let sum = relative(&|i| fields.errors[task.groups][i], all);
        let guide = match task.groups {
            1 => [0.0; 2],
            _ => equal_weight_error(task, fields, &levels).map(|e| e / EQUAL_WEIGHT_MULTIPLE),
        };
        let inherited = relative(&|i| fields.inherited[i], all);
        let surroundings = relative(&|i| task.known_radiation(i)[1], all);
        let found = sums.changes.as_ref().map_or([Bands::ZERO; 2], |c| c.zoning[task.groups]);
        let zoning_of = |reading: DirectReading| {
            [0, 1].map(|kind| if sums.direct[kind] == reading { found[kind].max_element() } else { 0.0 })
        };
        let thickness = relative(&|i| task.error_by_thickness(i), all);
        let [zoning, removed] = [DirectReading::OfZones, DirectReading::AtPoints].map(zoning_of);
        let parts = [0, 1].map(|kind| ErrorParts {
            sampling: sum[kind].max(guide[kind]),
            radiosities: inherited[kind],
            direct: surroundings[kind],
            zoning: zoning[kind].hypot(thickness[kind]),
            zoning_removed: removed[kind],
        });
        let wanted = |part: ErrorParts| {
            let others = part.radiosities.hypot(part.direct) / task.tolerance;
            let left = (1.0 - others * others).max(0.0).sqrt().max(MIN_NOISE_SHARE);
            let beside_others = if others > 1.0 { NOISE_OVER_LARGE_ERRORS * others } else { 0.0 };
            (NOISE_SHARE * left).max(beside_others) * task.tolerance
        };
        Goal { parts, wanted: parts.map(wanted), levels }
    }

    /// The samples of each half of every zone in the next round; `None` where the goal is met or nothing can be added.
    fn samples(&self, task: &GatherTask, sums: &GatherSums, fields: &GatheredFields) -> Option<Vec<usize>> {
        let zones = task.zones;
        let n = zones.len();
        // σ of one sample over the level, of the sum and of the equally weighted sum.
        let deviation = |i: usize| {
            let kind = kind_of(zones, i);
            let relative = |q: usize| {
                let (e, level) = (fields.errors[q][i], self.levels[q][kind]);
                Band::all().filter(|&b| level[b] > 0.0).fold(0.0f64, |m, b| m.max(e[b] / level[b]))
            };
            let worst = match task.groups {
                1 => relative(1),
                g => (0..g).map(relative).sum::<f64>().max(relative(g)),
            };
            worst * (sums.counts[i] as f64).powf(0.5 * VARIANCE_EXPONENT)
        };
        let deviations: Vec<f64> = parallel::collect(n, deviation);
        let (mut wanted, mut added) = (sums.counts.clone(), 0);
        for (kind, range) in ranges_of_kinds(zones).into_iter().enumerate() {
            // A kind that meets its goal keeps its samples.
            let over = self.parts[kind].sampling / self.wanted[kind];
            if over.partial_cmp(&1.0) != Some(Ordering::Greater) || over.is_infinite() {
                continue;
            }
            let counts = &sums.counts[range.clone()];
            let allocation = Allocation { deviations: &deviations[range.clone()], counts };
            let numbers = allocation.reducing_error(1.0 / over);
            added += numbers.iter().zip(counts).map(|(w, c)| w - c).sum::<usize>();
            wanted[range].copy_from_slice(&numbers);
        }
        (added > 0).then_some(wanted)
    }
}

/// Samples of the zones of one kind by their need.
struct Allocation<'a> {
    /// σ of one sample of each zone.
    deviations: &'a [f64],
    /// Samples of each half so far.
    counts: &'a [usize],
}

impl Allocation<'_> {
    /// Samples of each half with which the error falls to `wanted` of the present one, or comes as close to it as the limits of one round let it.
    fn reducing_error(&self, wanted: f64) -> Vec<usize> {
        let now = self.squared_error(self.counts);
        // Growths in steps of an eighth of an octave, the least that suffices by bisection.
        let numbers = |step: u32| self.grown((f64::from(step) / 8.0).exp2());
        let suffices = |n: &[usize]| self.squared_error(n) <= wanted * wanted * now;
        let (mut low, mut high) = (1, (8.0 * MAX_GROWTH.log2()) as u32);
        while high > low + 1 {
            let middle = u32::midpoint(low, high);
            if suffices(&numbers(middle)) {
                high = middle;
            } else {
                low = middle;
            }
        }
        numbers(high)
    }

    fn squared_error(&self, counts: &[usize]) -> f64 {
        let of = |(s, c): (&f64, &usize)| s * s / (*c as f64).powf(VARIANCE_EXPONENT);
        self.deviations.iter().zip(counts).map(of).sum()
    }

    /// Samples that are `growth` times as many in all, in proportion to the deviations.
    fn grown(&self, growth: f64) -> Vec<usize> {
        let all = growth * self.counts.iter().map(|c| *c as f64).sum::<f64>();
        let (mean, sum) = (all / self.counts.len().max(1) as f64, self.deviations.iter().sum::<f64>());
        let number = |(deviation, count): (&f64, &usize)| {
            let share = if sum > 0.0 { all * deviation / sum } else { mean };
            let share = share.min(MAX_OVER_MEAN * mean).clamp(2.0, MAX_SAMPLES as f64);
            let power = 1usize << (share.log2().round() as u32);
            power.min(MAX_SAMPLES).max(*count)
        };
        self.deviations.iter().zip(self.counts).map(number).collect()
    }
}

/// Relative error of a combination of the groups in which all have the same weight, for patches and for volume zones.
fn equal_weight_error(task: &GatherTask, fields: &GatheredFields, levels: &[[Bands; 2]]) -> [f64; 2] {
    let zones = task.zones;
    let ranges = ranges_of_kinds(zones);
    let mut worst = [0.0f64; 2];
    for (kind, range) in ranges.into_iter().enumerate() {
        for b in Band::all() {
            let weight = |q: usize| {
                let level = levels[q][kind][b];
                if level > 0.0 { 1.0 / level } else { 0.0 }
            };
            let weights: Vec<f64> = (0..task.groups).map(weight).collect();
            let (mut errors, mut values) = (0.0, 0.0);
            for i in range.clone() {
                let combined = |list: &[Vec<Bands>]| {
                    weights.iter().zip(list).map(|(w, column)| w * column[i][b]).sum::<f64>()
                };
                errors += combined(&fields.errors).powi(2);
                values += combined(&fields.values).powi(2);
            }
            if values > 0.0 {
                worst[kind] = worst[kind].max((errors / values).sqrt());
            }
        }
    }
    worst
}
