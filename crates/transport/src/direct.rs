//! Direct light at a point: H_dir on a surface, G_dir in free space.
//!
//! ```text
//! H_dir = ∫ L τ cosθ⁺ dω      G_dir = ∫ L τ dω      over the directions ω in which the light is seen
//! ```
//!
//! | light | sampled | contribution of one sample, before τ |
//! |---|---|---|
//! | sun, angular radius α, irradiance E⊥ on a plane square to it | uniform over its cone | G: 2 E⊥/(1+cosα), times cosθ for H |
//! | sky of radiance L | cosine-weighted for H, uniform over the sphere for G | π L, 4π L |
//! | emitter of flux E(x), solid angle Ω | uniform over Ω, before a receiver's front (`emitter`) | Ω E/π, times cosθ for H |
//!
//! (The sun's radiance is E⊥/(π sin²α) and its solid angle 2π(1−cosα); their product is 2E⊥/(1+cosα).) τ is that of
//! [`Transport::transmittance`]: coloured by medium and panes, zero behind a facet; the emitter's own facet does not block,
//! since a segment's ends are not counted. What an emitter of a few even facets sends is known in closed form, E/π times its
//! (projected) solid angle; samples then say only which share of it arrives, so that nothing is noisy beside a lamp.
//! Points are low-discrepancy ones, shifted by a hash of the seed: the same call gives the same bits. All means are statistical; their error falls like 1/samples where the light is seen whole.

use crate::Transport;
use crate::emitter::{Emitter, Spot};
use std::f64::consts::PI;
use zonal_math::directions::{self, sphere, turn};
use zonal_math::{Vec3, sequence};
use zonal_scene::{Bands, Light, Scene, bands};

/// Who receives the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Receiver {
    /// A surface with this unit normal: contributions are irradiances.
    Surface(Vec3),
    /// A point in free space: contributions are fluences.
    Free,
}

/// One sample of a light as seen from a point, not yet dimmed by what lies between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Unit vector towards the light.
    pub towards: Vec3,
    /// The far end of the shadow ray, m.
    pub end: Vec3,
    /// What the sample contributes to H or G where nothing lies between, W/m².
    pub flux: Bands,
}

/// One sample of a light, wherever it is seen from: for light along a whole ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// At infinity: the same fluence everywhere, W/m².
    Distant {
        /// Unit vector towards it.
        towards: Vec3,
        /// Fluence where nothing lies between, W/m².
        fluence: Bands,
    },
    /// A point of an emitter: at distance r and angle θ from its normal the fluence is `power` · cosθ/r².
    Point {
        /// Position, m.
        at: Vec3,
        /// Unit normal of its front.
        normal: Vec3,
        /// True when the back shines as well.
        both: bool,
        /// Index of the facet it lies on.
        facet: usize,
        /// A E/π, W/sr.
        power: Bands,
    },
}

/// A light made ready to be sampled.
#[derive(Clone, Debug)]
pub struct Lamp<'a> {
    light: &'a Light,
    /// Set for an emitter.
    emitter: Option<Emitter<'a>>,
}

