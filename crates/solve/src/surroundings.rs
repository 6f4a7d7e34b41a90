//! What leaves a zone for good: the factors of the surroundings' zone and of the black backs of one-sided surfaces, by rays.
//!
//! g_i,sky = ∬ τ (cosine) dω dA/π over the directions that leave the scene, likewise for the backs; for a volume zone without its κ.
//! Rays start at low-discrepancy points of the zone, in directions of the kernel's density (cosine on a patch, uniform in a voxel,
//! |cosine| with the pane's own share on a pane). First a few from every zone; where any of them escapes, the scene is open and every
//! zone gets all its rays: a window that the first few miss still counts. Millions of zones share a number of rays: few each, since
//! their errors are independent, and twice as many where the first ones disagree. Grade: statistical.
//!
//! The standard error of g_i,sky is told by the spread of batches of successive rays, whose sums are as independent as makes no matter;
//! of n rays none of which escaped, it is a share of 1/(n + 2), as [`zonal_exchange::pair`] has it.
//! Where the surroundings shine, zones whose error exceeds a share of the tolerance times the root mean square of what comes in shoot
//! more. The error of a batch falls with its rays to the power of about 3/4.

use rayon::prelude::*;
use zonal_exchange::pair::{SUCCESSION, sample_seed, target};
use zonal_math::directions::{cosine, sphere};
use zonal_math::{Vec3, sequence};
use zonal_scene::{Bands, PaneZone, Progress, Scene, Sides, VoxelZone, Zones, bands};
use zonal_transport::Transport;

/// Rays of the first look.
const PILOT: usize = 64;
/// Rays of all zones together, where they are many; times so many where the surroundings shine.
const BUDGET: usize = 1 << 24;
const SHINING: usize = 4;
/// The fewest rays of a zone, and how many times its share one takes of whose first rays some escape.
const FEW: usize = 8;
const MIXED: usize = 2;
/// Batches whose spread tells the error.
const BATCHES: usize = 8;
/// Error wanted of what comes in over tolerance and root mean square.
const SHARE: f64 = 0.4;
/// Times that zones shoot more, and how many times as many rays at most.
const ROUNDS: usize = 2;
const MORE: f64 = 16.0;
/// How many times as many that comes to, about, where light falls in through windows.
const LIKELY: usize = 10;
/// Rays of a zone at most.
const MOST: u32 = 1 << 16;

/// The surroundings' share of each zone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Escape {
    /// g_i,sky.
    pub sky: Vec<Bands>,
    /// g_i,backs.
    pub backs: Vec<Bands>,
    /// Standard error of g_i,sky; empty where nothing comes in from there.
    pub error: Vec<Bands>,
    /// Rays shot.
    pub rays: u64,
}

impl Escape {
    /// Measures all zones with up to `rays` rays each, of one of the samples as in [`zonal_exchange::pair::Settings`].
    pub fn measure(
        scene: &Scene,
        zones: &Zones,
        transport: &Transport,
        (rays, sample): (usize, u64),
        progress: &dyn Progress,
    ) -> Escape {
        let n = zones.len();
        progress.begin("surroundings", n as u64);
        let (each, pilot) = shares(scene, n, rays);
        let seed = sample_seed(sample);
        let shoot = |i: usize, range| one(scene, zones, transport, (i, seed), range);
        let mut found: Vec<One> = (0..n).into_par_iter().map(|i| shoot(i, 0..pilot)).collect();
        if pilot < rays && found.iter().any(|x| x.count > 0) {
            found.par_iter_mut().enumerate().for_each(|(i, x)| {
                let mixed = x.count > 0 && x.count < x.shot;
                x.add(&shoot(i, pilot..if mixed { (MIXED * each).min(rays) } else { each }));
            });
        }
        progress.advance(n as u64);
        let shining = scene.surroundings().shine();
        let target = |i: usize| target(zones, i);
        for _ in 0..if shining { ROUNDS } else { 0 } {
            let most = most(n);
            let wish = wishes(&found, zones, SHARE * scene.options().tolerance);
            found.par_iter_mut().zip(wish).enumerate().for_each(|(i, (x, wish))| {
                let all = ((x.shot as f64 * wish) as u32).min(most);
                if all > x.shot {
                    x.add(&shoot(i, x.shot as usize..all as usize));
                }
            });
        }
        progress.end();
        let mut escape = Escape::from_counts(&found, target);
        if shining && !escape.closed() {
            let error = |(i, x): (usize, &One)| x.error().map(|e| e * target(i));
            escape.error = found.iter().enumerate().map(error).collect();
        }
        escape
    }

