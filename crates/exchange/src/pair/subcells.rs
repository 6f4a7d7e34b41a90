//! Sub-cells of a voxel, and their factors by offset.

use crate::aligned::{Cuboid, FactorCache};
use zonal_math::{Vec3, vec3};
use zonal_scene::SUBCELLS;
use zonal_scene::VolumeSample;

/// Number of offsets along an axis between sub-cells of two touching cells.
pub(super) const SUBCELL_OFFSETS: usize = 2 * SUBCELLS;

/// The samples of a whole cell, at the centres of its sub-cells, relative to its corner.
pub(super) fn whole_samples(cell: Vec3) -> Vec<VolumeSample> {
    let n = SUBCELLS;
    let volume = cell.product() / (n * n * n) as f64;
    (0..n * n * n)
        .map(|k| {
            let c = [k / (n * n), k / n % n, k % n].map(|c| (c as f64 + 0.5) / n as f64);
            VolumeSample { point: cell.scale(Vec3::from_array(c)), volume, subcell: k as u8 }
        })
        .collect()
}

/// 𝓕, ⟨r⟩, ⟨r²⟩ and ⟨r³⟩ of two sub-cells by their offset, |offset| < 2·SUBCELLS on each axis.
pub(super) fn subcell_table(cell: Vec3, cache: &FactorCache) -> Vec<[f64; 4]> {
    let n = SUBCELL_OFFSETS;
    let a = Cuboid { lo: Vec3::ZERO, hi: cell, normal: None };
    (0..n * n * n)
        .map(|k| {
            let d = vec3((k / (n * n)) as f64, (k / n % n) as f64, (k % n) as f64);
            let lo = cell.scale(d);
            let c = cache.get_cumulants(&a, &Cuboid { lo, hi: lo + cell, normal: None });
            let (m, v) = (c.mean_distance, c.variance);
            [c.factor.value, m, m * m + v, c.third_cumulant + m * (3.0 * v + m * m)]
        })
        .collect()
}
