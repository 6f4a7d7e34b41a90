//! Nodes: bodies at one unknown temperature, whose zones share one balance, with links to each other.
//!
//! With the zones i of node K at the emissive power E_K = σT_K⁴, area measure V_i, and its convection and links,
//!
//! ```text
//!     Σ_i V_i Σ_b m_b a_b (w_b(E_K) − h_b) + Σ_i h_i V_i (T_K − T∞_i) + Σ_L C_L (T_K − T_L) + Σ_L R_L (E_K − E_L) = P_K
//! ```
//!
//! For given incident fluxes this is a system of as many equations as there are unknown nodes, with increasing diagonal and decreasing couplings; Newton's
//! method solves it. About temperatures T⁰ it is linear,
//!
//! ```text
//!     D δT = r + Σ_i V_i Σ_b m_b a_b h_b            D_KK = Σ_i V_i Σ_b m a ψ / T'_K + Σ h_i V_i + Σ (C + R/T'_K),   T' = dT/dE
//! ```
//!
//! so that the zones of a node reemit what all zones of its links absorb: δE = N (r + absorbed) with N = T'⁻¹ D⁻¹, which has no negative entry.

use super::spectral_balance::SpectralBalances;
use super::zone_balance::temperature_slope;
use zonal_math::parallel;
use zonal_scene::thermal::{blackbody_emissive_power, blackbody_temperature};
use zonal_scene::{Bands, LinkLaw, NodeCondition, ThermalNetwork};

/// Maximum number of Newton steps for given incident fluxes.
const MAX_STEPS: usize = 100;
/// Change of a temperature relative to it below which they end.
const RELATIVE_STEP: f64 = 1e-14;
/// Largest factor by which a temperature changes in a step.
const MAX_CHANGE_FACTOR: f64 = 2.0;

/// A link with its coefficients: conductance, W/K, and radiative area, m².
#[derive(Clone, Copy)]
struct ZoneLink {
    nodes: [usize; 2],
    conductance: f64,
    radiative_area: f64,
}

/// The nodes of a scene with their zones.
pub(super) struct NodeZones<'a> {
    network: &'a ThermalNetwork,
    /// The zones of each node, of known temperature too.
    zones: Vec<Vec<u32>>,
    links: Vec<ZoneLink>,
    /// Nodes of unknown temperature.
    unknown: Vec<usize>,
    /// Σ h V (W/K) and Σ h V T∞ (W) of each node.
    convection: Vec<[f64; 2]>,
}

/// A linearization of the balances of the nodes.
pub(super) struct NodeLinearization {
    /// Position among the unknown nodes, by node.
    position: Vec<Option<usize>>,
    /// N by rows, over the unknown nodes, m² of E per W.
    gain: Vec<f64>,
    /// Change of E of each unknown node without incident radiation, W/m².
    own: Vec<f64>,
}

