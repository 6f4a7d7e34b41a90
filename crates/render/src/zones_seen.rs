//! Which zone every pixel sees, and false colours of zones with clean edges.
//!
//! A ray ends at the first side of a surface that is a zone, or, where panes are wanted, at the first pane. Sides that are none (backs of
//! one-sided surfaces) are looked through, and so is the medium: a room shows its inside from without. On a plane x_k = c that cuts the
//! medium, where one is wanted, rays end at the voxel zones.
//!
//! Colours are found zone by zone and mean colours are taken, not means of values: between 400 and 1200 K there is no 800 K. Where two
//! pixels side by side differ in zone, surface or direction, both have a grid of 4 × 4 rays. Where neighbours half a pixel apart lie on
//! different surfaces, face ways more than 20° apart, or one stands behind the other (n·d > sin 20° |d|, d from one to the other), a thin
//! line parts them, so that walls of one temperature can be told apart.
//!
//! Every pixel is a function of its place alone; strips of rows bound the memory and change nothing.

use crate::camera::{Pinhole, subpixel};
use crate::march::patch_tiles;
use rayon::prelude::*;
use std::ops::Range;
use zonal_math::Vec3;
use zonal_scene::{Camera, Lens, Plate, Progress, Solution};
use zonal_transport::sheets::{Sheets, of_panes};
use zonal_transport::{Hit, Transport};

/// Rays along a side of a pixel at an edge.
const SIDE: usize = 4;
const RAYS: usize = SIDE * SIDE;
/// Rays on either side that a line reaches: half a pixel.
const REACH: isize = SIDE as isize / 2;
/// Rows of a strip, and its pixels at most.
const STRIP: usize = 64;
const STRIP_PIXELS: usize = 1 << 18;
const COS_CREASE: f64 = 0.939_692_620_785_908_4; // cos 20°
const SIN_CREASE: f64 = 0.342_020_143_325_668_7;
/// A line is dark on light colours, and light on dark ones.
const INK: f32 = 0.62;
const DARK: f32 = 0.06;
const CHALK: f32 = 0.22;

/// What a camera sees of a solution's zones.
pub struct ZonesSeen<'a> {
    solution: &'a Solution,
    transport: Transport<'a>,
    patches: Sheets,
    /// The number of each pane's first plate, and the pieces of all panes, where panes are wanted.
    panes: Option<(Vec<usize>, Sheets)>,
    /// Axis and place, m, of a plane on which the medium is seen.
    slice: Option<(usize, f64)>,
    pinhole: Pinhole,
    width: usize,
    height: usize,
}

/// Where a ray ends: on a zone with its point, direction and surface (or pane, counted on), or nowhere.
#[derive(Clone, Copy)]
struct Spot {
    zone: u32,
    surface: u32,
    normal: Vec3,
    point: Vec3,
}

const NOTHING: Spot = Spot { zone: u32::MAX, surface: u32::MAX, normal: Vec3::ZERO, point: Vec3::ZERO };

impl Spot {
    fn zone(&self) -> Option<usize> {
        (self.zone != u32::MAX).then_some(self.zone as usize)
    }
    /// True where a line parts two places side by side.
    fn parted(&self, other: &Spot) -> bool {
        if self.surface != other.surface {
            return true;
        }
        let way = other.point - self.point;
        let steep = |n: Vec3| n.dot(way).abs() > SIN_CREASE * way.length();
        self.zone().is_some()
            && (self.normal.dot(other.normal) < COS_CREASE || steep(self.normal) && steep(other.normal))
    }
    fn differs(&self, other: &Spot) -> bool {
        self.zone != other.zone || self.parted(other)
    }
}

