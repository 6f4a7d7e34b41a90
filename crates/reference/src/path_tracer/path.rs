//! One path, backwards from a vertex: I = ∫ L f dω with f the scattering density of the vertex.
//!
//! At each vertex the path samples the suns, the point lights and one point of an emitter (next-event estimation), then continues in a direction of
//! density f. Emission that the path hits counts too; both ways of finding an emitter share it by the balance heuristic (Veach
//! 1997): with p_e the density of the emitter's point, β the throughput and τ the transmittance,
//!
//! ```text
//! sampled:  β τ L f/(p_e + f)        hit:  β L f/(p_e + f)
//! ```
//!
//! After a few bounces Russian roulette continues a path with the probability of its last albedo and weights it accordingly, which
//! keeps the estimate unbiased. Light that arrives unscattered from a sun, a sky, a point light or a surface that the scene lists as a light is direct.

use super::bvh::RayHit;
use super::detector::{Detector, SubcellPart, SurfacePlate};
use super::flight::{FlightEnd, PathVertex, RayScene, sample_scattering};
use super::light_sampling::{FacetSide, LightSet};
use crate::rng::Rng;
use zonal_math::Vec3;
use zonal_scene::{Bands, Sides};

/// Bounces before Russian roulette begins.
const MIN_ROULETTE_BOUNCES: usize = 3;
/// Largest probability of survival, so that paths in a white closed scene end.
const MAX_SURVIVAL_PROBABILITY: f64 = 0.995;
/// Most trials to draw a point of a sub-cell that its sample point sees.
const MAX_POINT_TRIALS: usize = 200;

/// The numbers of a path: evenly distributed ones for its first events, then random ones.
pub(super) struct PathNumbers {
    /// Evenly distributed numbers in [0, 1), used from the end.
    pub low_discrepancy: Vec<f64>,
    /// The generator of all further numbers.
    pub rng: Rng,
}

impl PathNumbers {
    /// The next number of [0, 1).
    pub(super) fn next_number(&mut self) -> f64 {
        self.low_discrepancy.pop().unwrap_or_else(|| self.rng.uniform())
    }
    /// The next `N` numbers.
    pub(super) fn next_array<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.next_number())
    }
}

/// The radiance found by a path, W/(m² sr).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PathRadiance {
    /// All light.
    pub total: Bands,
    /// Direct light alone.
    pub direct: Bands,
}

impl PathRadiance {
    fn add(&mut self, x: Bands, direct: bool) {
        self.total += x;
        if direct {
            self.direct += x;
        }
    }
}

/// The scene and lights of paths.
pub(super) struct PathSampler<'a> {
    /// The scene with its BVHs.
    pub space: RayScene<'a>,
    /// The lights of the scene.
    pub lights: LightSet<'a>,
    /// Maximum number of bounces between detector and emission.
    pub max_bounces: usize,
}

/// The state of a path.
struct PathState {
    vertex: PathVertex,
    throughput: Bands,
    bounces: usize,
    radiance: PathRadiance,
}

