//! Direct light at the points where rays, connections and the medium meet zones, in place of the means of the zones.
//!
//! A zone has one radiosity B_j, of which r_j Σ_l H_l,j scatters direct light (r the reflectance of a patch, Ω/4 in the medium). Where a shadow passes
//! through the zone, or a lamp stands in it, what another zone sees of it is not this mean. At the point y of the zone
//!
//! ```text
//! B(y) = B_j + r_j (H_l(y) − H_l,j)/(q_j p_l)          H_l(y): one shadow ray to light l
//! ```
//!
//! The change has the mean 0 over the zone, but for the error of H_l,j itself: it counts where kernel, transmittance or visibility vary within the zone.
//!
//! **Where it is read.** A few points of every zone give the standard deviation σ_l of the light l within it. A light is chosen by p_l ∝ σ_l, and read with
//! the probability q_j = min(1, w_j r_j Σ_l σ_l/(τ Σ_k w_k B_k)), the sum over all that the sample collects: zones of even light cost nothing.
//!
//! **In the medium** the ray has q points by the same rule, q up to 4 and spread evenly. Of the pieces k of the ray, of weight w_k, one is chosen by
//! w_k r_k Σ_l σ_l,k, then a light l, then a point at the distance s by the absorption in the piece; or, for lights at a place, by the angle at which they
//! see it (Kulla and Fajardo 2012), so that the change stays bounded near a lamp. With c the distance of its centre from the line of the ray, at s = s_c,
//! and ϱ its radius,
//!
//! ```text
//! p(s) = (1 − a) P_k(l) w_k'(s)/∫w_k'  +  a Q(l) b/((θ₂ − θ₁)(b² + (s − s_c)²))        b² = c² + ϱ²,  tan θ = (s − s_c)/b
//! ```
//!
//! is the density of a point and a light, with P_k(l) the probability of piece and light, Q(l) = Σ_k P_k(l), and a = 1/2 for lights at a place, else 0. The
//! change is w'(s) r (G_l(y) − G_l,k)/(q p(s)).
//!
//! Skies vary little within zones and stay at their means.
//!
//! **Textures.** The reflectance ϱ(y) of the texture at a point of a patch that does not emit changes its radiosity in the ratio t = ϱ(y)/ϱ_j: the change is
//! (t − 1) B_j, and r_j above becomes ϱ(y).

use super::expected_path::{CollectedZones, ExpectedPath, MediumPiece, WeightedZone};
use super::gather_error::ratio;
use crate::engines::merged_operator::PatchGroups;
use crate::engines::rays::stored_rays::padded_bands::{LANES, PaddedBands, padded, widened};
use crate::engines::rays::stored_rays::path_continuation::PathLights;
use crate::engines::rays::weighted_choice;
use crate::right_hand_side::surroundings::zone_rays::{WeightedRay, point_in_zone};
use std::ops::Range;
use zonal_math::parallel;
use zonal_math::{Vec3, low_discrepancy, scrambled_sobol};
use zonal_scene::{Bands, ZoneKind, ZoneRef, Zones};
use zonal_transport::Transport;
use zonal_transport::lights::{LightBall, Receiver};

/// a: share of the points by angle, for lights at a place.
const SHARE_BY_ANGLE: f64 = 0.5;
/// Least breadth of an angle over the length of the ray.
const SMALLEST_BREADTH: f64 = 1e-9;
/// τ.
const VARIATION_OVER_RADIOSITY: f32 = 0.05;
/// Most points of the medium on a ray.
const MAX_POINTS_OF_RAY: f64 = 4.0;
/// Step between the numbers of the points of a ray: the golden section.
const GOLDEN_SECTION: f64 = 0.618_033_988_749_894_9;
/// Least σ over the mean of a zone: a few points may miss a small shadow.
const LEAST_VARIATION: f64 = 0.1;
/// Points of a patch, and of a volume zone, at which its light is compared with its mean, and the seed of their numbers.
const POINTS_OF_ZONE: [usize; 2] = [8, 4];
const VARIATION_SEED: u64 = 0x9b05_688c_2b3e_6c1f;

