//! Adaptive sampling of the picture with separate rays for the medium and for what lies behind it.
//!
//! A ray brings L = L_m + τ L_b: in-scattered radiance and transmittance of the medium segment before the first pane or surface, and the
//! radiance behind it. Both vary at different rates across the picture, so that they are sampled apart.
//!
//! 1. L_b at the centre of every pixel.
//! 2. L_m and τ at every fourth pixel across and down, then halfway between those, then between these. Halfway, the mean of the two or
//!    four neighbours is taken where they agree: their lengths, in optical depth, are close to each other and to its own, and L_m differs
//!    by less than a few hundredths of L. The difference of length, t − t̄, is corrected by κ and the source at the ends. Elsewhere
//!    the segment is integrated: at borders of objects and of shafts.
//! 3. Pixels that differ from one of their eight neighbours have rays in their corners, and where these differ strongly also at their
//!    edges: nine in all, those of a regular grid. Pixels with small emitters have all nine. Such a ray takes L_m and τ from its own
//!    pixel or a neighbour of about the same length.
//!
//! Every value is a function of the pixel and its neighbours alone; strips of rows bound the memory and change nothing. Cost: one surface
//! ray per pixel, a sixteenth to one medium segment a pixel, and four or eight more rays at edges.

use crate::image::{pixels_of_rows, to_pixel};
use crate::integrator::medium_segment::MediumSegment;
use crate::integrator::radiance::Integrator;
use crate::integrator::ray_sampler::{RaySampler, pixel_shift};
use crate::options::{MAX_SUN_STEPS_ADAPTIVE, RenderOptions};
use crate::picture::camera::{PerspectiveCamera, subpixel};
use crate::view_ray::ViewRay;
use rayon::prelude::*;
use std::collections::HashSet;
use zonal_scene::{Band, Bands, Facet, NoProgress, Plate, Progress};

/// Largest number of rays of a pixel, on a square grid that contains the pixel's centre.
const RAYS: usize = 9;
/// Index of the ray in the centre, and of those in the corners and at the edges.
const CENTRE_RAY: usize = 4;
const CORNER_RAYS: [usize; 4] = [0, 2, 6, 8];
const EDGE_RAYS: [usize; 4] = [1, 3, 5, 7];

// Density and thresholds of adaptive sampling. The thresholds hold the mean difference from pictures of nine rays per pixel below 1 %
// in blocks of 8 × 8 pixels (`approximation_tests`).

/// Spacing of the first medium segments, pixels.
const SEGMENT_SPACING: usize = 4;
/// Rows of a strip.
const STRIP_ROWS: usize = 128;
/// Number of times that suns and emitters are sampled along a segment of the medium.
const MEDIUM_REPEATS: usize = 4;
/// Largest difference of L_m between neighbouring segments that agree, as a share of L.
const MAX_INSCATTERED_DIFFERENCE: f64 = 0.05;
/// Largest difference of their lengths, in optical depth …
const MAX_DEPTH_DIFFERENCE: f64 = 0.06;
/// … and as a share of the length.
const MAX_LENGTH_DIFFERENCE: f64 = 0.2;
/// Largest difference between the length of a ray and the mean of its neighbours, in optical depth …
const MAX_OWN_DEPTH_DIFFERENCE: f64 = 0.01;
/// … and as a share of the length.
const MAX_OWN_LENGTH_DIFFERENCE: f64 = 0.05;
/// Contrast of neighbouring pixels above which a pixel has corner rays.
const CORNER_CONTRAST: f64 = 0.06;
/// Contrast of the rays of a pixel above which it has edge rays.
const EDGE_CONTRAST: f64 = 0.2;
/// Width, pixels, up to which an emitting plate is small.
const MAX_SMALL_EMITTER_WIDTH: f64 = 4.0;

/// A picture that is sampled adaptively.
pub(crate) struct AdaptiveSampler<'a> {
    integrator: &'a Integrator<'a>,
    camera: &'a PerspectiveCamera,
    options: &'a RenderOptions,
    /// Pixels that contain a small emitter.
    emitter_pixels: HashSet<(usize, usize)>,
}

/// The end of the medium segment in the centre of a pixel.
#[derive(Clone, Copy)]
struct PixelCentre {
    /// Length of the segment, m.
    length: f64,
    /// Radiance behind it, W/(m² sr).
    behind: Bands,
}

