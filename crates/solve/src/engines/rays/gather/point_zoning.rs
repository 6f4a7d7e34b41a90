//! The zoning error of direct light, and how samples read direct light.
//!
//! The mean C_i of the changes of zone i by direct light at points (`point_light`) is its error by direct light that is constant on zones. Every reflection
//! makes this error anew, so it also passes through the equations: with the exchange K of the stored rays and the responses r,
//!
//! ```text
//! δB = r (C + K δB)          E_i = C_i + (K δB)_i
//! ```
//!
//! With the two halves A and B of the samples, over the zones of a kind,
//!
//! ```text
//! z² = max(0, Σ E_A,i E_B,i) + √(Σ s_i⁴)          s_i² = (E_A,i − E_B,i)²/2
//! ```
//!
//! the squared zoning error from above: the noise drops out of the first sum, and the second is its variance where E is 0. After the first round z says
//! whether a kind of zones reads direct light at points. Where some kind does, δB is added to the radiosities that are read.

use super::gather_error::{EQUAL_WEIGHT_MULTIPLE, HalfProducts, ratio};
use super::gather_sums::{GatherSums, PointChanges};
use super::gather_task::{GatherTask, kind_of, ranges_of_kinds};
use super::zone_gather::{DirectReading, Gatherer};
use crate::settings::zone_power::fluence_factor;
use std::ops::Range;
use zonal_math::parallel;
use zonal_scene::{Bands, Zones};

/// Share of the tolerance above which the zoning error of direct light is removed.
const ZONING_SHARE: f64 = 0.3;

/// Noise of the incident radiation by that of the changes, over the tolerance, above which these are sampled further.
const MAX_NOISE_OF_CHANGES: f64 = 0.2;
/// Largest growth of their samples in one round, and their most samples of each half.
const MAX_GROWTH: f64 = 8.0;
const MAX_SAMPLES_OF_CHANGES: usize = 512;

/// False where light takes the place of direct light in its shadows, behind sheets that transmit. There the means of zones stay.
fn has_plain_shadows(zones: &Zones) -> bool {
    zones.sheets.is_empty()
}

/// C of column `c` by one half of the samples, W/m².
fn change(task: &GatherTask, sums: &GatherSums, half: usize, c: usize) -> Vec<Bands> {
    parallel::collect(task.zones.len(), |i| {
        let factor = fluence_factor(task.zones, i);
        factor * (sums.half(i, half, task.quantities() + c) - sums.half(i, half, c))
    })
}

/// Factor on the numbers of samples with which the changes are known well enough; `None` where they are, or have the most samples. `noise` is that of δB in
/// the incident radiation of the worst kind of zones, relative.
fn more_samples(task: &GatherTask, sums: &GatherSums, noise: f64) -> Option<usize> {
    if sums.counts.iter().any(|n| *n >= MAX_SAMPLES_OF_CHANGES) {
        return None;
    }
    let over = noise / (MAX_NOISE_OF_CHANGES * task.tolerance);
    (over > 1.0).then(|| (over * over).min(MAX_GROWTH).log2().ceil().exp2() as usize)
}

/// Decides by the samples so far how the zones of each kind read direct light. Returns the factor on their numbers where this takes more of them.
pub(crate) fn choose_readings(task: &GatherTask, sums: &mut GatherSums) -> Option<usize> {
    let (plain, groups, n) = (task.quantities(), task.groups, task.zones.len());
    let halves = |q: usize| [0, 1].map(|half| change(task, sums, half, q));
    let found = |q: usize| ZoningOfQuantity::of(task, sums, q, &halves(q));
    let of_sum = found(groups);
    let mut zoning: Vec<[Bands; 2]> = match groups {
        // A single column is the sum.
        1 => vec![of_sum.zoning],
        _ => (0..groups).map(|c| found(c).zoning).collect(),
    };
    zoning.push(of_sum.zoning);
    let reading = |kind: usize| {
        let of_columns = zoning[..groups].iter().map(|z| z[kind] / EQUAL_WEIGHT_MULTIPLE);
        let worst = of_columns.fold(zoning[groups][kind], Bands::max);
        if has_plain_shadows(task.zones) && worst.max_element() > ZONING_SHARE * task.tolerance {
            DirectReading::AtPoints
        } else {
            DirectReading::OfZones
        }
    };
    let direct = [0, 1].map(reading);
    let (mut columns, mut noise) = (Vec::new(), Vec::new());
    if direct.contains(&DirectReading::AtPoints) {
        if let Some(growth) = more_samples(task, sums, of_sum.noise) {
            return Some(growth);
        }
        columns = (0..groups)
            .map(|c| {
                let [a, b] = halves(c);
                parallel::collect(n, |i| 0.5 * (a[i] + b[i]))
            })
            .collect();
        let [a, b] = halves(groups);
        noise = parallel::collect(n, |i| 0.5 * (a[i] - b[i]));
    }
    sums.changes = Some(PointChanges { columns, noise, zoning });
    sums.keep_readings(|i| kind_of(task.zones, i), plain, direct);
    None
}

/// Sum of squares of the incident radiation of quantity `q` over a range of zones, W²/m⁴.
fn level(task: &GatherTask, sums: &GatherSums, q: usize, range: Range<usize>) -> Bands {
    let of_zone = |i: usize| {
        let known = if q == task.groups { task.known_radiation(i)[0] } else { Bands::ZERO };
        let v = fluence_factor(task.zones, i) * sums.mean(i, q) + known;
        v * v
    };
    range.map(of_zone).sum()
}

/// The zoning error of a quantity.
struct ZoningOfQuantity {
    /// z of the kinds of zones, over the root of the sum of squares of their incident radiation.
    zoning: [Bands; 2],
    /// Noise of the incident radiation by that of δB, over the same, of the worst kind and band.
    noise: f64,
}

impl ZoningOfQuantity {
    /// Of quantity `q` from its changes by both halves.
    fn of(task: &GatherTask, sums: &GatherSums, q: usize, changes: &[Vec<Bands>; 2]) -> ZoningOfQuantity {
        let passed_on = (task.passed_on)(changes);
        let mut worst_noise = 0.0f64;
        let zoning = ranges_of_kinds(task.zones).map(|range| {
            let (mut products, mut noise) = (HalfProducts::default(), Bands::ZERO);
            for i in range.clone() {
                let [further_a, further_b] = [0, 1].map(|half| passed_on[half].incident[i]);
                products.add(changes[0][i] + further_a, changes[1][i] + further_b);
                noise += 0.25 * (further_a - further_b) * (further_a - further_b);
            }
            let level = level(task, sums, q, range);
            worst_noise = worst_noise.max(noise.zip_map(level, ratio).sqrt().max_element());
            products.square_from_above(level).sqrt()
        });
        ZoningOfQuantity { zoning, noise: worst_noise }
    }
}

/// Adds δB of every column to the radiosities of a gather, and the noise of it to the column of noise.
pub(crate) fn add_changes(changes: &PointChanges, gatherer: &mut Gatherer, task: &GatherTask) {
    if changes.columns.is_empty() {
        return;
    }
    let mut all = changes.columns.clone();
    all.push(changes.noise.clone());
    for (c, passed_on) in (task.passed_on)(&all).into_iter().enumerate() {
        gatherer.add_radiosity(c, &passed_on.radiosity);
    }
}
