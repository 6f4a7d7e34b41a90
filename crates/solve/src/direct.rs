//! Direct light on the zones: H_dir and G_dir of every light, and the power that each light brings in, by rays.
//!
//! Zones gather: points of the zone, shadow rays with coloured transmittance. The power of a light is measured the other way
//! round, by rays that start at the light: what it sends in, what leaves again, what ends on black backs. Both must agree;
//! where closure is restored, the gathered fields are scaled so that they do, and the change is told.
//!
//! **Error.** With P the power that the zones meet by the gathered fields, P' the power measured at the light, σ and σ' their standard errors (σ from
//! the errors of the zones, which are independent; σ' from the spread of blocks of rays) and D = P'/P − 1, the fields are scaled by
//!
//! ```text
//! f = 1 + αD,      α = σ²/(σ² + σ'²)
//! ```
//!
//! the mean by inverse variance. Scaling adds the relative error α σ'/P, which all zones share. What |D| exceeds 2 √(σ² + σ'²)/P by is no noise: it is
//! added to the shared error whether the fields are scaled or not. The error of a zone is its own error and its share of the shared one:
//! [`Lit::error_of`].

use crate::columns;
use crate::energy::section;
use crate::gather::{Gathered, gather};
use crate::stage::{Pen, Reader};
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
pub(crate) const BEAM_RAYS: usize = 1 << 17;

/// What one light does, with its own balance, W a band.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lit {
    /// Its name: that of a sun or a sky, or of the surface of an emitter.
    pub name: String,
    /// H_dir of patches, G_dir of volume zones, W/m², one entry a zone.
    pub fields: Vec<Bands>,
    /// Standard error of `fields`, W/m², one entry a zone: independent from zone to zone unless `by_exchange`.
    pub error: Vec<Bands>,
    /// Relative error of `fields` that all zones share.
    pub shared: Bands,
    /// True where the fields come from exchange areas, false where they come from shadow rays.
    pub by_exchange: bool,
    /// Power P that arrives at the slopes inside zones, W (see [`crate::Operator::slopes`]); empty for none.
    pub slopes: Vec<Bands>,
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
    /// Standard errors of the power that came in or was emitted, of `escaped`, of `backs`, W.
    pub power_error: [Bands; 3],
    /// Largest relative change by which the fields were scaled to the power measured; zero without.
    pub largest_change: f64,
    /// What is wrong: fields and power disagree too much to be scaled, or the sampling error misses the tolerance.
    pub warning: Option<String>,
}

impl Lit {
    /// Error of the field of zone `i`, W/m².
    pub fn error_of(&self, i: usize) -> Bands {
        let own = self.error.get(i).copied().unwrap_or_default();
        let field = self.fields.get(i).copied().unwrap_or_default();
        bands(|b| own[b] + self.shared[b] * field[b].abs())
    }

    /// The light as a stage.
    pub(crate) fn kept(&self) -> Vec<u8> {
        let mut pen = Pen::default();
        pen.text(&self.name);
        pen.triples(&self.fields);
        pen.triples(&self.error);
        pen.int(self.rays as usize);
        let [sent, escaped, backs] = self.power_error;
        pen.triples(&[
            self.incoming,
            self.emitted,
            self.escaped,
            self.backs,
            [self.largest_change, 0.0, 0.0],
            self.shared,
            sent,
            escaped,
            backs,
        ]);
        pen.text(self.warning.as_deref().unwrap_or(""));
        pen.bytes()
    }

    /// A light of shadow rays on so many zones that [`Lit::kept`] wrote.
    pub(crate) fn restored(bytes: &[u8], zones: usize) -> Option<Lit> {
        let mut r = Reader::new(bytes);
        let (name, fields, error, rays) = (r.text()?, r.triples()?, r.triples()?, r.int()? as u64);
        let (small, warning) = (r.triples()?, r.text()?);
        let [incoming, emitted, escaped, backs, [largest_change, ..], shared, e0, e1, e2] = small[..] else {
            return None;
        };
        let warning = (!warning.is_empty()).then_some(warning);
        let whole = r.at_end() && fields.len() == zones && error.len() == zones;
        whole.then_some(Lit {
            name,
            fields,
            error,
            shared,
            rays,
            incoming,
            emitted,
            escaped,
            backs,
            power_error: [e0, e1, e2],
            largest_change,
            warning,
            ..Lit::default()
        })
    }
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
    let Gathered { mut fields, mut error, rays, limited } = gather(scene, zones, transport, light, progress);
    let mut beam = beam(scene, transport, light);
    let emitter = matches!(light, Light::Emitter { .. });
    let Agreement { off, change, shared } = agreement(zones, &fields, &error, &beam, normalise);
    let largest = |v: Bands| v.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let wild = largest(off) > MOST_CHANGE;
    let name = light.name(scene).to_string();
    let mut warning = wild.then(|| {
        format!(
            "light '{name}': what the zones met and what its rays brought differ by {:.0} %; it was left as gathered. Look for surfaces that coincide",
            100.0 * largest(off)
        )
    });
    if normalise && !wild {
        let factor = change.map(|c| 1.0 + c);
        for list in [&mut fields, &mut error] {
            list.iter_mut().for_each(|x| *x = bands(|b| x[b] * factor[b]));
        }
        beam.balance(met(zones, &fields), emitter);
    }
    let tolerance = scene.options().tolerance;
    if warning.is_none() && limited.0 > tolerance {
        warning = Some(format!(
            "light '{name}': shadow rays on the zones leave an error of {:.1e} of its root mean square, more than the tolerance, {tolerance:.1e}; they are limited to {} a zone. The stated errors include it; use smaller patches where its shadows end, or a larger tolerance",
            limited.0, limited.1
        ));
    }
    let (emitted, incoming) = if emitter { (beam.sent, [0.0; 3]) } else { ([0.0; 3], beam.sent) };
    Lit {
        name,
        fields,
        error,
        shared,
        rays,
        incoming,
        emitted,
        escaped: beam.escaped,
        backs: beam.backs,
        power_error: beam.error,
        largest_change: if wild || !normalise { 0.0 } else { largest(change) },
        warning,
        ..Lit::default()
    }
}

