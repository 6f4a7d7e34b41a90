//! Direct light of one light on all zones, and the expected number of its shadow rays.

use super::neighbour_agreement::NeighbourAgreement;
use super::params::{
    AVERAGED_ERROR_SHARE, AVERAGED_VOXEL_SAMPLES, CHUNK_ZONES, CURVATURE_SHARE, DISAGREEING_NEIGHBOURS,
    ERROR_SHARE, EXPECTED_CLUSTER_SHARE, FINE_TOLERANCE, FOUR_DIMENSIONAL_RATE, MAX_DEVIATION_FROM_MEAN,
    MAX_ERROR_EXCESS, MAX_OPENING_RAYS, MAX_RATIO_CHANGE, MAX_RAYS, MAX_SAMPLES, MAX_SAMPLES_PER_ZONE,
    MIN_RELATIVE_LEVEL, PANE_POINTS, PILOT_SAMPLES, SAMPLE_QUANTUM, SAMPLES_PER_PANE_POINT,
    STATED_OVER_AGREEMENT_ERROR, STATED_OVER_MEAN_ERROR, ZONES_PER_TASK,
};
use super::patch_clusters::{ClusterAgreement, PatchClusters};
use super::zone_sampler::{DirectLightEstimate, ZoneLightSampler, largest};
use crate::distribution::Execution;
use crate::distribution::multivector;
use crate::right_hand_side::surroundings::sky_openings::{MIN_SKY_RAYS, SampleNeed, SkyOpenings};
use crate::settings::unobstructed_cells::{CellRow, UnobstructedCells};
use rayon::prelude::*;
use std::ops::Range;
use zonal_math::parallel;
use zonal_scene::{Bands, Light, Scene, Zones};
use zonal_transport::Transport;

/// Direct light of one light on all zones.
pub(crate) struct GatheredLight {
    /// H_dir of patches, G_dir of volume zones, W/m².
    pub fields: Vec<Bands>,
    /// Standard error, W/m².
    pub error: Vec<Bands>,
    /// Number of shadow rays.
    pub rays: u64,
    /// The largest error of a kind of zones: root mean square over that of the light.
    pub worst_error: f64,
    /// Maximum number of samples of a zone.
    pub max_samples: usize,
}

/// Maximum number of samples of each patch and each voxel of `n` zones together.
fn max_samples(scene: &Scene, n: usize) -> [usize; 2] {
    let finer = (FINE_TOLERANCE / scene.options().tolerance).max(1.0).powf(1.0 / FOUR_DIMENSIONAL_RATE);
    let all = (MAX_RAYS / n.max(1)).min(MAX_SAMPLES_PER_ZONE);
    MAX_SAMPLES.map(|m| ((m as f64 * finer) as usize).min(all).max(m).next_multiple_of(SAMPLE_QUANTUM))
}

/// Wanted error of the zones of a kind (patches or volume zones).
struct ErrorTarget {
    /// Root mean square of the light, W/m².
    level: f64,
    /// Wanted error over the light of a zone.
    share: f64,
    /// Smallest light of a zone over `level` that lowers the wanted error.
    min_relative_level: f64,
}

impl ErrorTarget {
    fn new(scene: &Scene, pilot: &[DirectLightEstimate], kind: usize) -> ErrorTarget {
        ErrorTarget {
            level: root_mean_square(pilot),
            share: ERROR_SHARE[kind] * scene.options().tolerance,
            min_relative_level: MIN_RELATIVE_LEVEL[kind],
        }
    }

    /// Wanted error of a zone, W/m².
    fn of(&self, one: &DirectLightEstimate) -> f64 {
        self.share * largest(one.value()).clamp(self.min_relative_level * self.level, self.level)
    }
}

/// The targets of patches and of voxels from estimates of all zones.
fn error_targets(scene: &Scene, list: &[DirectLightEstimate], patches: usize) -> [ErrorTarget; 2] {
    let (of_patches, of_voxels) = list.split_at(patches);
    [ErrorTarget::new(scene, of_patches, 0), ErrorTarget::new(scene, of_voxels, 1)]
}

