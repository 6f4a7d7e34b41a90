//! Importance sampling of the openings through which rays of a zone leave the scene.
//!
//! The view factor from a zone to the sky through a window is the mean, over points of the zone and directions, of a function that vanishes
//! almost everywhere and is discontinuous at the frame. As a mean over points of the zone and points y of the opening,
//!
//! ```text
//!     g/A  = ⟨ cosθ cosθ_y τ/(π r²) ⟩ A_y   of a patch,      g/4V = ⟨ cosθ_y τ/(4π r²) ⟩ A_y   of a volume,
//! ```
//!
//! the integrand is smooth. Every ray leaves through the bounding box of the scene. Its sides are divided into cells, and pilot rays of all
//! zones mark the cells through which rays leave (`open_cells`). For one zone the marked cells that are not near it are strata of points y; all other rays
//! form one stratum of directions. The estimate is unbiased, since the pilot rays do not enter it. The number of rays of a stratum is
//! proportional to its standard deviation (Neyman allocation), estimated by a few pilot rays. Each stratum has a low-discrepancy sequence of
//! its own; the spread of its batches gives its variance.

use super::box_cells::{BoxCell, CELLS_ALONG_LONGEST_SIDE};
use super::open_cells::OpenCells;
use super::ray_tally::{BATCHES, RayTally, TracedScene};
use super::zone_rays::{WeightedRay, ZoneRaySample, pane_ray_weight, point_in_zone, sample_of_sequence};
use std::f64::consts::PI;
use zonal_exchange::pair::SUCCESSION_PSEUDO_COUNTS;
use zonal_math::low_discrepancy;
use zonal_scene::{Bands, ZoneRef};

/// Pilot rays that mark open cells: of all zones, and at most of one zone.
const MARKING_RAYS: usize = 1 << 21;
const MAX_MARKING_RAYS_PER_ZONE: usize = 512;
/// A cell is near if its distance is at most this multiple of half the diagonals of cell and zone together.
const NEAR_CELL_RATIO: f64 = 1.5;
/// Pilot rays to each cell, and of the stratum of directions.
const PILOT_RAYS_PER_CELL: usize = 4;
const PILOT_RAYS_OF_DIRECTIONS: usize = 256;
/// Lower bound of the standard deviation of a cell, over the mean weight of an unoccluded ray.
const MIN_RELATIVE_DEVIATION: f64 = 0.25;
/// Lower bound of the share of a stratum over the mean share, and its minimum number of rays.
const MIN_SHARE_OVER_MEAN: f64 = 0.2;
const MIN_RAYS_PER_STRATUM: usize = 2;
/// Minimum share of the rays in the stratum of directions.
const MIN_SHARE_OF_DIRECTIONS: f64 = 0.1;
/// Rays of the first round, maximum number of further rounds, and largest growth of the number of rays from round to round.
pub(super) const FIRST_ROUND_RAYS: usize = 1024;
const MAX_ROUNDS: usize = 4;
const MAX_RAY_GROWTH: f64 = 8.0;
/// Maximum number of rays of a zone from which opening sampling is used.
pub(super) const MIN_RAYS_FOR_OPENINGS: usize = 4 * FIRST_ROUND_RAYS;

/// Exponent of rays over error, from an error that falls like the number of rays to the power −3/4.
pub(super) const RAYS_OVER_ERROR_EXPONENT: f64 = 4.0 / 3.0;

/// Openings by groups of zones.
#[derive(Clone, Debug)]
pub(super) struct OpeningSampler<'a> {
    traced: TracedScene<'a>,
    /// The open cells of each group; `None` of a group whose rays leave nearly everywhere.
    groups: Vec<Option<OpenCells>>,
    /// The group of each zone, `None` of zones without; empty where all zones are the first group.
    group_of: Vec<Option<u32>>,
}

/// Estimate of one zone.
pub(super) struct OpeningEstimate {
    pub tally: RayTally,
    /// Standard error of the mean, root of the sum of squares over the bands; for a sky with the light through cells that no ray reached.
    pub error: f64,
    /// Share of the rays that may leave through cells that are not marked.
    pub missed: f64,
}

/// Result of the pilot rays of a stratum.
struct StratumPilot {
    /// Standard deviation of the rays.
    deviation: f64,
    /// Mean weight without occlusion, the largest band; 0 of the stratum of directions.
    weight: f64,
}

/// The strata of one zone: the open cells that are not near it, and the other directions.
struct Strata<'a, 'b> {
    sampler: &'a OpeningSampler<'b>,
    open: &'a OpenCells,
    zone: usize,
    /// For each open cell, whether it is a stratum.
    is_stratum: Vec<bool>,
    cells: Vec<&'a BoxCell>,
}

/// Which random sequence of a stratum a ray belongs to.
#[derive(Clone, Copy, PartialEq)]
enum RayPurpose {
    Pilot,
    Estimate,
}

