//! Points of a shining surface: by area for light that leaves it, by solid angle for light that arrives at a point.
//!
//! Drawn by area, a point of a lamp contributes cosθ_x/r², without bound beside the lamp. Drawn uniformly over the solid angle Ω under
//! which the lamp is seen, each contributes the same:
//!
//! ```text
//! H = ∫ L τ cosθ⁺ dω ≈ Ω ⟨L τ cosθ⟩      G = ∫ L τ dω ≈ Ω ⟨L τ⟩
//! ```
//!
//! A facet is cut to the front of the receiver. With q the foot of the receiver's point p on the facet's plane, the rest is split into
//! triangles that fan out from its point b nearest to q: from p no point of the polygon is then more than 90° from b, and every triangle
//! is well conditioned however near p is to the plane. In a spherical triangle with corners a, b, c (unit vectors) let w run along the
//! side ac. Of the solid angle of abw (van Oosterom and Strackee 1983) there remains, with o = a + w up to length,
//!
//! ```text
//! tan(ω/2) = det(a, b, o) / ((a + b)·o),   linear in o = x a + y c:
//! x = D cos(ω/2) − (a + b)·c sin(ω/2)      y = (1 + a·b) sin(ω/2)      D = det(a, b, c)
//! ```
//!
//! so that the share of the solid angle up to w gives w, and a point on the arc from b to w, 1 − cos uniform, is uniform over the
//! triangle (Arvo 1995; this form of it after Peters 2021). The map from the unit square onto the whole fan is continuous and keeps
//! areas: evenly spread numbers give evenly spread directions.

use crate::cluster::{self, Tree};
use crate::direct::{Receiver, Source};
use crate::solid_angle::{in_front, projected_solid_angle, solid_angle};
use std::f64::consts::PI;
use std::ops::Range;
use zonal_math::directions::turn;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Plate, PlateKind, Scene, Sides, bands};

/// Facets are chosen by the solid angles of all of them, and the light without obstacles is had in closed form, up to so many. Of more,
/// a cluster is chosen first (`cluster`), then one of its facets by solid angle.
const FEW: usize = cluster::LEAF;
/// A cluster farther away than so many of its radii looks small.
const FAR: f64 = 6.0;
/// A point nearer to the plane of a facet, over the scene's diagonal, lies in it: that of `Transport::epsilon`.
const IN_PLANE: f64 = 1e-9;
/// A triangle of a smaller determinant is so far away, or so thin, that rounding shows: its points are drawn by area. What it adds to
/// H or G is then too little to matter if it is thin, and right if it is far away.
const THIN: f64 = 1e-9;
/// Points keep this far from the borders of a facet, over its sides: off a wall that stands on it, and no farther, or those seen from
/// close above a border would move.
const RIM: f64 = 1e-9;
/// The most corners of a facet that is cut, and one.
const CORNERS: usize = 6;

/// A shining surface made ready to be sampled.
#[derive(Clone, Debug)]
pub(crate) struct Emitter<'a> {
    scene: &'a Scene,
    facets: Vec<Facet>,
    /// Their clusters, where there are many.
    tree: Option<Tree>,
    /// Their areas, summed up, m².
    cumulative: Vec<f64>,
    both: bool,
    /// Radiance, W/(m² sr), where it is the same all over a surface of few facets.
    even: Option<Bands>,
    /// Points nearer to a facet's plane lie in it, m.
    plane: f64,
}

/// A facet of an emitter, in axes of its own: the first two in its plane, the third its normal, the origin that of the plate.
#[derive(Clone, Copy, Debug)]
struct Facet {
    id: usize,
    plate: Plate,
    axes: [Vec3; 3],
    corners: [Vec3; 4],
    count: usize,
    /// u and v of a point (x, y) of its plane.
    parameters: [[f64; 2]; 2],
}

