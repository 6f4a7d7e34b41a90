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
//! more. The error of a batch falls with its rays to the power of about 3/4. Where zones are few enough for thousands of rays each, these
//! go where they are needed (module `openings`).

use crate::openings::{self, Met, Openings, Room};
use rayon::prelude::*;
use zonal_exchange::pair::{sample_seed, target};
use zonal_math::directions::{cosine, sphere};
use zonal_math::{Vec3, sequence};
use zonal_scene::{Bands, PaneZone, Plate, Progress, Scene, Sides, VoxelZone, Zones, bands};
use zonal_transport::Transport;

/// Rays of the first look.
const PILOT: usize = 64;
/// Rays of all zones together, where they are many; times so many where the surroundings shine.
const BUDGET: usize = 1 << 24;
const SHINING: usize = 4;
/// The fewest rays of a zone, and how many times its share one takes of whose first rays some escape.
const FEW: usize = 8;
const MIXED: usize = 2;
/// Error wanted of what comes in over tolerance and root mean square.
const SHARE: f64 = 0.4;
/// Times that zones shoot more, and how many times as many rays at most.
const ROUNDS: usize = 2;
const MORE: f64 = 16.0;
/// Rays of a zone before [`crate::openings`] takes over.
const FIRST: usize = 256;
/// How many times as many that comes to, about, where light falls in through windows.
const LIKELY: usize = 10;
/// Rays of a zone to openings, about: three times so many at this tolerance.
const AIMED: f64 = 1500.0;
const AIMED_AT: f64 = 0.05;
/// Rays of a zone at most.
const MOST: usize = 1 << 18;
/// Tolerance below which all zones together may shoot more: rays go with the error to the power of −4/3.
const FINE: f64 = 0.01;

