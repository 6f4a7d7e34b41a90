//! Exchange factors of the zones with the surroundings and with the black backs of one-sided surfaces, sampled by rays.
//!
//! g_i,sky = ∬ τ (cosine) dω dA/π over the directions that leave the scene, and likewise for the backs; for a volume zone without its κ.
//! Method: quasi-Monte Carlo with rays distributed by the kernel (`zone_rays`). A few pilot rays of every zone come first; if any of them
//! escapes, the scene is open, and all zones trace their full number of rays. Millions of zones share a total number of rays: a few each, since
//! their errors are independent, and twice as many if the pilot rays disagree. If the surroundings have a radiance, zones whose error exceeds a
//! share of the tolerance times the root mean square trace more rays; the error falls like the number of rays to the power of about −3/4. If
//! zones are few enough for thousands of rays each, `opening_sampling` takes over. Grade: statistical.

use super::opening_sampling::{MIN_RAYS_FOR_OPENINGS, OpeningSampler, RAYS_OVER_ERROR_EXPONENT};
use super::ray_tally::{RayTally, TracedScene};
use crate::distribution::Execution;
use zonal_exchange::pair::{SUCCESSION_PSEUDO_COUNTS, StripImages, closure_target, sample_seed};
use zonal_math::parallel;
use zonal_scene::{Band, Bands, Scene, Zones};
use zonal_transport::Transport;

// Limits on the number of rays to the surroundings.

/// Rays of a zone times the square of the tolerance, and limits of that number; the lower one falls with the square of tolerances above
/// `COARSE_TOLERANCE`.
const RAYS_TIMES_TOLERANCE_SQUARED: f64 = 0.05;
const ESCAPE_RAYS_PER_ZONE: [usize; 2] = [256, 4096];
/// Factor on the numbers of rays if the surroundings have a radiance.
const RADIANCE_FACTOR: usize = 4;
/// Pilot rays of a zone.
const PILOT_RAYS: usize = 64;
/// Rays of all zones together.
const TOTAL_RAYS: usize = 1 << 24;
/// Minimum number of rays of a zone.
const MIN_RAYS: usize = 8;
/// Factor on the rays of a zone whose pilot rays disagree.
const MIXED_FACTOR: usize = 2;
/// Wanted error over the tolerance times the root mean square of the exchange.
const ERROR_SHARE: f64 = 0.4;
/// Rounds of additional rays, and the largest growth of a zone's rays in a round.
const ROUNDS: usize = 2;
const MAX_GROWTH: f64 = 16.0;
/// Rays of a zone before opening sampling takes over.
const RAYS_BEFORE_OPENINGS: usize = 256;
/// Expected growth of the number of rays in a room with windows; for the cost estimate.
const EXPECTED_GROWTH: usize = 10;
/// Expected rays of a zone with opening sampling at the tolerance that follows; for the cost estimate.
const EXPECTED_OPENING_RAYS: f64 = 1500.0;
const EXPECTED_OPENING_TOLERANCE: f64 = 0.05;
/// Maximum number of rays of a zone.
const MAX_ESCAPE_RAYS_PER_ZONE: usize = 1 << 18;
/// Tolerance above which a zone may have fewer rays.
const COARSE_TOLERANCE: f64 = 0.12;
/// Tolerance below which the total number of rays grows, like the tolerance to the power of −4/3.
const FINE_TOLERANCE: f64 = 0.01;

/// Zones of a block that one rank measures.
const ZONES_PER_BLOCK: usize = 64;

/// Error of the exchange of a strip with the surroundings over its area: rounding of its row.
const STRIP_ERROR_OVER_AREA: f64 = 1e-10;

/// Exchange factors of every zone with the surroundings and with black backs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurroundingsExchange {
    /// g_i,sky, m² or m³; empty for zeros.
    pub sky: Vec<Bands>,
    /// g_i,backs, m² or m³; empty for zeros.
    pub backfaces: Vec<Bands>,
    /// Standard error of g_i,sky; empty if the surroundings have no radiance.
    pub error: Vec<Bands>,
    /// Number of rays.
    pub rays: u64,
}