impl Facet {
    fn new(id: usize, plate: Plate) -> Facet {
        let normal = plate.normal();
        let (t, b) = normal.frame();
        let axes = [t, b, normal];
        let own = |x: Vec3| vec3(x.dot(t), x.dot(b), 0.0);
        let (corners, count) = plate.corners();
        let (e, f) = (own(plate.e1), own(plate.e2));
        let det = e.x * f.y - e.y * f.x;
        let parameters = [[f.y / det, -f.x / det], [-e.y / det, e.x / det]];
        Facet { id, plate, axes, corners: corners.map(|c| own(c - plate.origin)), count, parameters }
    }

    /// A vector in the facet's axes.
    fn own(&self, x: Vec3) -> Vec3 {
        let [t, b, n] = self.axes;
        vec3(x.dot(t), x.dot(b), x.dot(n))
    }

    /// (u, v) of a point given in the facet's axes, moved into the plate and off its borders.
    fn inside(&self, at: Vec3) -> [f64; 2] {
        let [u, v] = self.parameters.map(|[x, y]| (x * at.x + y * at.y).clamp(RIM, 1.0 - RIM));
        let over = (u + v) / (1.0 - RIM);
        match self.plate.kind {
            PlateKind::Triangle if over > 1.0 => [u / over, v / over],
            _ => [u, v],
        }
    }
}

/// A point of an emitter as a receiver sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    /// Position, m.
    pub at: Vec3,
    /// L over the density of the point, W/m²: what it adds to G where nothing lies between.
    pub fluence: Bands,
}