impl<'a> OpeningSampler<'a> {
    /// Marks the open cells of all zones together; `None` if rays leave nearly everywhere.
    pub(super) fn find(traced: TracedScene<'a>) -> Option<OpeningSampler<'a>> {
        let all: Vec<usize> = (0..traced.zones.len()).collect();
        let rays = (MARKING_RAYS / all.len().max(1)).clamp(1, MAX_MARKING_RAYS_PER_ZONE);
        let open = OpenCells::mark(traced, &[CELLS_ALONG_LONGEST_SIDE], &all, rays)?;
        Some(OpeningSampler { traced, groups: vec![Some(open)], group_of: Vec::new() })
    }

    /// A sampler with the openings of groups of zones; zone i is in the group `group_of[i]`, or in none.
    pub(super) fn of_groups(
        traced: TracedScene<'a>,
        groups: Vec<Option<OpenCells>>,
        group_of: Vec<Option<u32>>,
    ) -> OpeningSampler<'a> {
        OpeningSampler { traced, groups, group_of }
    }

    /// The open cells of the group of zone `i`.
    pub(super) fn open_cells(&self, i: usize) -> Option<&OpenCells> {
        let group = self.group_of.get(i).copied().unwrap_or(Some(0))?;
        self.groups.get(group as usize)?.as_ref()
    }

    /// Number of patches, the first zones.
    pub(super) fn patches(&self) -> usize {
        self.traced.zones.patches.len()
    }

    /// Traces rays of zone `i` until the error (root of the sum of squares over the bands) is at most `wanted`, with about `max_rays` at most; `None` for a zone of a
    /// group without openings.
    pub(super) fn measure(&self, i: usize, wanted: f64, max_rays: usize) -> Option<OpeningEstimate> {
        let open = self.open_cells(i)?;
        let strata = Strata::new(self, open, i);
        let count = strata.cells.len();
        let pilots: Vec<StratumPilot> = (0..=count).map(|c| strata.pilot(c)).collect();
        let shares = allocation(pilots.iter().map(|p| p.deviation).collect());
        let mut tallies = vec![RayTally::default(); count + 1];
        let (mut all, mut rays) = (RayTally::default(), FIRST_ROUND_RAYS.max(MIN_RAYS_PER_STRATUM * count));
        let mut error = 0.0;
        for _ in 0..=MAX_ROUNDS {
            for (c, tally) in tallies.iter_mut().enumerate() {
                let upto = whole_batches((rays as f64 * shares[c]) as usize).max(tally.traced as usize);
                let sequence = strata.sequence(c, RayPurpose::Estimate);
                tally.add(&RayTally::of(tally.traced as usize..upto, |k| {
                    self.traced.trace(strata.ray(c, sequence, k))
                }));
            }
            all = RayTally::combine_strata(&tallies);
            error = self.error(&all, tallies.iter().zip(&pilots));
            if error <= wanted || rays >= max_rays {
                break;
            }
            let growth = (error / wanted).powf(RAYS_OVER_ERROR_EXPONENT).min(MAX_RAY_GROWTH);
            rays = ((rays as f64 * growth) as usize).min(max_rays);
        }
        let tally =
            RayTally { pilot: (PILOT_RAYS_OF_DIRECTIONS + PILOT_RAYS_PER_CELL * count) as u32, ..all };
        Some(OpeningEstimate { tally, error, missed: open.missed })
    }

    /// Standard error of the sum `all` of strata: of surroundings by all rays together. For a sky the cells that no ray of theirs reached err by the rule of succession each.
    fn error<'c>(
        &self,
        all: &RayTally,
        strata: impl Iterator<Item = (&'c RayTally, &'c StratumPilot)>,
    ) -> f64 {
        let of_all = all.standard_error().map(|e| e * e).sum();
        if self.traced.sky.is_none() {
            return of_all.sqrt();
        }
        let missed = |(tally, pilot): (&RayTally, &StratumPilot)| match tally.escaped {
            0 => (pilot.weight / (f64::from(tally.traced) + SUCCESSION_PSEUDO_COUNTS)).powi(2),
            _ => 0.0,
        };
        (strata.map(missed).sum::<f64>() + if all.escaped > 0 { of_all } else { 0.0 }).sqrt()
    }
}

impl<'a, 'b> Strata<'a, 'b> {
    fn new(sampler: &'a OpeningSampler<'b>, open: &'a OpenCells, zone: usize) -> Strata<'a, 'b> {
        let (centre, radius) = sampler.traced.bounding_sphere(zone);
        let is_far = |c: &BoxCell| {
            let size = radius + 0.5 * (c.edges[0] + c.edges[1]).length();
            (c.centre() - centre).length() > NEAR_CELL_RATIO * size
        };
        let is_stratum: Vec<bool> = open.cells.iter().map(is_far).collect();
        let cells = open.cells.iter().zip(&is_stratum).filter(|c| *c.1).map(|c| c.0).collect();
        Strata { sampler, open, zone, is_stratum, cells }
    }

