//! A field on surfaces, smooth across the zones of one sheet and sharp at creases and walls.
//!
//! Every tile (a patch, or a piece of a pane) has nodes at its corners and edge middles. Their values come from
//! [`crate::interpolation::node_interpolation`] over the tiles that touch the node, face the same way within 20° (or stand for a curved surface whose normals at the node do) and are not separated by a wall or a pane
//! (the segment between points just above both centres is free). Weights are the angles that the tiles subtend at the node. Inside a
//! parallelogram the nine values (the ninth, at the centre, conserves the mean of the tile) are interpolated by the biquadratic
//! Lagrange polynomial; inside a triangle by the quadratic one with a cubic bubble for the centre. Both agree along shared edges and
//! are limited to the range of their nodes. A node inside a neighbour's edge (a hanging node) takes that neighbour's value there.
//! Cost: one node evaluation a tile, on first use, then nine weights a point.

use crate::interpolation::lazy_values::LazyValues;
use crate::interpolation::node_interpolation::{
    BandGradients, GradientFit, NodeZone, node_value, value_ranges, weighted_sum,
};
use std::f64::consts::{PI, TAU};
use zonal_math::Vec3;
use zonal_scene::{Band, Bands, PerBand, Plate, PlateKind, SidedFacet};
use zonal_transport::Transport;
use zonal_transport::patch_locator::{PatchLocator, clamped_parameters};
use zonal_transport::plate_boxes::PlateBoxes;

/// Least cosine between the normals of tiles of one smooth sheet: cos 20°.
const MIN_COS_SMOOTH: f64 = 0.939_692_620_785_908_4;
/// Least cosine between the normals of facets that stand for one curved surface.
const MIN_COS_CURVED: f64 = -0.5;
/// Distance within which points of a tile coincide, over the tile's diameter.
const TOUCHING_SHARE: f64 = 1e-6;
/// Tiles that touch a node of most meshes.
const USUAL_NEIGHBOURS: usize = 8;

/// A zone of a sheet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlateTile {
    pub plate: Plate,
    /// Unit normal of its side.
    pub normal: Vec3,
    /// The sheet from which it is cut: one side of a facet, or a plate of a pane.
    pub sheet: usize,
    /// True of a patch whose facet stands for a curved surface.
    pub is_curved: bool,
}

/// A field that is evaluated at points of its sheets.
pub(crate) struct PatchField<'a> {
    topology: TileTopology<'a>,
    values: TileField,
    sheets: PatchLocator,
}

