//! Samples of an emitting surface: by area for light that leaves it, by solid angle for light that arrives at a point.
//!
//! A sample by area contributes cosθ_x/r², which is unbounded near the emitter. Sampled uniformly over the solid angle Ω of the
//! emitter, each sample contributes the same:
//!
//! ```text
//! H = ∫ L τ cosθ⁺ dω ≈ Ω ⟨L τ cosθ⟩      G = ∫ L τ dω ≈ Ω ⟨L τ⟩
//! ```
//!
//! Of at most [`MAX_FACETS_WITHOUT_TREE`] facets one is chosen by solid angle; of more facets a cluster of the light tree is chosen
//! first (`light_tree`), then one of its facets. `visible_polygon` samples the solid angle of the facet.

use super::light_tree::{self, LightBall, LightTree};
use super::receiver::Receiver;
use super::samples::EmissionSample;
use super::visible_polygon::{EmitterFacet, VisiblePolygon};
use crate::solid_angle::{projected_solid_angle, solid_angle};
use std::f64::consts::PI;
use std::ops::Range;
use zonal_math::Vec3;
use zonal_scene::{Bands, Scene, Sides};

/// Up to this number of facets one is chosen by the solid angles of all, and the unoccluded light has a closed form.
const MAX_FACETS_WITHOUT_TREE: usize = light_tree::MAX_LEAF_FACETS;
/// A cluster farther away than this multiple of its radius is sampled as seen from its centre.
const FAR_FIELD_RADII: f64 = 6.0;
/// A point nearer to the plane of a facet, as a fraction of the scene's diagonal, lies in it: the fraction of `Transport::epsilon`.
const IN_PLANE_SHARE_OF_DIAGONAL: f64 = 1e-9;

/// An emitting surface prepared for sampling.
#[derive(Clone, Debug)]
pub(crate) struct Emitter<'a> {
    scene: &'a Scene,
    facets: Vec<EmitterFacet>,
    /// The light tree over the facets, where there are many.
    tree: Option<LightTree>,
    /// Running sums of the facets' areas, m².
    cumulative_area: Vec<f64>,
    two_sided: bool,
    /// Radiance, W/(m² sr), where it is uniform over a surface of few facets.
    uniform_radiance: Option<Bands>,
    /// The largest flux that a point emits, W/m², band by band.
    max_emission: Bands,
    /// Points nearer to a facet's plane lie in it, m.
    plane_tolerance: f64,
}

/// A point of an emitter as sampled from a receiver.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EmitterPoint {
    /// Position, m.
    pub at: Vec3,
    /// L over the density of the point, W/m²: its contribution to G without attenuation.
    pub fluence: Bands,
}

/// A facet chosen by solid angle.
struct ChosenFacet {
    index: usize,
    polygon: VisiblePolygon,
    /// The number in [0, 1) that remains for a sample within the facet.
    s: f64,
    /// Solid angle of all facets of the choice over the probability of their cluster, sr.
    weight: f64,
}

/// An emitter as seen from one point. The visible parts of its facets, or of those of the cluster of the last sample, are kept: the samples are those of
/// [`Emitter::sample_solid_angle`].
pub(crate) struct EmitterView<'e> {
    emitter: &'e Emitter<'e>,
    p: Vec3,
    receiver: Receiver,
    /// The facets whose visible parts are kept, those parts, and the running sums of their solid angles, sr.
    facets: Range<usize>,
    polygons: Vec<Option<VisiblePolygon>>,
    sums: Vec<f64>,
}

impl EmitterView<'_> {
    /// The point at `s` ∈ [0,1)³, by solid angle; `None` where no part of the emitter, or of the chosen cluster, is visible.
    pub(crate) fn sample(&mut self, s: [f64; 3]) -> Option<EmitterPoint> {
        let (facets, probability) = match &self.emitter.tree {
            None => (0..self.emitter.facets.len(), 1.0),
            Some(tree) => {
                let leaf = tree.sample(self.p, self.receiver, s[2])?;
                (leaf.facets, leaf.probability)
            }
        };
        self.keep(facets);
        let (k, rest) = match self.sums.as_slice() {
            [_] => (0, s[0]),
            sums => choose_cumulative(sums, s[0])?,
        };
        let polygon = self.polygons[k].as_ref()?;
        let weight = self.sums[self.sums.len() - 1] / probability;
        self.emitter.point_on(self.facets.start + k, polygon, [rest, s[1]], weight)
    }

    /// Finds the visible parts of these facets, unless they are known.
    fn keep(&mut self, facets: Range<usize>) {
        if self.facets == facets {
            return;
        }
        let part = |k: usize| self.emitter.visible_polygon(k, self.p, self.receiver);
        self.polygons.clear();
        self.polygons.extend(facets.clone().map(part));
        let mut total = 0.0;
        self.sums.clear();
        self.sums.extend(self.polygons.iter().map(|part| {
            total += part.as_ref().map_or(0.0, |part| part.solid_angle);
            total
        }));
        self.facets = facets;
    }
}

