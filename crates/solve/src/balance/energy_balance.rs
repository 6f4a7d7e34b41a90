//! Energy balance of a light group: emitted + incoming = absorbed by surfaces, volumes and panes + escaped + absorbed by black backs.
//!
//! The escaped power is the sum of the strengths times the factors of the surroundings, plus the unscattered direct light; it is not a difference.
//! The residual of the balance is relative to emitted + incoming. The balance of a solution is the sum over its light groups.

use crate::distribution::sum_order::SharedZones;
use crate::right_hand_side::direct_light::light_field::DirectLight;
use crate::right_hand_side::light_groups::SourceGroup;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use zonal_exchange::pair::scaled_radiosity_coefficient;
use zonal_scene::{Bands, EnergyBalance, LightGroupKind, Scene};

/// Fields and strengths of one light group.
pub(crate) struct GroupFields<'a> {
    /// H and G without direct light, W/m².
    pub incident: &'a [Bands],
    /// H_dir and G_dir, W/m²; empty for none.
    pub direct: &'a [Bands],
    /// Strengths c B of all unknowns. The higher-order ones contribute to the escaping power.
    pub strengths: &'a [Bands],
}

/// The energy balance of a light group.
pub(crate) fn balance_group(
    scene: &Scene,
    zones: SharedZones,
    source: &SourceGroup,
    fields: &GroupFields,
    surroundings: &SurroundingsExchange,
    direct: &DirectLight,
) -> EnergyBalance {
    let mut e = EnergyBalance::of_surfaces(scene.surfaces());
    for (_, light) in direct.lights.iter().enumerate().filter(|(l, _)| source.has_light(*l)) {
        e.emitted += light.emitted;
        e.incoming += light.incoming;
        e.escaped += light.escaped;
        e.absorbed_backfaces += light.absorbed_backfaces;
    }
    add_zones(&mut e, zones, source.kind, fields.incident, fields.direct);
    let sky = source.sky(scene);
    if !surroundings.is_closed() {
        let [escaped, on_backs, incoming]: [Bands; 3] = zones.order().sum(fields.strengths.len(), |i| {
            let (to_sky, to_backs) = (surroundings.sky_of(i), surroundings.backfaces_of(i));
            // The incoming radiation is uniform: higher-order unknowns have no part in it.
            let c = if i < zones.len() { scaled_radiosity_coefficient(&zones, i) } else { Bands::ZERO };
            let s = fields.strengths[i];
            [to_sky * s, to_backs * s, to_sky * c * sky]
        });
        e.escaped += escaped;
        e.absorbed_backfaces += on_backs;
        e.incoming += incoming;
    }
    e.balance();
    e
}

/// The energy balance of all light for zones with other emission and absorption, from the incident and the direct field (W/m²). The powers exchanged with the
/// surroundings are those of `old`; `emitters` is the power of emitters, W per band.
pub(crate) fn balance_zones(
    scene: &Scene,
    zones: SharedZones,
    [incident, direct]: [&[Bands]; 2],
    old: &EnergyBalance,
    emitters: Bands,
) -> EnergyBalance {
    let mut e = EnergyBalance {
        emitted: emitters,
        incoming: old.incoming,
        escaped: old.escaped,
        absorbed_backfaces: old.absorbed_backfaces,
        ..EnergyBalance::of_surfaces(scene.surfaces())
    };
    add_zones(&mut e, zones, LightGroupKind::All, incident, direct);
    e.balance();
    e
}

/// Adds the powers that zones of a group emit and absorb.
fn add_zones(
    e: &mut EnergyBalance,
    zones: SharedZones,
    kind: LightGroupKind,
    incident: &[Bands],
    direct: &[Bands],
) {
    let total = |i: usize| incident[i] + direct.get(i).copied().unwrap_or_default();
    let emits = |i: usize| if kind.emits(&zones, i) { 1.0 } else { 0.0 };
    for (i, p) in zones.patches.iter().enumerate() {
        e.emitted += emits(i) * p.emission * p.area;
        e.absorbed_surfaces[p.surface].1 +=
            (1.0 - p.reflectance - zones.sheets.transmittance(i)) * total(i) * p.area;
    }
    let [emitted, absorbed]: [Bands; 2] = zones.sum_voxels(|k| {
        let (i, v) = (zones.voxel_index(k), zones.voxels.at(k));
        let absorption = v.extinction * (1.0 - v.albedo);
        let emitted = emits(i) * (4.0 * absorption * v.emission + v.source);
        [v.volume * emitted, v.volume * (absorption * total(i))]
    });
    e.emitted += emitted;
    e.absorbed_volumes += absorbed;
    for (k, p) in zones.panes.iter().enumerate() {
        let i = zones.pane_index(k);
        let volume = p.area * p.thickness;
        let absorption = p.extinction * (1.0 - p.albedo);
        e.emitted += emits(i) * 4.0 * absorption * p.emission * volume;
        e.absorbed_panes += absorption * total(i) * volume;
    }
}