/// Root mean square of the largest band over some zones.
fn root_mean_square(list: &[DirectLightEstimate]) -> f64 {
    let square = |c: &[DirectLightEstimate]| c.iter().map(|o| largest(o.value()).powi(2)).sum::<f64>();
    let parts: Vec<f64> = list.par_chunks(CHUNK_ZONES).map(square).collect();
    (parts.iter().sum::<f64>() / list.len().max(1) as f64).sqrt()
}

/// The cells whose ratios may be averaged: none under a sun or a point light, whose penumbra is narrower than a cell.
fn unobstructed_cells<'a>(
    zones: &'a Zones,
    transport: &'a Transport<'a>,
    light: &Light,
) -> Option<UnobstructedCells<'a>> {
    let grid = transport.scene().voxel_grid()?;
    (!light.has_narrow_penumbra()).then(|| UnobstructedCells::new(grid, zones, transport))
}

/// True for a zone among obstacles whose error is too large by the factor `excess`, for its pilot samples were too alike to tell the number of samples.
fn is_undersampled(one: &DirectLightEstimate, excess: f64, limit: usize) -> bool {
    excess > MAX_ERROR_EXCESS && 2 * one.count as usize <= limit
}

/// The openings of a scene through which a sky lights its zones, and the maximum number of rays of a zone through them.
struct SkyThroughOpenings<'a> {
    openings: SkyOpenings<'a>,
    max_rays: usize,
}

impl<'a> SkyThroughOpenings<'a> {
    /// The openings for a sky by the pilot samples of every `step`-th zone with their wanted errors; `None` for other lights, and where plain samples do.
    fn find<'b>(
        sampler: &ZoneLightSampler<'a>,
        limit: [usize; 2],
        step: usize,
        pilot: impl Iterator<Item = (usize, &'b DirectLightEstimate, f64)>,
    ) -> Option<SkyThroughOpenings<'a>> {
        let light = sampler.light.light();
        let max_rays = (MAX_RAYS / sampler.zones.pane_index(0).max(1)).min(MAX_OPENING_RAYS);
        if limit[0].min(max_rays) < MIN_SKY_RAYS || light.sky().is_none() {
            return None;
        }
        let need = |(zone, one, wanted): (usize, &DirectLightEstimate, f64)| SampleNeed {
            zone,
            pilot: one.count as f64,
            visible: one.count as f64 * one.visible as f64,
            unoccluded_over_error: largest(one.unoccluded) / wanted,
            limit: limit[0] as f64,
        };
        let needs: Vec<SampleNeed> = pilot.map(need).collect();
        let openings = SkyOpenings::find(sampler.zones, sampler.transport, light, &needs, step)?;
        Some(SkyThroughOpenings { openings, max_rays })
    }
}

