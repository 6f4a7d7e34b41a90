//! Which parts of a ray a distant disc of light reaches, from a map of the columns along the light.
//!
//! With e the direction to the disc's middle, a point x has the place (u·x, v·x) across the light and the depth z = −e·x along it. Of every
//! column of a grid across the light the map knows the depth Z at which its first facet stops the light, and before that the panes that it
//! passes, each with its depth and what it lets through. The point is lit where z < Z, tinted by the panes with a smaller depth.
//!
//! A disc of angular radius α is seen from x in directions that leave the middle by up to tan α. What bounds the light stands at a depth p:
//! that of the column's pane, or of its first facet, or in the open of those nearby. So a direction δ off the middle asks the column at the
//! place of x + δ (z − p): shadows are as soft as they are far from what casts them. Along a ray the light is asked at one point of each step, off by a part of it and with
//! a δ of its own; over steps of one kind the integral is exact (see [`crate::shafts`]).
//!
//! The grid is made tile by tile where rays come by. A tile knows the greatest Z of itself and those around: rays below that are dark
//! until they leave it.

use crate::lazy::Lazy;
use crate::path::Path;
use crate::shafts::Shafts;
use crate::towards::Towards;
use zonal_math::{Vec3, directions, sequence};
use zonal_scene::{Bands, bands};
use zonal_transport::Transport;
use zonal_transport::direct::Source;

/// Columns along the longer side of the scene.
const COLUMNS: f64 = 2560.0;
/// Columns along a side of a tile.
const TILE: usize = 32;
/// Steps of a ray at most, where a pixel has several and where it has one, or shares it.
pub(crate) const STEPS: usize = 256;
pub(crate) const FINE_STEPS: usize = 1024;
/// A step over the width of a column, at least.
const COARSE: f64 = 3.0;

/// Directions in which a point of a surface looks for what hides the disc in part.
const ASKED: usize = 8;
/// A surface so many columns' widths below all that is lit around it is dark, however steep.
const MARGIN: f64 = 16.0;

/// A pane in a column: its depth, m, and what it lets through.
type Sheet = (f32, [f32; 3]);

/// Some columns.
struct Tile {
    /// Depth of the first facet, m over the map's plane.
    first: Vec<f32>,
    /// Where the sheets of each column begin.
    begin: Vec<u32>,
    sheets: Vec<Sheet>,
    /// The least depth of a facet or pane, and the greatest of a first facet.
    bounds: (f32, f32),
}

/// The columns of a disc of light.
pub(crate) struct Columns<'a> {
    transport: &'a Transport<'a>,
    /// Optical depths towards the disc's middle.
    depths: Towards<'a>,
    source: Source,
    towards: Vec3,
    across: [Vec3; 2],
    /// tan of the disc's angular radius.
    spread: f64,
    /// Place of the first column's corner, and depth of the plane from which columns are counted, m.
    lo: [f64; 2],
    plane: f64,
    side: f64,
    tiles: [usize; 2],
    made: Lazy<Tile>,
    bounds: Lazy<(f32, f32)>,
}

/// What reaches a point: nothing, or light with a tint.
type State = Option<[f32; 3]>;
/// Light with nothing between.
const OPEN: State = Some([1.0; 3]);