impl<'a> Lamp<'a> {
    /// Prepares a light.
    pub fn new(scene: &'a Scene, light: &'a Light) -> Lamp<'a> {
        let emitter = match light {
            Light::Emitter { surface, .. } => Some(Emitter::new(scene, *surface)),
            _ => None,
        };
        Lamp { light, emitter }
    }

    /// The light.
    pub fn light(&self) -> &'a Light {
        self.light
    }

    /// True when every sample is the same: a sun without extent.
    pub fn is_single(&self) -> bool {
        matches!(self.light, Light::Sun { angular_diameter, .. } if *angular_diameter == 0.0)
    }

    /// True for an emitter of so many facets that they are drawn cluster by cluster.
    pub fn is_crowd(&self) -> bool {
        self.emitter.as_ref().is_some_and(Emitter::is_crowd)
    }

    /// Centre, m, and radius, m, of each cluster of an emitter's facets; none where these are few.
    pub fn clusters(&self) -> Vec<(Vec3, f64)> {
        self.emitter.as_ref().map_or(Vec::new(), Emitter::clusters)
    }

    /// About H or G with nothing between, W/m², of an emitter of many facets; zero for other lights.
    pub fn estimate(&self, point: Vec3, receiver: Receiver) -> Bands {
        self.emitter.as_ref().map_or([0.0; 3], |e| e.estimate(point, receiver))
    }

    /// [`Lamp::beam`] of an emitter of many facets with each cluster as seen from its middle where it looks small: what it brings is right within a few
    /// per cent, and had at much less work. With the distance from which it comes, m.
    pub fn rough_beam(
        &self,
        transport: &Transport,
        point: Vec3,
        receiver: Receiver,
        s: [f64; 3],
    ) -> Option<(Beam, f64)> {
        let far = self.emitter.as_ref().and_then(|e| e.far_spot(point, receiver, s));
        match far {
            Some((spot, r)) => arriving(spot, point, receiver).map(|b| (b, r)),
            None => self.beam(transport, point, receiver, s).map(|b| (b, (b.end - point).length())),
        }
    }

    /// G r² of cluster number `k` with nothing between, W/m² · m², far away in the unit direction `dir` from it.
    pub fn cluster_intensity(&self, k: usize, dir: Vec3) -> Bands {
        self.emitter.as_ref().map_or([0.0; 3], |e| e.intensity(k, dir))
    }

    /// True when [`Lamp::unhindered`] knows its light.
    pub fn has_closed_form(&self) -> bool {
        self.emitter.as_ref().is_some_and(Emitter::is_even)
    }

    /// The sample of the light at `s` ∈ [0,1)³ as seen from `point`; `None` where it contributes nothing.
    pub fn beam(&self, transport: &Transport, point: Vec3, receiver: Receiver, s: [f64; 3]) -> Option<Beam> {
        match self.light {
            Light::Sun { direction, irradiance, angular_diameter, .. } => {
                let cos_radius = (0.5 * angular_diameter).cos();
                let towards = in_cone(-*direction, *angular_diameter, [s[0], s[1]]);
                let flux = irradiance.map(|e| e * 2.0 / (1.0 + cos_radius));
                distant(transport, point, towards, cosine(receiver, towards), flux)
            }
            Light::Sky { radiance, .. } => {
                let (towards, weight) = match receiver {
                    Receiver::Surface(n) => (directions::cosine(n, [s[0], s[1]]), PI),
                    Receiver::Free => (sphere([s[0], s[1]]), 4.0 * PI),
                };
                distant(transport, point, towards, weight, *radiance)
            }
            Light::Emitter { .. } => self.emitter_beam(point, receiver, s),
        }
    }

    /// [`Lamp::unhindered`] and [`Lamp::beam`] together: in free space every beam of a light with a closed form brings all of it.
    pub fn beam_of_all(
        &self,
        transport: &Transport,
        point: Vec3,
        receiver: Receiver,
        s: [f64; 3],
    ) -> (Bands, Option<Beam>) {
        let beam = self.beam(transport, point, receiver, s);
        let all = match receiver {
            Receiver::Free if self.has_closed_form() => beam.map_or([0.0; 3], |b| b.flux),
            _ => self.unhindered(point, receiver),
        };
        (all, beam)
    }

    /// The sample of the light at `s` ∈ [0,1)³, for all points at once; `None` for an emitter without facets.
    pub fn source(&self, s: [f64; 3]) -> Option<Source> {
        match self.light {
            Light::Sun { direction, irradiance, angular_diameter, .. } => {
                let cos_radius = (0.5 * angular_diameter).cos();
                Some(Source::Distant {
                    towards: in_cone(-*direction, *angular_diameter, [s[0], s[1]]),
                    fluence: irradiance.map(|e| e * 2.0 / (1.0 + cos_radius)),
                })
            }
            Light::Sky { radiance, .. } => Some(Source::Distant {
                towards: sphere([s[0], s[1]]),
                fluence: radiance.map(|l| 4.0 * PI * l),
            }),
            Light::Emitter { .. } => self.emitter.as_ref()?.point(s),
        }
    }

    fn emitter_beam(&self, point: Vec3, receiver: Receiver, s: [f64; 3]) -> Option<Beam> {
        arriving(self.emitter.as_ref()?.spot(point, receiver, s)?, point, receiver)
    }

    /// The beam's contribution after what lies between; `None` behind a facet.
    pub fn lit(&self, transport: &Transport, point: Vec3, beam: &Beam) -> Option<Bands> {
        let tau = transport.transmittance(point, beam.end)?;
        Some(bands(|b| tau[b] * beam.flux[b]))
    }

    /// H or G of this light alone, W/m²: the mean over `samples` points of the light.
    pub fn gather(
        &self,
        transport: &Transport,
        point: Vec3,
        receiver: Receiver,
        samples: usize,
        seed: u64,
    ) -> Bands {
        let n = if self.is_single() { 1 } else { samples.max(1) };
        let shift = [0, 1, 2].map(|k| sequence::unit(seed.wrapping_mul(3).wrapping_add(k)));
        self.gather_at(transport, point, receiver, n, |i| stratified(i, n, shift))
    }

    /// H or G of this light alone, W/m², from `n` samples at given points of the unit cube.
    pub fn gather_at(
        &self,
        transport: &Transport,
        point: Vec3,
        receiver: Receiver,
        n: usize,
        at: impl Fn(usize) -> [f64; 3],
    ) -> Bands {
        let (mut sent, mut arrived) = ([0.0; 3], [0.0; 3]);
        for i in 0..n {
            if let Some(beam) = self.beam(transport, point, receiver, at(i)) {
                let lit = self.lit(transport, point, &beam).unwrap_or([0.0; 3]);
                sent = bands(|b| sent[b] + beam.flux[b]);
                arrived = bands(|b| arrived[b] + lit[b]);
            }
        }
        if !self.has_closed_form() {
            return arrived.map(|x| x / n as f64);
        }
        let all = self.unhindered(point, receiver);
        bands(|b| if sent[b] > 0.0 { all[b] * arrived[b] / sent[b] } else { 0.0 })
    }

    /// H or G of an emitter with nothing between, W/m², in closed form; zero for a light that has none.
    pub fn unhindered(&self, point: Vec3, receiver: Receiver) -> Bands {
        self.emitter.as_ref().map_or([0.0; 3], |e| e.unhindered(point, receiver))
    }
}

