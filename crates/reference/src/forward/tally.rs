//! What zones and names do with light, and how sums over walks become answers.

use super::ground::Ground;
use super::{Answer, HeatAnswer, estimate};
use crate::{Dice, Estimate};
use zonal_math::Vec3;
use zonal_scene::thermal::black;
use zonal_scene::zones::SUBCELLS;
use zonal_scene::{Bands, Known, Scene, VoxelZone, Zones, bands};

/// Tries to draw a point of a sub-cell that its sample sees.
const TRIES: usize = 200;

/// What a surface, a cell or a pane does with light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known3 {
    /// The share of what it meets that it absorbs.
    pub absorb: Bands,
    /// Extinction of a volume, 1/m; 1 of a surface.
    pub extinction: Bands,
    /// What it emits by itself, W/m² or W/m³: less than 0 where heat is taken away.
    pub sends: Bands,
    /// True where it sends out again what it absorbs.
    pub again: bool,
    /// a_b(1 − ρ_b), or 4κ_b(1 − Ω_b)a_b: in these shares.
    pub shares: Bands,
    /// Their sum: power sent out for σT⁴ = 1.
    pub emits: f64,
    /// σT⁴ where it is known, W/m².
    pub known: Option<f64>,
    /// Net power that is known, W/m² or W/m³.
    pub net: f64,
}

/// All that is optical in a scene.
pub(super) struct Optics {
    surfaces: Vec<Known3>,
    cells: Vec<Known3>,
    panes: Vec<Known3>,
    /// True where the bands are one: only the first is walked.
    pub one_band: bool,
}

/// Properties of a surface (m = 1) or of a volume (m = 4κ): what it emits in light mode, or what is known of it.
fn of(absorb: Bands, extinction: Option<Bands>, light: Bands, known: Option<Known>, scene: &Scene) -> Known3 {
    let measure = extinction.map_or([1.0; 3], |k| k.map(|k| 4.0 * k));
    let mut out = Known3 {
        absorb,
        extinction: extinction.unwrap_or([1.0; 3]),
        sends: light,
        again: false,
        shares: [0.0; 3],
        emits: 1.0,
        known: None,
        net: 0.0,
    };
    let Some(thermal) = scene.thermal() else { return out };
    let grey = thermal.shares.grey();
    let weigh = |a: Bands| bands(|b| if grey && b > 0 { 0.0 } else { a[b] * measure[b] * absorb[b] });
    match known {
        Some(Known::Temperature(t)) => {
            let w = thermal.shares.emissive(black(t))[0];
            out.shares = weigh(w.map(|w| w / black(t)));
            out.sends = out.shares.map(|s| s * black(t));
            out.known = Some(black(t));
        }
        Some(Known::Flux(q) | Known::Power(q)) => {
            out.shares = weigh(thermal.shares.weights(1000.0));
            let all: f64 = out.shares.iter().sum();
            out.sends = out.shares.map(|s| if all > 0.0 { q * s / all } else { 0.0 });
            (out.again, out.net) = (all > 0.0, q);
        }
        None => out.sends = [0.0; 3],
    }
    out.emits = out.shares.iter().sum();
    out
}

