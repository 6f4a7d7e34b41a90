//! What leaves a zone for good: the factors of the surroundings' zone and of the black backs of one-sided surfaces, by rays.
//!
//! g_i,sky = ∬ τ (cosine) dω dA/π over the directions that leave the scene, likewise for the backs; for a volume zone without its κ.
//! Rays start at low-discrepancy points of the zone, in directions of the kernel's density (cosine on a patch, uniform in a voxel,
//! |cosine| with the pane's own share on a pane). First a few from every zone; where any of them escapes, the scene is open and every
//! zone gets all its rays: a window that the first few miss still counts. Grade: statistical.

use rayon::prelude::*;
use std::f64::consts::PI;
use zonal_exchange::pair::target;
use zonal_math::{Vec3, sequence, vec3};
use zonal_scene::{Bands, Progress, Scene, Sides, VoxelZone, Zones, bands};
use zonal_transport::Transport;

/// Rays of the first look.
const PILOT: usize = 64;

/// The surroundings' share of each zone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Escape {
    /// g_i,sky.
    pub sky: Vec<Bands>,
    /// g_i,backs.
    pub backs: Vec<Bands>,
    /// Rays shot.
    pub rays: u64,
}

impl Escape {
    /// Measures all zones with up to `rays` rays each.
    pub fn measure(
        scene: &Scene,
        zones: &Zones,
        transport: &Transport,
        rays: usize,
        progress: &dyn Progress,
    ) -> Escape {
        let n = zones.len();
        progress.begin("surroundings", n as u64);
        let shoot = |first: usize, last: usize| -> Vec<Lost> {
            (0..n).into_par_iter().map(|i| one(scene, zones, transport, i, first..last)).collect()
        };
        let mut sums = shoot(0, PILOT.min(rays));
        let mut shot = PILOT.min(rays);
        if shot < rays && sums.iter().any(|x| *x != Lost::default()) {
            let more = shoot(shot, rays);
            for (s, m) in sums.iter_mut().zip(&more) {
                (0..2).for_each(|k| s[k] = bands(|b| s[k][b] + m[k][b]));
            }
            shot = rays;
        }
        progress.advance(n as u64);
        progress.end();
        Escape::from_sums(&sums, zones, 1, shot)
    }

    /// Sums over `shot` rays from every `step`-th zone, made factors.
    fn from_sums(sums: &[Lost], zones: &Zones, step: usize, shot: usize) -> Escape {
        let scaled = |k: usize| {
            let one = |(i, x): (usize, &Lost)| x[k].map(|x| x * target(zones, i * step) / shot as f64);
            sums.iter().enumerate().map(one).collect()
        };
        Escape { sky: scaled(0), backs: scaled(1), rays: (sums.len() * shot) as u64 }
    }

    /// A quick look at every `step`-th zone.
    pub fn sample(scene: &Scene, zones: &Zones, transport: &Transport, rays: usize, step: usize) -> Escape {
        let sums: Vec<Lost> =
            (0..zones.len()).step_by(step).map(|i| one(scene, zones, transport, i, 0..rays)).collect();
        Escape::from_sums(&sums, zones, step, rays)
    }

    /// True where no zone loses anything.
    pub fn closed(&self) -> bool {
        self.sky.iter().chain(&self.backs).all(|x| *x == [0.0; 3])
    }
}

/// Sums over rays: what went to the sky, what ended on black backs.
type Lost = [Bands; 2];

fn one(scene: &Scene, zones: &Zones, transport: &Transport, i: usize, rays: std::ops::Range<usize>) -> Lost {
    let cell = scene.voxmap().map_or(Vec3::ZERO, |v| v.cell());
    let mut sums = Lost::default();
    for k in rays {
        let (origin, dir, weight) = ray(zones, cell, i, k);
        let (share, back) = fate(scene, transport, origin, dir);
        (0..3).for_each(|b| sums[back as usize][b] += share[b] * weight[b]);
    }
    sums
}

/// Transmittance of a ray that leaves the scene or ends on a black back (true), zero for one that ends on a zone.
pub fn fate(scene: &Scene, transport: &Transport, origin: Vec3, dir: Vec3) -> (Bands, bool) {
    let reach = 2.0 * scene.diagonal() + (origin - scene.bounds().0).length();
    let eps = 1e-9 * scene.diagonal();
    match transport.nearest(origin, dir, eps, reach) {
        None => (transport.optical_depth(origin, origin + dir * reach).map(|d| (-d).exp()), false),
        Some(hit) => {
            let s = &scene.surfaces()[scene.facets()[hit.facet].surface];
            if hit.front || s.sides == Sides::Both {
                ([0.0; 3], false)
            } else {
                (transport.optical_depth(origin, origin + dir * hit.t).map(|d| (-d).exp()), true)
            }
        }
    }
}

/// The `k`-th ray of a zone: origin, direction and weight with mean 1 (a pane's own share apart).
fn ray(zones: &Zones, cell: Vec3, i: usize, k: usize) -> (Vec3, Vec3, Bands) {
    let shift = |m: u64| sequence::unit(i as u64 * 8 + m);
    let p = sequence::r3(k, [shift(0), shift(1), shift(2)]);
    let d = sequence::r2(k, [shift(3), shift(4)]);
    if i < zones.voxel_offset() {
        let z = &zones.patches[i];
        let [u, v] = z.plate.warp([p[0], p[1]]);
        return (z.plate.at(u, v), cosine(z.normal, d), [1.0; 3]);
    }
    if i >= zones.pane_offset() {
        let z = &zones.panes[i - zones.pane_offset()];
        let [u, v] = z.plate.warp([p[0], p[1]]);
        let side = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        let w = cosine(z.normal * side, d);
        let path = z.thickness / z.normal.dot(w).abs().max(1e-6);
        // 2 A ⟨(1 − e^{−κt/c})/κ⟩ against the target 4 A t.
        let weight = z.extinction.map(|e| if e * path > 1e-12 { -(-e * path).exp_m1() / e } else { path });
        return (z.plate.at(u, v), w, weight.map(|x| x / (2.0 * z.thickness)));
    }
    let cos = 1.0 - 2.0 * d[0];
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (s, c) = (2.0 * PI * d[1]).sin_cos();
    (
        voxel_point(&zones.voxels[i - zones.voxel_offset()], cell, p),
        vec3(sin * c, sin * s, cos),
        bands(|_| 1.0),
    )
}

/// A point of a voxel zone with cell edges `cell`: uniform in a whole voxel, one of the samples of a cut one.
pub fn voxel_point(z: &VoxelZone, cell: Vec3, u: [f64; 3]) -> Vec3 {
    let whole = || z.centre + cell.scale(Vec3::from_array(u) - Vec3::splat(0.5));
    z.part.point_at(u[0]).unwrap_or_else(whole)
}

/// A direction of cosine density about `n` from two numbers in [0, 1).
pub fn cosine(n: Vec3, u: [f64; 2]) -> Vec3 {
    let (t, b) = n.frame();
    let r = u[0].sqrt();
    let (s, c) = (2.0 * PI * u[1]).sin_cos();
    t * (r * c) + b * (r * s) + n * (1.0 - u[0]).max(0.0).sqrt()
}
