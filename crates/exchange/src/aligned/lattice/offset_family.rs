//! Values and radii of a family of pairs that differ in their offset alone, eight at a time.
//!
//! A batch takes the cheapest method that is proved for **all** of its offsets: the moments' series (κ = 0), else Gauss rules of
//! the density. Offsets nearer than D/[`moment_series::MAX_SIZE_OVER_DISTANCE`], and entries whose radius exceeds the tolerance, are computed as
//! single pairs (`method_selection.rs`).

use super::offset_index::OffsetIndex;
use crate::Method;
use crate::aligned::cell_integration;
use crate::aligned::cube_series::{self, CubeSeries};
use crate::aligned::density_rules::{DensityFamily, PlanHint};
use crate::aligned::method_selection::{self, FINEST_TOLERANCE, TRUNCATION_SHARE};
use crate::aligned::moment_series::{self, BoxPairMoments, FarPairs};
use crate::aligned::reduced_pair::{AxisDensity, ReducedPair};
use rayon::prelude::*;
use zonal_math::simd::{self, LANES};

/// Entries of a table by the method that served them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MethodCounts {
    /// By the moments' series.
    pub moments: usize,
    /// By the closed form of two rectangles.
    pub closed: usize,
    /// By Gauss rules.
    pub gauss: usize,
    /// By pyramid coordinates.
    pub pyramid: usize,
    /// By sums of Gaussians.
    pub gaussians: usize,
    /// Patches that are not visible from each other.
    pub unseen: usize,
}

zonal_math::counters!(MethodCounts of usize: moments, closed, gauss, pyramid, gaussians, unseen);

impl MethodCounts {
    /// The sum over the methods.
    pub fn total(&self) -> usize {
        self.numbers().iter().sum()
    }
    fn count(&mut self, method: Method, n: usize) {
        *match method {
            Method::Moments => &mut self.moments,
            Method::ClosedForm => &mut self.closed,
            Method::Pyramid => &mut self.pyramid,
            Method::NotVisible => &mut self.unseen,
            _ => &mut self.gauss,
        } += n;
    }
}

/// Entries per parallel task, in whole batches.
pub(super) const OFFSETS_PER_CHUNK: usize = 512 * LANES;

/// Pairs of boxes whose centre offsets are (i + shift) · step.
pub(super) struct OffsetFamily {
    extents: [(f64, f64); 3],
    step: [f64; 3],
    shift: [f64; 3],
    kappa: f64,
    tolerance: f64,
    moments: BoxPairMoments,
    densities: DensityFamily,
    /// The edge where all boxes are equal cubes without a medium, with the series' constants.
    cube: Option<(f64, &'static CubeSeries)>,
    /// Least squared distance of a batch, m².
    far2: f64,
}

/// Values and radii of a list of offsets, with the counts of methods.
struct FilledEntries<'a> {
    values: &'a mut [f64],
    radii: &'a mut [f64],
    counts: &'a mut MethodCounts,
}

/// A list of offsets to fill.
struct FillWork<'a> {
    family: &'a OffsetFamily,
    offsets: &'a [[u16; 3]],
    entries: FilledEntries<'a>,
}

/// The values and radii of a batch, and the method that served it.
type ServedBatch = ([f64; LANES], [f64; LANES], Method);

impl simd::SimdKernel for FillWork<'_> {
    type Output = ();
    #[inline(always)]
    fn evaluate(self) {
        self.family.fill_batches(self.offsets, self.entries);
    }
}

