//! Radiosity of one light group.

use zonal_scene::{Bands, LightGroup, Solution, bands};

/// B of one light group at a zone, W/m², direct light included.
pub(super) fn group_radiosity(s: &Solution, g: &LightGroup, zone: usize) -> Bands {
    let (h, d, (rho, _)) = (g.incident.at(zone), g.direct.at(zone), s.zones.response(zone));
    let e = if g.kind.emits(&s.zones, zone) { s.zones.emission(zone) } else { [0.0; 3] };
    bands(|b| e[b] + rho[b] * (h[b] * g.incident_scale[b] + d[b] * g.direct_scale[b]))
}
