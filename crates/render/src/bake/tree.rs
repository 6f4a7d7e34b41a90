//! One patch, halved both ways where its light asks for it.
//!
//! Points are places (x, y) of a lattice on the patch's parameters, u = x/SIDE, v = y/SIDE, so fine that edge middles and centres of the
//! smallest pieces are among them: SIDE = 3·2^11, pieces of level l have the size SIDE/2^l, a multiple of 6. A piece of a parallelogram is
//! a square of the lattice; of a triangle one with its right angle at `at`, upright or (size < 0) turned by half a turn.

use super::light::Lights;
use std::collections::{HashMap, HashSet};
use zonal_scene::{PlateKind, bands};

/// Halvings at most.
pub(super) const LEVELS: u32 = 10;
/// Edge of a patch on the lattice.
pub(super) const SIDE: i32 = 3 << (LEVELS + 1);

/// A place of the lattice.
pub(super) type Place = [i32; 2];

/// A piece of a patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub at: Place,
    /// Edge on the lattice; negative for a triangle turned by half a turn.
    pub size: i32,
    /// Difference from linear interpolation, relative to the light about; negative where not yet known.
    pub deviation: f32,
}

/// A patch in pieces, with the light at its points.
pub(super) struct Tree {
    pub patch: usize,
    pub kind: PlateKind,
    pub pieces: Vec<Piece>,
    /// Corners of pieces.
    corners: HashSet<Place>,
    /// Where the values of a point lie, in units of the number of values a point.
    index: HashMap<Place, u32>,
    values: Vec<[f32; 3]>,
}

impl Tree {
    /// The patch as one piece.
    pub(super) fn new(patch: usize, kind: PlateKind) -> Tree {
        let whole = Piece { at: [0, 0], size: SIDE, deviation: -1.0 };
        let corners = corners(kind, &whole).iter().copied().collect();
        let (index, values) = (HashMap::new(), Vec::new());
        Tree { patch, kind, pieces: vec![whole], corners, index, values }
    }

    /// The plate's parameters of a place.
    pub(super) fn parameters(at: Place) -> [f64; 2] {
        at.map(|x| x as f64 / SIDE as f64)
    }

    /// The values at a place, evaluated when first asked for.
    pub(super) fn values(&mut self, lights: &Lights, at: Place) -> &[[f32; 3]] {
        let n = lights.values();
        let next = self.index.len();
        let i = *self.index.entry(at).or_insert(next as u32) as usize;
        if i == next {
            lights.at(self.patch, Tree::parameters(at), &mut self.values);
        }
        &self.values[i * n..(i + 1) * n]
    }

    /// The `n` values at a corner or centre of a piece that has been judged.
    pub(super) fn known(&self, n: usize, at: Place) -> &[[f32; 3]] {
        let i = self.index[&at] as usize;
        &self.values[i * n..(i + 1) * n]
    }

    /// Where corners lie inside a side, from its beginning, on the lattice. Side k runs from corner k of the plate to the next.
    pub(super) fn border(&self, side: u8) -> impl Iterator<Item = i32> {
        let kind = self.kind;
        let on = move |&[x, y]: &Place| match (kind, side) {
            (_, 0) => (y == 0).then_some(x),
            (PlateKind::Parallelogram, 1) => (x == SIDE).then_some(y),
            (PlateKind::Parallelogram, 2) => (y == SIDE).then_some(SIDE - x),
            (PlateKind::Triangle, 1) => (x + y == SIDE).then_some(y),
            _ => (x == 0).then_some(SIDE - y),
        };
        self.corners.iter().filter_map(on).filter(|t| (1..SIDE).contains(t))
    }

    /// Puts a corner on a side.
    pub(super) fn add_corner(&mut self, lights: &Lights, side: u8, t: i32) {
        let place = match (self.kind, side) {
            (_, 0) => [t, 0],
            (PlateKind::Parallelogram, 1) => [SIDE, t],
            (PlateKind::Parallelogram, 2) => [SIDE - t, SIDE],
            (PlateKind::Triangle, 1) => [SIDE - t, t],
            _ => [0, SIDE - t],
        };
        if self.corners.insert(place) {
            self.values(lights, place);
        }
    }

    /// Vertices of its triangles: corners, and the centres of pieces that have one on an edge.
    pub(super) fn vertices(&self) -> usize {
        self.corners.len() + self.pieces.iter().filter(|p| self.hangs(p)).count()
    }

    /// True where a corner of another piece lies on an edge.
    pub(super) fn hangs(&self, p: &Piece) -> bool {
        middles(self.kind, p).iter().any(|m| self.corners.contains(m))
    }

    /// The corners of a piece, and those of others on its edges, counter-clockwise in the plate's parameters.
    pub(super) fn outline(&self, p: &Piece) -> Vec<Place> {
        let corners = corners(self.kind, p);
        let mut out = Vec::with_capacity(corners.len() + 4);
        for (k, &a) in corners.iter().enumerate() {
            out.push(a);
            self.between(a, corners[(k + 1) % corners.len()], &mut out);
        }
        out
    }

    fn between(&self, a: Place, b: Place, out: &mut Vec<Place>) {
        let m = middle(a, b);
        if (a[0] + b[0]) % 2 == 0 && (a[1] + b[1]) % 2 == 0 && self.corners.contains(&m) {
            self.between(a, m, out);
            out.push(m);
            self.between(m, b, out);
        }
    }