impl<'a> NodeZones<'a> {
    /// Of the zones of a scene; `None` without nodes.
    pub(super) fn new(balances: &SpectralBalances<'a>, surface_of_patch: &[usize]) -> Option<NodeZones<'a>> {
        let network = balances.tables[0].network().filter(|n| !n.nodes.is_empty())?;
        let count = network.nodes.len();
        let mut zones = vec![Vec::new(); count];
        let (mut area, mut convection) = (vec![0.0; count], vec![[0.0; 2]; count]);
        for (i, &surface) in surface_of_patch.iter().enumerate() {
            let Some(k) = network.surface_nodes[surface] else { continue };
            let size = balances.first(i).measure;
            zones[k].push(i as u32);
            area[k] += size;
            if let Some(c) = network.convection[surface] {
                convection[k][0] += c.coefficient * size;
                convection[k][1] += c.coefficient * size * c.ambient;
            }
        }
        let link = |l: &zonal_scene::NodeLink| {
            let (conductance, radiative_area) = match l.law {
                LinkLaw::Conductance(c) => (c, 0.0),
                LinkLaw::ConductancePerArea(c) => (c * area[l.nodes[0]], 0.0),
                LinkLaw::EffectiveEmissivity(e) => (0.0, e * area[l.nodes[0]]),
            };
            ZoneLink { nodes: l.nodes, conductance, radiative_area }
        };
        let links = network.links.iter().map(link).collect();
        let unknown = (0..count).filter(|k| network.is_unknown(*k)).collect();
        Some(NodeZones { network, zones, links, unknown, convection })
    }
    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.network.nodes.len()
    }
    /// The zones of a node.
    pub(super) fn zones(&self, node: usize) -> &[u32] {
        &self.zones[node]
    }
    /// Name of a node.
    pub(super) fn name(&self, node: usize) -> &str {
        &self.network.nodes[node].name
    }
    /// True if the temperature of a node is unknown.
    pub(super) fn is_unknown(&self, node: usize) -> bool {
        self.network.is_unknown(node)
    }
    /// E of the nodes at the beginning, W/m²: of known temperatures, else `initial`.
    pub(super) fn initial_emissive_powers(&self, initial: f64) -> Vec<f64> {
        let of = |n: &zonal_scene::ThermalNode| match n.condition {
            NodeCondition::Temperature(t) => blackbody_emissive_power(t),
            NodeCondition::Power(_) => initial,
        };
        self.network.nodes.iter().map(of).collect()
    }
    /// True if the balances are linear in E.
    pub(super) fn is_linear(&self, balances: &SpectralBalances) -> bool {
        let of_node = |k: &usize| {
            self.convection[*k][0] == 0.0
                && self.zones[*k].iter().all(|i| balances.has_constant_fractions(*i as usize))
        };
        self.unknown.iter().all(of_node) && self.links.iter().all(|l| l.conductance == 0.0)
    }
    /// Power absorbed by the zones of each node for an incident flux h of every block and zone, W.
    pub(super) fn absorbed(
        &self,
        balances: &SpectralBalances,
        h: impl Fn(usize, usize) -> Bands + Sync,
    ) -> Vec<f64> {
        let counted = balances.counted();
        let of_zone = |i: usize| {
            let of = |t: usize| (balances.zones[t][i].absorption_weight() * counted * h(t, i)).sum();
            balances.first(i).measure * (1..balances.blocks()).fold(of(0), |s, t| s + of(t))
        };
        let of_node = |zones: &Vec<u32>| zones.iter().map(|i| of_zone(*i as usize)).sum();
        parallel::map(&self.zones, of_node)
    }
    /// Power that a node emits at `e`, W, and its derivative by e, m².
    fn emitted(&self, balances: &SpectralBalances, node: usize, e: f64) -> [f64; 2] {
        self.zones[node].iter().fold([0.0; 2], |s, i| {
            let [w, slope] = balances.emitted_and_slope(*i as usize, e);
            let size = balances.first(*i as usize).measure;
            [s[0] + size * w, s[1] + size * slope]
        })
    }
    /// Power to the air and to other nodes for the E of all nodes, W.
    pub(super) fn heat_flows(&self, node: usize, e: &[f64]) -> [f64; 2] {
        let t = |k: usize| blackbody_temperature(e[k].max(0.0));
        let [coefficient, ambient] = self.convection[node];
        let of_link = |l: &ZoneLink| {
            let other = match l.nodes {
                [a, b] if a == node => b,
                [a, b] if b == node => a,
                _ => return 0.0,
            };
            l.conductance * (t(node) - t(other)) + l.radiative_area * (e[node] - e[other])
        };
        [coefficient * t(node) - ambient, self.links.iter().map(of_link).sum()]
    }
    /// Supplied less emitted, convected and conducted power of every unknown node at the E of all nodes, W, and D by rows, W/K.
    fn residual_and_matrix(&self, balances: &SpectralBalances, e: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let n = self.unknown.len();
        let position = self.positions();
        let slope = |k: usize| 1.0 / temperature_slope(blackbody_temperature(e[k].max(0.0)));
        let (mut residual, mut matrix) = (vec![0.0; n], vec![0.0; n * n]);
        for (p, &k) in self.unknown.iter().enumerate() {
            let NodeCondition::Power(supplied) = self.network.nodes[k].condition else { continue };
            let [emitted, per_e] = self.emitted(balances, k, e[k]);
            residual[p] = supplied - emitted - self.heat_flows(k, e).iter().sum::<f64>();
            matrix[p * n + p] += per_e * slope(k) + self.convection[k][0];
        }
        for l in &self.links {
            let couple = |k: usize| l.conductance + l.radiative_area * slope(k);
            for [own, other] in [l.nodes, [l.nodes[1], l.nodes[0]]] {
                let Some(p) = position[own] else { continue };
                matrix[p * n + p] += couple(own);
                if let Some(q) = position[other] {
                    matrix[p * n + q] -= couple(other);
                }
            }
        }
        (residual, matrix)
    }
    fn positions(&self) -> Vec<Option<usize>> {
        let mut position = vec![None; self.len()];
        self.unknown.iter().enumerate().for_each(|(p, &k)| position[k] = Some(p));
        position
    }
    /// E of all nodes for the power absorbed by their zones, from `start`; NaN where a node has no balance.
    pub(super) fn balance(&self, balances: &SpectralBalances, absorbed: &[f64], start: &[f64]) -> Vec<f64> {
        let mut e = start.to_vec();
        for _ in 0..MAX_STEPS {
            let (mut residual, matrix) = self.residual_and_matrix(balances, &e);
            self.unknown.iter().zip(&mut residual).for_each(|(&k, r)| *r += absorbed[k]);
            let change = DenseFactors::new(matrix, residual.len()).solve(residual);
            let mut largest = 0.0f64;
            for (&k, change) in self.unknown.iter().zip(change) {
                let t = blackbody_temperature(e[k].max(0.0));
                let next = (t + change).clamp(t / MAX_CHANGE_FACTOR, t * MAX_CHANGE_FACTOR);
                largest = largest.max(((next - t) / t).abs());
                e[k] = if change.is_finite() { blackbody_emissive_power(next) } else { f64::NAN };
            }
            if largest.is_nan() || largest <= RELATIVE_STEP {
                break;
            }
        }
        e
    }
    /// E of all nodes for the incident flux h of every block and zone, W/m².
    pub(super) fn found(
        &self,
        balances: &SpectralBalances,
        h: impl Fn(usize, usize) -> Bands + Sync,
    ) -> Vec<f64> {
        let initial = blackbody_emissive_power(balances.tables[0].initial_temperature());
        self.balance(balances, &self.absorbed(balances, h), &self.initial_emissive_powers(initial))
    }
    /// Linearizes the balances about the E of all nodes.
    pub(super) fn linearize(&self, balances: &SpectralBalances, e: &[f64]) -> NodeLinearization {
        let n = self.unknown.len();
        let (residual, matrix) = self.residual_and_matrix(balances, e);
        let per_kelvin: Vec<f64> = self
            .unknown
            .iter()
            .map(|&k| 1.0 / temperature_slope(blackbody_temperature(e[k].max(0.0))))
            .collect();
        let factors = DenseFactors::new(matrix, n);
        let column = |q: usize| {
            let mut unit = vec![0.0; n];
            unit[q] = 1.0;
            factors.solve(unit)
        };
        let columns: Vec<Vec<f64>> = parallel::collect(n, column);
        let gain: Vec<f64> =
            (0..n).flat_map(|p| (0..n).map(|q| per_kelvin[p] * columns[q][p]).collect::<Vec<_>>()).collect();
        let own = (0..n).map(|p| (0..n).map(|q| gain[p * n + q] * residual[q]).sum()).collect();
        NodeLinearization { position: self.positions(), gain, own }
    }
}