/// H_dir of one light, W/m², at `point` on a surface with unit `normal`. Emitters are prepared at every call: for many points
/// prepare a [`Lamp`] once.
pub fn irradiance(
    scene: &Scene,
    transport: &Transport,
    light: &Light,
    point: Vec3,
    normal: Vec3,
    samples: usize,
    seed: u64,
) -> Bands {
    Lamp::new(scene, light).gather(transport, point, Receiver::Surface(normal), samples, seed)
}

/// G_dir of one light, W/m², at `point` in free space. See [`irradiance`] for many points.
pub fn fluence(
    scene: &Scene,
    transport: &Transport,
    light: &Light,
    point: Vec3,
    samples: usize,
    seed: u64,
) -> Bands {
    Lamp::new(scene, light).gather(transport, point, Receiver::Free, samples, seed)
}

/// The `i`-th of `n` points of the unit cube: a shifted R₂ sequence, and an evenly spaced third coordinate.
fn stratified(i: usize, n: usize, shift: [f64; 3]) -> [f64; 3] {
    let [x, y] = sequence::r2(i, [shift[0], shift[1]]);
    [x, y, (i as f64 + shift[2]) / n as f64]
}

fn arriving(spot: Spot, point: Vec3, receiver: Receiver) -> Option<Beam> {
    let towards = (spot.at - point).normalized();
    let arriving = cosine(receiver, towards);
    (arriving > 0.0).then(|| Beam { towards, end: spot.at, flux: spot.fluence.map(|g| g * arriving) })
}

