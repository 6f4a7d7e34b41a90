//! The error budget of the refinement: power, its variation and the tolerance of every node, from an approximate solution.
//!
//! From strengths s known approximately, node j sends M_j = Σ W s, and s varies over it by the standard deviation σ_j. Both are relative
//! to the mean incident radiation, H̄ for patches and Ḡ for volumes. The largest value over bands and light groups counts, so that every
//! group is served, and a uniform floor of strength keeps links that carry no power. One link may leave at node i the relative error
//!
//! ```text
//! tol_i = ε ((1 − α) + α min(1, H_i/H̄)) / √(leaves of i)
//! ```
//!
//! which is smaller for dark zones, and for large clusters, whose error all their leaves share.

use super::tree::{ClusterKind, ClusterTree};
use zonal_exchange::pair::scaled_radiosity_coefficient;
use zonal_scene::{Band, Bands, Zones};

/// How tolerances and floors follow from the approximate solution.
struct ErrorBudgetParams {
    /// α: weight of a zone's own incident radiation in its tolerance.
    own_incident_weight: f64,
    /// Uniform strength that every node has at least, relative to the mean incident radiation.
    strength_floor: f64,
}

const ERROR_BUDGET_PARAMS: ErrorBudgetParams =
    ErrorBudgetParams { own_incident_weight: 0.8, strength_floor: 0.03 };

/// H̄/Ḡ where it is unknown: that of an isotropic field.
const ISOTROPIC_IRRADIANCE_OVER_FLUENCE: f64 = 0.25;

/// Powers and tolerances of every node.
pub(crate) struct ErrorBudget {
    /// M_j relative to H̄: largest over bands and groups.
    pub power: Vec<f32>,
    /// W_j σ_j relative to H̄.
    pub power_deviation: Vec<f32>,
    /// tol_i.
    pub tolerance: Vec<f32>,
    /// H̄/Ḡ: weight of the incident radiation of volumes.
    pub volume_weight: f64,
}

/// The approximate solution of a light group.
pub(crate) struct GroupSolution<'a> {
    /// Strengths c B, W/m² or W/m³.
    pub strengths: &'a [Bands],
    /// H of patches, G of volumes, W/m².
    pub incident: &'a [Bands],
}

impl GroupSolution<'_> {
    /// True if both bands have the same strengths.
    fn has_equal_strengths(&self, a: Band, b: Band) -> bool {
        self.strengths.iter().all(|s| s[a] == s[b])
    }
}

/// Mean incident radiation of patches, and of volumes.
fn mean_incident(tree: &ClusterTree, zones: &Zones, incident: &[Bands]) -> [Bands; 2] {
    let mut sums = [Bands::ZERO; 2];
    let mut weights = [0.0; 2];
    for leaf in 0..tree.leaves() {
        let n = &tree.nodes[tree.leaf_node(leaf)];
        let zone = tree.leaf_zones[leaf] as usize;
        let k = usize::from(zone >= zones.voxel_offset());
        if n.kind == ClusterKind::Pane {
            continue;
        }
        weights[k] += n.measure as f64;
        sums[k] += n.measure as f64 * incident[zone];
    }
    [0, 1].map(|k| if weights[k] > 0.0 { sums[k] / weights[k] } else { Bands::ZERO })
}

/// Largest values of every node over the bands and groups included.
struct NodeMaxima {
    power: Vec<f32>,
    power_deviation: Vec<f32>,
    incident: Vec<f32>,
}

impl ErrorBudget {
    /// The budget for the tolerance `epsilon` from the approximate solution of each light group.
    pub(crate) fn new(
        tree: &ClusterTree,
        zones: &Zones,
        groups: &[GroupSolution],
        epsilon: f64,
    ) -> ErrorBudget {
        let nodes = tree.nodes.len();
        let zeros = || vec![0.0f32; nodes];
        let mut maxima = NodeMaxima { power: zeros(), power_deviation: zeros(), incident: zeros() };
        let mut volume_weight: f64 = 0.0;
        for group in groups {
            let [patches, volumes] = mean_incident(tree, zones, group.incident);
            let previous = std::iter::once(None).chain(Band::all().map(Some));
            for (b, before) in Band::all().zip(previous) {
                if before.is_some_and(|a| group.has_equal_strengths(a, b)) {
                    continue;
                }
                // Mean irradiance and fluence; either one from the other in a scene of one kind of zones.
                let surface = if patches[b] > 0.0 {
                    patches[b]
                } else {
                    ISOTROPIC_IRRADIANCE_OVER_FLUENCE * volumes[b]
                };
                if surface <= 0.0 {
                    continue;
                }
                let volume = if volumes[b] > 0.0 { volumes[b] } else { 4.0 * surface };
                volume_weight = volume_weight.max(surface / volume);
                maxima.include(tree, zones, (group, b), [surface, volume]);
            }
        }
        let alpha = ERROR_BUDGET_PARAMS.own_incident_weight;
        let tolerance = (0..nodes)
            .map(|n| {
                let leaves = tree.nodes[n].leaves() as f64;
                let h = (maxima.incident[n] as f64).min(1.0);
                (epsilon * ((1.0 - alpha) + alpha * h) / leaves.sqrt()) as f32
            })
            .collect();
        ErrorBudget {
            power: maxima.power,
            power_deviation: maxima.power_deviation,
            tolerance,
            volume_weight: if volume_weight > 0.0 {
                volume_weight
            } else {
                ISOTROPIC_IRRADIANCE_OVER_FLUENCE
            },
        }
    }
}

impl NodeMaxima {
    /// Includes band `b` of a group; `scale` is the mean incident radiation of patches, and of volumes.
    fn include(
        &mut self,
        tree: &ClusterTree,
        zones: &Zones,
        (group, b): (&GroupSolution, Band),
        scale: [f64; 2],
    ) {
        // W, Σ W s, Σ W s², Σ W H of every node, relative to the scale.
        let nodes = tree.nodes.len();
        let mut sums = vec![[0.0f64; 3]; nodes];
        for n in (0..nodes).rev() {
            let node = &tree.nodes[n];
            if node.is_leaf() {
                let zone = tree.zone_of(node);
                let w = node.measure as f64;
                let coefficient = scaled_radiosity_coefficient(zones, zone)[b];
                let floor = ERROR_BUDGET_PARAMS.strength_floor * scale[0] * coefficient;
                let s = (group.strengths[zone][b] + floor) / scale[0];
                let unit = if node.kind == ClusterKind::Patch { scale[0] } else { scale[1] };
                let h = group.incident[zone][b] / unit;
                sums[n] = [w * s, w * s * s, w * h];
            } else {
                sums[n] = tree.children(n as u32).iter().fold([0.0; 3], |t, &k| {
                    let x = sums[k as usize];
                    [t[0] + x[0], t[1] + x[1], t[2] + x[2]]
                });
            }
            let w = node.measure as f64;
            let mean = sums[n][0] / w;
            let sigma = (sums[n][1] / w - mean * mean).max(0.0).sqrt();
            self.power[n] = self.power[n].max(sums[n][0] as f32);
            self.power_deviation[n] = self.power_deviation[n].max((w * sigma) as f32);
            self.incident[n] = self.incident[n].max((sums[n][2] / w) as f32);
        }
    }
}