    /// What comes in from the surroundings to zone `i` where they shine with radiosity `sky`, in the unit of P, and its error.
    pub fn incoming(&self, i: usize, sky: Bands) -> [Bands; 2] {
        let error = self.error.get(i).copied().unwrap_or_default();
        [bands(|b| self.sky[i][b] * sky[b]), bands(|b| error[b] * sky[b])]
    }

    /// Nothing yet, for [`crate::hierarchical::views::Views::escape`] to tell.
    pub fn untold(zones: &Zones) -> Escape {
        let none = vec![[0.0; 3]; zones.len()];
        Escape { sky: none.clone(), backs: none, ..Escape::default() }
    }

    /// Sums over rays of zones with these targets, made factors.
    fn from_counts(found: &[One], target: impl Fn(usize) -> f64) -> Escape {
        let scaled = |k: usize| {
            let one = |(i, x): (usize, &One)| x.sums[k].map(|s| s * target(i) / x.shot as f64);
            found.iter().enumerate().map(one).collect()
        };
        let rays = found.iter().map(|x| x.shot as u64).sum();
        Escape { sky: scaled(0), backs: scaled(1), error: Vec::new(), rays }
    }

    /// Rays that [`Escape::measure`] will take of `zones` zones, about.
    pub fn forecast(scene: &Scene, zones: usize, closed: bool) -> u64 {
        let rays = crate::pipeline::escape_rays(scene);
        let (each, pilot) = shares(scene, zones, rays);
        let shining = scene.surroundings().shine();
        let more = if shining { LIKELY.min(most(zones) as usize / each.max(1)).max(1) } else { 1 };
        (zones * if closed { pilot } else { more * each }) as u64
    }

    /// A quick look at every `step`-th zone.
    pub fn sample(scene: &Scene, zones: &Zones, transport: &Transport, rays: usize, step: usize) -> Escape {
        let list: Vec<usize> = (0..zones.len()).step_by(step).collect();
        let found: Vec<One> =
            list.into_par_iter().map(|i| one(scene, zones, transport, (i, 0), 0..rays)).collect();
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
    /// Variance of the first of these sums.
    variance: Bands,
    /// Number of these rays.
    count: u32,
    /// Number of all rays.
    shot: u32,
}

impl One {
    fn add(&mut self, o: &One) {
        self.sums = [0, 1].map(|k| bands(|b| self.sums[k][b] + o.sums[k][b]));
        self.variance = bands(|b| self.variance[b] + o.variance[b]);
        (self.count, self.shot) = (self.count + o.count, self.shot + o.shot);
    }