impl<'a> ZonesSeen<'a> {
    /// Ready to look, through a pinhole; panes are looked through unless they are wanted.
    pub fn new(
        solution: &'a Solution,
        camera: &Camera,
        (width, height): (usize, usize),
        panes: bool,
    ) -> ZonesSeen<'a> {
        let scene = &solution.scene;
        let sheets: Vec<Plate> = scene.facets().iter().flat_map(|f| [f.plate, f.plate]).collect();
        let tiles = patch_tiles(solution);
        let pinhole = Camera { lens: Lens::default(), ..camera.clone() };
        ZonesSeen {
            solution,
            transport: Transport::new(scene),
            patches: Sheets::new(&sheets, tiles.iter().map(|t| (&t.plate, t.sheet))),
            panes: panes.then(|| of_panes(scene, &solution.zones)),
            slice: None,
            pinhole: Pinhole::new(&pinhole, width, height),
            width,
            height,
        }
    }

    /// The same with the voxel zones where the plane at `place` (m) across an axis cuts the medium; between two cells it shows the upper one.
    pub fn sliced(mut self, axis: usize, place: f64) -> ZonesSeen<'a> {
        self.slice = Some((axis, place));
        self
    }

    /// The zone in the middle of every pixel, row by row, row 0 on top; `None` where there is nothing.
    pub fn zones(&self, progress: &dyn Progress) -> Vec<Option<u32>> {
        progress.begin("look", self.height as u64);
        let row = |y: usize| {
            let row: Vec<_> = (0..self.width).map(|x| self.middle(x, y).zone().map(|z| z as u32)).collect();
            progress.advance(1);
            row
        };
        let rows: Vec<Vec<Option<u32>>> = (0..self.height).into_par_iter().map(row).collect();
        progress.end();
        rows.into_iter().flatten().collect()
    }

    /// The picture, linear colours row by row, of zones that have the colours `colour`; `None` is the background.
    pub fn coloured(
        &self,
        colour: &(dyn Fn(Option<usize>) -> [f32; 3] + Sync),
        progress: &dyn Progress,
    ) -> Vec<[f32; 3]> {
        progress.begin("render", self.height as u64);
        let mut out = Vec::with_capacity(self.width * self.height);
        let step = (STRIP_PIXELS / self.width.max(1)).clamp(1, STRIP);
        for first in (0..self.height).step_by(step) {
            let rows = first..(first + step).min(self.height);
            let strip = Strip::new(self, rows.clone());
            let row =
                |y: usize| -> Vec<[f32; 3]> { (0..self.width).map(|x| strip.pixel(x, y, colour)).collect() };
            let drawn: Vec<Vec<[f32; 3]>> = rows.clone().into_par_iter().map(row).collect();
            out.extend(drawn.into_iter().flatten());
            progress.advance(rows.len() as u64);
        }
        progress.end();
        out
    }

    fn middle(&self, x: usize, y: usize) -> Spot {
        self.spot(x, y, [0.5; 2])
    }

    fn spot(&self, x: usize, y: usize, [dx, dy]: [f64; 2]) -> Spot {
        let at = [(x as f64 + dx) / self.width as f64, (y as f64 + dy) / self.height as f64];
        self.first(self.pinhole.origin, self.pinhole.direction(at[0], at[1]))
    }

    /// Where a ray ends.
    fn first(&self, origin: Vec3, dir: Vec3) -> Spot {
        let (transport, zones) = (&self.transport, &self.solution.zones);
        let far = transport.beyond(origin, dir);
        let mut found = transport.nearest(origin, dir, 0.0, f64::INFINITY).map(|h| (h, self.patch(&h)));
        if let Some((_, None)) = found {
            // Behind a side that is no zone; another facet may lie on it.
            let mut seen: Vec<Hit> = Vec::new();
            transport.facet_crossings(origin, far, &mut |h| seen.push(h));
            seen.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.facet.cmp(&b.facet)));
            found = seen.iter().find_map(|h| Some((*h, Some(self.patch(h)?))));
        }
        let found = found.and_then(|(h, patch)| Some((h, patch?)));
        let cut = self.cut(origin, dir).filter(|c| found.is_none_or(|(h, _)| c.0 <= h.t));
        let reach = cut.as_ref().map(|c| c.0).or(found.map(|(h, _)| h.t));
        let end = reach.map_or(far, |t| origin + dir * t);
        if let Some(spot) = self.pane(origin, dir, end).or(cut.map(|c| c.1)) {
            return spot;
        }
        found.map_or(NOTHING, |(_, i)| {
            let p = &zones.patches[i as usize];
            Spot { zone: i, surface: p.surface as u32, normal: p.normal, point: end }
        })
    }

    /// The patch of the side of a facet that is met.
    fn patch(&self, hit: &Hit) -> Option<u32> {
        self.patches.find(2 * hit.facet + usize::from(!hit.front), [hit.u, hit.v])
    }

    /// Where a ray meets the plane in the medium, and its distance, m.
    fn cut(&self, origin: Vec3, dir: Vec3) -> Option<(f64, Spot)> {
        let ((axis, place), map) = (self.slice?, self.solution.scene.voxmap()?);
        let t = (place - origin[axis]) / dir[axis];
        if !(t > 0.0 && t.is_finite()) {
            return None;
        }
        let mut point = (origin + dir * t).array();
        point[axis] = place;
        let point = Vec3::from_array(point);
        let zones = &self.solution.zones;
        let zone = self.transport.zone_in(zones, map.index(map.cell_at(point)?), point)?;
        let normal = Vec3::from_array(std::array::from_fn(|k| f64::from(u8::from(k == axis))));
        Some((t, Spot { zone: (zones.voxel_offset() + zone) as u32, surface: u32::MAX - 1, normal, point }))
    }

    /// The first pane on the way.
    fn pane(&self, origin: Vec3, dir: Vec3, end: Vec3) -> Option<Spot> {
        let (first, sheets) = self.panes.as_ref()?;
        let (scene, zones) = (&self.solution.scene, &self.solution.zones);
        let mut nearest = None;
        self.transport.pane_crossings(origin, end, &mut |h| nearest = nearest.or(Some(h)));
        let hit = nearest?;
        let point = origin + dir * hit.t;
        let plate = &scene.panes()[hit.pane].plates[hit.plate];
        let piece = sheets.find(first[hit.pane] + hit.plate, plate.parameters(point))?;
        let normal = zones.panes[piece as usize].normal;
        let surface = (scene.surfaces().len() + hit.pane) as u32;
        Some(Spot { zone: zones.pane_offset() as u32 + piece, surface, normal, point })
    }
}

