//! Points in grids of several cell sizes, to find those near a place.
//!
//! The cells of each grid are half as large as those of the one before. A search takes the finest grid whose cells are at least half as large as its radius, and
//! visits the lines of cells that meet the ball around the place, each as far as the ball reaches. Its cost is that of the points nearby, also where the distances
//! between points vary over the scene. Points are sorted by cell, so that those of the cells in a line follow one another, and are compared eight at a time in
//! single precision, with the radius widened by the rounding.
//!
//! Memory: at most 32 bytes a point and grid.

use std::ops::Range;
use zonal_math::Vec3;
use zonal_math::parallel;
use zonal_math::simd::{self, SimdKernel};

/// Number of grids.
const LEVELS: usize = 8;
/// Smallest cell over the radius of a search.
const MIN_CELL_OVER_RADIUS: f64 = 0.5;
/// Points whose distances are computed together.
const POINTS_AT_ONCE: usize = 8;
/// Largest coordinate of a cell.
const MAX_COORDINATE: f64 = 1e9;

/// Points in grids of several cell sizes.
///
/// ```
/// use zonal_math::vec3;
/// use zonal_transport::point_grids::PointGrids;
///
/// let points: Vec<_> = (0..100).map(|i| vec3(f64::from(i), 0.0, 0.0)).collect();
/// let grids = PointGrids::new(&points, 8.0);
/// let mut near = Vec::new();
/// grids.for_each_near(vec3(50.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), 2.0, 1.0, |i| near.push(i));
/// assert!([48, 49, 50, 51, 52].iter().all(|i| near.contains(i)) && near.len() < 8);
/// ```
pub struct PointGrids {
    /// From coarse to fine.
    grids: Vec<SortedPoints>,
    /// The middle of the points.
    origin: Vec3,
    /// Bound of the error of a distance between two points in single precision.
    rounding: f64,
}

/// Points by the cells of one grid.
struct SortedPoints {
    /// Edge of a cell.
    cell: f64,
    /// The occupied cells in order, each with the place in `order` where its points begin.
    cells: Vec<([i32; 3], u32)>,
    order: Vec<u32>,
    /// Coordinates of the points in this order, from the origin, in single precision.
    points: [Vec<f32>; 3],
}

impl PointGrids {
    /// Sorts points into grids, for searches within at most `largest_radius`.
    #[must_use]
    pub fn new(points: &[Vec3], largest_radius: f64) -> PointGrids {
        let levels = if points.is_empty() { 0 } else { LEVELS };
        let low = points.iter().copied().reduce(Vec3::min).unwrap_or(Vec3::ZERO);
        let high = points.iter().copied().reduce(Vec3::max).unwrap_or(Vec3::ZERO);
        let origin = (low + high) * 0.5;
        let grid = |level: usize| SortedPoints::new(points, origin, largest_radius / (1u32 << level) as f64);
        PointGrids {
            grids: parallel::collect(levels, grid),
            origin,
            rounding: 8.0 * f64::from(f32::EPSILON) * (high - origin).max_abs(),
        }
    }

    /// Calls `visit` with the index of every point within `radius` of `centre` and within `height_share` of that from the plane through `centre` with the unit normal
    /// `normal`, and of some that are farther away; `radius` must not exceed that of the grids, and `centre` must lie among the points. A share of 1 finds all
    /// points of the ball, and no other beyond a rounding error; a smaller one takes less time.
    pub fn for_each_near(
        &self,
        centre: Vec3,
        normal: Vec3,
        radius: f64,
        height_share: f64,
        mut visit: impl FnMut(usize),
    ) {
        let fits = |g: &&SortedPoints| g.cell >= MIN_CELL_OVER_RADIUS * radius;
        let Some(grid) = self.grids.iter().rfind(fits) else { return };
        // Half the bounds of a disc in the plane with that height.
        let half = |n: f64| radius * ((1.0 - n * n).max(0.0).sqrt() + height_share * n.abs()).min(1.0);
        let half = Vec3::from_array(normal.array().map(half)) + Vec3::splat(self.rounding);
        let (from, reach) = (centre - self.origin, radius + self.rounding);
        simd::run(NearSearch { grid, from, reach, half, visit: &mut visit });
    }
}

/// A search for the points within `reach` of a place.
struct NearSearch<'a, F> {
    grid: &'a SortedPoints,
    /// The place, from the origin.
    from: Vec3,
    reach: f64,
    /// Largest distance along each axis.
    half: Vec3,
    visit: &'a mut F,
}

impl<F: FnMut(usize)> SimdKernel for NearSearch<'_, F> {
    type Output = ();
    #[inline(always)]
    fn evaluate(self) {
        let NearSearch { grid, from, reach, half, visit } = self;
        let [low, high] = [from - half, from + half].map(|p| grid.key(p));
        let (centre, reach2) = (single(from), (reach * reach) as f32 * (1.0 + 4.0 * f32::EPSILON));
        for x in low[0]..=high[0] {
            let beside = grid.distance_to_cells(0, x, from);
            for y in low[1]..=high[1] {
                let across2 = beside * beside + grid.distance_to_cells(1, y, from).powi(2);
                if across2 > reach * reach {
                    continue;
                }
                let along = (reach * reach - across2).sqrt().min(half.z);
                let ends = [from.z - along, from.z + along].map(|z| grid.coordinate(z));
                grid.for_each_within(grid.points_in_line([x, y], ends), centre, reach2, visit);
            }
        }
    }
}

