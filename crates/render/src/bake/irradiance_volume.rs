//! Irradiance volume: the incident radiance at the points of a regular grid in spherical harmonics of degree 0 and 1, for objects that move through a scene.
//!
//! With ω the direction towards which an observer looks, so that L(ω) arrives against it, and n the normal of a small surface,
//!
//! ```text
//!     c_lm = ∫ L(ω) Y_lm(ω) dω     Y_00 = ½ √(1/π)     (Y_1,−1, Y_10, Y_11) = ½ √(3/π) (ω_y, ω_z, ω_x)
//!     G    = c_00/Y_00             F = ∫ L ω dω = (c_11, c_1,−1, c_10)/(½ √(3/π))
//!     H(n) ≈ π Y_00 c_00 + ⅔π ½ √(3/π) (c_11 n_x + c_1,−1 n_y + c_10 n_z) = G/4 + F·n/2
//! ```
//!
//! G is the fluence; −F is the vector of net flux (Greger et al., *The irradiance volume*, IEEE CG&A 1998; Ramamoorthi & Hanrahan, SIGGRAPH 2001). L has two
//! parts. Light of the zones, of surroundings and of uniform skies is sampled in N directions: half of them are the points of a spherical Fibonacci lattice
//! (González, *Measurement of areas on a sphere using Fibonacci and latitude–longitude lattices*, Math. Geosci. 2010) on a hemisphere, the others are opposite to
//! these, so that constant radiance has F = 0. Light of all other lights is sampled by the light sampler; that of a point light is at most its mean over a ball of the cell's
//! volume. All points take the same samples, so that errors vary smoothly between them.
//!
//! The sampling error of G is estimated from two halves A and B of all samples, |G_A − G_B|/2. A point is outside where it lies in a closed solid or where more
//! than a tenth of its directions end on backs of one-sided surfaces; such points take the mean of their neighbours, two layers deep, so that interpolation
//! near walls is not darkened.
//!
//! Cost: N rays a point, and the samples of the lights. The same bits for any number of threads.

use super::volume_grid::{extrapolate, extrapolation_order, softening};
use crate::integrator::radiance::Integrator;
use crate::integrator::ray_sampler::RaySampler;
use crate::picture::even_extension;
use crate::view_ray::ViewRay;
use std::f64::consts::PI;
use zonal_math::direction_sampling::sin_cos_turns;
use zonal_math::parallel;
use zonal_math::{Vec3, low_discrepancy, vec3};
use zonal_scene::{Bands, PerBand, Progress, Scene, Solution};
use zonal_transport::Transport;
use zonal_transport::lights::{LightSampler, Receiver};

/// Y_00 = ½ √(1/π).
pub const SH_CONSTANT: f64 = 0.282_094_791_773_878_14;
/// Factor ½ √(3/π) of Y_1m.
pub const SH_LINEAR: f64 = 0.488_602_511_902_919_9;

/// Points along the longest edge where the grid is not given.
const DEFAULT_POINTS_ALONG: f64 = 32.0;
/// (√5 − 1)/2: turns between successive points of the lattice.
const GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;
/// Samples of a sky over those of other lights: it fills the sphere.
const SKY_SAMPLE_FACTOR: usize = 4;
/// Smallest edge of the box over the scene's diagonal.
const MIN_EXTENT_SHARE: f64 = 0.01;
/// Share of the directions that may end on backs of one-sided surfaces at a point inside of the scene.
const MAX_BACK_SHARE: f64 = 0.1;
/// Shifts of the sequences of directions and of light samples.
const SAMPLE_SHIFT: [f64; 3] = [0.5, 0.5, 0.5];

/// Size and sampling of a volume.
#[derive(Clone, Debug, PartialEq)]
pub struct IrradianceVolumeOptions {
    /// Points along x, y, z; 32 along the longest edge of the scene's bounds where not given.
    pub dims: Option<[usize; 3]>,
    /// Rays of each point, rounded up to a multiple of four; 512.
    pub rays: usize,
    /// Samples of each sun and emitter at a point, and a quarter of those of a sky that is not uniform; 64.
    pub light_samples: usize,
}

impl Default for IrradianceVolumeOptions {
    fn default() -> Self {
        IrradianceVolumeOptions { dims: None, rays: 512, light_samples: 64 }
    }
}