    /// The share that comes from the sky, and its standard error.
    fn sky(&self) -> Bands {
        self.sums[0].map(|s| s / self.shot.max(1) as f64)
    }
    fn error(&self) -> Bands {
        match self.count {
            0 => [1.0 / (self.shot as f64 + SUCCESSION); 3],
            _ => self.variance.map(|v| v.sqrt() / self.shot.max(1) as f64),
        }
    }
}

/// How many times as many rays every zone wants, for errors of `share` of the root mean square over the zones of its kind.
fn wishes(found: &[One], zones: &Zones, share: f64) -> Vec<f64> {
    let square = |v: Bands| v.iter().map(|x| x * x).sum::<f64>();
    let first = zones.voxel_offset();
    let mean = |of: &[One]| of.iter().map(|x| square(x.sky())).sum::<f64>() / of.len().max(1) as f64;
    let (patches, volumes) = found.split_at(first.min(found.len()));
    let wanted = [patches, volumes].map(|of| share * share * mean(of));
    let one = |(i, x): (usize, &One)| {
        let wanted = wanted[usize::from(i >= first)];
        if wanted > 0.0 { (square(x.error()) / wanted).powf(2.0 / 3.0).clamp(1.0, MORE) } else { 1.0 }
    };
    found.iter().enumerate().map(one).collect()
}

/// Rays of each of `n` zones, no more than `rays`, and the first of them.
fn shares(scene: &Scene, n: usize, rays: usize) -> (usize, usize) {
    let each = (budget(scene) / n.max(1)).clamp(FEW.min(rays), rays);
    (each, if each < rays { PILOT.min(each.div_ceil(2)) } else { PILOT.min(rays) })
}

/// Rays of each of `n` zones at most where the surroundings shine.
fn most(n: usize) -> u32 {
    (SHINING * BUDGET / n.max(1)).min(MOST as usize) as u32
}

/// Rays of all zones together; more where light comes in that way.
fn budget(scene: &Scene) -> usize {
    if scene.surroundings().shine() { SHINING * BUDGET } else { BUDGET }
}

/// Rays of a zone, shifted by `seed`.
fn one(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    (i, seed): (usize, u64),
    rays: std::ops::Range<usize>,
) -> One {
    let cell = scene.voxmap().map_or(Vec3::ZERO, |v| v.cell());
    let mut found = One { shot: rays.len() as u32, ..One::default() };
    // Sums of the batches, and of their squares.
    let (mut sum, mut squares, mut batches) = ([0.0; 3], [0.0; 3], 0.0);
    for batch in 0..BATCHES {
        let at = |b: usize| rays.start + b * rays.len() / BATCHES;
        let before = found.sums[0];
        for k in at(batch)..at(batch + 1) {
            let (origin, dir, weight) = ray(zones, cell, (i, seed), k);
            let (share, back) = fate(scene, transport, origin, dir);
            found.count += u32::from(share != [0.0; 3]);
            let sums = &mut found.sums[back as usize];
            (0..3).for_each(|b| sums[b] += share[b] * weight[b]);
        }
        if at(batch) < at(batch + 1) {
            let own = bands(|b| found.sums[0][b] - before[b]);
            (sum, squares) = (bands(|b| sum[b] + own[b]), bands(|b| squares[b] + own[b] * own[b]));
            batches += 1.0;
        }
    }
    if batches > 1.0 {
        let spread = |b: usize| (squares[b] - sum[b] * sum[b] / batches).max(0.0);
        found.variance = bands(|b| spread(b) * batches / (batches - 1.0));
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
pub fn ray(zones: &Zones, cell: Vec3, (i, seed): (usize, u64), k: usize) -> (Vec3, Vec3, Bands) {
    let hash = |m: u64| sequence::hash((i as u64 * 8 + m) ^ seed);
    let p = sequence::r3(k, [0, 1, 2].map(|m| sequence::unit((i as u64 * 8 + m) ^ seed)));
    // Two sequences of one sort would keep step for thousands of rays.
    let d = sequence::net(k as u32, [hash(3) as u32, hash(4) as u32]);
    if i < zones.voxel_offset() {
        let z = &zones.patches[i];
        let [u, v] = z.plate.warp([p[0], p[1]]);
        return (z.plate.at(u, v), cosine(z.normal, d), [1.0; 3]);
    }
    if i >= zones.pane_offset() {
        let z = &zones.panes[i - zones.pane_offset()];
        let [u, v] = z.plate.warp([p[0], p[1]]);
        // By the cosine, to either side.
        let w = cosine(if p[2] < 0.5 { z.normal } else { -z.normal }, d);
        return (z.plate.at(u, v), w, pane_share(z, w));
    }
    (voxel_point(&zones.voxels[i - zones.voxel_offset()], cell, p), sphere(d), [1.0; 3])
}

/// What such a ray counts, a band: with c its cosine 2 A ⟨(1 − e^{−κt/c})/κ⟩ against the target 4 A t.
pub fn pane_share(z: &PaneZone, dir: Vec3) -> Bands {
    z.within(dir).map(|x| x / (2.0 * z.thickness))
}

/// A point of a voxel zone with cell edges `cell`: uniform in a whole voxel, one of the samples of a cut one.
pub fn voxel_point(z: &VoxelZone, cell: Vec3, u: [f64; 3]) -> Vec3 {
    let whole = || z.centre + cell.scale(Vec3::from_array(u) - Vec3::splat(0.5));
    z.part.point_at(u[0]).unwrap_or_else(whole)
}
