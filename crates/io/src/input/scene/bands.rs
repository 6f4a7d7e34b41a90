//! `bands`: the number of bands, or their wavelengths.

use crate::input::reading::error::InputError;
use crate::input::scene::quantities::gas_composition::{SceneGas, find_gas};
use crate::input::toml::key_tables::ROOT;
use crate::input::toml::node::{TomlNode, TomlTable};
use zonal_scene::{BandSet, MAX_BANDS};

/// The bands of a document, and its gas model. Without the key they are the grey gases of the model, the one band of a grey scene in thermal mode, or red,
/// green and blue. Lights of a scene in thermal mode add a band of sunlight.
pub(crate) fn read_bands(root: &TomlTable<'_>) -> Result<(BandSet, Option<SceneGas>), InputError> {
    let (mut bands, gas) = read_own_bands(root)?;
    let is_thermal = root.value(&ROOT.mode)? == Some(1);
    if is_thermal && root.get(&ROOT.bands).is_none() && gas.is_none() && root.get(&ROOT.thermal).is_none() {
        bands = BandSet::grey();
    }
    let lights = root.list(&ROOT.light)?;
    let Some(first) = lights.first().filter(|_| is_thermal) else { return Ok((bands, gas)) };
    let all = bands.with_solar_band();
    Ok((all.map_err(|e| first.error(e.message().to_string()))?, gas))
}

/// The bands of a document without that of sunlight, and its gas model.
fn read_own_bands(root: &TomlTable<'_>) -> Result<(BandSet, Option<SceneGas>), InputError> {
    let gas = find_gas(root)?;
    let set = match (root.get(&ROOT.bands), gas) {
        (None, None) => BandSet::default(),
        (None, Some(gas)) => {
            BandSet::numbered(gas.bands()).map_err(|e| root.error(e.message().to_string()))?
        }
        (Some(node), None) => {
            let set = if node.is_list() {
                BandSet::by_wavelength(read_wavelengths(&node)?)
            } else {
                BandSet::numbered(node.count()?)
            };
            set.map_err(|e| node.error(e.message().to_string()))?
        }
        (Some(node), Some(gas)) => {
            let (name, count) = (gas.model.name(), gas.bands());
            if node.is_list() || node.count()? != count {
                return Err(node
                    .error(format!("{name} has {count} grey gases, which are the bands; remove this key")));
            } else {
                BandSet::numbered(count).map_err(|e| node.error(e.message().to_string()))?
            }
        }
    };
    Ok((set, gas))
}

/// Limits of each band, nm.
fn read_wavelengths(node: &TomlNode<'_>) -> Result<Vec<[f64; 2]>, InputError> {
    let list = node.list()?;
    if list.len() > MAX_BANDS {
        return Err(node.error(format!("this list has {} bands; give at most {MAX_BANDS}", list.len())));
    }
    let band = |n: &TomlNode<'_>| match n.list()?.as_slice() {
        [from, to] => Ok([from.number()?, to.number()?]),
        _ => Err(n.error("a band has two limits; give [from, to] in nm")),
    };
    list.iter().map(band).collect()
}