/// The surroundings' share of each zone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Escape {
    /// g_i,sky; an empty list stands for zeros.
    pub sky: Vec<Bands>,
    /// g_i,backs; an empty list stands for zeros.
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
        let shining = scene.surroundings().shine();
        progress.begin("surroundings", if shining { 2 * n as u64 } else { n as u64 });
        let rays = if worth_aiming(scene, n) { rays.min(FIRST) } else { rays };
        let (each, pilot) = shares(scene, n, rays);
        let room = Room { scene, zones, transport, seed: sample_seed(sample) };
        let mut found: Vec<Met> = (0..n).into_par_iter().map(|i| Met::evenly(&room, i, 0..pilot)).collect();
        if pilot < rays && found.iter().any(|x| x.count > 0) {
            found.par_iter_mut().enumerate().for_each(|(i, x)| {
                let mixed = x.count > 0 && x.count < x.shot;
                x.add(&Met::evenly(&room, i, pilot..if mixed { (MIXED * each).min(rays) } else { each }));
            });
        }
        progress.advance(n as u64);
        let target = |i: usize| target(zones, i);
        if shining {
            shoot_more(&room, &mut found, progress);
        }
        progress.end();
        let mut escape = Escape::from_counts(&found, target);
        if shining && !escape.closed() {
            let error = |(i, x): (usize, &Met)| x.error().map(|e| e * target(i));
            escape.error = found.iter().enumerate().map(error).collect();
        }
        escape
    }

    /// What comes in from the surroundings to zone `i` where they shine with radiosity `sky`, in the unit of P, and its error.
    pub fn incoming(&self, i: usize, sky: Bands) -> [Bands; 2] {
        let error = self.error.get(i).copied().unwrap_or_default();
        let own = self.sky_of(i);
        [bands(|b| own[b] * sky[b]), bands(|b| error[b] * sky[b])]
    }

    /// Standard error of the share of a zone's power that escapes, of a zone with this `target`: as measured, or that of as many independent
    /// rays as zones have in the mean, which is no less.
    pub fn spread(&self, i: usize, target: f64) -> Bands {
        if let Some(e) = self.error.get(i) {
            return e.map(|e| e / target);
        }
        let rays = (self.rays as f64 / self.sky.len().max(1) as f64).max(1.0);
        let away = self.away(i);
        bands(|b| {
            let share = (away[b] / target).clamp(0.0, 1.0);
            (share * (1.0 - share) / rays).sqrt()
        })
    }

    /// g_i,sky of zone `i`.
    pub fn sky_of(&self, i: usize) -> Bands {
        self.sky.get(i).copied().unwrap_or_default()
    }
    /// g_i,backs of zone `i`.
    pub fn backs_of(&self, i: usize) -> Bands {
        self.backs.get(i).copied().unwrap_or_default()
    }
    /// Both together.
    pub fn away(&self, i: usize) -> Bands {
        let (sky, backs) = (self.sky_of(i), self.backs_of(i));
        bands(|b| sky[b] + backs[b])
    }

    /// What escapes of every zone (and slope) times its factor, where closure is restored.
    pub fn scale(&mut self, d: &[Bands]) {
        for away in [&mut self.sky, &mut self.backs] {
            away.iter_mut().zip(d).for_each(|(x, d)| *x = bands(|b| x[b] * d[b]));
        }
    }

    /// Nothing yet, for [`crate::hierarchical::views::Views::escape`] to tell.
    pub fn untold(zones: &Zones) -> Escape {
        let none = vec![[0.0; 3]; zones.len()];
        Escape { sky: none.clone(), backs: none, ..Escape::default() }
    }

    /// Sums over rays of zones with these targets, made factors.
    fn from_counts(found: &[Met], target: impl Fn(usize) -> f64) -> Escape {
        let scaled = |k: usize| {
            let one = |(i, x): (usize, &Met)| x.sums[k].map(|s| s * target(i) / x.shot as f64);
            found.iter().enumerate().map(one).collect()
        };
        let rays = found.iter().map(|x| (x.shot + x.looked) as u64).sum();
        Escape { sky: scaled(0), backs: scaled(1), error: Vec::new(), rays }
    }

    /// Rays that [`Escape::measure`] will take of `zones` zones, about.
    pub fn forecast(scene: &Scene, zones: usize, closed: bool) -> u64 {
        let rays = crate::pipeline::escape_rays(scene);
        let (each, pilot) = shares(scene, zones, rays);
        let most = most(scene, zones);
        let shining = scene.surroundings().shine();
        let each = match shining {
            _ if closed => pilot,
            true if worth_aiming(scene, zones) => {
                let finer = (AIMED_AT / scene.options().tolerance).powf(4.0 / 3.0);
                (AIMED * (2.0 + finer)).min(most as f64) as usize
            }
            true => each * LIKELY.min(most / each.max(1)).max(1),
            false => each,
        };
        (zones * each) as u64
    }

    /// A quick look at every `step`-th zone.
    pub fn sample(scene: &Scene, zones: &Zones, transport: &Transport, rays: usize, step: usize) -> Escape {
        let list: Vec<usize> = (0..zones.len()).step_by(step).collect();
        let room = Room { scene, zones, transport, seed: 0 };
        let found: Vec<Met> = list.into_par_iter().map(|i| Met::evenly(&room, i, 0..rays)).collect();
        Escape::from_counts(&found, |i| target(zones, i * step))
    }

    /// True where no zone loses anything.
    pub fn closed(&self) -> bool {
        self.sky.iter().chain(&self.backs).all(|x| *x == [0.0; 3])
    }
}

/// Shoots more from zones whose error is too large.
fn shoot_more(room: &Room, found: &mut [Met], progress: &dyn Progress) {
    let options = room.scene.options();
    let most = most(room.scene, found.len());
    let kinds = [room.zones.voxel_offset(), room.zones.pane_offset()];
    let openings = if worth_aiming(room.scene, found.len()) { Openings::find(*room) } else { None };
    for round in if openings.is_some() { ROUNDS - 1 } else { 0 }..ROUNDS {
        let wanted = wanted(found, kinds, SHARE * options.tolerance);
        found.par_iter_mut().enumerate().for_each(|(i, x)| {
            let wanted = wanted[kinds.iter().filter(|first| i >= **first).count()];
            let off = norm(x.error()) / wanted;
            if wanted > 0.0 && off > 1.0 {
                let all = ((x.shot as f64 * off.powf(4.0 / 3.0).min(MORE)) as usize).min(most);
                match &openings {
                    Some(openings) => *x = openings.measure(i, wanted, most),
                    None if all > x.shot as usize => x.add(&Met::evenly(room, i, x.shot as usize..all)),
                    None => {}
                }
            }
            progress.advance(u64::from(round == ROUNDS - 1));
        });
    }
}

/// Whether zones may shoot so many rays that openings are worth looking for.
fn worth_aiming(scene: &Scene, zones: usize) -> bool {
    scene.surroundings().shine() && most(scene, zones) >= openings::WORTHWHILE
}

