//! One patch as a quadtree of cells.
//!
//! Points are places (x, y) of a lattice on the patch's parameters, u = x/SIDE, v = y/SIDE, fine enough to contain edge midpoints and centres of
//! the smallest cells: SIDE = 3·2^11, cells of level l have the size SIDE/2^l, a multiple of 6. A cell of a parallelogram is a square of
//! the lattice; a cell of a triangle has its right angle at `at`, upright or (size < 0) rotated by half a turn.

use super::vertex_lighting::VertexLighting;
use std::collections::{HashMap, HashSet};
use zonal_scene::{Band, Bands, PerBand, PlateKind};

/// Largest number of successive splits.
const MAX_LEVELS: u32 = 10;
/// Edge of a patch on the lattice.
pub(super) const LATTICE_SIDE: i32 = 3 << (MAX_LEVELS + 1);
/// Size of the smallest cells on the lattice.
const MIN_CELL_SIZE: i32 = 6;

/// A point of the lattice.
pub(super) type LatticePoint = [i32; 2];

/// A cell of a patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct QuadtreeCell {
    pub at: LatticePoint,
    /// Edge on the lattice; negative for a triangle rotated by half a turn.
    pub size: i32,
    /// Error of linear interpolation, relative to the light nearby; negative where not yet evaluated.
    pub error: f32,
}

/// A patch in cells, with the light at its points.
#[derive(Clone)]
pub(super) struct PatchQuadtree {
    pub patch: usize,
    pub kind: PlateKind,
    pub cells: Vec<QuadtreeCell>,
    /// Corners of cells.
    corners: HashSet<LatticePoint>,
    /// Index of the values of a point, in units of the number of values a point.
    index: HashMap<LatticePoint, u32>,
    values: Vec<PerBand<f32>>,
}

impl PatchQuadtree {
    /// The patch as one cell.
    pub(super) fn new(patch: usize, kind: PlateKind) -> PatchQuadtree {
        let whole = QuadtreeCell { at: [0, 0], size: LATTICE_SIDE, error: -1.0 };
        let corners = corners(kind, &whole).iter().copied().collect();
        let (index, values) = (HashMap::new(), Vec::new());
        PatchQuadtree { patch, kind, cells: vec![whole], corners, index, values }
    }

    /// The plate's parameters of a lattice point.
    pub(super) fn parameters(at: LatticePoint) -> [f64; 2] {
        at.map(|x| x as f64 / LATTICE_SIDE as f64)
    }

    /// The values at a point, evaluated on first use.
    pub(super) fn values(&mut self, lighting: &VertexLighting, at: LatticePoint) -> &[PerBand<f32>] {
        let n = lighting.value_count();
        let next = self.index.len();
        let i = *self.index.entry(at).or_insert(next as u32) as usize;
        if i == next {
            lighting.evaluate(self.patch, PatchQuadtree::parameters(at), &mut self.values);
        }
        &self.values[i * n..(i + 1) * n]
    }

    /// The `n` values at a corner or centre of an evaluated cell.
    pub(super) fn evaluated(&self, n: usize, at: LatticePoint) -> &[PerBand<f32>] {
        let i = self.index[&at] as usize;
        &self.values[i * n..(i + 1) * n]
    }

    /// Lattice coordinates of the corners inside a side, from its start. Side k runs from corner k of the plate to the next.
    pub(super) fn corners_on_side(&self, side: u8) -> impl Iterator<Item = i32> {
        let kind = self.kind;
        let on = move |&[x, y]: &LatticePoint| match (kind, side) {
            (_, 0) => (y == 0).then_some(x),
            (PlateKind::Parallelogram, 1) => (x == LATTICE_SIDE).then_some(y),
            (PlateKind::Parallelogram, 2) => (y == LATTICE_SIDE).then_some(LATTICE_SIDE - x),
            (PlateKind::Triangle, 1) => (x + y == LATTICE_SIDE).then_some(y),
            _ => (x == 0).then_some(LATTICE_SIDE - y),
        };
        self.corners.iter().filter_map(on).filter(|t| (1..LATTICE_SIDE).contains(t))
    }

