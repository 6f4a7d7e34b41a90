//! Direct light on the zones: H_dir and G_dir of every light, and the power that each light brings in, by rays.
//!
//! Zones gather: points of the zone, shadow rays with coloured transmittance. The power of a light is measured the other way
//! round, by rays that start at the light: what it sends in, what leaves again, what ends on black backs. Both must agree;
//! where closure is restored, the gathered fields are scaled so that they do, and the change is told.

use crate::gather::{Gathered, gather};
use crate::surroundings::fate;
use rayon::prelude::*;
use std::f64::consts::PI;
use zonal_math::directions::{cosine, sphere, turn};
use zonal_math::{Vec3, sequence};
use zonal_scene::{Bands, Light, Note, Progress, Scene, Zones, bands};
use zonal_transport::Transport;
use zonal_transport::direct::{Lamp, Source};

/// A ray dimmed by less has met nothing: rounding where the medium's box and a wall coincide.
const CLEAR: f64 = 1e-9;
/// Beyond this relative disagreement with the power measured at the light, fields are left as they are: something is wrong that
/// no factor mends.
const MOST_CHANGE: f64 = 0.12;
/// Rays that measure the power of a light.
const BEAM_RAYS: usize = 1 << 17;

/// What one light does, with its own balance, W a band.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lit {
    /// Its name: that of a sun or a sky, or of the surface of an emitter.
    pub name: String,
    /// H_dir of patches, G_dir of volume zones, W/m², one entry a zone.
    pub fields: Vec<Bands>,
    /// Standard error of the largest band of `fields`, W/m², one entry a zone.
    pub error: Vec<f64>,
    /// Shadow rays.
    pub rays: u64,
    /// Power that came in, from a sun or a sky.
    pub incoming: Bands,
    /// Power emitted, by a surface that counts as direct light.
    pub emitted: Bands,
    /// Power that left again without meeting anything.
    pub escaped: Bands,
    /// Power on black backs.
    pub backs: Bands,
    /// Largest relative change by which the fields were scaled to the power measured; zero without.
    pub largest_change: f64,
    /// What is wrong: fields and power disagree too much to be scaled.
    pub warning: Option<String>,
}

/// Direct light on the zones, light by light in the scene's order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Direct {
    /// The lights, in the order of `scene.lights()`.
    pub lights: Vec<Lit>,
}

impl Direct {
    /// Sum of the fields of all lights over `zones` zones, in the order of the lights.
    pub fn fields(&self, zones: usize) -> Vec<Bands> {
        let mut out = vec![[0.0; 3]; zones];
        for light in &self.lights {
            for (o, f) in out.iter_mut().zip(&light.fields) {
                (0..3).for_each(|b| o[b] += f[b]);
            }
        }
        out
    }
    /// Largest relative change by which the fields of any light were scaled.
    pub fn largest_change(&self) -> f64 {
        self.lights.iter().fold(0.0, |m, l| m.max(l.largest_change))
    }
    /// What is wrong with the lights.
    pub fn warnings(&self) -> impl Iterator<Item = Note> {
        self.lights
            .iter()
            .filter_map(|l| l.warning.as_ref())
            .map(|w| Note::warning("light-power", w.as_str()))
    }
}

/// Computes all lights; `normalise` scales the fields of each to the power measured at the light.
pub fn illuminate(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    normalise: bool,
    progress: &dyn Progress,
) -> Direct {
    let one = |l: usize| light(scene, zones, transport, l, normalise, progress);
    Direct { lights: (0..scene.lights().len()).map(one).collect() }
}

/// Computes light number `index` of the scene; as in [`illuminate`].
pub fn light(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    index: usize,
    normalise: bool,
    progress: &dyn Progress,
) -> Lit {
    let light = &scene.lights()[index];
    let Gathered { mut fields, error, rays } = gather(scene, zones, transport, light, progress);
    let beam = beam(scene, transport, light);
    let factor = if normalise { agreement(zones, &fields, &beam) } else { [1.0; 3] };
    let change = factor.iter().fold(0.0f64, |m, f| m.max((f - 1.0).abs()));
    let wild = change > MOST_CHANGE;
    if !wild {
        fields.iter_mut().for_each(|f| *f = bands(|b| f[b] * factor[b]));
    }
    let name = light.name(scene).to_string();
    let warning = wild.then(|| {
        format!(
            "light '{name}': what the zones met and what its rays brought differ by {:.0} %; it was left as gathered. Look for surfaces that coincide",
            100.0 * change
        )
    });
    let emitter = matches!(light, Light::Emitter { .. });
    let (emitted, incoming) = if emitter { (beam.sent, [0.0; 3]) } else { ([0.0; 3], beam.sent) };
    Lit {
        name,
        fields,
        error,
        rays,
        incoming,
        emitted,
        escaped: beam.escaped,
        backs: beam.backs,
        largest_change: if wild { 0.0 } else { change },
        warning,
    }
}

/// Power met by the zones according to the fields, W.
fn met(zones: &Zones, fields: &[Bands]) -> Bands {
    let patches = zones.patches.iter().map(|p| [p.area; 3]);
    let voxels = zones.voxels.iter().map(|v| v.extinction.map(|k| k * v.volume));
    let panes = zones.panes.iter().map(|p| p.extinction.map(|k| k * p.area * p.thickness));
    patches.chain(voxels).chain(panes).zip(fields).fold([0.0; 3], |s, (w, f)| bands(|b| s[b] + w[b] * f[b]))
}

