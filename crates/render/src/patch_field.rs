//! A field on surfaces, smooth across the zones of one sheet and sharp at creases and walls.
//!
//! Every tile (a patch, or a piece of a pane) has nodes at its corners and edge middles, valued by [`crate::fit`] over the tiles that
//! touch the node, face the same way within 20° and are not cut off by a wall (the segment between points just above both
//! centres is free). Weights are the angles that the tiles subtend at the node. Inside a parallelogram the nine values (the
//! ninth, at the centre, is such that the tile keeps its mean) are interpolated by the biquadratic Lagrange polynomial, inside a
//! triangle by the quadratic one with a cubic bubble for the centre; both agree along shared edges and are kept within the range
//! of their nodes. A node that lies inside a neighbour's edge takes that neighbour's value there (T-junctions).

use crate::fit::{Fit, Slope, Touch, combine, node_value, range};
use crate::lazy::Lazy;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use zonal_math::Vec3;
use zonal_scene::{Bands, Plate, PlateKind, bands};
use zonal_transport::Transport;
use zonal_transport::sheets::{Sheets, onto};

const COS_SMOOTH: f64 = 0.939_692_620_785_908_4; // cos 20°

/// A zone of a sheet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tile {
    pub plate: Plate,
    /// Unit normal of the side it stands for.
    pub normal: Vec3,
    /// Which sheet it is cut from: one side of a facet, or a plate of a pane.
    pub sheet: usize,
}

/// The field, ready to be asked at points of its sheets.
pub(crate) struct PatchField<'a> {
    shape: Shape<'a>,
    layer: Layer,
    sheets: Sheets,
}

impl<'a> PatchField<'a> {
    /// `values` are the tiles' means; `sheets` the plates they are cut from; walls are asked of `transport`, if given.
    pub(crate) fn new(
        tiles: Vec<Tile>,
        values: Vec<Bands>,
        sheets: &[Plate],
        transport: Option<&'a Transport<'a>>,
    ) -> PatchField<'a> {
        let sheets = Sheets::new(sheets, tiles.iter().map(|t| (&t.plate, t.sheet)));
        PatchField { shape: Shape::new(tiles, transport), layer: Layer::new(values), sheets }
    }

    /// The value at a point of a sheet with the sheet's parameters (u, v); `None` where the sheet has no tile.
    pub(crate) fn at(&self, sheet: usize, uv: [f64; 2], point: Vec3) -> Option<Bands> {
        let i = self.sheets.find(sheet, uv)? as usize;
        let uv = onto(&self.shape.tiles[i].plate, point);
        Some(self.layer.at(&self.shape, i, uv))
    }
}

/// Parameters of the nodes: corners, then edge middles.
fn node_parameters(kind: PlateKind) -> &'static [[f64; 2]] {
    match kind {
        PlateKind::Parallelogram => {
            &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.0], [1.0, 0.5], [0.5, 1.0], [0.0, 0.5]]
        }
        PlateKind::Triangle => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]],
    }
}

/// The value at the centre with which the polynomial's mean over the tile is the tile's own mean.
fn conserving(kind: PlateKind, nodes: &[Bands; 8], own: Bands) -> Bands {
    let sum = |b: usize, from: usize, to: usize| nodes[from..to].iter().map(|n| n[b]).sum::<f64>();
    let centre = |b: usize| match kind {
        // Simpson's rule: (corners + 4 middles + 16 centre)/36.
        PlateKind::Parallelogram => (36.0 * own[b] - sum(b, 0, 4) - 4.0 * sum(b, 4, 8)) / 16.0,
        // The mean of the quadratic is that of its middles, of the bubble 9/20.
        PlateKind::Triangle => {
            let (corners, middles) = (sum(b, 0, 3) / 3.0, sum(b, 3, 6) / 3.0);
            (4.0 * middles - corners) / 3.0 + (own[b] - middles) * (20.0 / 9.0)
        }
    };
    // Negative means, as slopes in thick voxels may leave them, turn the limits round.
    bands(|b| centre(b).clamp(0.5 * own[b].max(0.0), 1.5 * own[b].max(0.0)))
}

fn interpolate(kind: PlateKind, nodes: &[Bands; 8], own: Bands, u: f64, v: f64) -> Bands {
    let (count, raw) = match kind {
        PlateKind::Parallelogram => (8, biquadratic(nodes, own, u, v)),
        PlateKind::Triangle => (6, quadratic(nodes, own, u, v)),
    };
    let limits = range(nodes[..count].iter().copied().chain([own]));
    bands(|b| raw[b].max(limits[b].0).min(limits[b].1))
}

