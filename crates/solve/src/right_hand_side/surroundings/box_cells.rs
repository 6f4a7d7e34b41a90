//! The sides of the bounding box of a scene, divided into cells.

use zonal_math::Vec3;
use zonal_scene::Scene;

/// Number of cells along the longest side.
pub(super) const CELLS_ALONG_LONGEST_SIDE: f64 = 32.0;

/// A rectangular cell of a side: one corner, two edges, and the outward normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoxCell {
    pub corner: Vec3,
    pub edges: [Vec3; 2],
    pub normal: Vec3,
}

impl BoxCell {
    pub(super) fn centre(&self) -> Vec3 {
        self.corner + (self.edges[0] + self.edges[1]) * 0.5
    }
    pub(super) fn area(&self) -> f64 {
        self.edges[0].length() * self.edges[1].length()
    }
}

/// The bounding box, and the number of cells along its edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoxSides {
    low: [f64; 3],
    high: [f64; 3],
    cells: [usize; 3],
}

impl BoxSides {
    /// The sides with `cells` cells along the longest one.
    pub(super) fn of(scene: &Scene, cells: f64) -> BoxSides {
        let [low, high] = [scene.bounds().0, scene.bounds().1].map(Vec3::array);
        let longest = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        let along = |k: usize| (cells * (high[k] - low[k]) / longest).ceil().max(1.0) as usize;
        BoxSides { low, high, cells: [0, 1, 2].map(along) }
    }

    /// The two axes along a side with a normal along `axis`.
    fn tangents(axis: usize) -> [usize; 2] {
        [(axis + 1) % 3, (axis + 2) % 3]
    }

    /// Number of cells before the side at the lower (0) or upper (1) `end` of `axis`; the number of all cells for axis 3.
    fn first_cell(&self, axis: usize, end: usize) -> usize {
        let of = |axis: usize| BoxSides::tangents(axis).iter().map(|&k| self.cells[k]).product::<usize>();
        (0..axis).map(|k| 2 * of(k)).sum::<usize>() + if end == 1 { of(axis) } else { 0 }
    }

    /// The number of the cell through which a ray from inside leaves the box.
    pub(super) fn exit_cell(&self, origin: Vec3, dir: Vec3) -> usize {
        let (o, d) = (origin.array(), dir.array());
        let distance = |k: usize| match d[k] {
            0.0 => f64::INFINITY,
            _ => ((if d[k] > 0.0 { self.high[k] } else { self.low[k] }) - o[k]) / d[k],
        };
        let axis = (1..3).fold(0, |nearest, k| if distance(k) < distance(nearest) { k } else { nearest });
        let at = BoxSides::tangents(axis).map(|k| {
            let y = (o[k] + d[k] * distance(axis) - self.low[k]) / (self.high[k] - self.low[k]);
            ((y * self.cells[k] as f64) as usize).min(self.cells[k] - 1)
        });
        let first = self.first_cell(axis, usize::from(d[axis] > 0.0));
        first + at[0] * self.cells[BoxSides::tangents(axis)[1]] + at[1]
    }

    /// All cells in the order of their numbers.
    pub(super) fn cells(&self) -> Vec<BoxCell> {
        let mut all = Vec::with_capacity(self.first_cell(3, 0));
        for (axis, end) in (0..6).map(|s| (s / 2, s % 2)) {
            let along = BoxSides::tangents(axis);
            let edge = |k: usize| (self.high[k] - self.low[k]) / self.cells[k] as f64;
            let unit =
                |k: usize, x: f64| Vec3::from_array(std::array::from_fn(|m| if m == k { x } else { 0.0 }));
            for (m, n) in
                (0..self.cells[along[0]]).flat_map(|m| (0..self.cells[along[1]]).map(move |n| (m, n)))
            {
                let mut corner = self.low;
                corner[axis] = if end == 1 { self.high[axis] } else { self.low[axis] };
                corner[along[0]] += m as f64 * edge(along[0]);
                corner[along[1]] += n as f64 * edge(along[1]);
                let normal = unit(axis, if end == 1 { 1.0 } else { -1.0 });
                let edges = along.map(|k| unit(k, edge(k)));
                all.push(BoxCell { corner: Vec3::from_array(corner), edges, normal });
            }
        }
        all
    }
}
