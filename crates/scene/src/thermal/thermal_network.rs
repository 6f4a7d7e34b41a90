//! Bodies at one temperature, convection and conductances: what couples the temperatures of surfaces beside radiation.
//!
//! A **node** is a body at one temperature T. Its surfaces i, of area A_i, radiate the net flux q_i; it has a given net power P, loses heat to the air by
//! convection with coefficients h_i (W/(m² K)) at the temperatures T∞_i, and to other nodes K by conductances C (W/K) and radiative links R (m²):
//!
//! ```text
//!     Σ_i A_i q_i + Σ_i h_i A_i (T − T∞_i) + Σ_K C_K (T − T_K) + Σ_K R_K σ (T⁴ − T_K⁴) = P
//! ```
//!
//! A surface without a node that has a given net flux q₀ and convection has a temperature in each zone: q_i + h (T_i − T∞) = q₀.

use crate::base::limits::{MAX_NET_POWER, MAX_TEMPERATURE};
use crate::base::printable::printable_text;
use crate::base::scene_error::{SceneError, invalid};

/// Largest number of nodes: a step inverts their matrix.
const MAX_NODES: usize = 1000;
/// Largest coefficient of convection, conductance or link.
const MAX_COEFFICIENT: f64 = 1e12;

/// A body at one temperature.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
pub struct ThermalNode {
    /// Unique name.
    #[serde(deserialize_with = "printable_text")]
    pub name: String,
    /// What is known.
    #[serde(flatten)]
    pub condition: NodeCondition,
}

/// What is known of a node.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
pub enum NodeCondition {
    /// Temperature, K.
    #[serde(rename = "temperature_K")]
    Temperature(f64),
    /// Power supplied to the node by what the scene does not contain, W.
    #[serde(rename = "net_power_W")]
    Power(f64),
}

/// A heat path between two nodes.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
pub struct NodeLink {
    /// Indices of the nodes.
    pub nodes: [usize; 2],
    /// Its law.
    #[serde(flatten)]
    pub law: LinkLaw,
}

/// The law of a heat path.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LinkLaw {
    /// C (T − T'), C in W/K.
    Conductance(f64),
    /// C A (T − T'), C in W/(m² K), A the area of the first node's surfaces.
    ConductancePerArea(f64),
    /// ε A σ (T⁴ − T'⁴), ε an effective emissivity, A the area of the first node's surfaces.
    EffectiveEmissivity(f64),
}

/// Convection of a surface.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(from = "[f64; 2]", into = "[f64; 2]")]
pub struct Convection {
    /// Heat transfer coefficient h, W/(m² K).
    pub coefficient: f64,
    /// Temperature T∞ of the air, K.
    pub ambient: f64,
}

impl From<[f64; 2]> for Convection {
    fn from([coefficient, ambient]: [f64; 2]) -> Convection {
        Convection { coefficient, ambient }
    }
}

impl From<Convection> for [f64; 2] {
    fn from(c: Convection) -> [f64; 2] {
        [c.coefficient, c.ambient]
    }
}

/// Nodes, their links, and the surfaces that have nodes or convection.
#[derive(Clone, Debug, Default, PartialEq, serde::Deserialize, serde::Serialize)]
pub struct ThermalNetwork {
    /// The nodes.
    pub nodes: Vec<ThermalNode>,
    /// Heat paths between them.
    pub links: Vec<NodeLink>,
    /// Node of each surface.
    pub surface_nodes: Vec<Option<usize>>,
    /// Convection of each surface.
    pub convection: Vec<Option<Convection>>,
}

impl ThermalNetwork {
    /// True if the network says nothing: no surface has convection, and there is no node.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty() && self.convection.iter().all(Option::is_none)
    }
    /// True if the temperature of the node is unknown.
    pub fn is_unknown(&self, node: usize) -> bool {
        matches!(self.nodes[node].condition, NodeCondition::Power(_))
    }
    /// Multiplies powers and conductances that belong to whole bodies, where a scene is extended by its mirror images.
    pub(crate) fn scale(&mut self, factor: f64) {
        for node in &mut self.nodes {
            if let NodeCondition::Power(p) = &mut node.condition {
                *p *= factor;
            }
        }
        for link in &mut self.links {
            if let LinkLaw::Conductance(c) = &mut link.law {
                *c *= factor;
            }
        }
    }
    /// Validates ranges and indices for a number of surfaces.
    ///
    /// # Errors
    /// If a number is out of range, a node has no heat path at all, or names are not unique.
    pub fn check(&self, surfaces: usize) -> Result<(), SceneError> {
        if self.surface_nodes.len() != surfaces || self.convection.len() != surfaces {
            return invalid("node", "give a node and a convection, or none, for each surface");
        }
        if self.nodes.len() > MAX_NODES {
            return invalid(
                "node",
                format!("there are {} nodes; give at most {MAX_NODES}", self.nodes.len()),
            );
        }
        for (k, node) in self.nodes.iter().enumerate() {
            self.check_node(k, node)?;
        }
        let is_coefficient = |c: f64| (0.0..=MAX_COEFFICIENT).contains(&c);
        for c in self.convection.iter().flatten() {
            if !is_coefficient(c.coefficient) {
                let what =
                    format!("{} W/(m2 K) is out of range; give a number from 0 to 1e12", c.coefficient);
                return invalid("surface.heat_transfer_coefficient", what);
            }
            if !(c.ambient > 0.0 && c.ambient <= MAX_TEMPERATURE) {
                let what = format!("{} K is out of range; give kelvin above 0", c.ambient);
                return invalid("surface.ambient_temperature", what);
            }
        }
        for link in &self.links {
            let [a, b] = link.nodes;
            let (LinkLaw::Conductance(c) | LinkLaw::ConductancePerArea(c) | LinkLaw::EffectiveEmissivity(c)) =
                link.law;
            if a.max(b) >= self.nodes.len() || a == b || !is_coefficient(c) {
                return invalid("node.links", "give two different nodes and a number from 0 to 1e12");
            }
            let has_area = self.surface_nodes.contains(&Some(a));
            if !has_area && !matches!(link.law, LinkLaw::Conductance(_)) {
                let what = "this node has no surface, hence no area; give conductance, in W/K";
                return invalid(format!("node '{}'.links", self.nodes[a].name), what);
            }
        }
        Ok(())
    }
    fn check_node(&self, k: usize, node: &ThermalNode) -> Result<(), SceneError> {
        let key = |name: &str| format!("node '{}'.{name}", node.name);
        if self.nodes[..k].iter().any(|other| other.name == node.name) {
            return invalid(key("name"), "this name is given twice; give each node a name of its own");
        }
        match node.condition {
            NodeCondition::Temperature(t) if !(t > 0.0 && t <= MAX_TEMPERATURE) => {
                invalid(key("temperature"), format!("{t} K is out of range; give kelvin above 0"))
            }
            NodeCondition::Power(p) if p.is_nan() || p.abs() > MAX_NET_POWER => {
                let what = format!("{p:e} is out of range; give watts of a modulus up to {MAX_NET_POWER:e}");
                invalid(key("net_power"), what)
            }
            _ if self.surface_nodes.contains(&Some(k)) || self.links.iter().any(|l| l.nodes.contains(&k)) => {
                Ok(())
            }
            _ => invalid(
                key("name"),
                "no surface and no link refers to this node; write node = \"…\" in a surface",
            ),
        }
    }
}
