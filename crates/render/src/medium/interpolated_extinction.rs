//! The extinction between the cells of a sampled density: trilinear between values at the centres of the cells.
//!
//! A cell of a density that samples a smooth field ([`VoxelGrid::mark_interpolated`]) has the mean extinction κ_c. Pictures use the trilinear field of node values v at
//! the centres, whose mean over a cell is (M v)_c: per axis with the weights 1/8, 3/4, 1/8. The node values are those of van Cittert's iteration
//!
//! ```text
//! v ← max(0, v + κ − M v),   first v = κ
//! ```
//!
//! so that the mean of the field over a cell is its extinction κ_c, to about a thousandth where the density varies little from cell to cell and to a hundredth at its
//! borders, and the integral over the medium likewise that of the cells but for nodes at 0. Towards a neighbour that is no such cell, or outside, the field is constant.
//!
//! A ray is cut where it crosses the planes through the centre of a cell; between cuts the field is a cubic polynomial of the distance, whose integral by two Gauss
//! points is exact. Each part has the mean extinction between its cuts, so that optical depths at the cuts are those of the field.

use zonal_math::Vec3;
use zonal_math::parallel;
use zonal_scene::{Bands, VoxelGrid};

/// Passes of van Cittert's iteration.
const PASSES: usize = 3;
/// The two Gauss–Legendre points on [0,1].
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];
/// Weight of the neighbour's node in the mean over the half of a cell along an axis.
const NEIGHBOUR_WEIGHT: f64 = 0.25;

/// The field of the extinction of a medium.
pub(crate) struct InterpolatedExtinction<'a> {
    grid: &'a VoxelGrid,
    /// v of every cell, 1/m.
    nodes: Vec<Bands>,
}

