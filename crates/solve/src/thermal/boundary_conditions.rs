//! Thermal boundary conditions as emission and sources of the zones (header of [`super`]).

use super::nodes::fixes_level;
use super::spectral_balance::{BlockZones, SpectralBalances};
use super::zone_balance::ZoneBalances;
use crate::context::BlockEngine;
use zonal_scene::{Bands, Scene, SceneError, ThermalCondition, Zones};

/// Sets the emission of zones with known temperature, and turns zones with known power into white zones with a source. `scenes` are the blocks of bands of
/// a scene, each with its zones. No effect in light mode.
pub fn apply_boundary_conditions(scenes: &[Scene], zones: &mut [Zones]) {
    if scenes[0].thermal().is_none() {
        return;
    }
    let blocks: Vec<BlockZones> =
        scenes.iter().zip(&*zones).map(|(scene, zones)| BlockZones { scene, zones }).collect();
    let balances = SpectralBalances::new(&blocks);
    let patches = blocks[0].zones.patches.len();
    let of_block = |t: usize| -> Vec<(ThermalCondition, Bands)> {
        let of_zone = |i: usize| (balances.first(i).condition, balances.source(t, i, i < patches));
        (0..balances.len()).map(of_zone).collect()
    };
    let all: Vec<_> = (0..blocks.len()).map(of_block).collect();
    zones.iter_mut().zip(all).for_each(|(zones, sources)| set_sources(zones, &sources));
}

/// Sets emission and sources of zones, each with its thermal condition.
fn set_sources(zones: &mut Zones, sources: &[(ThermalCondition, Bands)]) {
    let (of_patches, others) = sources.split_at(zones.patches.len());
    let (of_voxels, of_panes) = others.split_at(zones.voxels.len());
    for (p, (condition, own)) in zones.patches.iter_mut().zip(of_patches) {
        p.emission = *own;
        if !matches!(condition, ThermalCondition::Temperature(_)) {
            p.reflectance = Bands::ONE;
        }
    }
    let is_known = |k: usize| matches!(of_voxels[k].0, ThermalCondition::Temperature(_));
    zones.voxels.update_albedo(|k, old| if is_known(k) { old } else { Bands::ONE });
    zones.voxels.update_emission(|k, _| if is_known(k) { of_voxels[k].1 } else { Bands::ZERO });
    zones.voxels.update_source(|k, old| if is_known(k) { old } else { of_voxels[k].1 });
    for (p, (condition, own)) in zones.panes.iter_mut().zip(of_panes) {
        match condition {
            ThermalCondition::Temperature(_) => p.emission = *own,
            _ => (p.albedo, p.emission) = (Bands::ONE, Bands::ZERO),
        }
    }
}

/// Gives zones the optical properties of the scene and the emission of the emissive powers w(E) of all zones.
pub(super) fn set_emissive_powers(scene: &Scene, zones: &mut Zones, emissive: &[Bands]) {
    let balances = ZoneBalances::new(scene, zones);
    let own: Vec<_> = (0..zones.len()).map(|i| balances.of(zones, i)).collect();
    let [_, voxels, panes] = zones.ranges_of_kinds().map(|zones| zones.start);
    for (i, p) in zones.patches.iter_mut().enumerate() {
        p.reflectance = own[i].reflect;
        p.emission = (own[i].absorb * emissive[i]).map(|w| w.max(0.0));
    }
    zones.voxels.update_albedo(|k, _| own[voxels + k].reflect);
    zones.voxels.update_emission(|k, _| emissive[voxels + k].map(|w| w.max(0.0)));
    zones.voxels.update_source(|_, _| Bands::ZERO);
    for (k, p) in zones.panes.iter_mut().enumerate() {
        let i = panes + k;
        (p.albedo, p.emission) = (own[i].reflect, emissive[i].map(|w| w.max(0.0)));
    }
}

/// Refuses a closed scene in which no absorbing zone has a known temperature, so that the level of the temperatures is undetermined. `blocks` are
/// those of its bands, each with its surroundings.
pub(crate) fn check_temperature_level(blocks: &[BlockEngine]) -> Result<(), SceneError> {
    let first = blocks[0].context.scene;
    if first.thermal().is_none() || !blocks.iter().all(|b| b.surroundings.is_closed()) {
        return Ok(());
    }
    let fixes = |t: &BlockEngine| {
        let zones = t.context.zones;
        let balances = ZoneBalances::new(t.context.scene, zones);
        (0..zones.len()).any(|i| {
            let l = balances.of(zones, i);
            matches!(l.condition, ThermalCondition::Temperature(_)) && l.absorption_weight().any(|m| m > 0.0)
        })
    };
    let network = first.thermal().and_then(|t| t.network.as_ref());
    if blocks.iter().any(fixes) || network.is_some_and(fixes_level) {
        return Ok(());
    }
    Err(SceneError::new(
        "mode",
        "the level of the temperatures is undetermined: the scene is closed and nothing that absorbs has a known temperature; give some surface or medium a temperature",
    ))
}
