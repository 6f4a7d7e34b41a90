//! Pictures from a solution.
//!
//! A solution does not depend on the view: solve once, look from anywhere. Along each camera ray the indirect light of the zones is
//! interpolated so that neither facets nor cubes show, and direct light is evaluated anew at the surface point and along the
//! ray, so that shadows and shafts are crisp. The renderer reads a [`Solution`] and asks rays of `zonal-transport`; it knows no
//! solver. It gives linear radiance; exposure and files are `zonal-io`'s.
//!
//! | module | what |
//! |---|---|
//! | [`bake`] | the solution on triangles, for viewers and other engines |
//! | `adaptive` | rays where the picture needs them |
//! | [`bloom()`] | light that a lens scatters over the picture |
//! | `calm` | noise of patches, as far as the solution tells of it, taken out |
//! | `camera` | pinhole, thin lens and subpixels |
//! | `columns` | what a sun reaches, by columns along its light |
//! | `crowd` | light of lamps of many facets in the medium |
//! | `towards` | optical depth towards a distant light, everywhere |
//! | `fit` | from zone means to node values |
//! | `gather` | indirect light of a surface point by rays |
//! | `lazy` | values made when first asked for |
//! | `patch_field` | a smooth field on surfaces and panes |
//! | `voxel_field` | a smooth field in the medium |
//! | `path` | a ray in pieces, and the integral over one |
//! | `shadow` | exact lit intervals of a ray |
//! | `shafts` | direct light scattered along a ray |
//! | `lamplight` | the same for small lamps, without noise beside them |
//! | `march` | one ray, everything together |
//! | `zones_seen` | which zone every pixel sees, for false colours |
//!
//! Rows are computed in parallel and put together in order; every pixel depends on its own number alone, so the bits do not
//! depend on the number of threads.

pub mod bake;

mod adaptive;
mod bloom;
mod calm;
mod camera;
mod columns;
mod crowd;
mod fit;
mod gather;
mod lamplight;
mod lazy;
mod march;
mod patch_field;
mod path;
mod shadow;
mod shafts;
mod towards;
mod voxel_field;
mod zones_seen;

pub use bloom::bloom;
pub use zones_seen::ZonesSeen;

use adaptive::Adaptive;
use camera::{Pinhole, subpixel};
use march::{Draw, View};
use rayon::prelude::*;
use zonal_math::sequence;
use zonal_scene::{Camera, Lens, Progress, Solution};
use zonal_transport::Transport;

/// Size and quality of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// Pixels across; 640.
    pub width: usize,
    /// Pixels down; 480.
    pub height: usize,
    /// Rays of every pixel, on a regular grid where it is a square number; 0: one to nine, where neighbours differ; 4.
    pub samples: usize,
    /// Points of each extended light a ray: as many of suns and emitters for surfaces, four times as many of skies; for the medium
    /// one of a sun, half as many of skies and emitters; 4.
    pub light_samples: usize,
    /// Rays that gather the indirect light of each surface point seen; 0: that of the patches is interpolated; 0.
    pub gather: usize,
}

impl Default for RenderOptions {
    fn default() -> Self {
        RenderOptions { width: 640, height: 480, samples: 4, light_samples: 4, gather: 0 }
    }
}

/// A linear picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Radiance, W/(m² sr) a band, row by row, row 0 on top; what is beyond single precision is its largest number.
    pub pixels: Vec<[f32; 3]>,
}

/// Rays of a pixel behind a lens where their number is left open.
const LENS_RAYS: usize = 64;

/// Renders what the camera sees of the solution. The same bits for any number of threads.
pub fn render(
    solution: &Solution,
    camera: &Camera,
    options: &RenderOptions,
    progress: &dyn Progress,
) -> Image {
    let mut out = None;
    let cameras = std::slice::from_ref(camera);
    let Ok(()) = render_each(solution, cameras, options, progress, |_, image| {
        out = Some(image);
        Ok::<(), std::convert::Infallible>(())
    });
    out.unwrap_or(Image { width: 0, height: 0, pixels: Vec::new() })
}

