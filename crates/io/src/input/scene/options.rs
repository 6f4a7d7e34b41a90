//! `[solve]`: settings of the solver.

use crate::input::reading::error::InputError;
use crate::input::toml::key_tables::{SOLVE, Solve};
use crate::input::toml::node::TomlTable;
use zonal_scene::SolveOptions;

/// The settings of a table in place of those of `base`.
pub(crate) fn read_options(t: &TomlTable<'_>, base: SolveOptions) -> Result<SolveOptions, InputError> {
    t.check(Solve::TABLE)?;
    Ok(SolveOptions {
        tolerance: t.value(&SOLVE.tolerance)?.unwrap_or(base.tolerance),
        patch_size: t.value(&SOLVE.patch_size)?.or(base.patch_size),
        patch_rule: t.value(&SOLVE.patch_rule)?.unwrap_or(base.patch_rule),
        restore_closure: t.value(&SOLVE.closure)?.map(|i| i == 1).or(base.restore_closure),
        residual: t.value(&SOLVE.residual)?.unwrap_or(base.residual),
        max_iterations: t.value(&SOLVE.max_iterations)?.unwrap_or(base.max_iterations),
        scattering_orders: t.value(&SOLVE.scattering_orders)?.or(base.scattering_orders),
        engine: t.value(&SOLVE.engine)?.unwrap_or(base.engine),
        light_grouping: t.value(&SOLVE.light_groups)?.unwrap_or(base.light_grouping),
        zone_basis: t.value(&SOLVE.zone_basis)?.unwrap_or(base.zone_basis),
        discretization_error: t.value(&SOLVE.discretization_error)?.or(base.discretization_error),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn documented_defaults_are_those_of_the_options() {
        let defaults = SolveOptions::default();
        assert_eq!(SOLVE.tolerance.default().unwrap(), defaults.tolerance);
        assert_eq!(SOLVE.residual.default().unwrap(), defaults.residual);
        assert_eq!(SOLVE.max_iterations.default().unwrap(), defaults.max_iterations);
        assert_eq!(SOLVE.engine.default().unwrap(), defaults.engine);
        assert_eq!(SOLVE.light_groups.default().unwrap(), defaults.light_grouping);
        assert_eq!(SOLVE.zone_basis.default().unwrap(), defaults.zone_basis);
    }
}