    /// Adds a corner on a side.
    pub(super) fn add_corner(&mut self, lighting: &VertexLighting, side: u8, t: i32) {
        let place = match (self.kind, side) {
            (_, 0) => [t, 0],
            (PlateKind::Parallelogram, 1) => [LATTICE_SIDE, t],
            (PlateKind::Parallelogram, 2) => [LATTICE_SIDE - t, LATTICE_SIDE],
            (PlateKind::Triangle, 1) => [LATTICE_SIDE - t, t],
            _ => [0, LATTICE_SIDE - t],
        };
        if self.corners.insert(place) {
            self.values(lighting, place);
        }
    }

    /// Number of vertices of its triangles: corners, and the centres of cells with a hanging vertex.
    pub(super) fn vertex_count(&self) -> usize {
        self.corners.len() + self.cells.iter().filter(|p| self.has_hanging_vertex(p)).count()
    }

    /// True where a corner of another cell lies on an edge.
    fn has_hanging_vertex(&self, p: &QuadtreeCell) -> bool {
        midpoints(self.kind, p).iter().any(|m| self.corners.contains(m))
    }

    /// The corners of a cell, and those of others on its edges, counter-clockwise in the plate's parameters.
    pub(super) fn outline(&self, p: &QuadtreeCell) -> Vec<LatticePoint> {
        let corners = corners(self.kind, p);
        let mut out = Vec::with_capacity(corners.len() + 4);
        for (k, &a) in corners.iter().enumerate() {
            out.push(a);
            self.push_between(a, corners[(k + 1) % corners.len()], &mut out);
        }
        out
    }

    /// Appends the corners between two ends of an edge, in order.
    fn push_between(&self, a: LatticePoint, b: LatticePoint, out: &mut Vec<LatticePoint>) {
        let m = midpoint(a, b);
        if (a[0] + b[0]) % 2 == 0 && (a[1] + b[1]) % 2 == 0 && self.corners.contains(&m) {
            self.push_between(a, m, out);
            out.push(m);
            self.push_between(m, b, out);
        }
    }

    /// Replaces a cell by its four parts.
    pub(super) fn split(&mut self, i: usize) {
        let QuadtreeCell { at: [x, y], size, .. } = self.cells[i];
        let h = size / 2;
        let rotated = if self.kind == PlateKind::Triangle { -h } else { h };
        let part = |at: LatticePoint, size: i32| QuadtreeCell { at, size, error: -1.0 };
        let parts =
            [part([x, y], h), part([x + h, y], h), part([x + h, y + h], rotated), part([x, y + h], h)];
        for p in &parts {
            self.corners.extend(corners(self.kind, p));
        }
        self.cells[i] = parts[0];
        self.cells.extend(&parts[1..]);
    }

    /// The longest edge of a cell where that of the patch is `longest`.
    pub(super) fn edge(p: &QuadtreeCell, longest: f64) -> f64 {
        longest * p.size.abs() as f64 / LATTICE_SIDE as f64
    }

    /// True where a cell can be split on the lattice.
    pub(super) fn is_divisible(p: &QuadtreeCell) -> bool {
        p.size.abs() > MIN_CELL_SIZE
    }

