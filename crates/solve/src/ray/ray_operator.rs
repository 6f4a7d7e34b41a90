//! The exchange operator of a ray table.
//!
//! The operator is not symmetric, as the exchange of i with j is sampled at i alone; its equations are solved by stabilised
//! bi-conjugate gradients (`iteration::bicgstab`, van der Vorst). The incident radiation of the solution is smoothed over neighbouring zones
//! (`smoothing`), which reduces the noise and gives its error, and in large scenes resampled where it remains noisy
//! (`adaptive_resampling`). One product costs one read of every ray.

use super::adaptive_resampling::{AdaptiveResampling, SmoothedFields};
use super::padded_bands::{LANES, PaddedBands, padded};
use super::path_continuation::{PathLights, VertexSource};
use super::ray_sampling::{RaysPerZone, uses_rays_only};
use super::ray_table::{IncidentEstimate, PathExtent, RayTable};
use super::ray_tracer::RayTracer;
use super::smoothing::Smoother;
use crate::direct_light::light_field::DirectLight;
use crate::iteration::multivector::total;
use crate::iteration::{IterationResult, LinearSystem, StoppingCriterion, bicgstab, neumann_series};
use crate::light_groups::SourceGroup;
use crate::operator::{ErrorModel, ExchangeOperator, IncidentPower};
use crate::solve_context::SolveContext;
use crate::surroundings::SurroundingsExchange;
use crate::zone_power::{closure_targets, reflection_weights};
use rayon::prelude::*;
use zonal_exchange::pair::scaled_radiosity_coefficient;
use zonal_math::Grade;
use zonal_scene::{Bands, NoCheckpoints, Scene, Zones};
use zonal_transport::Transport;

/// The equations are solved by the first 1/4 of the rays of every zone first; all rays start from that solution.
const INITIAL_SOLVE_DIVISOR: usize = 4;
/// End of the iteration: relative error of the strengths, and products of a column.
const RAY_SOLVE_STOP: StoppingCriterion = StoppingCriterion { residual: 2e-4, max_iterations: 200 };

/// Whether rays continue from patches that they hit close by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathContinuation {
    /// Rays end in the first zone.
    Off,
    /// Rays from patches continue (`path_continuation`).
    On,
}

/// The exchange of all zones by the rays of a table.
pub struct RayOperator<'a> {
    scene: &'a Scene,
    zones: &'a Zones,
    transport: &'a Transport<'a>,
    direct: &'a DirectLight,
    table: RayTable,
    continuation: PathContinuation,
    /// c of every zone.
    coefficients: Vec<Bands>,
    /// Source terms at path vertices, a group; empty where paths do not continue.
    sources: Vec<VertexSource>,
}

/// The incident radiation of a solution by rays.
pub struct RayIncident {
    /// Smoothed incident power of every column, W.
    pub columns: Vec<Vec<Bands>>,
    /// Estimated error of the sum of the columns, W.
    pub(crate) error: Vec<Bands>,
    /// Incident power of all columns together before smoothing, W.
    pub unsmoothed: Vec<Bands>,
    /// Standard error of `unsmoothed` by the variance of the rays, W.
    pub(crate) unsmoothed_error: Vec<Bands>,
    /// Relative error of a combination of the columns in which all have the same weight.
    pub(crate) equal_weight_error: f64,
    /// Rays added by adaptive resampling.
    pub(crate) resampled_rays: u64,
}