impl<'a> PatchField<'a> {
    /// The field with the means `values` on tiles cut from the plates `sheets`; walls come from `transport`, if given.
    pub(crate) fn new(
        tiles: Vec<PlateTile>,
        values: Vec<Bands>,
        sheets: &[Plate],
        transport: Option<&'a Transport<'a>>,
    ) -> PatchField<'a> {
        let sheets = PatchLocator::new(sheets, tiles.iter().map(|t| (&t.plate, t.sheet)));
        PatchField { topology: TileTopology::new(tiles, transport), values: TileField::new(values), sheets }
    }

    /// The value at a point of a sheet with the sheet's parameters (u, v); `None` where the sheet has no tile.
    pub(crate) fn at(&self, sheet: usize, uv: [f64; 2], point: Vec3) -> Option<Bands> {
        Some(self.on_tile(self.tile_at(sheet, uv)?, point))
    }

    /// The tile at a point of a sheet with the sheet's parameters (u, v).
    pub(crate) fn tile_at(&self, sheet: usize, uv: [f64; 2]) -> Option<usize> {
        self.sheets.locate(sheet, uv).map(|i| i as usize)
    }

    /// The value at a point of tile `i`.
    pub(crate) fn on_tile(&self, i: usize, point: Vec3) -> Bands {
        let uv = clamped_parameters(&self.topology.tiles[i].plate, point);
        self.values.at(&self.topology, i, uv)
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

/// The value at the centre that makes the mean of the polynomial the mean of the tile.
fn conserving_centre(kind: PlateKind, nodes: &[Bands; 8], own: Bands) -> Bands {
    let sum = |from: usize, to: usize| nodes[from..to].iter().sum::<Bands>();
    let centre = match kind {
        // Simpson's rule: (corners + 4 middles + 16 centre)/36.
        PlateKind::Parallelogram => (36.0 * own - sum(0, 4) - 4.0 * sum(4, 8)) / 16.0,
        // The mean of the quadratic is that of its edge middles; the bubble has the mean 9/20.
        PlateKind::Triangle => {
            let (corners, middles) = (sum(0, 3) / 3.0, sum(3, 6) / 3.0);
            (4.0 * middles - corners) / 3.0 + (own - middles) * (20.0 / 9.0)
        }
    };
    // Negative means, which linear fields in thick voxels may leave, would swap the limits.
    centre.zip_map(own, |x, own| x.clamp(0.5 * own.max(0.0), 1.5 * own.max(0.0)))
}

fn interpolate(kind: PlateKind, nodes: &[Bands; 8], own: Bands, u: f64, v: f64) -> Bands {
    let (count, raw) = match kind {
        PlateKind::Parallelogram => (8, biquadratic(nodes, own, u, v)),
        PlateKind::Triangle => (6, quadratic(nodes, own, u, v)),
    };
    let limits = value_ranges(nodes[..count].iter().copied().chain([own]));
    Bands::from_fn(|b| raw[b].max(limits[b].0).min(limits[b].1))
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
    let edge = weighted_sum(w, nodes);
    edge + a[1] * b[1] * own
}

fn quadratic(nodes: &[Bands; 8], own: Bands, u: f64, v: f64) -> Bands {
    let p2 = |u: f64, v: f64| {
        let l = 1.0 - u - v;
        let corner = |x: f64| x * (2.0 * x - 1.0);
        weighted_sum([corner(l), corner(u), corner(v), 4.0 * l * u, 4.0 * u * v, 4.0 * v * l], nodes)
    };
    let (here, centre) = (p2(u, v), p2(1.0 / 3.0, 1.0 / 3.0));
    let bubble = 27.0 * u * v * (1.0 - u - v);
    here + bubble * (own - centre)
}

/// Positions and adjacency of the tiles: the same for every field on them.
pub(crate) struct TileTopology<'a> {
    tiles: Vec<PlateTile>,
    measures: Vec<TileMeasures>,
    transport: Option<&'a Transport<'a>>,
    boxes: PlateBoxes,
    nodes: LazyValues<TileNodes>,
}

/// Measures of a tile's plate.
struct TileMeasures {
    centre: Vec3,
    /// Area, m².
    area: f64,
    /// Distance within which points coincide, m.
    tolerance: f64,
}

/// One field on the tiles of a topology.
pub(crate) struct TileField {
    values: Vec<Bands>,
    fits: LazyValues<TileFit>,
    /// Node values before hanging nodes take the value of their neighbour …
    free_nodes: LazyValues<[Bands; 8]>,
    /// … and after.
    nodes: LazyValues<[Bands; 8]>,
}

/// The gradients of a tile, and the smallest and largest value among it and its neighbours, band by band.
type TileFit = (BandGradients, PerBand<(f64, f64)>);

/// The nodes of one tile, in the order of [`node_parameters`].
#[derive(Default)]
struct TileNodes {
    /// The tiles that touch each node in turn, with the angle each subtends there.
    touching: Vec<(u32, f64)>,
    /// For each node the end of its tiles in `touching`.
    ends: [u32; 8],
    /// The larger neighbours inside whose edges nodes hang: node, neighbour, and the neighbour's parameters there.
    hosts: Vec<(u8, u32, [f64; 2])>,
}

impl TileNodes {
    /// The tiles that touch node `k`, with the angle each subtends there.
    fn touching(&self, k: usize) -> &[(u32, f64)] {
        let begin = if k == 0 { 0 } else { self.ends[k - 1] };
        &self.touching[begin as usize..self.ends[k] as usize]
    }
}