/// Incident radiance on a grid; lists have one entry a point, z fastest: index (i·ny + j)·nz + k. Each point lies in the centre of its part of the box.
#[derive(Clone, Debug, PartialEq)]
pub struct IrradianceVolume {
    /// Lower corner of the box, m.
    pub min: Vec3,
    /// Upper corner, m.
    pub max: Vec3,
    /// Points along x, y, z.
    pub dims: [usize; 3],
    /// c_00, c_1,−1, c_10 and c_11, red, green and blue, W/m².
    pub coefficients: [Vec<[f32; 3]>; 4],
    /// Estimated sampling error of the fluence, red, green and blue, W/m²; zero outside. The error of the solution is not in it.
    pub sampling_error: Vec<[f32; 3]>,
    /// True for points in solids and behind one-sided surfaces, which have values of their neighbours or zeros.
    pub is_outside: Vec<bool>,
}

/// Bakes the incident radiance of a solution. The same bits for any number of threads.
///
/// ```
/// use zonal_math::{Vec3, vec3};
/// use zonal_render::bake::irradiance_volume::{IrradianceVolumeOptions, SH_CONSTANT, bake_irradiance_volume};
/// # use zonal_scene::{
/// #     Bands, Facet, Fields, NoProgress, Plate, Report, Scene, SceneParts, Sides, Solution, Surface, Surroundings,
/// # };
/// # use zonal_transport::{Transport, build_zones};
/// # let wall = Surface {
/// #     name: "wall".into(),
/// #     reflectance: Bands::ZERO,
/// #     emission: Bands::ONE,
/// #     sides: Sides::Both,
/// #     ..Surface::default()
/// # };
/// # let plate = Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 1.0));
/// # let pi = std::f64::consts::PI;
/// # let surroundings = Surroundings { radiance: Bands::splat(1.0 / pi), ..Default::default() };
/// # let scene = Scene::new(SceneParts {
/// #     surfaces: vec![wall],
/// #     facets: vec![Facet { surface: 0, plate, uv: [[0.0; 2]; 3] }],
/// #     surroundings,
/// #     ..SceneParts::default()
/// # })
/// # .unwrap();
/// # let zones = build_zones(&scene, &Transport::new(&scene)).unwrap();
/// # let (one, zero) = (vec![Bands::ONE; zones.len()], vec![Bands::ZERO; zones.len()]);
/// # let mut fields = Fields::default();
/// # (fields.radiosity, fields.incident) = (one.clone(), one);
/// # (fields.direct, fields.error) = (zero.clone(), zero);
/// # let (groups, report) = (Vec::new(), Report::default());
/// # let (scene_hash, version) = (String::new(), String::new());
/// # let solution = Solution { scene, zones, fields, groups, report, further_blocks: Vec::new(), scene_hash, version };
/// // A black wall of 1 W/m² in surroundings of the radiance 1/π: the fluence is 4 everywhere.
/// let options = IrradianceVolumeOptions { dims: Some([2, 2, 2]), ..IrradianceVolumeOptions::default() };
/// let volume = bake_irradiance_volume(&solution, &options, &NoProgress);
/// assert!(volume.coefficients[0].iter().all(|c| (f64::from(c[0]) / SH_CONSTANT - 4.0).abs() < 1e-5));
/// assert!(volume.coefficients[1].iter().all(|c| c[0].abs() < 1e-5));
/// ```
#[must_use]
pub fn bake_irradiance_volume(
    solution: &Solution,
    options: &IrradianceVolumeOptions,
    progress: &dyn Progress,
) -> IrradianceVolume {
    let extended = even_extension(&solution.scene).map(|e| e.extended_solution(solution));
    let s = extended.as_ref().unwrap_or(solution);
    let transport = Transport::new(&s.scene);
    let (min, max) = volume_box(&solution.scene);
    let dims = options.dims.unwrap_or_else(|| default_dims(max - min));
    let cell = [0, 1, 2].map(|k| (max[k] - min[k]) / dims[k] as f64);
    let sampler = PointSampler::new(s, &transport, options, cell.iter().product());
    progress.begin("irradiance volume", dims.iter().product::<usize>() as u64);
    let at = |i: usize| {
        let n = [i / (dims[1] * dims[2]), i / dims[2] % dims[1], i % dims[2]];
        let place = [0, 1, 2].map(|k| min[k] + (n[k] as f64 + 0.5) * cell[k]);
        progress.advance(1);
        sampler.sample(Vec3::from_array(place))
    };
    let points: Vec<Option<[RadianceMoments; 2]>> = parallel::collect(dims.iter().product::<usize>(), at);
    progress.end();
    // Points outside take values of their neighbours.
    let known: Vec<bool> = points.iter().map(Option::is_some).collect();
    let order = extrapolation_order(&known, dims);
    let single = |x: Bands| x.map(|x| x as f32);
    let coefficients = [0, 1, 2, 3].map(|k| {
        let mean = |p: &Option<[RadianceMoments; 2]>| {
            let [a, b] = p.unwrap_or_default();
            single(0.5 * (a.coefficient(k) + b.coefficient(k)))
        };
        let mut values: Vec<PerBand<f32>> = points.iter().map(mean).collect();
        extrapolate(&mut values, &order);
        values.into_iter().map(PerBand::into_rgb).collect()
    });
    let error = |p: &Option<[RadianceMoments; 2]>| {
        let [a, b] = p.unwrap_or_default();
        single(0.5 * (a.fluence - b.fluence).abs()).into_rgb()
    };
    let sampling_error = points.iter().map(error).collect();
    let is_outside = known.into_iter().map(|k| !k).collect();
    IrradianceVolume { min, max, dims, coefficients, sampling_error, is_outside }
}

