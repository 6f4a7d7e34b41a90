//! Validation of thermal conditions against the scene that they belong to.

use crate::band::{Band, PerBand};
use crate::bands::Bands;
use crate::options::LightGrouping;
use crate::scene_error::{SceneError, invalid};
use crate::scene_parts::SceneParts;
use crate::surface::{Pane, Surface};
use crate::thermal::{Thermal, ThermalCondition};
use crate::voxel_grid::VoxelGrid;

/// Validates the thermal conditions of a scene.
pub(crate) fn check_thermal(thermal: &Thermal, parts: &SceneParts) -> Result<(), SceneError> {
    thermal.band_fractions.check()?;
    if thermal.surfaces.len() != parts.surfaces.len() || thermal.panes.len() != parts.panes.len() {
        return invalid("thermal", "give a thermal condition for each surface and pane, or for none");
    }
    if !parts.lights.is_empty() {
        return invalid(
            "light",
            "lights belong to mode = \"light\"; in thermal mode give temperatures, or heat_flux to what the sun warms",
        );
    }
    if parts.options.light_grouping == LightGrouping::Each {
        return invalid(
            "solve.light_groups",
            "heat is one sum: temperatures of separate lights do not add; remove this key in thermal mode",
        );
    }
    if parts.options.scattering_orders.is_some() {
        return invalid(
            "solve.scattering_orders",
            "scattering orders are not defined for coupled temperatures; remove this key in thermal mode",
        );
    }
    if let Some(t) = thermal.surroundings {
        ThermalCondition::Temperature(t).check(|k| format!("surroundings.{k}"))?;
    }
    let emitting = thermal.band_fractions.emitting_bands();
    for (s, condition) in parts.surfaces.iter().zip(&thermal.surfaces) {
        check_surface(thermal, s, *condition, emitting)?;
    }
    for (facet, v) in parts.facets.iter().zip(&parts.faces.values) {
        // The values of a facet in place of those of its surface.
        let (s, condition) = (&parts.surfaces[facet.surface], thermal.surfaces[facet.surface]);
        let own = Surface {
            reflectance: v.reflectance.unwrap_or(s.reflectance),
            emission: v.emission.unwrap_or(s.emission),
            name: s.name.clone(),
            ..*s
        };
        check_surface(thermal, &own, v.condition.unwrap_or(condition), emitting)?;
    }
    if parts.faces.values.iter().any(|v| matches!(v.condition, Some(ThermalCondition::Power(_)))) {
        check_power_has_faces(parts)?;
    }
    for (p, condition) in parts.panes.iter().zip(&thermal.panes) {
        check_pane(thermal, p, *condition)?;
    }
    parts.voxel_grid.as_ref().map_or(Ok(()), |grid| check_medium(thermal, grid, emitting))
}

/// Refuses a power of a face on a facet without one.
fn check_power_has_faces(parts: &SceneParts) -> Result<(), SceneError> {
    let faces = &parts.faces;
    let lacks_face = |k: usize| {
        matches!(faces.values[k].condition, Some(ThermalCondition::Power(_))) && faces.face_of(k).is_none()
    };
    match (0..faces.values.len()).any(lacks_face) {
        true => invalid("mesh", "a facet without a face has the power of a face; give a heat flux"),
        false => Ok(()),
    }
}

/// Refuses bands that differ in a grey scene.
fn check_grey(thermal: &Thermal, key: String, v: Bands) -> Result<(), SceneError> {
    if thermal.band_fractions.is_grey() && !v.is_grey() {
        return invalid(
            key,
            "the bands differ, but a grey scene has one; give one number, or [thermal] band_fractions",
        );
    }
    Ok(())
}

fn check_surface(
    thermal: &Thermal,
    s: &Surface,
    condition: ThermalCondition,
    emitting: PerBand<bool>,
) -> Result<(), SceneError> {
    let key = |k: &str| format!("surface '{}'.{k}", s.name);
    condition.check(key)?;
    check_grey(thermal, key("emissivity"), s.reflectance)?;
    if s.emission != Bands::ZERO || s.emission_texture.is_some() || s.reflectance_texture.is_some() {
        return invalid(
            key("emission"),
            "emission and pictures belong to mode = \"light\"; give a temperature and an emissivity",
        );
    }
    if condition.prescribed_power() == 0.0 {
        return Ok(());
    }
    let power_key = if matches!(condition, ThermalCondition::Power(_)) { "net_power" } else { "heat_flux" };
    if s.reflectance == Bands::ONE {
        return invalid(
            key(power_key),
            "a surface of emissivity 0 can give no power; raise its emissivity, or give 0",
        );
    }
    if !Band::all().any(|b| emitting[b] && s.reflectance[b] < 1.0) {
        return invalid(
            key(power_key),
            "the emissivity is 0 in every band that has a fraction of the emission, so that the surface can give no power; raise it in one of them, or give 0",
        );
    }
    Ok(())
}

fn check_pane(thermal: &Thermal, p: &Pane, condition: ThermalCondition) -> Result<(), SceneError> {
    let key = |k: &str| format!("pane '{}'.{k}", p.name);
    condition.check(key)?;
    check_grey(thermal, key("extinction"), p.extinction)?;
    check_grey(thermal, key("albedo"), p.albedo)?;
    if p.emission != Bands::ZERO {
        return invalid(key("emission"), "emission belongs to mode = \"light\"; give a temperature");
    }
    if !matches!(condition, ThermalCondition::Temperature(_) | ThermalCondition::Flux(0.0)) {
        return invalid(key("heat_source"), "a pane has a temperature, or heat_source = 0; give one of them");
    }
    Ok(())
}

fn check_medium(thermal: &Thermal, grid: &VoxelGrid, emitting: PerBand<bool>) -> Result<(), SceneError> {
    if !grid.is_thermal() {
        return invalid(
            "medium",
            "neither temperature nor heat_source is given; write heat_source = 0 for radiative equilibrium",
        );
    }
    for i in grid.distinct_cells() {
        check_grey(thermal, "medium.extinction".into(), grid.extinction(i))?;
        check_grey(thermal, "medium.albedo".into(), grid.albedo(i))?;
        if grid.emission(i) != Bands::ZERO || grid.source(i) != Bands::ZERO {
            return invalid(
                "medium.emission",
                "emission and source belong to mode = \"light\"; give temperature or heat_source",
            );
        }
        let (k, o) = (grid.extinction(i), grid.albedo(i));
        let has_power = grid.heat(i).is_some_and(|h| h.prescribed_power() != 0.0);
        if has_power && !Band::all().any(|b| emitting[b] && k[b] * (1.0 - o[b]) > 0.0) {
            let [x, y, z] = grid.coordinates(i);
            return invalid(
                "medium.heat_source",
                format!(
                    "in cell ({x}, {y}, {z}) the medium absorbs in no band that has a fraction of the emission, so that it can give no heat; raise extinction or band fractions there, or give 0"
                ),
            );
        }
    }
    Ok(())
}