    /// Puts the four parts of a piece in its place.
    pub(super) fn split(&mut self, i: usize) {
        let Piece { at: [x, y], size, .. } = self.pieces[i];
        let h = size / 2;
        let turned = if self.kind == PlateKind::Triangle { -h } else { h };
        let part = |at: Place, size: i32| Piece { at, size, deviation: -1.0 };
        let parts = [part([x, y], h), part([x + h, y], h), part([x + h, y + h], turned), part([x, y + h], h)];
        for p in &parts {
            self.corners.extend(corners(self.kind, p));
        }
        self.pieces[i] = parts[0];
        self.pieces.extend(&parts[1..]);
    }

    /// The longest edge of a piece where that of the patch is `longest`.
    pub(super) fn edge(p: &Piece, longest: f64) -> f64 {
        longest * p.size.abs() as f64 / SIDE as f64
    }

    /// True where a piece can be halved on the lattice.
    pub(super) fn divisible(p: &Piece) -> bool {
        p.size.abs() > 6
    }

    /// The largest difference of edge middles and centre of a piece from linear interpolation, relative to the light about.
    pub(super) fn deviation(&mut self, lights: &Lights, p: &Piece) -> f32 {
        let (kind, n) = (self.kind, lights.values());
        let corners = corners(kind, p);
        let at: Vec<Vec<[f32; 3]>> = corners.iter().map(|c| self.values(lights, *c).to_vec()).collect();
        let middles: Vec<Vec<[f32; 3]>> =
            middles(kind, p).iter().map(|c| self.values(lights, *c).to_vec()).collect();
        let centre = self.values(lights, centre(kind, p)).to_vec();
        let mut worst: f64 = 0.0;
        for k in 0..n {
            let all = || at.iter().chain(&middles).chain([&centre]).map(move |v| v[k]);
            let most = all().flatten().fold(0.0f32, f32::max) as f64;
            let level = most + 0.25 * lights.means[k] + 0.05 * lights.means.iter().sum::<f64>();
            let mean = bands(|b| at.iter().map(|v| v[k][b] as f64).sum::<f64>() / at.len() as f64);
            let mut off = (0..3).fold(0.0, |m, b| f64::max(m, (centre[k][b] as f64 - mean[b]).abs()));
            for (e, m) in middles.iter().enumerate() {
                let (a, c) = (&at[e][k], &at[(e + 1) % at.len()][k]);
                for b in 0..3 {
                    off = f64::max(off, (m[k][b] as f64 - 0.5 * (a[b] as f64 + c[b] as f64)).abs());
                }
            }
            if level > 0.0 {
                worst = worst.max(off / level);
            }
        }
        worst as f32
    }

    /// How far the means of the values of a patch in one piece or four are from those that the solver found, relative to the
    /// light about: what lies between the points shows there.
    pub(super) fn missed(&mut self, lights: &Lights, found: &[[f64; 3]]) -> f32 {
        let (kind, n) = (self.kind, lights.values());
        let mut means = vec![[0.0; 3]; n];
        for p in self.pieces.clone() {
            let points = [corners(kind, &p), middles(kind, &p), vec![centre(kind, &p)]];
            let weights = match kind {
                PlateKind::Parallelogram => [1.0 / 36.0, 4.0 / 36.0, 16.0 / 36.0],
                PlateKind::Triangle => [1.0 / 20.0, 2.0 / 15.0, 9.0 / 20.0],
            };
            let share = 1.0 / self.pieces.len() as f64;
            for (list, w) in points.iter().zip(weights) {
                for &place in list {
                    let v = self.values(lights, place);
                    (0..n).for_each(|k| (0..3).for_each(|b| means[k][b] += share * w * v[k][b] as f64));
                }
            }
        }
        let mut worst: f64 = 0.0;
        for k in 1..n {
            let level = found[k].into_iter().fold(0.0, f64::max) + 0.25 * lights.means[k];
            let off = (0..3).fold(0.0, |m, b| f64::max(m, (means[k][b] - found[k][b]).abs()));
            if level > 0.0 {
                worst = worst.max(off / level);
            }
        }
        worst as f32
    }
}

fn middle(a: Place, b: Place) -> Place {
    [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]
}

/// The corners of a piece, counter-clockwise in the plate's parameters.
pub(super) fn corners(kind: PlateKind, p: &Piece) -> Vec<Place> {
    let ([x, y], s) = (p.at, p.size);
    match kind {
        PlateKind::Parallelogram => vec![[x, y], [x + s, y], [x + s, y + s], [x, y + s]],
        PlateKind::Triangle => vec![[x, y], [x + s, y], [x, y + s]],
    }
}

/// The edge middles of a piece, each after the corner with which its edge begins.
fn middles(kind: PlateKind, p: &Piece) -> Vec<Place> {
    let c = corners(kind, p);
    (0..c.len()).map(|k| middle(c[k], c[(k + 1) % c.len()])).collect()
}

/// The centroid of a piece.
pub(super) fn centre(kind: PlateKind, p: &Piece) -> Place {
    let parts = if kind == PlateKind::Triangle { 3 } else { 2 };
    p.at.map(|x| x + p.size / parts)
}
