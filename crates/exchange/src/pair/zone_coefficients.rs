//! Coefficients of a zone in the zonal equations (Hottel and Sarofim 1967): closure sums, and the scale of its radiosity.

use zonal_scene::{Bands, ZoneRef, Zones};

/// The sum Σ_j g_ij c_j of a closed enclosure, per unit of c_i: A of a patch in m², 4V of a voxel in m³, 4At of a pane in m³.
pub fn closure_target(zones: &Zones, i: usize) -> f64 {
    match zones.zone(i) {
        ZoneRef::Patch(p) => p.area,
        ZoneRef::Voxel(_, v) => 4.0 * v.volume,
        ZoneRef::Pane(_, p) => 4.0 * p.area * p.thickness,
    }
}

/// c_i in the scaled radiosity c_i B_i: 1 of a patch, κ in 1/m of a volume zone.
pub fn scaled_radiosity_coefficient(zones: &Zones, i: usize) -> Bands {
    match zones.zone(i) {
        ZoneRef::Patch(_) => Bands::ONE,
        ZoneRef::Voxel(_, v) => v.extinction,
        ZoneRef::Pane(_, p) => p.extinction,
    }
}