/// The light of one point in a sample.
pub(crate) struct PointChange {
    light: u32,
    /// Weighted change of the radiosity by this light, W/m².
    change: PaddedBands,
}

/// The numbers of a point in the medium.
struct MediumNumbers {
    zone: f64,
    /// The kind of choice of the distance.
    kind: f64,
    distance: f64,
    choice: f64,
    light: [f64; 3],
}

/// A point of a surface at the end of a ray, connection or path.
pub(crate) struct SurfacePoint {
    /// Its zone with its weight.
    pub zone: WeightedZone,
    /// m.
    pub at: Vec3,
    /// t.
    pub texture: Bands,
    /// Its part of the numbers of the sample.
    pub part: u32,
}

/// Parts of the numbers of a sample: of the ends of its ray and its connection, and two of the medium.
pub(crate) const RAY_PART: u32 = 2;
pub(crate) const CONNECTION_PART: u32 = 3;
const MEDIUM_PARTS: [u32; 2] = [4, 5];

/// The ray and the zones of a sample.
pub(crate) struct SampledZones<'a> {
    /// The ray.
    pub ray: &'a WeightedRay,
    /// Its zones, those of surfaces included.
    pub collected: &'a CollectedZones,
    /// The points of the surfaces.
    pub ends: &'a [SurfacePoint],
    /// The lookup of volume zones.
    pub path: &'a ExpectedPath<'a>,
    /// The number of the sample in its sequence.
    pub number: usize,
    /// The seed of the sequence.
    pub seed: u32,
}

/// Lights and what lies between them and the points.
#[derive(Clone, Copy)]
pub(crate) struct LightPlace<'a> {
    /// The lights of the scene.
    pub lights: &'a PathLights<'a>,
    /// Facets, panes and medium.
    pub transport: &'a Transport<'a>,
    /// Zones.
    pub zones: &'a Zones,
}

/// A light that is read at points.
struct PointLight {
    /// Its number.
    number: usize,
    /// The ball about a light at a place.
    ball: Option<LightBall>,
    /// σ of every zone, of the band in which it is largest, W/m².
    variation: Vec<f32>,
    /// Its scattered light in the radiosity of every patch, W/m², where patches share one radiosity.
    merged: Option<Vec<Bands>>,
}

impl PointLight {
    /// What zone `i` scatters of it in its radiosity, W/m².
    fn scattered(&self, place: LightPlace, i: usize) -> Bands {
        match self.merged.as_ref().and_then(|m| m.get(i)) {
            Some(mean) => *mean,
            None => place.zones.response(i).0 * place.lights.direct().lights[self.number].fields[i],
        }
    }
}

/// How much direct light varies within a zone.
#[derive(Clone, Copy, Default)]
struct Importance {
    /// r Σ_l σ_l, W/m².
    variation: f32,
    /// τ B, W/m².
    limit: f32,
}

impl Importance {
    /// q: the number of points that are read.
    fn number(self) -> f64 {
        if self.variation > 0.0 { f64::from(self.variation / self.limit.max(f32::MIN_POSITIVE)) } else { 0.0 }
    }
}

/// The lights that are read at points.
pub(crate) struct PointLights {
    lights: Vec<PointLight>,
    /// Σ_l σ_l of every zone, W/m².
    total: Vec<f32>,
    /// r Σ_l σ_l, and τ B, of every zone, W/m².
    importance: Vec<Importance>,
    /// Factor of every light of the scene, a column.
    factors: Vec<Vec<f32>>,
}

/// True for zones of one radiosity: not for sheets that transmit, whose radiosity is of both sides, nor for panes.
fn is_read(zones: &Zones, i: usize) -> bool {
    zones.kind(i) != ZoneKind::Pane && zones.sheets.opposite(i).is_none()
}

