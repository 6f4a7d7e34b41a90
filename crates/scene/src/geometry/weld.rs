//! Welding: corners of plates that lie within a tolerance get one number.
//!
//! A hash grid of cells four tolerances wide holds the corners found so far. A new corner takes the number of the first one within the
//! tolerance, in its own cell or, near a border, in the neighbouring ones; rounding therefore never separates two corners. Corners are taken
//! in the order of the plates, so that the numbers do not depend on the hash order.

use crate::geometry::plate::Plate;
use std::collections::HashMap;
use zonal_math::Vec3;

/// Width of a cell of the hash grid, in tolerances.
const CELL_IN_TOLERANCES: f64 = 4.0;

/// Corners of plates by number.
#[derive(Clone, Debug, Default)]
pub(crate) struct WeldedCorners {
    /// Numbers of the corners of each plate; a triangle repeats its third.
    pub(crate) of_plate: Vec<[u32; 4]>,
    /// Position of each number, m.
    pub(crate) points: Vec<Vec3>,
    /// Distance of corners that have one number, m.
    pub(crate) tolerance: f64,
}

/// Corners and their cells while they are welded.
struct WeldGrid {
    lowest: Vec3,
    tolerance: f64,
    /// The last corner of each cell, and of each corner the one before it in its cell.
    last_of_cell: HashMap<[i64; 3], u32>,
    before: Vec<u32>,
    points: Vec<Vec3>,
}

impl WeldGrid {
    fn number(&mut self, p: Vec3) -> u32 {
        let width = CELL_IN_TOLERANCES * self.tolerance;
        let place = [0, 1, 2].map(|k| (p[k] - self.lowest[k]) / width);
        let own = place.map(|x| x.floor() as i64);
        // The neighbour along each axis that is nearer than the tolerance, if any.
        let near = [0, 1, 2].map(|k| {
            let within = place[k] - place[k].floor();
            let margin = 1.0 / CELL_IN_TOLERANCES;
            i64::from(within > 1.0 - margin) - i64::from(within < margin)
        });
        for combination in 0..8 {
            let step = [0, 1, 2].map(|k| if combination >> k & 1 == 1 { near[k] } else { 0 });
            if (0..3).any(|k| combination >> k & 1 == 1 && near[k] == 0) {
                continue;
            }
            let cell = [0, 1, 2].map(|k| own[k] + step[k]);
            let mut at = self.last_of_cell.get(&cell).copied().unwrap_or(u32::MAX);
            while at != u32::MAX {
                if (self.points[at as usize] - p).max_abs() <= self.tolerance {
                    return at;
                }
                at = self.before[at as usize];
            }
        }
        let number = self.points.len() as u32;
        self.before.push(self.last_of_cell.insert(own, number).unwrap_or(u32::MAX));
        self.points.push(p);
        number
    }
}

impl WeldedCorners {
    /// Welds corners nearer than `share` times the extent of all plates.
    pub(crate) fn of(plates: &[Plate], share: f64) -> WeldedCorners {
        let empty = (Vec3::splat(f64::INFINITY), Vec3::splat(f64::NEG_INFINITY));
        let (lowest, highest) =
            plates.iter().map(Plate::bounds).fold(empty, |(lo, hi), (a, b)| (lo.min(a), hi.max(b)));
        let tolerance = ((highest - lowest).max_abs() * share).max(f64::MIN_POSITIVE);
        let mut grid = WeldGrid {
            lowest,
            tolerance,
            last_of_cell: HashMap::with_capacity(plates.len()),
            before: Vec::new(),
            points: Vec::new(),
        };
        let mut of_plate = Vec::with_capacity(plates.len());
        for p in plates {
            let (c, n) = p.corners();
            let mut own = [0; 4];
            (0..n).for_each(|k| own[k] = grid.number(c[k]));
            if n == 3 {
                own[3] = own[2];
            }
            of_plate.push(own);
        }
        WeldedCorners { of_plate, points: grid.points, tolerance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    #[test]
    fn rounding_never_separates_corners() {
        // Two copies of a fan whose corners differ by a tenth of the tolerance, at many places relative to the grid.
        for k in 0..200 {
            let shift = vec3(0.137 * k as f64, 0.0711 * k as f64, 0.0093 * k as f64) * 1e-6;
            let fan = |offset: f64| {
                let at = |x: f64, y: f64| vec3(x + offset, y - offset, offset) + shift;
                Plate::triangle(at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0))
            };
            let far = Plate::triangle(vec3(-0.5, -0.5, 0.5), vec3(-1.0, 0.0, 0.0), vec3(0.0, -1.0, 1.0));
            let corners = WeldedCorners::of(&[far, fan(0.0), fan(2e-7)], 1e-6);
            assert_eq!(corners.of_plate[1], corners.of_plate[2], "{k}");
        }
    }
}