impl<'a> RayOperator<'a> {
    /// Traces `rays_per_zone` rays of every patch, and of every volume zone.
    pub fn new(
        context: &SolveContext<'a>,
        rays_per_zone: RaysPerZone,
        continuation: PathContinuation,
    ) -> RayOperator<'a> {
        let lights =
            (continuation == PathContinuation::On).then(|| PathLights::new(context.scene, context.direct));
        let zones = context.zones;
        RayOperator {
            scene: context.scene,
            zones,
            transport: context.transport,
            direct: context.direct,
            table: RayTable::trace(context, rays_per_zone, lights.as_ref()),
            continuation,
            coefficients: (0..zones.len())
                .into_par_iter()
                .map(|i| scaled_radiosity_coefficient(zones, i))
                .collect(),
            sources: Vec::new(),
        }
    }

    /// Number of rays, and of path vertices.
    pub(crate) fn rays_and_vertices(&self) -> [u64; 2] {
        self.table.rays_and_vertices()
    }

    /// Writes into `surroundings` the exchange with the surroundings by the same rays.
    pub(crate) fn measure_escape(&self, surroundings: &mut SurroundingsExchange) {
        self.table.measure_escape(self.zones, surroundings);
    }

    /// Solves all groups by the rays, or follows the scattering orders that the scene fixes. Returns the strengths of every group.
    pub fn solve(&mut self, context: &SolveContext, surroundings: &SurroundingsExchange) -> Vec<Vec<Bands>> {
        self.solve_groups(context, surroundings).into_iter().map(|e| e.strengths).collect()
    }

    /// The results of the iteration of [`RayOperator::solve`] for all groups.
    pub(crate) fn solve_groups(
        &mut self,
        context: &SolveContext,
        surroundings: &SurroundingsExchange,
    ) -> Vec<IterationResult> {
        let (weights, targets) = (reflection_weights(self.zones), closure_targets(self.zones));
        // Move the source terms at path vertices to the right-hand side.
        let mut columns = context.source_strengths(surroundings);
        if self.rays_and_vertices()[1] > 0 {
            let sources = columns.iter().zip(context.sources).map(|(c, s)| self.vertex_source(context, s, c));
            self.sources = sources.collect();
            for (column, source) in columns.iter_mut().zip(&self.sources) {
                let dark = vec![[0.0; LANES]; self.len()];
                let lit = self.times_measure(self.table.incident(&dark, PathExtent::WithSource(source), 1));
                let add = |i: usize, s: &mut Bands| *s += weights[i] * lit[i];
                column.par_iter_mut().enumerate().for_each(|(i, s)| add(i, s));
            }
        }
        if let Some(count) = context.scene.options().scattering_orders {
            let operator = &ContinuedRays { rays: self, divisor: 1 };
            let system = LinearSystem { operator, weights: &weights, targets: &targets };
            return neumann_series::solve(&system, &columns, count, &NoCheckpoints, context.progress);
        }
        // Solve by a part of the rays, then by all.
        let solved = |divisor: usize, initial| {
            let operator = &ContinuedRays { rays: self, divisor };
            let system = LinearSystem { operator, weights: &weights, targets: &targets };
            bicgstab::solve(&system, &columns, initial, RAY_SOLVE_STOP, context.progress)
        };
        let initial = solved(INITIAL_SOLVE_DIVISOR, None);
        solved(1, Some(initial.into_iter().map(|e| e.strengths).collect()))
    }

    /// The source term of a group with source strengths `column` at path vertices: all of it except the lights sampled there.
    fn vertex_source(&self, context: &SolveContext, group: &SourceGroup, column: &[Bands]) -> VertexSource {
        let direct = group.direct(context.direct);
        let one = |(i, s): (usize, &Bands)| {
            let (c, p) = (self.coefficients[i], &self.zones.patches[i]);
            let lit = direct.get(i).copied().unwrap_or_default();
            let all = s.zip_map(c, |s, c| if c > 0.0 { s / c } else { 0.0 });
            padded((all - p.reflectance * lit).map(|source| source.max(0.0)))
        };
        let factor = |l: usize| if group.has_light(l) { 1.0 } else { 0.0 };
        VertexSource {
            patches: column[..self.zones.voxel_offset()].par_iter().enumerate().map(one).collect(),
            lights: (0..context.direct.lights.len()).map(factor).collect(),
        }
    }

    /// How the paths of column `c` are followed.
    fn extent(&self, c: usize) -> PathExtent<'_> {
        self.sources.get(c).map_or(PathExtent::FirstZone, PathExtent::WithSource)
    }

    /// B of all zones by their strengths, W/m².
    fn radiosities(&self, strengths: &[Bands]) -> Vec<PaddedBands> {
        let over = |s: f64, c: f64| if c > 0.0 { s / c } else { 0.0 };
        let both = strengths.par_iter().zip(&self.coefficients);
        both.map(|(s, c)| padded(s.zip_map(*c, over))).collect()
    }

    /// Multiplies H by areas and G by volumes.
    fn times_measure(&self, v: Vec<Bands>) -> Vec<Bands> {
        v.into_par_iter().enumerate().map(|(i, v)| v * self.zones.response(i).1).collect()
    }
}

impl ExchangeOperator for RayOperator<'_> {
    fn len(&self) -> usize {
        self.zones.len()
    }
    fn apply(&self, strengths: &[Bands]) -> Vec<Bands> {
        self.times_measure(self.table.incident(&self.radiosities(strengths), PathExtent::FirstZone, 1))
    }
    fn scale(&mut self, _: &[Bands]) {}
}

impl ErrorModel for RayOperator<'_> {
    fn incident_power(&self, columns: &[Vec<Bands>]) -> IncidentPower {
        let RayIncident { columns, error, .. } = self.estimate_incident(columns);
        IncidentPower { columns, error: Some(error) }
    }
    fn grade(&self) -> Grade {
        Grade::Statistical
    }
}

