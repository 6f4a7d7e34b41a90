//! Rays that go on where they end close by: light that varies within a patch.
//!
//! A zone shines with one radiosity. In a crease, under a ledge, behind an ornament that all but touches a wall, what a ray meets is darker
//! than the patch as a whole. A ray that meets patch j at x nearer than the patch is large goes on from x, by the cosine, and ends
//! elsewhere, in zone k; with one shadow ray towards one of the lights l of the patch, taken with probability p_l,
//!
//! ```text
//! B(x) = B⁰_j + ρ_j (H_l(x)/p_l + B_k)        B⁰_j the own light of j, without the lights that are followed
//! ```
//!
//! in place of B_j: unbiased for the light at x, of which B_j is the mean over the patch. It may go on again at k.

use super::shooter::{NOWHERE, SEED, Shooter, Stop};
use super::views::Shine;
use crate::direct::Direct;
use zonal_math::directions::cosine;
use zonal_math::{Vec3, sequence};
use zonal_scene::{Bands, Scene};
use zonal_transport::direct::{Lamp, Receiver};

/// A ray of a patch that ends nearer than this many square roots of the area of the patch that it meets goes on. (What a volume sees of
/// a patch close by is more of it.)
const NEAR: f64 = 1.5;
/// So many times at most.
const OFTEN: u64 = 8;
/// Marks the number of a step where that of a zone may stand.
const STEP: u32 = 1 << 31;
/// No light.
const DARK: u32 = u32::MAX;
/// Zones whose steps lie together.
pub(super) const BLOCK: usize = 256;

/// A place from which a ray goes on.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// The patch that was met.
    zone: u32,
    /// The zone that is met next, or another step, or nothing.
    next: u32,
    light: u32,
    /// H of the light over its probability, W/m².
    bright: [f32; 3],
    /// What the way to the next counts.
    worth: [f32; 3],
}

impl Step {
    /// Numbers that make a step.
    pub const WORDS: usize = 9;
    /// The numbers.
    pub fn words(&self) -> [u32; 9] {
        let ([a, b, c], [d, e, f]) = (self.bright.map(f32::to_bits), self.worth.map(f32::to_bits));
        [self.zone, self.next, self.light, a, b, c, d, e, f]
    }
    /// The step of these numbers.
    pub fn of([zone, next, light, a, b, c, d, e, f]: [u32; 9]) -> Step {
        let (bright, worth) = ([a, b, c].map(f32::from_bits), [d, e, f].map(f32::from_bits));
        Step { zone, next, light, bright, worth }
    }
    /// What is met next: a zone, a step or nothing.
    pub fn next(&self) -> u32 {
        self.next
    }
    /// True where the step is on one of so many patches.
    pub fn is_on(&self, patches: usize) -> bool {
        (self.zone as usize) < patches
    }
}

/// Bytes of a step.
pub(super) const BYTES: usize = size_of::<Step>();

/// Zone or step?
pub(super) fn step_of(met: u32) -> Option<usize> {
    (STEP..NOWHERE).contains(&met).then_some((met & !STEP) as usize)
}

/// The zone that a ray meets first.
pub(super) fn first_of(met: u32, steps: &[Step]) -> u32 {
    step_of(met).map_or(met, |s| steps[s].zone)
}

/// The light of a column that zones have of their own.
#[derive(Clone, Debug, Default)]
pub struct Own {
    /// B⁰ of the patches without the lights followed, W/m².
    pub zones: Vec<Shine>,
    /// What each light counts.
    pub lights: Vec<f32>,
}

impl Own {
    /// Adds so many times `other`.
    pub fn add(&mut self, other: &Own, times: f32) {
        self.zones.resize(other.zones.len(), [0.0; 4]);
        self.lights.resize(other.lights.len(), 0.0);
        for (o, z) in self.zones.iter_mut().zip(&other.zones) {
            (0..3).for_each(|b| o[b] += times * z[b]);
        }
        self.lights.iter_mut().zip(&other.lights).for_each(|(o, l)| *o += times * l);
    }
}

