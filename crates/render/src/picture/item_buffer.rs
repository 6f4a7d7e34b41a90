//! Item buffer: the zone that every pixel sees (Weghorst, Hooper & Greenberg, 1984), and false colours of zones with sharp edges.
//!
//! A ray ends at the first surface side that is a zone, or, where panes are opaque, at the first pane. Sides without a zone (backs of
//! one-sided surfaces) and the medium are transparent, so that a closed box shows its inside from without. On an optional plane x_k = c
//! that cuts the medium, rays end at the voxel zones.
//!
//! Colours are averaged, not values: a pixel between zones of 400 and 1200 K does not show 800 K. Where two neighbouring pixels differ in
//! zone, surface or direction, both have a grid of 4 × 4 rays. Where rays half a pixel apart lie on different surfaces, on faces more
//! than 20° apart, or one behind the other (n·d > sin 20° |d|, d from one to the other), a thin line separates them, so that walls of
//! one temperature remain distinguishable. Cost: one ray per pixel, 16 at edges.
//!
//! Every pixel is a function of its position alone; strips of rows bound the memory and change nothing.

use crate::image::pixels_of_rows;
use crate::picture::camera::{PerspectiveCamera, subpixel};
use crate::view_ray::ViewRay;
use std::ops::Range;
use zonal_math::Vec3;
use zonal_scene::{Camera, Lens, NoProgress, Progress, Solution};
use zonal_transport::patch_locator::{PatchLocator, facet_side_locator, pane_piece_locator};
use zonal_transport::{Hit, Transport};

/// Rays along a side of a pixel at an edge, and in all.
const RAYS_PER_SIDE: usize = 4;
const RAYS_PER_EDGE_PIXEL: usize = RAYS_PER_SIDE * RAYS_PER_SIDE;
/// Half width of a line, rays: half a pixel.
const LINE_HALF_WIDTH: isize = RAYS_PER_SIDE as isize / 2;
/// Largest number of rows of a strip, and of its pixels.
const MAX_STRIP_ROWS: usize = 64;
const MAX_STRIP_PIXELS: usize = 1 << 18;
/// Cosine and sine of the angle of a crease, 20°.
const COS_CREASE: f64 = 0.939_692_620_785_908_4;
const SIN_CREASE: f64 = 0.342_020_143_325_668_7;

// Contrast of the lines between surfaces: dark on light colours, and light on dark ones.

/// Luminance below which a colour is dark.
const DARK_LUMINANCE: f32 = 0.06;
/// Share by which a line darkens a light colour.
const DARKENING: f32 = 0.62;
/// Share by which a line lightens a dark colour.
const LIGHTENING: f32 = 0.22;

/// Visibility of panes in an item buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PaneVisibility {
    /// Rays pass through panes.
    Transparent,
    /// Rays end at the first pane.
    Opaque,
}

/// The zones of a solution that a camera sees, pixel by pixel.
///
/// ```
/// use zonal_render::{ItemBuffer, PaneVisibility};
/// # use zonal_math::{Vec3, vec3};
/// # use zonal_scene::{
/// #     Bands, Camera, Facet, Fields, NoProgress, Plate, Report, Scene, SceneParts, Sides, Solution,
/// #     Surface, VoxelGrid,
/// # };
/// # use zonal_transport::{Transport, build_zones};
/// # let wall = Surface {
/// #     name: "wall".into(),
/// #     reflectance: Bands::ZERO,
/// #     emission: Bands::ONE,
/// #     sides: Sides::Both,
/// #     ..Surface::default()
/// # };
/// # let plate = Plate::parallelogram(vec3(-9.0, 2.0, -9.0), vec3(18.0, 0.0, 0.0), vec3(0.0, 0.0, 18.0));
/// # let wall_facet = Facet { surface: 0, plate, uv: [[0.0; 2]; 3] };
/// # let mut grid = VoxelGrid::new(vec3(-1.0, 0.0, -1.0), vec3(1.0, 1.0, 1.0), [2, 2, 2]).unwrap();
/// # (0..8).for_each(|i| grid.set(i, Bands::splat(0.5), Bands::ZERO, Bands::ZERO, Bands::ZERO));
/// # let scene = Scene::new(SceneParts {
/// #     surfaces: vec![wall],
/// #     facets: vec![wall_facet],
/// #     voxel_grid: Some(grid.seal().unwrap()),
/// #     ..SceneParts::default()
/// # })
/// # .unwrap();
/// # let zones = build_zones(&scene, &Transport::new(&scene)).unwrap();
/// # let emission: Vec<Bands> = (0..zones.len()).map(|i| zones.emission(i)).collect();
/// # let zero = vec![Bands::ZERO; zones.len()];
/// # let mut fields = Fields::default();
/// # (fields.radiosity, fields.incident) = (emission, zero.clone());
/// # (fields.direct, fields.error) = (zero.clone(), zero);
/// # let (groups, report) = (Vec::new(), Report::default());
/// # let (scene_hash, version) = (String::new(), String::new());
/// # let solution = Solution { scene, zones, fields, groups, report, further_blocks: Vec::new(), scene_hash, version };
/// let camera = Camera::look_at([0.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
/// let items = ItemBuffer::new(&solution, &camera, 8, 6, PaneVisibility::Opaque);
/// let zones = items.zones(&NoProgress);
/// assert!(zones.iter().all(|z| z.is_some_and(|z| (z as usize) < solution.zones.patches.len())));
/// ```
pub struct ItemBuffer<'a> {
    solution: &'a Solution,
    transport: Transport<'a>,
    patches: PatchLocator,
    /// The index of each pane's first plate, and the pieces of all panes, where panes are opaque.
    panes: Option<(Vec<usize>, PatchLocator)>,
    /// Axis and coordinate, m, of a plane on which the medium is seen.
    slice: Option<(usize, f64)>,
    camera: PerspectiveCamera,
    width: usize,
    height: usize,
}

