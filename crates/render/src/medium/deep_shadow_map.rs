//! Deep shadow map of a sun with an extent: which parts of a ray it lights, and through which panes.
//!
//! With e the direction to the centre of the sun, a point x has the position (u·x, v·x) across the light and the depth z = −e·x along it.
//! For every column of a grid across the light the map stores the depth Z of the first facet and, before it, the panes with their
//! depths and transmittances (Lokovic & Veach, *Deep Shadow Maps*, SIGGRAPH 2000). A point is lit where z < Z, tinted by the panes of
//! smaller depth.
//!
//! A sun of angular radius α is seen from x in directions up to tan α off its centre. The blocker stands at a depth p: that of the
//! column's pane or first facet, or in the open of those nearby. A direction δ off the centre therefore looks up the column at the position
//! of x + δ (z − p): shadows are as soft as their casters are distant. Along a ray the map is looked up at one jittered point of each
//! step, with a δ of its own; over runs of steps of one state the integral is exact ([`super::single_scattering`]).
//!
//! Tiles of the map are built on first use. A tile stores the greatest Z of itself and of those around it: rays below that depth are
//! dark until they leave it. Cost: one ray per column that is built, one lookup a step of a camera ray.

use super::ray_path::RayPath;
use super::single_scattering::SingleScattering;
use crate::interpolation::lazy_values::LazyValues;
use crate::lights::sun_depth_cache::SunDepthCache;
use crate::view_ray::ViewRay;
use zonal_math::{Vec3, direction_sampling, low_discrepancy};
use zonal_scene::{Bands, PerBand};
use zonal_transport::Transport;
use zonal_transport::lights::EmissionSample;

/// Resolution and lookups of the map.
struct ShadowMapParams {
    /// Columns along the longer side of the scene.
    columns: f64,
    /// Least length of a step of a ray, widths of a column.
    min_step: f64,
    /// Directions in which a surface point looks for partial occlusion of the sun.
    penumbra_directions: usize,
    /// Depth below all lit depths nearby, widths of a column, from which on a surface is dark, however steep.
    surface_margin: f64,
}

const PARAMS: ShadowMapParams =
    ShadowMapParams { columns: 2560.0, min_step: 3.0, penumbra_directions: 8, surface_margin: 16.0 };

/// Columns along a side of a tile.
const TILE_COLUMNS: usize = 32;

/// A pane in a column: its depth, m, and its transmittance.
type PaneLayer = (f32, PerBand<f32>);

/// A square of columns.
struct ShadowTile {
    /// Depth of the first facet, m over the map's plane.
    first: Vec<f32>,
    /// Index of the first pane layer of each column.
    begin: Vec<u32>,
    layers: Vec<PaneLayer>,
    /// The least depth of a facet or pane, and the greatest of a first facet.
    bounds: (f32, f32),
}

/// Choice of the points at which a ray looks up the map.
#[derive(Clone, Copy)]
pub(crate) struct MapSamples {
    /// Index of the run through the low-discrepancy sequence, and its shift.
    pub first: usize,
    pub shift: [f64; 3],
    /// Largest number of steps.
    pub max_steps: usize,
}

/// The deep shadow map of one sun.
pub(crate) struct DeepShadowMap<'a> {
    transport: &'a Transport<'a>,
    /// Optical depths towards the sun's centre.
    depths: SunDepthCache<'a>,
    source: EmissionSample<'static>,
    towards: Vec3,
    /// The axes u and v across the light.
    across: [Vec3; 2],
    /// tan of the sun's angular radius.
    spread: f64,
    /// Position of the first column's corner, and depth of the plane from which depths are counted, m.
    lo: [f64; 2],
    plane: f64,
    /// Width of a column, m.
    side: f64,
    /// Tiles along u and v.
    tiles: [usize; 2],
    built: LazyValues<ShadowTile>,
    bounds: LazyValues<(f32, f32)>,
}

/// Transmittance towards the sun; `None` in shadow.
type SunTransmittance = Option<PerBand<f32>>;