impl SurroundingsExchange {
    /// Samples zones with up to `rays` rays each, with the sample number of [`zonal_exchange::pair::PairSettings`]: all zones, or the zones that `needs` names, and
    /// the others with pilot rays. Errors are known if the surroundings have a radiance, or if `needs` is given.
    pub fn measure(
        zones: &Zones,
        transport: &Transport,
        rays: usize,
        sample: u64,
        execution: Execution,
        needs: Option<&[bool]>,
    ) -> SurroundingsExchange {
        let scene = transport.scene();
        let needs_all = |i: usize| needs.is_none_or(|list| list[i]);
        let (n, progress) = (zones.len(), execution.progress);
        let (blocks, communicator) = (execution.blocks(n, ZONES_PER_BLOCK), execution.communicator);
        let has_radiance = scene.surroundings().has_radiance();
        progress.begin("surroundings", if has_radiance { 2 * n as u64 } else { n as u64 });
        let rays = if uses_openings(scene, n) { rays.min(RAYS_BEFORE_OPENINGS) } else { rays };
        let (each, pilot) = ray_counts(scene, n, rays);
        let traced = TracedScene { zones, transport, seed: sample_seed(sample), sky: None };
        // Trace the pilot rays, and the other rays if the scene is open.
        let mut tallies: Vec<RayTally> =
            blocks.map(communicator, |i| RayTally::of_zone(&traced, i, 0..pilot));
        if pilot < rays && tallies.iter().any(|x| x.escaped > 0) {
            tallies = blocks.map(communicator, |i| {
                let mut x = tallies[i];
                if !needs_all(i) {
                    return x;
                }
                let mixed = x.escaped > 0 && x.escaped < x.traced;
                let count = if mixed { (MIXED_FACTOR * each).min(rays) } else { each };
                x.add(&RayTally::of_zone(&traced, i, pilot..count));
                x
            });
        }
        progress.advance(n as u64);
        // Refine zones whose error is too large.
        if has_radiance {
            refine(&traced, &mut tallies, execution, &needs_all);
        }
        progress.end();
        let target = |i: usize| closure_target(zones, i);
        let mut exchange = SurroundingsExchange::from_tallies(&tallies, target);
        if (has_radiance || needs.is_some()) && !exchange.is_closed() {
            let error = |(i, x): (usize, &RayTally)| x.standard_error() * target(i);
            exchange.error = tallies.iter().enumerate().map(error).collect();
        }
        exchange
    }

    /// The exchange of infinitely long strips, exact to rounding; zeros if they close.
    pub(crate) fn of_strips(strips: &StripImages, zones: &Zones) -> SurroundingsExchange {
        let losses: Vec<[f64; 2]> = parallel::collect(zones.len(), |i| strips.losses(i));
        let list = |k: usize| -> Vec<Bands> {
            let open = losses.iter().any(|l| l[k] > 0.0);
            losses.iter().filter(|_| open).map(|l| Bands::splat(l[k])).collect()
        };
        let rounding = |i: usize| Bands::splat(STRIP_ERROR_OVER_AREA * closure_target(zones, i));
        let error = (0..zones.len()).map(rounding).collect();
        SurroundingsExchange { sky: list(0), backfaces: list(1), error, rays: 0 }
    }

    /// Power incident on zone `i` from surroundings of radiosity `sky`, in the unit of P, and its standard error.
    pub fn incoming(&self, i: usize, sky: Bands) -> [Bands; 2] {
        let error = self.error.get(i).copied().unwrap_or_default();
        let factor = self.sky_of(i);
        [factor * sky, error * sky]
    }

    /// Standard error of the fraction of a zone's power that escapes, for a zone with closure target `target`: measured, or the binomial error
    /// of the mean number of rays of a zone, which is no smaller.
    pub(crate) fn escape_fraction_error(&self, i: usize, target: f64) -> Bands {
        if let Some(e) = self.error.get(i) {
            return *e / target;
        }
        let rays = (self.rays as f64 / self.sky.len().max(1) as f64).max(1.0);
        let escaping = self.total_of(i);
        escaping.map(|escaping| {
            let share = (escaping / target).clamp(0.0, 1.0);
            (share * (1.0 - share) / rays).sqrt()
        })
    }

    /// Standard error of g_i,sky + g_i,backs of zone `i`, whose closure target is `target`, in the unit of these; 0 if no power leaves the scene. If all rays
    /// of the zone agree, by the rule of succession.
    pub(crate) fn loss_error(&self, i: usize, target: f64) -> Bands {
        if self.is_closed() {
            return Bands::ZERO;
        }
        let rays = (self.rays as f64 / self.sky.len().max(1) as f64).max(1.0);
        let share = |x: f64| (x / target).clamp(0.0, 1.0);
        let binomial = |x: f64| (share(x) * (1.0 - share(x)) / rays).sqrt();
        let fraction = match self.error.get(i) {
            Some(e) => (*e / target).hypot(self.backfaces_of(i).map(binomial)),
            None => self.total_of(i).map(binomial),
        };
        let least = if self.rays > 0 { 1.0 / (rays + SUCCESSION_PSEUDO_COUNTS) } else { 0.0 };
        fraction.zip_map(self.total_of(i), |e, x| e.max(least * if x > 0.0 { share(x) } else { 1.0 }))
            * target
    }

