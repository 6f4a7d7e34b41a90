//! Tensor grids of quadrature nodes around the difference of two centres, laid out in SIMD lanes.

use super::trapezoid_gauss::{self, TrapezoidDensity, TrapezoidRule};
use zonal_math::gauss_legendre;
pub(super) use zonal_math::simd::LANES;

/// Nodes relative to the difference of the centres, strip axis first, weights of sum one; padded to whole blocks with nodes of weight zero.
pub(super) struct TensorNodes {
    axes: [Vec<[f64; LANES]>; 3],
    weights: Vec<[f64; LANES]>,
    /// The largest |node| on each axis.
    pub half_extents: [f64; 3],
    /// Number of nodes with a weight.
    pub count: usize,
    /// The defects of the three rules.
    pub defect: [f64; 3],
}

/// Quadrature rule of one axis.
pub(super) struct AxisRule {
    pub nodes: Vec<f64>,
    pub weights: Vec<f64>,
    pub defect: f64,
}

impl AxisRule {
    /// The `n`-point Gauss rule of the trapezoid density.
    pub(super) fn trapezoid(shape: &TrapezoidDensity, n: usize) -> AxisRule {
        let n = if shape.half > 0.0 { n } else { 1 };
        let of = |r: &TrapezoidRule| AxisRule {
            nodes: r.nodes.iter().map(|u| u * shape.half).collect(),
            weights: r.weights.clone(),
            defect: r.defect,
        };
        if shape.plateau == 0.0 {
            of(trapezoid_gauss::triangle_rule(n))
        } else {
            of(&trapezoid_gauss::trapezoid_rule(n, shape.plateau))
        }
    }

    /// The n² differences of two Gauss–Legendre rules of `n` points: the six-dimensional integration of the paper.
    pub(super) fn gauss_differences(a: f64, b: f64, n: usize) -> AxisRule {
        let rule = gauss_legendre::rule(n);
        let points = |len: f64| -> Vec<(f64, f64)> {
            if len == 0.0 {
                return vec![(0.0, 1.0)];
            }
            rule.nodes.iter().zip(&rule.weights).map(|(x, w)| (len * (x - 0.5), *w)).collect()
        };
        let (mut nodes, mut weights) = (Vec::new(), Vec::new());
        for (x, w) in points(a) {
            for (y, v) in points(b) {
                nodes.push(y - x);
                weights.push(w * v);
            }
        }
        // Nodes and weights within 2⁻⁵² relative: T_k of the rule off by at most (2n)² · 2⁻⁵² on each of the two.
        let n2 = (2 * n * 2 * n) as f64;
        AxisRule { nodes, weights, defect: 2.0 * (n2 + 4.0) * f64::EPSILON }
    }
}

impl AxisRule {
    /// (t², w t^p) of every node around `centre`.
    pub(super) fn squares_and_weights(&self, centre: f64, power: i32) -> Vec<(f64, f64)> {
        let at = |(u, w): (&f64, &f64)| {
            let t = centre + u;
            (t * t, w * t.powi(power))
        };
        self.nodes.iter().zip(&self.weights).map(at).collect()
    }
}

impl TensorNodes {
    /// The tensor product of three lines.
    pub(super) fn tensor(lines: [&AxisRule; 3]) -> TensorNodes {
        let count = lines.iter().map(|l| l.nodes.len()).product::<usize>();
        let blocks = count.div_ceil(LANES);
        let mut axes = [0, 1, 2].map(|_| vec![[0.0; LANES]; blocks]);
        let mut weights = vec![[0.0; LANES]; blocks];
        let [x, y, z] = lines;
        let mut i = 0;
        for (x, wx) in x.nodes.iter().zip(&x.weights) {
            for (y, wy) in y.nodes.iter().zip(&y.weights) {
                for (z, wz) in z.nodes.iter().zip(&z.weights) {
                    let (b, l) = (i / LANES, i % LANES);
                    (axes[0][b][l], axes[1][b][l], axes[2][b][l]) = (*x, *y, *z);
                    weights[b][l] = wx * wy * wz;
                    i += 1;
                }
            }
        }
        let half_extents = lines.map(|l| l.nodes.iter().fold(0.0f64, |m, x| m.max(x.abs())));
        TensorNodes { axes, weights, half_extents, count, defect: lines.map(|l| l.defect) }
    }

    #[inline(always)]
    pub(super) fn blocks(&self) -> usize {
        self.weights.len()
    }

    /// `L` nodes from block `first` on: three coordinates and weights.
    #[inline(always)]
    pub(super) fn lanes_from<const L: usize>(
        &self,
        first: usize,
    ) -> ([f64; L], [f64; L], [f64; L], [f64; L]) {
        let gather = |v: &[[f64; LANES]]| -> [f64; L] {
            let mut out = [0.0; L];
            out.copy_from_slice(v[first..first + L / LANES].as_flattened());
            out
        };
        (gather(&self.axes[0]), gather(&self.axes[1]), gather(&self.axes[2]), gather(&self.weights))
    }

    /// Smallest distance of a node from t = 0.
    #[inline(always)]
    pub(super) fn min_distance(&self, centre: [f64; 3]) -> f64 {
        let mut square = 0.0;
        for k in 0..3 {
            let gap = (centre[k].abs() - self.half_extents[k]).max(0.0);
            square += gap * gap;
        }
        square.sqrt() * (1.0 - 1e-14)
    }

    /// Q 1/|t|²: the mean of the kernel without a series.
    #[inline(always)]
    pub(super) fn mean_inverse_square(&self, centre: [f64; 3]) -> f64 {
        let mut sum = [0.0; LANES];
        for b in 0..self.blocks() {
            let (x, y, z, w) = (&self.axes[0][b], &self.axes[1][b], &self.axes[2][b], &self.weights[b]);
            for l in 0..LANES {
                let (x, y, z) = (centre[0] + x[l], centre[1] + y[l], centre[2] + z[l]);
                sum[l] += w[l] / (x * x + y * y + z * z);
            }
        }
        ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]))
    }
}