fn cosine(receiver: Receiver, towards: Vec3) -> f64 {
    match receiver {
        Receiver::Surface(n) => n.dot(towards),
        Receiver::Free => 1.0,
    }
}

fn distant(transport: &Transport, point: Vec3, towards: Vec3, weight: f64, light: Bands) -> Option<Beam> {
    (weight > 0.0).then(|| Beam {
        towards,
        end: transport.beyond(point, towards),
        flux: light.map(|x| x * weight),
    })
}

/// A direction uniform over the cone of full angle `angle` about the unit vector `axis`.
fn in_cone(axis: Vec3, angle: f64, s: [f64; 2]) -> Vec3 {
    if angle == 0.0 {
        return axis;
    }
    // 1 − cosα without cancellation.
    let height = 2.0 * (0.25 * angle).sin().powi(2) * s[0];
    let z = 1.0 - height;
    around(axis, z, (height * (2.0 - height)).max(0.0).sqrt(), s[1])
}

fn around(axis: Vec3, z: f64, r: f64, share: f64) -> Vec3 {
    let (t, b) = axis.frame();
    let (sin, cos) = turn(share);
    (axis * z + (t * cos + b * sin) * r).normalized()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;
    use zonal_math::vec3;
    use zonal_scene::{Facet, Pane, Plate, SceneParts, Sides, Surface, Voxmap};

    fn surface(name: &str, emission: f64) -> Surface {
        Surface {
            name: name.into(),
            reflectance: [0.5; 3],
            emission: [emission; 3],
            reflectance_texture: None,
            emission_texture: None,
            sides: Sides::Front,
            patch_size: None,
            solid: false,
        }
    }

    fn facet(surface: usize, plate: Plate) -> Facet {
        let uv = [[0.0; 2]; 3];
        Facet { surface, plate, uv }
    }

    fn square(z: f64, half: f64, up: bool) -> Plate {
        let (x, y) = (vec3(2.0 * half, 0.0, 0.0), vec3(0.0, 2.0 * half, 0.0));
        let o = vec3(-half, -half, z);
        if up { Plate::parallelogram(o, x, y) } else { Plate::parallelogram(o, y, x) }
    }

    fn sun(angle: f64) -> Light {
        Light::Sun {
            name: "sun".into(),
            direction: vec3(0.0, 0.6, -0.8),
            irradiance: [1.0, 2.0, 4.0],
            angular_diameter: angle,
        }
    }

    /// Form factor of a rectangle a × b seen from a parallel element at distance c below one of its corners.
    fn corner(a: f64, b: f64, c: f64) -> f64 {
        let (x, y) = (a / c, b / c);
        let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
        (x / p * (y / p).atan() + y / q * (x / q).atan()) / TAU
    }

    #[test]
    fn a_rectangular_emitter_agrees_with_the_closed_form() {
        let scene = Scene::new(SceneParts {
            surfaces: vec![surface("lamp", 7.0), surface("floor", 0.0)],
            facets: vec![facet(0, square(1.0, 0.5, false)), facet(1, square(0.0, 2.0, true))],
            lights: vec![Light::Emitter { surface: 0, name: None }],
            ..SceneParts::default()
        })
        .unwrap();
        let transport = Transport::new(&scene);
        let light = &scene.lights()[0];
        let up = vec3(0.0, 0.0, 1.0);
        let h = irradiance(&scene, &transport, light, Vec3::ZERO, up, 4096, 1);
        let exact = 7.0 * 4.0 * corner(0.5, 0.5, 1.0);
        assert!((h[0] / exact - 1.0).abs() < 1e-3, "{} {exact}", h[0]);
        let away = irradiance(&scene, &transport, light, Vec3::ZERO, -up, 64, 1);
        assert_eq!(away, [0.0; 3]);
        let above = fluence(&scene, &transport, light, vec3(0.0, 0.0, 2.0), 64, 1);
        assert_eq!(above, [0.0; 3], "the lamp shines downwards only");
    }

    #[test]
    fn the_sun_is_dimmed_by_medium_and_pane_and_stopped_by_walls() {
        let mut map = Voxmap::new(vec3(-1.0, -1.0, 0.0), Vec3::splat(1.0), [2, 2, 2]).unwrap();
        (0..8).for_each(|i| map.set(i, [0.3; 3], [0.5; 3], [0.0; 3], [0.0; 3]));
        let pane = Pane {
            name: "pane".into(),
            plates: vec![square(3.0, 9.0, true)],
            thickness: 0.01,
            extinction: [10.0, 0.0, 20.0],
            albedo: [0.0; 3],
            emission: [0.0; 3],
        };
        let parts = SceneParts {
            panes: vec![pane],
            voxmap: Some(map.seal().unwrap()),
            lights: vec![sun(0.0)],
            ..SceneParts::default()
        };
        let scene = Scene::new(parts.clone()).unwrap();
        let transport = Transport::new(&scene);
        let p = vec3(0.0, 0.5, 1.0);
        let g = fluence(&scene, &transport, &scene.lights()[0], p, 16, 3);
        // Towards (0, −0.6, 0.8): one metre up takes 1.25 m.
        let depth: Bands = [0.3 * 1.25 + 0.1 / 0.8, 0.3 * 1.25, 0.3 * 1.25 + 0.2 / 0.8];
        for b in 0..3 {
            let exact = [1.0, 2.0, 4.0][b] * (-depth[b]).exp();
            assert!((g[b] / exact - 1.0).abs() < 1e-12, "{} {exact}", g[b]);
        }
        let h = irradiance(&scene, &transport, &scene.lights()[0], p, vec3(0.0, 0.0, 1.0), 16, 3);
        assert!((h[0] / g[0] - 0.8).abs() < 1e-12);
        let walled = SceneParts {
            surfaces: vec![surface("roof", 0.0)],
            facets: vec![facet(0, square(2.5, 9.0, true))],
            ..parts
        };
        let scene = Scene::new(walled).unwrap();
        let transport = Transport::new(&scene);
        assert_eq!(fluence(&scene, &transport, &scene.lights()[0], p, 16, 3), [0.0; 3]);
    }

    #[test]
    fn wide_suns_and_skies_have_their_exact_means() {
        let floor = SceneParts {
            surfaces: vec![surface("floor", 0.0)],
            facets: vec![facet(0, square(0.0, 1.0, true))],
            ..SceneParts::default()
        };
        let scene = Scene::new(floor).unwrap();
        let transport = Transport::new(&scene);
        let towards = vec3(0.0, -0.6, 0.8);
        let h = irradiance(&scene, &transport, &sun(0.8), Vec3::ZERO, towards, 1024, 5);
        assert!((h[1] / 2.0 - 1.0).abs() < 2e-3, "E⊥ is kept for a wide sun: {}", h[1]);
        let sky = Light::Sky { name: "sky".into(), radiance: [2.0; 3] };
        let up = vec3(0.0, 0.0, 1.0);
        let h = irradiance(&scene, &transport, &sky, Vec3::ZERO, up, 64, 5);
        assert!((h[0] / TAU - 1.0).abs() < 1e-9, "{}", h[0]);
        let g = fluence(&scene, &transport, &sky, vec3(0.0, 0.0, 1e-4), 1024, 5);
        assert!((g[0] / (4.0 * PI) - 1.0).abs() < 0.01, "half the sphere is floor: {}", g[0]);
    }
}