    /// Sets g_i,sky + g_i,backs of zone `i`, in the former proportion.
    pub(crate) fn set_loss(&mut self, i: usize, total: Bands) {
        let ratio = total.zip_map(self.total_of(i), |new, old| if old > 0.0 { new / old } else { f64::NAN });
        let (sky, backs) = (self.sky.is_empty(), self.backfaces.is_empty());
        for (factors, takes_all) in [(&mut self.sky, true), (&mut self.backfaces, sky)] {
            if let Some(x) = factors.get_mut(i) {
                let all = if takes_all || backs { total } else { Bands::ZERO };
                *x = Bands::from_fn(|b| if ratio[b].is_nan() { all[b] } else { x[b] * ratio[b] });
            }
        }
    }

    /// g_i,sky of zone `i`.
    pub(crate) fn sky_of(&self, i: usize) -> Bands {
        self.sky.get(i).copied().unwrap_or_default()
    }
    /// g_i,backs of zone `i`.
    pub(crate) fn backfaces_of(&self, i: usize) -> Bands {
        self.backfaces.get(i).copied().unwrap_or_default()
    }
    /// g_i,sky + g_i,backs of zone `i`.
    pub(crate) fn total_of(&self, i: usize) -> Bands {
        let (sky, backs) = (self.sky_of(i), self.backfaces_of(i));
        sky + backs
    }

    /// Multiplies the factors of every unknown by `d`, where closure is restored.
    pub fn scale(&mut self, d: &[Bands]) {
        for factors in [&mut self.sky, &mut self.backfaces] {
            factors.iter_mut().zip(d).for_each(|(x, d)| *x *= d);
        }
    }

    /// Zeros for all zones, to be filled by an engine that samples the surroundings itself.
    pub fn unmeasured(zones: &Zones) -> SurroundingsExchange {
        let zeros = vec![Bands::ZERO; zones.len()];
        SurroundingsExchange { sky: zeros.clone(), backfaces: zeros, ..SurroundingsExchange::default() }
    }

    /// Replaces the factors by those of the incident radiation `incident` of surroundings of radiosity `sky`, W/m², in the bands in which these radiate.
    /// `response` gives area or volume of each zone. The error of the result is that of the incident radiation, which contains it.
    pub(crate) fn set_incident(
        &mut self,
        incident: &[Bands],
        sky: Bands,
        response: impl Fn(usize) -> f64 + Sync,
        rays: u64,
    ) {
        parallel::for_each(&mut self.sky, |i, factor| {
            let measured = incident[i] * response(i);
            let replaced = |b: Band| if sky[b] > 0.0 { measured[b] / sky[b] } else { factor[b] };
            *factor = Bands::from_fn(replaced);
        });
        self.rays = rays;
    }

    /// Factors from tallies of zones with closure targets `target`.
    fn from_tallies(tallies: &[RayTally], target: impl Fn(usize) -> f64) -> SurroundingsExchange {
        let scaled = |k: usize| {
            let factor = |(i, x): (usize, &RayTally)| x.sums[k] * target(i) / x.traced as f64;
            tallies.iter().enumerate().map(factor).collect()
        };
        let rays = tallies.iter().map(|x| (x.traced + x.pilot) as u64).sum();
        SurroundingsExchange { sky: scaled(0), backfaces: scaled(1), error: Vec::new(), rays }
    }

    /// Expected number of rays of [`SurroundingsExchange::measure`] for `zones` zones, a sample of which is `self`.
    pub(crate) fn expected_rays(&self, scene: &Scene, zones: usize) -> u64 {
        let (each, pilot) = ray_counts(scene, zones, escape_rays_per_zone(scene));
        let limit = max_rays(scene, zones);
        let each = if self.is_closed() {
            pilot
        } else if !scene.surroundings().has_radiance() {
            each
        } else if uses_openings(scene, zones) {
            let finer =
                (EXPECTED_OPENING_TOLERANCE / scene.options().tolerance).powf(RAYS_OVER_ERROR_EXPONENT);
            (EXPECTED_OPENING_RAYS * (2.0 + finer)).min(limit as f64) as usize
        } else {
            each * EXPECTED_GROWTH.min(limit / each.max(1)).max(1)
        };
        (zones * each) as u64
    }

    /// Samples every `step`-th zone with `rays` rays.
    pub(crate) fn sample(
        zones: &Zones,
        transport: &Transport,
        rays: usize,
        step: usize,
    ) -> SurroundingsExchange {
        let list: Vec<usize> = (0..zones.len()).step_by(step).collect();
        let traced = TracedScene { zones, transport, seed: 0, sky: None };
        let tallies: Vec<RayTally> = parallel::map(&list, |i| RayTally::of_zone(&traced, *i, 0..rays));
        SurroundingsExchange::from_tallies(&tallies, |i| closure_target(zones, i * step))
    }

