//! The exchange operator of a ray table.
//!
//! The operator is not symmetric, as the exchange of i with j is sampled at i alone; its equations are solved by stabilised
//! bi-conjugate gradients (`iteration::bicgstab`, van der Vorst). The incident radiation of the solution is sampled afresh by a final gather
//! (`gather`), which gives its error. One product costs one read of every ray.

use crate::context::SolveContext;
use crate::distribution::Execution;
use crate::distribution::multivector::{self, total};
use crate::distribution::sum_order::SumOrder;
use crate::engines::merged_operator::PatchGroups;
use crate::engines::rays::gather::final_gather::{self, Gathered};
use crate::engines::rays::gather::gather_error::stated_errors;
use crate::engines::rays::gather::gather_task::{GatherTask, PassedOn};
use crate::engines::rays::gather::point_light::{LightPlace, PointLights};
use crate::engines::rays::gather::regression_windows::RegressionWindows;
use crate::engines::rays::gather::zone_gather::{GatherField, GatheredSky, Gatherer};
use crate::engines::rays::gather::zone_groups::ZoneGroups;
use crate::engines::rays::stored_rays::padded_bands::{LANES, PaddedBands, padded};
use crate::engines::rays::stored_rays::path_continuation::{PathLights, VertexSource};
use crate::engines::rays::stored_rays::ray_sampling::{RaysPerZone, rays_measure_escape};
use crate::engines::rays::stored_rays::ray_table::{PathExtent, RayTable};
use crate::engines::rays::stored_rays::ray_tracer::RayTracer;
use crate::iteration::{IterationResult, LinearSystem, StoppingCriterion, bicgstab, neumann_series};
use crate::operator::mixed_sides::mix_sides;
use crate::operator::{ErrorModel, ExchangeOperator, IncidentPower};
use crate::right_hand_side::direct_light::light_field::DirectLight;
use crate::right_hand_side::light_groups::SourceGroup;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use crate::settings::zone_power::{closure_targets, reflection_weights};
use rayon::prelude::*;
use zonal_exchange::pair::{pane_self_exchange, scaled_radiosity_coefficient};
use zonal_math::parallel;
use zonal_math::{Grade, low_discrepancy};
use zonal_scene::{
    Bands, CheckpointStore, NoCheckpoints, NoProgress, PaneZone, Progress, Scene, ZoneRef, Zones,
};
use zonal_transport::Transport;

/// The equations are solved by the first 1/4 of the rays of every zone first; all rays start from that solution.
const INITIAL_SOLVE_DIVISOR: usize = 4;
/// Relative error of the strengths at which the iteration ends, over the tolerance.
const SOLVE_ERROR_OVER_TOLERANCE: f64 = 2e-3;
/// Smallest relative error of the strengths that is asked for.
const MIN_SOLVE_ERROR: f64 = 2e-4;

/// End of the iteration for the noise of the radiosities, of which the size matters only.
const NOISE_SOLVE_STOP: StoppingCriterion = StoppingCriterion { residual: 0.05, max_iterations: 40 };
/// End of the iteration for small changes of a solution.
const CHANGE_SOLVE_STOP: StoppingCriterion = StoppingCriterion { residual: 0.02, max_iterations: 40 };
/// Seed of the signs of that noise.
const NOISE_SEED: u64 = 0x9d39_247e_3377_6d41;

/// Whether rays continue from patches that they hit close by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathContinuation {
    /// Rays end in the first zone.
    Off,
    /// Rays from patches continue (`path_continuation`).
    On,
}

/// Radiation that a gather meets beside the columns.
#[derive(Default)]
pub(crate) struct OutsideRadiation<'a> {
    /// H or G of known value and its error, W/m², of every zone; it is no part of the result.
    pub known: &'a [[Bands; 2]],
    /// The surroundings, where the gather samples them.
    pub sky: Option<GatheredSky>,
    /// Error of every zone by panes whose light varies over their thickness, W/m²; empty without panes that scatter.
    pub thickness: Vec<Bands>,
    /// Factor of every light of the scene in the radiosities of a column; empty where these are not those of a solution.
    pub light_factors: Vec<Vec<f32>>,
}

