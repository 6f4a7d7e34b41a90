//! Heat conduction in tetrahedra with one temperature a node, coupled to grey diffuse radiation between triangles on their surface.
//!
//! Linear elements: K T = load, K_ij = Σ k V ∇N_i·∇N_j, load_i = Σ Q V/4 − Σ q A/3. The net flux out of the radiating triangles is linear in
//! their black emissive powers e = σ⟨T⁴⟩ (mean over the corners), q = M e with
//!
//! ```text
//! (I − (1−ε) A⁻¹F) B = ε e,      q = B − A⁻¹F B,
//! ```
//!
//! and Newton's method solves for the temperatures.

use super::factors::STEFAN_BOLTZMANN;
use zonal_report::Failure;

/// A mesh of tetrahedra with loads.
pub(crate) struct TetrahedralMesh {
    /// Nodes, m.
    pub nodes: Vec<[f64; 3]>,
    /// Corners of the tetrahedra, with conductivity, W/(m K), and heat source, W/m³.
    pub bodies: Vec<([usize; 4], f64, f64)>,
    /// Nodes of known temperature, K.
    pub fixed: Vec<(usize, f64)>,
    /// Corners of the triangles that radiate.
    pub radiating: Vec<[usize; 3]>,
}

/// A dense square matrix, row by row.
#[derive(Clone)]
pub(crate) struct SquareMatrix {
    n: usize,
    values: Vec<f64>,
}

impl SquareMatrix {
    /// Zero.
    pub(crate) fn new(n: usize) -> SquareMatrix {
        SquareMatrix { n, values: vec![0.0; n * n] }
    }
    /// An entry.
    pub(crate) fn get(&self, i: usize, j: usize) -> f64 {
        self.values[i * self.n + j]
    }
    /// Adds to an entry.
    pub(crate) fn add(&mut self, i: usize, j: usize, x: f64) {
        self.values[i * self.n + j] += x;
    }
    fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.n..(i + 1) * self.n]
    }
    /// Solves for several right sides at once, by elimination with the largest pivots.
    pub(crate) fn solve(mut self, mut sides: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
        let n = self.n;
        for k in 0..n {
            let best = (k..n).max_by(|&a, &b| self.get(a, k).abs().total_cmp(&self.get(b, k).abs()))?;
            if self.get(best, k) == 0.0 {
                return None;
            }
            if best != k {
                (0..n).for_each(|j| self.values.swap(k * n + j, best * n + j));
                sides.iter_mut().for_each(|s| s.swap(k, best));
            }
            let (above, below) = self.values.split_at_mut((k + 1) * n);
            let pivot = &above[k * n..];
            for i in k + 1..n {
                let row = &mut below[(i - k - 1) * n..(i - k) * n];
                let f = row[k] / pivot[k];
                if f != 0.0 {
                    row[k..].iter_mut().zip(&pivot[k..]).for_each(|(x, p)| *x -= f * p);
                    sides.iter_mut().for_each(|s| s[i] -= f * s[k]);
                }
            }
        }
        for s in &mut sides {
            for i in (0..n).rev() {
                let rest: f64 = (i + 1..n).map(|j| self.get(i, j) * s[j]).sum();
                s[i] = (s[i] - rest) / self.get(i, i);
            }
        }
        Some(sides)
    }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

/// a × b.
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i] * b[j] - a[j] * b[i]
    })
}