impl<'a> Emitter<'a> {
    /// Prepares the facets of `surface`.
    pub(crate) fn new(scene: &'a Scene, surface: usize) -> Emitter<'a> {
        let own = |(_, f): &(usize, &zonal_scene::Facet)| f.surface == surface;
        let ready = |(id, f): (usize, &zonal_scene::Facet)| Facet::new(id, f.plate);
        let mut facets: Vec<Facet> = scene.facets().iter().enumerate().filter(own).map(ready).collect();
        let tree = (facets.len() > FEW).then(|| Tree::new(&mut facets, |f| f.plate));
        let mut sum = 0.0;
        let add = |f: &Facet| {
            sum += f.plate.area();
            sum
        };
        let cumulative = facets.iter().map(add).collect();
        let own = &scene.surfaces()[surface];
        let even =
            (facets.len() <= FEW && own.emission_texture.is_none()).then(|| own.emission.map(|e| e / PI));
        let plane = IN_PLANE * scene.diagonal();
        Emitter { scene, facets, tree, cumulative, both: own.sides == Sides::Both, even, plane }
    }

    /// True when [`Emitter::unhindered`] knows its light.
    pub(crate) fn is_even(&self) -> bool {
        self.even.is_some()
    }

    /// Number in `self.facets` of the facet that holds the share `s` ∈ [0,1) of the area.
    fn by_area(&self, s: f64) -> Option<usize> {
        let total = *self.cumulative.last()?;
        let k = self.cumulative.partition_point(|&a| a <= s * total);
        Some(k.min(self.facets.len() - 1))
    }

    /// The point at `s` ∈ [0,1)³, uniform over the area; `None` without facets.
    pub(crate) fn point(&self, s: [f64; 3]) -> Option<Source> {
        let (total, k) = (*self.cumulative.last()?, self.by_area(s[2])?);
        let Facet { id, plate, axes, .. } = self.facets[k];
        let [u, v] = plate.warp([s[0], s[1]]);
        Some(Source::Point {
            at: plate.at(u, v),
            normal: axes[2],
            both: self.both,
            facet: id,
            power: self.scene.emission_at(id, u, v).map(|e| e * total / PI),
        })
    }

    /// True where a facet shines at a point `height` before its plane.
    fn shines(&self, height: f64) -> bool {
        height > self.plane || (self.both && height < -self.plane)
    }

    /// What of facet number `k` shines on a receiver at `p`.
    #[inline(always)]
    fn fan(&self, k: usize, p: Vec3, receiver: Receiver) -> Option<Fan> {
        let facet = &self.facets[k];
        let from = facet.own(p - facet.plate.origin);
        if self.shines(from.z) { Fan::new(facet, from, receiver) } else { None }
    }

    /// The point at `s` ∈ [0,1)³, by solid angle from `p`; `None` where nothing of the emitter, or of a cluster chosen, is seen.
    pub(crate) fn spot(&self, p: Vec3, receiver: Receiver, s: [f64; 3]) -> Option<Spot> {
        let (k, fan, share, weight) = match self.facets.len() {
            1 => {
                let fan = self.fan(0, p, receiver)?;
                let weight = fan.total;
                (0, fan, s[0], weight)
            }
            n => match &self.tree {
                None => self.by_solid_angle(0..n, p, receiver, s[0])?,
                Some(tree) => {
                    let leaf = tree.descend(p, receiver, s[2])?;
                    let (k, fan, share, weight) = self.by_solid_angle(leaf.facets, p, receiver, s[0])?;
                    (k, fan, share, weight / leaf.chance)
                }
            },
        };
        let facet = &self.facets[k];
        let [u, v] = facet.inside(fan.at([share, s[1]])?);
        let radiance = self.even.unwrap_or_else(|| self.scene.emission_at(facet.id, u, v).map(|e| e / PI));
        Some(Spot { at: facet.plate.at(u, v), fluence: radiance.map(|l| l * weight) })
    }

    /// Of some facets the one that holds the share `s` ∈ [0,1) of their solid angle, where in it, and that solid angle, sr.
    fn by_solid_angle(
        &self,
        among: Range<usize>,
        p: Vec3,
        receiver: Receiver,
        s: f64,
    ) -> Option<(usize, Fan, f64, f64)> {
        let mut sums = [0.0; FEW];
        let mut total = 0.0;
        for (sum, k) in sums.iter_mut().zip(among.clone()) {
            total += self.fan(k, p, receiver).map_or(0.0, |f| f.total);
            *sum = total;
        }
        let (k, share) = chosen(&sums[..among.len()], s)?;
        let facet = among.start + k;
        Some((facet, self.fan(facet, p, receiver)?, share, total))
    }

    /// About H or G with nothing between, W/m², of a surface of many facets; zero of few.
    pub(crate) fn estimate(&self, p: Vec3, receiver: Receiver) -> Bands {
        let (Some(tree), Some(first)) = (&self.tree, self.facets.first()) else {
            return [0.0; 3];
        };
        let own = &self.scene.surfaces()[self.scene.facets()[first.id].surface];
        let seen = tree.estimate(p, receiver) / PI;
        own.emission.map(|e| e * seen)
    }

    /// True where facets are many, and in clusters.
    pub(crate) fn is_crowd(&self) -> bool {
        self.tree.is_some()
    }

    /// Centre, m, and radius, m, of each cluster; none where facets are few.
    pub(crate) fn clusters(&self) -> Vec<(Vec3, f64)> {
        let tree = self.tree.iter();
        tree.flat_map(|t| (0..t.len()).map(|k| t.leaf(k))).map(|(c, r, _)| (c, r)).collect()
    }

    /// The area that a facet shows far away in the unit direction `dir`, m².
    fn shown(&self, f: &Facet, dir: Vec3) -> f64 {
        let slope = dir.dot(f.axes[2]);
        (if self.both { slope.abs() } else { slope.max(0.0) }) * f.plate.area()
    }

    /// G r² of cluster number `k`, W/m² · m², far away in the unit direction `dir` from it.
    pub(crate) fn intensity(&self, k: usize, dir: Vec3) -> Bands {
        let Some(tree) = &self.tree else {
            return [0.0; 3];
        };
        let mut sum = [0.0; 3];
        for f in &self.facets[tree.leaf(k).2] {
            let seen = self.shown(f, dir) / PI;
            if seen > 0.0 {
                let flux = self.scene.emission_at(f.id, 1.0 / 3.0, 1.0 / 3.0);
                sum = bands(|b| sum[b] + flux[b] * seen);
            }
        }
        sum
    }

    /// A point at `s` ∈ [0,1)³ that brings what its cluster would bring from its middle, and the distance of this, m: facets by the area that
    /// they show, points by area. `None` of few facets, and of a cluster that does not look small.
    pub(crate) fn far_spot(&self, p: Vec3, receiver: Receiver, s: [f64; 3]) -> Option<(Spot, f64)> {
        let leaf = self.tree.as_ref()?.descend(p, receiver, s[2])?;
        let (way, radius) = (p - leaf.ball.0, leaf.ball.1);
        let r = way.length();
        if r < FAR * radius {
            return None;
        }
        let (dir, facets) = (way / r, &self.facets[leaf.facets.clone()]);
        let (mut sums, mut total) = ([0.0; FEW], 0.0);
        for (sum, f) in sums.iter_mut().zip(facets) {
            total += self.shown(f, dir);
            *sum = total;
        }
        let (k, share) = chosen(&sums[..facets.len()], s[0])?;
        let facet = &facets[k];
        let [u, v] = facet.plate.warp([share, s[1]]);
        let weight = total / (PI * r * r * leaf.chance);
        let fluence = self.scene.emission_at(facet.id, u, v).map(|e| e * weight);
        Some((Spot { at: facet.plate.at(u, v), fluence }, r))
    }

    /// H or G with nothing between, W/m², in closed form; zero unless [`Emitter::is_even`].
    pub(crate) fn unhindered(&self, p: Vec3, receiver: Receiver) -> Bands {
        let Some(radiance) = self.even else {
            return [0.0; 3];
        };
        let seen = self.facets.iter().filter(|f| self.shines((p - f.plate.origin).dot(f.axes[2])));
        let sum: f64 = match receiver {
            Receiver::Free => seen.map(|f| solid_angle(&f.plate, p).abs()).sum(),
            Receiver::Surface(n) => seen.map(|f| projected_solid_angle(&f.plate, p, n)).sum(),
        };
        bands(|b| radiance[b] * sum)
    }
}

/// Of parts whose sums from the first on these are, the one that holds the share `s` ∈ [0,1) of all, and where in it.
fn chosen(sums: &[f64], s: f64) -> Option<(usize, f64)> {
    let at = s * sums.last()?;
    let k = sums.partition_point(|&x| x <= at);
    let before = if k > 0 { sums[k - 1] } else { 0.0 };
    Some((k, (at - before) / (sums.get(k)? - before)))
}

/// What a point sees of a facet: a polygon, split into triangles about the point of it that is nearest to the foot. In the facet's
/// axes; all vectors but `from` start at the point.
struct Fan {
    /// The point, from the facet's origin.
    from: Vec3,
    hub: Vec3,
    rim: [Vec3; CORNERS],
    count: usize,
    /// For the triangle of hub and rim k, k + 1: a complex number whose argument is half its solid angle.
    half: [[f64; 2]; CORNERS],
    /// Solid angle of all, sr.
    total: f64,
}

impl Fan {
    /// `None` where nothing of the facet is in front of the receiver `from` its origin.
    #[inline(always)]
    fn new(facet: &Facet, from: Vec3, receiver: Receiver) -> Option<Fan> {
        let mut rim = [Vec3::ZERO; CORNERS];
        let mut count = facet.count;
        (0..count).for_each(|k| rim[k] = facet.corners[k] - from);
        if let Receiver::Surface(front) = receiver {
            (rim, count) = in_front(&rim[..count], facet.own(front));
        }
        if count < 3 {
            return None;
        }
        let hub = nearest(&rim[..count], -from.z);
        let near = hub.length();
        let (mut half, mut product) = ([[1.0, 0.0]; CORNERS], [1.0, 0.0]);
        let (mut a, mut la) = (rim[0], rim[0].length());
        for k in 0..count {
            let c = rim[if k + 1 < count { k + 1 } else { 0 }];
            let lc = c.length();
            // Twice the area times the height: no cancellation however thin the triangle looks.
            let det = (cross(a - hub, c - hub) * from.z.abs()).max(0.0);
            half[k] = [la * near * lc + a.dot(hub) * lc + a.dot(c) * near + hub.dot(c) * la, det];
            let scale = 1.0 / (la * near * lc);
            product = times(product, half[k].map(|x| x * scale));
            (a, la) = (c, lc);
        }
        // At most π: a hair above it is rounding.
        let total = 2.0 * product[1].abs().atan2(product[0]);
        (total > 0.0).then_some(Fan { from, hub, rim, count, half, total })
    }