    /// Seed of the sequence of stratum `c`.
    fn sequence(&self, c: usize, purpose: RayPurpose) -> u64 {
        let estimate = u64::from(purpose == RayPurpose::Estimate);
        let seed = (((self.zone << 10) + c) as u64 * 2 + estimate) ^ self.sampler.traced.seed.rotate_left(32);
        low_discrepancy::split_mix64(seed)
    }

    /// The `k`-th ray of stratum `c`; the last stratum is that of directions, without the rays that leave through the other strata.
    fn ray(&self, c: usize, sequence: u64, k: usize) -> WeightedRay {
        let sampler = self.sampler;
        let sample = sample_of_sequence(sampler.traced.zones, self.zone, sequence, k);
        if c < self.cells.len() {
            return self.ray_to_cell(sample, self.cells[c]);
        }
        let ray = sampler.traced.ray(self.zone, sample);
        let exit = self.open.index[self.open.sides.exit_cell(ray.origin, ray.dir)];
        let in_other_stratum = exit.is_some_and(|c| self.is_stratum[c as usize]);
        WeightedRay { weight: if in_other_stratum { Bands::ZERO } else { ray.weight }, ..ray }
    }

    /// The ray from a point of the zone to the point of a cell in the place of the direction.
    fn ray_to_cell(&self, sample: ZoneRaySample, cell: &BoxCell) -> WeightedRay {
        let (traced, d) = (&self.sampler.traced, sample.direction);
        let origin = point_in_zone(traced.zones, traced.transport, self.zone, sample.origin);
        let r = cell.corner + cell.edges[0] * d[0] + cell.edges[1] * d[1] - origin;
        let dir = r.normalized();
        let solid_angle = cell.normal.dot(dir).max(0.0) * cell.area() / r.length2();
        // Density of the rays of the kernel in this direction, times their weight.
        let density = match traced.zones.zone(self.zone) {
            ZoneRef::Patch(p) => Bands::splat(p.normal.dot(dir).max(0.0) / PI),
            ZoneRef::Voxel(..) => Bands::splat(0.25 / PI),
            ZoneRef::Pane(_, p) => pane_ray_weight(p, dir) * p.normal.dot(dir).abs() / (2.0 * PI),
        };
        WeightedRay { origin, dir, weight: density * traced.radiance(dir) * solid_angle }
    }

    /// The pilot rays of stratum `c`.
    fn pilot(&self, c: usize) -> StratumPilot {
        let is_cell = c < self.cells.len();
        let sequence = self.sequence(c, RayPurpose::Pilot);
        let count = if is_cell { PILOT_RAYS_PER_CELL } else { PILOT_RAYS_OF_DIRECTIONS };
        let rays = (0..count).map(|k| self.ray(c, sequence, k));
        let (weights, met): (Vec<Bands>, Vec<Bands>) =
            rays.map(|r| (r.weight, self.sampler.traced.trace(r).share)).unzip();
        let deviation = standard_deviation(&met);
        let weight = if is_cell { largest_mean(&weights) } else { 0.0 };
        StratumPilot { deviation: deviation.max(MIN_RELATIVE_DEVIATION * weight), weight }
    }
}

/// Rounds a number of rays up to whole batches.
fn whole_batches(rays: usize) -> usize {
    if rays < BATCHES { rays.max(MIN_RAYS_PER_STRATUM) } else { rays.next_multiple_of(BATCHES) }
}

/// The largest mean over the bands.
fn largest_mean(values: &[Bands]) -> f64 {
    let sum = Bands::from_fn(|b| values.iter().map(|x| x[b]).sum::<f64>());
    sum.max_element() / values.len() as f64
}

/// The largest standard deviation over the bands.
fn standard_deviation(values: &[Bands]) -> f64 {
    let n = values.len() as f64;
    let variance = Bands::from_fn(|b| {
        let mean = values.iter().map(|x| x[b]).sum::<f64>() / n;
        values.iter().map(|x| (x[b] - mean).powi(2)).sum::<f64>() / n
    });
    variance.max_element().sqrt()
}

/// The share of the rays of each stratum, by standard deviations of which the last belongs to the stratum of directions.
fn allocation(mut deviations: Vec<f64>) -> Vec<f64> {
    let Some(directions) = deviations.pop() else { return Vec::new() };
    let sum: f64 = deviations.iter().sum();
    let least = MIN_SHARE_OVER_MEAN * sum / deviations.len().max(1) as f64;
    deviations.iter_mut().for_each(|s| *s = s.max(least));
    let sum: f64 = deviations.iter().sum();
    let least_of_directions = MIN_SHARE_OF_DIRECTIONS * sum / (1.0 - MIN_SHARE_OF_DIRECTIONS);
    deviations.push(if sum > 0.0 { directions.max(least_of_directions) } else { 1.0 });
    let sum: f64 = deviations.iter().sum();
    deviations.iter().map(|s| s / sum).collect()
}
