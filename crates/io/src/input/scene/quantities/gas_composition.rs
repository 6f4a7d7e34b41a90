//! `gas = { model, h2o, co2, soot, pressure }` of a medium or region: a gas model by name, and the composition of the gas.
//!
//! A scene has one model. Its grey gases are the bands. Composition and pressure may vary from voxel to voxel; a voxel that is filled in part takes the
//! mean over its volume.

use crate::input::reading::error::InputError;
use crate::input::toml::key_tables::ROOT;
use crate::input::toml::medium_keys::{GAS, Gas, MEDIUM, MEDIUM_PROPERTIES};
use crate::input::toml::node::{TomlNode, TomlTable};
use zonal_gas::{GasModel, GasState};

/// The quantities of a composition, in the order of [`Composition`].
pub(crate) const GAS_QUANTITIES: [&str; 4] = ["h2o", "co2", "soot", "pressure"];

/// Mole fractions of H2O and CO2, volume fraction of soot, and pressure in Pa.
pub(crate) type Composition = [f64; 4];

/// The quantities of a composition that a table gives as numbers.
pub(crate) type GasValues = [Option<f64>; 4];

/// The gas model of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SceneGas {
    pub(crate) model: GasModel,
    /// True if some part of the medium has soot.
    pub(crate) has_soot: bool,
}

impl SceneGas {
    /// Number of bands.
    pub(crate) fn bands(self) -> usize {
        self.model.gas_count(self.has_soot)
    }
}

/// The gas model of a document: that of the medium and of all its regions; none without a key `gas`.
pub(crate) fn find_gas(root: &TomlTable<'_>) -> Result<Option<SceneGas>, InputError> {
    let Some(medium) = root.get(&ROOT.medium).filter(TomlNode::is_table) else { return Ok(None) };
    let medium = medium.any_table()?;
    let mut tables = vec![medium.get(&MEDIUM_PROPERTIES.gas)];
    if let Some(regions) = medium.get(&MEDIUM.region).filter(TomlNode::is_list) {
        for region in regions.list()?.iter().filter(|n| n.is_table()) {
            tables.push(region.any_table()?.get(&MEDIUM_PROPERTIES.gas));
        }
    }
    let mut found: Option<SceneGas> = None;
    for node in tables.into_iter().flatten() {
        let t = node.table(Gas::TABLE)?;
        let names = GasModel::VARIANTS.map(GasModel::name);
        let model = t.get(&GAS.model).map(|n| n.choice(&names).map(|k| GasModel::VARIANTS[k])).transpose()?;
        let has_soot = t.get(&GAS.soot).is_some_and(|n| n.is_table() || n.number().is_ok_and(|x| x != 0.0));
        match (&mut found, model) {
            (None, Some(model)) => found = Some(SceneGas { model, has_soot }),
            (None, None) => {
                t.require(&GAS.model)?;
            }
            (Some(gas), Some(model)) if model != gas.model => {
                let message = format!(
                    "a scene has one gas model, and this one differs from {}; give the same",
                    gas.model.name()
                );
                return Err(t.get(&GAS.model).map_or_else(|| t.error(&message), |n| n.error(&message)));
            }
            (Some(gas), _) => gas.has_soot |= has_soot,
        }
    }
    Ok(found)
}

/// The numbers of the key `gas` of a table of the medium; none without the key.
pub(crate) fn read_gas_values(t: &TomlTable<'_>) -> Result<Option<GasValues>, InputError> {
    let Some(node) = t.get(&MEDIUM_PROPERTIES.gas) else { return Ok(None) };
    let gas = node.table(Gas::TABLE)?;
    if let Some(n) = ["extinction", "absorption", "albedo", "density"].iter().find_map(|k| t.get(k)) {
        return Err(n.error("the gas gives the absorption, and nothing scatters; remove this key or the gas"));
    }
    let mut out = [None; 4];
    for (value, key) in out.iter_mut().zip(GAS_QUANTITIES) {
        let Some(n) = gas.get(key).filter(|n| !n.is_table()) else { continue };
        let x = n.number()?;
        check_quantity(key, x).map_err(|message| n.error(message))?;
        *value = Some(x);
    }
    Ok(Some(out))
}

/// Refuses a value that no composition has.
fn check_quantity(key: &str, x: f64) -> Result<(), String> {
    let valid = if key == "pressure" { x > 0.0 } else { (0.0..=1.0).contains(&x) };
    let wanted = if key == "pressure" { "pascals above 0" } else { "a fraction from 0 to 1" };
    if valid { Ok(()) } else { Err(format!("{x} is out of range; give {wanted}")) }
}

/// The composition of a voxel before anything fills it: no absorbing gas at one atmosphere.
pub(crate) fn no_gas() -> Composition {
    [0.0, 0.0, 0.0, GasState::default().pressure]
}
