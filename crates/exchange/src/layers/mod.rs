//! Exchange factors of infinite parallel layers between two planes, for any extinction of each layer.
//!
//! Elements are the lower plane, the layers from the lower plane on, and the upper plane. With the optical thickness a = κd of a layer and the optical
//! depth x between two elements, the exchange areas of a unit of area are (Hottel and Sarofim 1967; Modest, chapter 14)
//!
//! ```text
//!     plane and plane   2 E₃(x)
//!     plane and layer   2 [E₃(x) − E₃(x+a)]
//!     two layers        2 [E₃(x) − E₃(x+a) − E₃(x+b) + E₃(x+a+b)]
//!     a layer           4 [a − ½ + E₃(a)]
//! ```
//!
//! **Differences.** Thin layers lose all digits in these differences, and a transparent layer has a factor but no exchange area. With
//! E₃(x) = ∫₁^∞ e^{−xt} t⁻³ dt the factors g_ij = F_ij/(c_i c_j), c = κ or 1, of two elements are one integral of positive terms:
//!
//! ```text
//!     g_ij = 2 ∫₁^∞ e^{−xt} φ_i(t) φ_j(t) dt/t,      φ = d (1 − e^{−at})/(at) of a layer, 1/t of a plane
//! ```
//!
//! **Method.** t = 1 + e^y and the trapezoidal rule in y with the step h = `LOG_STEP`. All pairs share the nodes, so a row of factors takes one
//! multiplication for each element and node, and the row sums telescope node by node: closure does not depend on the step. The factor of a layer
//! with itself is 2d² m(a), m = 2 [a − ½ + E₃(a)]/a², up to a = 1 by the power series of E₃ without its first two terms,
//!
//! ```text
//!     m(a) = 3/2 − γ − ln a + 2 Σ_{k≥1} (−1)^{k+1} a^k/(k (k+2)!)
//! ```
//!
//! Two transparent layers (κ = 0), also the same one, have the factor 0 in place of a limit that may be infinite: neither emits, and the incident
//! power is exact.
//!
//! **Error.** All terms are positive.
//! - *Step.* The contour may be turned to Im y = φ < π/2. There |t| ≥ (1 + e^{Re y})/2, |1 − e^{−z}| ≤ 4 (1 − e^{−|z|}) and |e^{−xt}| = e^{−x(1 + cos φ e^{Re y})},
//!   which widens the integral by at most 1/cos φ: the relative error is below 2·8·16/cos φ · e^{−2πφ/h}, for φ = 1.45 below 1e-16.
//! - *Ends.* Integrands fall as e^y below and at least as 1/(at) above; the shares that are left out are below 1e-16.
//! - *Rounding.* Sums in eight columns, a product of one transmittance a layer, and the exponent of the optical depth between two elements: see
//!   [`LayerFactors::relative_radius`].
//!
//! Cost: N²M/2 multiplications for N elements and M nodes, 400 to 600.

use zonal_math::exponential_integral::e3;

/// Step in y = ln(t − 1).
const LOG_STEP: f64 = 0.2;
/// First node: t − 1.
const FIRST_NODE_LOG: f64 = -46.0;
/// Last node times the smallest optical thickness above 0.
const LAST_NODE_TIMES_DEPTH: f64 = 1e17;
/// Optical thickness below which a layer is transparent.
const MIN_OPTICAL_DEPTH: f64 = 1e-250;
/// Optical depth beyond which all factors are 0 in double precision.
const MAX_OPTICAL_DEPTH: f64 = 750.0;
/// Columns of a sum.
const SUM_COLUMNS: usize = 8;
/// Nodes are padded to a multiple of the columns by nodes of weight 0.
const PADDING_NODE: f64 = 1.0;
/// Rounding of nodes, profiles and sums, in units of ε.
const SUM_ROUNDING: f64 = 150.0;
/// Rounding of a transmittance for each element, in units of ε.
const ELEMENT_ROUNDING: f64 = 4.0;
/// The Euler–Mascheroni constant.
const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;
/// Terms of the power series of m for a ≤ 1; the first omitted one is below 1e-22.
const SERIES_TERMS: usize = 20;

/// The factors of a stack of layers, per unit of area.
pub struct LayerFactors {
    /// Optical thicknesses.
    depths: Vec<f64>,
    thickness: Vec<f64>,
    /// Number of nodes.
    nodes: usize,
    /// 2h (t − 1)/t by node.
    weights: Vec<f64>,
    /// φ by element and node.
    profiles: Vec<f64>,
    /// e^{−at} by layer and node.
    transmittances: Vec<f64>,
}