/// Power met by the zones according to the fields, W.
fn met(zones: &Zones, fields: &[Bands]) -> Bands {
    columns::sum(fields.len(), |i| {
        let w = section(zones, i);
        bands(|b| w[b] * fields[i][b])
    })
}

/// How the fields of a light are made to agree with the power measured at it.
struct Agreement {
    /// Relative difference, where it is more than noise.
    off: Bands,
    /// Relative change of the fields.
    change: Bands,
    /// Relative error that all zones share after it.
    shared: Bands,
}

/// Compares fields with their errors to the power of the beam; see the module's header.
fn agreement(zones: &Zones, fields: &[Bands], error: &[Bands], beam: &Beam, normalise: bool) -> Agreement {
    /// A difference beyond so many standard errors is no noise.
    const NOISE: f64 = 2.0;
    let met = met(zones, fields);
    let square: Bands = columns::sum(fields.len(), |i| {
        let w = section(zones, i);
        bands(|b| (w[b] * error[i][b]).powi(2))
    });
    let mut out = Agreement { off: [0.0; 3], change: [0.0; 3], shared: [0.0; 3] };
    for b in 0..3 {
        let want = beam.sent[b] - beam.escaped[b] - beam.backs[b];
        if met[b] <= 0.0 || want <= 0.0 {
            continue;
        }
        let (own, other) = (square[b].sqrt() / met[b], beam.kept_error[b] / met[b]);
        let off = want / met[b] - 1.0;
        let both = own.hypot(other);
        let weight = if both > 0.0 { (own / both).powi(2) } else { 1.0 };
        out.change[b] = weight * off;
        out.shared[b] = (off.abs() - NOISE * both).max(0.0);
        if out.shared[b] > 0.0 {
            out.off[b] = off;
        }
        if normalise {
            out.shared[b] += weight * other;
        }
    }
    out
}

/// What a light sends and loses, W.
#[derive(Clone, Copy, Debug, Default)]
struct Beam {
    sent: Bands,
    escaped: Bands,
    backs: Bands,
    /// Standard errors of the three.
    error: [Bands; 3],
    /// Standard error of what is kept, sent − escaped − backs.
    kept_error: Bands,
}

impl Beam {
    fn powers(&self) -> [Bands; 4] {
        let kept = bands(|b| self.sent[b] - self.escaped[b] - self.backs[b]);
        [self.sent, self.escaped, self.backs, kept]
    }
    /// Makes the powers balance with what the zones met: what a surface emits is known, and what comes in from outside is not.
    fn balance(&mut self, met: Bands, emitter: bool) {
        for b in 0..3 {
            if met[b] <= 0.0 {
                continue;
            }
            let lost = self.escaped[b] + self.backs[b];
            if emitter && lost > 0.0 && self.sent[b] >= met[b] {
                let factor = (self.sent[b] - met[b]) / lost;
                self.escaped[b] *= factor;
                self.backs[b] *= factor;
            } else {
                self.sent[b] = met[b] + lost;
            }
        }
    }
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
    let n = parts.len() as f64;
    let powers: Vec<[Bands; 4]> = parts.iter().map(Beam::powers).collect();
    // A block's sum over the rays of a block is one estimate of the power.
    let each = n / BEAM_RAYS as f64;
    let mean = |k: usize| bands(|b| powers.iter().map(|p| p[k][b]).sum::<f64>() / BEAM_RAYS as f64);
    let spread = |k: usize| {
        let mean = mean(k);
        bands(|b| {
            let square: f64 = powers.iter().map(|p| (p[k][b] * each - mean[b]).powi(2)).sum();
            (square / (n * (n - 1.0))).sqrt()
        })
    };
    Beam {
        sent: mean(0),
        escaped: mean(1),
        backs: mean(2),
        error: [spread(0), spread(1), spread(2)],
        kept_error: spread(3),
    }
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