/// The exchange of all zones by the rays of a table.
pub struct RayOperator<'a> {
    scene: &'a Scene,
    zones: &'a Zones,
    transport: &'a Transport<'a>,
    direct: &'a DirectLight,
    table: RayTable<'a>,
    continuation: PathContinuation,
    /// c of every zone.
    coefficients: Vec<Bands>,
    /// Source terms at path vertices, a group; empty where paths do not continue.
    sources: Vec<VertexSource>,
    /// Fraction of its own emission that each pane zone absorbs.
    pane_self_exchange: Vec<Bands>,
    /// Patches that share one radiosity.
    groups: Option<PatchGroups>,
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
            coefficients: parallel::collect(zones.len(), |i| scaled_radiosity_coefficient(zones, i)),
            sources: Vec::new(),
            pane_self_exchange: zones.panes.iter().map(self_absorbed_fraction).collect(),
            groups: PatchGroups::of(zones),
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
        // Move the source terms at path vertices to the right-hand side.
        let mut columns = context.source_strengths(surroundings);
        if self.rays_and_vertices()[1] > 0 {
            let sources = columns.iter().zip(context.sources).map(|(c, s)| self.vertex_source(context, s, c));
            self.sources = sources.collect();
            for (column, source) in columns.iter_mut().zip(&self.sources) {
                let dark = vec![[0.0; LANES]; self.len()];
                let lit =
                    self.scattered_strengths(self.table.incident(&dark, PathExtent::WithSource(source), 1));
                parallel::for_each(column, |i, s| *s += lit[i]);
            }
        }
        if let Some(count) = context.scene.options().scattering_orders {
            return self.with_system(1, |system| {
                neumann_series::solve(system, &columns, count, &NoCheckpoints, context.settings.progress)
            });
        }
        // Solve by a part of the rays, then by all.
        let stop = StoppingCriterion {
            residual: MIN_SOLVE_ERROR.max(SOLVE_ERROR_OVER_TOLERANCE * context.scene.options().tolerance),
            max_iterations: context.scene.options().max_iterations,
        };
        let solved = |divisor: usize, initial| {
            let progress = context.settings.progress;
            self.with_system(divisor, |system| bicgstab::solve(system, &columns, initial, stop, progress))
        };
        let initial = solved(INITIAL_SOLVE_DIVISOR, None);
        solved(1, Some(initial.into_iter().map(|e| e.strengths).collect()))
    }

    /// `f` of the equations by the first 1/`divisor` of the rays of every zone.
    fn with_system<T>(&self, divisor: usize, f: impl FnOnce(&LinearSystem) -> T) -> T {
        let operator = &ContinuedRays { rays: self, divisor };
        let (weights, targets) = (reflection_weights(self.zones), closure_targets(self.zones));
        let (weights, sums) = ((&weights).into(), SumOrder::plain());
        f(&LinearSystem { operator, weights, targets: &targets, sums })
    }

    /// The strengths that incident radiation, H and G in W/m², adds to the zones.
    fn scattered_strengths(&self, incident: Vec<Bands>) -> Vec<Bands> {
        let (mut lit, weights) = (self.times_measure(incident), reflection_weights(self.zones));
        mix_sides(self.zones, &mut lit);
        parallel::for_each(&mut lit, |i, s| *s *= weights[i]);
        lit
    }

    /// The source term of a group with source strengths `column` at path vertices: all of it except the lights sampled there.
    fn vertex_source(&self, context: &SolveContext, group: &SourceGroup, column: &[Bands]) -> VertexSource {
        let direct = group.direct(context.direct);
        let one = |i: usize| {
            let p = &self.zones.patches[i];
            let lit = direct.get(i).copied().unwrap_or_default();
            padded((self.radiosity_of(i, column[i]) - p.reflectance * lit).map(|source| source.max(0.0)))
        };
        VertexSource {
            patches: parallel::collect(self.zones.patches.len(), one),
            lights: light_factors(context, group),
        }
    }

    /// Incident power of every column of strengths by a final gather, W.
    pub fn gathered_power(&self, columns: &[Vec<Bands>]) -> Vec<Vec<Bands>> {
        self.incident_power_of(self.gather_alone(columns)).columns
    }

    /// The powers and errors of a gather.
    pub(crate) fn incident_power_of(&self, gathered: Gathered) -> IncidentPower {
        IncidentPower {
            columns: gathered.columns.into_iter().map(|f| self.times_measure(f)).collect(),
            error: Some(self.times_measure(gathered.error)),
            column_errors: gathered.column_errors.into_iter().map(|e| self.times_measure(e)).collect(),
        }
    }

    /// B of all zones by their strengths, W/m²; of merged patches the mean.
    fn radiosities(&self, strengths: &[Bands]) -> Vec<PaddedBands> {
        if let Some(groups) = &self.groups {
            return self.single_radiosities(&groups.averaged(strengths));
        }
        self.single_radiosities(strengths)
    }

    fn single_radiosities(&self, strengths: &[Bands]) -> Vec<PaddedBands> {
        parallel::collect(strengths.len(), |i| padded(self.radiosity_of(i, strengths[i])))
    }

    /// Multiplies H by areas and G by volumes.
    fn times_measure(&self, mut v: Vec<Bands>) -> Vec<Bands> {
        parallel::for_each(&mut v, |i, x| *x *= self.zones.response(i).1);
        v
    }
}