impl LayerFactors {
    /// The stack of layers with extinctions κ, 1/m, 0 or more, and thicknesses d, m, above 0; both finite, in equal numbers.
    pub fn new(extinction: &[f64], thickness: &[f64]) -> LayerFactors {
        assert_eq!(extinction.len(), thickness.len(), "one thickness a layer");
        let depth = |(k, d): (&f64, &f64)| Some(k * d).filter(|a| *a >= MIN_OPTICAL_DEPTH).unwrap_or(0.0);
        let depths: Vec<f64> = extinction.iter().zip(thickness).map(depth).collect();
        let smallest = depths.iter().copied().filter(|a| *a > 0.0).fold(1.0, f64::min);
        let count = ((LAST_NODE_TIMES_DEPTH / smallest).ln() - FIRST_NODE_LOG) / LOG_STEP;
        let count = count.ceil() as usize + 1;
        let nodes = count.next_multiple_of(SUM_COLUMNS);
        let beyond = |k: usize| (FIRST_NODE_LOG + LOG_STEP * k as f64).exp();
        let node = |k: usize| if k < count { 1.0 + beyond(k) } else { PADDING_NODE };
        let t: Vec<f64> = (0..nodes).map(node).collect();
        let weight = |k: usize| if k < count { 2.0 * LOG_STEP * beyond(k) / t[k] } else { 0.0 };
        let plane = || t.iter().map(|t| 1.0 / t);
        let layer = |i: usize| {
            let (a, d) = (depths[i], thickness[i]);
            t.iter().map(move |t| if a > 0.0 { -(-a * t).exp_m1() / (a * t) * d } else { d })
        };
        let profiles = plane().chain((0..depths.len()).flat_map(layer)).chain(plane()).collect();
        let transmittances = depths.iter().flat_map(|a| t.iter().map(move |t| (-a * t).exp())).collect();
        let weights = (0..nodes).map(weight).collect();
        LayerFactors { thickness: thickness.to_vec(), nodes, weights, profiles, transmittances, depths }
    }

    /// Number of elements: the layers and two planes.
    pub fn elements(&self) -> usize {
        self.depths.len() + 2
    }

    /// Number of nodes of the integrals.
    pub fn nodes(&self) -> usize {
        self.nodes
    }

    /// Bytes of the tables of `layers` layers whose smallest optical thickness above 0 is `smallest`, m.
    pub fn bytes(layers: usize, smallest: f64) -> u64 {
        let smallest = smallest.clamp(MIN_OPTICAL_DEPTH, 1.0);
        let nodes = ((LAST_NODE_TIMES_DEPTH / smallest).ln() - FIRST_NODE_LOG) / LOG_STEP + 10.0;
        (16.0 * nodes * (layers as f64 + 2.0)) as u64
    }

    /// Relative radius of every factor.
    pub fn relative_radius(&self) -> f64 {
        let depth = self.depths.iter().sum::<f64>().min(MAX_OPTICAL_DEPTH);
        f64::EPSILON * (SUM_ROUNDING + ELEMENT_ROUNDING * (self.elements() as f64 + depth))
    }

    /// The factors of element `i` with the elements 0 to `i`: dimensionless between planes, m between a plane and a layer, m² between layers.
    pub fn row(&self, i: usize, row: &mut [f64]) {
        let m = self.nodes;
        let mut along: Vec<f64> = self.profile(i).iter().zip(&self.weights).map(|(p, w)| p * w).collect();
        row[i] = self.own(i);
        let is_transparent = |j: usize| j > 0 && self.depths.get(j - 1) == Some(&0.0);
        for j in (0..i).rev() {
            row[j] = if is_transparent(i) && is_transparent(j) { 0.0 } else { dot(&along, self.profile(j)) };
            if j > 0 {
                let passed = &self.transmittances[(j - 1) * m..j * m];
                along.iter_mut().zip(passed).for_each(|(x, q)| *x *= q);
            }
        }
    }

    fn profile(&self, i: usize) -> &[f64] {
        &self.profiles[i * self.nodes..(i + 1) * self.nodes]
    }

    /// The factor of an element with itself.
    fn own(&self, i: usize) -> f64 {
        let Some(layer) = i.checked_sub(1).filter(|l| *l < self.depths.len()) else { return 0.0 };
        let (a, d) = (self.depths[layer], self.thickness[layer]);
        if a > 0.0 { 2.0 * d * d * mean_kernel(a) } else { 0.0 }
    }
}

/// Σ x_k y_k in eight columns; the length is a multiple of eight.
fn dot(x: &[f64], y: &[f64]) -> f64 {
    let mut sums = [0.0; SUM_COLUMNS];
    for (x, y) in x.chunks_exact(SUM_COLUMNS).zip(y.chunks_exact(SUM_COLUMNS)) {
        for (s, (x, y)) in sums.iter_mut().zip(x.iter().zip(y)) {
            *s += x * y;
        }
    }
    sums.iter().sum()
}

/// m(a) = 2 [a − ½ + E₃(a)]/a² for a > 0.
fn mean_kernel(a: f64) -> f64 {
    if a > 1.0 {
        return 2.0 * (a - 0.5 + e3(a)) / (a * a);
    }
    let (mut sum, mut power) = (0.0, 0.5);
    for k in 1..=SERIES_TERMS {
        // power = −(−a)^k/(k+2)!
        power *= if k == 1 { a / 3.0 } else { -a / (k + 2) as f64 };
        sum += power / k as f64;
    }
    1.5 - EULER_GAMMA - a.ln() + 2.0 * sum
}

#[cfg(test)]
mod tests;
