//! `[solve]`: settings of the solver.

use crate::input::reading::error::InputError;
use crate::input::toml::key_tables::SOLVE;
use crate::input::toml::node::TomlNode;
use zonal_scene::{Engine, LightGrouping, SolveOptions};
use zonal_scene::{PatchRule, ZoneBasis};

/// Reads the settings; keys that are absent keep their defaults.
pub(crate) fn read_options(node: &TomlNode<'_>) -> Result<SolveOptions, InputError> {
    let t = node.table(SOLVE)?;
    let mut o = SolveOptions::default();
    if let Some(x) = t.read("tolerance", fraction)? {
        o.tolerance = x;
    }
    o.patch_size = t.read("patch_size", |n| n.positive())?;
    if let Some(i) = t.read("patch_rule", |n| n.choice(&PatchRule::NAMES))? {
        o.patch_rule = PatchRule::VARIANTS[i];
    }
    if let Some(i) = t.read("closure", |n| n.choice(&["measure", "restore"]))? {
        o.restore_closure = Some(i == 1);
    }
    if let Some(x) = t.read("residual", fraction)? {
        o.residual = x;
    }
    if let Some(n) = t.read("max_iterations", |n| n.count())? {
        o.max_iterations = n;
    }
    o.scattering_orders = t.read("scattering_orders", |n| n.count())?;
    if let Some(i) = t.read("engine", |n| n.choice(&Engine::NAMES))? {
        o.engine = Engine::VARIANTS[i];
    }
    if let Some(i) = t.read("light_groups", |n| n.choice(&LightGrouping::NAMES))? {
        o.light_grouping = LightGrouping::VARIANTS[i];
    }
    if let Some(i) = t.read("zone_basis", |n| n.choice(&ZoneBasis::NAMES))? {
        o.zone_basis = ZoneBasis::VARIANTS[i];
    }
    o.discretization_error = t.read("discretization_error", |n| n.boolean())?;
    Ok(o)
}

/// A number between 0 and 1.
fn fraction(n: TomlNode<'_>) -> Result<f64, InputError> {
    match n.number()? {
        x if x > 0.0 && x < 1.0 => Ok(x),
        x => Err(n.error(format!("{x} is out of range; give a number above 0 and below 1"))),
    }
}