impl Optics {
    /// Of a scene whose surfaces have these areas, m².
    pub(super) fn new(scene: &Scene, areas: &[f64]) -> Optics {
        let thermal = scene.thermal();
        let surfaces: Vec<Known3> = (scene.surfaces().iter().enumerate())
            .map(|(i, s)| {
                let known = thermal.map(|t| match t.surfaces[i] {
                    Known::Power(p) => Known::Flux(p / areas[i]),
                    other => other,
                });
                of(s.reflectance.map(|r| 1.0 - r), None, s.emission, known, scene)
            })
            .collect();
        let cells: Vec<Known3> = scene.voxmap().map_or(Vec::new(), |m| {
            (0..m.len())
                .map(|c| {
                    let (k, a) = (m.extinction(c), m.albedo(c).map(|o| 1.0 - o));
                    let light = bands(|b| 4.0 * k[b] * a[b] * m.emission(c)[b] + m.source(c)[b]);
                    of(a, Some(k), light, m.heat(c), scene)
                })
                .collect()
        });
        let panes: Vec<Known3> = (scene.panes().iter().enumerate())
            .map(|(i, p)| {
                let a = p.albedo.map(|o| 1.0 - o);
                let light = bands(|b| 4.0 * p.extinction[b] * a[b] * p.emission[b]);
                of(a, Some(p.extinction), light, thermal.map(|t| t.panes[i]), scene)
            })
            .collect();
        let grey = thermal.is_some_and(|t| t.shares.grey());
        let same = |v: Bands| v[0] == v[1] && v[1] == v[2];
        let alike = |k: &Known3| same(k.absorb) && same(k.extinction) && same(k.sends);
        let lights = scene.lights().iter().all(|l| match l {
            zonal_scene::Light::Sun { irradiance, .. } => same(*irradiance),
            zonal_scene::Light::Sky { radiance, .. } => same(*radiance),
            zonal_scene::Light::Emitter { .. } => true,
        });
        let all = surfaces.iter().chain(&cells).chain(&panes).all(alike);
        let one = thermal.is_none() && all && lights && same(scene.surroundings().radiance);
        Optics { surfaces, cells, panes, one_band: grey || one }
    }
    /// Of a surface.
    pub(super) fn surface(&self, s: usize) -> &Known3 {
        &self.surfaces[s]
    }
    /// Of a cell.
    pub(super) fn cell(&self, c: usize) -> &Known3 {
        &self.cells[c]
    }
    /// Of a pane.
    pub(super) fn pane(&self, p: usize) -> &Known3 {
        &self.panes[p]
    }
}

/// Where sums stand: four numbers a name and a zone, three bands and ∫σT⁴ by what is absorbed and sent out again.
pub(super) struct Slots {
    /// The medium's.
    pub medium: usize,
    /// The first pane's.
    pub panes: usize,
    /// What escapes.
    pub escaped: usize,
    /// What ends on backs.
    pub backs: usize,
    /// The first zone's.
    pub zones: usize,
    /// All of them.
    pub len: usize,
}

impl Slots {
    /// Of a scene, with zones or without.
    pub(super) fn new(scene: &Scene, zones: Option<&Zones>) -> Slots {
        let medium = scene.surfaces().len();
        let escaped = medium + 1 + scene.panes().len();
        let first = escaped + 2;
        let len = first + zones.map_or(0, Zones::len);
        Slots { medium, panes: medium + 1, escaped, backs: escaped + 1, zones: first, len }
    }

