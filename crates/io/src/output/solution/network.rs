//! Nodes, links and convection in the header of a solution.

use serde::{Deserialize, Serialize};
use zonal_scene::{Convection, LinkLaw, NodeCondition, NodeLink, ThermalNetwork, ThermalNode, printable};

/// A thermal network.
#[derive(Serialize, Deserialize)]
pub(super) struct NetworkFormat {
    nodes: Vec<NodeFormat>,
    links: Vec<LinkFormat>,
    /// The node of each surface.
    surface_nodes: Vec<Option<usize>>,
    /// Heat transfer coefficient, W/(m² K), and temperature of the air, K, of each surface.
    convection: Vec<Option<[f64; 2]>>,
}

#[derive(Serialize, Deserialize)]
struct NodeFormat {
    name: String,
    #[serde(rename = "temperature_K", default, skip_serializing_if = "Option::is_none")]
    temperature: Option<f64>,
    /// Of a node of unknown temperature.
    #[serde(rename = "net_power_W", default, skip_serializing_if = "Option::is_none")]
    power: Option<f64>,
}

#[derive(Serialize, Deserialize)]
struct LinkFormat {
    nodes: [usize; 2],
    #[serde(flatten)]
    law: LawFormat,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum LawFormat {
    Conductance(f64),
    ConductancePerArea(f64),
    EffectiveEmissivity(f64),
}

impl NetworkFormat {
    pub(super) fn new(network: &ThermalNetwork) -> NetworkFormat {
        let node = |n: &ThermalNode| match n.condition {
            NodeCondition::Temperature(t) => {
                NodeFormat { name: n.name.clone(), temperature: Some(t), power: None }
            }
            NodeCondition::Power(p) => NodeFormat { name: n.name.clone(), temperature: None, power: Some(p) },
        };
        let link = |l: &NodeLink| LinkFormat {
            nodes: l.nodes,
            law: match l.law {
                LinkLaw::Conductance(c) => LawFormat::Conductance(c),
                LinkLaw::ConductancePerArea(c) => LawFormat::ConductancePerArea(c),
                LinkLaw::EffectiveEmissivity(e) => LawFormat::EffectiveEmissivity(e),
            },
        };
        NetworkFormat {
            nodes: network.nodes.iter().map(node).collect(),
            links: network.links.iter().map(link).collect(),
            surface_nodes: network.surface_nodes.clone(),
            convection: network.convection.iter().map(|c| c.map(|c| [c.coefficient, c.ambient])).collect(),
        }
    }

    /// The network; the constructor of the scene checks it.
    pub(super) fn into_network(self) -> ThermalNetwork {
        let node = |n: NodeFormat| ThermalNode {
            name: printable(&n.name).to_string(),
            condition: match n.temperature {
                Some(t) => NodeCondition::Temperature(t),
                None => NodeCondition::Power(n.power.unwrap_or(0.0)),
            },
        };
        let link = |l: LinkFormat| NodeLink {
            nodes: l.nodes,
            law: match l.law {
                LawFormat::Conductance(c) => LinkLaw::Conductance(c),
                LawFormat::ConductancePerArea(c) => LinkLaw::ConductancePerArea(c),
                LawFormat::EffectiveEmissivity(e) => LinkLaw::EffectiveEmissivity(e),
            },
        };
        let convection =
            |c: Option<[f64; 2]>| c.map(|[coefficient, ambient]| Convection { coefficient, ambient });
        ThermalNetwork {
            nodes: self.nodes.into_iter().map(node).collect(),
            links: self.links.into_iter().map(link).collect(),
            surface_nodes: self.surface_nodes,
            convection: self.convection.into_iter().map(convection).collect(),
        }
    }
}