fn biquadratic(nodes: &[Bands; 8], own: Bands, u: f64, v: f64) -> Bands {
    let basis = |x: f64| [(1.0 - 2.0 * x) * (1.0 - x), 4.0 * x * (1.0 - x), x * (2.0 * x - 1.0)];
    let (a, b) = (basis(u), basis(v));
    let w = [
        a[0] * b[0],
        a[2] * b[0],
        a[2] * b[2],
        a[0] * b[2],
        a[1] * b[0],
        a[2] * b[1],
        a[1] * b[2],
        a[0] * b[1],
    ];
    let edge = combine(w, nodes);
    bands(|k| edge[k] + a[1] * b[1] * own[k])
}

fn quadratic(nodes: &[Bands; 8], own: Bands, u: f64, v: f64) -> Bands {
    let p2 = |u: f64, v: f64| {
        let l = 1.0 - u - v;
        let corner = |x: f64| x * (2.0 * x - 1.0);
        combine([corner(l), corner(u), corner(v), 4.0 * l * u, 4.0 * u * v, 4.0 * v * l], nodes)
    };
    let (here, centre) = (p2(u, v), p2(1.0 / 3.0, 1.0 / 3.0));
    let bubble = 27.0 * u * v * (1.0 - u - v);
    bands(|b| here[b] + bubble * (own[b] - centre[b]))
}

/// Tiles by the cells of a uniform grid, for 'who touches this point'.
struct Near {
    cell: f64,
    cells: HashMap<[i64; 3], Vec<u32>>,
}

impl Near {
    fn new(tiles: &[Tile]) -> Near {
        let mean = tiles.iter().map(|t| t.plate.diameter()).sum::<f64>() / tiles.len().max(1) as f64;
        let largest = tiles.iter().map(|t| t.plate.diameter()).fold(0.0, f64::max);
        // Large tiles among many small ones must not fill the grid.
        let cell = mean.max(largest / 32.0).max(1e-12);
        let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        for (i, t) in tiles.iter().enumerate() {
            let (lo, hi) = t.plate.bounds();
            let pad = Vec3::splat(1e-6 * t.plate.diameter());
            let (a, b) = (key(lo - pad, cell), key(hi + pad, cell));
            for x in a[0]..=b[0] {
                for y in a[1]..=b[1] {
                    for z in a[2]..=b[2] {
                        let middle = [x, y, z].map(|k| (k as f64 + 0.5) * cell);
                        let height = t.normal.dot(Vec3::from_array(middle) - t.plate.origin);
                        if height.abs() <= cell {
                            cells.entry([x, y, z]).or_default().push(i as u32);
                        }
                    }
                }
            }
        }
        Near { cell, cells }
    }
    fn at(&self, p: Vec3) -> &[u32] {
        self.cells.get(&key(p, self.cell)).map_or(&[], Vec::as_slice)
    }
}

/// The cell of a uniform grid in which a point lies.
pub(crate) fn key(p: Vec3, cell: f64) -> [i64; 3] {
    p.array().map(|x| (x / cell).floor() as i64)
}

/// Where the tiles lie and which of them belong together: the same for every field on them.
pub(crate) struct Shape<'a> {
    tiles: Vec<Tile>,
    transport: Option<&'a Transport<'a>>,
    near: Near,
    touching: Lazy<Touching>,
}

/// One field on the tiles of a shape.
pub(crate) struct Layer {
    values: Vec<Bands>,
    fits: Lazy<Fitted>,
    /// Nodes before and after those inside a neighbour's edge have its value.
    raw: Lazy<[Bands; 8]>,
    nodes: Lazy<[Bands; 8]>,
}

/// The gradient of a tile, and the smallest and largest value among it and its neighbours, a band.
type Fitted = (Slope, [(f64, f64); 3]);

/// The tiles that touch each node of one tile, with the angle each subtends there.
type Touching = Vec<Vec<(u32, f64)>>;