/// The bounds of a scene; a flat one gets a thickness.
fn volume_box(scene: &Scene) -> (Vec3, Vec3) {
    let (min, max) = scene.bounds();
    let lacking = |k: usize| 0.5 * (MIN_EXTENT_SHARE * scene.diagonal() - (max[k] - min[k])).max(0.0);
    let pad = vec3(lacking(0), lacking(1), lacking(2));
    (min - pad, max + pad)
}

/// Points along each axis for nearly cubic cells.
fn default_dims(size: Vec3) -> [usize; 3] {
    let longest = size.array().into_iter().fold(f64::MIN_POSITIVE, f64::max);
    size.array().map(|x| (DEFAULT_POINTS_ALONG * x / longest).round().max(1.0) as usize)
}

/// G and F of the radiance at a point, W/m².
#[derive(Clone, Copy, Default)]
struct RadianceMoments {
    fluence: Bands,
    /// ∫ L ω dω along x, y, z.
    vector: [Bands; 3],
}

impl RadianceMoments {
    /// Adds light of the fluence `g` from the direction `from`.
    fn add(&mut self, g: Bands, from: Vec3) {
        self.fluence += g;
        (0..3).for_each(|k| self.vector[k] += from[k] * g);
    }
    /// The coefficient in the order c_00, c_1,−1, c_10, c_11.
    fn coefficient(&self, k: usize) -> Bands {
        match k {
            0 => SH_CONSTANT * self.fluence,
            _ => SH_LINEAR * self.vector[k % 3],
        }
    }
}

/// Samples the radiance at points.
struct PointSampler<'a> {
    transport: &'a Transport<'a>,
    integrator: Integrator<'a>,
    /// Directions in two halves, one after the other.
    directions: Vec<Vec3>,
    /// Radiance of all uniform skies, W/(m² sr).
    uniform_sky: Bands,
    /// Other lights and their numbers of samples.
    lights: Vec<(LightSampler<'a>, usize)>,
    /// Volume of a cell, m³.
    cell_volume: f64,
}