impl PathSampler<'_> {
    /// ∫ L f dω at a vertex by one path.
    pub(super) fn scattered_radiance(&self, vertex: PathVertex, numbers: &mut PathNumbers) -> PathRadiance {
        let mut s =
            PathState { vertex, throughput: Bands::ONE, bounces: 0, radiance: PathRadiance::default() };
        self.sample_lights(&mut s, numbers);
        let d = sample_scattering(&s.vertex, numbers.next_array());
        self.run(s, d, false, numbers)
    }

    /// Radiance that arrives at `o` from the unit direction `d`, by one path. Suns are not visible as discs.
    pub(super) fn radiance(&self, o: Vec3, d: Vec3, numbers: &mut PathNumbers) -> PathRadiance {
        let vertex = PathVertex::Free { at: o };
        let s = PathState { vertex, throughput: Bands::ONE, bounces: 0, radiance: PathRadiance::default() };
        self.run(s, d, true, numbers)
    }

    /// Follows the path from its vertex along `d`. `camera_ray`: the first vertex has no next-event estimation, so emission that it hits
    /// counts in full.
    fn run(
        &self,
        mut s: PathState,
        mut d: Vec3,
        mut camera_ray: bool,
        numbers: &mut PathNumbers,
    ) -> PathRadiance {
        while self.advance(&mut s, d, camera_ray, numbers) {
            camera_ray = false;
            self.sample_lights(&mut s, numbers);
            d = sample_scattering(&s.vertex, numbers.next_array());
        }
        s.radiance
    }

    /// Advances the path to the next vertex; false when it ends.
    fn advance(&self, s: &mut PathState, d: Vec3, camera_ray: bool, numbers: &mut PathNumbers) -> bool {
        // The band is random; the distance uses an evenly distributed number.
        let u = [numbers.rng.uniform(), numbers.next_number()];
        let flight = self.space.sample_flight(&s.vertex, d, s.throughput, u);
        s.radiance.add(s.throughput * flight.emitted, false);
        s.throughput *= flight.weight;
        let first = s.bounces == 0;
        let albedo = match flight.end {
            FlightEnd::Escaped => {
                let surroundings_radiance = self.space.scene.surroundings().radiance;
                s.radiance.add(s.throughput * surroundings_radiance, false);
                s.radiance.add(s.throughput * self.lights.sky(d), first);
                return false;
            }
            FlightEnd::Collision(vertex, albedo) => {
                s.vertex = vertex;
                albedo
            }
            FlightEnd::Facet(hit) => {
                let facet = &self.space.scene.facets()[hit.id as usize];
                let normal = facet.plate.normal();
                let (radiance, direct) = self.lights.facet_radiance(hit.id, hit.uv, facet_side(hit.front));
                if radiance != Bands::ZERO {
                    let f = s.vertex.density(d);
                    let sampled = self.lights.density(hit.id, hit.t, normal.dot(d));
                    let mis_weight = if camera_ray { 1.0 } else { f / (f + sampled) };
                    s.radiance.add(s.throughput * radiance * mis_weight, direct && first);
                }
                if !hit.front && self.space.scene.surfaces()[facet.surface].sides == Sides::Front {
                    return false;
                }
                let mut normal = if hit.front { normal } else { -normal };
                let at = s.vertex.at() + d * hit.t;
                let albedo = self.scattering_of_facet(&hit, &mut normal, numbers);
                s.vertex = PathVertex::Surface { at, normal, facet: Some(hit.id) };
                albedo
            }
        };
        self.scatter(s, albedo, numbers)
    }

    /// The fraction that a facet reflects or transmits; the normal turns to the other side where light is transmitted.
    fn scattering_of_facet(&self, hit: &RayHit, normal: &mut Vec3, numbers: &mut PathNumbers) -> Bands {
        let (facet, [u, v]) = (hit.id as usize, hit.uv);
        let (rho, tau) =
            (self.space.scene.reflectance_at(facet, u, v), self.space.scene.transmittance_at(facet, u, v));
        let (albedo, transmitted) = choose_side(rho, tau, numbers);
        if transmitted {
            *normal = -*normal;
        }
        albedo
    }

    /// A random point of a detector.
    pub(super) fn start(&self, detector: &Detector, numbers: &mut PathNumbers) -> PathVertex {
        let u: [f64; 3] = numbers.next_array();
        match detector {
            Detector::Patch { plate, normal } => {
                let [s, t] = plate.warp([u[0], u[1]]);
                PathVertex::Surface { at: plate.at(s, t), normal: *normal, facet: None }
            }
            Detector::Surface(plates) => {
                let SurfacePlate { plate, normal, .. } = SurfacePlate::at_share(plates, u[2]);
                let [s, t] = plate.warp([u[0], u[1]]);
                PathVertex::Surface { at: plate.at(s, t), normal: *normal, facet: None }
            }
            Detector::Point(at) => PathVertex::Free { at: *at },
            Detector::Cell { lo, hi } => {
                PathVertex::Free { at: *lo + (*hi - *lo).scale(Vec3::from_array(u)) }
            }
            Detector::Part(parts) => PathVertex::Free { at: self.point_of(parts, u[0], &mut numbers.rng) },
            Detector::Pane { pane, plate } => {
                let [s, t] = plate.warp([u[0], u[1]]);
                let height = u[2] * self.space.scene.panes()[*pane].thickness;
                PathVertex::Pane { at: plate.at(s, t), normal: plate.normal(), pane: *pane, height }
            }
        }
    }

    /// A random point of a divided cell: a sub-cell by its volume, in it a point that its sample point sees.
    fn point_of(&self, parts: &[SubcellPart], u: f64, rng: &mut Rng) -> Vec3 {
        let mut rest = u * parts.iter().map(|p| p.volume).sum::<f64>();
        let chosen = parts.iter().find(|p| {
            rest -= p.volume;
            rest <= 0.0
        });
        let p = chosen.unwrap_or(&parts[parts.len() - 1]);
        (0..MAX_POINT_TRIALS)
            .map(|_| rng.point_in_box(p.lo, p.hi))
            .find(|x| self.space.visible(p.point, *x))
            .unwrap_or(p.point)
    }

    /// Applies the albedo and Russian roulette; false when the path ends.
    fn scatter(&self, s: &mut PathState, albedo: Bands, numbers: &mut PathNumbers) -> bool {
        let before = s.throughput.iter().fold(0.0f64, |m, x| m.max(*x));
        s.throughput *= albedo;
        s.bounces += 1;
        let after = s.throughput.iter().fold(0.0f64, |m, x| m.max(*x));
        if after <= 0.0 || s.bounces > self.max_bounces {
            return false;
        }
        if s.bounces > MIN_ROULETTE_BOUNCES {
            let survival = (after / before).min(MAX_SURVIVAL_PROBABILITY);
            if numbers.rng.uniform() >= survival {
                return false;
            }
            s.throughput /= survival;
        }
        true
    }

    /// Next-event estimation: adds the light that suns, point lights and one emitter send to the vertex.
    fn sample_lights(&self, s: &mut PathState, numbers: &mut PathNumbers) {
        let direct = s.bounces == 0;
        let u: [f64; 3] = numbers.next_array();
        let (rng, mut first) = (&mut numbers.rng, Some([u[0], u[1]]));
        let pair = || first.take().unwrap_or_else(|| [rng.uniform(), rng.uniform()]);
        self.lights.for_each_source(s.vertex.at(), pair, |towards, r, fluence| {
            let f = s.vertex.density(towards);
            if f > 0.0
                && let Some(transmittance) = self.space.transmittance(&s.vertex, towards, r, None)
            {
                s.radiance.add(s.throughput * transmittance * fluence * f, direct);
            }
        });
        let u = if first.is_none() { [rng.uniform(), rng.uniform(), rng.uniform()] } else { u };
        let Some(point) = self.lights.sample_point(u) else { return };
        let offset = point.at - s.vertex.at();
        let r = offset.length();
        let towards = offset / r;
        let cos = -towards.dot(point.normal);
        let (radiance, is_scene_light) =
            self.lights.facet_radiance(point.facet, point.uv, facet_side(cos > 0.0));
        let f = s.vertex.density(towards);
        if !(r > 0.0 && cos != 0.0 && f > 0.0) || radiance == Bands::ZERO {
            return;
        }
        let mis_weight = f / (f + self.lights.density(point.facet, r, cos));
        if let Some(transmittance) = self.space.transmittance(&s.vertex, towards, r, Some(point.facet)) {
            s.radiance.add(s.throughput * transmittance * radiance * mis_weight, direct && is_scene_light);
        }
    }
}

/// Reflects or transmits with probabilities in proportion to the means of ρ and τ: the fraction over its probability, and true where light is transmitted.
fn choose_side(rho: Bands, tau: Bands, numbers: &mut PathNumbers) -> (Bands, bool) {
    if tau == Bands::ZERO {
        return (rho, false);
    }
    let transmits = tau.mean() / (rho.mean() + tau.mean());
    let is_transmitted = numbers.rng.uniform() < transmits;
    (if is_transmitted { tau / transmits } else { rho / (1.0 - transmits) }, is_transmitted)
}

fn facet_side(front: bool) -> FacetSide {
    if front { FacetSide::Front } else { FacetSide::Back }
}