impl OffsetFamily {
    /// Boxes of these extents per axis (equal, or one or both zero), m.
    pub(super) fn new(
        extents: [(f64, f64); 3],
        step: [f64; 3],
        shift: [f64; 3],
        kappa: f64,
        tolerance: f64,
    ) -> OffsetFamily {
        assert!(step.iter().all(|e| *e > 0.0 && e.is_finite()), "edges {step:?}");
        assert!(kappa >= 0.0 && kappa.is_finite(), "extinction {kappa} 1/m");
        assert!(tolerance > 0.0, "tolerance {tolerance}");
        let moments = BoxPairMoments::new(extents);
        let far2 = moments.least_distance().powi(2) * (1.0 + 1e-9);
        let tolerance = tolerance.clamp(FINEST_TOLERANCE, 0.1);
        let edge = extents[0].0;
        let cubes = kappa == 0.0 && extents == [(edge, edge); 3];
        let cube = cubes.then(|| (edge, cube_series::constants()));
        let grid = DensityFamily::new(extents, kappa);
        OffsetFamily { extents, step, shift, kappa, tolerance, moments, densities: grid, cube, far2 }
    }

    /// The reduced pair at an offset.
    fn pair(&self, offset: [u16; 3]) -> ReducedPair {
        ReducedPair(std::array::from_fn(|k| {
            let at = |d: f64| (offset[k] as f64 + self.shift[k] + d) * self.step[k];
            let (long, short) = self.extents[k];
            let p = if long > 0.0 && short > 0.0 {
                [at(-1.0), at(0.0), at(0.0), at(1.0)]
            } else if long > 0.0 {
                [at(-0.5), at(-0.5), at(0.5), at(0.5)]
            } else {
                [at(0.0); 4]
            };
            AxisDensity { long, short, p }
        }))
    }

    /// All offsets of an index on rayon's threads.
    pub(super) fn fill_parallel(&self, index: &OffsetIndex) -> (Vec<f64>, Vec<f64>, MethodCounts) {
        let (mut values, mut radii) = (vec![0.0; index.len()], vec![0.0; index.len()]);
        let counts = values
            .par_chunks_mut(OFFSETS_PER_CHUNK)
            .zip(radii.par_chunks_mut(OFFSETS_PER_CHUNK))
            .enumerate()
            .map(|(k, (v, r))| {
                let first = k * OFFSETS_PER_CHUNK;
                self.fill(&index.offsets(first..first + v.len()), v, r)
            })
            .reduce(MethodCounts::default, |mut sum, more| {
                sum.merge(more);
                sum
            });
        (values, radii, counts)
    }

    /// All offsets on this thread.
    pub(super) fn fill(&self, offsets: &[[u16; 3]], values: &mut [f64], radii: &mut [f64]) -> MethodCounts {
        let mut counts = MethodCounts::default();
        let entries = FilledEntries { values, radii, counts: &mut counts };
        simd::run(FillWork { family: self, offsets, entries });
        counts
    }

    #[inline(always)]
    fn fill_batches(&self, offsets: &[[u16; 3]], entries: FilledEntries) {
        let FilledEntries { values, radii, counts } = entries;
        let mut hint = PlanHint::default();
        for (i, o) in offsets.chunks(LANES).enumerate() {
            let lanes = i * LANES..i * LANES + o.len();
            let (values, radii) = (&mut values[lanes.clone()], &mut radii[lanes]);
            self.fill_batch(o, FilledEntries { values, radii, counts: &mut *counts }, &mut hint);
        }
    }

    #[inline(always)]
    fn fill_batch(&self, offsets: &[[u16; 3]], entries: FilledEntries, hint: &mut PlanHint) {
        let mut centre = [[0.0; LANES]; 3];
        // The last batch of a chunk repeats its first offset.
        let mut padded = [offsets[0]; LANES];
        padded[..offsets.len()].copy_from_slice(offsets);
        for k in 0..3 {
            for l in 0..LANES {
                centre[k][l] = (padded[l][k] as f64 + self.shift[k]) * self.step[k];
            }
        }
        let mut nearest = f64::INFINITY;
        let mut r2 = [0.0; LANES];
        for l in 0..LANES {
            r2[l] = centre[0][l] * centre[0][l] + centre[1][l] * centre[1][l] + centre[2][l] * centre[2][l];
            nearest = if r2[l] < nearest { r2[l] } else { nearest };
        }
        if nearest < self.far2 {
            return self.fill_mixed_batch(offsets, centre, r2, entries);
        }
        self.write_batch(offsets, self.serve_batch(&centre, nearest, hint), [true; LANES], entries);
    }