impl PointLights {
    /// The sharp lights of a scene, whose factors in every column are `factors`; `groups` are the patches that share one radiosity, and `radiosity` gives
    /// the sum of the columns.
    pub(crate) fn new(
        place: LightPlace,
        factors: Vec<Vec<f32>>,
        groups: Option<&PatchGroups>,
        radiosity: impl Fn(usize) -> f32 + Sync,
    ) -> PointLights {
        let LightPlace { lights, zones, .. } = place;
        let n = zones.len();
        let sharp = lights.samplers().iter().enumerate().filter(|(_, s)| !s.light().fills_sphere());
        let list: Vec<PointLight> = sharp
            .map(|(number, sampler)| {
                let merged = groups.map(|groups| {
                    let fields = &lights.direct().lights[number].fields;
                    let scattered = |i: usize| zones.patches[i].reflectance * fields[i];
                    let mut of_patches = parallel::collect(zones.patches.len(), scattered);
                    groups.average(&mut of_patches);
                    of_patches
                });
                let variation = parallel::collect(n, |i| variation(place, number, i) as f32);
                PointLight { number, ball: sampler.ball(), variation, merged }
            })
            .collect();
        let total: Vec<f32> = parallel::collect(n, |i| list.iter().map(|l| l.variation[i]).sum());
        let importance = |i: usize| Importance {
            variation: zones.response(i).0.max_element() as f32 * total[i],
            limit: VARIATION_OVER_RADIOSITY * radiosity(i),
        };
        PointLights { lights: list, importance: parallel::collect(n, importance), total, factors }
    }

    /// True where some light varies within a zone.
    pub(crate) fn has_light(&self) -> bool {
        self.total.iter().any(|t| *t > 0.0)
    }

    /// The change of column `c` in a sample.
    pub(crate) fn change(&self, c: usize, points: &[PointChange]) -> PaddedBands {
        let (mut sum, factors) = ([0.0; LANES], &self.factors[c]);
        for p in points {
            let factor = factors[p.light as usize];
            (0..LANES).for_each(|k| sum[k] += factor * p.change[k]);
        }
        sum
    }

    /// Σ of the parts of a list of weighted zones in the variation and limit of a sample.
    fn importance_of(&self, zones: &[WeightedZone]) -> Importance {
        zones.iter().fold(Importance::default(), |sum, z| {
            let Importance { variation, limit } = self.importance[z.zone as usize];
            let weight = largest(z);
            Importance { variation: sum.variation + weight * variation, limit: sum.limit + weight * limit }
        })
    }

    /// Adds the light at points of a sample: of the surfaces that it meets, and of the medium on its ray.
    pub(crate) fn add_points(&self, place: LightPlace, sample: &SampledZones, points: &mut Vec<PointChange>) {
        let limit = self.importance_of(&sample.collected.zones).limit;
        for end in sample.ends {
            self.add_surface(
                place,
                end,
                limit,
                scrambled_sobol::further_dimensions(sample.number, end.part, sample.seed),
                points,
            );
        }
        self.add_medium(place, sample, limit, points);
    }

    /// Adds the light at the surface point at the end of a ray, connection or path.
    fn add_surface(
        &self,
        place: LightPlace,
        end: &SurfacePoint,
        limit: f32,
        [u0, u1, u2, choice]: [f64; 4],
        points: &mut Vec<PointChange>,
    ) {
        let i = end.zone.zone as usize;
        let variation = largest(&end.zone) * self.importance[i].variation;
        let read = Importance { variation, limit }.number().min(1.0);
        if choice >= read {
            return;
        }
        let Some(light) = self.choose(i, choice / read) else { return };
        let probability = read * f64::from(light.variation[i] / self.total[i]);
        let receiver = receiver(place.zones, i);
        let incident = place.lights.incident(place.transport, light.number, end.at, receiver, [u0, u1, u2]);
        let weight = end.texture * widened(end.zone.weight) / probability;
        points.push(self.lit_point(place, light, i, incident, weight));
    }

    /// The change of zone `i` by the incident light of a point, of this weight.
    fn lit_point(
        &self,
        place: LightPlace,
        light: &PointLight,
        i: usize,
        incident: Bands,
        weight: Bands,
    ) -> PointChange {
        let (r, mean) = (place.zones.response(i).0, light.scattered(place, i));
        PointChange { light: light.number as u32, change: padded(weight * (r * incident - mean)) }
    }

    /// A light of zone `i`, by its variation.
    fn choose(&self, i: usize, u: f64) -> Option<&PointLight> {
        let lights = self.lights.iter().map(|l| (l, f64::from(l.variation[i])));
        weighted_choice::choose(lights, u * f64::from(self.total[i]))
    }