impl<'a> TileTopology<'a> {
    /// The topology of the tiles; walls come from `transport`, if given.
    pub(crate) fn new(tiles: Vec<PlateTile>, transport: Option<&'a Transport<'a>>) -> TileTopology<'a> {
        let plates: Vec<Plate> = tiles.iter().map(|t| t.plate).collect();
        let (boxes, nodes) = (PlateBoxes::new(&plates), LazyValues::new(tiles.len()));
        let measure = |p: &Plate| TileMeasures {
            centre: p.centre(),
            area: p.area(),
            tolerance: TOUCHING_SHARE * p.diameter(),
        };
        let measures = plates.iter().map(measure).collect();
        TileTopology { tiles, measures, transport, boxes, nodes }
    }

    /// The tiles.
    pub(crate) fn tiles(&self) -> &[PlateTile] {
        &self.tiles
    }

    fn nodes(&self, i: usize) -> &TileNodes {
        self.nodes.get(i, || self.find_nodes(i))
    }

    fn find_nodes(&self, i: usize) -> TileNodes {
        let tile = &self.tiles[i];
        let mut known: Vec<(u32, bool)> = Vec::with_capacity(USUAL_NEIGHBOURS);
        known.push((i as u32, true));
        let mut near = Vec::with_capacity(USUAL_NEIGHBOURS);
        let touching = Vec::with_capacity(4 * USUAL_NEIGHBOURS);
        let mut nodes = TileNodes { touching, ..TileNodes::default() };
        for (k, &[u, v]) in node_parameters(tile.plate.kind).iter().enumerate() {
            let p = tile.plate.at(u, v);
            let begin = nodes.touching.len();
            self.boxes.at(p, &mut near);
            for &j in &near {
                let Some(angle) = self.subtended(j as usize, p) else {
                    continue;
                };
                let smooth = self.are_one_curve(i, j as usize, p);
                let connected = if smooth {
                    self.are_joined(i, j as usize)
                } else {
                    known.iter().find(|k| k.0 == j).map(|k| k.1).unwrap_or_else(|| {
                        let connected = self.are_connected(i, j as usize);
                        known.push((j, connected));
                        connected
                    })
                };
                if connected {
                    nodes.touching.push((j, angle));
                }
            }
            nodes.ends[k] = nodes.touching.len() as u32;
            if let Some((host, uv)) = self.host_of(i, p, &nodes.touching[begin..]) {
                nodes.hosts.push((k as u8, host, uv));
            }
        }
        nodes.touching.shrink_to_fit();
        nodes
    }

    /// The first of the tiles touching a node of tile `i` at `p` that is larger and has no node there.
    fn host_of(&self, i: usize, p: Vec3, touching: &[(u32, f64)]) -> Option<(u32, [f64; 2])> {
        let is_host = |j: usize| {
            let (other, measures) = (&self.tiles[j].plate, &self.measures[j]);
            j != i
                && measures.area > self.measures[i].area
                && node_parameters(other.kind)
                    .iter()
                    .all(|&[a, b]| (other.at(a, b) - p).length() > measures.tolerance)
        };
        let host = touching.iter().map(|t| t.0).find(|j| is_host(*j as usize))?;
        Some((host, clamped_parameters(&self.tiles[host as usize].plate, p)))
    }

    /// The angle that tile `i` subtends at a point of it, radians; `None` for points off the tile.
    fn subtended(&self, i: usize, p: Vec3) -> Option<f64> {
        let (plate, tolerance) = (&self.tiles[i].plate, self.measures[i].tolerance);
        let (corners, n) = plate.corners();
        let at_corner = (0..n).find(|&k| (corners[k] - p).length() <= tolerance);
        if let Some(k) = at_corner {
            let (a, b) = (corners[(k + 1) % n] - corners[k], corners[(k + n - 1) % n] - corners[k]);
            return Some(a.normalized().dot(b.normalized()).clamp(-1.0, 1.0).acos());
        }
        let [u, v] = clamped_parameters(plate, p);
        if (plate.at(u, v) - p).length() > tolerance {
            return None;
        }
        let edge = match plate.kind {
            PlateKind::Parallelogram => u.min(v).min(1.0 - u).min(1.0 - v),
            PlateKind::Triangle => u.min(v).min(1.0 - u - v),
        };
        Some(if edge < 1e-6 { PI } else { TAU })
    }

    /// True where two tiles that touch belong to one smooth sheet with no wall or pane between.
    fn are_connected(&self, i: usize, j: usize) -> bool {
        self.tiles[i].normal.dot(self.tiles[j].normal) >= MIN_COS_SMOOTH && self.are_joined(i, j)
    }

    /// True where two tiles at a steep angle stand for one curved surface at a common point: its normals there are the same within 20°.
    fn are_one_curve(&self, i: usize, j: usize, p: Vec3) -> bool {
        let (a, b) = (&self.tiles[i], &self.tiles[j]);
        let cos = a.normal.dot(b.normal);
        if !(a.is_curved || b.is_curved) || !(MIN_COS_CURVED..MIN_COS_SMOOTH).contains(&cos) {
            return false;
        }
        self.curved_normal(a, p).dot(self.curved_normal(b, p)) >= MIN_COS_SMOOTH
    }

    /// The normal of the curved surface for which a tile stands.
    fn curved_normal(&self, tile: &PlateTile, p: Vec3) -> Vec3 {
        let Some(scene) = self.transport.map(Transport::scene).filter(|_| tile.is_curved) else {
            return tile.normal;
        };
        let side = SidedFacet::of_number(tile.sheet);
        let uv = scene.facets()[side.facet].plate.parameters(p);
        scene.curved_point(side, uv, 0.0).map_or(tile.normal, |at| at.normal)
    }

    /// True where no wall and no pane stands between the upper sides of two tiles.
    fn are_joined(&self, i: usize, j: usize) -> bool {
        let cos = self.tiles[i].normal.dot(self.tiles[j].normal);
        let size = self.measures[i].area.min(self.measures[j].area).sqrt();
        let lift = size * (1e-3 + 0.6 * ((1.0 - cos).max(0.0) / 2.0).sqrt());
        let above = |k: usize| self.measures[k].centre + self.tiles[k].normal * lift;
        !self.transport.is_some_and(|t| t.separated_inside(above(i), above(j)))
    }
}