    /// The largest error of linear interpolation at the edge midpoints and the centre of a cell, relative to the light nearby.
    pub(super) fn interpolation_error(&mut self, lighting: &VertexLighting, p: &QuadtreeCell) -> f32 {
        let (kind, n) = (self.kind, lighting.value_count());
        let corners = corners(kind, p);
        let at: Vec<Vec<PerBand<f32>>> = corners.iter().map(|c| self.values(lighting, *c).to_vec()).collect();
        let midpoints: Vec<Vec<PerBand<f32>>> =
            midpoints(kind, p).iter().map(|c| self.values(lighting, *c).to_vec()).collect();
        let centre = self.values(lighting, centre(kind, p)).to_vec();
        let mut worst: f64 = 0.0;
        for k in 0..n {
            let all = || at.iter().chain(&midpoints).chain([&centre]).map(move |v| v[k]);
            let largest = all().flatten().fold(0.0f32, f32::max) as f64;
            let level = largest + 0.25 * lighting.means[k] + 0.05 * lighting.means.iter().sum::<f64>();
            let mean = Bands::from_fn(|b| at.iter().map(|v| v[k][b] as f64).sum::<f64>() / at.len() as f64);
            let mut off = Band::all().fold(0.0, |m, b| f64::max(m, (centre[k][b] as f64 - mean[b]).abs()));
            for (e, m) in midpoints.iter().enumerate() {
                let (a, c) = (&at[e][k], &at[(e + 1) % at.len()][k]);
                for b in Band::all() {
                    off = f64::max(off, (m[k][b] as f64 - 0.5 * (a[b] as f64 + c[b] as f64)).abs());
                }
            }
            if level > 0.0 {
                worst = worst.max(off / level);
            }
        }
        worst as f32
    }

    /// Difference between the means of the values of a patch in one cell or four and those of the solution, relative to the light nearby:
    /// it shows features between the points.
    pub(super) fn mean_difference(&mut self, lighting: &VertexLighting, found: &[Bands]) -> f32 {
        let (kind, n) = (self.kind, lighting.value_count());
        let mut means = vec![Bands::ZERO; n];
        for p in self.cells.clone() {
            let points = [corners(kind, &p), midpoints(kind, &p), vec![centre(kind, &p)]];
            let weights = match kind {
                PlateKind::Parallelogram => [1.0 / 36.0, 4.0 / 36.0, 16.0 / 36.0],
                PlateKind::Triangle => [1.0 / 20.0, 2.0 / 15.0, 9.0 / 20.0],
            };
            let area = 1.0 / self.cells.len() as f64;
            for (list, w) in points.iter().zip(weights) {
                for &place in list {
                    let v = self.values(lighting, place);
                    (0..n).for_each(|k| means[k] += area * w * v[k].map(f64::from));
                }
            }
        }
        let mut worst: f64 = 0.0;
        for k in (0..n).filter(|k| lighting.has_zone_mean[*k]) {
            let level = found[k].into_iter().fold(0.0, f64::max) + 0.25 * lighting.means[k];
            let off = (means[k] - found[k]).abs().iter().copied().fold(0.0, f64::max);
            if level > 0.0 {
                worst = worst.max(off / level);
            }
        }
        worst as f32
    }
}

fn midpoint(a: LatticePoint, b: LatticePoint) -> LatticePoint {
    [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]
}

/// The corners of a cell, counter-clockwise in the plate's parameters.
pub(super) fn corners(kind: PlateKind, p: &QuadtreeCell) -> Vec<LatticePoint> {
    let ([x, y], s) = (p.at, p.size);
    match kind {
        PlateKind::Parallelogram => vec![[x, y], [x + s, y], [x + s, y + s], [x, y + s]],
        PlateKind::Triangle => vec![[x, y], [x + s, y], [x, y + s]],
    }
}

/// The edge midpoints of a cell, in the order of the corners at which the edges begin.
fn midpoints(kind: PlateKind, p: &QuadtreeCell) -> Vec<LatticePoint> {
    let c = corners(kind, p);
    (0..c.len()).map(|k| midpoint(c[k], c[(k + 1) % c.len()])).collect()
}

/// The centroid of a cell.
pub(super) fn centre(kind: PlateKind, p: &QuadtreeCell) -> LatticePoint {
    let parts = if kind == PlateKind::Triangle { 3 } else { 2 };
    p.at.map(|x| x + p.size / parts)
}