/// The zone at which a ray ends, with its point, normal and surface (panes are counted after the surfaces).
#[derive(Clone, Copy)]
struct SeenItem {
    zone: u32,
    surface: u32,
    normal: Vec3,
    point: Vec3,
}

/// The item of a ray that meets nothing.
const NO_ITEM: SeenItem =
    SeenItem { zone: u32::MAX, surface: u32::MAX, normal: Vec3::ZERO, point: Vec3::ZERO };

impl SeenItem {
    fn zone(&self) -> Option<usize> {
        (self.zone != u32::MAX).then_some(self.zone as usize)
    }
    /// True where a line separates two neighbouring points.
    fn is_separated_from(&self, other: &SeenItem) -> bool {
        if self.surface != other.surface {
            return true;
        }
        let offset = other.point - self.point;
        let steep = |n: Vec3| n.dot(offset).abs() > SIN_CREASE * offset.length();
        self.zone().is_some()
            && (self.normal.dot(other.normal) < COS_CREASE || steep(self.normal) && steep(other.normal))
    }
    fn differs(&self, other: &SeenItem) -> bool {
        self.zone != other.zone || self.is_separated_from(other)
    }
}

impl<'a> ItemBuffer<'a> {
    /// The item buffer of a camera, as a pinhole, for a picture of `width` × `height` pixels.
    pub fn new(
        solution: &'a Solution,
        camera: &Camera,
        width: usize,
        height: usize,
        panes: PaneVisibility,
    ) -> ItemBuffer<'a> {
        let scene = &solution.scene;
        let pinhole = Camera { lens: Lens::default(), ..camera.clone() };
        ItemBuffer {
            solution,
            transport: Transport::new(scene),
            patches: facet_side_locator(scene, &solution.zones),
            panes: (panes == PaneVisibility::Opaque).then(|| pane_piece_locator(scene, &solution.zones)),
            slice: None,
            camera: PerspectiveCamera::new(&pinhole, width, height),
            width,
            height,
        }
    }

    /// The same with the voxel zones where the plane at `coordinate` (m) on `axis` cuts the medium; between two cells it shows the
    /// upper one.
    pub fn with_slice(mut self, axis: usize, coordinate: f64) -> ItemBuffer<'a> {
        self.slice = Some((axis, coordinate));
        self
    }

    /// The zone in the centre of every pixel, row by row, row 0 on top; `None` where there is none.
    pub fn zones(&self, progress: &dyn Progress) -> Vec<Option<u32>> {
        progress.begin("visible zones", self.height as u64);
        let zone = |x: usize, y: usize| self.centre_item(x, y).zone().map(|z| z as u32);
        let zones = pixels_of_rows(0..self.height, self.width, progress, zone);
        progress.end();
        zones
    }

    /// The picture in false colours, linear, row by row; `colour` has the colour of each zone, for `None` that of the background.
    pub fn false_colours(
        &self,
        colour: &(dyn Fn(Option<usize>) -> [f32; 3] + Sync),
        progress: &dyn Progress,
    ) -> Vec<[f32; 3]> {
        progress.begin("render", self.height as u64);
        let mut out = Vec::with_capacity(self.width * self.height);
        let step = (MAX_STRIP_PIXELS / self.width.max(1)).clamp(1, MAX_STRIP_ROWS);
        for first in (0..self.height).step_by(step) {
            let rows = first..(first + step).min(self.height);
            let strip = ItemStrip::new(self, rows.clone());
            out.extend(pixels_of_rows(rows, self.width, progress, |x, y| strip.pixel(x, y, colour)));
        }
        progress.end();
        out
    }

    fn centre_item(&self, x: usize, y: usize) -> SeenItem {
        self.item(x, y, [0.5; 2])
    }

    fn item(&self, x: usize, y: usize, [dx, dy]: [f64; 2]) -> SeenItem {
        let at = [(x as f64 + dx) / self.width as f64, (y as f64 + dy) / self.height as f64];
        self.trace(ViewRay { origin: self.camera.origin, dir: self.camera.direction(at[0], at[1]) })
    }

    /// Traces a ray to its item.
    fn trace(&self, ray: ViewRay) -> SeenItem {
        let ViewRay { origin, dir } = ray;
        let (transport, zones) = (&self.transport, &self.solution.zones);
        let far = transport.exterior_point(origin, dir);
        let mut found = transport.closest_hit(origin, dir, 0.0, f64::INFINITY).map(|h| (h, self.patch(&h)));
        if let Some((_, None)) = found {
            // Look behind a side without a zone; another facet may lie on it.
            let mut seen: Vec<Hit> = Vec::new();
            transport.facet_crossings(origin, far, &mut |h| seen.push(h));
            seen.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.facet.cmp(&b.facet)));
            found = seen.iter().find_map(|h| Some((*h, Some(self.patch(h)?))));
        }
        let found = found.and_then(|(h, patch)| Some((h, patch?)));
        // Cut the ray short at the slice and at panes.
        let cut = self.slice_item(ray).filter(|c| found.is_none_or(|(h, _)| c.0 <= h.t));
        let reach = cut.as_ref().map(|c| c.0).or(found.map(|(h, _)| h.t));
        let end = reach.map_or(far, |t| origin + dir * t);
        if let Some(item) = self.pane_item(ray, end).or(cut.map(|c| c.1)) {
            return item;
        }
        found.map_or(NO_ITEM, |(_, i)| {
            let p = &zones.patches[i as usize];
            SeenItem { zone: i, surface: p.surface as u32, normal: p.normal, point: end }
        })
    }

    /// The patch at a hit; `None` on sides without a zone.
    fn patch(&self, hit: &Hit) -> Option<u32> {
        self.patches.locate(hit.side(), [hit.u, hit.v])
    }

    /// Distance, m, and item at which a ray meets the slice of the medium.
    fn slice_item(&self, ray: ViewRay) -> Option<(f64, SeenItem)> {
        let ViewRay { origin, dir } = ray;
        let ((axis, coordinate), map) = (self.slice?, self.solution.scene.voxel_grid()?);
        let t = (coordinate - origin[axis]) / dir[axis];
        if !(t > 0.0 && t.is_finite()) {
            return None;
        }
        let mut point = (origin + dir * t).array();
        point[axis] = coordinate;
        let point = Vec3::from_array(point);
        let zones = &self.solution.zones;
        let zone = self.transport.volume_zone_at(zones, map.index(map.cell_at(point)?), point)?;
        let normal = Vec3::from_array(std::array::from_fn(|k| f64::from(u8::from(k == axis))));
        let zone = zones.voxel_index(zone) as u32;
        Some((t, SeenItem { zone, surface: u32::MAX - 1, normal, point }))
    }

    /// The first pane before `end`.
    fn pane_item(&self, ray: ViewRay, end: Vec3) -> Option<SeenItem> {
        let (first, sheets) = self.panes.as_ref()?;
        let (scene, zones) = (&self.solution.scene, &self.solution.zones);
        let mut nearest = None;
        self.transport.pane_crossings(ray.origin, end, &mut |h| nearest = nearest.or(Some(h)));
        let hit = nearest?;
        let point = ray.at(hit.t);
        let plate = &scene.panes()[hit.pane].plates[hit.plate];
        let piece = sheets.locate(first[hit.pane] + hit.plate, plate.parameters(point))?;
        let normal = zones.panes[piece as usize].normal;
        let surface = (scene.surfaces().len() + hit.pane) as u32;
        Some(SeenItem { zone: zones.pane_index(piece as usize) as u32, surface, normal, point })
    }
}