/// Expected number of shadow rays of [`gather`], from about `sample` zones of each kind; `unobstructed` are the cells of a light that averages over them.
pub(crate) fn expected_rays(
    zones: &Zones,
    transport: &Transport,
    light: &Light,
    sample: usize,
    unobstructed: Option<&UnobstructedCells>,
) -> f64 {
    let (sampler, scene) = (ZoneLightSampler::new(zones, transport, light), transport.scene());
    let (n, patches) = (zones.pane_index(0), zones.patches.len());
    let limit = max_samples(scene, n);
    let of = |range: Range<usize>, kind: usize| {
        let step = (range.len() / sample.max(1)).max(1);
        let list: Vec<usize> = range.step_by(step).collect();
        let pilot: Vec<DirectLightEstimate> =
            parallel::map(&list, |&i| sampler.sample_zone(i, 0..PILOT_SAMPLES[kind]));
        let target = ErrorTarget::new(scene, &pilot, kind);
        let wanted = pilot.iter().zip(&list).map(|(o, &i)| (i, o, target.of(o)));
        let openings = SkyThroughOpenings::find(&sampler, limit, step, wanted);
        let more = |(o, &i): (&DirectLightEstimate, &usize)| {
            let wanted = target.of(o);
            if o.absolute_error() <= wanted {
                return 0.0;
            }
            let averaged = i >= patches && unobstructed.is_some_and(|o| o.cube(i - patches, 1).is_some());
            let by_openings = openings.as_ref().filter(|_| !averaged);
            if let Some(rays) = by_openings.and_then(|x| x.openings.expected_rays(i, wanted, x.max_rays)) {
                return rays;
            }
            let share = if !o.agrees() {
                1.0
            } else if scene.voxel_grid().is_none() {
                EXPECTED_CLUSTER_SHARE
            } else {
                DISAGREEING_NEIGHBOURS
            };
            let most = if averaged { AVERAGED_VOXEL_SAMPLES } else { limit[kind] };
            let second = sampler.resample(i, o, most, 1.0, wanted);
            let excess = second.absolute_error() / wanted;
            let third = if !averaged && is_undersampled(&second, excess, most) {
                sampler.resample(i, &second, most, 1.0, wanted).count
            } else {
                0
            };
            share * (second.count as f64 + third as f64)
        };
        let resampled: Vec<f64> = pilot.par_iter().zip(&list).map(more).collect();
        step as f64 * (resampled.iter().sum::<f64>() + (list.len() * PILOT_SAMPLES[kind]) as f64)
    };
    let panes = zones.panes.len() * PANE_POINTS * SAMPLES_PER_PANE_POINT;
    of(0..patches, 0) + of(patches..n, 1) + panes as f64
}

/// Gathers one light on all zones.
pub(crate) fn gather(
    zones: &Zones,
    transport: &Transport,
    light: &Light,
    execution: Execution,
) -> GatheredLight {
    let (sampler, scene) = (ZoneLightSampler::new(zones, transport, light), transport.scene());
    let (n, patches) = (zones.pane_index(0), zones.patches.len());
    let progress = execution.progress;
    progress.begin("direct light", 2 * n as u64);
    // Sample every zone with its pilot samples.
    let kind = |i: usize| usize::from(i >= patches);
    let pilot =
        ZoneLightSampler::for_zones(n, execution, |i| sampler.sample_zone(i, 0..PILOT_SAMPLES[kind(i)]));
    let mut gathering = Gathering::new(&sampler, &pilot);
    // Resample the zones whose error is too large.
    let clusters = scene.voxel_grid().is_none().then(|| PatchClusters::new(&zones.patches));
    let neighbours = Neighbours {
        cells: scene.voxel_grid().map(|m| NeighbourAgreement::new(&sampler, m, &pilot)),
        cluster: clusters.as_ref().map(|c| c.agreement(&pilot)),
    };
    let mut second = ZoneLightSampler::for_zones(n, execution, |i| {
        gathering.resample_if_needed(i, &pilot[i], &neighbours)
    });
    if let Some(clusters) = &clusters {
        let agreement = clusters.agreement(&second);
        parallel::for_each(&mut second, |i, one| one.support = agreement.support(i, one).0);
    }
    let counted = |list: &[DirectLightEstimate]| list.iter().map(|o| o.count as u64).sum::<u64>();
    let rays = counted(&pilot) + counted(&second);
    drop((neighbours, pilot));
    gathering.update_targets(&second);
    // Average or resample the voxels whose error is still too large.
    let settle = |i: usize| gathering.average_or_resample(i, &second);
    let settled: Vec<(Bands, (Bands, u64))> =
        execution.blocks(n, ZONES_PER_TASK).map(execution.communicator, settle);
    // Add the panes.
    let (panes, pane_rays) = sampler.panes(scene.options().tolerance, execution);
    progress.end();
    let fields: Vec<Bands> = settled.iter().map(|s| s.0).chain(panes.iter().map(|p| p[0])).collect();
    let error: Vec<Bands> = settled.iter().map(|s| s.1.0).chain(panes.iter().map(|p| p[1])).collect();
    let kinds = [0..patches, patches..n, n..zones.len()];
    let worst_error = kinds.into_iter().map(|kind| relative_error(&fields, &error, kind)).fold(0.0, f64::max);
    let rays = rays + settled.iter().map(|s| s.1.1).sum::<u64>() + pane_rays;
    GatheredLight { fields, error, rays, worst_error, max_samples: gathering.max_samples() }
}

