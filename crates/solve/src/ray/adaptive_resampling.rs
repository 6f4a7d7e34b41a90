//! Adaptive resampling: a second pass of rays for zones whose smoothed estimate is still too uncertain.
//!
//! Zones that receive strong radiation through a small opening, or have few similar neighbours, remain noisy after smoothing. Zone i is
//! resampled where its stated error exceeds
//!
//! ```text
//! w_i = share · ε · min(max(v_i, dark · mean of v), bright · root mean square of v)        v_i incident and direct radiation
//! ```
//!
//! with ε the tolerance, so that errors of bright zones count in full. It receives (e_i/w_i)² times its present rays, e_i the error of its
//! own rays. All requests shrink by one factor where they exceed the total; a zone that would then be worse than its smoothed value is
//! left out. (Serving the noisiest zones first was measured: the others lose more than these gain.) The mean of all rays of a resampled
//! zone replaces its smoothed value.

use super::padded_bands::{PaddedBands, without_padding};
use super::path_continuation::{PathLights, VertexSource};
use super::ray_table::{IncidentEstimate, PathExtent, RayTable};
use super::ray_tracer::RayTracer;
use super::smoothing::SMOOTHING_PARAMS;
use crate::iteration::multivector;
use rayon::prelude::*;
use zonal_scene::{Bands, Scene};

/// Thresholds and limits of resampling.
///
/// `zonal solve scenes/sponza.toml -o sponza.npz` adds 21 million rays to 71 million. Before errors of bright zones counted in full, one
/// patch beside the lamp made an L2 error of 3.9 % of H at seed 1, now 2.9 % (`docs/hierarchical.md`).
struct ResamplingParams {
    /// Allowed error over tolerance and incident radiation, of a patch and of a volume zone.
    allowed_error_share: [f64; 2],
    /// Smallest incident radiation that counts, over its mean.
    min_share_of_mean: f64,
    /// Largest incident radiation that counts, over its root mean square.
    max_share_of_rms: f64,
    /// Fewest and most new rays of a zone, over its present rays.
    new_rays_over_present: [f64; 2],
    /// Most new rays of all zones, over the rays of the table.
    max_new_rays_in_total: f64,
}

const RESAMPLING_PARAMS: ResamplingParams = ResamplingParams {
    allowed_error_share: [1.75, 2.2],
    min_share_of_mean: 0.1,
    max_share_of_rms: 0.5,
    new_rays_over_present: [1.0, 12.0],
    max_new_rays_in_total: 0.3,
};

/// Zones whose rays are traced in one task.
const ZONES_PER_TASK: usize = 32;

/// New rays of a zone.
struct SampleRequest {
    zone: usize,
    rays: usize,
}

/// A zone whose error exceeds the allowed one.
struct NoisyZone {
    zone: usize,
    /// New rays wanted, over the present ones.
    wanted: f64,
    /// All rays over the present ones at which their mean is as good as the smoothed value.
    break_even: f64,
}

/// The smoothed incident radiation that resampling improves.
pub(crate) struct SmoothedFields<'a> {
    /// H or G of every column by the rays alone.
    pub raw: &'a [Vec<Bands>],
    /// Sum of the columns by the rays alone, with its standard error.
    pub estimate: &'a [IncidentEstimate],
    /// H or G of every column.
    pub columns: &'a mut [Vec<Bands>],
    /// Stated error of the sum of the columns.
    pub error: &'a mut [Bands],
}

/// The zones to resample, by their values and stated errors.
fn sample_requests(
    table: &RayTable,
    fields: &SmoothedFields,
    direct: &[Bands],
    tolerance: f64,
) -> Vec<SampleRequest> {
    let (n, patches) = (fields.error.len(), table.patches());
    let p = &RESAMPLING_PARAMS;
    let value = |i: usize| fields.columns.iter().map(|c| c[i].sum()).sum::<f64>() + direct[i].sum();
    let mut out: Vec<NoisyZone> = Vec::new();
    for (range, share) in [0..patches, patches..n].into_iter().zip(p.allowed_error_share) {
        // Mean and root mean square over the zones of one kind.
        let of_zone = |k: usize| value(range.start + k);
        let [sum, squares] = multivector::sum(range.len(), |k| [of_zone(k), of_zone(k).powi(2)]);
        let count = range.len().max(1) as f64;
        let (dark, bright) =
            (p.min_share_of_mean * sum / count, p.max_share_of_rms * (squares / count).sqrt());
        let noisy = |i: usize| {
            let allowed = share * tolerance * value(i).max(dark).min(bright);
            let raw = SMOOTHING_PARAMS.stated_error_factor * fields.estimate[i].error.sum();
            let exceeds = fields.error[i].sum() > allowed && allowed > 0.0;
            let [least, most] = p.new_rays_over_present;
            let wanted = (raw / allowed).powi(2).clamp(least, most);
            let break_even = (raw / fields.error[i].sum()).powi(2);
            exceeds.then_some(NoisyZone { zone: i, wanted, break_even })
        };
        out.extend(range.into_par_iter().filter_map(noisy).collect::<Vec<_>>());
    }
    let max_rays = p.max_new_rays_in_total * table.rays_and_vertices()[0] as f64;
    allocate_rays(out, &|zone| table.rays_of(zone).len(), max_rays)
}

