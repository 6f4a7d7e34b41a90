//! Directions drawn by a table of cells over the sphere.
//!
//! Rows divide the sphere by the height z = ω·up, columns by the turn about the axis. A cell of the weight w (the mean of the radiance over its directions)
//! and of the solid angle Ω is drawn with the probability w Ω/Σ w Ω, and a direction in it uniformly, so that the density per steradian is
//!
//! ```text
//! p = w / Σ w Ω
//! ```
//!
//! First the row is found in the running sums of the rows, then the cell in those of the row (inversion); the remainders of the two numbers place the direction in the cell.

/// Cells over the sphere with the running sums of their shares of the light.
#[derive(Clone, PartialEq)]
pub(super) struct DirectionTable {
    /// z of the edges of the rows, descending from 1 to −1.
    edges: Vec<f64>,
    columns: usize,
    /// Running sums of w Ω over the rows, from 0.
    rows: Vec<f64>,
    /// Of each row the running sums of w over its cells, from 0.
    cells: Vec<f64>,
}

impl std::fmt::Debug for DirectionTable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "DirectionTable({} × {})", self.edges.len() - 1, self.columns)
    }
}

/// A direction drawn by a table.
pub(super) struct TableSample {
    /// Height z.
    pub z: f64,
    /// Turn about the axis in [0, 1).
    pub turn: f64,
    /// Density, 1/sr.
    pub density: f64,
}

impl DirectionTable {
    /// A table of cells of the weights `weight(row, column)` from 0.
    pub(super) fn new(
        edges: Vec<f64>,
        columns: usize,
        weight: impl Fn(usize, usize) -> f64,
    ) -> DirectionTable {
        let count = edges.len() - 1;
        let mut out = DirectionTable {
            edges,
            columns,
            rows: Vec::with_capacity(count + 1),
            cells: Vec::with_capacity(count * (columns + 1)),
        };
        let mut sum = 0.0;
        out.rows.push(sum);
        for r in 0..count {
            let mut row = 0.0;
            out.cells.push(row);
            for c in 0..columns {
                row += weight(r, c);
                out.cells.push(row);
            }
            sum += row * out.cell_solid_angle(r);
            out.rows.push(sum);
        }
        out
    }

    /// Edges of `rows` rows of equal angle from the axis; that of an even number of rows in the middle is exactly 0.
    pub(super) fn edges_of_equal_angles(rows: usize) -> Vec<f64> {
        let edge = |r: usize| {
            if 2 * r == rows { 0.0 } else { (std::f64::consts::PI * r as f64 / rows as f64).cos() }
        };
        (0..=rows).map(edge).collect()
    }

    /// Solid angle of a cell of row `r`, sr.
    pub(super) fn cell_solid_angle(&self, r: usize) -> f64 {
        (self.edges[r] - self.edges[r + 1]) * std::f64::consts::TAU / self.columns as f64
    }

    /// Σ w Ω.
    pub(super) fn total(&self) -> f64 {
        self.rows[self.rows.len() - 1]
    }

    fn cells_of_row(&self, r: usize) -> &[f64] {
        &self.cells[r * (self.columns + 1)..(r + 1) * (self.columns + 1)]
    }

    /// Row and column of a direction.
    pub(super) fn locate(&self, z: f64, turn: f64) -> [usize; 2] {
        let rows = self.edges.len() - 1;
        let row = self.edges[1..rows].partition_point(|e| *e >= z);
        [row, ((turn * self.columns as f64) as usize).min(self.columns - 1)]
    }

    /// Density of a direction, 1/sr.
    pub(super) fn density(&self, z: f64, turn: f64) -> f64 {
        let [r, c] = self.locate(z, turn);
        let row = self.cells_of_row(r);
        (row[c + 1] - row[c]) / self.total()
    }

    /// An upper bound of ∫ w cos⁺ dω, with the cosine to the unit vector of height `z` and turn `turn`: each row counts its cells that reach above the plane of
    /// the vector, with the largest cosine of the row. Zero where no cell with light does.
    pub(super) fn cosine_bound(&self, z: f64, turn: f64) -> f64 {
        let across = (1.0 - z * z).max(0.0).sqrt();
        let polar = z.clamp(-1.0, 1.0).acos();
        let of_row = |r: usize| {
            let ends =
                [self.edges[r], self.edges[r + 1]].map(|e| (e * z, (1.0 - e * e).max(0.0).sqrt() * across));
            let half = ends.iter().fold(0.0, |most: f64, e| most.max(half_width(e.0, e.1)));
            let [from, to] = [self.edges[r], self.edges[r + 1]].map(|e| e.clamp(-1.0, 1.0).acos());
            // The cosine of an angle changes by no more than the angle.
            let highest = ends.iter().fold(-1.0, |most: f64, e| most.max(e.0 + e.1)) + (to - from);
            let cos = if (from..=to).contains(&polar) { 1.0 } else { highest.clamp(0.0, 1.0) };
            self.row_sum(r, turn, half) * self.cell_solid_angle(r) * cos
        };
        (0..self.edges.len() - 1).map(of_row).sum()
    }

    /// Σ w over the cells of row `r` within `half` turns of `turn`.
    fn row_sum(&self, r: usize, turn: f64, half: f64) -> f64 {
        let (row, n) = (self.cells_of_row(r), self.columns as f64);
        if half <= 0.0 {
            return 0.0;
        }
        if half >= 0.5 {
            return row[self.columns];
        }
        let (from, to) = (((turn - half) * n).floor(), ((turn + half) * n).ceil());
        if to - from >= n {
            return row[self.columns];
        }
        let place = |k: f64| k.rem_euclid(n) as usize;
        let (a, b) = (place(from), place(to));
        if a < b { row[b] - row[a] } else { row[self.columns] - row[a] + row[b] }
    }

    /// The direction at a point of the unit square.
    pub(super) fn sample(&self, u: [f64; 2]) -> TableSample {
        let (r, down) = interval(&self.rows, u[0]);
        let row = self.cells_of_row(r);
        let (c, across) = interval(row, u[1]);
        TableSample {
            z: self.edges[r] + (self.edges[r + 1] - self.edges[r]) * down,
            turn: (c as f64 + across) / self.columns as f64,
            density: (row[c + 1] - row[c]) / self.total(),
        }
    }
}

/// Half the extent in turns of the directions of a row's edge that are above the plane of a vector: the solutions of height + across cos t > 0.
fn half_width(height: f64, across: f64) -> f64 {
    if height >= across {
        0.5
    } else if height <= -across {
        0.0
    } else {
        (-height / across).acos() / std::f64::consts::TAU
    }
}

/// The interval of running sums from 0 at the share `u` of their total, and the place within it from 0 to 1.
fn interval(sums: &[f64], u: f64) -> (usize, f64) {
    // Below the total, so that the interval has a width.
    let total = sums[sums.len() - 1];
    let wanted = (u * total).min(total * (1.0 - f64::EPSILON));
    let k = sums[1..sums.len() - 1].partition_point(|s| *s <= wanted);
    let width = sums[k + 1] - sums[k];
    (k, if width > 0.0 { ((wanted - sums[k]) / width).clamp(0.0, 1.0) } else { 0.5 })
}
