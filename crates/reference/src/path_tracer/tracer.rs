//! Readings of detectors by path tracing.
//!
//! A reading is the mean over [`REPLICATE_COUNT`] independent replicates of equally many paths; their spread gives the standard
//! error. Within a replicate the first [`SPREAD_DIMENSIONS`] numbers of the paths form a rank-1 lattice (Roberts 2018) with a random
//! shift. A pilot run of each detector sets the number of paths of its final run.

use super::detector::Detector;
use super::flight::RayScene;
use super::light_sampling::LightSet;
use super::path::{PathNumbers, PathRadiance, PathSampler};
use crate::estimate::{SampleEstimate, SampleStatistics};
use crate::rng::{Rng, hash};
use std::f64::consts::PI;
use zonal_math::parallel;
use zonal_scene::{Band, Bands, PerBand, Scene};

/// Independent replicates of a mean: their spread gives its standard error to about nine per cent.
const REPLICATE_COUNT: usize = 64;
/// Paths of the pilot run in each replicate.
const PILOT_PATHS: usize = 48;
/// Factor on the number of paths that the pilot run requests, for the uncertainty of its error.
const PATH_COUNT_MARGIN: f64 = 1.2;
/// Numbers of a path that are evenly distributed over the paths of a replicate.
const SPREAD_DIMENSIONS: usize = 9;

/// Requested accuracy of readings.
#[derive(Clone, Copy, Debug)]
pub struct TracingAccuracy {
    /// Standard error, relative to the detector's mean in each band.
    pub relative: f64,
    /// A detector whose mean is below this fraction of the mean over all detectors is measured as if it had that much.
    pub floor: f64,
    /// Most paths of a detector.
    pub max_paths: u64,
}

impl Default for TracingAccuracy {
    fn default() -> Self {
        TracingAccuracy { relative: 0.01, floor: 0.1, max_paths: 1 << 22 }
    }
}

/// H or G of a detector, W/m².
#[derive(Clone, Copy, Debug, Default)]
pub struct DetectorReading {
    /// All light.
    pub total: PerBand<SampleEstimate>,
    /// All but direct light.
    pub incident: PerBand<SampleEstimate>,
    /// Number of paths.
    pub paths: u64,
}

/// A scene prepared for path tracing.
pub struct PathTracer<'a> {
    pub(super) paths: PathSampler<'a>,
    /// The generator of the lattice: the increments from path to path.
    lattice: [f64; SPREAD_DIMENSIONS],
}

impl<'a> PathTracer<'a> {
    /// Builds the trees and collects the lights.
    pub fn new(scene: &'a Scene) -> PathTracer<'a> {
        let paths = PathSampler {
            space: RayScene::new(scene),
            lights: LightSet::new(scene),
            max_bounces: usize::MAX - 1,
        };
        PathTracer { paths, lattice: lattice_generator() }
    }

    /// Ignores light that was scattered more than `bounces` times.
    pub fn with_max_bounces(mut self, bounces: usize) -> PathTracer<'a> {
        self.paths.max_bounces = bounces;
        self
    }

    /// Measures detectors of one kind (all H, or all G). A pilot run sets the number of paths of each detector; the final run uses
    /// independent paths, so the choice introduces no bias.
    pub fn measure(
        &self,
        detectors: &[Detector],
        accuracy: &TracingAccuracy,
        seed: u64,
    ) -> Vec<DetectorReading> {
        let pilots = self.run(detectors, &vec![PILOT_PATHS as u64; detectors.len()], hash(seed, 1));
        let n = detectors.len().max(1) as f64;
        let overall = Bands::from_fn(|b| pilots.iter().map(|r| r.total[b].value).sum::<f64>() / n);
        let max_count = accuracy.max_paths.div_ceil(REPLICATE_COUNT as u64).max(PILOT_PATHS as u64);
        let counts: Vec<u64> = pilots
            .iter()
            .map(|r| {
                let excess = Band::all().map(|b| {
                    let wanted = accuracy.relative * r.total[b].value.max(accuracy.floor * overall[b]);
                    if r.total[b].error > 0.0 { (r.total[b].error / wanted).powi(2) } else { 0.0 }
                });
                let excess = excess.fold(0.0, f64::max);
                let count = (PILOT_PATHS as f64 * excess * PATH_COUNT_MARGIN).ceil() as u64;
                count.clamp(PILOT_PATHS as u64, max_count)
            })
            .collect();
        self.run(detectors, &counts, hash(seed, 2))
    }