impl NodeLinearization {
    /// Change of E of a node of unknown temperature without incident radiation, W/m².
    pub(super) fn own(&self, node: usize) -> f64 {
        self.position[node].map_or(0.0, |p| self.own[p])
    }
    /// Change of E of every node by the power that all of them absorb, W/m².
    pub(super) fn response(&self, absorbed: &[f64]) -> Vec<f64> {
        let n = self.own.len();
        let own: Vec<f64> =
            self.position.iter().zip(absorbed).filter(|(p, _)| p.is_some()).map(|(_, a)| *a).collect();
        let of = |p: usize| (0..n).map(|q| self.gain[p * n + q] * own[q]).sum();
        self.position.iter().map(|p| p.map_or(0.0, of)).collect()
    }
}

/// Triangular factors of a dense matrix with pivots; solutions are not finite if it is singular.
struct DenseFactors {
    size: usize,
    factors: Vec<f64>,
    /// The row that takes the place of each row.
    pivots: Vec<usize>,
}

impl DenseFactors {
    /// Of a matrix by rows.
    fn new(mut a: Vec<f64>, n: usize) -> DenseFactors {
        let mut pivots = Vec::with_capacity(n);
        for k in 0..n {
            let pivot = (k..n).max_by(|i, j| a[i * n + k].abs().total_cmp(&a[j * n + k].abs())).unwrap_or(k);
            pivots.push(pivot);
            if pivot != k {
                (0..n).for_each(|j| a.swap(k * n + j, pivot * n + j));
            }
            let (done, rest) = a.split_at_mut((k + 1) * n);
            let row = &done[k * n..];
            for other in rest.chunks_mut(n).filter(|other| other[k] != 0.0) {
                other[k] /= row[k];
                let factor = other[k];
                (k + 1..n).for_each(|j| other[j] -= factor * row[j]);
            }
        }
        DenseFactors { size: n, factors: a, pivots }
    }
    /// The solution for a right-hand side.
    fn solve(&self, mut b: Vec<f64>) -> Vec<f64> {
        let (n, a) = (self.size, &self.factors);
        self.pivots.iter().enumerate().for_each(|(k, &p)| b.swap(k, p));
        for k in 0..n {
            let known: f64 = (0..k).map(|j| a[k * n + j] * b[j]).sum();
            b[k] -= known;
        }
        for k in (0..n).rev() {
            let known: f64 = (k + 1..n).map(|j| a[k * n + j] * b[j]).sum();
            b[k] = (b[k] - known) / a[k * n + k];
        }
        b
    }
}