    /// The point of the facet's plane at `s` ∈ [0,1)², uniform in solid angle, from the facet's origin.
    #[inline(always)]
    fn at(&self, s: [f64; 2]) -> Option<Vec3> {
        let (sin, cos) = turn(s[0] * self.total / (4.0 * PI));
        // Turned back by one triangle after the other.
        let (mut left, mut found) = ([cos, sin], None);
        for (k, &[x, y]) in self.half[..self.count].iter().enumerate().filter(|h| h.1[1] > 0.0) {
            found = Some((k, left));
            let back = times(left, [x, -y]);
            if back[1] < 0.0 {
                break;
            }
            let scale = 1.0 / (x * x + y * y).sqrt();
            left = back.map(|b| b * scale);
        }
        let (k, left) = found?;
        let (a, c) = (self.rim[k], self.rim[if k + 1 < self.count { k + 1 } else { 0 }]);
        let (la, lb, lc) = (a.length(), self.hub.length(), c.length());
        let det = self.half[k][1] / (la * lb * lc);
        if det < THIN {
            // Uniform over the area: the root brings the corner at the hub its due.
            let along = (left[1] * self.half[k][0] / self.half[k][1]).clamp(0.0, 1.0);
            return Some(self.from + self.hub + (a + (c - a) * along - self.hub) * s[1].sqrt());
        }
        let direction = on_triangle([a / la, self.hub / lb, c / lc], det, left, s[1]);
        let reach = -self.from.z / direction.z;
        reach.is_finite().then(|| self.from + direction * reach)
    }
}

/// Product of two complex numbers.
#[inline(always)]
fn times([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}

/// The third component of a × b.
#[inline(always)]
fn cross(a: Vec3, b: Vec3) -> f64 {
    a.x * b.y - a.y * b.x
}

/// The unit vector in the spherical triangle abc of determinant `det` that leaves a solid angle between itself, ab and the arc from b
/// through it, and the share `s` of this arc's 1 − cos before it; of half that solid angle, cosine and sine. No corner is more than 90°
/// from b.
#[inline(always)]
fn on_triangle([a, b, c]: [Vec3; 3], det: f64, [cos, sin]: [f64; 2], s: f64) -> Vec3 {
    let o = a * (det * cos - (a + b).dot(c) * sin) + c * ((1.0 + a.dot(b)) * sin);
    let w = o * (2.0 * a.dot(o) / o.length2()) - a;
    // 1 − cos of the whole arc, from the chord: no cancellation where it is short.
    let chord = w - b;
    let whole = 0.5 * chord.length2();
    let part = s * whole;
    let along = (s * (2.0 - part) / (2.0 - whole)).sqrt();
    b * (1.0 - part) + (chord + b * whole) * along
}

/// The point nearest to the foot (0, 0, z) of a convex polygon in the plane of height `z`, its corners counter-clockwise.
#[inline(always)]
fn nearest(corners: &[Vec3], z: f64) -> Vec3 {
    let foot = vec3(0.0, 0.0, z);
    let (mut best, mut least) = (foot, f64::INFINITY);
    for (k, &a) in corners.iter().enumerate() {
        let edge = corners[if k + 1 < corners.len() { k + 1 } else { 0 }] - a;
        if cross(a, edge) < 0.0 {
            let t = ((foot - a).dot(edge) / edge.length2()).clamp(0.0, 1.0);
            let at = a + edge * t;
            let d2 = (foot - at).length2();
            if d2 < least {
                (best, least) = (at, d2);
            }
        }
    }
    best
}

#[cfg(test)]
mod tests;