impl ExchangeOperator for RayOperator<'_> {
    fn len(&self) -> usize {
        self.zones.len()
    }
    fn apply(&self, strengths: &[Bands]) -> Vec<Bands> {
        self.times_measure(self.stored_incident(strengths))
    }
    fn scale(&mut self, _: &[Bands]) {}
}

impl ErrorModel for RayOperator<'_> {
    fn incident_power(&self, columns: &[Vec<Bands>]) -> IncidentPower {
        self.incident_power_of(self.gather_alone(columns))
    }
    fn grade(&self) -> Grade {
        Grade::Statistical
    }
}

/// Optical depth below which a pane absorbs nothing of its own emission.
const TRANSPARENT_DEPTH: f64 = 1e-9;

/// Cosine of the light that falls on a pane, and rate per optical depth at which diffuse light leaves the depths of a pane.
const TYPICAL_COSINE: f64 = 0.7;
const DIFFUSE_RATE: f64 = 2.0;

/// The relative excess of the mean fluence over the thickness of a pane of optical depth x over that from which its far face sends light, for light from one side.
///
/// With the fluence e^(−u/μ) at the depth u and the share e^(−2(x−u)) of what leaves there by the far face: 1 − ⟨e^(−u/μ)⟩_far/⟨e^(−u/μ)⟩.
fn excess_of_mean(x: f64) -> f64 {
    let (rate, share) =
        (1.0 / TYPICAL_COSINE, |r: f64| if x * r > 1e-6 { -(-x * r).exp_m1() / (x * r) } else { 1.0 });
    // ∫ e^(−u/μ) e^(−2(x−u)) du = e^(−x/μ) ∫ e^((1/μ−2)s) ds over the distance s from the far face.
    let far = (-x * rate).exp() * share(DIFFUSE_RATE - rate) / share(DIFFUSE_RATE);
    1.0 - (far / share(rate)).min(1.0)
}

/// Fraction of its own emission 4κt that a pane absorbs, of an area of 1.
fn self_absorbed_fraction(pane: &PaneZone) -> Bands {
    let t = pane.thickness;
    let fraction = |k: f64| pane_self_exchange(k, t) * k / (4.0 * t);
    pane.extinction.map(|k| if k * t > TRANSPARENT_DEPTH { fraction(k) } else { 0.0 })
}

