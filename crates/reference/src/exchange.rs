//! g_ij = F_ij/(c_i c_j) of two bodies, c = κ for volumes and panes and 1 for patches, by random samples.
//!
//! **By rays**: origins and directions of the density of body a's kernel (cosine on a patch, uniform in a volume, |cosine| times
//! (1 − e^{−κt/c})/κ on a pane); the score on b is τ (patch), ∫ τ ds inside (volume), τ (1 − e^{−κt/c})/κ (pane). Bounded, so touching
//! and overlapping bodies are as good as others.
//!
//! **By points**: the definition itself, (1/π) ∬ τ V cosθ_a cosθ_b/r². For bodies that are apart.

use crate::{Dice, Estimate, Tally, World, world};
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::{Bands, Plate, Scene, Zones};

/// A body that exchanges.
#[derive(Clone, Debug)]
pub enum Body {
    /// The front of a plate.
    Patch(Plate),
    /// A box, cut to the half-spaces n·x ≥ c.
    Volume {
        /// Lower corner, m.
        lo: Vec3,
        /// Upper corner, m.
        hi: Vec3,
        /// Half-spaces (n, c).
        planes: Vec<(Vec3, f64)>,
    },
    /// A pane.
    Pane {
        /// Its middle.
        plate: Plate,
        /// Thickness, m.
        thickness: f64,
        /// Extinction, 1/m.
        extinction: Bands,
    },
}

/// (1 − e^{−κt/c})/κ.
fn share(extinction: Bands, path: f64) -> Bands {
    extinction.map(|k| if k * path < 1e-9 { path } else { (1.0 - (-k * path).exp()) / k })
}

fn admits(planes: &[(Vec3, f64)], x: Vec3) -> bool {
    planes.iter().all(|(n, c)| n.dot(x) >= *c)
}

impl Body {
    /// A whole box.
    pub fn cuboid(lo: Vec3, hi: Vec3) -> Body {
        Body::Volume { lo, hi, planes: Vec::new() }
    }

    /// The body of a zone; of a cut voxel, the whole cell.
    pub fn of(scene: &Scene, zones: &Zones, i: usize) -> Body {
        if i < zones.voxel_offset() {
            return Body::Patch(zones.patches[i].plate);
        }
        if i < zones.pane_offset() {
            let map = scene.voxmap().expect("voxel zones come from a voxmap");
            let lo = map.corner(map.coordinates(zones.voxels[i - zones.voxel_offset()].cell));
            return Body::cuboid(lo, lo + map.cell());
        }
        let p = &zones.panes[i - zones.pane_offset()];
        Body::Pane { plate: p.plate, thickness: p.thickness, extinction: p.extinction }
    }

    /// A ray of the body's density and its weight: area, 4 × volume, or the pane's.
    fn emit(&self, dice: &mut Dice) -> (Vec3, Vec3, Bands) {
        match self {
            Body::Patch(p) => (dice.on_plate(p), dice.cosine(p.normal()), [p.area(); 3]),
            Body::Volume { lo, hi, planes } => {
                let x = dice.in_box(*lo, *hi);
                let w = if admits(planes, x) { 4.0 * (*hi - *lo).product() } else { 0.0 };
                (x, dice.direction(), [w; 3])
            }
            Body::Pane { plate, thickness, extinction } => {
                let n = plate.normal();
                let n = if dice.roll() < 0.5 { n } else { -n };
                let (x, d) = (dice.on_plate(plate), dice.cosine(n));
                let path = thickness / n.dot(d).max(1e-9);
                (x, d, share(*extinction, path).map(|s| 2.0 * plate.area() * s))
            }
        }
    }