    /// What sums say.
    pub(super) fn read(
        &self,
        scene: &Scene,
        zones: Option<&Zones>,
        optics: &Optics,
        (areas, volumes): (&[f64], &[f64]),
        (sums, one): (&[Vec<f64>], Bands),
    ) -> Answer {
        // No sum is known better than to what one walk carries, W a band.
        let floor = |e: Estimate, one: f64| Estimate { error: e.error.hypot(one), ..e };
        let all: f64 = if optics.one_band { one[0] } else { one.iter().sum() };
        let band = |b: usize| if optics.one_band { 0 } else { b };
        let powers =
            |slot: usize| [0, 1, 2].map(|b| floor(estimate(sums, |s| s[4 * slot + band(b)]), one[band(b)]));
        let panes = |b: usize| {
            let of = |s: &[f64]| (0..scene.panes().len()).map(|p| s[4 * (self.panes + p) + band(b)]).sum();
            floor(estimate(sums, of), one[band(b)])
        };
        let mut out = Answer {
            surfaces: (0..scene.surfaces().len()).map(powers).collect(),
            medium: powers(self.medium),
            panes: [0, 1, 2].map(panes),
            escaped: powers(self.escaped),
            backs: powers(self.backs),
            ..Answer::default()
        };
        if let Some(z) = zones {
            out.zones = (0..z.len())
                .map(|i| {
                    let (_, measure) = z.response(i);
                    [0, 1, 2].map(|b| {
                        let e = estimate(sums, |s| s[4 * (self.zones + i) + band(b)] / measure);
                        floor(e, one[band(b)] / measure)
                    })
                })
                .collect();
        }
        if scene.thermal().is_none() {
            return out;
        }
        let heat = |slot: usize, factor: [f64; 3], parts: &[(&Known3, f64)]| {
            // Of what has a temperature: its size, ∫σT⁴ of what is given or comes from q; net power of known powers and what known temperatures emit.
            let warm = parts.iter().filter(|(k, _)| k.known.is_some() || k.emits > 0.0);
            let size: f64 = warm.map(|p| p.1).sum();
            let given = |(k, size): &(&Known3, f64)| match k.known {
                Some(e) => e * size,
                None if k.emits > 0.0 => k.net * size / k.emits,
                None => 0.0,
            };
            let base: f64 = parts.iter().map(given).sum();
            let sent: f64 = parts
                .iter()
                .map(|(k, size)| size * if k.known.is_some() { k.sends.iter().sum() } else { k.net })
                .sum();
            // Sums of names hold what known temperatures absorb, and those of zones what arrives at any.
            let absorbs = |s: &[f64]| (0..3).map(|b| factor[b] * s[4 * slot + b]).sum::<f64>();
            let takes = slot < self.zones || parts.iter().all(|p| p.0.known.is_some());
            HeatAnswer {
                emissive: (size > 0.0).then(|| {
                    let least =
                        parts.iter().map(|p| p.0.emits).filter(|e| *e > 0.0).fold(f64::INFINITY, f64::min);
                    let found = parts.iter().any(|p| p.0.again) && least.is_finite();
                    let e = estimate(sums, |s| (base + s[4 * slot + 3]) / size);
                    floor(e, if found { all / (least * size) } else { 0.0 })
                }),
                power: {
                    let e = estimate(sums, |s| sent - if takes { absorbs(s) } else { 0.0 });
                    floor(e, if takes { all } else { 0.0 })
                },
            }
        };
        let one = [1.0; 3];
        for (i, k) in optics.surfaces.iter().enumerate() {
            out.heat.push(heat(i, one, &[(k, areas[i])]));
        }
        if scene.voxmap().is_some() {
            let parts: Vec<(&Known3, f64)> = match zones {
                None => optics.cells.iter().zip(volumes.iter().copied()).collect(),
                Some(z) => z.voxels.iter().map(|v| (optics.cell(v.cell), v.volume)).collect(),
            };
            out.heat.push(heat(self.medium, one, &parts));
        }
        for (i, k) in optics.panes.iter().enumerate() {
            let p = &scene.panes()[i];
            let volume = p.thickness * p.plates.iter().map(|q| q.area()).sum::<f64>();
            out.heat.push(heat(self.panes + i, one, &[(k, volume)]));
        }
        if let Some(z) = zones {
            for i in 0..z.len() {
                let (_, measure) = z.response(i);
                let k = if i < z.voxel_offset() {
                    optics.surface(z.patches[i].surface)
                } else if i < z.pane_offset() {
                    optics.cell(z.voxels[i - z.voxel_offset()].cell)
                } else {
                    optics.pane(z.panes[i - z.pane_offset()].pane)
                };
                let part =
                    if i < z.voxel_offset() { k.absorb } else { bands(|b| k.absorb[b] * k.extinction[b]) };
                out.zone_heat.push(heat(self.zones + i, part, &[(k, measure)]));
            }
        }
        out
    }
}

/// The part of a cell with walls that holds a point: the one of which some sample sees it.
pub(super) fn part_of(
    ground: &Ground,
    zones: &Zones,
    range: std::ops::Range<usize>,
    at: Vec3,
) -> Option<usize> {
    let samples = range.flat_map(|k| zones.voxels[k].part.iter().map(move |s| (k, s.point)));
    let mut near: Vec<(usize, Vec3)> = samples.collect();
    near.sort_by(|a, b| (a.1 - at).length2().total_cmp(&(b.1 - at).length2()));
    near.iter().find(|(_, p)| ground.sees(*p, at)).or(near.first()).map(|x| x.0)
}

/// A point of a voxel zone.
pub(super) fn point_of(ground: &Ground, z: &VoxelZone, lo: Vec3, edge: Vec3, dice: &mut Dice) -> Vec3 {
    if z.part.is_empty() {
        return dice.in_box(lo, lo + edge);
    }
    let mut rest = dice.roll() * z.part.iter().map(|s| s.volume).sum::<f64>();
    let mut chosen = None;
    for s in z.part.iter() {
        rest -= s.volume;
        chosen = Some(s);
        if rest <= 0.0 {
            break;
        }
    }
    let Some(s) = chosen else { return dice.in_box(lo, lo + edge) };
    let small = edge / SUBCELLS as f64;
    let k = s.subcell as usize;
    let place = [k / (SUBCELLS * SUBCELLS), k / SUBCELLS % SUBCELLS, k % SUBCELLS].map(|i| i as f64);
    let lo = lo + small.scale(Vec3::from_array(place));
    (0..TRIES).map(|_| dice.in_box(lo, lo + small)).find(|x| ground.sees(s.point, *x)).unwrap_or(s.point)
}