    /// A batch with near offsets, whose lanes repeat a far offset of the batch.
    #[inline(never)]
    fn fill_mixed_batch(
        &self,
        offsets: &[[u16; 3]],
        mut centre: [[f64; LANES]; 3],
        r2: [f64; LANES],
        entries: FilledEntries,
    ) {
        let far = r2.map(|r2| r2 >= self.far2);
        let mut served = None;
        if let Some(some) = (0..LANES).find(|&l| far[l]) {
            for l in (0..LANES).filter(|&l| !far[l]) {
                for k in 0..3 {
                    centre[k][l] = centre[k][some];
                }
            }
            let nearest = (0..LANES).filter(|&l| far[l]).map(|l| r2[l]).fold(f64::INFINITY, f64::min);
            served = self.serve_batch(&centre, nearest, &mut PlanHint::default());
        }
        self.write_batch(offsets, served, far, entries);
    }

    /// Writes the entries that meet the tolerance; every other entry is computed as a single pair.
    #[inline(always)]
    fn write_batch(
        &self,
        offsets: &[[u16; 3]],
        served: Option<ServedBatch>,
        far: [bool; LANES],
        entries: FilledEntries,
    ) {
        let FilledEntries { values, radii, counts } = entries;
        let n = offsets.len();
        let mut good = [false; LANES];
        let mut count = 0;
        if let Some((value, radius, method)) = &served {
            for l in 0..LANES {
                good[l] = far[l]
                    & (radius[l] <= self.tolerance * value[l])
                    & (value[l] > cell_integration::MIN_SAFE_VALUE);
            }
            for l in 0..n {
                (values[l], radii[l]) = (value[l], radius[l]);
                count += good[l] as usize;
            }
            counts.count(*method, count);
        }
        if count < n {
            for l in (0..n).filter(|&l| !good[l]) {
                (values[l], radii[l]) = self.fill_single(offsets[l], counts);
            }
        }
    }

    /// The cheapest method that is proved for the whole batch; `nearest` its least squared distance, m².
    #[inline(always)]
    fn serve_batch(
        &self,
        centre: &[[f64; LANES]; 3],
        nearest: f64,
        hint: &mut PlanHint,
    ) -> Option<ServedBatch> {
        if let Some((edge, constants)) = self.cube {
            if let Some(order) = constants.order(edge * edge / nearest, TRUNCATION_SHARE * self.tolerance) {
                let (value, radius) = constants.factors(order, edge, centre);
                return Some((value, radius, Method::Moments));
            }
        } else if self.kappa == 0.0 {
            let far = FarPairs::new(&self.moments, centre);
            if let Some((order, left)) =
                moment_series::order(&self.moments, &far, TRUNCATION_SHARE * self.tolerance)
            {
                let (value, radius) = far.finish(&self.moments, order, &left);
                return Some((value, radius, Method::Moments));
            }
        }
        let plan = self.densities.plan_near(centre, TRUNCATION_SHARE * self.tolerance, hint)?;
        let (value, radius) = self.densities.integrate(centre, &plan);
        Some((value, radius, Method::Gauss))
    }

    #[inline(never)]
    fn fill_single(&self, offset: [u16; 3], counts: &mut MethodCounts) -> (f64, f64) {
        let pair = self.pair(offset);
        let f = if pair.is_visible() {
            method_selection::factor_of(&pair, self.kappa, self.tolerance)
        } else {
            crate::Factor::NOT_VISIBLE
        };
        counts.count(f.method, 1);
        (f.bounded.value, f.bounded.radius)
    }
}
