//! Radiosity of one light group.

use zonal_scene::{Bands, LightGroup, Solution};

/// B of one light group at a zone, W/m², direct light included.
pub(super) fn group_radiosity(s: &Solution, g: &LightGroup, zone: usize) -> Bands {
    let arrives = |i: usize| g.incident_at(i) + g.direct_at(i);
    let e = if g.kind.emits(&s.zones, zone) { s.zones.emission(zone) } else { Bands::ZERO };
    e + s.zones.scattered(zone, arrives)
}
