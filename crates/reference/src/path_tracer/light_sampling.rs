//! Light sampling: suns, the sky, point lights, and every facet that emits.
//!
//! A facet is chosen with probability P ∝ area × flux, and a point on it uniformly; seen from a distance r at cosine c to its normal
//! the density per steradian is P r²/(A c).

use super::flight::direction_about;
use zonal_math::Vec3;
use zonal_scene::{Bands, IntensityDistribution, Light, Scene, Sides, SkyDistribution};

/// Points along each parameter at which the textured emission of a facet is evaluated for its weight.
const TEXTURE_SAMPLES_PER_SIDE: usize = 4;

/// A sun as a disc of uniform radiance.
struct SunDisc {
    towards: Vec3,
    /// Cosine of the angular radius.
    cos: f64,
    /// Radiance times solid angle, W/m².
    flux: Bands,
}

/// The lights of a scene.
pub(super) struct LightSet<'a> {
    scene: &'a Scene,
    suns: Vec<SunDisc>,
    points: Vec<(Vec3, Bands, &'a IntensityDistribution)>,
    /// Unit and relative radiance of the skies.
    skies: Vec<(Bands, &'a SkyDistribution)>,
    emitters: Vec<u32>,
    cumulative: Vec<f64>,
    /// P/A of each facet of the scene, 1/m².
    density: Vec<f64>,
    direct: Vec<bool>,
}

/// A side of a facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FacetSide {
    /// The side of the normal.
    Front,
    /// The side opposite to the normal.
    Back,
}

/// A point of an emitting facet.
pub(super) struct FacetPoint {
    /// The facet.
    pub facet: u32,
    /// Position, m.
    pub at: Vec3,
    /// Unit normal of the front.
    pub normal: Vec3,
    /// Plate parameters.
    pub uv: [f64; 2],
}

impl<'a> LightSet<'a> {
    /// Collects the lights.
    pub(super) fn new(scene: &'a Scene) -> LightSet<'a> {
        let mut out = LightSet {
            scene,
            suns: Vec::new(),
            points: Vec::new(),
            skies: Vec::new(),
            emitters: Vec::new(),
            cumulative: Vec::new(),
            density: vec![0.0; scene.facets().len()],
            direct: (0..scene.surfaces().len()).map(|s| scene.is_direct_emitter(s)).collect(),
        };
        for light in scene.lights() {
            match light {
                Light::Sun { direction, irradiance, angular_diameter, .. } => {
                    let cos = (0.5 * angular_diameter).cos();
                    let flux = 2.0 * *irradiance / (1.0 + cos);
                    out.suns.push(SunDisc { towards: -*direction, cos, flux });
                }
                Light::Sky { radiance, distribution, .. } => out.skies.push((*radiance, distribution)),
                Light::Point { position, intensity, distribution, .. } => {
                    out.points.push((*position, *intensity, distribution));
                }
                Light::Emitter { .. } => {}
            }
        }
        let mut sum = 0.0;
        for f in 0..scene.facets().len() {
            let power = out.power(f);
            if power > 0.0 {
                sum += power;
                out.emitters.push(f as u32);
                out.cumulative.push(sum);
                out.density[f] = power / scene.facets()[f].plate.area();
            }
        }
        out.density.iter_mut().for_each(|x| *x /= sum.max(f64::MIN_POSITIVE));
        out
    }

    /// Area × flux of a facet, all bands.
    fn power(&self, f: usize) -> f64 {
        let facet = &self.scene.facets()[f];
        let s = &self.scene.surfaces()[facet.surface];
        if s.emission == Bands::ZERO {
            return 0.0;
        }
        let n = if s.emission_texture.is_some() { TEXTURE_SAMPLES_PER_SIDE } else { 1 };
        let at = |k: usize| (k as f64 + 0.5) / n as f64;
        let mean = (0..n * n).map(|k| {
            let [u, v] = facet.plate.warp([at(k % n), at(k / n)]);
            self.scene.emission_at(f, u, v).sum() / (n * n) as f64
        });
        mean.sum::<f64>() * facet.plate.area()
    }

    /// Radiance of all skies from a unit direction, W/(m² sr).
    pub(super) fn sky(&self, direction: Vec3) -> Bands {
        self.skies.iter().map(|(radiance, distribution)| *radiance * distribution.relative(direction)).sum()
    }

    /// Calls `each` for each sun and each point light with the unit direction towards a point of it, its distance, m, and its fluence at `at` without
    /// attenuation, W/m². A sun takes two numbers of [0, 1).
    pub(super) fn for_each_source(
        &self,
        at: Vec3,
        mut numbers: impl FnMut() -> [f64; 2],
        mut each: impl FnMut(Vec3, f64, Bands),
    ) {
        for s in &self.suns {
            let u = numbers();
            let is_disc = s.cos != 1.0;
            let sampled = || direction_about(s.towards, 1.0 - u[0] * (1.0 - s.cos), u[1]);
            each(if is_disc { sampled() } else { s.towards }, f64::INFINITY, s.flux);
        }
        for (position, intensity, distribution) in &self.points {
            let r = (*position - at).length();
            let towards = (*position - at) / r;
            each(towards, r, *intensity * (distribution.relative(-towards) / (r * r)));
        }
    }

    /// A point of an emitter from three numbers of [0, 1); `None` without emitters.
    pub(super) fn sample_point(&self, u: [f64; 3]) -> Option<FacetPoint> {
        let total = *self.cumulative.last()?;
        let k = self.cumulative.partition_point(|&x| x <= u[2] * total).min(self.emitters.len() - 1);
        let facet = self.emitters[k];
        let plate = &self.scene.facets()[facet as usize].plate;
        let uv = plate.warp([u[0], u[1]]);
        Some(FacetPoint { facet, at: plate.at(uv[0], uv[1]), normal: plate.normal(), uv })
    }

    /// The density per steradian with which [`LightSet::sample_point`] draws a point of a facet seen from distance `r` (m) at this
    /// cosine.
    pub(super) fn density(&self, facet: u32, r: f64, cos: f64) -> f64 {
        self.density[facet as usize] * r * r / cos.abs()
    }

    /// Radiance of a side of a facet, W/(m² sr), and whether it is direct light.
    pub(super) fn facet_radiance(&self, facet: u32, uv: [f64; 2], side: FacetSide) -> (Bands, bool) {
        let surface = self.scene.facets()[facet as usize].surface;
        let s = &self.scene.surfaces()[surface];
        if s.emission == Bands::ZERO || !(side == FacetSide::Front || s.sides == Sides::Both) {
            return (Bands::ZERO, false);
        }
        let e = self.scene.emission_at(facet as usize, uv[0], uv[1]);
        (e / std::f64::consts::PI, self.direct[surface])
    }
}
