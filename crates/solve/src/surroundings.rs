//! What leaves a zone for good: the factors of the surroundings' zone and of the black backs of one-sided surfaces, by rays.
//!
//! g_i,sky = ∬ τ (cosine) dω dA/π over the directions that leave the scene, likewise for the backs; for a volume zone without its κ.
//! Rays start at low-discrepancy points of the zone, in directions of the kernel's density (cosine on a patch, uniform in a voxel,
//! |cosine| with the pane's own share on a pane). First a few from every zone; where any of them escapes, the scene is open and every
//! zone gets all its rays: a window that the first few miss still counts. Millions of zones share a number of rays: few each, since
//! their errors are independent, and twice as many where the first ones disagree. Grade: statistical.

use rayon::prelude::*;
use zonal_exchange::pair::target;
use zonal_math::directions::{cosine, sphere};
use zonal_math::{Vec3, sequence};
use zonal_scene::{Bands, Progress, Scene, Sides, VoxelZone, Zones, bands};
use zonal_transport::Transport;

/// Rays of the first look.
const PILOT: usize = 64;
/// Rays of all zones together, where they are many; times so many where the surroundings shine.
const BUDGET: usize = 1 << 24;
const SHINING: usize = 4;
/// The fewest rays of a zone, and how many times its share one takes of whose first rays some escape.
const FEW: usize = 8;
const MIXED: usize = 2;

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
        let (each, pilot) = shares(scene, n, rays);
        let shoot = |i: usize, range| one(scene, zones, transport, i, range);
        let mut found: Vec<One> = (0..n).into_par_iter().map(|i| shoot(i, 0..pilot)).collect();
        if pilot < rays && found.iter().any(|x| x.count > 0) {
            found.par_iter_mut().enumerate().for_each(|(i, x)| {
                let mixed = x.count > 0 && x.count < x.shot;
                x.add(&shoot(i, pilot..if mixed { (MIXED * each).min(rays) } else { each }));
            });
        }
        progress.advance(n as u64);
        progress.end();
        Escape::from_counts(&found, |i| target(zones, i))
    }

    /// Measures pane zones alone, with so many rays each: the others wait for [`crate::hierarchical::views::Views::escape`].
    pub fn of_panes(scene: &Scene, zones: &Zones, transport: &Transport, rays: usize) -> Escape {
        let (n, from) = (zones.len(), zones.pane_offset());
        let found: Vec<One> =
            (from..n).into_par_iter().map(|i| one(scene, zones, transport, i, 0..rays)).collect();
        let Escape { sky, backs, rays } = Escape::from_counts(&found, |k| target(zones, from + k));
        let whole = |panes: Vec<Bands>| [vec![[0.0; 3]; from], panes].concat();
        Escape { sky: whole(sky), backs: whole(backs), rays }
    }

    /// Sums over rays of zones with these targets, made factors.
    fn from_counts(found: &[One], target: impl Fn(usize) -> f64) -> Escape {
        let scaled = |k: usize| {
            let one = |(i, x): (usize, &One)| x.sums[k].map(|s| s * target(i) / x.shot as f64);
            found.iter().enumerate().map(one).collect()
        };
        let rays = found.iter().map(|x| x.shot as u64).sum();
        Escape { sky: scaled(0), backs: scaled(1), rays }
    }

    /// Rays that [`Escape::measure`] will take of `zones` zones, about.
    pub fn forecast(scene: &Scene, zones: usize, closed: bool) -> u64 {
        let rays = crate::pipeline::escape_rays(scene);
        let (each, pilot) = shares(scene, zones, rays);
        (zones * if closed { pilot } else { each }) as u64
    }

    /// A quick look at every `step`-th zone.
    pub fn sample(scene: &Scene, zones: &Zones, transport: &Transport, rays: usize, step: usize) -> Escape {
        let list: Vec<usize> = (0..zones.len()).step_by(step).collect();
        let found: Vec<One> =
            list.into_par_iter().map(|i| one(scene, zones, transport, i, 0..rays)).collect();
        Escape::from_counts(&found, |i| target(zones, i * step))
    }

    /// True where no zone loses anything.
    pub fn closed(&self) -> bool {
        self.sky.iter().chain(&self.backs).all(|x| *x == [0.0; 3])
    }
}

/// What the rays of one zone met.
#[derive(Clone, Copy, Debug, Default)]
struct One {
    /// Sums over the rays that went to the sky, and that ended on black backs.
    sums: [Bands; 2],
    /// Number of these rays.
    count: u32,
    /// Number of all rays.
    shot: u32,
}

impl One {
    fn add(&mut self, o: &One) {
        self.sums = [0, 1].map(|k| bands(|b| self.sums[k][b] + o.sums[k][b]));
        (self.count, self.shot) = (self.count + o.count, self.shot + o.shot);
    }
}

/// Rays of each of `n` zones, no more than `rays`, and the first of them.
fn shares(scene: &Scene, n: usize, rays: usize) -> (usize, usize) {
    let each = (budget(scene) / n.max(1)).clamp(FEW.min(rays), rays);
    (each, if each < rays { PILOT.min(each.div_ceil(2)) } else { PILOT.min(rays) })
}

/// Rays of all zones together; more where light comes in that way.
fn budget(scene: &Scene) -> usize {
    if scene.surroundings().radiance == [0.0; 3] { BUDGET } else { SHINING * BUDGET }
}

fn one(scene: &Scene, zones: &Zones, transport: &Transport, i: usize, rays: std::ops::Range<usize>) -> One {
    let cell = scene.voxmap().map_or(Vec3::ZERO, |v| v.cell());
    let mut found = One { shot: rays.len() as u32, ..One::default() };
    for k in rays {
        let (origin, dir, weight) = ray(zones, cell, i, k);
        let (share, back) = fate(scene, transport, origin, dir);
        found.count += u32::from(share != [0.0; 3]);
        let sums = &mut found.sums[back as usize];
        (0..3).for_each(|b| sums[b] += share[b] * weight[b]);
    }
    found
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
    (voxel_point(&zones.voxels[i - zones.voxel_offset()], cell, p), sphere(d), [1.0; 3])
}

/// A point of a voxel zone with cell edges `cell`: uniform in a whole voxel, one of the samples of a cut one.
pub fn voxel_point(z: &VoxelZone, cell: Vec3, u: [f64; 3]) -> Vec3 {
    let whole = || z.centre + cell.scale(Vec3::from_array(u) - Vec3::splat(0.5));
    z.part.point_at(u[0]).unwrap_or_else(whole)
}
