//! Cells of directions: rectangles on the faces of a cube around the origin.

use zonal_math::Vec3;

/// Directions d with d[axis] = sign and d[axis + 1], d[axis + 2] (cyclic) within two ranges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DirectionCell {
    pub axis: usize,
    pub sign: f64,
    pub range: [[f64; 2]; 2],
}

impl DirectionCell {
    /// The six faces, each in n × n cells; n even, so that no cell lies on both sides of a coordinate plane.
    pub(crate) fn sphere(n: usize) -> Vec<DirectionCell> {
        let step = |k: usize| [2.0 * k as f64 / n as f64 - 1.0, 2.0 * (k + 1) as f64 / n as f64 - 1.0];
        let mut cells = Vec::with_capacity(6 * n * n);
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                for u in 0..n {
                    cells.extend((0..n).map(|v| DirectionCell { axis, sign, range: [step(u), step(v)] }));
                }
            }
        }
        cells
    }

    /// The four corners, counter-clockwise for an observer at the origin.
    pub(crate) fn corners(&self) -> [Vec3; 4] {
        let [[a, b], [c, d]] = self.range;
        let at = |u: f64, v: f64| {
            let mut x = [0.0; 3];
            (x[self.axis], x[(self.axis + 1) % 3], x[(self.axis + 2) % 3]) = (self.sign, u, v);
            Vec3::from_array(x)
        };
        if self.sign > 0.0 {
            [at(a, d), at(b, d), at(b, c), at(a, c)]
        } else {
            [at(a, c), at(b, c), at(b, d), at(a, d)]
        }
    }

    /// Four cells of half the size.
    pub(crate) fn quarters(&self) -> [DirectionCell; 4] {
        let [[a, b], [c, d]] = self.range;
        let (m, n) = (0.5 * (a + b), 0.5 * (c + d));
        [[[a, m], [c, n]], [[m, b], [c, n]], [[a, m], [n, d]], [[m, b], [n, d]]]
            .map(|range| DirectionCell { range, ..*self })
    }

    /// Smallest and largest modulus of each coordinate; no range has zero inside.
    pub(crate) fn extremes(&self) -> ([f64; 3], [f64; 3]) {
        let (mut least, mut most) = ([1.0; 3], [1.0; 3]);
        for (k, [a, b]) in self.range.iter().enumerate() {
            let axis = (self.axis + 1 + k) % 3;
            least[axis] = a.abs().min(b.abs());
            most[axis] = a.abs().max(b.abs());
        }
        (least, most)
    }

    /// The mean of the corners.
    pub(crate) fn centre(&self) -> Vec3 {
        self.corners().into_iter().fold(Vec3::ZERO, |s, c| s + c) * 0.25
    }
}