/// Distributes at most `max_rays` rays; `present` returns the rays of a zone.
fn allocate_rays(
    mut list: Vec<NoisyZone>,
    present: &dyn Fn(usize) -> usize,
    max_rays: f64,
) -> Vec<SampleRequest> {
    let wanted = |list: &[NoisyZone]| list.iter().map(|z| z.wanted * present(z.zone) as f64).sum::<f64>();
    let fraction = |list: &[NoisyZone]| (max_rays / wanted(list).max(1.0)).min(1.0);
    // Zones that the reduced number would not improve leave their rays to the others.
    let reduced = fraction(&list);
    list.retain(|z| 1.0 + reduced * z.wanted > z.break_even);
    let reduced = fraction(&list);
    let request = |z: NoisyZone| SampleRequest {
        zone: z.zone,
        rays: (reduced * z.wanted * present(z.zone) as f64) as usize,
    };
    list.into_iter().map(request).collect()
}

/// A resampled zone: its number, H or G of every column, and the error of their sum.
type ResampledZone = (usize, Vec<Bands>, Bands);

/// The table, the radiosities and the rays that resampling adds to.
pub(crate) struct AdaptiveResampling<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Traces the new rays.
    pub tracer: RayTracer<'a>,
    /// Lights at path vertices; `None` where paths do not continue.
    pub lights: Option<PathLights<'a>>,
    /// The present rays.
    pub table: &'a RayTable,
    /// Radiosities of every column, W/m².
    pub radiosity: &'a [Vec<PaddedBands>],
    /// Source terms at path vertices of every column; empty where paths do not continue.
    pub sources: &'a [VertexSource],
}

impl AdaptiveResampling<'_> {
    /// Resamples the zones that need it and replaces their values and errors; `direct` is the direct light on the zones. Returns the
    /// number of new rays.
    pub(crate) fn resample(&self, fields: &mut SmoothedFields, direct: &[Bands]) -> u64 {
        let requests = sample_requests(self.table, fields, direct, self.scene.options().tolerance);
        let done: Vec<ResampledZone> = requests
            .par_chunks(ZONES_PER_TASK)
            .flat_map_iter(|task| self.resample_zones(task, fields.raw, fields.estimate))
            .collect();
        for (i, values, error) in done {
            fields.error[i] = error;
            values.into_iter().zip(fields.columns.iter_mut()).for_each(|(v, to)| to[i] = v);
        }
        requests.iter().map(|r| r.rays as u64).sum()
    }

    /// How the paths of column `c` are followed.
    fn extent(&self, c: usize) -> PathExtent<'_> {
        self.sources.get(c).map_or(PathExtent::FirstZone, PathExtent::WithSource)
    }

    /// Traces the new rays of some zones and joins them with the present ones.
    fn resample_zones(
        &self,
        requests: &[SampleRequest],
        raw: &[Vec<Bands>],
        estimate: &[IncidentEstimate],
    ) -> Vec<ResampledZone> {
        // The request that each ray serves, and its number among the rays of the zone.
        let mut rays: Vec<(usize, usize)> = Vec::new();
        for (q, request) in requests.iter().enumerate() {
            let present = self.table.rays_of(request.zone).len();
            rays.extend((present..present + request.rays).map(|k| (q, k)));
        }
        // Sum the radiosities of every column, and the squares of their sum.
        let source = |r: usize| (requests[rays[r].0].zone, rays[r].1);
        let mut vertices = Vec::new();
        let mut sums = vec![vec![Bands::ZERO; self.radiosity.len()]; requests.len()];
        let mut squares = vec![Bands::ZERO; requests.len()];
        self.tracer.trace_batch(rays.len(), source, |r, end| {
            let (q, weight) = (rays[r].0, end.weight);
            vertices.clear();
            let end = self
                .lights
                .as_ref()
                .map_or(end.zone, |lights| self.tracer.continue_path(lights, source(r), end, &mut vertices));
            let mut all = Bands::ZERO;
            for (c, b) in self.radiosity.iter().enumerate() {
                let v = self.table.transported(&vertices, (end, weight), b, self.extent(c));
                let v = without_padding(v.map(f64::from));
                sums[q][c] += v;
                all += v;
            }
            squares[q] += all * all;
        });
        let joined = |((request, sums), square): ((&SampleRequest, Vec<Bands>), Bands)| {
            let (i, present) = (request.zone, self.table.rays_of(request.zone).len());
            let (m, factor) = (request.rays as f64, self.table.incident_factor(i));
            let (old, new) = (present as f64, present as f64 + m);
            let all: Bands = sums.iter().sum();
            // The variance of the mean, from the squares about the means of the old and of the new rays.
            let own = (square - all * all / m.max(1.0)).map(|s| s.max(0.0)) * factor * factor;
            let before = (estimate[i].error * old).map(|e| e.powi(2));
            let error = SMOOTHING_PARAMS.stated_error_factor * (own + before).sqrt() / new;
            let value = |c: usize| {
                let own = self.table.self_irradiation(i, &self.radiosity[c]);
                (raw[c][i] * old + factor * (sums[c] + m * own)) / new
            };
            (i, (0..self.radiosity.len()).map(value).collect(), error)
        };
        requests.iter().zip(sums).zip(squares).map(joined).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_are_allocated_to_zones_that_they_improve() {
        let noisy = |zone, wanted, break_even| NoisyZone { zone, wanted, break_even };
        // 100 present rays each, 400 wanted, 200 allowed: half the request would leave the second zone worse than smoothing does.
        let list = vec![noisy(3, 2.0, 1.5), noisy(5, 2.0, 2.5)];
        let requests = allocate_rays(list, &|_| 100, 200.0);
        assert_eq!(requests.iter().map(|r| (r.zone, r.rays)).collect::<Vec<_>>(), [(3, 200)]);
        // All zones are served where the limit allows all requests.
        let list = vec![noisy(3, 2.0, 1.5), noisy(5, 2.0, 2.5)];
        assert_eq!(allocate_rays(list, &|_| 100, 400.0).len(), 2);
    }
}