/// a · b.
pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl TetrahedralMesh {
    /// The normal of a triangle, twice its area long.
    pub(crate) fn normal(&self, t: [usize; 3]) -> [f64; 3] {
        let [a, b, c] = t.map(|i| self.nodes[i]);
        cross(minus(b, a), minus(c, a))
    }

    /// The area of a triangle, m².
    pub(crate) fn area(&self, t: [usize; 3]) -> f64 {
        let n = self.normal(t);
        0.5 * dot(n, n).sqrt()
    }

    /// The stiffness and the load of conduction alone.
    fn conduction(&self) -> (SquareMatrix, Vec<f64>) {
        let mut matrix = SquareMatrix::new(self.nodes.len());
        let mut load = vec![0.0; self.nodes.len()];
        for (corners, conductivity, source) in &self.bodies {
            let x = corners.map(|i| self.nodes[i]);
            // ∇N_i = the normal of the opposite face, inward, over 6V.
            let six = dot(minus(x[1], x[0]), cross(minus(x[2], x[0]), minus(x[3], x[0])));
            let gradient = |i: usize| {
                let [a, b, c] = [1, 2, 3].map(|k| x[(i + k) % 4]);
                let n = cross(minus(b, a), minus(c, a));
                let height = dot(n, minus(x[i], a));
                n.map(|v| v / height)
            };
            let volume = six.abs() / 6.0;
            for (i, &p) in corners.iter().enumerate() {
                load[p] += source * volume / 4.0;
                for (j, &q) in corners.iter().enumerate() {
                    matrix.add(p, q, conductivity * volume * dot(gradient(i), gradient(j)));
                }
            }
        }
        (matrix, load)
    }

    /// Temperatures of the nodes, K: `flux` is M, the net fluxes out of the radiating triangles for their black emissive powers. Starts from `first` K.
    pub(crate) fn temperatures(&self, flux: &SquareMatrix, first: f64) -> Result<Vec<f64>, Failure> {
        const MAX_NEWTON_STEPS: usize = 60;
        const RELATIVE_STEP_TOLERANCE: f64 = 1e-9;
        let (stiffness, load) = self.conduction();
        let mut t = vec![first; self.nodes.len()];
        self.fixed.iter().for_each(|&(i, kelvin)| t[i] = kelvin);
        let singular = || Failure::new("the coupled conduction has no solution");
        for _ in 0..MAX_NEWTON_STEPS {
            let mut jacobian = stiffness.clone();
            let mut rest: Vec<f64> = (0..t.len())
                .map(|i| load[i] - stiffness.row(i).iter().zip(&t).map(|(k, t)| k * t).sum::<f64>())
                .collect();
            let powers: Vec<f64> = self
                .radiating
                .iter()
                .map(|s| STEFAN_BOLTZMANN * s.map(|i| t[i].powi(4)).iter().sum::<f64>() / 3.0)
                .collect();
            for (e, triangle) in self.radiating.iter().enumerate() {
                let third = self.area(*triangle) / 3.0;
                let q: f64 = flux.row(e).iter().zip(&powers).map(|(m, p)| m * p).sum();
                for &i in triangle {
                    rest[i] -= third * q;
                    for (f, other) in self.radiating.iter().enumerate() {
                        for &j in other {
                            jacobian.add(
                                i,
                                j,
                                third * flux.get(e, f) * STEFAN_BOLTZMANN * 4.0 * t[j].powi(3) / 3.0,
                            );
                        }
                    }
                }
            }
            for &(i, _) in &self.fixed {
                (0..t.len()).for_each(|j| jacobian.values[i * t.len() + j] = f64::from(u8::from(i == j)));
                rest[i] = 0.0;
            }
            let step = jacobian.solve(vec![rest]).ok_or_else(singular)?.swap_remove(0);
            let most = step.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            t.iter_mut().zip(&step).for_each(|(t, d)| *t = (*t + d).max(1.0));
            if most < RELATIVE_STEP_TOLERANCE * first {
                return Ok(t);
            }
        }
        Err(Failure::new("the coupled conduction does not converge"))
    }
}

/// M: net fluxes out of triangles of one emissivity, `shares` = A⁻¹F, for their black emissive powers.
pub(crate) fn net_fluxes(shares: &SquareMatrix, emissivity: f64) -> Option<SquareMatrix> {
    let n = shares.n;
    let mut system = SquareMatrix::new(n);
    for i in 0..n {
        (0..n).for_each(|j| {
            system.add(i, j, f64::from(u8::from(i == j)) - (1.0 - emissivity) * shares.get(i, j))
        });
    }
    let unit = |k: usize| (0..n).map(|i| if i == k { emissivity } else { 0.0 }).collect();
    let radiosities = system.solve((0..n).map(unit).collect())?;
    let mut out = SquareMatrix::new(n);
    for (k, b) in radiosities.iter().enumerate() {
        for i in 0..n {
            let arrives: f64 = shares.row(i).iter().zip(b).map(|(f, b)| f * b).sum();
            out.add(i, k, b[i] - arrives);
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elimination_solves_a_pivoted_system() {
        let mut m = SquareMatrix::new(3);
        for (i, row) in [[0.0, 2.0, 1.0], [1.0, 1.0, 0.0], [3.0, 0.0, -1.0]].iter().enumerate() {
            row.iter().enumerate().for_each(|(j, x)| m.add(i, j, *x));
        }
        let x = m.solve(vec![vec![7.0, 3.0, 0.0]]).unwrap().swap_remove(0);
        for (x, y) in x.iter().zip([1.0, 2.0, 3.0]) {
            assert!((x - y).abs() < 1e-13, "{x} {y}");
        }
        assert!(SquareMatrix::new(2).solve(vec![vec![1.0, 1.0]]).is_none());
    }

    /// Two plates that see only each other: q = σ(T₁⁴ − T₂⁴)/(2/ε − 1).
    #[test]
    fn two_plates_exchange_by_the_closed_form() {
        let mut shares = SquareMatrix::new(2);
        shares.add(0, 1, 1.0);
        shares.add(1, 0, 1.0);
        let m = net_fluxes(&shares, 0.6).unwrap();
        let k = 1.0 / (2.0 / 0.6 - 1.0);
        assert!((m.get(0, 0) - k).abs() < 1e-14 && (m.get(0, 1) + k).abs() < 1e-14);
    }

    /// A tetrahedron whose base is held and whose other node is heated: by symmetry Q V/4 flows through the base.
    #[test]
    fn heated_tetrahedron_conducts_through_its_base() {
        let nodes = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let fixed = vec![(0, 300.0), (1, 300.0), (2, 300.0)];
        let mesh =
            TetrahedralMesh { nodes, bodies: vec![([0, 1, 2, 3], 2.0, 12.0)], fixed, radiating: vec![] };
        let t = mesh.temperatures(&SquareMatrix::new(0), 250.0).unwrap();
        // k V |∇N|² ΔT = Q V/4 with |∇N| = 1.
        assert!((t[3] - 301.5).abs() < 1e-9, "{t:?}");
    }
}
