//! The energy balance: emitted + incoming = absorbed by surfaces, volumes and panes + escaped + lost on black backs.
//!
//! Escaped power is what the factors of the surroundings' zone, measured by rays, carry away, with the uncollided part of the
//! direct light; it is not a difference. The residual is what remains, relative to emitted + incoming. Every light group has a balance
//! of its own; that of the whole is their sum.

use crate::direct::Direct;
use crate::groups::Source;
use crate::surroundings::Escape;
use zonal_exchange::pair::strength;
use zonal_scene::solution::Energy;
use zonal_scene::{Bands, Scene, Zones};

/// What arrives because of one group, without and with its direct light, and what leaves.
pub struct Found<'a> {
    /// H and G without direct light, W/m².
    pub incident: &'a [Bands],
    /// H_dir and G_dir, W/m²; empty for none.
    pub direct: &'a [Bands],
    /// c B of every zone.
    pub strengths: &'a [Bands],
}

/// Balances what a group gives.
pub fn balance(
    scene: &Scene,
    zones: &Zones,
    source: &Source,
    found: &Found,
    escape: &Escape,
    direct: &Direct,
) -> Energy {
    let mut e = Energy {
        absorbed_surfaces: scene.surfaces().iter().map(|s| (s.name.clone(), [0.0; 3])).collect(),
        ..Energy::default()
    };
    for (_, light) in direct.lights.iter().enumerate().filter(|(l, _)| source.has_light(*l)) {
        for b in 0..3 {
            e.emitted[b] += light.emitted[b];
            e.incoming[b] += light.incoming[b];
            e.escaped[b] += light.escaped[b];
            e.backs[b] += light.backs[b];
        }
    }
    let arriving = |i: usize, b: usize| found.incident[i][b] + found.direct.get(i).map_or(0.0, |d| d[b]);
    let own = |i: usize| if source.emits(zones, i) { 1.0 } else { 0.0 };
    for (i, p) in zones.patches.iter().enumerate() {
        for b in 0..3 {
            e.emitted[b] += own(i) * p.emission[b] * p.area;
            e.absorbed_surfaces[p.surface].1[b] += (1.0 - p.reflectance[b]) * arriving(i, b) * p.area;
        }
    }
    for (k, v) in zones.voxels.iter().enumerate() {
        let i = zones.voxel_offset() + k;
        for b in 0..3 {
            let absorption = v.extinction[b] * (1.0 - v.albedo[b]);
            e.emitted[b] += own(i) * (4.0 * absorption * v.emission[b] + v.source[b]) * v.volume;
            e.absorbed_volumes[b] += absorption * arriving(i, b) * v.volume;
        }
    }
    for (k, p) in zones.panes.iter().enumerate() {
        let i = zones.pane_offset() + k;
        let volume = p.area * p.thickness;
        for b in 0..3 {
            let absorption = p.extinction[b] * (1.0 - p.albedo[b]);
            e.emitted[b] += own(i) * 4.0 * absorption * p.emission[b] * volume;
            e.absorbed_panes[b] += absorption * arriving(i, b) * volume;
        }
    }
    let sky = source.sky(scene);
    for i in 0..zones.len() {
        let c = strength(zones, i);
        for b in 0..3 {
            e.escaped[b] += escape.sky[i][b] * found.strengths[i][b];
            e.backs[b] += escape.backs[i][b] * found.strengths[i][b];
            e.incoming[b] += escape.sky[i][b] * c[b] * sky[b];
        }
    }
    e.balance();
    e
}
