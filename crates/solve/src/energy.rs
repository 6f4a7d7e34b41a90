//! The energy balance: emitted + incoming = absorbed by surfaces, volumes and panes + escaped + lost on black backs.
//!
//! Escaped power is what the factors of the surroundings' zone, measured by rays, carry away, with the uncollided part of the
//! direct light; it is not a difference. The residual is what remains, relative to emitted + incoming.

use crate::direct::Direct;
use crate::surroundings::Escape;
use std::f64::consts::PI;
use zonal_exchange::pair::strength;
use zonal_scene::solution::Energy;
use zonal_scene::{Bands, Fields, Scene, Zones, bands};

/// Balances a solution. `strengths` are c B of every zone.
pub fn balance(
    scene: &Scene,
    zones: &Zones,
    fields: &Fields,
    strengths: &[Bands],
    escape: &Escape,
    direct: &Direct,
) -> Energy {
    let mut e = Energy {
        absorbed_surfaces: scene.surfaces().iter().map(|s| (s.name.clone(), [0.0; 3])).collect(),
        ..Energy::default()
    };
    for light in &direct.lights {
        for b in 0..3 {
            e.emitted[b] += light.emitted[b];
            e.incoming[b] += light.incoming[b];
            e.escaped[b] += light.escaped[b];
            e.backs[b] += light.backs[b];
        }
    }
    let arriving = |i: usize, b: usize| fields.incident[i][b] + fields.direct[i][b];
    for (i, p) in zones.patches.iter().enumerate() {
        for b in 0..3 {
            e.emitted[b] += p.emission[b] * p.area;
            e.absorbed_surfaces[p.surface].1[b] += (1.0 - p.reflectance[b]) * arriving(i, b) * p.area;
        }
    }
    for (k, v) in zones.voxels.iter().enumerate() {
        let i = zones.voxel_offset() + k;
        for b in 0..3 {
            let absorption = v.extinction[b] * (1.0 - v.albedo[b]);
            e.emitted[b] += (4.0 * absorption * v.emission[b] + v.source[b]) * v.volume;
            e.absorbed_volumes[b] += absorption * arriving(i, b) * v.volume;
        }
    }
    for (k, p) in zones.panes.iter().enumerate() {
        let i = zones.pane_offset() + k;
        let volume = p.area * p.thickness;
        for b in 0..3 {
            let absorption = p.extinction[b] * (1.0 - p.albedo[b]);
            e.emitted[b] += 4.0 * absorption * p.emission[b] * volume;
            e.absorbed_panes[b] += absorption * arriving(i, b) * volume;
        }
    }
    let sky = scene.surroundings().radiance.map(|l| PI * l);
    for i in 0..zones.len() {
        let c = strength(zones, i);
        for b in 0..3 {
            e.escaped[b] += escape.sky[i][b] * strengths[i][b];
            e.backs[b] += escape.backs[i][b] * strengths[i][b];
            e.incoming[b] += escape.sky[i][b] * c[b] * sky[b];
        }
    }
    e.residual = bands(|b| {
        let given = e.emitted[b] + e.incoming[b];
        let surfaces: f64 = e.absorbed_surfaces.iter().map(|s| s.1[b]).sum();
        let taken = surfaces + e.absorbed_volumes[b] + e.absorbed_panes[b] + e.escaped[b] + e.backs[b];
        if given > 0.0 { (given - taken) / given } else { 0.0 }
    });
    e
}
