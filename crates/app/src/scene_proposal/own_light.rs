//! How much of a model its own light reaches.
//!
//! Points on the surfaces, spread by area, see points on the emitting surfaces, spread by power, and the lights of the file:
//!
//! ```text
//!     E(x) = Σ_k Φ_k cos θ cos θ_k / (π r²) V(x, k)  +  Σ_l I_l cos θ / r² V(x, l)  +  Σ_s E_s cos θ V(x, s)
//! ```
//!
//! The model's own light suffices if at least a tenth of these points receive 0.01 W/m² (about 7 lx at 555 nm). The lamp of a room passes; a light-emitting diode,
//! a glowing display or the visor of a helmet do not.

use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_math::low_discrepancy::r2;
use zonal_scene::{Light, Scene, Sides};
use zonal_transport::Transport;
use zonal_transport::lights::{LightSampler, Receiver};

/// Least irradiance that counts as light, W/m².
pub(super) const MIN_IRRADIANCE: f64 = 0.01;
/// Fraction of the area with that irradiance, from which the own light suffices.
pub(super) const MIN_LIT_FRACTION: f64 = 0.1;
/// Points on surfaces, and points on emitting surfaces that each sees.
const RECEIVING_POINTS: usize = 256;
const EMITTING_POINTS: usize = 64;
/// Lights of a file that each point sees.
const MAX_LIGHTS: usize = 64;

/// A point on a surface.
#[derive(Clone, Copy)]
struct SpreadPoint {
    at: Vec3,
    normal: Vec3,
    has_back: bool,
    /// Power of an emitting point and its surroundings, W.
    power: f64,
}

/// Fraction of the area of a model that its own light reaches; zero without any.
pub(super) fn lit_fraction(transport: &Transport) -> f64 {
    let scene = transport.scene();
    let emitting = spread_points(scene, EMITTING_POINTS, |s| scene.surfaces()[s].emission.mean());
    if emitting.is_empty() && scene.lights().is_empty() {
        return 0.0;
    }
    let receiving = spread_points(scene, RECEIVING_POINTS, |_| 1.0);
    let is_lit = |p: &&SpreadPoint| {
        let front = irradiance(transport, p, p.normal, &emitting);
        front >= MIN_IRRADIANCE
            || p.has_back && irradiance(transport, p, p.normal * -1.0, &emitting) >= MIN_IRRADIANCE
    };
    receiving.iter().filter(is_lit).count() as f64 / receiving.len().max(1) as f64
}

/// Points spread evenly by area times a weight of the surface.
fn spread_points(scene: &Scene, count: usize, weight: impl Fn(usize) -> f64) -> Vec<SpreadPoint> {
    let sides = |s: usize| if scene.surfaces()[s].sides == Sides::Both { 2.0 } else { 1.0 };
    let of_facet: Vec<f64> =
        scene.facets().iter().map(|f| f.plate.area() * sides(f.surface) * weight(f.surface)).collect();
    let total: f64 = of_facet.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return Vec::new();
    }
    let (mut out, mut sum) = (Vec::with_capacity(count), 0.0);
    for (f, own) in scene.facets().iter().zip(of_facet) {
        sum += own;
        while out.len() < count && sum >= (out.len() as f64 + 0.5) / count as f64 * total {
            let [u, v] = f.plate.warp(r2(out.len(), [0.5; 2]));
            let surface = &scene.surfaces()[f.surface];
            let texture = surface.emission_texture.map(|t| scene.textures()[t].sample(f.uv_at(u, v)).mean());
            out.push(SpreadPoint {
                at: f.plate.at(u, v),
                normal: f.plate.normal(),
                has_back: surface.sides == Sides::Both && !surface.solid,
                power: total / count as f64 * texture.unwrap_or(1.0),
            });
        }
    }
    out
}

/// Irradiance on one side of a point by the light of the model, W/m².
fn irradiance(transport: &Transport, p: &SpreadPoint, normal: Vec3, emitting: &[SpreadPoint]) -> f64 {
    let of_emitter = |source: &SpreadPoint| {
        let (way, back) = (source.at - p.at, if source.has_back { 0.5 } else { 1.0 });
        let r2 = way.length2();
        let (cosine, other) = (way.dot(normal), -way.dot(source.normal));
        let other = if source.has_back { other.abs() } else { other };
        if !(cosine > 0.0 && other > 0.0 && r2 > 0.0) || transport.occluded(p.at, source.at) {
            return 0.0;
        }
        back * source.power * cosine * other / (PI * r2 * r2)
    };
    let of_light = |light: &Light| {
        let sampler = LightSampler::new(transport.scene(), light);
        let sample = sampler.sample_at(transport, p.at, Receiver::Surface(normal), [0.5; 3]);
        let arrived = sample.filter(|s| !transport.occluded(p.at, s.end));
        arrived.map_or(0.0, |s| s.flux.mean())
    };
    let lights = transport.scene().lights().iter().take(MAX_LIGHTS);
    emitting.iter().map(of_emitter).sum::<f64>() + lights.map(of_light).sum::<f64>()
}
