//! Thermal boundary conditions as emission and sources of the zones (header of [`super`]).

use super::zone_balance::ZoneBalances;
use crate::surroundings::SurroundingsExchange;
use zonal_scene::{Bands, Scene, SceneError, ThermalCondition, Zones};

/// Sets the emission of zones with known temperature, and turns zones with known power into white zones with a source. No effect in light mode.
pub fn apply_boundary_conditions(scene: &Scene, zones: &mut Zones) {
    if scene.thermal().is_none() {
        return;
    }
    let balances = ZoneBalances::new(scene, zones);
    let all: Vec<(ThermalCondition, Bands)> = (0..zones.len()).map(|i| balances.source(zones, i)).collect();
    let mut list = all.into_iter();
    for (p, (condition, own)) in zones.patches.iter_mut().zip(&mut list) {
        p.emission = own;
        if !matches!(condition, ThermalCondition::Temperature(_)) {
            p.reflectance = Bands::ONE;
        }
    }
    for (v, (condition, own)) in zones.voxels.iter_mut().zip(&mut list) {
        match condition {
            ThermalCondition::Temperature(_) => v.emission = own,
            _ => (v.albedo, v.emission, v.source) = (Bands::ONE, Bands::ZERO, own),
        }
    }
    for (p, (condition, own)) in zones.panes.iter_mut().zip(&mut list) {
        match condition {
            ThermalCondition::Temperature(_) => p.emission = own,
            _ => (p.albedo, p.emission) = (Bands::ONE, Bands::ZERO),
        }
    }
}

/// Gives zones the optical properties of the scene and the emission of the emissive powers w(E) of all zones.
pub(super) fn set_emissive_powers(scene: &Scene, zones: &mut Zones, emissive: &[Bands]) {
    let balances = ZoneBalances::new(scene, zones);
    let own: Vec<_> = (0..zones.len()).map(|i| balances.of(zones, i)).collect();
    let (voxels, panes) = (zones.voxel_offset(), zones.pane_offset());
    for (i, p) in zones.patches.iter_mut().enumerate() {
        p.reflectance = own[i].reflect;
        p.emission = (own[i].absorb * emissive[i]).map(|w| w.max(0.0));
    }
    for (k, v) in zones.voxels.iter_mut().enumerate() {
        let i = voxels + k;
        (v.albedo, v.source) = (own[i].reflect, Bands::ZERO);
        v.emission = emissive[i].map(|w| w.max(0.0));
    }
    for (k, p) in zones.panes.iter_mut().enumerate() {
        let i = panes + k;
        (p.albedo, p.emission) = (own[i].reflect, emissive[i].map(|w| w.max(0.0)));
    }
}

/// Refuses a closed scene in which no absorbing zone has a known temperature, so that the level of the temperatures is undetermined.
pub(crate) fn check_temperature_level(
    scene: &Scene,
    zones: &Zones,
    surroundings: &SurroundingsExchange,
) -> Result<(), SceneError> {
    if scene.thermal().is_none() || !surroundings.is_closed() {
        return Ok(());
    }
    let balances = ZoneBalances::new(scene, zones);
    let fixes = |i: usize| {
        let l = balances.of(zones, i);
        matches!(l.condition, ThermalCondition::Temperature(_)) && (l.weight * l.absorb).any(|m| m > 0.0)
    };
    if (0..zones.len()).any(fixes) {
        return Ok(());
    }
    Err(SceneError::new(
        "mode",
        "the level of the temperatures is undetermined: the scene is closed and nothing that absorbs has a known temperature; give some surface or medium a temperature",
    ))
}