    /// True if no power escapes from any zone.
    pub fn is_closed(&self) -> bool {
        self.sky.iter().chain(&self.backfaces).all(|x| *x == Bands::ZERO)
    }
}

/// Rays of a zone to the surroundings for the tolerance of a scene, before refinement.
pub(crate) fn escape_rays_per_zone(scene: &Scene) -> usize {
    let tolerance = scene.options().tolerance;
    let [least, most] = ESCAPE_RAYS_PER_ZONE;
    let coarse = (COARSE_TOLERANCE / tolerance).min(1.0);
    let least = (least as f64 * coarse * coarse).ceil() as usize;
    let factor = if scene.surroundings().has_radiance() { RADIANCE_FACTOR } else { 1 };
    ((RAYS_TIMES_TOLERANCE_SQUARED / (tolerance * tolerance)) as usize).clamp(least, most) * factor
}

/// Traces more rays from zones whose error is too large.
fn refine(
    traced: &TracedScene,
    tallies: &mut Vec<RayTally>,
    execution: Execution,
    needs_all: &(dyn Fn(usize) -> bool + Sync),
) {
    let options = traced.transport.scene().options();
    let limit = max_rays(traced.transport.scene(), tallies.len());
    let any = (0..tallies.len()).any(needs_all);
    let openings = if any && uses_openings(traced.transport.scene(), tallies.len()) {
        OpeningSampler::find(*traced)
    } else {
        None
    };
    for round in if openings.is_some() { ROUNDS - 1 } else { 0 }..ROUNDS {
        let wanted = error_targets(tallies, traced.zones, ERROR_SHARE * options.tolerance);
        let refined = |i: usize| {
            let mut x = tallies[i];
            let wanted = wanted[traced.zones.kind(i) as usize];
            let off = norm(x.standard_error()) / wanted;
            if wanted > 0.0 && off > 1.0 && needs_all(i) {
                let growth = off.powf(RAYS_OVER_ERROR_EXPONENT).min(MAX_GROWTH);
                let all = ((x.traced as f64 * growth) as usize).min(limit);
                match &openings {
                    Some(openings) => x = openings.measure(i, wanted, limit).map_or(x, |found| found.tally),
                    None if all > x.traced as usize => {
                        x.add(&RayTally::of_zone(traced, i, x.traced as usize..all));
                    }
                    None => {}
                }
            }
            execution.progress.advance(u64::from(round == ROUNDS - 1));
            x
        };
        *tallies = execution.blocks(tallies.len(), ZONES_PER_BLOCK).map(execution.communicator, refined);
    }
}

/// True if zones may trace enough rays for opening sampling.
fn uses_openings(scene: &Scene, zones: usize) -> bool {
    scene.surroundings().has_radiance() && max_rays(scene, zones) >= MIN_RAYS_FOR_OPENINGS
}

/// Wanted error of patches, voxel zones and panes: `share` of the root mean square over the kind. The offsets are those of voxels and panes.
fn error_targets(tallies: &[RayTally], zones: &Zones, share: f64) -> [f64; 3] {
    let mean =
        |of: &[RayTally]| of.iter().map(|x| norm(x.mean_sky()).powi(2)).sum::<f64>() / of.len().max(1) as f64;
    zones.ranges_of_kinds().map(|of| share * mean(&tallies[of]).sqrt())
}

/// Root of the sum of squares over the bands.
fn norm(v: Bands) -> f64 {
    v.map(|x| x * x).sum().sqrt()
}

/// Rays of each of `n` zones, at most `rays`, and the pilot rays among them.
fn ray_counts(scene: &Scene, n: usize, rays: usize) -> (usize, usize) {
    let each = (total_rays(scene) / n.max(1)).clamp(MIN_RAYS.min(rays), rays);
    let pilot = if each < rays { PILOT_RAYS.min(each.div_ceil(2)) } else { PILOT_RAYS.min(rays) };
    (each, pilot)
}

/// Maximum number of rays of each of `n` zones if the surroundings have a radiance.
fn max_rays(scene: &Scene, n: usize) -> usize {
    let finer = (FINE_TOLERANCE / scene.options().tolerance).powf(RAYS_OVER_ERROR_EXPONENT).max(1.0);
    let total = RADIANCE_FACTOR * TOTAL_RAYS;
    ((finer * total as f64 / n.max(1) as f64) as usize).min(MAX_ESCAPE_RAYS_PER_ZONE)
}

/// Rays of all zones together before refinement.
fn total_rays(scene: &Scene) -> usize {
    if scene.surroundings().has_radiance() { RADIANCE_FACTOR * TOTAL_RAYS } else { TOTAL_RAYS }
}