impl<'a> Shape<'a> {
    /// The tiles, with walls asked of `transport`, if given.
    pub(crate) fn new(tiles: Vec<Tile>, transport: Option<&'a Transport<'a>>) -> Shape<'a> {
        let (near, touching) = (Near::new(&tiles), Lazy::new(tiles.len()));
        Shape { tiles, transport, near, touching }
    }

    /// The tiles.
    pub(crate) fn tiles(&self) -> &[Tile] {
        &self.tiles
    }

    fn touching(&self, i: usize) -> &Touching {
        self.touching.get(i, || self.touch(i))
    }

    fn touch(&self, i: usize) -> Touching {
        let tile = &self.tiles[i];
        let mut known: Vec<(u32, bool)> = vec![(i as u32, true)];
        let mut list = Vec::new();
        for &[u, v] in node_parameters(tile.plate.kind) {
            let p = tile.plate.at(u, v);
            let mut here = Vec::new();
            for &j in self.near.at(p) {
                let Some(angle) = subtended(&self.tiles[j as usize].plate, p) else {
                    continue;
                };
                let joined = known.iter().find(|k| k.0 == j).map(|k| k.1).unwrap_or_else(|| {
                    let yes = self.joined(i, j as usize);
                    known.push((j, yes));
                    yes
                });
                if joined {
                    here.push((j, angle));
                }
            }
            list.push(here);
        }
        list
    }

    /// True when two tiles that touch belong to one smooth sheet with no wall between.
    fn joined(&self, i: usize, j: usize) -> bool {
        let (a, b) = (&self.tiles[i], &self.tiles[j]);
        let cos = a.normal.dot(b.normal);
        if cos < COS_SMOOTH {
            return false;
        }
        let size = a.plate.area().min(b.plate.area()).sqrt();
        let lift = size * (1e-3 + 0.6 * ((1.0 - cos).max(0.0) / 2.0).sqrt());
        let above = |t: &Tile| t.plate.centre() + t.normal * lift;
        !self.transport.is_some_and(|t| t.blocked(above(a), above(b)))
    }
}

impl Layer {
    /// The field with these means, one a tile.
    pub(crate) fn new(values: Vec<Bands>) -> Layer {
        let n = values.len();
        Layer { values, fits: Lazy::new(n), raw: Lazy::new(n), nodes: Lazy::new(n) }
    }

    /// The value at the point of tile `i` with the tile's parameters (u, v).
    pub(crate) fn at(&self, shape: &Shape, i: usize, [u, v]: [f64; 2]) -> Bands {
        let (kind, nodes) = (shape.tiles[i].plate.kind, self.nodes(shape, i));
        interpolate(kind, nodes, conserving(kind, nodes, self.values[i]), u, v)
    }

    fn fit(&self, shape: &Shape, i: usize) -> &Fitted {
        self.fits.get(i, || self.slope(shape, i))
    }
    fn raw_nodes(&self, shape: &Shape, i: usize) -> &[Bands; 8] {
        self.raw.get(i, || self.node_values(shape, i))
    }
    /// Values at the nodes of tile `i`.
    fn nodes(&self, shape: &Shape, i: usize) -> &[Bands; 8] {
        self.nodes.get(i, || self.hang(shape, i))
    }

    fn slope(&self, shape: &Shape, i: usize) -> Fitted {
        let touching = shape.touching(i);
        let mut ids: Vec<u32> = touching.iter().flatten().map(|t| t.0).collect();
        ids.sort_unstable();
        ids.dedup();
        let (tile, mut fits) = (&shape.tiles[i], [Fit::default(); 3]);
        for &j in ids.iter().filter(|j| **j as usize != i) {
            let d = shape.tiles[j as usize].plate.centre() - tile.plate.centre();
            // Unrolled onto the tile's plane at its own length.
            let flat = (d - tile.normal * d.dot(tile.normal)).normalized() * d.length();
            (0..3).for_each(|b| fits[b].add(flat, self.values[j as usize][b] - self.values[i][b]));
        }
        (fits.map(|f| f.slope()), range(ids.iter().map(|&j| self.values[j as usize])))
    }

    fn node_values(&self, shape: &Shape, i: usize) -> [Bands; 8] {
        let touching = shape.touching(i);
        let mut out = [[0.0; 3]; 8];
        let plate = &shape.tiles[i].plate;
        for (k, &[u, v]) in node_parameters(plate.kind).iter().enumerate() {
            let touch = |b: usize| {
                touching[k].iter().map(move |&(j, angle)| {
                    let fit = self.fit(shape, j as usize);
                    Touch {
                        weight: angle,
                        centre: shape.tiles[j as usize].plate.centre(),
                        value: self.values[j as usize][b],
                        slope: fit.0[b],
                        range: fit.1[b],
                    }
                })
            };
            let p = plate.at(u, v);
            out[k] = bands(|b| node_value(p, touch(b)).unwrap_or(self.values[i][b]));
        }
        out
    }