/// Some rows, and one more on either side.
struct Strip {
    width: usize,
    first: usize,
    /// Middles of pixels, of one row more still.
    middles: Vec<Spot>,
    /// Grids of rays, where there are.
    grids: Vec<Option<Box<[Spot; RAYS]>>>,
    /// Rows of the grids.
    rows: Range<usize>,
}

impl Strip {
    fn new(seen: &ZonesSeen, rows: Range<usize>) -> Strip {
        let wider = |r: &Range<usize>| r.start.saturating_sub(1)..(r.end + 1).min(seen.height);
        let rows = wider(&rows);
        let all = wider(&rows);
        let middles: Vec<Vec<Spot>> = all
            .clone()
            .into_par_iter()
            .map(|y| (0..seen.width).map(|x| seen.middle(x, y)).collect())
            .collect();
        let mut strip = Strip {
            width: seen.width,
            first: all.start,
            middles: middles.into_iter().flatten().collect(),
            grids: Vec::new(),
            rows: rows.clone(),
        };
        let grid = |x: usize, y: usize| {
            let at = |i: usize| seen.spot(x, y, subpixel(i, RAYS));
            strip.is_edge(x, y, &all).then(|| Box::new(std::array::from_fn(at)))
        };
        let grids: Vec<Vec<_>> =
            rows.into_par_iter().map(|y| (0..seen.width).map(|x| grid(x, y)).collect()).collect();
        strip.grids = grids.into_iter().flatten().collect();
        strip
    }

    fn dot(&self, x: usize, y: usize) -> &Spot {
        &self.middles[(y - self.first) * self.width + x]
    }

    fn is_edge(&self, x: usize, y: usize, rows: &Range<usize>) -> bool {
        let ys = y.saturating_sub(1).max(rows.start)..(y + 2).min(rows.end);
        let xs = x.saturating_sub(1)..(x + 2).min(self.width);
        let own = self.dot(x, y);
        ys.flat_map(|v| xs.clone().map(move |u| (u, v))).any(|(u, v)| own.differs(self.dot(u, v)))
    }

    /// The grid of a pixel.
    fn grid(&self, x: usize, y: usize) -> Option<&[Spot; RAYS]> {
        self.grids[(y - self.rows.start) * self.width + x].as_deref()
    }

    /// The ray of column `i` and row `j` of all rays; of a pixel without a grid the one in its middle. `None` beyond the picture.
    fn ray(&self, i: isize, j: isize) -> Option<&Spot> {
        let cell = |i: isize| (i >= 0).then_some((i as usize / SIDE, i as usize % SIDE));
        let ((x, a), (y, b)) = (cell(i)?, cell(j)?);
        if x >= self.width || !self.rows.contains(&y) {
            return None;
        }
        Some(self.grid(x, y).map_or_else(|| self.dot(x, y), |grid| &grid[b * SIDE + a]))
    }

    fn pixel(&self, x: usize, y: usize, colour: &(dyn Fn(Option<usize>) -> [f32; 3] + Sync)) -> [f32; 3] {
        let Some(grid) = self.grid(x, y) else {
            return colour(self.dot(x, y).zone());
        };
        let mut sum = [0.0; 3];
        for (k, spot) in grid.iter().enumerate() {
            let (i, j) = ((x * SIDE + k % SIDE) as isize, (y * SIDE + k / SIDE) as isize);
            let around = [(-REACH, 0), (REACH, 0), (0, -REACH), (0, REACH)];
            let line = around.iter().any(|(a, b)| self.ray(i + a, j + b).is_some_and(|o| spot.parted(o)));
            let c = colour(spot.zone());
            let c = if line { lined(c) } else { c };
            (0..3).for_each(|b| sum[b] += c[b] / RAYS as f32);
        }
        sum
    }
}

/// A line on a colour.
fn lined(c: [f32; 3]) -> [f32; 3] {
    let luminance = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    c.map(|x| if luminance < DARK { x + CHALK * (1.0 - x) } else { x * (1.0 - INK) })
}
