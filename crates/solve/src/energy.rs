//! The energy balance: emitted + incoming = absorbed by surfaces, volumes and panes + escaped + lost on black backs.
//!
//! Escaped power is what the factors of the surroundings' zone, measured by rays, carry away, with the uncollided part of the
//! direct light; it is not a difference. The residual is what remains, relative to emitted + incoming. Every light group has a balance
//! of its own; that of the whole is their sum.

use crate::columns;
use crate::direct::Direct;
use crate::groups::Source;
use crate::surroundings::Escape;
use zonal_exchange::pair::strength;
use zonal_scene::solution::Energy;
use zonal_scene::{Bands, Kind, Scene, Zones, bands};

/// What arrives because of one group, without and with its direct light, and what leaves.
pub struct Found<'a> {
    /// H and G without direct light, W/m².
    pub incident: &'a [Bands],
    /// H_dir and G_dir, W/m²; empty for none.
    pub direct: &'a [Bands],
    /// c B of every zone, and behind them of their slopes, if they have any: with these more or less escapes than by the means.
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
    add_zones(&mut e, zones, source.kind, found.incident, found.direct);
    let sky = source.sky(scene);
    if !escape.closed() {
        let away: [f64; 9] = columns::sum(found.strengths.len(), |i| {
            let (to_sky, to_backs) = (escape.sky_of(i), escape.backs_of(i));
            // What comes in is even: slopes have no part in it.
            let c = if i < zones.len() { strength(zones, i) } else { [0.0; 3] };
            std::array::from_fn(|n| {
                let (b, s) = (n % 3, found.strengths[i][n % 3]);
                [to_sky[b] * s, to_backs[b] * s, to_sky[b] * c[b] * sky[b]][n / 3]
            })
        });
        for b in 0..3 {
            e.escaped[b] += away[b];
            e.backs[b] += away[3 + b];
            e.incoming[b] += away[6 + b];
        }
    }
    e.balance();
    e
}

/// The balance of all light together on zones that emit and absorb otherwise, from what arrives (W/m²); what came in and went from the
/// scene stays as in `old`.
pub fn of_zones(scene: &Scene, zones: &Zones, incident: &[Bands], old: &Energy) -> Energy {
    let mut e = Energy {
        incoming: old.incoming,
        escaped: old.escaped,
        backs: old.backs,
        absorbed_surfaces: scene.surfaces().iter().map(|s| (s.name.clone(), [0.0; 3])).collect(),
        ..Energy::default()
    };
    add_zones(&mut e, zones, Kind::All, incident, &[]);
    e.balance();
    e
}

/// Power that zone `i` meets of one W/m² that arrives, m² a band: the area of a patch, κV of a volume zone.
pub(crate) fn section(zones: &Zones, i: usize) -> Bands {
    let measure = zones.response(i).1;
    strength(zones, i).map(|c| c * measure)
}

/// Power that it absorbs of that, m² a band: (1 − ρ) A of a patch, κ (1 − Ω) V of a volume zone.
pub(crate) fn uptake(zones: &Zones, i: usize) -> Bands {
    let (met, back) = (section(zones, i), sent_back(zones, i));
    bands(|b| (1.0 - back[b]) * met[b])
}

/// The share that it reflects or scatters of that: ρ of a patch, Ω of a volume zone, whose response is Ω/4.
pub(crate) fn sent_back(zones: &Zones, i: usize) -> Bands {
    let parts = if i < zones.voxel_offset() { 1.0 } else { 4.0 };
    zones.response(i).0.map(|r| parts * r)
}

/// Power that all zones absorb of a field (W/m²), W a band.
pub(crate) fn absorbed(zones: &Zones, field: impl Fn(usize) -> Bands + Sync) -> Bands {
    columns::sum(zones.len(), |i| {
        let (a, h) = (uptake(zones, i), field(i));
        // A zone that absorbs nothing has no part in it, whatever its field.
        bands(|b| if a[b] == 0.0 { 0.0 } else { a[b] * h[b] })
    })
}

/// Adds what zones of a group emit and what they absorb.
fn add_zones(e: &mut Energy, zones: &Zones, kind: Kind, incident: &[Bands], direct: &[Bands]) {
    let arriving = |i: usize, b: usize| incident[i][b] + direct.get(i).map_or(0.0, |d| d[b]);
    let own = |i: usize| if kind.emits(zones, i) { 1.0 } else { 0.0 };
    for (i, p) in zones.patches.iter().enumerate() {
        for b in 0..3 {
            e.emitted[b] += own(i) * p.emission[b] * p.area;
            e.absorbed_surfaces[p.surface].1[b] += (1.0 - p.reflectance[b]) * arriving(i, b) * p.area;
        }
    }
    let volumes: [f64; 6] = columns::sum(zones.voxels.len(), |k| {
        let (i, v) = (zones.voxel_offset() + k, &zones.voxels[k]);
        std::array::from_fn(|n| {
            let b = n % 3;
            let absorption = v.extinction[b] * (1.0 - v.albedo[b]);
            let shining = own(i) * (4.0 * absorption * v.emission[b] + v.source[b]);
            v.volume * if n < 3 { shining } else { absorption * arriving(i, b) }
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
            e.emitted[b] += own(i) * 4.0 * absorption * p.emission[b] * volume;
            e.absorbed_panes[b] += absorption * arriving(i, b) * volume;
        }
    }
}