/// The error wanted of patches, voxel zones and panes, of which the latter begin so: `share` of the root mean square over the kind.
fn wanted(found: &[Met], [voxels, panes]: [usize; 2], share: f64) -> [f64; 3] {
    let mean = |of: &[Met]| of.iter().map(|x| norm(x.sky()).powi(2)).sum::<f64>() / of.len().max(1) as f64;
    [0..voxels, voxels..panes, panes..found.len()].map(|of| share * mean(&found[of]).sqrt())
}

/// Root of the sum of squares over bands.
fn norm(v: Bands) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Rays of each of `n` zones, no more than `rays`, and the first of them.
fn shares(scene: &Scene, n: usize, rays: usize) -> (usize, usize) {
    let each = (budget(scene) / n.max(1)).clamp(FEW.min(rays), rays);
    (each, if each < rays { PILOT.min(each.div_ceil(2)) } else { PILOT.min(rays) })
}

/// Rays of each of `n` zones at most where the surroundings shine.
fn most(scene: &Scene, n: usize) -> usize {
    let finer = (FINE / scene.options().tolerance).powf(4.0 / 3.0).max(1.0);
    ((finer * (SHINING * BUDGET) as f64 / n.max(1) as f64) as usize).min(MOST)
}

/// Rays of all zones together; more where light comes in that way.
fn budget(scene: &Scene) -> usize {
    if scene.surroundings().shine() { SHINING * BUDGET } else { BUDGET }
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
    let (p, d) = numbers(i, seed, k);
    ray_at(zones, cell, i, p, d)
}

/// Where in the unit cube of places and in the unit square of directions the `k`-th ray of zone `i` is.
pub fn numbers(i: usize, seed: u64, k: usize) -> ([f64; 3], [f64; 2]) {
    let hash = |m: u64| sequence::hash((i as u64 * 8 + m) ^ seed);
    let p = sequence::r3(k, [0, 1, 2].map(|m| sequence::unit((i as u64 * 8 + m) ^ seed)));
    // Two sequences of one sort would keep step for thousands of rays.
    (p, sequence::net(k as u32, [hash(3) as u32, hash(4) as u32]))
}

/// The ray of zone `i` from its place `p` of the unit cube in the direction `d` of the unit square, as [`ray`].
pub fn ray_at(zones: &Zones, cell: Vec3, i: usize, p: [f64; 3], d: [f64; 2]) -> (Vec3, Vec3, Bands) {
    let origin = place(zones, cell, i, p);
    if i < zones.voxel_offset() {
        return (origin, cosine(zones.patches[i].normal, d), [1.0; 3]);
    }
    if i >= zones.pane_offset() {
        let z = &zones.panes[i - zones.pane_offset()];
        // By the cosine, to either side.
        let w = cosine(if p[2] < 0.5 { z.normal } else { -z.normal }, d);
        return (origin, w, pane_share(z, w));
    }
    (origin, sphere(d), [1.0; 3])
}

/// The place of zone `i` at the point `p` of the unit cube.
pub fn place(zones: &Zones, cell: Vec3, i: usize, p: [f64; 3]) -> Vec3 {
    let on = |plate: &Plate| {
        let [u, v] = plate.warp([p[0], p[1]]);
        plate.at(u, v)
    };
    if i < zones.voxel_offset() {
        return on(&zones.patches[i].plate);
    }
    match i.checked_sub(zones.pane_offset()) {
        Some(k) => on(&zones.panes[k].plate),
        None => voxel_point(&zones.voxels[i - zones.voxel_offset()], cell, p),
    }
}

/// What such a ray counts, a band: with c its cosine 2 A ⟨(1 − e^{−κt/c})/κ⟩ against the target 4 A t.
pub fn pane_share(z: &PaneZone, dir: Vec3) -> Bands {
    z.effective_path(dir).map(|x| x / (2.0 * z.thickness))
}

/// A point of a voxel zone with cell edges `cell`: uniform in a whole voxel, one of the samples of a cut one.
pub fn voxel_point(z: &VoxelZone, cell: Vec3, u: [f64; 3]) -> Vec3 {
    let whole = || z.centre + cell.scale(Vec3::from_array(u) - Vec3::splat(0.5));
    z.part.point_at(u[0]).unwrap_or_else(whole)
}
