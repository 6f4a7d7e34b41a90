//! `[[node]]`: bodies at one temperature and the links between them; `node` and convection of surfaces.

use crate::input::reading::error::InputError;
use crate::input::scene::scene_reader::SceneReader;
use crate::input::toml::key_tables::ROOT;
use crate::input::toml::keys::Key;
use crate::input::toml::node::{TomlNode, TomlTable};
use crate::input::toml::surface_keys::SURFACE_PROPERTIES;
use crate::input::toml::thermal_keys::{NODE, NODE_LINK, Node, NodeLink as LinkKeys};
use zonal_scene::{
    Convection, LinkLaw, NodeCondition, NodeLink, ThermalCondition, ThermalNetwork, ThermalNode,
};

/// The law of a link with a coefficient.
type LawOf = fn(f64) -> LinkLaw;
/// Keys of a link, of which one is given, with their laws.
const LINK_LAWS: [(Key<f64>, LawOf); 3] = [
    (NODE_LINK.conductance, LinkLaw::Conductance),
    (NODE_LINK.conductance_per_area, LinkLaw::ConductancePerArea),
    (NODE_LINK.effective_emissivity, LinkLaw::EffectiveEmissivity),
];

/// Reads the nodes of a scene in thermal mode, before the surfaces that name them.
pub(crate) fn read_nodes(root: &TomlTable<'_>, reader: &mut SceneReader<'_>) -> Result<(), InputError> {
    let list = root.list(&ROOT.node)?;
    let Some(thermal) = &mut reader.parts.thermal else {
        return match list.first() {
            Some(n) => Err(n.error(
                "nodes belong to thermal mode; write mode = \"thermal\" at the top of the file, or remove this table",
            )),
            None => Ok(()),
        };
    };
    let tables = list.iter().map(|n| n.table(Node::TABLE)).collect::<Result<Vec<_>, _>>()?;
    let mut network = ThermalNetwork::default();
    for (t, n) in tables.iter().zip(&list) {
        let name = t.required(&NODE.name)?;
        let temperature = t.value(&NODE.temperature)?;
        let power = t.value(&NODE.net_power)?;
        let condition = match (temperature, power) {
            (Some(_), Some(_)) => {
                return Err(n.error("temperature and net_power are both given; keep one of them"));
            }
            (Some(kelvin), None) => NodeCondition::Temperature(kelvin),
            (None, power) => NodeCondition::Power(power.unwrap_or(0.0)),
        };
        network.nodes.push(ThermalNode { name, condition });
    }
    for (k, t) in tables.iter().enumerate() {
        for link in t.list(&NODE.links)? {
            let link = read_link(&link, k, &network.nodes)?;
            network.links.push(link);
        }
    }
    thermal.network = Some(network);
    Ok(())
}

/// A link of node `from`.
fn read_link(node: &TomlNode<'_>, from: usize, nodes: &[ThermalNode]) -> Result<NodeLink, InputError> {
    let t = node.table(LinkKeys::TABLE)?;
    let to = t.require(&NODE_LINK.to)?;
    let other = index_of(&to, nodes)?;
    if other == from {
        return Err(to.error("a node has no link to itself; name another node"));
    }
    let given: Vec<_> = LINK_LAWS.iter().filter_map(|(key, law)| Some((key, law, t.get(key)?))).collect();
    let [(key, law, value)] = given.as_slice() else {
        return Err(node.error("a link has one law; give one of conductance (W/K), conductance_per_area (W/(m2 K)), effective_emissivity"));
    };
    Ok(NodeLink { nodes: [from, other], law: law(key.read(value)?) })
}

/// The index of the node of a name.
fn index_of(name: &TomlNode<'_>, nodes: &[ThermalNode]) -> Result<usize, InputError> {
    let text = name.text()?;
    nodes.iter().position(|n| n.name == text).ok_or_else(|| {
        let known: Vec<&str> = nodes.iter().map(|n| n.name.as_str()).collect();
        if known.is_empty() {
            name.error(format!("there is no node '{text}'; add [[node]] with name = \"{text}\""))
        } else {
            name.error(format!("there is no node '{text}'; the nodes are: {}", known.join(", ")))
        }
    })
}

/// The node that a surface names, and what is known of its surfaces.
pub(crate) fn read_surface_node(
    t: &TomlTable<'_>,
    reader: &SceneReader<'_>,
) -> Result<Option<(usize, ThermalCondition)>, InputError> {
    let Some(name) = t.get(&SURFACE_PROPERTIES.node) else { return Ok(None) };
    let network = reader.parts.thermal.as_ref().and_then(|t| t.network.as_ref());
    let nodes = network.map_or(&[][..], |n| &n.nodes);
    let k = index_of(&name, nodes)?;
    Ok(Some(match nodes[k].condition {
        NodeCondition::Temperature(kelvin) => (k, ThermalCondition::Temperature(kelvin)),
        NodeCondition::Power(_) => (k, ThermalCondition::Flux(0.0)),
    }))
}

/// The convection of a surface.
pub(crate) fn read_convection(t: &TomlTable<'_>) -> Result<Option<Convection>, InputError> {
    let coefficient = t.value(&SURFACE_PROPERTIES.heat_transfer_coefficient)?;
    let ambient = t.value(&SURFACE_PROPERTIES.ambient_temperature)?;
    match (coefficient, ambient) {
        (Some(coefficient), Some(ambient)) => Ok(Some(Convection { coefficient, ambient })),
        (None, None) => Ok(None),
        _ => Err(t.error(
            "convection takes both heat_transfer_coefficient (W/(m2 K)) and ambient_temperature (K); give both",
        )),
    }
}