impl<'a> PointSampler<'a> {
    fn new(
        s: &'a Solution,
        transport: &'a Transport<'a>,
        options: &IrradianceVolumeOptions,
        cell_volume: f64,
    ) -> PointSampler<'a> {
        let (mut uniform_sky, mut lights) = (Bands::ZERO, Vec::new());
        for light in s.scene.lights() {
            let n = 2 * options.light_samples.div_ceil(2).max(1);
            match light.sky() {
                Some((radiance, distribution)) if distribution.is_uniform() => uniform_sky += radiance,
                _ => {
                    let factor = if light.fills_sphere() { SKY_SAMPLE_FACTOR } else { 1 };
                    lights.push((LightSampler::new(&s.scene, light), factor * n));
                }
            }
        }
        PointSampler {
            transport,
            integrator: Integrator::new(s, transport).with_gather(1),
            directions: directions(4 * options.rays.div_ceil(4).max(1)),
            uniform_sky,
            lights,
            cell_volume,
        }
    }

    /// Two estimates of the moments at a point, each from half of the samples; `None` outside.
    fn sample(&self, point: Vec3) -> Option<[RadianceMoments; 2]> {
        if self.transport.inside_solid(point) {
            return None;
        }
        let mut halves = [RadianceMoments::default(); 2];
        let half = self.directions.len() / 2;
        let (weight, mut backs) = (4.0 * PI / half as f64, 0);
        for (i, &dir) in self.directions.iter().enumerate() {
            let ray = ViewRay { origin: point, dir };
            match self.integrator.zonal_radiance(ray, RaySampler::of_ray(i, 1, SAMPLE_SHIFT)) {
                Some(radiance) => halves[i / half].add(weight * (radiance + self.sky(ray)), dir),
                None => backs += 1,
            }
        }
        if backs as f64 > MAX_BACK_SHARE * self.directions.len() as f64 {
            return None;
        }
        self.lights.iter().for_each(|(light, n)| self.add_light(light, *n, point, &mut halves));
        Some(halves)
    }

    /// Radiance of uniform skies, W/(m² sr), that arrives at the origin of a ray.
    fn sky(&self, ray: ViewRay) -> Bands {
        if self.uniform_sky == Bands::ZERO {
            return Bands::ZERO;
        }
        let end = self.transport.exterior_point(ray.origin, ray.dir);
        self.transport.transmittance(ray.origin, end).map_or(Bands::ZERO, |tau| tau * self.uniform_sky)
    }

    /// Adds a light, every second sample to each half.
    fn add_light(&self, light: &LightSampler, n: usize, point: Vec3, halves: &mut [RadianceMoments; 2]) {
        let n = if light.is_delta() { 2 } else { n };
        let weight = softening(light.light(), point, self.cell_volume) / (n / 2) as f64;
        for i in 0..n {
            let [x, y] =
                low_discrepancy::r2(i / 2, [SAMPLE_SHIFT[0] + 0.37 * (i % 2) as f64, SAMPLE_SHIFT[1]]);
            let sample = [x, y, (i as f64 + 0.5) / n as f64];
            let found = light.sample_at(self.transport, point, Receiver::Free, sample);
            let arrived =
                found.and_then(|f| Some((light.attenuated(self.transport, point, &f)?, f.direction)));
            if let Some((flux, direction)) = arrived {
                halves[i % 2].add(weight * flux, direction);
            }
        }
    }
}