impl<'a> Emitter<'a> {
    /// Prepares the facets of `surface`.
    pub(crate) fn new(scene: &'a Scene, surface: usize) -> Emitter<'a> {
        let of_surface = |(_, f): &(usize, &zonal_scene::Facet)| f.surface == surface;
        let prepared = |(id, f): (usize, &zonal_scene::Facet)| EmitterFacet::new(id, f.plate);
        let mut facets: Vec<EmitterFacet> =
            scene.facets().iter().enumerate().filter(of_surface).map(prepared).collect();
        let tree = (facets.len() > MAX_FACETS_WITHOUT_TREE).then(|| LightTree::new(&mut facets, |f| f.plate));
        let mut sum = 0.0;
        let add = |f: &EmitterFacet| {
            sum += f.plate.area();
            sum
        };
        let cumulative_area = facets.iter().map(add).collect();
        let material = &scene.surfaces()[surface];
        // Without texture a facet emits the same flux everywhere; faces of tables of values have fluxes of their own.
        let untextured = material.emission_texture.is_none();
        let of_facet = |f: &EmitterFacet| scene.emission_at(f.id, 1.0 / 3.0, 1.0 / 3.0);
        let is_alike = untextured && facets.iter().all(|f| of_facet(f) == material.emission);
        let uniform = facets.len() <= MAX_FACETS_WITHOUT_TREE && is_alike;
        let max_emission = match material.emission_texture {
            None => facets.iter().map(of_facet).fold(material.emission, Bands::max),
            Some(t) => material.emission * scene.textures()[t].upper_bound(),
        };
        Emitter {
            scene,
            facets,
            tree,
            cumulative_area,
            max_emission,
            two_sided: material.sides == Sides::Both,
            uniform_radiance: uniform.then(|| material.emission.map(|e| e / PI)),
            plane_tolerance: IN_PLANE_SHARE_OF_DIAGONAL * scene.diagonal(),
        }
    }

    /// True when [`Emitter::unoccluded`] has a closed form.
    pub(crate) fn is_uniform(&self) -> bool {
        self.uniform_radiance.is_some()
    }

    /// Index in `self.facets` of the facet at the fraction `s` ∈ [0,1) of the area.
    fn facet_at_area(&self, s: f64) -> Option<usize> {
        let total = *self.cumulative_area.last()?;
        let k = self.cumulative_area.partition_point(|&a| a <= s * total);
        Some(k.min(self.facets.len() - 1))
    }

    /// The point at `s` ∈ [0,1)³, uniform over the area; `None` without facets.
    pub(crate) fn sample_area(&self, s: [f64; 3]) -> Option<EmissionSample<'static>> {
        let (total, k) = (*self.cumulative_area.last()?, self.facet_at_area(s[2])?);
        let facet = &self.facets[k];
        let [u, v] = facet.plate.warp([s[0], s[1]]);
        Some(EmissionSample::Point {
            position: facet.plate.at(u, v),
            normal: facet.normal(),
            two_sided: self.two_sided,
            facet: Some(facet.id),
            power: self.scene.emission_at(facet.id, u, v) * total / PI,
        })
    }

    /// True where a facet emits towards a point at `height` in front of its plane.
    fn emits_towards(&self, height: f64) -> bool {
        height > self.plane_tolerance || (self.two_sided && height < -self.plane_tolerance)
    }

    /// The part of facet number `k` that emits towards a receiver at `p`.
    #[inline(always)]
    fn visible_polygon(&self, k: usize, p: Vec3, receiver: Receiver) -> Option<VisiblePolygon> {
        let facet = &self.facets[k];
        let from = facet.local(p - facet.plate.origin);
        if self.emits_towards(from.z) { VisiblePolygon::new(facet, from, receiver) } else { None }
    }

    /// The point at `s` ∈ [0,1)³, by solid angle from `p`; `None` where no part of the emitter, or of the chosen cluster, is visible.
    pub(crate) fn sample_solid_angle(
        &self,
        p: Vec3,
        receiver: Receiver,
        s: [f64; 3],
    ) -> Option<EmitterPoint> {
        let chosen = match self.facets.len() {
            1 => {
                let polygon = self.visible_polygon(0, p, receiver)?;
                let weight = polygon.solid_angle;
                ChosenFacet { index: 0, polygon, s: s[0], weight }
            }
            n => match &self.tree {
                None => self.choose_by_solid_angle(0..n, p, receiver, s[0])?,
                Some(tree) => {
                    let leaf = tree.sample(p, receiver, s[2])?;
                    let chosen = self.choose_by_solid_angle(leaf.facets, p, receiver, s[0])?;
                    ChosenFacet { weight: chosen.weight / leaf.probability, ..chosen }
                }
            },
        };
        self.point_on(chosen.index, &chosen.polygon, [chosen.s, s[1]], chosen.weight)
    }