/// Renders what each of the cameras sees, and gives number and picture to `take`, which may end it. What belongs to the solution is
/// prepared once; the pictures are those of [`render`].
pub fn render_each<E>(
    solution: &Solution,
    cameras: &[Camera],
    options: &RenderOptions,
    progress: &dyn Progress,
    mut take: impl FnMut(usize, Image) -> Result<(), E>,
) -> Result<(), E> {
    let transport = Transport::new(&solution.scene);
    let view = View::new(solution, &transport).gathering(options.gather);
    let view = if options.samples == 0 { view.roughly() } else { view };
    for (i, camera) in cameras.iter().enumerate() {
        let focus = camera.lens.focus.or_else(|| in_the_middle(&transport, camera));
        let camera = Camera { lens: Lens { focus, ..camera.lens }, ..camera.clone() };
        let pinhole = Pinhole::new(&camera, options.width, options.height);
        let mut image = picture(&view, &pinhole, options, progress);
        // Slopes in thick voxels may leave less than nothing, which is no radiance.
        image.pixels.iter_mut().flatten().filter(|x| **x < 0.0).for_each(|x| *x = 0.0);
        take(i, image)?;
    }
    Ok(())
}

/// How far away, m, is what each camera sees in its middle, a surface or a pane; none where there is nothing.
pub fn middle_distances(solution: &Solution, cameras: &[Camera]) -> Vec<Option<f64>> {
    let transport = Transport::new(&solution.scene);
    cameras.iter().map(|c| in_the_middle(&transport, c)).collect()
}

fn in_the_middle(transport: &Transport, camera: &Camera) -> Option<f64> {
    let dir = (camera.target - camera.origin).normalized();
    let wall = transport.nearest(camera.origin, dir, 0.0, f64::INFINITY).map(|h| h.t);
    let end = wall.map_or_else(|| transport.beyond(camera.origin, dir), |t| camera.origin + dir * t);
    let mut pane = None;
    transport.pane_crossings(camera.origin, end, &mut |h| pane = pane.or(Some(h.t)));
    pane.or(wall)
}

fn picture(view: &View, pinhole: &Pinhole, options: &RenderOptions, progress: &dyn Progress) -> Image {
    let (width, height) = (options.width, options.height);
    progress.begin("render", height as u64);
    let adaptive = options.samples == 0;
    if adaptive && !pinhole.has_lens() && width * height > 0 {
        let pixels = Adaptive::new(view, pinhole, options).draw(progress);
        progress.end();
        return Image { width, height, pixels };
    }
    // Behind a lens no two pixels look from one place.
    let options =
        &RenderOptions { samples: if adaptive { LENS_RAYS } else { options.samples }, ..options.clone() };
    let rows: Vec<Vec<[f32; 3]>> = (0..height)
        .into_par_iter()
        .map(|y| {
            let row = (0..width).map(|x| pixel(view, pinhole, options, x, y)).collect();
            progress.advance(1);
            row
        })
        .collect();
    progress.end();
    Image { width, height, pixels: rows.into_iter().flatten().collect() }
}

fn pixel(view: &View, pinhole: &Pinhole, o: &RenderOptions, x: usize, y: usize) -> [f32; 3] {
    let (n, count) = (o.samples.max(1), o.light_samples.max(1));
    let shift = pixel_shift(x, y);
    let mut sum = [0.0; 3];
    for i in 0..n {
        let [dx, dy] = subpixel(i, n);
        let at = [(x as f64 + dx) / o.width as f64, (y as f64 + dy) / o.height as f64];
        let (origin, dir) = pinhole.ray(at, i, [shift[1], shift[2]]);
        let draw = Draw::of_ray(i, count, shift);
        let l = view.radiance(origin, dir, draw);
        (0..3).for_each(|b| sum[b] += l[b]);
    }
    sum.map(|s| single(s / n as f64))
}

/// A radiance in single precision: at most the largest number there is in it. What is not a number stays so: `min` would hide it.
fn single(l: f64) -> f32 {
    l.clamp(f32::MIN.into(), f32::MAX.into()) as f32
}

/// Shifts of the light samples: a hash, since any lattice over the pixels shows as a weave in soft light.
fn pixel_shift(x: usize, y: usize) -> [f64; 3] {
    let seed = (x as u64) << 32 | y as u64;
    [0, 1, 2].map(|k| sequence::unit(seed.wrapping_mul(3).wrapping_add(k)))
}

#[cfg(test)]
mod lens_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_fast;
