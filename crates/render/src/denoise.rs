//! Edge-preserving filter of the patches' irradiance: a cross-bilateral filter whose range width is the estimated error.
//!
//! A solution by rays knows the error e of each value. Differences between neighbouring patches below the noise level appear as blotches
//! on evenly lit surfaces. Each patch i therefore takes the weighted mean of those around it (Tomasi & Manduchi, ICCV 1998; Eisemann &
//! Durand, SIGGRAPH 2004),
//!
//! ```text
//! H_i' = Σ_j w_ij H_j / Σ_j w_ij      w_ij = A_j exp(−d²/2r²) exp(−|H_i − H_j|²/2σ²)      σ² = Σ_{i,j} (s (e − e_min H)₊)²
//! ```
//!
//! over patches within 3r that face nearly the same way or follow round a column; r is a few patches wide, s and e_min are
//! `noise_share_of_estimate` and `min_relative_error`. Differences above the noise (shadows, other rooms) remain, and values with a
//! relative error below e_min are not changed. Cost: the patches within 3r of each patch.

use crate::surface::point_grid::cell_of;
use rayon::prelude::*;
use std::collections::HashMap;
use zonal_math::Vec3;
use zonal_scene::{Bands, Patch};

/// Widths and thresholds of the filter.
struct DenoiseParams {
    /// Share s of the estimated error that counts as noise: estimates are two to five times the error that they bound.
    noise_share_of_estimate: f64,
    /// Relative error e_min below which noise is not visible.
    min_relative_error: f64,
    /// r over the square root of a patch's area.
    filter_radius: f64,
    /// Least cosine between the normals of two patches: neighbouring sides of a round column pass.
    min_normal_cosine: f64,
    /// Largest height of a patch over the plane of the other, over their distance.
    max_plane_distance: f64,
}

const PARAMS: DenoiseParams = DenoiseParams {
    noise_share_of_estimate: 0.7,
    min_relative_error: 0.015,
    filter_radius: 4.0,
    min_normal_cosine: 0.78,
    max_plane_distance: 0.34,
};

/// Distance of the farthest patches of a mean over r, and largest square root of a patch's area over the mean one that widens r.
const REACH: f64 = 3.0;
const MAX_RELATIVE_SIZE: f64 = 2.0;

/// A patch with its value and noise.
struct NoisyPatch {
    /// Centre, m.
    at: Vec3,
    normal: Vec3,
    /// m².
    area: f64,
    /// W/m².
    value: Bands,
    /// W/m², all bands together.
    noise: f64,
}

/// The irradiance of the patches, W/m², filtered by the noise level that `error` implies.
pub(crate) fn denoise_patches(patches: &[Patch], incident: &[Bands], error: &[Bands]) -> Vec<Bands> {
    let excess = |i: usize| (error[i].sum() - PARAMS.min_relative_error * incident[i].sum()).max(0.0);
    let noise: Vec<f64> = (0..patches.len()).map(|i| PARAMS.noise_share_of_estimate * excess(i)).collect();
    if noise.iter().all(|x| *x == 0.0) {
        return incident[..patches.len()].to_vec();
    }
    // Choose the grid by the mean size, so that a few large patches do not occupy many cells.
    let mean = patches.iter().map(|p| p.area.sqrt()).sum::<f64>() / patches.len() as f64;
    let cell = REACH * PARAMS.filter_radius * mean.max(1e-12);
    let noisy = |i: usize| NoisyPatch {
        at: patches[i].plate.centre(),
        normal: patches[i].normal,
        area: patches[i].area,
        value: incident[i],
        noise: noise[i],
    };
    let noisy: Vec<NoisyPatch> = (0..patches.len()).into_par_iter().map(noisy).collect();
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    noisy.iter().enumerate().for_each(|(i, p)| cells.entry(cell_of(p.at, cell)).or_default().push(i as u32));
    let filter = PatchFilter { patches: &noisy, cells, cell, mean };
    noisy.par_iter().map(|own| filter.apply(own)).collect()
}

/// The patches in a hash grid.
struct PatchFilter<'a> {
    patches: &'a [NoisyPatch],
    /// The patches of each cell.
    cells: HashMap<[i64; 3], Vec<u32>>,
    /// Edge of a cell, m.
    cell: f64,
    /// Mean square root of the patches' areas, m.
    mean: f64,
}

