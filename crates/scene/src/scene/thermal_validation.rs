//! Validation of thermal conditions against the scene that they belong to.

use crate::bands::Bands;
use crate::bands::band::{Band, PerBand};
use crate::base::scene_error::{SceneError, invalid};
use crate::medium::voxel_grid::VoxelGrid;
use crate::model::light::Light;
use crate::model::options::LightGrouping;
use crate::model::surface::{Pane, Surface};
use crate::scene::scene_parts::SceneParts;
use crate::thermal::{BandFractions, Thermal, ThermalCondition};

/// Validates the thermal conditions of a scene.
pub(crate) fn check_thermal(thermal: &Thermal, parts: &SceneParts) -> Result<(), SceneError> {
    let is_whole = parts.bands.block_count() == 1;
    for fractions in thermal.all_fractions() {
        if is_whole { fractions.check()? } else { fractions.check_coefficients()? }
    }
    if thermal.band_fractions.is_grey() && parts.bands.count() > 1 {
        return missing_fractions();
    }
    check_cell_fractions(thermal, parts)?;
    if thermal.surfaces.len() != parts.surfaces.len() || thermal.panes.len() != parts.panes.len() {
        return invalid("thermal", "give a thermal condition for each surface and pane, or for none");
    }
    if let Some(network) = &thermal.network {
        network.check(parts.surfaces.len())?;
    }
    check_options(parts)?;
    if let Some(t) = thermal.surroundings {
        ThermalCondition::Temperature(t).check(|k| format!("surroundings.{k}"))?;
    }
    // Another block of bands may emit.
    let emitting = is_whole.then(|| thermal.band_fractions.emitting_bands());
    let emitters = direct_emitters(parts);
    for (k, (s, condition)) in parts.surfaces.iter().zip(&thermal.surfaces).enumerate() {
        check_surface(thermal, s, *condition, emitting)?;
        check_emission(thermal, s, emitters[k])?;
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
        check_emission(thermal, &own, emitters[facet.surface])?;
    }
    if parts.faces.values.iter().any(|v| matches!(v.condition, Some(ThermalCondition::Power(_)))) {
        check_power_has_faces(parts)?;
    }
    for (p, condition) in parts.panes.iter().zip(&thermal.panes) {
        check_pane(thermal, p, *condition)?;
    }
    let Some(grid) = &parts.voxel_grid else { return Ok(()) };
    check_medium(thermal, grid)?;
    if is_whole { check_heat_sources(&[(thermal, grid)]) } else { Ok(()) }
}

/// Refuses several bands without fractions of the emission.
fn missing_fractions() -> Result<(), SceneError> {
    invalid(
        "thermal.band_fractions",
        "the scene has several bands, but their fractions of the emission are missing; give band_fractions, weights or a gas",
    )
}

/// Refuses lights and settings that have no meaning for heat.
fn check_options(parts: &SceneParts) -> Result<(), SceneError> {
    if !parts.lights.is_empty() && !parts.bands.has_solar_band() {
        return invalid(
            "light",
            "lights of a thermal scene need a band of sunlight, and these bands have none; use BandSet::with_solar_band",
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
    Ok(())
}

/// For each surface, whether it is an emitter of direct light.
fn direct_emitters(parts: &SceneParts) -> Vec<bool> {
    let mut out = vec![false; parts.surfaces.len()];
    for surface in parts.lights.iter().filter_map(Light::surface) {
        out[surface] = true;
    }
    out
}

/// Refuses emission that is neither that of an emitter nor in a band of sunlight, in which no temperature emits.
fn check_emission(thermal: &Thermal, s: &Surface, is_emitter: bool) -> Result<(), SceneError> {
    let emits = thermal.band_fractions.emitting_bands();
    let is_light = is_emitter && !Band::all().any(|b| s.emission[b] != 0.0 && emits[b]);
    if s.emission != Bands::ZERO && !is_light {
        return invalid(
            format!("surface '{}'.emission", s.name),
            "in thermal mode only emitters emit light; name the surface in a [[light]] of kind \"emitter\" (builder: as_direct_light), or give a temperature and an emissivity",
        );
    }
    Ok(())
}

/// Validates that every cell has band fractions.
fn check_cell_fractions(thermal: &Thermal, parts: &SceneParts) -> Result<(), SceneError> {
    let Some(own) = &thermal.cell_fractions else { return Ok(()) };
    let cells = parts.voxel_grid.as_ref().map_or(0, VoxelGrid::len);
    let is_known = own.kind_of_cell.iter().all(|k| (*k as usize) < own.kinds.len());
    if cells != own.kind_of_cell.len() || !is_known || own.kinds.iter().any(BandFractions::is_grey) {
        return invalid(
            "thermal.band_fractions",
            "give every cell of the medium one of the kinds of band fractions",
        );
    }
    Ok(())
}

/// Refuses a power of a face on a facet without one.
fn check_power_has_faces(parts: &SceneParts) -> Result<(), SceneError> {
    let faces = &parts.faces;
    let lacks_face = |k: usize| {
        matches!(faces.values[k].condition, Some(ThermalCondition::Power(_))) && faces.face_of(k).is_none()
    };
    if (0..faces.values.len()).any(lacks_face) {
        invalid("mesh", "a facet without a face has the power of a face; give a heat flux")
    } else {
        Ok(())
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
    emitting: Option<PerBand<bool>>,
) -> Result<(), SceneError> {
    let key = |k: &str| format!("surface '{}'.{k}", s.name);
    condition.check(key)?;
    check_grey(thermal, key("emissivity"), s.reflectance)?;
    if s.emission_texture.is_some() || s.reflectance_texture.is_some() {
        return invalid(
            key("texture"),
            "pictures belong to mode = \"light\"; give a temperature and an emissivity",
        );
    }
    let Some(emitting) = emitting.filter(|_| condition.prescribed_power() != 0.0) else { return Ok(()) };
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

fn check_medium(thermal: &Thermal, grid: &VoxelGrid) -> Result<(), SceneError> {
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
    }
    Ok(())
}

/// Refuses heat of cells that absorb in no band, or in none that has a fraction of the emission. `blocks` are the blocks of bands.
pub(crate) fn check_heat_sources(blocks: &[(&Thermal, &VoxelGrid)]) -> Result<(), SceneError> {
    let Some((_, grid)) = blocks.first() else { return Ok(()) };
    // The bands that emit, by kind of cell.
    let kinds = |t: &Thermal| t.all_fractions().map(BandFractions::emitting_bands).collect::<Vec<_>>();
    let emitting: Vec<_> = blocks.iter().map(|(t, _)| kinds(t)).collect();
    for i in grid.distinct_cells().filter(|&i| grid.heat(i).is_some_and(|h| h.prescribed_power() != 0.0)) {
        let absorption = |g: &VoxelGrid| g.extinction(i) * (1.0 - g.albedo(i));
        let [x, y, z] = grid.coordinates(i);
        if blocks.iter().all(|(_, g)| absorption(g) == Bands::ZERO) {
            let message = "heat needs a medium that absorbs to come from; raise the extinction, lower the albedo, or give 0";
            return invalid("medium.heat_source", format!("in cell ({x}, {y}, {z}) {message}"));
        }
        let gives = |((t, g), emitting): (&(&Thermal, &VoxelGrid), &Vec<PerBand<bool>>)| {
            let kind = t.cell_fractions.as_ref().map_or(0, |f| f.kind_of_cell[i] as usize + 1);
            Band::all().any(|b| emitting[kind][b] && absorption(g)[b] > 0.0)
        };
        if !blocks.iter().zip(&emitting).any(gives) {
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