    /// Adds the light at points of the medium on the ray of a sample.
    fn add_medium(
        &self,
        place: LightPlace,
        sample: &SampledZones,
        limit: f32,
        points: &mut Vec<PointChange>,
    ) {
        let CollectedZones { zones, pieces } = sample.collected;
        let (Some(first), Some(last)) = (pieces.first(), pieces.last()) else { return };
        let medium = MediumOfRay {
            lights: self,
            sample,
            zones: first.zones.start..last.zones.end,
            distances: first.ends().start..last.ends().end,
            variation: f64::from(self.importance_of(&zones[first.zones.start..last.zones.end]).variation),
        };
        let number = Importance { variation: medium.variation as f32, limit }.number().min(MAX_POINTS_OF_RAY);
        let [[by_zone, kind, distance, choice], [u0, u1, u2, _]] =
            MEDIUM_PARTS.map(|part| scrambled_sobol::further_dimensions(sample.number, part, sample.seed));
        let mut k = 0;
        while medium.variation > 0.0 && by_zone + f64::from(k) < number {
            let further = |u: f64| (u + f64::from(k) * GOLDEN_SECTION).fract();
            let numbers = MediumNumbers {
                zone: (by_zone + f64::from(k)) / number,
                kind: further(kind),
                distance: further(distance),
                choice: further(choice),
                light: [u0, u1, u2].map(further),
            };
            points.extend(medium.lit_point(place, &numbers, number));
            k += 1;
        }
    }
}

/// The largest weight of the bands.
fn largest(z: &WeightedZone) -> f32 {
    z.weight.iter().fold(0.0, |m, w| m.max(*w))
}

/// The medium on the ray of a sample.
struct MediumOfRay<'a> {
    lights: &'a PointLights,
    sample: &'a SampledZones<'a>,
    /// Its zones among those collected, and the distances of its ends, m.
    zones: Range<usize>,
    distances: Range<f64>,
    /// Σ w r σ of the zones, W/m².
    variation: f64,
}

impl<'a> MediumOfRay<'a> {
    /// The share in the choice of zones of those of a range, each times a factor.
    fn share(&self, range: Range<usize>, factor: impl Fn(usize) -> f32) -> f64 {
        let of = |z: &WeightedZone| {
            let i = z.zone as usize;
            f64::from(largest(z) * self.lights.importance[i].variation * factor(i))
        };
        self.sample.collected.zones[range].iter().map(of).sum::<f64>() / self.variation
    }

    /// The piece and the zone at the share `u` of the choice.
    fn choose(&self, u: f64) -> Option<(&'a MediumPiece, usize)> {
        let CollectedZones { zones, pieces } = self.sample.collected;
        let of_piece = |piece: &'a MediumPiece| zones[piece.zones.clone()].iter().map(move |z| (piece, z));
        let weighted = pieces.iter().flat_map(of_piece).map(|(piece, z)| {
            let i = z.zone as usize;
            ((piece, i), f64::from(largest(z) * self.lights.importance[i].variation))
        });
        weighted_choice::choose(weighted, u * self.variation)
    }

    /// The light at one of `number` points.
    fn lit_point(&self, place: LightPlace, numbers: &MediumNumbers, number: f64) -> Option<PointChange> {
        let WeightedRay { origin, dir, .. } = *self.sample.ray;
        let (piece, zone) = self.choose(numbers.zone)?;
        let light = self.lights.choose(zone, numbers.choice)?;
        let angles = light.ball.map(|ball| AngleSampling::new(self.sample.ray, ball, &self.distances));
        let share_by_angle = if angles.is_some() { SHARE_BY_ANGLE } else { 0.0 };
        let distance = match &angles {
            Some(angles) if numbers.kind < SHARE_BY_ANGLE => angles.distance(numbers.distance),
            _ => piece.distance(numbers.distance),
        };
        let piece = piece_at(&self.sample.collected.pieces, distance)?;
        let of_light =
            |i: usize| ratio(f64::from(light.variation[i]), f64::from(self.lights.total[i])) as f32;
        let by_piece = self.share(piece.zones.clone(), of_light) * piece.density(distance);
        let by_angle = angles.map_or(0.0, |a| self.share(self.zones.clone(), of_light) * a.density(distance));
        let density = (1.0 - share_by_angle) * by_piece + share_by_angle * by_angle;
        let at = origin + dir * distance;
        let zone = match piece.zones.len() {
            1 => self.sample.collected.zones[piece.zones.start].zone,
            _ => self.sample.path.volume_zone(at)?,
        };
        let incident =
            place.lights.incident(place.transport, light.number, at, Receiver::Free, numbers.light);
        let weight = piece.weight_at(distance) / (number * density);
        Some(self.lights.lit_point(place, light, zone as usize, incident, weight))
    }
}

