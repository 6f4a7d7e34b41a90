//! `bands`: the number of bands, or their wavelengths.

use crate::input::error::InputError;
use crate::input::toml::node::{TomlNode, TomlTable};
use zonal_scene::{BandSet, MAX_BANDS};

/// The bands of a document: red, green and blue if the key is missing.
pub(crate) fn read_bands(root: &TomlTable<'_>) -> Result<BandSet, InputError> {
    let Some(node) = root.get("bands") else { return Ok(BandSet::default()) };
    let set = match node.is_list() {
        true => BandSet::by_wavelength(read_wavelengths(&node)?),
        false => BandSet::numbered(node.count()?),
    };
    set.map_err(|e| node.error(e.message().to_string()))
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