/// Rows of the picture, and one more on either side.
struct ItemStrip {
    width: usize,
    first: usize,
    /// Items in the centres of pixels, of one row more on either side.
    centres: Vec<SeenItem>,
    /// Grids of rays of the pixels at edges.
    grids: Vec<Option<Box<[SeenItem; RAYS_PER_EDGE_PIXEL]>>>,
    /// Rows of the grids.
    rows: Range<usize>,
}

impl ItemStrip {
    fn new(buffer: &ItemBuffer, rows: Range<usize>) -> ItemStrip {
        let wider = |r: &Range<usize>| r.start.saturating_sub(1)..(r.end + 1).min(buffer.height);
        let rows = wider(&rows);
        let all = wider(&rows);
        let width = buffer.width;
        let mut strip = ItemStrip {
            width,
            first: all.start,
            centres: pixels_of_rows(all.clone(), width, &NoProgress, |x, y| buffer.centre_item(x, y)),
            grids: Vec::new(),
            rows: rows.clone(),
        };
        let grid = |x: usize, y: usize| {
            let at = |i: usize| buffer.item(x, y, subpixel(i, RAYS_PER_EDGE_PIXEL));
            strip.is_edge(x, y, &all).then(|| Box::new(std::array::from_fn(at)))
        };
        strip.grids = pixels_of_rows(rows, width, &NoProgress, grid);
        strip
    }