impl<'a> InterpolatedExtinction<'a> {
    /// The field of a grid; `None` where no cell is interpolated.
    pub(crate) fn new(grid: &'a VoxelGrid) -> Option<InterpolatedExtinction<'a>> {
        if !grid.has_interpolated_cells() || grid.uniform_extinction().is_some() {
            return None;
        }
        let nodes = (0..grid.len()).map(|i| grid.extinction(i)).collect();
        let mut field = InterpolatedExtinction { grid, nodes };
        for _ in 0..PASSES {
            let corrected = |i: usize| {
                if grid.is_interpolated(i) {
                    (field.nodes[i] + grid.extinction(i) - field.mean(i)).max(Bands::ZERO)
                } else {
                    field.nodes[i]
                }
            };
            field.nodes = parallel::collect(grid.len(), corrected);
        }
        Some(field)
    }

    /// True for a cell in which the extinction varies.
    pub(crate) fn is_interpolated(&self, cell: usize) -> bool {
        self.grid.is_interpolated(cell)
    }

    /// Mean of the field over a cell, 1/m.
    fn mean(&self, cell: usize) -> Bands {
        let octants = (0..8).map(|o| self.blend(cell, o, [NEIGHBOUR_WEIGHT; 3]));
        octants.sum::<Bands>() / 8.0
    }

    /// The field at a point of a cell, 1/m.
    fn at(&self, cell: usize, p: Vec3) -> Bands {
        let centre = self.grid.centre(self.grid.coordinates(cell));
        let offset = [0, 1, 2].map(|k| (p[k] - centre[k]) / self.grid.cell()[k]);
        let octant = (0..3).fold(0, |o, k| o | usize::from(offset[k] > 0.0) << k);
        self.blend(cell, octant, offset.map(|x| x.abs().min(0.5)))
    }

    /// The node values around the centre of a cell, blended in octant `octant` with the weight `t` of the neighbour along each axis.
    fn blend(&self, cell: usize, octant: usize, t: [f64; 3]) -> Bands {
        let weight = |corner: usize| -> f64 {
            (0..3).map(|k| if corner >> k & 1 == 1 { t[k] } else { 1.0 - t[k] }).product()
        };
        (0..8).map(|corner| self.nodes[self.neighbour(cell, octant, corner)] * weight(corner)).sum()
    }

    /// The cell beside `cell` along the axes of the bits of `corner`, upwards where `octant` has the bit; where that is no interpolated cell, the one along fewer of the
    /// axes.
    fn neighbour(&self, cell: usize, octant: usize, corner: usize) -> usize {
        let at = self.grid.coordinates(cell);
        let dims = self.grid.dims();
        let along = |axes: usize| {
            let mut to = at;
            for k in (0..3).filter(|k| axes >> k & 1 == 1) {
                to[k] = match octant >> k & 1 {
                    1 => at[k] + 1,
                    _ => at[k].checked_sub(1)?,
                };
            }
            let inside = (0..3).all(|k| to[k] < dims[k]);
            inside.then(|| self.grid.index(to)).filter(|i| self.grid.is_interpolated(*i))
        };
        let fewer =
            [corner, corner & 0b011, corner & 0b101, corner & 0b110, corner & 1, corner & 2, corner & 4];
        fewer.into_iter().find_map(along).unwrap_or(cell)
    }

    /// Parts of a ray within a cell: calls `part` with the ends of each, m along the ray from `at(t0)` to `at(t1)`, and its mean extinction, 1/m.
    pub(crate) fn for_each_part(
        &self,
        cell: usize,
        at: impl Fn(f64) -> Vec3,
        t0: f64,
        t1: f64,
        mut part: impl FnMut(f64, f64, Bands),
    ) {
        let centre = self.grid.centre(self.grid.coordinates(cell));
        let (start, end) = (at(t0), at(t1));
        let crossing = |k: usize| {
            let (a, b) = (start[k] - centre[k], end[k] - centre[k]);
            if a * b < 0.0 { t0 + (t1 - t0) * (a / (a - b)) } else { t1 }
        };
        let mut cuts = [crossing(0), crossing(1), crossing(2), t1];
        cuts.sort_by(f64::total_cmp);
        let mut from = t0;
        for to in cuts {
            if to > from {
                let points = GAUSS.map(|g| self.at(cell, at(from + g * (to - from))));
                part(from, to, 0.5 * (points[0] + points[1]));
                from = to;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    /// A grid of 12 × 10 × 8 cells with a smooth extinction, interpolated in the cells that `marked` selects.
    fn grid(extinction: impl Fn(Vec3) -> f64, marked: impl Fn([usize; 3]) -> bool) -> VoxelGrid {
        let mut grid = VoxelGrid::new(vec3(-0.6, 0.0, 1.0), vec3(0.1, 0.2, 0.15), [12, 10, 8]).unwrap();
        for i in 0..grid.len() {
            let c = grid.coordinates(i);
            let k = Bands::splat(extinction(grid.centre(c)));
            grid.set(i, k, Bands::ZERO, Bands::ZERO, Bands::ZERO);
            if marked(c) {
                grid.mark_interpolated(i);
            }
        }
        grid.seal().unwrap()
    }

    #[test]
    fn the_mean_over_a_cell_is_its_extinction() {
        let smooth = |p: Vec3| 2.0 + (2.0 * p.x).sin() + (1.5 * p.y + p.z).cos();
        let grid = grid(smooth, |_| true);
        let field = InterpolatedExtinction::new(&grid).unwrap();
        for i in 0..grid.len() {
            let c = grid.coordinates(i);
            let inner = (0..3).all(|k| c[k] > 2 && c[k] + 3 < grid.dims()[k]);
            let off = (field.mean(i) / grid.extinction(i)).first() - 1.0;
            assert!(off.abs() < if inner { 5e-4 } else { 1e-2 }, "{c:?}: {off}");
        }
        let total = |f: &dyn Fn(usize) -> Bands| (0..grid.len()).map(|i| f(i).first()).sum::<f64>();
        let (fields, cells) = (total(&|i| field.mean(i)), total(&|i| grid.extinction(i)));
        assert!((fields / cells - 1.0).abs() < 1e-3, "{fields} {cells}");
    }

    // Guards (pictures): approximations of the renderer agree with exact evaluation: interpolated extinction.
    #[test]
    fn the_field_is_continuous_and_its_depth_exact() {
        let step = |p: Vec3| if p.x > 0.05 { 3.0 } else { 0.5 + p.y };
        let grid = grid(step, |c| c[2] < 6 && c != [5, 5, 3]);
        let field = InterpolatedExtinction::new(&grid).unwrap();
        let (a, b) = (vec3(-0.57, 0.13, 1.02), vec3(0.55, 1.87, 1.88));
        let at = |t: f64| a + (b - a) * t;
        // From cell to cell of the interpolated part the field is continuous.
        let cell_at = |t: f64| grid.index(grid.cell_at(at(t)).unwrap());
        let (mut last, mut sum, n) = (None, 0.0, 40_000);
        let mut by_parts = 0.0;
        let mut entered = 0.0;
        for k in 0..n {
            let t = (k as f64 + 0.5) / n as f64;
            let cell = cell_at(t);
            if !field.is_interpolated(cell) {
                last = None;
                entered = t + 0.5 / n as f64;
                continue;
            }
            let here = field.at(cell, at(t)).first();
            if let Some(before) = last {
                let jump: f64 = here - before;
                assert!(jump.abs() < 2e-3, "{t}: {jump}");
            }
            last = Some(here);
            sum += here / n as f64;
            if k + 1 == n || cell_at((k as f64 + 1.5) / n as f64) != cell {
                let end = t + 0.5 / n as f64;
                field.for_each_part(cell, at, entered, end, |t0, t1, mean| {
                    by_parts += mean.first() * (t1 - t0);
                });
                entered = end;
            }
        }
        assert!(sum > 0.5 && (by_parts / sum - 1.0).abs() < 1e-6, "{by_parts} {sum}");
    }
}