/// Root mean square of the errors of some zones over that of their fields.
fn relative_error(fields: &[Bands], error: &[Bands], zones: Range<usize>) -> f64 {
    let [e, f]: [f64; 2] =
        multivector::sum(zones.len(), |k| [error, fields].map(|list| largest(list[zones.start + k]).powi(2)));
    if e > 0.0 { (e / f).sqrt() } else { 0.0 }
}

/// Agreement of the pilot samples around a zone: of the cells, or of the cluster of a patch where there is no voxel grid.
struct Neighbours<'a> {
    cells: Option<NeighbourAgreement<'a>>,
    cluster: Option<ClusterAgreement<'a>>,
}

impl Neighbours<'_> {
    /// Number of samples around zone `i` that support its pilot samples `one`, and the number of samples that it needs alone over that with its neighbours.
    fn of(&self, sampler: &ZoneLightSampler, i: usize, one: &DirectLightEstimate) -> (u32, f64) {
        match (&self.cells, &self.cluster) {
            (_, Some(c)) => c.support(i, one),
            (Some(c), None) => (c.agreeing_samples(sampler, one, i) as u32, 1.0),
            (None, None) => (0, 1.0),
        }
    }
}

/// Shared data of the passes over the zones after the pilot samples.
struct Gathering<'a> {
    sampler: &'a ZoneLightSampler<'a>,
    targets: [ErrorTarget; 2],
    openings: Option<SkyThroughOpenings<'a>>,
    unobstructed: Option<UnobstructedCells<'a>>,
    limit: [usize; 2],
    /// Number of patches.
    patches: usize,
}