/// Rows of the picture with a margin up to the next rows and columns of the grid of segments.
struct PixelStrip {
    first: usize,
    width: usize,
    centres: Vec<PixelCentre>,
    segments: Vec<Option<MediumSegment>>,
}

impl PixelStrip {
    fn index(&self, x: usize, y: usize) -> usize {
        (y - self.first) * self.width + x
    }
    /// True where two pixels of these indices need more rays: the radiance behind the medium differs, or both the depth and the radiance seen.
    fn differ(&self, i: usize, j: usize) -> bool {
        let (Some(f), Some(g)) = (self.segments[i], self.segments[j]) else {
            return true;
        };
        let [a, b] = [(f, i), (g, j)].map(|(f, i)| f.in_front_of(self.centres[i].behind));
        let kappa = f.end_extinction.max(g.end_extinction).max_element();
        let depth_edge = (f.length - g.length).abs() * kappa > MAX_OWN_DEPTH_DIFFERENCE
            || (f.length - g.length).abs() > MAX_OWN_LENGTH_DIFFERENCE * f.length;
        let behind = |f: &MediumSegment, i: usize| f.transmittance * self.centres[i].behind;
        let contrast = CORNER_CONTRAST;
        differ_relative_to(behind(&f, i), behind(&g, j), contrast, a + b)
            || depth_edge && differ(a, b, contrast)
    }
    /// L of a pixel.
    fn radiance(&self, x: usize, y: usize) -> Bands {
        let i = self.index(x, y);
        self.segments[i].map_or(Bands::ZERO, |f| f.in_front_of(self.centres[i].behind))
    }
}