impl TileField {
    /// The field with these means, one a tile.
    pub(crate) fn new(values: Vec<Bands>) -> TileField {
        let n = values.len();
        let (fits, free_nodes, nodes) = (LazyValues::new(n), LazyValues::new(n), LazyValues::new(n));
        TileField { values, fits, free_nodes, nodes }
    }

    /// The value at the point of tile `i` with the tile's parameters (u, v).
    pub(crate) fn at(&self, topology: &TileTopology, i: usize, [u, v]: [f64; 2]) -> Bands {
        let (kind, nodes) = (topology.tiles[i].plate.kind, self.nodes(topology, i));
        interpolate(kind, nodes, conserving_centre(kind, nodes, self.values[i]), u, v)
    }

    fn fit(&self, topology: &TileTopology, i: usize) -> &TileFit {
        self.fits.get(i, || self.fit_gradients(topology, i))
    }
    fn free_nodes(&self, topology: &TileTopology, i: usize) -> &[Bands; 8] {
        self.free_nodes.get(i, || self.node_values(topology, i))
    }
    /// Values at the nodes of tile `i`.
    fn nodes(&self, topology: &TileTopology, i: usize) -> &[Bands; 8] {
        self.nodes.get(i, || self.constrain_hanging_nodes(topology, i))
    }

    fn fit_gradients(&self, topology: &TileTopology, i: usize) -> TileFit {
        let mut ids: Vec<u32> = topology.nodes(i).touching.iter().map(|t| t.0).collect();
        ids.sort_unstable();
        ids.dedup();
        let (normal, centre) = (topology.tiles[i].normal, topology.measures[i].centre);
        let mut fits = PerBand::<GradientFit>::default();
        for &j in ids.iter().filter(|j| **j as usize != i) {
            let d = topology.measures[j as usize].centre - centre;
            // Unroll the offset onto the tile's plane, with its length kept.
            let flat = (d - normal * d.dot(normal)).normalized() * d.length();
            let difference = self.values[j as usize] - self.values[i];
            Band::all().for_each(|b| fits[b].add(flat, difference[b]));
        }
        (fits.map(|f| f.gradient()), value_ranges(ids.iter().map(|&j| self.values[j as usize])))
    }