/// The same exchange with continued paths, by the first 1/`divisor` of the rays of every zone.
struct ContinuedRays<'a, 'b> {
    rays: &'a RayOperator<'b>,
    divisor: usize,
}

impl ExchangeOperator for ContinuedRays<'_, '_> {
    fn len(&self) -> usize {
        self.rays.len()
    }
    fn apply(&self, strengths: &[Bands]) -> Vec<Bands> {
        let b = self.rays.radiosities(strengths);
        self.rays.times_measure(self.rays.table.incident(&b, PathExtent::Continued, self.divisor))
    }
    fn scale(&mut self, _: &[Bands]) {}
}

impl RayOperator<'_> {
    /// Radiosities in which every group has the same weight: windows chosen for them suit each group, also after relighting.
    fn equal_weight_guide(&self, columns: &[Vec<Bands>]) -> (Vec<PaddedBands>, VertexSource) {
        let mut out = vec![[0.0f32; LANES]; self.len()];
        let mut source = VertexSource::default();
        for (c, s) in columns.iter().enumerate() {
            let b = self.radiosities(s);
            let square = b.iter().flatten().map(|x| (*x as f64).powi(2)).sum::<f64>();
            let level = (square / b.len().max(1) as f64).sqrt();
            if level > 0.0 {
                out.iter_mut()
                    .zip(&b)
                    .for_each(|(o, b)| (0..LANES).for_each(|k| o[k] += b[k] / level as f32));
                self.sources.get(c).into_iter().for_each(|o| source.add_scaled(o, 1.0 / level as f32));
            }
        }
        (out, source)
    }

    /// Incident radiation of radiosities `b` with the source term `source` at path vertices.
    fn incident_with_error(&self, b: &[PaddedBands], source: &VertexSource) -> Vec<IncidentEstimate> {
        let extent =
            if self.sources.is_empty() { PathExtent::FirstZone } else { PathExtent::WithSource(source) };
        self.table.incident_with_error(b, extent)
    }

    /// Incident radiation of every column of strengths, smoothed and resampled, with its error.
    pub fn estimate_incident(&self, columns: &[Vec<Bands>]) -> RayIncident {
        // Sum the rays of all columns together with their standard error, and of each column.
        let radiosity: Vec<Vec<PaddedBands>> = columns.iter().map(|s| self.radiosities(s)).collect();
        let mut source = VertexSource::default();
        self.sources.iter().for_each(|o| source.add_scaled(o, 1.0));
        let all = self.radiosities(&total(self.len(), columns));
        let estimate = self.incident_with_error(&all, &source);
        let of_column = |(c, b): (usize, &Vec<PaddedBands>)| match columns.len() {
            1 => estimate.iter().map(|m| m.value).collect(),
            _ => self.table.incident(b, self.extent(c), 1),
        };
        let raw: Vec<Vec<Bands>> = radiosity.iter().enumerate().map(of_column).collect();
        // Smooth over windows chosen by an equally weighted sum.
        let guide = (columns.len() > 1).then(|| {
            let (b, source) = self.equal_weight_guide(columns);
            self.incident_with_error(&b, &source)
        });
        let smoother = Smoother::new(self.scene, self.zones, self.transport);
        let mut smoothed = smoother.smooth(guide.as_ref().unwrap_or(&estimate), &estimate, &raw);
        drop(smoother);
        // Resample noisy zones of large scenes.
        let mut fields = SmoothedFields {
            raw: &raw,
            estimate: &estimate,
            columns: &mut smoothed.columns,
            error: &mut smoothed.error,
        };
        let resampled_rays = match uses_rays_only(self.zones) {
            true => self.resampling(&radiosity).resample(&mut fields, &self.direct.fields(self.len())),
            false => 0,
        };
        // Convert to incident power.
        let (value, standard_error) = estimate.into_iter().map(|m| (m.value, m.error)).unzip();
        let [patches, volumes] = smoothed.guide_error;
        RayIncident {
            columns: smoothed.columns.into_iter().map(|f| self.times_measure(f)).collect(),
            error: self.times_measure(smoothed.error),
            unsmoothed: self.times_measure(value),
            unsmoothed_error: self.times_measure(standard_error),
            equal_weight_error: patches.max(volumes),
            resampled_rays,
        }
    }

    fn resampling<'b>(&'b self, radiosity: &'b [Vec<PaddedBands>]) -> AdaptiveResampling<'b> {
        let continues = self.continuation == PathContinuation::On;
        AdaptiveResampling {
            scene: self.scene,
            tracer: RayTracer::new(self.scene, self.zones, self.transport),
            lights: continues.then(|| PathLights::new(self.scene, self.direct)),
            table: &self.table,
            radiosity,
            sources: &self.sources,
        }
    }
}
