//! Coefficients of a zone in the zonal equations (Hottel and Sarofim 1967): closure sums, and the scale of its radiosity.

use zonal_scene::{Bands, Zones};

/// The sum Σ_j g_ij c_j of a closed enclosure, per unit of c_i: A of a patch in m², 4V of a voxel in m³, 4At of a pane in m³.
pub fn closure_target(zones: &Zones, i: usize) -> f64 {
    if i < zones.voxel_offset() {
        zones.patches[i].area
    } else if i < zones.pane_offset() {
        4.0 * zones.voxels.at(i - zones.voxel_offset()).volume
    } else {
        let p = &zones.panes[i - zones.pane_offset()];
        4.0 * p.area * p.thickness
    }
}

/// c_i in the scaled radiosity c_i B_i: 1 of a patch, κ in 1/m of a volume zone.
pub fn scaled_radiosity_coefficient(zones: &Zones, i: usize) -> Bands {
    if i < zones.voxel_offset() {
        Bands::ONE
    } else if i < zones.pane_offset() {
        zones.voxels.at(i - zones.voxel_offset()).extinction
    } else {
        zones.panes[i - zones.pane_offset()].extinction
    }
}
