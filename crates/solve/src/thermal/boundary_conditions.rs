//! Thermal boundary conditions as emission and sources of the zones (header of [`super`]).

use super::nodes::fixes_level;
use super::spectral_balance::{SpectralBalances, TripleZones};
use super::zone_balance::ZoneBalances;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use zonal_scene::{Bands, Scene, SceneError, ThermalCondition, Zones};

/// Sets the emission of zones with known temperature, and turns zones with known power into white zones with a source. `zones` are those of every
/// triple of bands of the scene. No effect in light mode.
pub fn apply_boundary_conditions(scene: &Scene, zones: &mut [Zones]) {
    if scene.thermal().is_none() {
        return;
    }
    let triples: Vec<TripleZones> =
        scene.triples().zip(&*zones).map(|(scene, zones)| TripleZones { scene, zones }).collect();
    let balances = SpectralBalances::new(&triples);
    let patches = triples[0].zones.voxel_offset();
    let of_triple = |t: usize| -> Vec<(ThermalCondition, Bands)> {
        let of_zone = |i: usize| (balances.first(i).condition, balances.source(t, i, i < patches));
        (0..balances.len()).map(of_zone).collect()
    };
    let all: Vec<_> = (0..triples.len()).map(of_triple).collect();
    zones.iter_mut().zip(all).for_each(|(zones, sources)| set_sources(zones, &sources));
}

/// Sets emission and sources of zones, each with its thermal condition.
fn set_sources(zones: &mut Zones, sources: &[(ThermalCondition, Bands)]) {
    let (of_patches, others) = sources.split_at(zones.voxel_offset());
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
    let (voxels, panes) = (zones.voxel_offset(), zones.pane_offset());
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

/// Refuses a closed scene in which no absorbing zone has a known temperature, so that the level of the temperatures is undetermined. `triples` are
/// those of its bands, each with its surroundings.
pub(crate) fn check_temperature_level(
    triples: &[TripleZones],
    surroundings: &[SurroundingsExchange],
) -> Result<(), SceneError> {
    if triples[0].scene.thermal().is_none() || !surroundings.iter().all(SurroundingsExchange::is_closed) {
        return Ok(());
    }
    let fixes = |t: &TripleZones| {
        let balances = ZoneBalances::new(t.scene, t.zones);
        (0..t.zones.len()).any(|i| {
            let l = balances.of(t.zones, i);
            matches!(l.condition, ThermalCondition::Temperature(_)) && l.absorption_weight().any(|m| m > 0.0)
        })
    };
    let network = triples[0].scene.thermal().and_then(|t| t.network.as_ref());
    if triples.iter().any(fixes) || network.is_some_and(fixes_level) {
        return Ok(());
    }
    Err(SceneError::new(
        "mode",
        "the level of the temperatures is undetermined: the scene is closed and nothing that absorbs has a known temperature; give some surface or medium a temperature",
    ))
}