    /// The emitter as seen from `p`, for several samples.
    pub(crate) fn view(&self, p: Vec3, receiver: Receiver) -> EmitterView<'_> {
        EmitterView { emitter: self, p, receiver, facets: 0..0, polygons: Vec::new(), sums: Vec::new() }
    }

    /// The point at `s` ∈ [0,1)² of the visible part of a facet; `weight` is its solid angle over the probability of the facet, sr.
    fn point_on(
        &self,
        index: usize,
        visible: &VisiblePolygon,
        s: [f64; 2],
        weight: f64,
    ) -> Option<EmitterPoint> {
        let facet = &self.facets[index];
        let [u, v] = facet.clamped_uv(visible.sample(s)?);
        let radiance = self.uniform_radiance.unwrap_or_else(|| self.scene.emission_at(facet.id, u, v) / PI);
        Some(EmitterPoint { at: facet.plate.at(u, v), fluence: radiance * weight })
    }

    /// The facet of a range at the fraction `s` ∈ [0,1) of their solid angle.
    fn choose_by_solid_angle(
        &self,
        facets: Range<usize>,
        p: Vec3,
        receiver: Receiver,
        s: f64,
    ) -> Option<ChosenFacet> {
        let mut sums = [0.0; MAX_FACETS_WITHOUT_TREE];
        let mut total = 0.0;
        for (sum, k) in sums.iter_mut().zip(facets.clone()) {
            total += self.visible_polygon(k, p, receiver).map_or(0.0, |f| f.solid_angle);
            *sum = total;
        }
        let (k, s) = choose_cumulative(&sums[..facets.len()], s)?;
        let index = facets.start + k;
        Some(ChosenFacet { index, polygon: self.visible_polygon(index, p, receiver)?, s, weight: total })
    }

    /// Estimate of H or G without occlusion, W/m², of a surface of many facets; zero of few.
    pub(crate) fn estimate_unoccluded(&self, p: Vec3, receiver: Receiver) -> Bands {
        let (Some(tree), Some(first)) = (&self.tree, self.facets.first()) else {
            return Bands::ZERO;
        };
        let material = &self.scene.surfaces()[self.scene.facets()[first.id].surface];
        let seen = tree.estimate(p, receiver) / PI;
        material.emission * seen
    }

    /// An upper bound of H or G without occlusion, W/m², at any point of the convex hull of `corners`, which lies in the plane of the receiver: zero where no facet
    /// emits towards it.
    pub(crate) fn upper_bound(&self, corners: &[Vec3], receiver: Receiver) -> Bands {
        let Some(first) = corners.first() else { return Bands::ZERO };
        let ahead = |c: Vec3| match receiver {
            Receiver::Free => f64::INFINITY,
            Receiver::Surface(n) => n.dot(c - *first),
        };
        let may_light = |f: &EmitterFacet| {
            let (own, n) = f.plate.corners();
            let emits = |x: &Vec3| self.emits_towards((*x - f.plate.origin).dot(f.normal()));
            own[..n].iter().any(|c| ahead(*c) > self.plane_tolerance) && corners.iter().any(emits)
        };
        let lights = match &self.tree {
            None => self.facets.iter().any(may_light),
            Some(tree) => {
                tree.any_facet(|c, r| ahead(c) + r > 0.0, |range| self.facets[range].iter().any(may_light))
            }
        };
        if !lights {
            return Bands::ZERO;
        }
        // The flux of one side of a plane of this emission, or that of both, unless the facets are too far and too small for that.
        let most: f64 = if matches!(receiver, Receiver::Free) { 4.0 } else { 1.0 };
        let centre = corners.iter().fold(Vec3::ZERO, |sum, c| sum + *c) / corners.len() as f64;
        let radius = corners.iter().fold(0.0f64, |m, c| m.max((*c - centre).length()));
        let ball = LightBall { centre, radius };
        let seen = match &self.tree {
            Some(tree) => tree.solid_angle_bound(&ball),
            None => {
                let of_facet = |f: &EmitterFacet| {
                    let own = LightBall { centre: f.plate.centre(), radius: f.plate.diameter() };
                    own.solid_angle_bound(f.plate.area(), &ball)
                };
                self.facets.iter().map(of_facet).sum()
            }
        };
        self.max_emission * most.min(seen / PI)
    }

    /// True where the facets are many and form clusters.
    pub(crate) fn is_clustered(&self) -> bool {
        self.tree.is_some()
    }

    /// Centre, m, and radius, m, of each cluster; none where facets are few.
    pub(crate) fn clusters(&self) -> Vec<(Vec3, f64)> {
        let tree = self.tree.iter();
        tree.flat_map(|t| (0..t.len()).map(|k| t.leaf(k))).map(|(c, r, _)| (c, r)).collect()
    }

    /// A ball about all facets; `None` without facets.
    pub(crate) fn ball(&self) -> Option<LightBall> {
        let first = self.facets.first()?.plate.centre();
        let (lo, hi) = self.facets.iter().fold((first, first), |(lo, hi), f| {
            let centre = f.plate.centre();
            (lo.min(centre), hi.max(centre))
        });
        let centre = (lo + hi) * 0.5;
        let reach = |f: &EmitterFacet| (f.plate.centre() - centre).length() + 0.5 * f.plate.diameter();
        Some(LightBall { centre, radius: self.facets.iter().map(reach).fold(0.0, f64::max) })
    }

    /// Projected area of a facet in the unit direction `dir` from it, m².
    fn projected_area(&self, f: &EmitterFacet, dir: Vec3) -> f64 {
        let slope = dir.dot(f.normal());
        (if self.two_sided { slope.abs() } else { slope.max(0.0) }) * f.plate.area()
    }

    /// G r² of cluster number `k`, W/m² · m², far away in the unit direction `dir` from it.
    pub(crate) fn cluster_intensity(&self, k: usize, dir: Vec3) -> Bands {
        let Some(tree) = &self.tree else {
            return Bands::ZERO;
        };
        let mut sum = Bands::ZERO;
        for f in &self.facets[tree.leaf(k).2] {
            let seen = self.projected_area(f, dir) / PI;
            if seen > 0.0 {
                let flux = self.scene.emission_at(f.id, 1.0 / 3.0, 1.0 / 3.0);
                sum += flux * seen;
            }
        }
        sum
    }

    /// A point at `s` ∈ [0,1)³ with the contribution of its cluster as seen from the cluster's centre, and the distance of the
    /// centre, m: facets by projected area, points by area. `None` for few facets, and for a cluster within [`FAR_FIELD_RADII`].
    pub(crate) fn sample_far_cluster(
        &self,
        p: Vec3,
        receiver: Receiver,
        s: [f64; 3],
    ) -> Option<(EmitterPoint, f64)> {
        let leaf = self.tree.as_ref()?.sample(p, receiver, s[2])?;
        let (offset, radius) = (p - leaf.ball.centre, leaf.ball.radius);
        let r = offset.length();
        if r < FAR_FIELD_RADII * radius {
            return None;
        }
        let (dir, facets) = (offset / r, &self.facets[leaf.facets.clone()]);
        let (mut sums, mut total) = ([0.0; MAX_FACETS_WITHOUT_TREE], 0.0);
        for (sum, f) in sums.iter_mut().zip(facets) {
            total += self.projected_area(f, dir);
            *sum = total;
        }
        let (k, rest) = choose_cumulative(&sums[..facets.len()], s[0])?;
        let facet = &facets[k];
        let [u, v] = facet.plate.warp([rest, s[1]]);
        let weight = total / (PI * r * r * leaf.probability);
        let fluence = self.scene.emission_at(facet.id, u, v) * weight;
        Some((EmitterPoint { at: facet.plate.at(u, v), fluence }, r))
    }

    /// H or G without occlusion, W/m², in closed form; zero unless [`Emitter::is_uniform`].
    pub(crate) fn unoccluded(&self, p: Vec3, receiver: Receiver) -> Bands {
        let Some(radiance) = self.uniform_radiance else {
            return Bands::ZERO;
        };
        let height = |f: &EmitterFacet| (p - f.plate.origin).dot(f.normal());
        let visible = self.facets.iter().filter(|f| self.emits_towards(height(f)));
        let sum: f64 = match receiver {
            Receiver::Free => visible.map(|f| solid_angle(&f.plate, p).abs()).sum(),
            Receiver::Surface(n) => visible.map(|f| projected_solid_angle(&f.plate, p, n)).sum(),
        };
        radiance * sum
    }
}

/// The part at the fraction `s` ∈ [0,1) of the total, given the running sums of the parts, and the fraction within the part.
fn choose_cumulative(sums: &[f64], s: f64) -> Option<(usize, f64)> {
    let at = s * sums.last()?;
    let k = sums.partition_point(|&x| x <= at);
    let before = if k > 0 { sums[k - 1] } else { 0.0 };
    Some((k, (at - before) / (sums.get(k)? - before)))
}

#[cfg(test)]
mod tests;
