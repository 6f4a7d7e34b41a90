//! Energy balance of a light group: emitted + incoming = absorbed by surfaces, volumes and panes + escaped + absorbed by black backs.
//!
//! The escaped power is the sum of the strengths times the factors of the surroundings, plus the unscattered direct light; it is not a difference.
//! The residual of the balance is relative to emitted + incoming. The balance of a solution is the sum over its light groups.

use crate::direct_light::light_field::DirectLight;
use crate::iteration::multivector;
use crate::light_groups::SourceGroup;
use crate::surroundings::SurroundingsExchange;
use zonal_exchange::pair::scaled_radiosity_coefficient;
use zonal_scene::{Bands, EnergyBalance, LightGroupKind, Scene, Zones};

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
    zones: &Zones,
    source: &SourceGroup,
    fields: &GroupFields,
    surroundings: &SurroundingsExchange,
    direct: &DirectLight,
) -> EnergyBalance {
    let mut e = EnergyBalance {
        absorbed_surfaces: scene.surfaces().iter().map(|s| (s.name.clone(), [0.0; 3])).collect(),
        ..EnergyBalance::default()
    };
    for (_, light) in direct.lights.iter().enumerate().filter(|(l, _)| source.has_light(*l)) {
        for b in 0..3 {
            e.emitted[b] += light.emitted[b];
            e.incoming[b] += light.incoming[b];
            e.escaped[b] += light.escaped[b];
            e.absorbed_backfaces[b] += light.absorbed_backfaces[b];
        }
    }
    add_zones(&mut e, zones, source.kind, fields.incident, fields.direct);
    let sky = source.sky(scene);
    if !surroundings.is_closed() {
        let lost: [f64; 9] = multivector::sum(fields.strengths.len(), |i| {
            let (to_sky, to_backs) = (surroundings.sky_of(i), surroundings.backfaces_of(i));
            // The incoming radiation is uniform: higher-order unknowns have no part in it.
            let c = if i < zones.len() { scaled_radiosity_coefficient(zones, i) } else { [0.0; 3] };
            std::array::from_fn(|n| {
                let (b, s) = (n % 3, fields.strengths[i][n % 3]);
                [to_sky[b] * s, to_backs[b] * s, to_sky[b] * c[b] * sky[b]][n / 3]
            })
        });
        for b in 0..3 {
            e.escaped[b] += lost[b];
            e.absorbed_backfaces[b] += lost[3 + b];
            e.incoming[b] += lost[6 + b];
        }
    }
    e.balance();
    e
}

/// The energy balance of all light for zones with other emission and absorption, from the incident field (W/m²). The powers exchanged with the
/// surroundings are those of `old`.
pub(crate) fn balance_zones(
    scene: &Scene,
    zones: &Zones,
    incident: &[Bands],
    old: &EnergyBalance,
) -> EnergyBalance {
    let mut e = EnergyBalance {
        incoming: old.incoming,
        escaped: old.escaped,
        absorbed_backfaces: old.absorbed_backfaces,
        absorbed_surfaces: scene.surfaces().iter().map(|s| (s.name.clone(), [0.0; 3])).collect(),
        ..EnergyBalance::default()
    };
    add_zones(&mut e, zones, LightGroupKind::All, incident, &[]);
    e.balance();
    e
}

/// Adds the powers that zones of a group emit and absorb.
fn add_zones(
    e: &mut EnergyBalance,
    zones: &Zones,
    kind: LightGroupKind,
    incident: &[Bands],
    direct: &[Bands],
) {
    let total = |i: usize, b: usize| incident[i][b] + direct.get(i).map_or(0.0, |d| d[b]);
    let emits = |i: usize| if kind.emits(zones, i) { 1.0 } else { 0.0 };
    for (i, p) in zones.patches.iter().enumerate() {
        for b in 0..3 {
            e.emitted[b] += emits(i) * p.emission[b] * p.area;
            e.absorbed_surfaces[p.surface].1[b] += (1.0 - p.reflectance[b]) * total(i, b) * p.area;
        }
    }
    let volumes: [f64; 6] = multivector::sum(zones.voxels.len(), |k| {
        let (i, v) = (zones.voxel_offset() + k, &zones.voxels[k]);
        std::array::from_fn(|n| {
            let b = n % 3;
            let absorption = v.extinction[b] * (1.0 - v.albedo[b]);
            let emitted = emits(i) * (4.0 * absorption * v.emission[b] + v.source[b]);
            v.volume * if n < 3 { emitted } else { absorption * total(i, b) }
        })
    });
    for b in 0..3 {
        e.emitted[b] += volumes[b];
        e.absorbed_volumes[b] += volumes[3 + b];
    }
    for (k, p) in zones.panes.iter().enumerate() {
        let i = zones.pane_offset() + k;
        let volume = p.area * p.thickness;
        for b in 0..3 {
            let absorption = p.extinction[b] * (1.0 - p.albedo[b]);
            e.emitted[b] += emits(i) * 4.0 * absorption * p.emission[b] * volume;
            e.absorbed_panes[b] += absorption * total(i, b) * volume;
        }
    }
}
