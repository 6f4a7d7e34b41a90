//! Rays where the picture needs them.
//!
//! A ray brings L = M + T L_b: what the medium adds and leaves before the first pane or surface, and what comes from there. Both differ in how
//! fast they change across the picture, so they have rays of their own.
//!
//! 1. L_b of the middle of every pixel.
//! 2. M and T at every fourth pixel across and down, then halfway between those, then between these. Halfway the mean of the two or four
//!    around serves where they agree: their ends are about as far, seen through the medium's extinction, theirs and its own, and M differs by less than a
//!    few hundredths of L. The rest of the depth, t − t̄, is made good by κ and the source at the ends. Else the ray is
//!    followed: at borders of things, and of shafts.
//! 3. Pixels that differ from one of the eight around have rays in their corners, and where these differ much, at their edges: nine
//!    in all, the same as of a regular grid, which small things that shine have in any case. Such a ray has M and T from its own pixel or one of those around which is about as deep.
//!
//! Every value is a function of the pixel and what it is compared with alone; strips of rows bound the memory and change nothing.

use crate::camera::{Pinhole, subpixel};
use crate::columns::FINE_STEPS;
use crate::march::{Draw, Front, View};
use crate::{RenderOptions, pixel_shift, single};
use rayon::prelude::*;
use std::collections::HashSet;
use zonal_math::Vec3;
use zonal_scene::{Bands, Facet, Plate, Progress, bands};

/// Spacing of the first rays through the medium, pixels.
const GRID: usize = 4;
/// Rows of a strip.
const STRIP: usize = 128;
/// Rays of a pixel at most, on a square grid with the pixel's middle among them.
const RAYS: usize = 9;
const MIDDLE: usize = 4;
/// Those that are asked first, and then.
const CORNERS: [usize; 4] = [0, 2, 6, 8];
const EDGES: [usize; 4] = [1, 3, 5, 7];

/// How often suns are asked along a ray of the first grid, and of a later one.
const SHARED: usize = 4;
const OWN: usize = 2;
/// Neighbours in the medium agree where M differs by less than this share of L.
const SAME_GLOW: f64 = 0.05;
/// … and the depths of their ends by less than this optical depth, and this share.
const SAME_DEPTH: f64 = 0.06;
const SAME_LENGTH: f64 = 0.2;
/// A ray's own depth may be off theirs by so much.
const NEAR_DEPTH: f64 = 0.01;
const NEAR_LENGTH: f64 = 0.05;
/// Pixels that differ by a larger share have more rays.
const CONTRAST: f64 = 0.06;
/// A plate that shines is small if it is not wider than so many pixels.
const SMALL: f64 = 4.0;
/// Rays of a pixel that differ by a larger share have still more.
const STRONG: f64 = 0.2;

/// A picture that is drawn.
pub(crate) struct Adaptive<'a> {
    view: &'a View<'a>,
    pinhole: &'a Pinhole,
    options: &'a RenderOptions,
    /// Pixels in which something small shines.
    bright: HashSet<(usize, usize)>,
}

/// What lies behind the medium at the middle of a pixel.
#[derive(Clone, Copy)]
struct Dot {
    t: f64,
    back: Bands,
}

/// Some rows, beyond the picture's borders to the next rays of the grid.
struct Strip {
    first: usize,
    width: usize,
    dots: Vec<Dot>,
    fronts: Vec<Option<Front>>,
}

impl Strip {
    fn index(&self, x: usize, y: usize) -> usize {
        (y - self.first) * self.width + x
    }
    /// True where two pixels need more rays: what lies behind the medium differs, or its depth and what is seen.
    fn differ(&self, (x, y): (usize, usize), (u, v): (usize, usize)) -> bool {
        let [i, j] = [self.index(x, y), self.index(u, v)];
        let (Some(f), Some(g)) = (self.fronts[i], self.fronts[j]) else {
            return true;
        };
        let [a, b] = [(f, i), (g, j)].map(|(f, i)| f.before(self.dots[i].back));
        let edge = (f.t - g.t).abs() * most(f.kappa).max(most(g.kappa)) > NEAR_DEPTH
            || (f.t - g.t).abs() > NEAR_LENGTH * f.t;
        let behind = |f: &Front, i: usize| bands(|b| f.tau[b] * self.dots[i].back[b]);
        far_apart(behind(&f, i), behind(&g, j), CONTRAST, bands(|k| a[k] + b[k]))
            || edge && differ(a, b, CONTRAST)
    }
    /// L of a pixel.
    fn seen(&self, x: usize, y: usize) -> Bands {
        let i = self.index(x, y);
        self.fronts[i].map_or([0.0; 3], |f| f.before(self.dots[i].back))
    }
}