impl<'a> AdaptiveSampler<'a> {
    /// Finds the pixels with small emitters.
    pub(crate) fn new(
        integrator: &'a Integrator<'a>,
        camera: &'a PerspectiveCamera,
        options: &'a RenderOptions,
    ) -> AdaptiveSampler<'a> {
        let mut out = AdaptiveSampler { integrator, camera, options, emitter_pixels: HashSet::new() };
        let scene = &integrator.solution().scene;
        let emits = |f: &&Facet| scene.surfaces()[f.surface].emission != Bands::ZERO;
        scene.facets().iter().filter(emits).for_each(|f| out.mark_small_emitter(&f.plate));
        out
    }

    /// Marks the pixels of an emitting plate, if they are few: rays through pixel centres might miss it.
    fn mark_small_emitter(&mut self, plate: &Plate) {
        let o = self.options;
        let (corners, n) = plate.corners();
        let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for c in &corners[..n] {
            let Some([x, y]) = self.camera.project(*c) else { return };
            let place = [x * o.width as f64, y * o.height as f64];
            (lo, hi) = ([0, 1].map(|k| lo[k].min(place[k])), [0, 1].map(|k| hi[k].max(place[k])));
        }
        if (0..2).any(|k| hi[k] - lo[k] > MAX_SMALL_EMITTER_WIDTH || hi[k] < 0.0) {
            return;
        }
        let range = |k: usize, n: usize| lo[k].max(0.0) as usize..(hi[k] as usize + 1).min(n);
        for y in range(1, o.height) {
            self.emitter_pixels.extend(range(0, o.width).map(|x| (x, y)));
        }
    }

    /// All pixels, row by row.
    pub(crate) fn render(&self, progress: &dyn Progress) -> Vec<[f32; 3]> {
        let height = self.options.height;
        let mut out = Vec::with_capacity(self.options.width * height);
        for first in (0..height).step_by(STRIP_ROWS) {
            let last = (first + STRIP_ROWS).min(height);
            let strip = self.sample_strip(first, last);
            let pixel = |x: usize, y: usize| self.pixel(&strip, x, y);
            out.extend(pixels_of_rows(first..last, self.options.width, progress, pixel));
        }
        out
    }

    /// The centres of the pixels of some rows and of their margin, with their medium segments.
    fn sample_strip(&self, first: usize, last: usize) -> PixelStrip {
        let up = |n: usize| n.div_ceil(SEGMENT_SPACING) * SEGMENT_SPACING;
        let width = up(self.options.width - 1) + 1;
        let margin = SEGMENT_SPACING;
        let (first, last) = (first.saturating_sub(margin), up(last.min(self.options.height - 1)) + 1);
        // Sample the radiance behind the medium in every pixel.
        let centres = pixels_of_rows(first..last, width, &NoProgress, |x, y| self.centre(x, y));
        let mut strip = PixelStrip { first, width, segments: vec![None; centres.len()], centres };
        // Fill the medium segments on successively finer grids.
        let mut step = SEGMENT_SPACING;
        while step > 0 {
            let rows: Vec<(usize, Vec<Option<MediumSegment>>)> = (first.next_multiple_of(step)..last)
                .into_par_iter()
                .step_by(step)
                .map(|y| (y, (0..width).step_by(step).map(|x| self.segment(&strip, x, y, step)).collect()))
                .collect();
            for (y, row) in rows {
                for (k, segment) in row.into_iter().enumerate() {
                    let i = strip.index(k * step, y);
                    strip.segments[i] = strip.segments[i].or(segment);
                }
            }
            step /= 2;
        }
        strip
    }

    /// Ray number `i` of a pixel, and its light samples.
    fn ray(&self, x: usize, y: usize, i: usize) -> (ViewRay, RaySampler) {
        let o = self.options;
        let [dx, dy] = subpixel(i, RAYS);
        let dir = self.camera.direction((x as f64 + dx) / o.width as f64, (y as f64 + dy) / o.height as f64);
        let count = o.light_samples.max(1);
        let max_sun_steps = MAX_SUN_STEPS_ADAPTIVE;
        let sampler = RaySampler { max_sun_steps, ..RaySampler::of_ray(i, count, pixel_shift(x, y)) };
        (ViewRay { origin: self.camera.origin, dir }, sampler)
    }

    fn centre(&self, x: usize, y: usize) -> PixelCentre {
        let (ray, sampler) = self.ray(x, y, CENTRE_RAY);
        let end = self.integrator.trace(ray);
        let behind = self.integrator.radiance_behind_segment(ray, &end, sampler);
        PixelCentre { length: end.segment_length(), behind }
    }

    /// The medium segment of a pixel of the grid of this step; `None` where there is one already.
    fn segment(&self, strip: &PixelStrip, x: usize, y: usize, step: usize) -> Option<MediumSegment> {
        let coarse = 2 * step;
        let length = strip.centres[strip.index(x, y)].length;
        if step < SEGMENT_SPACING {
            let side = |x: usize| [x - x % coarse, x.next_multiple_of(coarse)];
            let ([x0, x1], [y0, y1]) = (side(x), side(y));
            if x0 == x1 && y0 == y1 {
                return None;
            }
            let around = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)].map(|(x, y)| strip.index(x, y));
            if let Some(segment) = interpolate_segments(strip, around, length) {
                return Some(segment);
            }
        }
        let (ray, sampler) = self.ray(x, y, CENTRE_RAY);
        let sampler = RaySampler { medium_repeats: MEDIUM_REPEATS, ..sampler };
        Some(self.integrator.medium_segment(ray, length, sampler))
    }

    /// A pixel of the picture.
    fn pixel(&self, strip: &PixelStrip, x: usize, y: usize) -> [f32; 3] {
        let own = strip.radiance(x, y);
        let mut around = self.around(x, y).filter(|p| *p != (x, y));
        let has_emitter = self.emitter_pixels.contains(&(x, y));
        if !has_emitter && !around.any(|(u, v)| strip.differ(strip.index(x, y), strip.index(u, v))) {
            return to_pixel(own);
        }
        let (mut sum, mut count, mut range) = (own, 1.0, (own, own));
        for (k, i) in CORNER_RAYS.into_iter().chain(EDGE_RAYS).enumerate() {
            if k == CORNER_RAYS.len() && !has_emitter && !differ(range.0, range.1, EDGE_CONTRAST) {
                break;
            }
            let l = self.extra_ray(strip, x, y, i);
            (sum, count) = (sum + l, count + 1.0);
            range = (range.0.min(l), range.1.max(l));
        }
        to_pixel(sum / count)
    }

    /// Radiance of ray number `i` of a pixel; its medium segment is that of a nearby pixel if one is about as long.
    fn extra_ray(&self, strip: &PixelStrip, x: usize, y: usize, i: usize) -> Bands {
        let (ray, sampler) = self.ray(x, y, i);
        let end = self.integrator.trace(ray);
        let behind = self.integrator.radiance_behind_segment(ray, &end, sampler);
        let t = end.segment_length();
        let segments = self.around(x, y).filter_map(|(x, y)| strip.segments[strip.index(x, y)]);
        let closest = segments.map(|f| ((f.length - t).abs(), f)).min_by(|a, b| a.0.total_cmp(&b.0));
        match closest.filter(|(d, f)| {
            d * f.end_extinction.max_element() <= MAX_OWN_DEPTH_DIFFERENCE
                && *d <= MAX_OWN_LENGTH_DIFFERENCE * t
        }) {
            Some((_, f)) => f.with_end_at(t),
            None => self.integrator.medium_segment(ray, t, sampler),
        }
        .in_front_of(behind)
    }

    /// The pixel itself and its neighbours.
    fn around(&self, x: usize, y: usize) -> impl Iterator<Item = (usize, usize)> + use<> {
        let near = |x: usize, n: usize| x.saturating_sub(1)..(x + 2).min(n);
        let (xs, ys) = (near(x, self.options.width), near(y, self.options.height));
        ys.flat_map(move |y| xs.clone().map(move |x| (x, y)))
    }
}