    /// Measures one detector with a given number of paths, rounded up to whole replicates.
    pub fn measure_one(&self, detector: &Detector, paths: u64, seed: u64) -> DetectorReading {
        self.measure_with(std::slice::from_ref(detector), &[paths], seed)[0]
    }

    /// Measures each detector with its own number of paths, rounded up to whole replicates.
    ///
    /// # Panics
    /// Where `paths` has fewer numbers than there are detectors.
    pub fn measure_with(&self, detectors: &[Detector], paths: &[u64], seed: u64) -> Vec<DetectorReading> {
        let counts: Vec<u64> = paths.iter().map(|n| n.div_ceil(REPLICATE_COUNT as u64).max(1)).collect();
        self.run(detectors, &counts, seed)
    }

    /// Runs `counts[i]` paths in each replicate of detector i.
    fn run(&self, detectors: &[Detector], counts: &[u64], seed: u64) -> Vec<DetectorReading> {
        let means: Vec<[Bands; 2]> = parallel::collect(detectors.len() * REPLICATE_COUNT, |k| {
            let i = k / REPLICATE_COUNT;
            let replicate = (k % REPLICATE_COUNT) as u64;
            self.replicate(&detectors[i], counts[i], hash(hash(seed, i as u64), replicate))
        });
        let reading = |i: usize| {
            let replicates = &means[i * REPLICATE_COUNT..(i + 1) * REPLICATE_COUNT];
            let estimate = |which: usize, b: Band| {
                let mut statistics = SampleStatistics::default();
                replicates.iter().for_each(|m| statistics.add(m[which][b]));
                statistics.estimate(1.0)
            };
            DetectorReading {
                total: PerBand::from_fn(|b| estimate(0, b)),
                incident: PerBand::from_fn(|b| estimate(1, b)),
                paths: counts[i] * REPLICATE_COUNT as u64,
            }
        };
        (0..detectors.len()).map(reading).collect()
    }

    /// Means of all light and of indirect light over `count` paths.
    fn replicate(&self, detector: &Detector, count: u64, seed: u64) -> [Bands; 2] {
        let mut rng = Rng::new(hash(seed, u64::MAX));
        let shift: [f64; SPREAD_DIMENSIONS] = std::array::from_fn(|_| rng.uniform());
        let scale = (if detector.is_surface() { PI } else { 4.0 * PI }) / count as f64;
        let mut sums = [Bands::ZERO; 2];
        for j in 0..count {
            let low_discrepancy =
                (0..SPREAD_DIMENSIONS).map(|k| (shift[k] + j as f64 * self.lattice[k]).fract()).collect();
            let mut numbers = PathNumbers { low_discrepancy, rng: Rng::new(hash(seed, j)) };
            let vertex = self.paths.start(detector, &mut numbers);
            let PathRadiance { total, direct } = self.paths.scattered_radiance(vertex, &mut numbers);
            sums[0] += scale * total;
            sums[1] += scale * (total - direct);
        }
        sums
    }
}

/// The generator φ^{−k} of a rank-1 lattice in d dimensions, with φ the positive root of x^{d+1} = x + 1 (Roberts 2018).
fn lattice_generator() -> [f64; SPREAD_DIMENSIONS] {
    let d = SPREAD_DIMENSIONS as i32;
    let mut phi = 1.5f64;
    for _ in 0..60 {
        phi -= (phi.powi(d + 1) - phi - 1.0) / ((d + 1) as f64 * phi.powi(d) - 1.0);
    }
    std::array::from_fn(|k| phi.powi(-(k as i32 + 1)))
}