    /// Nodes inside a neighbour's edge take the neighbour's value.
    fn hang(&self, shape: &Shape, i: usize) -> [Bands; 8] {
        let touching = shape.touching(i);
        let mut out = *self.raw_nodes(shape, i);
        let plate = &shape.tiles[i].plate;
        for (k, &[u, v]) in node_parameters(plate.kind).iter().enumerate() {
            let p = plate.at(u, v);
            let host = touching[k].iter().map(|t| t.0 as usize).find(|&j| {
                let other = &shape.tiles[j].plate;
                let tol = 1e-6 * other.diameter();
                j != i
                    && other.area() > plate.area()
                    && node_parameters(other.kind).iter().all(|&[a, b]| (other.at(a, b) - p).length() > tol)
            });
            if let Some(j) = host {
                let [a, b] = onto(&shape.tiles[j].plate, p);
                out[k] =
                    interpolate(shape.tiles[j].plate.kind, self.raw_nodes(shape, j), self.values[j], a, b);
            }
        }
        out
    }
}

/// The angle that a plate subtends at a point of it, radians; `None` for points off the plate.
fn subtended(plate: &Plate, p: Vec3) -> Option<f64> {
    let tol = 1e-6 * plate.diameter();
    let (corners, n) = plate.corners();
    let at_corner = (0..n).find(|&k| (corners[k] - p).length() <= tol);
    if let Some(k) = at_corner {
        let (a, b) = (corners[(k + 1) % n] - corners[k], corners[(k + n - 1) % n] - corners[k]);
        return Some(a.normalized().dot(b.normalized()).clamp(-1.0, 1.0).acos());
    }
    let [u, v] = onto(plate, p);
    if (plate.at(u, v) - p).length() > tol {
        return None;
    }
    let edge = match plate.kind {
        PlateKind::Parallelogram => u.min(v).min(1.0 - u).min(1.0 - v),
        PlateKind::Triangle => u.min(v).min(1.0 - u - v),
    };
    Some(if edge < 1e-6 { PI } else { TAU })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    fn floor(n: usize, f: impl Fn(Vec3) -> f64) -> (Vec<Tile>, Vec<Bands>, Vec<Plate>) {
        let whole = Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        let h = 1.0 / n as f64;
        let tile = |i: usize| Tile {
            plate: Plate::parallelogram(
                vec3((i / n) as f64 * h, (i % n) as f64 * h, 0.0),
                vec3(h, 0.0, 0.0),
                vec3(0.0, h, 0.0),
            ),
            normal: vec3(0.0, 0.0, 1.0),
            sheet: 0,
        };
        let tiles: Vec<Tile> = (0..n * n).map(tile).collect();
        let values = tiles.iter().map(|t| [f(t.plate.centre()); 3]).collect();
        (tiles, values, vec![whole])
    }

    #[test]
    fn linear_fields_come_back_exactly_and_curved_ones_to_second_order() {
        let ask = |f: &dyn Fn(Vec3) -> f64| {
            let (tiles, values, sheets) = floor(10, f);
            let field = PatchField::new(tiles, values, &sheets, None);
            let mut worst: f64 = 0.0;
            for i in 0..400 {
                let [x, y] = zonal_math::sequence::r2(i, [0.0; 2]);
                let p = vec3(x, y, 0.0);
                worst = worst.max((field.at(0, [x, y], p).unwrap()[1] - f(p)).abs());
            }
            worst
        };
        assert!(ask(&|p| 2.0 + p.x - 0.5 * p.y) < 1e-6);
        assert!(ask(&|p| 2.0 + (3.0 * p.x).sin() * p.y) < 0.02);
    }

    #[test]
    fn triangles_reproduce_linear_fields_too() {
        let whole = Plate::triangle(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        let mut plates = vec![whole];
        for _ in 0..3 {
            plates = plates.iter().flat_map(|p| p.quarters()).collect();
        }
        let f = |p: Vec3| 3.0 + p.x - 2.0 * p.y;
        let tiles: Vec<Tile> =
            plates.iter().map(|p| Tile { plate: *p, normal: whole.normal(), sheet: 0 }).collect();
        let values = plates.iter().map(|p| [f(p.centre()); 3]).collect();
        let field = PatchField::new(tiles, values, &[whole], None);
        for i in 0..400 {
            let [u, v] = whole.warp(zonal_math::sequence::r2(i, [0.0; 2]));
            let p = whole.at(u, v);
            assert!((field.at(0, [u, v], p).unwrap()[0] - f(p)).abs() < 1e-6);
        }
    }
}