    /// What a ray scores on this body.
    fn score(&self, w: &World, o: Vec3, d: Vec3, limit: f64) -> Bands {
        let none = [0.0; 3];
        match self {
            Body::Patch(p) => match world::meet(p, o, d) {
                Some((t, _)) if t > w.near && t <= limit + w.near && d.dot(p.normal()) < 0.0 => {
                    w.depth(o, d, t).map(|x| (-x).exp())
                }
                _ => none,
            },
            Body::Pane { plate, thickness, extinction } => match world::meet(plate, o, d) {
                Some((t, _)) if t > w.near && t < limit => {
                    let tau = w.depth(o, d, t).map(|x| (-x).exp());
                    let s = share(*extinction, thickness / d.dot(plate.normal()).abs());
                    std::array::from_fn(|b| tau[b] * s[b])
                }
                _ => none,
            },
            Body::Volume { lo, hi, planes } => {
                let (mut t0, mut t1) = (0.0f64, limit);
                let mut sides: Vec<(Vec3, f64)> = planes.clone();
                for axis in 0..3 {
                    let mut e = [0.0; 3];
                    e[axis] = 1.0;
                    let e = Vec3::from_array(e);
                    sides.extend([(e, lo[axis]), (-e, -hi[axis])]);
                }
                for (n, c) in sides {
                    let (h, g) = (n.dot(o) - c, n.dot(d));
                    if g > 0.0 {
                        t0 = t0.max(-h / g);
                    } else if g < 0.0 {
                        t1 = t1.min(-h / g);
                    } else if h < 0.0 {
                        return none;
                    }
                }
                if t1 <= t0 { none } else { inside(w, o, d, t0, t1) }
            }
        }
    }
}

/// ∫ τ ds from t0 to t1.
fn inside(w: &World, o: Vec3, d: Vec3, t0: f64, t1: f64) -> Bands {
    let (mut depth, mut sum) = ([0.0; 3], [0.0; 3]);
    for leg in w.legs(o, d, t1) {
        let kappa = w.kappa(&leg);
        let (a, b) = (leg.from.max(t0), leg.to.min(t1));
        for k in 0..3 {
            depth[k] += leg.pane.map_or(0.0, |p| p.1[k]);
            if b > a {
                let tau = (-(depth[k] + kappa[k] * (a - leg.from))).exp();
                let x = kappa[k] * (b - a);
                sum[k] += tau * if x < 1e-9 { b - a } else { (1.0 - (-x).exp()) / kappa[k] };
            }
            depth[k] += kappa[k] * (leg.to - leg.from);
        }
    }
    sum
}

/// g of a and b by `n` rays from a.
pub fn by_rays(w: &World, a: &Body, b: &Body, n: usize, seed: u64) -> [Estimate; 3] {
    let (mut dice, mut tally) = (Dice::new(seed), [Tally::default(); 3]);
    for _ in 0..n {
        let (o, d, weight) = a.emit(&mut dice);
        let limit = w.first(o, d).map_or(w.far, |s| s.t);
        let s = if weight == [0.0; 3] { [0.0; 3] } else { b.score(w, o, d, limit) };
        (0..3).for_each(|k| tally[k].add(weight[k] * s[k]));
    }
    tally.map(|t| t.estimate(1.0))
}

/// g of a and b, patches or volumes, by `n` pairs of points.
pub fn by_points(w: &World, a: &Body, b: &Body, n: usize, seed: u64) -> [Estimate; 3] {
    let (mut dice, mut tally) = (Dice::new(seed), [Tally::default(); 3]);
    let point = |z: &Body, dice: &mut Dice| match z {
        Body::Patch(p) => (dice.on_plate(p), p.area()),
        Body::Volume { lo, hi, planes } => {
            let x = dice.in_box(*lo, *hi);
            (x, if admits(planes, x) { (*hi - *lo).product() } else { 0.0 })
        }
        Body::Pane { .. } => panic!("a pane has no points; use rays"),
    };
    let side = |z: &Body, d: Vec3| if let Body::Patch(p) = z { p.normal().dot(d).max(0.0) } else { 1.0 };
    for _ in 0..n {
        let ((x, ma), (y, mb)) = (point(a, &mut dice), point(b, &mut dice));
        let r = (y - x).length();
        let d = (y - x) / r;
        let kernel = side(a, d) * side(b, -d) * ma * mb / (PI * r * r);
        let tau = if kernel > 0.0 && w.sees(x, y) { w.depth(x, d, r).map(|t| (-t).exp()) } else { [0.0; 3] };
        (0..3).for_each(|k| tally[k].add(kernel * tau[k]));
    }
    tally.map(|t| t.estimate(1.0))
}