impl<'a> Adaptive<'a> {
    /// Ready to draw.
    pub(crate) fn new(view: &'a View<'a>, pinhole: &'a Pinhole, options: &'a RenderOptions) -> Adaptive<'a> {
        let mut out = Adaptive { view, pinhole, options, bright: HashSet::new() };
        let scene = view.scene();
        let shines = |f: &&Facet| scene.surfaces()[f.surface].emission != [0.0; 3];
        scene.facets().iter().filter(shines).for_each(|f| out.note(&f.plate));
        out
    }

    /// Notes the pixels of a plate that shines, if they are few: rays through the middles of pixels might miss it.
    fn note(&mut self, plate: &Plate) {
        let o = self.options;
        let (corners, n) = plate.corners();
        let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for c in &corners[..n] {
            let Some([x, y]) = self.pinhole.place(*c) else { return };
            let place = [x * o.width as f64, y * o.height as f64];
            (lo, hi) = ([0, 1].map(|k| lo[k].min(place[k])), [0, 1].map(|k| hi[k].max(place[k])));
        }
        if (0..2).any(|k| hi[k] - lo[k] > SMALL || hi[k] < 0.0) {
            return;
        }
        let range = |k: usize, n: usize| lo[k].max(0.0) as usize..(hi[k] as usize + 1).min(n);
        for y in range(1, o.height) {
            self.bright.extend(range(0, o.width).map(|x| (x, y)));
        }
    }

    /// All pixels, row by row.
    pub(crate) fn draw(&self, progress: &dyn Progress) -> Vec<[f32; 3]> {
        let height = self.options.height;
        let mut out = Vec::with_capacity(self.options.width * height);
        for first in (0..height).step_by(STRIP) {
            let last = (first + STRIP).min(height);
            let strip = self.strip(first, last);
            let rows: Vec<Vec<[f32; 3]>> = (first..last)
                .into_par_iter()
                .map(|y| (0..self.options.width).map(|x| self.pixel(&strip, x, y)).collect())
                .collect();
            out.extend(rows.into_iter().flatten());
            progress.advance((last - first) as u64);
        }
        out
    }

    /// The middles of the pixels of some rows and of what surrounds them.
    fn strip(&self, first: usize, last: usize) -> Strip {
        let up = |n: usize| n.div_ceil(GRID) * GRID;
        let width = up(self.options.width - 1) + 1;
        let (first, last) = (first.saturating_sub(GRID), up(last.min(self.options.height - 1)) + 1);
        let rows: Vec<Vec<Dot>> =
            (first..last).into_par_iter().map(|y| (0..width).map(|x| self.dot(x, y)).collect()).collect();
        let dots: Vec<Dot> = rows.into_iter().flatten().collect();
        let mut strip = Strip { first, width, fronts: vec![None; dots.len()], dots };
        let mut step = GRID;
        while step > 0 {
            let rows: Vec<(usize, Vec<Option<Front>>)> = (first.next_multiple_of(step)..last)
                .into_par_iter()
                .step_by(step)
                .map(|y| (y, (0..width).step_by(step).map(|x| self.medium(&strip, x, y, step)).collect()))
                .collect();
            for (y, row) in rows {
                for (k, front) in row.into_iter().enumerate() {
                    let i = strip.index(k * step, y);
                    strip.fronts[i] = strip.fronts[i].or(front);
                }
            }
            step /= 2;
        }
        strip
    }

    /// The direction of a ray of a pixel, and its samples of the lights.
    fn ray(&self, x: usize, y: usize, i: usize) -> (Vec3, Draw) {
        let o = self.options;
        let [dx, dy] = subpixel(i, RAYS);
        let dir = self.pinhole.direction((x as f64 + dx) / o.width as f64, (y as f64 + dy) / o.height as f64);
        let count = o.light_samples.max(1);
        (dir, Draw { steps: FINE_STEPS, ..Draw::of_ray(i, count, pixel_shift(x, y)) })
    }

    fn dot(&self, x: usize, y: usize) -> Dot {
        let (dir, draw) = self.ray(x, y, MIDDLE);
        let seen = self.view.seen(self.pinhole.origin, dir);
        Dot { t: seen.front(), back: self.view.back(self.pinhole.origin, dir, &seen, draw) }
    }

    /// The front of a pixel of the grid of this step; `None` where it is there.
    fn medium(&self, strip: &Strip, x: usize, y: usize, step: usize) -> Option<Front> {
        let wide = 2 * step;
        if step < GRID {
            let side = |x: usize| [x - x % wide, x.next_multiple_of(wide)];
            let ([x0, x1], [y0, y1]) = (side(x), side(y));
            if x0 == x1 && y0 == y1 {
                return None;
            }
            let around = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)].map(|(x, y)| strip.index(x, y));
            if let Some(front) = between(strip, around, strip.dots[strip.index(x, y)].t) {
                return Some(front);
            }
        }
        let (dir, draw) = self.ray(x, y, MIDDLE);
        let draw = Draw { rounds: if step == GRID { SHARED } else { OWN }, ..draw };
        Some(self.view.front(self.pinhole.origin, dir, strip.dots[strip.index(x, y)].t, draw))
    }

    /// A pixel of the picture.
    fn pixel(&self, strip: &Strip, x: usize, y: usize) -> [f32; 3] {
        let own = strip.seen(x, y);
        let mut around = self.around(x, y).filter(|p| *p != (x, y));
        let bright = self.bright.contains(&(x, y));
        if !bright && !around.any(|p| strip.differ((x, y), p)) {
            return own.map(single);
        }
        let (mut sum, mut count, mut range) = (own, 1.0, (own, own));
        for (k, i) in CORNERS.into_iter().chain(EDGES).enumerate() {
            if k == CORNERS.len() && !bright && !differ(range.0, range.1, STRONG) {
                break;
            }
            let l = self.more(strip, x, y, i);
            (sum, count) = (bands(|b| sum[b] + l[b]), count + 1.0);
            range = (bands(|b| range.0[b].min(l[b])), bands(|b| range.1[b].max(l[b])));
        }
        sum.map(|s| single(s / count))
    }

    /// Ray number `i` of a pixel.
    fn more(&self, strip: &Strip, x: usize, y: usize, i: usize) -> Bands {
        let (origin, (dir, draw)) = (self.pinhole.origin, self.ray(x, y, i));
        let seen = self.view.seen(origin, dir);
        let (back, t) = (self.view.back(origin, dir, &seen, draw), seen.front());
        let fronts = self.around(x, y).filter_map(|(x, y)| strip.fronts[strip.index(x, y)]);
        let near = fronts.map(|f| ((f.t - t).abs(), f)).min_by(|a, b| a.0.total_cmp(&b.0));
        match near.filter(|(d, f)| d * most(f.kappa) <= NEAR_DEPTH && *d <= NEAR_LENGTH * t) {
            Some((_, f)) => reaching(f, t),
            None => self.view.front(origin, dir, t, draw),
        }
        .before(back)
    }

    /// The pixel itself and those around it.
    fn around(&self, x: usize, y: usize) -> impl Iterator<Item = (usize, usize)> + use<> {
        let near = |x: usize, n: usize| x.saturating_sub(1)..(x + 2).min(n);
        let (xs, ys) = (near(x, self.options.width), near(y, self.options.height));
        ys.flat_map(move |y| xs.clone().map(move |x| (x, y)))
    }
}