fn single(p: Vec3) -> [f32; 3] {
    p.array().map(|x| x as f32)
}

impl SortedPoints {
    fn new(points: &[Vec3], origin: Vec3, cell: f64) -> SortedPoints {
        let mut grid =
            SortedPoints { cell, cells: Vec::new(), order: Vec::new(), points: [const { Vec::new() }; 3] };
        let mut keyed: Vec<([i32; 3], u32)> =
            (0..).zip(points).map(|(i, p)| (grid.key(*p - origin), i)).collect();
        keyed.sort_unstable();
        let mut at = 0;
        for run in keyed.chunk_by(|a, b| a.0 == b.0) {
            grid.cells.push((run[0].0, at));
            at += run.len() as u32;
        }
        grid.order = keyed.into_iter().map(|x| x.1).collect();
        let coordinate = |i: &u32, k: usize| single(points[*i as usize] - origin)[k];
        grid.points = [0, 1, 2].map(|k| grid.order.iter().map(|i| coordinate(i, k)).collect());
        grid
    }

    /// Places in `order` of the points of the cells from `low` to `high` along the third axis.
    fn points_in_line(&self, [x, y]: [i32; 2], [low, high]: [i32; 2]) -> Range<usize> {
        let first = self.cells.partition_point(|c| c.0 < [x, y, low]);
        let after = self.cells[first..].iter().find(|c| c.0 > [x, y, high]);
        let start = |c: Option<&([i32; 3], u32)>| c.map_or(self.order.len(), |c| c.1 as usize);
        start(self.cells.get(first))..start(after)
    }

    /// Calls `visit` with those of the points at these places that lie within a distance of `centre`.
    #[inline(always)]
    fn for_each_within(
        &self,
        places: Range<usize>,
        centre: [f32; 3],
        distance2: f32,
        visit: &mut impl FnMut(usize),
    ) {
        let [x, y, z] = [0, 1, 2].map(|k| self.points[k][places.clone()].as_chunks());
        // The rest is filled up with points that are infinitely far away.
        let mut rest = [[f32::INFINITY; POINTS_AT_ONCE]; 3];
        rest.iter_mut().zip([x.1, y.1, z.1]).for_each(|(all, part)| all[..part.len()].copy_from_slice(part));
        for (block, order) in self.order[places].chunks(POINTS_AT_ONCE).enumerate() {
            let [x, y, z] =
                if block < x.0.len() { [&x.0[block], &y.0[block], &z.0[block]] } else { rest.each_ref() };
            let mut square = [0.0; POINTS_AT_ONCE];
            for k in 0..POINTS_AT_ONCE {
                let d = [x[k] - centre[0], y[k] - centre[1], z[k] - centre[2]];
                square[k] = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            }
            for (i, square) in order.iter().zip(square) {
                if square <= distance2 {
                    visit(*i as usize);
                }
            }
        }
    }

    /// The cell of a point, from the origin.
    fn key(&self, p: Vec3) -> [i32; 3] {
        p.array().map(|x| self.coordinate(x))
    }

    /// Coordinate of the cells that hold the points of this coordinate, from the origin.
    fn coordinate(&self, x: f64) -> i32 {
        (x / self.cell).floor().clamp(-MAX_COORDINATE, MAX_COORDINATE) as i32
    }

    /// Distance along an axis of a place from the cells of a coordinate.
    fn distance_to_cells(&self, axis: usize, coordinate: i32, from: Vec3) -> f64 {
        let (low, x) = (f64::from(coordinate) * self.cell, from.array()[axis]);
        (low - x).max(x - low - self.cell).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::low_discrepancy::r3;
    use zonal_math::vec3;

    #[test]
    fn every_point_within_the_radius_is_visited_once() {
        // Points of very different distances: dense near the origin.
        let points: Vec<Vec3> = (0..2000)
            .map(|i| {
                let [x, y, z] = r3(i, [0.2, 0.4, 0.6]);
                Vec3::from_array([x - 0.5, y - 0.5, z - 0.5]) * (4.0 * x.powi(3))
            })
            .collect();
        let grids = PointGrids::new(&points, 1.0);
        let normal = vec3(2.0, -1.0, 0.5).normalized();
        for radius in [1.0, 0.3, 0.04, 0.001] {
            for centre in points.iter().step_by(97) {
                let mut visits = vec![0; points.len()];
                grids.for_each_near(*centre, normal, radius, 1.0, |i| visits[i] += 1);
                for (p, n) in points.iter().zip(&visits) {
                    assert!(*n <= 1 && (*n == 1 || (*p - *centre).length() > radius));
                }
                let far = |(p, n): (&Vec3, &i32)| *n == 1 && (*p - *centre).length() > radius + 1e-5;
                assert!(!points.iter().zip(&visits).any(far), "no other point is visited");
            }
        }
        // Points near a plane are found, too.
        for centre in points.iter().step_by(97) {
            let mut found = vec![false; points.len()];
            grids.for_each_near(*centre, normal, 0.5, 0.2, |i| found[i] = true);
            let is_near =
                |p: &Vec3| (*p - *centre).length() <= 0.5 && (*p - *centre).dot(normal).abs() <= 0.1;
            assert!(points.iter().zip(&found).all(|(p, found)| *found || !is_near(p)));
        }
        grids.for_each_near(points[0], normal, 2.5, 1.0, |_| panic!("the radius is too large"));
        PointGrids::new(&[], 1.0)
            .for_each_near(Vec3::ZERO, normal, 0.5, 1.0, |_| panic!("there are no points"));
    }
}