impl<'a> DeepShadowMap<'a> {
    /// The map of light of this fluence, W/m², from a disc of `angular_diameter` radians about the unit vector `towards`.
    pub(crate) fn new(
        transport: &'a Transport<'a>,
        towards: Vec3,
        angular_diameter: f64,
        fluence: Bands,
    ) -> DeepShadowMap<'a> {
        let (u, v) = towards.frame();
        let (a, b) = transport.scene().bounds();
        let corners = (0..8).map(|k| {
            let pick = |bit: usize, x: f64, y: f64| if k >> bit & 1 == 0 { x } else { y };
            Vec3::from_array([pick(0, a.x, b.x), pick(1, a.y, b.y), pick(2, a.z, b.z)])
        });
        let (mut lo, mut hi, mut plane) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2], f64::INFINITY);
        for c in corners {
            for (k, axis) in [u, v].iter().enumerate() {
                (lo[k], hi[k]) = (lo[k].min(axis.dot(c)), hi[k].max(axis.dot(c)));
            }
            plane = plane.min(-towards.dot(c));
        }
        let side = ((hi[0] - lo[0]).max(hi[1] - lo[1]) / PARAMS.columns).max(1e-9);
        let tiles = [0, 1].map(|k| ((hi[k] - lo[k]) / (side * TILE_COLUMNS as f64)).ceil().max(1.0) as usize);
        DeepShadowMap {
            transport,
            depths: SunDepthCache::new(transport, towards),
            source: EmissionSample::Distant { direction: towards, fluence },
            towards,
            across: [u, v],
            spread: (0.5 * angular_diameter).tan(),
            lo,
            plane: plane - 0.01 * transport.scene().diagonal(),
            side,
            tiles,
            built: LazyValues::new(tiles[0] * tiles[1]),
            bounds: LazyValues::new(tiles[0] * tiles[1]),
        }
    }

    /// Builds a tile by one ray per column from the plane above the scene.
    fn build_tile(&self, tile: usize) -> ShadowTile {
        let (i0, j0) = (tile / self.tiles[1] * TILE_COLUMNS, tile % self.tiles[1] * TILE_COLUMNS);
        let scene = self.transport.scene();
        let away = -self.towards;
        let mut out = ShadowTile {
            first: Vec::new(),
            begin: vec![0],
            layers: Vec::new(),
            bounds: (f32::INFINITY, 0.0),
        };
        for k in 0..TILE_COLUMNS * TILE_COLUMNS {
            let place = |l: usize, n: usize| self.lo[l] + (n as f64 + 0.5) * self.side;
            let (s, t) = (place(0, i0 + k / TILE_COLUMNS), place(1, j0 + k % TILE_COLUMNS));
            let from = self.across[0] * s + self.across[1] * t + away * self.plane;
            let hit = self.transport.closest_hit(from, away, 0.0, f64::INFINITY);
            let end = hit.map_or_else(|| self.transport.exterior_point(from, away), |h| from + away * h.t);
            let first = out.layers.len();
            self.transport.pane_crossings(from, end, &mut |p| {
                let pane = &scene.panes()[p.pane];
                let passes = (-pane.extinction * pane.thickness / p.cos).map(|x| x.exp() as f32);
                out.layers.push((p.t as f32, passes));
            });
            out.layers[first..].sort_by(|a, b| a.0.total_cmp(&b.0));
            out.begin.push(out.layers.len() as u32);
            let depth = hit.map_or(f32::INFINITY, |h| h.t as f32);
            out.first.push(depth);
            let top = out.layers[first..].first().map_or(depth, |s| s.0);
            out.bounds = (out.bounds.0.min(top), out.bounds.1.max(depth));
        }
        out
    }

    /// The tile at a position and the column in it; `None` beyond the scene.
    fn locate(&self, place: [f64; 2]) -> Option<(usize, usize)> {
        let [i, j] = [0, 1].map(|k| ((place[k] - self.lo[k]) / self.side).floor());
        let inside = |x: f64, k: usize| x >= 0.0 && x < (self.tiles[k] * TILE_COLUMNS) as f64;
        if !(inside(i, 0) && inside(j, 1)) {
            return None;
        }
        let (i, j) = (i as usize, j as usize);
        let tile = i / TILE_COLUMNS * self.tiles[1] + j / TILE_COLUMNS;
        Some((tile, i % TILE_COLUMNS * TILE_COLUMNS + j % TILE_COLUMNS))
    }

    fn tile(&self, k: usize) -> &ShadowTile {
        self.built.get(k, || self.build_tile(k))
    }

    /// The column at a position; `None` beyond the scene.
    fn column(&self, place: [f64; 2]) -> Option<ShadowColumn<'_>> {
        let (number, column) = self.locate(place)?;
        Some(ShadowColumn { tile: self.tile(number), number, column })
    }

    /// The least depth of a facet or pane and the greatest of a first facet in a tile and those around it.
    fn bounds_around(&self, k: usize) -> (f32, f32) {
        *self.bounds.get(k, || {
            let (i, j) = (k / self.tiles[1], k % self.tiles[1]);
            let near = |x: usize, n: usize| x.saturating_sub(1)..(x + 2).min(n);
            let around = near(i, self.tiles[0]).flat_map(|i| near(j, self.tiles[1]).map(move |j| (i, j)));
            let bounds = around.map(|(i, j)| self.tile(i * self.tiles[1] + j).bounds);
            bounds.fold((f32::INFINITY, 0.0), |a, b| (a.0.min(b.0), a.1.max(b.1)))
        })
    }

    /// Transmittance towards the sun, `delta` off its centre, from the depth `z` at a position.
    fn transmittance(&self, place: [f64; 2], z: f64, delta: [f64; 2]) -> SunTransmittance {
        let Some(here) = self.column(place) else {
            return Some(PerBand::splat(1.0));
        };
        let moved = |edge: f32| {
            let lever = (z - edge as f64).max(0.0);
            let near = lever * self.spread < 0.5 * self.side;
            if near { here } else { self.column([0, 1].map(|k| place[k] + delta[k] * lever)).unwrap_or(here) }
        };
        let edge = match (here.first_pane(), here.transmittance_to(z)) {
            (Some(depth), _) => depth,
            (None, None) => here.first_facet(),
            // In the open: look for a blocker at the height of the highest one nearby, then at its own height.
            (None, _) => {
                let top = self.bounds_around(here.number).0;
                let far = moved(top);
                match (far.first_pane(), far.transmittance_to(z)) {
                    (Some(depth), _) => depth,
                    (None, None) => far.first_facet(),
                    _ => return far.transmittance_to(z),
                }
            }
        };
        moved(edge).transmittance_to(z)
    }

    /// Optical depths of the medium towards the sun's centre.
    pub(crate) fn sun_depths(&self) -> &SunDepthCache<'a> {
        &self.depths
    }

    /// True where certainly no light reaches a surface point.
    pub(crate) fn is_dark(&self, point: Vec3) -> bool {
        let z = -self.towards.dot(point) - self.plane;
        let tile = self.locate(self.across.map(|a| a.dot(point)));
        tile.is_some_and(|(tile, _)| {
            z > self.bounds_around(tile).1 as f64 + PARAMS.surface_margin * self.side
        })
    }

    /// True where a few directions towards the sun differ in occlusion or panes.
    pub(crate) fn may_be_penumbra(&self, point: Vec3, shift: [f64; 3]) -> bool {
        // Start before the surface, which is part of the map.
        let z = -self.towards.dot(point) - self.plane - PARAMS.surface_margin * self.side;
        let place = self.across.map(|a| a.dot(point));
        let towards = |k: usize| {
            let [a, b] = low_discrepancy::r2(k, [shift[0], shift[1]]);
            self.transmittance(place, z, self.off_centre(a, b))
        };
        let first = towards(0);
        (1..PARAMS.penumbra_directions).any(|k| towards(k) != first)
    }

    /// Radiance, W/(m² sr), that the sun adds along the path.
    pub(crate) fn inscattered(
        &self,
        scattering: &SingleScattering,
        ray: ViewRay,
        path: &RayPath,
        samples: MapSamples,
    ) -> Bands {
        let mut out = Bands::ZERO;
        let Some((lo, hi)) = path.scattering_range() else {
            return out;
        };
        let max_steps = samples.max_steps;
        let n = (((hi - lo) / (PARAMS.min_step * self.side)).ceil() as usize).clamp(1, max_steps);
        let step = (hi - lo) / n as f64;
        let mut sample = scattering.sample_along(ray, &self.source, Some(&self.depths), lo, hi);
        // Position and depth at the start, and their change per metre.
        let start = ray.at(lo);
        let (place, rate) = (self.across.map(|a| a.dot(start)), self.across.map(|a| a.dot(ray.dir)));
        let (depth, sink) = (-self.towards.dot(start) - self.plane, -self.towards.dot(ray.dir));
        // The run of steps of one transmittance that is still open.
        let mut run: (usize, SunTransmittance) = (0, None);
        let mut k = 0;
        while k <= n {
            let mut here = None;
            let mut next = k + 1;
            if k < n {
                // Look up the map at a jittered point of the step, or skip steps that are certainly dark.
                let [a, b, c] = low_discrepancy::r3(samples.first * max_steps + k, samples.shift);
                let t = (k as f64 + c) * step;
                let (x, z) = ([0, 1].map(|l| place[l] + rate[l] * t), depth + sink * t);
                match self.dark_steps(x, z, rate.map(|r| r * step), sink * step, max_steps) {
                    0 => here = self.transmittance(x, z, self.off_centre(a, b)),
                    dark => next = (k + dark).min(n),
                }
            }
            if k == n || here != run.1 {
                if let Some(tint) = run.1 {
                    let tint = tint.map(f64::from);
                    let (from, to) = (lo + run.0 as f64 * step, lo + k as f64 * step);
                    sample.add_tinted(path, tint, from, to, &mut out);
                }
                run = (k, here);
            }
            k = next;
        }
        out
    }

    /// A direction off the sun's centre, as an offset per metre across the light, uniform over the disc.
    fn off_centre(&self, a: f64, b: f64) -> [f64; 2] {
        let (sin, cos) = direction_sampling::sin_cos_turns(b);
        let r = self.spread * a.sqrt();
        [r * cos, r * sin]
    }

    /// Number of steps that are certainly dark from a position `place` across the light and a depth `z` on, which change by `rate` and `sink` a step.
    fn dark_steps(&self, place: [f64; 2], z: f64, rate: [f64; 2], sink: f64, max_steps: usize) -> usize {
        let Some((tile, _)) = self.locate(place) else {
            return 0;
        };
        let deepest = self.bounds_around(tile).1 as f64;
        if z <= deepest {
            return 0;
        }
        let width = self.side * TILE_COLUMNS as f64;
        let corner = [tile / self.tiles[1], tile % self.tiles[1]];
        let mut steps = max_steps as f64;
        for k in 0..2 {
            let low = self.lo[k] + corner[k] as f64 * width;
            let left = if rate[k] > 0.0 { low + width - place[k] } else { place[k] - low };
            if rate[k] != 0.0 {
                steps = steps.min(left / rate[k].abs());
            }
        }
        if sink < 0.0 {
            steps = steps.min((z - deepest) / -sink);
        }
        (steps as usize).max(1)
    }
}

/// One column of a tile.
#[derive(Clone, Copy)]
struct ShadowColumn<'a> {
    tile: &'a ShadowTile,
    /// Number of the tile.
    number: usize,
    column: usize,
}

impl ShadowColumn<'_> {
    /// Depth of the first facet.
    fn first_facet(&self) -> f32 {
        self.tile.first[self.column]
    }
    fn layers(&self) -> &[PaneLayer] {
        let at = |k: usize| self.tile.begin[k] as usize;
        &self.tile.layers[at(self.column)..at(self.column + 1)]
    }
    /// Depth of the first pane.
    fn first_pane(&self) -> Option<f32> {
        self.layers().first().map(|s| s.0)
    }
    /// Transmittance down to the depth `z`.
    fn transmittance_to(&self, z: f64) -> SunTransmittance {
        if z >= self.first_facet() as f64 {
            return None;
        }
        let passed = self.layers().iter().take_while(|s| (s.0 as f64) < z);
        Some(passed.fold(PerBand::splat(1.0), |t, s| PerBand::from_fn(|b| t[b] * s.1[b])))
    }
}