/// True if the network fixes the level of the temperatures of a zone that it touches.
pub(super) fn fixes_level(network: &ThermalNetwork) -> bool {
    let has_air = |k: usize| {
        let surfaces = network.surface_nodes.iter().zip(&network.convection);
        surfaces.into_iter().any(|(n, c)| *n == Some(k) && c.is_some_and(|c| c.coefficient > 0.0))
    };
    let mut is_fixed: Vec<bool> =
        (0..network.nodes.len()).map(|k| !network.is_unknown(k) || has_air(k)).collect();
    for _ in 0..network.nodes.len() {
        for l in &network.links {
            let [a, b] = l.nodes;
            let (LinkLaw::Conductance(c) | LinkLaw::ConductancePerArea(c) | LinkLaw::EffectiveEmissivity(c)) =
                l.law;
            if c > 0.0 && (is_fixed[a] || is_fixed[b]) {
                (is_fixed[a], is_fixed[b]) = (true, true);
            }
        }
    }
    let of_surface = |(node, air): (&Option<usize>, &Option<zonal_scene::Convection>)| match node {
        Some(k) => is_fixed[*k],
        None => air.is_some_and(|c| c.coefficient > 0.0),
    };
    network.surface_nodes.iter().zip(&network.convection).any(of_surface)
}
