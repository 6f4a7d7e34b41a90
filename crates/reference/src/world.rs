//! A scene asked by brute force.
//!
//! A ray asks each facet in turn (Cramer's rule in the plate's plane). What lies along a ray is a list of legs: the ray is cut at
//! every plane between cells of the voxmap and at every pane, the cuts are sorted, and the middle of each leg says its cell.

use zonal_math::Vec3;
use zonal_scene::{Bands, Plate, PlateKind, Scene};

/// The first facet on a ray.
#[derive(Clone, Copy, Debug)]
pub struct Strike {
    /// Distance, m.
    pub t: f64,
    /// Index of the facet.
    pub facet: usize,
    /// Plate parameters.
    pub uv: [f64; 2],
    /// True when the front is met.
    pub front: bool,
}

/// A piece of a ray in one cell, or in none.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    /// Where it begins, m.
    pub from: f64,
    /// Where it ends, m.
    pub to: f64,
    /// The cell, if the leg lies in the voxmap.
    pub cell: Option<usize>,
    /// The pane that is crossed where the leg begins, with the optical depth across it.
    pub pane: Option<(usize, Bands)>,
}

/// Distance along a ray of unit direction to a plate, with plate parameters; a ray along the plate misses it.
pub fn meet(p: &Plate, o: Vec3, d: Vec3) -> Option<(f64, [f64; 2])> {
    let n = p.e1.cross(p.e2);
    let along = n.dot(d);
    if along.abs() < 1e-12 * n.length() {
        return None;
    }
    let t = n.dot(p.origin - o) / along;
    let [u, v] = p.parameters(o + d * t);
    let far = if p.kind == PlateKind::Triangle { u + v <= 1.0 } else { u <= 1.0 && v <= 1.0 };
    (u >= 0.0 && v >= 0.0 && far).then_some((t, [u, v]))
}

/// A scene and the lengths below which it does not look.
pub struct World<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Rays begin this far from their origin, m.
    pub near: f64,
    /// Rays end this far from their origin, m.
    pub far: f64,
}

impl<'a> World<'a> {
    /// Looks at a scene.
    pub fn new(scene: &'a Scene) -> World<'a> {
        let size = scene.diagonal();
        World { scene, near: 1e-9 * size, far: 4.0 * size }
    }

    /// The first facet on the ray.
    pub fn first(&self, o: Vec3, d: Vec3) -> Option<Strike> {
        let mut best: Option<Strike> = None;
        for (facet, f) in self.scene.facets().iter().enumerate() {
            if let Some((t, uv)) = meet(&f.plate, o, d)
                && t > self.near
                && best.is_none_or(|b| t < b.t)
            {
                best = Some(Strike { t, facet, uv, front: d.dot(f.plate.normal()) < 0.0 });
            }
        }
        best
    }

    /// True when no facet lies between two points.
    pub fn sees(&self, a: Vec3, b: Vec3) -> bool {
        let r = (b - a).length();
        self.first(a, (b - a) / r).is_none_or(|s| s.t > r - self.near)
    }

    /// The legs from 0 to `limit`.
    pub fn legs(&self, o: Vec3, d: Vec3, limit: f64) -> Vec<Leg> {
        let mut cuts: Vec<(f64, Option<(usize, Bands)>)> = vec![(0.0, None), (limit, None)];
        if let Some(map) = self.scene.voxmap() {
            for axis in 0..3 {
                for k in 0..=map.dims()[axis] {
                    let t = (map.min()[axis] + k as f64 * map.cell()[axis] - o[axis]) / d[axis];
                    if t > 0.0 && t < limit {
                        cuts.push((t, None));
                    }
                }
            }
        }
        for (k, p) in self.scene.panes().iter().enumerate() {
            let hit = p.plates.iter().find_map(|q| meet(q, o, d).map(|h| (h.0, q.normal())));
            if let Some((t, n)) = hit
                && t > self.near
                && t < limit - self.near
            {
                let path = p.thickness / n.dot(d).abs();
                cuts.push((t, Some((k, p.extinction.map(|e| e * path)))));
            }
        }
        cuts.sort_by(|a, b| a.0.total_cmp(&b.0));
        cuts.windows(2)
            .map(|w| Leg {
                from: w[0].0,
                to: w[1].0,
                cell: self.cell(o + d * (0.5 * (w[0].0 + w[1].0))),
                pane: w[0].1,
            })
            .collect()
    }

    /// The cell that holds `p`.
    fn cell(&self, p: Vec3) -> Option<usize> {
        let map = self.scene.voxmap()?;
        let mut c = [0; 3];
        for axis in 0..3 {
            let x = ((p[axis] - map.min()[axis]) / map.cell()[axis]).floor();
            if !(x >= 0.0 && x < map.dims()[axis] as f64) {
                return None;
            }
            c[axis] = x as usize;
        }
        Some(map.index(c))
    }

    /// κ of a leg.
    pub fn kappa(&self, leg: &Leg) -> Bands {
        leg.cell.map_or([0.0; 3], |c| self.scene.voxmap().expect("a cell has a voxmap").extinction(c))
    }

    /// Optical depth from 0 to `limit`.
    pub fn depth(&self, o: Vec3, d: Vec3, limit: f64) -> Bands {
        let mut sum = [0.0; 3];
        for leg in self.legs(o, d, limit) {
            let kappa = self.kappa(&leg);
            for b in 0..3 {
                sum[b] += leg.pane.map_or(0.0, |p| p.1[b]) + kappa[b] * (leg.to - leg.from);
            }
        }
        sum
    }
}
