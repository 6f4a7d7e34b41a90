//! Materials of a mesh that lack values, named together in one error.

use crate::input::reading::error::InputError;
use crate::input::reading::notes::quoted_list;
use crate::input::toml::node::TomlTable;

/// Most materials that an error names for each value.
pub(crate) const MAX_NAMED_MATERIALS: usize = 24;

/// A value that a material needs and nothing gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MissingValue {
    /// Temperature or heat of an opaque material, in thermal mode.
    Condition,
    /// Emissivity of an opaque material, in thermal mode.
    Emissivity,
    /// Thickness of a pane.
    Thickness,
    /// Extinction of a pane or a region.
    Extinction,
}

/// All of them, in the order of messages.
const MISSING_VALUES: [MissingValue; 4] =
    [MissingValue::Condition, MissingValue::Emissivity, MissingValue::Thickness, MissingValue::Extinction];

impl MissingValue {
    /// The value in messages, and the keys that give it.
    fn noun_and_keys(self) -> (&'static str, &'static str) {
        match self {
            MissingValue::Condition => {
                ("temperature or heat", "temperature (K), heat_flux (W/m2), net_power (W) or node")
            }
            MissingValue::Emissivity => ("emissivity", "emissivity"),
            MissingValue::Thickness => ("thickness of the glass", "pane.thickness (m)"),
            MissingValue::Extinction => ("extinction of the glass", "pane.extinction (1/m)"),
        }
    }
}

/// Refuses a mesh of which several materials lack values. `missing` has a name and a value for each gap; of one material alone the error of its
/// surface or pane tells.
pub(crate) fn refuse_missing(
    table: &TomlTable<'_>,
    missing: &[(&str, MissingValue)],
) -> Result<(), InputError> {
    let Some((first, _)) = missing.first() else { return Ok(()) };
    if missing.iter().all(|(name, _)| name == first) {
        return Ok(());
    }
    let (mut gaps, mut remedies) = (Vec::new(), Vec::new());
    for value in MISSING_VALUES {
        let names: Vec<&str> = missing.iter().filter(|(_, v)| *v == value).map(|(name, _)| *name).collect();
        if !names.is_empty() {
            let (noun, keys) = value.noun_and_keys();
            gaps.push(format!("the {noun} of {}", quoted_list(&names, MAX_NAMED_MATERIALS)));
            remedies.push(keys);
        }
    }
    let lacks = |value: MissingValue| missing.iter().any(|(_, v)| *v == value);
    let shared = if lacks(MissingValue::Condition) || lacks(MissingValue::Emissivity) {
        ", or what is the same for all surfaces in this table"
    } else {
        ""
    };
    let opaque = if lacks(MissingValue::Thickness) || lacks(MissingValue::Extinction) {
        "; pane = false makes a glass an opaque surface"
    } else {
        ""
    };
    Err(table.error(format!(
        "these values of materials are missing: {}; write {} in materials.\"{first}\" and so on{shared}{opaque}",
        gaps.join("; "),
        remedies.join(", ")
    )))
}
