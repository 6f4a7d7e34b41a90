//! Light at a point of a patch: the interpolated rest, and what the lamps send.
//!
//! Every point has 1 + n values a band: H_ind of all groups together, then H_dir of each of the n groups whose lamps are sampled
//! anew. All points take the same samples of a lamp, so that soft shadows come out as fine steps, not as noise.

use super::share::Share;
use crate::march::patch_tiles;
use crate::patch_field::{Layer, Shape};
use rayon::prelude::*;
use zonal_math::Vec3;
use zonal_scene::{Bands, Light, Solution, bands};
use zonal_transport::Transport;
use zonal_transport::direct::{Lamp, Receiver};

/// Direct light is asked this share of the way from a border to the middle of a patch: what stands on the border must hide it.
const INSET: f64 = 1e-3;
/// Skies among other lights fill the hemisphere.
const SKY: usize = 16;

/// Everything asked at the points of patches.
pub(super) struct Lights<'a> {
    pub shape: Shape<'a>,
    pub s: &'a Solution,
    transport: &'a Transport<'a>,
    all: Layer,
    /// Each lamp with the value that it adds to and its number of samples.
    lamps: Vec<(usize, Lamp<'a>, usize)>,
    /// For each group the value with its direct light, where it is sampled.
    pub slots: Vec<Option<usize>>,
    /// Means of the values over the patches by area, W/m²: the largest of the bands.
    pub means: Vec<f64>,
}

impl<'a> Lights<'a> {
    /// Prepares lamps and the field of all groups together.
    pub(super) fn new(
        s: &'a Solution,
        transport: &'a Transport<'a>,
        shares: &[Share],
        samples: usize,
    ) -> Lights<'a> {
        let (mut lamps, mut slots, mut used) = (Vec::new(), vec![None; shares.len()], 1);
        for (g, share) in shares.iter().enumerate().filter(|(_, g)| !g.is_smooth()) {
            for (_, light) in s.scene.lights().iter().enumerate().filter(|(l, _)| share.kind.has_light(*l)) {
                let slot = *slots[g].get_or_insert(used);
                used = slot + 1;
                let n = if matches!(light, Light::Sky { .. }) { SKY * samples } else { samples };
                lamps.push((slot, Lamp::new(&s.scene, light), n));
            }
        }
        let patches = s.zones.patches.len();
        let smooth = |i: usize| shares.iter().fold([0.0; 3], |sum, g| add(sum, interpolated(g, i)));
        let values: Vec<Bands> = (0..patches).into_par_iter().map(smooth).collect();
        let mut means = vec![mean(s, |i| values[i])];
        for (g, share) in shares.iter().enumerate().filter(|(g, _)| slots[*g].is_some()) {
            debug_assert_eq!(slots[g], Some(means.len()));
            means.push(mean(s, |i| share.direct(i)));
        }
        let shape = Shape::new(patch_tiles(s), Some(transport));
        Lights { shape, s, transport, all: Layer::new(values), lamps, slots, means }
    }

    /// Number of values a point.
    pub(super) fn values(&self) -> usize {
        self.means.len()
    }

    /// Appends the values at a point of a patch, given by the patch's parameters (u, v).
    pub(super) fn at(&self, patch: usize, uv: [f64; 2], out: &mut Vec<[f32; 3]>) {
        let first = out.len();
        out.push(single(self.all.at(&self.shape, patch, uv)));
        out.resize(first + self.values(), [0.0; 3]);
        let p = &self.s.zones.patches[patch];
        let point = self.place(patch, uv);
        let inside = point + (p.plate.centre() - point) * INSET;
        for (slot, lamp, n) in &self.lamps {
            let light = lamp.gather(self.transport, inside, Receiver::Surface(p.normal), *n, 1);
            let sum = &mut out[first + slot];
            *sum = [0, 1, 2].map(|b| sum[b] + light[b] as f32);
        }
    }

    /// The point of a patch with the patch's parameters, m.
    pub(super) fn place(&self, patch: usize, [u, v]: [f64; 2]) -> Vec3 {
        self.s.zones.patches[patch].plate.at(u, v)
    }

    /// The means of the values over a patch as the solver found them; direct light only where it is sampled.
    pub(super) fn of_zone(&self, shares: &[Share], patch: usize) -> Vec<Bands> {
        let mut out = vec![[0.0; 3]; self.values()];
        for (share, slot) in shares.iter().zip(&self.slots) {
            if let Some(slot) = slot {
                out[*slot] = share.direct(patch);
            }
        }
        out
    }
}

/// What of a group is interpolated on a patch, W/m².
pub(super) fn interpolated(share: &Share, patch: usize) -> Bands {
    if share.is_smooth() { share.fluence(patch) } else { share.incident(patch) }
}

fn mean(s: &Solution, value: impl Fn(usize) -> Bands) -> f64 {
    let (mut sum, mut area) = ([0.0; 3], 0.0);
    for (i, p) in s.zones.patches.iter().enumerate() {
        let v = value(i);
        sum = bands(|b| sum[b] + v[b] * p.area);
        area += p.area;
    }
    sum.into_iter().fold(0.0, f64::max) / f64::max(area, 1e-300)
}

fn add(a: Bands, b: Bands) -> Bands {
    bands(|k| a[k] + b[k])
}

pub(super) fn single(x: Bands) -> [f32; 3] {
    x.map(|x| x as f32)
}
