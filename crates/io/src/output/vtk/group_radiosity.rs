//! Radiosity of one light group.

use zonal_scene::{Bands, LightGroup, Solution};

/// B of one light group at a zone, W/m², direct light included.
pub(super) fn group_radiosity(s: &Solution, g: &LightGroup, zone: usize) -> Bands {
    let (h, d, (rho, _)) = (g.incident.at(zone), g.direct.at(zone), s.zones.response(zone));
    let e = if g.kind.emits(&s.zones, zone) { s.zones.emission(zone) } else { Bands::ZERO };
    e + rho * (h * g.incident_scale + d * g.direct_scale)
}
