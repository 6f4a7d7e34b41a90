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
//! `NOISE_SHARE_OF_ESTIMATE` and `MIN_RELATIVE_ERROR`. Differences above the noise (shadows, other rooms) remain, and values with a
//! relative error below e_min are not changed. Cost: the patches within 3r of each patch.

use rayon::prelude::*;
use zonal_math::Vec3;
use zonal_math::simd::{self, LANES, dispatch};
use zonal_scene::{Bands, Patch};
use zonal_transport::point_grids::PointGrids;

// Widths and thresholds of the filter.

/// Share s of the estimated error that counts as noise: estimates are two to five times the error that they bound.
const NOISE_SHARE_OF_ESTIMATE: f64 = 0.7;
/// Relative error e_min below which noise is not visible.
const MIN_RELATIVE_ERROR: f64 = 0.015;
/// r over the square root of a patch's area.
const FILTER_RADIUS: f64 = 4.0;
/// Least cosine between the normals of two patches: neighbouring sides of a round column pass.
const MIN_NORMAL_COSINE: f64 = 0.78;
/// Largest height of a patch over the plane of the other, over their distance.
const MAX_PLANE_DISTANCE: f64 = 0.34;

/// Distance of the farthest patches of a mean over r, and largest square root of a patch's area over the mean one that widens r.
const REACH: f64 = 3.0;
const MAX_RELATIVE_SIZE: f64 = 2.0;

/// Irradiances of the patches, and their errors, W/m².
#[derive(Clone, Copy)]
pub(crate) struct NoisyField<'a> {
    pub incident: &'a [Bands],
    pub error: &'a [Bands],
}

impl NoisyField<'_> {
    /// The part of the error of every patch that counts as noise, all bands together, W/m².
    fn noise(&self, patches: usize) -> Vec<f64> {
        let excess = |i: usize| self.error[i].sum() - MIN_RELATIVE_ERROR * self.incident[i].sum();
        (0..patches).map(|i| NOISE_SHARE_OF_ESTIMATE * excess(i).max(0.0)).collect()
    }
}

/// The irradiances of the patches, W/m², each field filtered by the noise level that its errors imply.
pub(crate) fn denoise_patches(patches: &[Patch], fields: &[NoisyField]) -> Vec<Vec<Bands>> {
    let noises: Vec<Vec<f64>> = fields.iter().map(|f| f.noise(patches.len())).collect();
    if noises.iter().flatten().all(|x| *x == 0.0) {
        return fields.iter().map(|f| f.incident[..patches.len()].to_vec()).collect();
    }
    let mean = patches.iter().map(|p| p.area.sqrt()).sum::<f64>() / patches.len() as f64;
    let centres: Vec<Vec3> = patches.iter().map(|p| p.plate.centre()).collect();
    let largest_radius = REACH * FILTER_RADIUS * MAX_RELATIVE_SIZE * mean;
    let grids = PointGrids::new(&centres, largest_radius);
    let filter = PatchFilter { patches, fields, noises: &noises, centres: &centres, grids, mean };
    let mut filtered = vec![Bands::ZERO; patches.len() * fields.len()];
    filtered
        .par_chunks_mut(fields.len())
        .enumerate()
        .for_each_init(Vec::new, |near, (i, out)| filter.apply(i, near, out));
    (0..fields.len()).map(|f| filtered.iter().skip(f).step_by(fields.len()).copied().collect()).collect()
}

/// A patch near another.
struct NearPatch {
    index: u32,
    /// −d²/2r².
    exponent: f64,
}

/// The patches in grids, with the fields on them.
struct PatchFilter<'a> {
    patches: &'a [Patch],
    fields: &'a [NoisyField<'a>],
    /// Of each field the noise of every patch, W/m².
    noises: &'a [Vec<f64>],
    /// Centres of the patches, m.
    centres: &'a [Vec3],
    grids: PointGrids,
    /// Mean square root of the patches' areas, m.
    mean: f64,
}