/// The mean of the segments around, for a ray of length `t`; `None` where they do not agree.
fn interpolate_segments(strip: &PixelStrip, around: [usize; 4], t: f64) -> Option<MediumSegment> {
    let segments = around.map(|i| strip.segments[i]);
    let segments = [segments[0]?, segments[1]?, segments[2]?, segments[3]?];
    let mean = |of: &dyn Fn(&MediumSegment) -> Bands| segments.iter().map(of).sum::<Bands>() / 4.0;
    let length = segments.iter().map(|f| f.length).sum::<f64>() / 4.0;
    if !lengths_agree(&segments, length, t) || !radiances_agree(strip, around, &segments) {
        return None;
    }
    let whole = MediumSegment {
        length,
        inscattered: mean(&|f| f.inscattered),
        transmittance: mean(&|f| f.transmittance),
        end_extinction: mean(&|f| f.end_extinction),
        end_source: mean(&|f| f.end_source),
    };
    Some(whole.with_end_at(t))
}

/// True where four segments with the mean length `mean` and a ray of length `t` are about as long as each other.
fn lengths_agree(segments: &[MediumSegment; 4], mean: f64, t: f64) -> bool {
    let (lo, hi) = segments.iter().fold((t, t), |(lo, hi), f| (lo.min(f.length), hi.max(f.length)));
    let kappa = segments.iter().fold(0.0, |k: f64, f| k.max(f.end_extinction.max_element()));
    let off = (t - mean).abs();
    let differ = (hi - lo) * kappa > MAX_DEPTH_DIFFERENCE
        || hi - lo > MAX_LENGTH_DIFFERENCE * lo
        || off * kappa > MAX_OWN_DEPTH_DIFFERENCE
        || off > MAX_OWN_LENGTH_DIFFERENCE * t;
    !differ
}

/// True where the in-scattered radiances and transmittances of four segments agree in every band.
fn radiances_agree(strip: &PixelStrip, around: [usize; 4], segments: &[MediumSegment; 4]) -> bool {
    let radiances = segments.iter().zip(around).map(|(f, i)| f.in_front_of(strip.centres[i].behind));
    let seen = radiances.sum::<Bands>() / 4.0;
    let all = seen.mean();
    for b in Band::all() {
        let range = |of: &dyn Fn(&MediumSegment) -> f64| {
            let (lo, hi) =
                segments.iter().map(of).fold((f64::INFINITY, 0.0f64), |(lo, hi), x| (lo.min(x), hi.max(x)));
            hi - lo
        };
        if range(&|f| f.inscattered[b]) > MAX_INSCATTERED_DIFFERENCE * 0.5 * (seen[b] + all)
            || range(&|f| f.transmittance[b]) > MAX_DEPTH_DIFFERENCE
        {
            return false;
        }
    }
    true
}

/// True where two radiances differ by more than a share of their mean, in any band.
fn differ(a: Bands, b: Bands, share: f64) -> bool {
    differ_relative_to(a, b, share, a + b)
}

/// True where two radiances differ by more than a share of the mean of two radiances whose sum is `both`, in any band.
fn differ_relative_to(a: Bands, b: Bands, share: f64, both: Bands) -> bool {
    let all = both.sum() / (2 * Band::count()) as f64;
    Band::all().any(|k| (a[k] - b[k]).abs() > share * (0.35 * both[k] + 0.3 * all))
}