/// The median radiosity of the patches by area in each band, W/m².
pub(super) fn typical_radiosity(zones: &Zones, b: &[PaddedBands]) -> PaddedBands {
    let patches = &zones.patches;
    let half = 0.5 * patches.iter().map(|p| p.area).sum::<f64>();
    std::array::from_fn(|k| {
        let mut order: Vec<usize> = (0..patches.len()).collect();
        order.par_sort_unstable_by(|&i, &j| b[i][k].total_cmp(&b[j][k]).then(i.cmp(&j)));
        let mut sum = 0.0;
        let median = order.into_iter().find(|&i| {
            sum += patches[i].area;
            sum >= half
        });
        median.map_or(0.0, |i| b[i][k])
    })
}

/// A brightness of every zone in which each column has the same weight, as has their sum: radiosities above the typical ones over their mean.
pub(super) fn mean_brightness(columns: &[Vec<PaddedBands>], typical: &[PaddedBands]) -> Vec<f64> {
    let zones = columns.first().map_or(0, Vec::len);
    let of = |b: &PaddedBands, typical: &PaddedBands| {
        b.iter().zip(typical).map(|(x, t)| f64::from((x - t).max(0.0))).sum::<f64>()
    };
    let level = |list: &mut dyn Iterator<Item = f64>| list.sum::<f64>() / zones.max(1) as f64;
    let mut out = vec![0.0; zones];
    let mut add = |value: &dyn Fn(usize) -> f64| {
        let level = level(&mut (0..zones).map(value));
        if level > 0.0 {
            out.iter_mut().enumerate().for_each(|(i, o)| *o += value(i) / level);
        }
    };
    columns.iter().zip(typical).for_each(|(c, t)| add(&|i| of(&c[i], t)));
    add(&|i| columns.iter().zip(typical).map(|(c, t)| of(&c[i], t)).sum());
    out
}

/// The factor of every light in a group.
pub(crate) fn light_factors(context: &SolveContext, group: &SourceGroup) -> Vec<f32> {
    (0..context.direct.lights.len()).map(|l| if group.has_light(l) { 1.0 } else { 0.0 }).collect()
}

/// True if the sum of squares of `a` exceeds that of `b` in some band.
fn exceeds(a: &[PaddedBands], b: &[PaddedBands]) -> bool {
    let [a, b] = [a, b].map(|list| {
        multivector::sum(list.len(), |i| -> [f64; LANES] {
            std::array::from_fn(|k| f64::from(list[i][k]).powi(2))
        })
    });
    a.iter().zip(b).any(|(a, b)| *a > b)
}

/// The same exchange with continued paths, by the first 1/`divisor` of the rays of every zone, and the sides of transmitting sheets mixed.
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
        let mut power =
            self.rays.times_measure(self.rays.table.incident(&b, PathExtent::Continued, self.divisor));
        mix_sides(self.rays.zones, &mut power);
        power
    }
    fn scale(&mut self, _: &[Bands]) {}
}