impl PatchFilter<'_> {
    /// The filtered values of patch `i`, a field; `near` is scratch memory.
    fn apply(&self, i: usize, near: &mut Vec<NearPatch>, out: &mut [Bands]) {
        near.clear();
        if self.noises.iter().any(|noise| noise[i] > 0.0) {
            self.find_near(i, near);
        }
        for ((out, field), noise) in out.iter_mut().zip(self.fields).zip(self.noises) {
            *out = if noise[i] > 0.0 {
                dispatch(|| self.weighted_mean(i, near, field.incident, noise))
            } else {
                field.incident[i]
            };
        }
    }

    /// The patches within the filter's radius of patch `i` that face nearly the same way or follow round a column.
    fn find_near(&self, i: usize, near: &mut Vec<NearPatch>) {
        let (own, at) = (&self.patches[i], self.centres[i]);
        let r = FILTER_RADIUS * own.area.sqrt().min(MAX_RELATIVE_SIZE * self.mean);
        let (reach2, scale) = (REACH * REACH * r * r, -0.5 / (r * r));
        let max_height2 = MAX_PLANE_DISTANCE * MAX_PLANE_DISTANCE;
        self.grids.for_each_near(at, own.normal, REACH * r, MAX_PLANE_DISTANCE, |j| {
            let away = self.centres[j] - at;
            let d2 = away.length2();
            if d2 > reach2 || own.normal.dot(away).powi(2) > max_height2 * d2 {
                return;
            }
            if own.normal.dot(self.patches[j].normal) >= MIN_NORMAL_COSINE {
                near.push(NearPatch { index: j as u32, exponent: scale * d2 });
            }
        });
    }

    /// The mean of the field `value` with the noise `noise` over the patches near patch `i`, by weights.
    #[inline(always)]
    fn weighted_mean(&self, i: usize, near: &[NearPatch], value: &[Bands], noise: &[f64]) -> Bands {
        let (own, own_variance) = (value[i], noise[i] * noise[i]);
        let (mut total, mut weights) = (Bands::ZERO, 0.0);
        for chunk in near.chunks(LANES) {
            let mut exponents = [0.0; LANES];
            for (exponent, other) in exponents.iter_mut().zip(chunk) {
                let j = other.index as usize;
                let difference = (own - value[j]).abs().sum();
                let variance = own_variance + noise[j] * noise[j];
                *exponent = other.exponent - 0.5 * (difference * difference) / variance;
            }
            for (w, other) in simd::exp(exponents).into_iter().zip(chunk) {
                let j = other.index as usize;
                let w = w * self.patches[j].area;
                total += w * value[j];
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

    fn denoise_one(patches: &[Patch], incident: &[Bands], error: &[Bands]) -> Vec<Bands> {
        denoise_patches(patches, &[NoisyField { incident, error }]).swap_remove(0)
    }

    #[test]
    fn denoising_halves_noise_and_keeps_shadow_edges() {
        let (patches, value, error, truth) = floor(0.3);
        let denoised = denoise_one(&patches, &value, &error);
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
    fn fields_are_filtered_apart() {
        let (patches, value, error, truth) = floor(0.3);
        let zero = vec![Bands::ZERO; patches.len()];
        let truth: Vec<Bands> = truth.into_iter().map(Bands::splat).collect();
        let fields = [(&value, &error), (&truth, &zero), (&truth, &error)];
        let fields = fields.map(|(incident, error)| NoisyField { incident, error });
        let together = denoise_patches(&patches, &fields);
        let alone = |f: usize| denoise_patches(&patches, &fields[f..=f]).swap_remove(0);
        (0..3).for_each(|f| assert_eq!(together[f], alone(f), "{f}"));
        assert_eq!(together[1], truth);
    }

    #[test]
    fn values_with_small_errors_are_unchanged() {
        let (patches, value, error, _) = floor(MIN_RELATIVE_ERROR);
        assert_eq!(denoise_one(&patches, &value, &error), value);
    }
}