    fn centre(&self, x: usize, y: usize) -> &SeenItem {
        &self.centres[(y - self.first) * self.width + x]
    }

    fn is_edge(&self, x: usize, y: usize, rows: &Range<usize>) -> bool {
        let ys = y.saturating_sub(1).max(rows.start)..(y + 2).min(rows.end);
        let xs = x.saturating_sub(1)..(x + 2).min(self.width);
        let own = self.centre(x, y);
        ys.flat_map(|v| xs.clone().map(move |u| (u, v))).any(|(u, v)| own.differs(self.centre(u, v)))
    }

    /// The grid of a pixel.
    fn grid(&self, x: usize, y: usize) -> Option<&[SeenItem; RAYS_PER_EDGE_PIXEL]> {
        self.grids[(y - self.rows.start) * self.width + x].as_deref()
    }

    /// The item of the ray in column `i` and row `j` of all rays; for a pixel without a grid that in its centre. `None` beyond the picture.
    fn ray_item(&self, i: isize, j: isize) -> Option<&SeenItem> {
        let cell = |i: isize| (i >= 0).then_some((i as usize / RAYS_PER_SIDE, i as usize % RAYS_PER_SIDE));
        let ((x, a), (y, b)) = (cell(i)?, cell(j)?);
        if x >= self.width || !self.rows.contains(&y) {
            return None;
        }
        Some(self.grid(x, y).map_or_else(|| self.centre(x, y), |grid| &grid[b * RAYS_PER_SIDE + a]))
    }

    fn pixel(&self, x: usize, y: usize, colour: &(dyn Fn(Option<usize>) -> [f32; 3] + Sync)) -> [f32; 3] {
        let Some(grid) = self.grid(x, y) else {
            return colour(self.centre(x, y).zone());
        };
        let mut sum = [0.0; 3];
        for (k, item) in grid.iter().enumerate() {
            let (i, j) = (
                (x * RAYS_PER_SIDE + k % RAYS_PER_SIDE) as isize,
                (y * RAYS_PER_SIDE + k / RAYS_PER_SIDE) as isize,
            );
            let h = LINE_HALF_WIDTH;
            let around = [(-h, 0), (h, 0), (0, -h), (0, h)];
            let line = around
                .iter()
                .any(|(a, b)| self.ray_item(i + a, j + b).is_some_and(|o| item.is_separated_from(o)));
            let c = colour(item.zone());
            let c = if line { line_colour(c) } else { c };
            (0..3).for_each(|b| sum[b] += c[b] / RAYS_PER_EDGE_PIXEL as f32);
        }
        sum
    }
}

/// The colour of a line on a colour.
fn line_colour(c: [f32; 3]) -> [f32; 3] {
    let luminance = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    c.map(|x| if luminance < DARK_LUMINANCE { x + LIGHTENING * (1.0 - x) } else { x * (1.0 - DARKENING) })
}