/// `n` directions, a multiple of four, in two halves of alternate points of the lattice; each direction is followed by its opposite.
fn directions(n: usize) -> Vec<Vec3> {
    let points = n / 2;
    let pair = |i: usize| {
        let z = (i as f64 + 0.5) / points as f64;
        let (sin, cos) = sin_cos_turns((i as f64 * GOLDEN_RATIO).fract());
        let r = (1.0 - z * z).sqrt();
        let d = vec3(r * cos, r * sin, z);
        [d, -d]
    };
    (0..points).step_by(2).chain((1..points).step_by(2)).flat_map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{furnace, quad, solution, sun, surface, walls};
    use zonal_math::direction_sampling::uniform_sphere;
    use zonal_scene::{Facet, Light, NoProgress, SceneParts, Sides, Surroundings};

    fn options(dims: [usize; 3]) -> IrradianceVolumeOptions {
        IrradianceVolumeOptions { dims: Some(dims), ..IrradianceVolumeOptions::default() }
    }

    fn baked(s: &Solution, dims: [usize; 3]) -> IrradianceVolume {
        bake_irradiance_volume(s, &options(dims), &NoProgress)
    }

    /// G and F of the red band at a point.
    fn moments(v: &IrradianceVolume, i: usize) -> (f64, Vec3) {
        let c = [0, 1, 2, 3].map(|k| f64::from(v.coefficients[k][i][0]));
        (c[0] / SH_CONSTANT, vec3(c[3], c[1], c[2]) / SH_LINEAR)
    }

    #[test]
    fn directions_integrate_odd_polynomials_exactly_and_fill_caps_evenly() {
        for (n, largest) in [(48, 0.05), (512, 0.003)] {
            let all = directions(n);
            assert!(all.len() == n && all.iter().all(|d| (d.length() - 1.0).abs() < 1e-14));
            for half in all.chunks(n / 2) {
                let mean = |f: &dyn Fn(&Vec3) -> f64| half.iter().map(f).sum::<f64>() / half.len() as f64;
                for (a, b, c) in [(0, 1, 2), (0, 0, 1), (2, 2, 2), (1, 1, 0)] {
                    assert!(mean(&|d| d[a]).abs() < 1e-15 && mean(&|d| d[a] * d[b] * d[c]).abs() < 1e-15);
                    let expected = if a == b { 1.0 / 3.0 } else { 0.0 };
                    assert!((mean(&|d| d[a] * d[b]) - expected).abs() < largest, "{n} {a} {b}");
                }
            }
        }
        // Caps of a twentieth of the sphere about any axis.
        let all = directions(512);
        for k in 0..200 {
            let axis = uniform_sphere(low_discrepancy::r2(k, [0.2, 0.9]));
            let share = all.iter().filter(|d| d.dot(axis) > 0.9).count() as f64 / 512.0;
            assert!((share - 0.05).abs() < 0.006, "{axis:?} {share}");
        }
    }

    #[test]
    fn furnace_has_constant_radiance() {
        // Radiance 1/π everywhere: G = 4, F = 0, with a medium, a wall inside and a sky in place of the surroundings.
        let mut open = furnace();
        open.facets.remove(1);
        open.surroundings = Surroundings::default();
        open.lights = vec![Light::Sky {
            name: "sky".into(),
            radiance: Bands::splat(1.0 / PI),
            distribution: zonal_scene::SkyDistribution::uniform(),
        }];
        // Where a sky is a light, rays that go on from close patches take one sample of it.
        for (parts, tolerance) in [(furnace(), 1e-5), (open, 0.02)] {
            let s = solution(parts, |_, _| 1.0, |_| 1.0);
            let v = baked(&s, [5, 4, 3]);
            for i in 0..60 {
                let (g, f) = moments(&v, i);
                assert!((g - 4.0).abs() < tolerance && f.length() < tolerance, "{g} {f:?}");
            }
            assert!(
                v.sampling_error.iter().flatten().all(|e| f64::from(*e) < tolerance)
                    && !v.is_outside.contains(&true)
            );
        }
    }

    #[test]
    fn flat_scenes_have_a_box_of_some_thickness() {
        let floor = quad(0, Vec3::ZERO, vec3(3.0, 0.0, 0.0), vec3(0.0, 4.0, 0.0));
        let parts = SceneParts {
            surfaces: vec![surface("floor", 0.5, 0.0)],
            facets: vec![floor],
            ..SceneParts::default()
        };
        let v = baked(&solution(parts, |_, _| 0.0, |_| 0.0), [2, 2, 2]);
        assert_eq!((v.min, v.max), (vec3(0.0, 0.0, -0.025), vec3(3.0, 4.0, 0.025)));
    }

    #[test]
    fn collimated_light_has_a_vector_as_long_as_its_fluence() {
        let direction = vec3(0.3, -0.5, -0.8).normalized();
        let board = quad(0, vec3(-4.0, -4.0, 0.0), vec3(8.0, 0.0, 0.0), vec3(0.0, 8.0, 1.0));
        let parts = SceneParts {
            surfaces: vec![surface("board", 0.0, 0.0)],
            facets: vec![board],
            lights: vec![sun(direction, 0.0)],
            ..SceneParts::default()
        };
        let s = solution(parts, |_, _| 0.0, |_| 0.0);
        let v = baked(&s, [4, 4, 2]);
        let (mut lit, mut dark) = (0, 0);
        for i in 0..32 {
            let (g, f) = moments(&v, i);
            let c = [0, 1, 2, 3].map(|k| f64::from(v.coefficients[k][i][0]));
            if g == 0.0 {
                dark += 1;
                continue;
            }
            lit += 1;
            assert!((g - 1.0).abs() < 1e-6 && (f + direction).length() < 1e-6, "{g} {f:?}");
            let linear = (c[1] * c[1] + c[2] * c[2] + c[3] * c[3]).sqrt();
            assert!((linear / c[0] - 3f64.sqrt()).abs() < 1e-6);
        }
        assert!(lit > 8 && dark > 8);
    }

    /// A black cube of edge 2 whose upper wall has the radiosity 5, as a zone or as a light.
    fn cube_with_a_bright_wall(lights: Vec<Light>) -> Solution {
        let mut facets = walls(vec3(-1.0, -1.0, -1.0), vec3(1.0, 1.0, 1.0));
        facets[1].surface = 1;
        let surfaces = vec![surface("wall", 0.0, 0.0), surface("lamp", 0.0, 5.0)];
        solution(SceneParts { surfaces, facets, lights, ..SceneParts::default() }, |_, _| 0.0, |_| 0.0)
    }

    #[test]
    fn centre_of_a_cube_with_one_bright_wall_is_analytic() {
        // Of the centre every wall fills a sixth of the sphere. ∫ ω_z dω over a square of edge 2 at distance 1 is π times the configuration factor of a
        // parallel element: four corners of (1/√2) atan(1/√2)/π each.
        let corner = (0.5f64.sqrt() * 0.5f64.sqrt().atan()) / PI;
        let (g, fz) = (2.0 / 3.0 * PI * 5.0 / PI, PI * 4.0 * corner * 5.0 / PI);
        for lights in [Vec::new(), vec![Light::Emitter { surface: 1, name: None }]] {
            let s = cube_with_a_bright_wall(lights);
            let fine = IrradianceVolumeOptions { rays: 9600, light_samples: 1024, dims: Some([1; 3]) };
            for (options, share) in [(options([1; 3]), 0.03), (fine, 0.003)] {
                let (found, f) = moments(&bake_irradiance_volume(&s, &options, &NoProgress), 0);
                assert!((found / g - 1.0).abs() < share && (f.z / fz - 1.0).abs() < share, "{found} {f:?}");
                assert!(f.x.abs() + f.y.abs() < share * fz, "{f:?}");
            }
        }
    }

    #[test]
    fn stated_sampling_error_is_no_smaller_than_the_true_one() {
        let s = cube_with_a_bright_wall(Vec::new());
        let v = baked(&s, [7, 7, 7]);
        let (mut stated, mut real) = (0.0, 0.0);
        for i in 0..343 {
            let at = [i / 49, i / 7 % 7, i % 7].map(|k| -1.0 + (2.0 * k as f64 + 1.0) / 7.0);
            let height = 1.0 - at[2];
            // Solid angle of a rectangle above a corner: atan(a b/(h √(a² + b² + h²))).
            let corner =
                |a: f64, b: f64| (a * b / (height * (a * a + b * b + height * height).sqrt())).atan();
            let (x, y) = ([1.0 - at[0], 1.0 + at[0]], [1.0 - at[1], 1.0 + at[1]]);
            let angle: f64 = x.iter().flat_map(|a| y.iter().map(|b| corner(*a, *b))).sum();
            real += (moments(&v, i).0 - angle * 5.0 / PI).powi(2);
            stated += f64::from(v.sampling_error[i][0]).powi(2);
        }
        assert!(real > 0.0 && real <= stated && stated < 16.0 * real, "{real} {stated}");
    }

    #[test]
    fn points_behind_walls_take_values_of_their_neighbours() {
        // A one-sided room in half of the bounds; a stick reaches out of it.
        let mut room = surface("room", 0.0, 1.0);
        room.sides = Sides::Front;
        let mut facets = walls(Vec3::ZERO, vec3(1.0, 1.0, 1.0));
        facets.push(Facet {
            surface: 1,
            ..quad(1, vec3(1.9, 0.0, 0.0), vec3(0.1, 0.0, 0.0), vec3(0.0, 0.1, 0.0))
        });
        let parts =
            SceneParts { surfaces: vec![room, surface("stick", 0.0, 0.0)], facets, ..SceneParts::default() };
        let s = solution(parts, |_, _| 0.0, |_| 0.0);
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| baked(&s, [8, 3, 3]))
        };
        let v = run(1);
        assert_eq!(v, run(3));
        for i in 0..72 {
            // From afar the back of the room is a small part of free space.
            let (g, column) = (moments(&v, i).0, i / 9);
            assert!(column > 5 || v.is_outside[i] == (column >= 4), "{column}");
            assert!(column > 4 || (g - 4.0).abs() < 1e-5, "{column}: {g}");
        }
    }
}