/// What a ray that counts `worth` brings from step number `at` on; `own` is left out where there is none.
pub(super) fn brought(
    steps: &[Step],
    at: usize,
    worth: Shine,
    reflectance: &[Shine],
    shine: &[Shine],
    own: Option<&Own>,
) -> Shine {
    let (mut left, mut sum, mut next) = (worth, [0.0; 4], Some(at));
    while let Some(at) = next {
        let step = &steps[at];
        let rho = reflectance[step.zone as usize];
        if let Some(own) = own {
            let lamp = own.lights.get(step.light as usize).copied().unwrap_or(0.0);
            let b = own.zones[step.zone as usize];
            (0..3).for_each(|k| sum[k] += left[k] * (b[k] + rho[k] * lamp * step.bright[k]));
        }
        (0..3).for_each(|k| left[k] *= rho[k] * step.worth[k]);
        next = step_of(step.next);
        if next.is_none() && step.next < NOWHERE {
            let b = shine[step.next as usize];
            (0..4).for_each(|k| sum[k] += left[k] * b[k]);
        }
    }
    sum
}

/// Lights as rays that go on meet them.
pub struct Lamps<'a> {
    lamps: Vec<Lamp<'a>>,
    direct: &'a Direct,
}

impl<'a> Lamps<'a> {
    /// Those of the scene, and what they bring to the zones.
    pub fn new(scene: &'a Scene, direct: &'a Direct) -> Lamps<'a> {
        Lamps { lamps: scene.lights().iter().map(|l| Lamp::new(scene, l)).collect(), direct }
    }

    /// One of the lights at `x` on patch `j`, and its H over its probability; by four numbers in [0,1).
    fn lit(&self, shooter: &Shooter, j: usize, x: Vec3, u: [f64; 4]) -> (u32, [f32; 3]) {
        let weight = |l: usize| self.direct.lights[l].fields[j].iter().fold(0.0f64, |m, v| m.max(*v));
        let total: f64 = (0..self.lamps.len()).map(weight).sum();
        if total <= 0.0 {
            return (DARK, [0.0; 3]);
        }
        let mut left = u[3] * total;
        let mut chosen = DARK;
        for l in (0..self.lamps.len()).filter(|&l| weight(l) > 0.0) {
            chosen = l as u32;
            left -= weight(l);
            if left < 0.0 {
                break;
            }
        }
        let (lamp, p) = (&self.lamps[chosen as usize], weight(chosen as usize) / total);
        let receiver = Receiver::Surface(shooter.zones.patches[j].normal);
        let beam = lamp.beam(shooter.transport, x, receiver, [u[0], u[1], u[2]]);
        let light: Option<Bands> = beam.and_then(|b| lamp.lit(shooter.transport, x, &b));
        (chosen, light.unwrap_or_default().map(|h| (h / p) as f32))
    }
}

impl Shooter<'_> {
    /// The patch at which a ray goes on.
    fn near(&self, stop: &Stop) -> Option<usize> {
        let patch = self.zones.patches.get(stop.zone as usize)?;
        (stop.distance < NEAR * patch.area.sqrt()).then_some(stop.zone as usize)
    }

    /// Follows ray `k` of zone `i` from where it stopped; the number of the zone or the step to note for it.
    pub(super) fn follow(
        &self,
        lamps: &Lamps,
        (i, k): (usize, usize),
        mut stop: Stop,
        steps: &mut Vec<Step>,
    ) -> u32 {
        let first = stop.zone;
        let seed = sequence::hash(sequence::hash(i as u64 ^ SEED).wrapping_add(k as u64));
        let mut head = None;
        let often = if i < self.zones.voxel_offset() { OFTEN } else { 0 };
        for depth in 0..often {
            let Some(j) = self.near(&stop) else { break };
            // Independent numbers: those of the ray's beginning, turned, would tie its end to it.
            let one = |m: u64| sequence::unit(seed.wrapping_add(depth << 3 | m));
            let (x, normal) = (stop.at, self.zones.patches[j].normal);
            let (light, bright) = lamps.lit(self, j, x, [one(0), one(1), one(2), one(3)]);
            let next = self.shoot(x, cosine(normal, [one(4), one(5)]), one(6));
            let number = STEP | steps.len() as u32;
            if head.is_none() {
                head = Some(number);
            } else if let Some(last) = steps.last_mut() {
                last.next = number;
            }
            steps.push(Step { zone: stop.zone, next: next.zone, light, bright, worth: next.worth });
            stop = next;
        }
        head.unwrap_or(first)
    }
}