impl<'a> Columns<'a> {
    /// The columns of light of this fluence, W/m², from a disc of `angular_diameter` radians about the unit vector `towards`.
    pub(crate) fn new(
        transport: &'a Transport<'a>,
        towards: Vec3,
        angular_diameter: f64,
        fluence: Bands,
    ) -> Columns<'a> {
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
        let side = ((hi[0] - lo[0]).max(hi[1] - lo[1]) / COLUMNS).max(1e-9);
        let tiles = [0, 1].map(|k| ((hi[k] - lo[k]) / (side * TILE as f64)).ceil().max(1.0) as usize);
        Columns {
            transport,
            depths: Towards::new(transport, towards),
            source: Source::Distant { towards, fluence },
            towards,
            across: [u, v],
            spread: (0.5 * angular_diameter).tan(),
            lo,
            plane: plane - 0.01 * transport.scene().diagonal(),
            side,
            tiles,
            made: Lazy::new(tiles[0] * tiles[1]),
            bounds: Lazy::new(tiles[0] * tiles[1]),
        }
    }

    fn make(&self, tile: usize) -> Tile {
        let (i0, j0) = (tile / self.tiles[1] * TILE, tile % self.tiles[1] * TILE);
        let scene = self.transport.scene();
        let away = -self.towards;
        let mut out =
            Tile { first: Vec::new(), begin: vec![0], sheets: Vec::new(), bounds: (f32::INFINITY, 0.0) };
        for k in 0..TILE * TILE {
            let place = |l: usize, n: usize| self.lo[l] + (n as f64 + 0.5) * self.side;
            let (s, t) = (place(0, i0 + k / TILE), place(1, j0 + k % TILE));
            let from = self.across[0] * s + self.across[1] * t + away * self.plane;
            let hit = self.transport.nearest(from, away, 0.0, f64::INFINITY);
            let end = hit.map_or_else(|| self.transport.beyond(from, away), |h| from + away * h.t);
            let first = out.sheets.len();
            self.transport.pane_crossings(from, end, &mut |p| {
                let pane = &scene.panes()[p.pane];
                let passes = pane.extinction.map(|x| (-x * pane.thickness / p.cos).exp() as f32);
                out.sheets.push((p.t as f32, passes));
            });
            out.sheets[first..].sort_by(|a, b| a.0.total_cmp(&b.0));
            out.begin.push(out.sheets.len() as u32);
            let depth = hit.map_or(f32::INFINITY, |h| h.t as f32);
            out.first.push(depth);
            let top = out.sheets[first..].first().map_or(depth, |s| s.0);
            out.bounds = (out.bounds.0.min(top), out.bounds.1.max(depth));
        }
        out
    }

    /// The tile and the column in it at a place; `None` beyond the scene.
    fn column(&self, place: [f64; 2]) -> Option<(usize, usize)> {
        let [i, j] = [0, 1].map(|k| ((place[k] - self.lo[k]) / self.side).floor());
        let inside = |x: f64, k: usize| x >= 0.0 && x < (self.tiles[k] * TILE) as f64;
        if !(inside(i, 0) && inside(j, 1)) {
            return None;
        }
        let (i, j) = (i as usize, j as usize);
        Some((i / TILE * self.tiles[1] + j / TILE, i % TILE * TILE + j % TILE))
    }

    fn tile(&self, k: usize) -> &Tile {
        self.made.get(k, || self.make(k))
    }

    fn asked(&self, place: [f64; 2]) -> Option<Column<'_>> {
        let (number, column) = self.column(place)?;
        Some(Column { tile: self.tile(number), number, column })
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

    /// What reaches the depth `z` at a place, by the direction `delta` off the middle.
    fn state(&self, place: [f64; 2], z: f64, delta: [f64; 2]) -> State {
        let Some(here) = self.asked(place) else {
            return OPEN;
        };
        let moved = |edge: f32| {
            let lever = (z - edge as f64).max(0.0);
            let near = lever * self.spread < 0.5 * self.side;
            if near { here } else { self.asked([0, 1].map(|k| place[k] + delta[k] * lever)).unwrap_or(here) }
        };
        let edge = match (here.sheet(), here.seen(z)) {
            (Some(depth), _) => depth,
            (None, None) => here.first(),
            // In the open: what may stand in the way is first sought from as high as anything does, then from where it stands.
            (None, _) => {
                let top = self.bounds_around(here.number).0;
                let far = moved(top);
                match (far.sheet(), far.seen(z)) {
                    (Some(depth), _) => depth,
                    (None, None) => far.first(),
                    _ => return far.seen(z),
                }
            }
        };
        moved(edge).seen(z)
    }

    /// Optical depths of the medium towards the disc's middle.
    pub(crate) fn depths(&self) -> &Towards<'a> {
        &self.depths
    }

    /// True where no light reaches a point of a surface for sure.
    pub(crate) fn are_dark(&self, point: Vec3) -> bool {
        let z = -self.towards.dot(point) - self.plane;
        let tile = self.column(self.across.map(|a| a.dot(point)));
        tile.is_some_and(|(tile, _)| z > self.bounds_around(tile).1 as f64 + MARGIN * self.side)
    }

    /// False where a point of a surface sees all of the disc through the same panes, or nothing, for all that a few directions tell.
    pub(crate) fn may_be_partly_lit(&self, point: Vec3, shift: [f64; 3]) -> bool {
        // Before the surface, which is in the columns too.
        let z = -self.towards.dot(point) - self.plane - MARGIN * self.side;
        let place = self.across.map(|a| a.dot(point));
        let state = |k: usize| {
            let [a, b] = sequence::r2(k, [shift[0], shift[1]]);
            self.state(place, z, self.off_middle(a, b))
        };
        let first = state(0);
        (1..ASKED).any(|k| state(k) != first)
    }

    /// Radiance, W/(m² sr), that the light adds along the path; `first` and `shift` choose the points that are asked,
    /// one of each of so many steps at most.
    pub(crate) fn scattered(
        &self,
        shafts: &Shafts,
        (origin, dir): (Vec3, Vec3),
        path: &Path,
        (first, shift, most): (usize, [f64; 3], usize),
    ) -> Bands {
        let mut out = [0.0; 3];
        let Some((lo, hi)) = path.scattering() else {
            return out;
        };
        let n = (((hi - lo) / (COARSE * self.side)).ceil() as usize).clamp(1, most);
        let step = (hi - lo) / n as f64;
        let mut beam = shafts.beam((origin, dir), &self.source, Some(&self.depths), (lo, hi));
        let start = origin + dir * lo;
        let (place, rate) = (self.across.map(|a| a.dot(start)), self.across.map(|a| a.dot(dir)));
        let (depth, sink) = (-self.towards.dot(start) - self.plane, -self.towards.dot(dir));
        let mut run: (usize, State) = (0, None);
        let mut k = 0;
        while k <= n {
            let mut state = None;
            let mut next = k + 1;
            if k < n {
                let [a, b, c] = sequence::r3(first * most + k, shift);
                let t = (k as f64 + c) * step;
                let (x, z) = ([0, 1].map(|l| place[l] + rate[l] * t), depth + sink * t);
                match self.dark(x, z, rate.map(|r| r * step), sink * step, most) {
                    0 => state = self.state(x, z, self.off_middle(a, b)),
                    dark => next = (k + dark).min(n),
                }
            }
            if k == n || state != run.1 {
                if let Some(tint) = run.1 {
                    let tint = bands(|b| tint[b] as f64);
                    beam.add_tinted(path, tint, lo + run.0 as f64 * step, lo + k as f64 * step, &mut out);
                }
                run = (k, state);
            }
            k = next;
        }
        out
    }

    /// A direction of the disc, over the plane across it.
    fn off_middle(&self, a: f64, b: f64) -> [f64; 2] {
        let (sin, cos) = directions::turn(b);
        let r = self.spread * a.sqrt();
        [r * cos, r * sin]
    }

    /// How many steps from here are dark for sure.
    fn dark(&self, place: [f64; 2], z: f64, rate: [f64; 2], sink: f64, most: usize) -> usize {
        let Some((tile, _)) = self.column(place) else {
            return 0;
        };
        let deepest = self.bounds_around(tile).1 as f64;
        if z <= deepest {
            return 0;
        }
        let width = self.side * TILE as f64;
        let corner = [tile / self.tiles[1], tile % self.tiles[1]];
        let mut steps = most as f64;
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
struct Column<'a> {
    tile: &'a Tile,
    /// Number of the tile.
    number: usize,
    column: usize,
}

impl Column<'_> {
    fn first(&self) -> f32 {
        self.tile.first[self.column]
    }
    fn sheets(&self) -> &[Sheet] {
        let at = |k: usize| self.tile.begin[k] as usize;
        &self.tile.sheets[at(self.column)..at(self.column + 1)]
    }
    /// Depth of the first pane.
    fn sheet(&self) -> Option<f32> {
        self.sheets().first().map(|s| s.0)
    }
    /// What reaches the depth `z`.
    fn seen(&self, z: f64) -> State {
        if z >= self.first() as f64 {
            return None;
        }
        let passed = self.sheets().iter().take_while(|s| (s.0 as f64) < z);
        Some(passed.fold([1.0; 3], |t, s| [t[0] * s.1[0], t[1] * s.1[1], t[2] * s.1[2]]))
    }
}