impl<'a> Gathering<'a> {
    fn new(sampler: &'a ZoneLightSampler<'a>, pilot: &[DirectLightEstimate]) -> Gathering<'a> {
        let ZoneLightSampler { zones, transport, light, .. } = sampler;
        let scene = transport.scene();
        let patches = zones.patches.len();
        let mut gathering = Gathering {
            targets: error_targets(scene, pilot, patches),
            openings: None,
            unobstructed: unobstructed_cells(zones, transport, light.light()),
            limit: max_samples(scene, pilot.len()),
            patches,
            sampler,
        };
        // Find the openings of a sky where plain samples do not meet the tolerance.
        let wanted = pilot.iter().enumerate().map(|(i, o)| (i, o, gathering.wanted(i, o)));
        gathering.openings = SkyThroughOpenings::find(sampler, gathering.limit, 1, wanted);
        gathering
    }

    /// Takes the targets from better estimates: the few pilot samples of a small opening overestimate its light.
    fn update_targets(&mut self, second: &[DirectLightEstimate]) {
        if self.openings.is_some() {
            self.targets = error_targets(self.sampler.transport.scene(), second, self.patches);
        }
    }

    /// Maximum number of samples of a zone.
    fn max_samples(&self) -> usize {
        let of_openings = self.openings.as_ref().map_or(0, |o| o.max_rays);
        self.limit[0].max(self.limit[1]).max(of_openings)
    }

    fn kind(&self, i: usize) -> usize {
        usize::from(i >= self.patches)
    }

    /// Wanted error of zone `i`, W/m².
    fn wanted(&self, i: usize, one: &DirectLightEstimate) -> f64 {
        self.targets[self.kind(i)].of(one)
    }

    /// The 27 cells around voxel zone `i`, if nothing obstructs them.
    fn cube(&self, i: usize) -> Option<impl Iterator<Item = CellRow> + Clone> {
        self.unobstructed.as_ref().filter(|_| i >= self.patches).and_then(|o| o.cube(i - self.patches, 1))
    }

    /// The openings of a sky for zone `i`; voxels whose ratios may be averaged are sampled plainly.
    fn openings(&self, i: usize) -> Option<&SkyThroughOpenings<'_>> {
        self.openings.as_ref().filter(|o| o.openings.serve(i) && self.cube(i).is_none())
    }

    /// The estimate of zone `i` after its pilot samples, which those of its neighbours may support.
    fn resample_if_needed(
        &self,
        i: usize,
        pilot: &DirectLightEstimate,
        neighbours: &Neighbours,
    ) -> DirectLightEstimate {
        let wanted = self.wanted(i, pilot);
        let (support, saving) = neighbours.of(self.sampler, i, pilot);
        let supported = DirectLightEstimate { support, ..*pilot };
        if supported.absolute_error() <= wanted {
            return supported;
        }
        if let Some(light) = self.openings(i).and_then(|o| o.openings.first_light(i)) {
            return DirectLightEstimate::of_sky(&light);
        }
        if self.cube(i).is_some() {
            return self.sampler.resample(i, pilot, AVERAGED_VOXEL_SAMPLES, 1.0, wanted);
        }
        self.sampler.resample(i, pilot, self.limit[self.kind(i)], saving, wanted)
    }

    /// Field, error (W/m²) and number of further rays of zone `i`, whose error is too large: the mean with the cells around it if that is smooth, else further samples.
    fn average_or_resample(&self, i: usize, all: &[DirectLightEstimate]) -> (Bands, (Bands, u64)) {
        let own = &all[i];
        let factor = |o: &DirectLightEstimate| {
            if o.agrees() { STATED_OVER_AGREEMENT_ERROR } else { STATED_OVER_MEAN_ERROR }
        };
        let stated = |o: &DirectLightEstimate| factor(o) * o.unoccluded * o.relative_error();
        let result = |o: &DirectLightEstimate, rays: u64| (o.value(), (stated(o), rays));
        let excess = own.absolute_error() / self.wanted(i, own);
        let limit = self.limit[self.kind(i)];
        let resampled = || {
            let more = self.sampler.resample(i, own, limit, 1.0, self.wanted(i, own));
            result(&more, more.count as u64)
        };
        let openings = self.openings(i).filter(|_| excess > 1.0);
        let measured = openings.and_then(|o| o.openings.light_on_zone(i, self.wanted(i, own), o.max_rays));
        if let Some(light) = measured {
            return result(&DirectLightEstimate::of_sky(&light), light.rays as u64);
        }
        match self.cube(i) {
            Some(rows) if excess > 1.0 => {
                let (mean, change) = mean_ratio(rows, &all[self.patches..]);
                let off = (own.ratio - mean).abs().into_iter().fold(0.0, f64::max);
                let error = own.relative_error();
                if off <= MAX_DEVIATION_FROM_MEAN * error && change <= MAX_RATIO_CHANGE {
                    let averaged = (AVERAGED_ERROR_SHARE * error).hypot(CURVATURE_SHARE * change);
                    return (own.unoccluded * mean, (factor(own) * own.unoccluded * averaged, 0));
                }
                resampled()
            }
            None if is_undersampled(own, excess, limit) => resampled(),
            _ => result(own, 0),
        }
    }
}

/// Mean ratio over the rows of 27 cells, and its largest change from one side to the other.
fn mean_ratio(rows: impl Iterator<Item = CellRow>, list: &[DirectLightEstimate]) -> (Bands, f64) {
    let (mut sum, mut change) = (Bands::ZERO, [Bands::ZERO; 3]);
    for row in rows {
        for (z, offset) in row.zones.zip([-1.0, 0.0, 1.0]) {
            let one = &list[z];
            let d = [row.offset[0] as f64, row.offset[1] as f64, offset];
            sum += one.ratio / 27.0;
            change.iter_mut().zip(d).for_each(|(c, d)| *c += d * one.ratio / 9.0);
        }
    }
    (sum, change.iter().flatten().fold(0.0, |m, c| c.abs().max(m)))
}