fn agreement(zones: &Zones, fields: &[Bands], beam: &Beam) -> Bands {
    let met = met(zones, fields);
    bands(|b| {
        let want = beam.sent[b] - beam.escaped[b] - beam.backs[b];
        if met[b] > 0.0 && want > 0.0 { want / met[b] } else { 1.0 }
    })
}

/// What a light sends and loses, W.
#[derive(Clone, Copy, Debug, Default)]
struct Beam {
    sent: Bands,
    escaped: Bands,
    backs: Bands,
}

fn beam(scene: &Scene, transport: &Transport, light: &Light) -> Beam {
    // A fixed number of blocks summed in order: the same bits for any number of threads.
    const BLOCK: usize = 1 << 10;
    let lamp = Lamp::new(scene, light);
    let parts: Vec<Beam> = (0..BEAM_RAYS / BLOCK)
        .into_par_iter()
        .map(|block| {
            let mut sum = Beam::default();
            for k in block * BLOCK..(block + 1) * BLOCK {
                beam_ray(scene, transport, &lamp, k, &mut sum);
            }
            sum
        })
        .collect();
    let mut out = Beam::default();
    for p in parts {
        for b in 0..3 {
            out.sent[b] += p.sent[b] / BEAM_RAYS as f64;
            out.escaped[b] += p.escaped[b] / BEAM_RAYS as f64;
            out.backs[b] += p.backs[b] / BEAM_RAYS as f64;
        }
    }
    out
}

fn beam_ray(scene: &Scene, transport: &Transport, lamp: &Lamp, k: usize, sum: &mut Beam) {
    let (lo, hi) = scene.bounds();
    let (centre, radius) = ((lo + hi) * 0.5, 0.5 * scene.diagonal() * (1.0 + 1e-9));
    let (u, v) = four(k);
    match lamp.light() {
        Light::Sun { direction, irradiance, angular_diameter, .. } => {
            // The rectangle that the bounds throw across the beam.
            let dir = sun_ray(*direction, *angular_diameter, sequence::net(k as u32, [0, 0]));
            let (t, s) = direction.frame();
            let half = (hi - lo) * 0.5;
            let extent = |w: Vec3| half.x * w.x.abs() + half.y * w.y.abs() + half.z * w.z.abs();
            let slack = 1.0 + angular_diameter;
            let (wt, ws) = (extent(t) * slack, extent(s) * slack);
            let at = centre + t * (wt * (2.0 * u[0] - 1.0)) + s * (ws * (2.0 * u[1] - 1.0));
            let power = irradiance.map(|e| e * 4.0 * wt * ws);
            enter(scene, transport, at - dir * (2.0 * radius), dir, power, sum);
        }
        Light::Sky { radiance, .. } => {
            let out = sphere(u);
            let dir = cosine(-out, v);
            let power = radiance.map(|l| l * PI * 4.0 * PI * radius * radius);
            enter(scene, transport, centre + out * radius, dir, power, sum);
        }
        Light::Emitter { .. } => emitter_ray(scene, transport, lamp, k, u, v, sum),
    }
}

/// The `k`-th point of the four-dimensional R sequence, two and two: φ^{−m} with φ⁵ = φ + 1.
fn four(k: usize) -> ([f64; 2], [f64; 2]) {
    const ALPHA: [f64; 4] =
        [0.856_674_883_854_502_9, 0.733_891_856_627_126, 0.628_706_721_037_808_7, 0.538_597_257_223_610_1];
    let x = ALPHA.map(|a| sequence::wrap(0.5 + k as f64 * a));
    ([x[0], x[1]], [x[2], x[3]])
}

/// A direction from the sun's disc.
fn sun_ray(direction: Vec3, angular_diameter: f64, u: [f64; 2]) -> Vec3 {
    let (t, b) = direction.frame();
    let r = (0.5 * angular_diameter).tan() * u[0].sqrt();
    let (s, c) = turn(u[1]);
    (direction + t * (r * c) + b * (r * s)).normalized()
}

/// A ray from outside: it counts as come in where it meets a medium, a pane or a surface that takes part; one that ends
/// on the outside of a black back has met nothing of the scene.
fn enter(scene: &Scene, transport: &Transport, origin: Vec3, dir: Vec3, power: Bands, sum: &mut Beam) {
    let (share, back) = fate(scene, transport, origin, dir);
    if share.iter().all(|&s| s > 1.0 - CLEAR) {
        return;
    }
    for b in 0..3 {
        sum.sent[b] += power[b];
        let lost = if back { &mut sum.backs } else { &mut sum.escaped };
        lost[b] += power[b] * share[b];
    }
}

fn emitter_ray(
    scene: &Scene,
    transport: &Transport,
    lamp: &Lamp,
    k: usize,
    u: [f64; 2],
    v: [f64; 2],
    sum: &mut Beam,
) {
    let Some(Source::Point { at, normal, both, power, .. }) =
        lamp.source([u[0], u[1], sequence::third(k as u32, 0)])
    else {
        return;
    };
    let normal = if both && k % 2 == 1 { -normal } else { normal };
    let sides = if both { 2.0 } else { 1.0 };
    let power = power.map(|p| p * PI * sides);
    let (share, back) = fate(scene, transport, at, cosine(normal, v));
    for b in 0..3 {
        sum.sent[b] += power[b];
        let lost = if back { &mut sum.backs } else { &mut sum.escaped };
        lost[b] += power[b] * share[b];
    }
}