/// The mean of the fronts around, for a ray of length `t`; `None` where they do not agree.
fn between(strip: &Strip, around: [usize; 4], t: f64) -> Option<Front> {
    let fronts = around.map(|i| strip.fronts[i]);
    let fronts = [fronts[0]?, fronts[1]?, fronts[2]?, fronts[3]?];
    let mean = |of: &dyn Fn(&Front) -> Bands| bands(|b| fronts.iter().map(|f| of(f)[b]).sum::<f64>() / 4.0);
    let length = fronts.iter().map(|f| f.t).sum::<f64>() / 4.0;
    let (lo, hi) = fronts.iter().fold((t, t), |(lo, hi), f| (lo.min(f.t), hi.max(f.t)));
    let kappa = fronts.iter().fold(0.0, |k: f64, f| k.max(most(f.kappa)));
    let off = (t - length).abs();
    if (hi - lo) * kappa > SAME_DEPTH
        || hi - lo > SAME_LENGTH * lo
        || off * kappa > NEAR_DEPTH
        || off > NEAR_LENGTH * t
    {
        return None;
    }
    let seen = bands(|b| {
        let one = |k: usize| fronts[k].before(strip.dots[around[k]].back)[b];
        (0..4).map(one).sum::<f64>() / 4.0
    });
    let all = seen.iter().sum::<f64>() / 3.0;
    for b in 0..3 {
        let range = |of: &dyn Fn(&Front) -> f64| {
            let (lo, hi) =
                fronts.iter().map(of).fold((f64::INFINITY, 0.0f64), |(lo, hi), x| (lo.min(x), hi.max(x)));
            hi - lo
        };
        if range(&|f| f.glow[b]) > SAME_GLOW * 0.5 * (seen[b] + all) || range(&|f| f.tau[b]) > SAME_DEPTH {
            return None;
        }
    }
    let whole = Front {
        t: length,
        glow: mean(&|f| f.glow),
        tau: mean(&|f| f.tau),
        kappa: mean(&|f| f.kappa),
        source: mean(&|f| f.source),
    };
    Some(reaching(whole, t))
}

/// A front that ends at `t` instead, a little before or behind.
fn reaching(f: Front, t: f64) -> Front {
    let more = t - f.t;
    let glow = bands(|b| (f.glow[b] + more * f.tau[b] * f.source[b]).max(0.0));
    Front { t, glow, tau: bands(|b| f.tau[b] * (-f.kappa[b] * more).exp()), ..f }
}

fn most(x: Bands) -> f64 {
    x[0].max(x[1]).max(x[2])
}

/// True where two radiances differ by more than a share of what both bring, in any band.
fn differ(a: Bands, b: Bands, share: f64) -> bool {
    far_apart(a, b, share, bands(|k| a[k] + b[k]))
}

/// True where two radiances differ by more than a share of the mean of two that sum to `both`, in any band.
fn far_apart(a: Bands, b: Bands, share: f64, both: Bands) -> bool {
    let all: f64 = both.iter().sum::<f64>() / 6.0;
    (0..3).any(|k| (a[k] - b[k]).abs() > share * (0.35 * both[k] + 0.3 * all))
}