impl RayOperator<'_> {
    /// Standard error of the incident radiation of radiosities `b` with the source term `source` at path vertices, W/m²; with that of the surroundings where
    /// these rays measure it.
    fn standard_error(&self, b: &[PaddedBands], source: &VertexSource) -> Vec<Bands> {
        let extent =
            if self.sources.is_empty() { PathExtent::FirstZone } else { PathExtent::WithSource(source) };
        let sky = if rays_measure_escape(self.scene, self.zones) {
            padded(self.scene.surroundings().radiosity())
        } else {
            [0.0; LANES]
        };
        self.table.standard_error(b, sky, extent)
    }

    /// H or G of every zone from the surroundings alone by a final gather, W/m²; `shares` holds the share of the rays of every zone that leave the
    /// scene.
    pub fn gathered_surroundings(&self, shares: Vec<f64>) -> Vec<Bands> {
        let (n, radiosity) = (self.len(), self.scene.surroundings().radiosity());
        let sky = GatheredSky { radiosity, column: 0, shares };
        let dark = [vec![Bands::ZERO; n]];
        let noise = vec![[0.0; LANES]; n];
        let outside = OutsideRadiation { sky: Some(sky), ..OutsideRadiation::default() };
        let stored = || self.stored_fields(&dark);
        self.gather_incident(&dark, &stored, noise, outside, &NoCheckpoints, &NoProgress).sky
    }

    /// A final gather of every column of strengths without further radiation.
    fn gather_alone(&self, columns: &[Vec<Bands>]) -> Gathered {
        let noise = self.radiosity_noise(columns, &NoProgress);
        let (stored, outside) = (|| self.stored_fields(columns), OutsideRadiation::default());
        self.gather_incident(columns, &stored, noise, outside, &NoCheckpoints, &NoProgress)
    }

    /// Incident radiation of every column of strengths by a final gather, W/m². `noise` is that of the radiosities ([`RayOperator::radiosity_noise`]);
    /// `stored` gives [`RayOperator::stored_fields`] of the columns, where they are needed.
    pub(crate) fn gather_incident(
        &self,
        columns: &[Vec<Bands>],
        stored: &(dyn Fn() -> Vec<Vec<Bands>> + Sync),
        noise: Vec<PaddedBands>,
        outside: OutsideRadiation,
        checkpoints: &dyn CheckpointStore,
        progress: &dyn Progress,
    ) -> Gathered {
        let execution = Execution { communicator: self.table.communicator(), progress };
        let sky = outside.sky.as_ref();
        let mut radiosity: Vec<Vec<PaddedBands>> = columns.iter().map(|s| self.radiosities(s)).collect();
        let mut typical: Vec<_> = radiosity.iter().map(|b| typical_radiosity(self.zones, b)).collect();
        let brightness = mean_brightness(&radiosity, &typical);
        typical.push([0.0; LANES]);
        radiosity.push(noise);
        let tracer = RayTracer::new(self.scene, self.zones, self.transport);
        let lights =
            (self.continuation == PathContinuation::On).then(|| PathLights::new(self.scene, self.direct));
        let own = |i: usize, c: usize| match self.zones.zone(i) {
            ZoneRef::Pane(k, _) => self.pane_self_exchange[k] * self.radiosity_of(i, columns[c][i]),
            _ => Bands::ZERO,
        };
        let points = lights
            .as_ref()
            .filter(|_| !outside.light_factors.is_empty())
            .map(|l| self.point_lights(l, outside.light_factors, &radiosity[..columns.len()]))
            .filter(|points| points.has_light() || tracer.has_textures());
        let field =
            GatherField { columns: radiosity, typical, sources: self.sources.iter().collect(), sky, points };
        let gatherer = Gatherer::new(&tracer, lights, field, &brightness);
        let windows = RegressionWindows::new(self.scene, self.zones, self.transport);
        let task = GatherTask {
            zones: self.zones,
            zone_groups: &ZoneGroups::new(self.scene, self.zones),
            windows: &windows,
            groups: columns.len(),
            sky,
            tolerance: self.scene.options().tolerance,
            known: outside.known,
            thickness: &outside.thickness,
            own: &own,
            passed_on: &|changes| self.passed_on(changes, progress),
            stored,
            stored_rays: self.table.rays_per_zone(),
            checkpoints,
            execution,
        };
        final_gather::gather(gatherer, &task)
    }

    /// The lights that a gather of these radiosities can read at points, with their factors in every column.
    fn point_lights(
        &self,
        lights: &PathLights,
        factors: Vec<Vec<f32>>,
        radiosity: &[Vec<PaddedBands>],
    ) -> PointLights {
        let place = LightPlace { lights, transport: self.transport, zones: self.zones };
        let largest =
            |i: usize| (0..LANES).map(|k| radiosity.iter().map(|b| b[i][k]).sum::<f32>()).fold(0.0, f32::max);
        PointLights::new(place, factors, self.groups.as_ref(), largest)
    }

    /// H or G of every column of strengths by the stored rays, W/m².
    pub(crate) fn stored_fields(&self, columns: &[Vec<Bands>]) -> Vec<Vec<Bands>> {
        columns.iter().map(|s| self.stored_incident(s)).collect()
    }

    /// H or G of every zone by the stored rays, W/m².
    pub(crate) fn stored_incident(&self, strengths: &[Bands]) -> Vec<Bands> {
        self.table.incident(&self.radiosities(strengths), PathExtent::FirstZone, 1)
    }

    /// The incident powers of a solution by its stored rays alone, without a gather: `incident` is H or G of every column of strengths, W/m², and `noise` that of the
    /// radiosities. The stated errors are those of the rays of each zone, and of the radiosities.
    pub(crate) fn stored_power(
        &self,
        columns: &[Vec<Bands>],
        incident: Vec<Vec<Bands>>,
        noise: &[PaddedBands],
    ) -> IncidentPower {
        let groups = ZoneGroups::new(self.scene, self.zones);
        let (sum, from_noise) = (total(self.len(), &incident), self.incident_noise(noise));
        let stated = |strengths: &[Bands], source: &VertexSource, own: &[Bands]| {
            let of_rays = self.standard_error(&self.radiosities(strengths), source);
            self.times_measure(stated_errors(&groups, &of_rays, &from_noise, [own, &sum]))
        };
        // Where paths do not continue there are no sources at their vertices.
        let mut all = VertexSource::default();
        self.sources.iter().for_each(|source| all.add_scaled(source, 1.0));
        let source = |c: usize| self.sources.get(c).unwrap_or(&all);
        IncidentPower {
            error: Some(stated(&total(self.len(), columns), &all, &sum)),
            column_errors: (0..columns.len()).map(|c| stated(&columns[c], source(c), &incident[c])).collect(),
            columns: incident.into_iter().map(|f| self.times_measure(f)).collect(),
        }
    }

    /// Replaces what the pane zones send to themselves, in a gather of the solution whose rays give `stored` H or G, W/m², of every column.
    ///
    /// A gather G' reads the pane's own radiosity as the stored rays have it. With the share a = f Ω of G by which f of the own radiosity returns,
    /// the value that is consistent with itself is G = G' + a (G − G_stored) = G' + (G' − G_stored) a/(1 − a).
    pub(crate) fn solve_pane_self_exchange(&self, stored: &[Vec<Bands>], gathered: &mut Gathered) {
        for (k, f) in self.pane_self_exchange.iter().enumerate() {
            let i = self.zones.pane_index(k);
            let share = 4.0 * *f * self.zones.response(i).0;
            let gain = share.map(|a| 1.0 / (1.0 - a));
            for (column, stored) in gathered.columns.iter_mut().zip(stored) {
                let more = (column[i] - stored[i]) * share * gain;
                column[i] += more;
            }
            gathered.column_errors.iter_mut().for_each(|e| e[i] *= gain);
            gathered.error[i] *= gain;
        }
    }

    /// One realization of the noise of the radiosities of the sum of all columns, W/m²: the solution for sources ρ_i e_i of random sign, e_i the
    /// standard error of the incident radiation by the rays of zone i.
    pub(crate) fn radiosity_noise(
        &self,
        columns: &[Vec<Bands>],
        progress: &dyn Progress,
    ) -> Vec<PaddedBands> {
        let b = self.radiosities(&total(self.len(), columns));
        let mut source = VertexSource::default();
        self.sources.iter().for_each(|o| source.add_scaled(o, 1.0));
        let error = self.standard_error(&b, &source);
        let weights = reflection_weights(self.zones);
        let sign =
            |i: usize| if low_discrepancy::hash_to_unit(i as u64 ^ NOISE_SEED) < 0.5 { -1.0 } else { 1.0 };
        let noise = |i: usize| sign(i) * weights[i] * error[i] * self.zones.response(i).1;
        let column = [parallel::collect(self.len(), noise)];
        let solve = |divisor: usize| {
            let solved = self.with_system(divisor, |system| {
                bicgstab::solve(system, &column, None, NOISE_SOLVE_STOP, progress)
            });
            self.radiosities(&solved[0].strengths)
        };
        // Among a few rays may be white zones whose rays all end on one another; what they hold back exceeds the light itself.
        let few = solve(INITIAL_SOLVE_DIVISOR);
        if exceeds(&few, &b) { solve(1) } else { few }
    }

    /// The response of the solution by the stored rays to changes of the incident radiation of all zones, W/m².
    fn passed_on(&self, changes: &[Vec<Bands>], progress: &dyn Progress) -> Vec<PassedOn> {
        let columns: Vec<Vec<Bands>> = changes.iter().map(|c| self.scattered_strengths(c.clone())).collect();
        let solved = self
            .with_system(1, |system| bicgstab::solve(system, &columns, None, CHANGE_SOLVE_STOP, progress));
        let passed_on = |solved: IterationResult| {
            let radiosity = self.radiosities(&solved.strengths);
            let incident = self.table.incident(&radiosity, PathExtent::Continued, 1);
            PassedOn { radiosity, incident }
        };
        solved.into_iter().map(passed_on).collect()
    }

    /// Error of the incident radiation of every zone by panes that have one radiosity over their thickness, W/m², for the incident radiation `all` of all zones:
    /// the response to the difference of each pane's radiosity from that of the face away from its light. Empty without panes that scatter.
    pub(crate) fn error_of_thick_panes(
        &self,
        all: impl Fn(usize) -> Bands + Sync,
        progress: &dyn Progress,
    ) -> Vec<Bands> {
        if self.zones.panes.is_empty() {
            return Vec::new();
        }
        let mut change = vec![Bands::ZERO; self.len()];
        for (k, pane) in self.zones.panes.iter().enumerate() {
            let i = self.zones.pane_index(k);
            let scatters = self.zones.response(i).0.map(|r| if r > 0.0 { 1.0 } else { 0.0 });
            change[i] = scatters * all(i) * (pane.extinction * pane.thickness).map(excess_of_mean);
        }
        if change.iter().all(|c| *c == Bands::ZERO) {
            return Vec::new();
        }
        self.passed_on(&[change], progress).swap_remove(0).incident
    }

    /// H or G of every zone from that noise by the stored rays, W/m².
    pub(crate) fn incident_noise(&self, noise: &[PaddedBands]) -> Vec<Bands> {
        self.table.incident(noise, PathExtent::Continued, 1)
    }

    fn radiosity_of(&self, i: usize, strength: Bands) -> Bands {
        strength.zip_map(self.coefficients[i], |s, c| if c > 0.0 { s / c } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn excess_of_the_mean_is_that_of_the_integrals() {
        for x in [0.01, 0.5, 3.0, 20.0] {
            let n = 20_000;
            let at = |k: usize| (k as f64 + 0.5) / n as f64 * x;
            let sums = (0..n).map(at).fold([0.0; 3], |[far, leaves, all], u| {
                let (light, share) = ((-u / TYPICAL_COSINE).exp(), (-DIFFUSE_RATE * (x - u)).exp());
                [far + light * share, leaves + share, all + light]
            });
            let [far, leaves, all] = sums;
            let want = 1.0 - (far / leaves) / (all / n as f64);
            let found = excess_of_mean(x);
            assert!((found - want).abs() < 1e-5 && (0.0..1.0).contains(&found), "{x}: {found}, not {want}");
        }
        assert_eq!(excess_of_mean(0.0), 0.0);
    }
}