    fn node_values(&self, topology: &TileTopology, i: usize) -> [Bands; 8] {
        let nodes = topology.nodes(i);
        let mut out = [Bands::ZERO; 8];
        let plate = &topology.tiles[i].plate;
        let mut touching = Vec::with_capacity(USUAL_NEIGHBOURS);
        for (k, &[u, v]) in node_parameters(plate.kind).iter().enumerate() {
            touching.clear();
            touching.extend(nodes.touching(k).iter().map(|&(j, angle)| {
                let j = j as usize;
                (angle, topology.measures[j].centre, self.values[j], self.fit(topology, j))
            }));
            let zones = |b: Band| {
                touching.iter().map(move |&(weight, centre, value, fit)| NodeZone {
                    weight,
                    centre,
                    value: value[b],
                    gradient: fit.0[b],
                    range: fit.1[b],
                })
            };
            let p = plate.at(u, v);
            out[k] = Bands::from_fn(|b| node_value(p, zones(b)).unwrap_or(self.values[i][b]));
        }
        out
    }

    /// Hanging nodes take the value of the neighbour whose edge contains them.
    fn constrain_hanging_nodes(&self, topology: &TileTopology, i: usize) -> [Bands; 8] {
        let mut out = *self.free_nodes(topology, i);
        for &(k, host, [u, v]) in &topology.nodes(i).hosts {
            let j = host as usize;
            let kind = topology.tiles[j].plate.kind;
            out[k as usize] = interpolate(kind, self.free_nodes(topology, j), self.values[j], u, v);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    fn floor(n: usize, f: impl Fn(Vec3) -> f64) -> (Vec<PlateTile>, Vec<Bands>, Vec<Plate>) {
        let whole = Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        let h = 1.0 / n as f64;
        let tile = |i: usize| PlateTile {
            plate: Plate::parallelogram(
                vec3((i / n) as f64 * h, (i % n) as f64 * h, 0.0),
                vec3(h, 0.0, 0.0),
                vec3(0.0, h, 0.0),
            ),
            normal: vec3(0.0, 0.0, 1.0),
            sheet: 0,
            is_curved: false,
        };
        let tiles: Vec<PlateTile> = (0..n * n).map(tile).collect();
        let values = tiles.iter().map(|t| Bands::splat(f(t.plate.centre()))).collect();
        (tiles, values, vec![whole])
    }

    #[test]
    fn linear_fields_are_exact_and_curved_fields_second_order() {
        let worst_error = |f: &dyn Fn(Vec3) -> f64| {
            let (tiles, values, sheets) = floor(10, f);
            let field = PatchField::new(tiles, values, &sheets, None);
            let mut worst: f64 = 0.0;
            for i in 0..400 {
                let [x, y] = zonal_math::low_discrepancy::r2(i, [0.0; 2]);
                let p = vec3(x, y, 0.0);
                worst = worst.max((field.at(0, [x, y], p).unwrap().first() - f(p)).abs());
            }
            worst
        };
        assert!(worst_error(&|p| 2.0 + p.x - 0.5 * p.y) < 1e-6);
        assert!(worst_error(&|p| 2.0 + (3.0 * p.x).sin() * p.y) < 0.02);
    }

    #[test]
    fn linear_fields_are_exact_on_triangles() {
        let whole = Plate::triangle(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        let mut plates = vec![whole];
        for _ in 0..3 {
            plates = plates.iter().flat_map(|p| p.quarters()).collect();
        }
        let f = |p: Vec3| 3.0 + p.x - 2.0 * p.y;
        let tiles: Vec<PlateTile> = plates
            .iter()
            .map(|p| PlateTile { plate: *p, normal: whole.normal(), sheet: 0, is_curved: false })
            .collect();
        let values = plates.iter().map(|p| Bands::splat(f(p.centre()))).collect();
        let field = PatchField::new(tiles, values, &[whole], None);
        for i in 0..400 {
            let [u, v] = whole.warp(zonal_math::low_discrepancy::r2(i, [0.0; 2]));
            let p = whole.at(u, v);
            assert!((field.at(0, [u, v], p).unwrap().first() - f(p)).abs() < 1e-6);
        }
    }
}