/// A point of zone `i` as a receiver of light.
fn receiver(zones: &Zones, i: usize) -> Receiver {
    zones.patches.get(i).map_or(Receiver::Free, |p| Receiver::Surface(p.normal))
}

/// σ of light `l` within zone `i`, of the band in which it is largest, W/m²: by a few points, and by its distance where it is at a place.
fn variation(place: LightPlace, l: usize, i: usize) -> f64 {
    let LightPlace { lights, transport, zones } = place;
    let mean = lights.direct().lights[l].fields[i];
    if !is_read(zones, i) || mean.max_element() <= 0.0 || zones.response(i).0 == Bands::ZERO {
        return 0.0;
    }
    let seed = low_discrepancy::split_mix64((i as u64) << 8 ^ l as u64 ^ VARIATION_SEED) as u32;
    let receiver = receiver(zones, i);
    let mut squares = Bands::ZERO;
    let count = POINTS_OF_ZONE[usize::from(i >= zones.patches.len())];
    for k in 0..count {
        let u = scrambled_sobol::point(k, seed);
        let at = point_in_zone(zones, transport, i, [u[0], u[1], u[2]]);
        let change = lights.incident(transport, l, at, receiver, [u[3], u[4], u[5]]) - mean;
        squares += change * change;
    }
    let of_points = (squares / count as f64).sqrt().max_element();
    let size = match zones.zone(i) {
        ZoneRef::Patch(p) => p.area.sqrt(),
        ZoneRef::Voxel(_, v) => v.volume.cbrt(),
        ZoneRef::Pane(..) => 0.0,
    };
    let by_distance = lights.samplers()[l].ball().map_or(0.0, |LightBall { centre, radius }| {
        let distance = (centre - zones.zone(i).centre()).length().hypot(radius);
        (size / distance).min(1.0)
    });
    of_points.max(by_distance.max(LEAST_VARIATION) * mean.max_element())
}

/// The piece that holds a distance.
fn piece_at(pieces: &[MediumPiece], distance: f64) -> Option<&MediumPiece> {
    let after = pieces.partition_point(|p| p.ends().start <= distance);
    pieces[..after].last().filter(|p| distance <= p.ends().end)
}

/// Points of a ray by the angle at which a ball sees them.
struct AngleSampling {
    /// s_c and b, m.
    centre: f64,
    breadth: f64,
    /// θ₁ and θ₂.
    angles: [f64; 2],
}

impl AngleSampling {
    fn new(ray: &WeightedRay, ball: LightBall, range: &Range<f64>) -> AngleSampling {
        let (WeightedRay { origin, dir, .. }, LightBall { centre, radius }) = (*ray, ball);
        let along = (centre - origin).dot(dir);
        let off = (centre - (origin + dir * along)).length2() + radius * radius;
        // A ray through a point light has no angle: a breadth far below the length of the ray stands for it.
        let breadth = off.sqrt().max(SMALLEST_BREADTH * (range.end - range.start));
        let angle = |s: f64| ((s - along) / breadth).atan();
        AngleSampling { centre: along, breadth, angles: [angle(range.start), angle(range.end)] }
    }

    fn distance(&self, u: f64) -> f64 {
        let [low, high] = self.angles;
        self.centre + self.breadth * (low + u * (high - low)).tan()
    }

    /// Density of the distance `s`, 1/m.
    fn density(&self, s: f64) -> f64 {
        let ([low, high], t) = (self.angles, s - self.centre);
        self.breadth / ((high - low) * (self.breadth * self.breadth + t * t))
    }
}