impl PatchFilter<'_> {
    /// The filtered value of a patch.
    fn apply(&self, own: &NoisyPatch) -> Bands {
        if own.noise == 0.0 {
            return own.value;
        }
        let r = PARAMS.filter_radius * own.area.sqrt().min(MAX_RELATIVE_SIZE * self.mean);
        let r2 = r * r;
        let (mut total, mut weights) = (Bands::ZERO, 0.0);
        let [low, high] = [-REACH * r, REACH * r].map(|x| cell_of(own.at + Vec3::splat(x), self.cell));
        let range = |k: usize| low[k]..=high[k];
        let around = range(0).flat_map(|x| range(1).flat_map(move |y| range(2).map(move |z| [x, y, z])));
        for at in around {
            for &j in self.cells.get(&at).map_or(&[][..], Vec::as_slice) {
                let other = &self.patches[j as usize];
                let away = other.at - own.at;
                let d2 = away.length2();
                let max_height = PARAMS.max_plane_distance;
                let apart = d2 > REACH * REACH * r2
                    || own.normal.dot(other.normal) < PARAMS.min_normal_cosine
                    || own.normal.dot(away).powi(2) > max_height * max_height * d2;
                if apart {
                    continue;
                }
                let difference = (own.value - other.value).abs().sum();
                let variance = own.noise.powi(2) + other.noise.powi(2);
                let w = other.area * (-0.5 * (d2 / r2 + difference * difference / variance)).exp();
                total += w * other.value;
                weights += w;
            }
        }
        total / weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::{low_discrepancy, vec3};
    use zonal_scene::Plate;

    /// A floor of unit patches, brighter by half beyond x = 16, with noise of 10 %.
    fn floor(relative_error: f64) -> (Vec<Patch>, Vec<Bands>, Vec<Bands>, Vec<f64>) {
        let (mut patches, mut value, mut truth) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..32 * 32u64 {
            let (i, j) = ((k / 32) as f64, (k % 32) as f64);
            let plate = Plate::parallelogram(vec3(i, j, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
            let (normal, zero) = (vec3(0.0, 0.0, 1.0), Bands::ZERO);
            let (facet, surface) = (0, 0);
            patches.push(Patch {
                facet,
                surface,
                plate,
                normal,
                area: 1.0,
                reflectance: zero,
                emission: zero,
            });
            let level = if i < 16.0 { 1.0 } else { 3.0 };
            truth.push(level);
            let noise = 0.1 * 12f64.sqrt() * (low_discrepancy::hash_to_unit(k + 5) - 0.5);
            value.push(Bands::splat(level * (1.0 + noise)));
        }
        let error = value.iter().map(|v| relative_error * *v).collect();
        (patches, value, error, truth)
    }

    #[test]
    fn denoising_halves_noise_and_keeps_shadow_edges() {
        let (patches, value, error, truth) = floor(0.3);
        let denoised = denoise_patches(&patches, &value, &error);
        let rms_error = |v: &[Bands]| {
            let square = v.iter().zip(&truth).map(|(v, t)| (v.first() / t - 1.0).powi(2)).sum::<f64>();
            (square / truth.len() as f64).sqrt()
        };
        let (before, after) = (rms_error(&value), rms_error(&denoised));
        assert!(before > 0.09 && after < 0.045, "{before} {after}");
        // The patches beside the edge improve too.
        let beside = |v: &Vec<Bands>| {
            (15 * 32..17 * 32).map(|k| (v[k].first() / truth[k] - 1.0).abs()).fold(0.0, f64::max)
        };
        assert!(beside(&denoised) < beside(&value), "{}", beside(&denoised));
        let mean = |v: &[Bands]| v.iter().map(|v| v.first()).sum::<f64>();
        assert!((mean(&denoised) / mean(&value) - 1.0).abs() < 0.01);
    }

    #[test]
    fn values_with_small_errors_are_unchanged() {
        let (patches, value, error, _) = floor(PARAMS.min_relative_error);
        assert_eq!(denoise_patches(&patches, &value, &error), value);
    }
}
