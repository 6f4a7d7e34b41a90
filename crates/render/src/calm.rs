//! Noise of patches that the solution tells of, taken out of pictures.
//!
//! A solution by rays knows how far each value may be off: e, relative e/H. Patches that lie side by side and differ by less than that are told
//! apart by noise alone, and the eye sees stains where there is even light. So each patch i takes the mean of those around it,
//!
//! ```text
//! H_i' = Σ_j w_ij H_j / Σ_j w_ij      w_ij = A_j exp(−d²/2r²) exp(−|H_i − H_j|²/2σ²)      σ² = Σ_{i,j} (SHARE · (e − LEAST · H)₊)²
//! ```
//!
//! over patches within 3r, r a few patches wide, that face nearly the same way or bend round a column. What differs by more than noise (shadows, another room)
//! stays apart, and where errors are below LEAST nothing is touched.

use crate::patch_field::key;
use rayon::prelude::*;
use std::collections::HashMap;
use zonal_math::Vec3;
use zonal_scene::{Bands, Patch, bands};

/// Share of the estimated error that counts as noise: estimates are two to five times what they bound.
const SHARE: f64 = 0.7;
/// Relative errors below this do not show.
const LEAST: f64 = 0.04;
/// r over the root of a patch's area.
const WIDTH: f64 = 2.4;
/// Least cosine between normals, and height over the patch's plane relative to distance: two sides of a round column count.
const ALIKE: f64 = 0.78;
const HEIGHT: f64 = 0.34;

/// What is asked of a patch.
struct Spot {
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

/// What arrives at patches, without the noise that its `error` tells.
pub(crate) fn calmed(patches: &[Patch], incident: &[Bands], error: &[Bands]) -> Vec<Bands> {
    let noise: Vec<f64> =
        (0..patches.len()).map(|i| SHARE * (sum(&error[i]) - LEAST * sum(&incident[i])).max(0.0)).collect();
    if noise.iter().all(|x| *x == 0.0) {
        return incident[..patches.len()].to_vec();
    }
    // A few large patches must not fill the grid.
    let mean = patches.iter().map(|p| p.area.sqrt()).sum::<f64>() / patches.len() as f64;
    let cell = 6.0 * WIDTH * mean.max(1e-12);
    let spot = |i: usize| Spot {
        at: patches[i].plate.centre(),
        normal: patches[i].normal,
        area: patches[i].area,
        value: incident[i],
        noise: noise[i],
    };
    let spots: Vec<Spot> = (0..patches.len()).into_par_iter().map(spot).collect();
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    spots.iter().enumerate().for_each(|(i, p)| cells.entry(key(p.at, cell)).or_default().push(i as u32));
    let one = |own: &Spot| {
        if own.noise == 0.0 {
            return own.value;
        }
        let r2 = (WIDTH * own.area.sqrt().min(2.0 * mean)).powi(2);
        let (home, mut total, mut weights) = (key(own.at, cell), [0.0; 3], 0.0);
        for c in 0..27 {
            let at = [home[0] + c / 9 - 1, home[1] + c / 3 % 3 - 1, home[2] + c % 3 - 1];
            for &j in cells.get(&at).map_or(&[][..], Vec::as_slice) {
                let other = &spots[j as usize];
                let away = other.at - own.at;
                let d2 = away.length2();
                let apart = d2 > 9.0 * r2
                    || own.normal.dot(other.normal) < ALIKE
                    || own.normal.dot(away).powi(2) > HEIGHT * HEIGHT * d2;
                if apart {
                    continue;
                }
                let differ = sum(&bands(|b| (own.value[b] - other.value[b]).abs()));
                let spread = own.noise.powi(2) + other.noise.powi(2);
                let w = other.area * (-0.5 * (d2 / r2 + differ * differ / spread)).exp();
                total = bands(|b| total[b] + w * other.value[b]);
                weights += w;
            }
        }
        total.map(|t| t / weights)
    };
    spots.par_iter().map(one).collect()
}

fn sum(v: &Bands) -> f64 {
    v.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::{sequence, vec3};
    use zonal_scene::Plate;

    /// A floor of unit patches, brighter by half beyond x = 16, with noise of 10 %.
    fn floor(told: f64) -> (Vec<Patch>, Vec<Bands>, Vec<Bands>, Vec<f64>) {
        let (mut patches, mut value, mut truth) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..32 * 32u64 {
            let (i, j) = ((k / 32) as f64, (k % 32) as f64);
            let plate = Plate::parallelogram(vec3(i, j, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
            let (normal, zero) = (vec3(0.0, 0.0, 1.0), [0.0; 3]);
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
            let noise = 0.1 * 12f64.sqrt() * (sequence::unit(k + 5) - 0.5);
            value.push([level * (1.0 + noise); 3]);
        }
        let error = value.iter().map(|v| v.map(|v| told * v)).collect();
        (patches, value, error, truth)
    }

    #[test]
    fn noise_goes_and_borders_of_shadows_stay() {
        let (patches, value, error, truth) = floor(0.3);
        let calm = calmed(&patches, &value, &error);
        let off = |v: &[Bands]| {
            let square = v.iter().zip(&truth).map(|(v, t)| (v[0] / t - 1.0).powi(2)).sum::<f64>();
            (square / truth.len() as f64).sqrt()
        };
        assert!(off(&value) > 0.09 && off(&calm) < 0.045, "{} {}", off(&value), off(&calm));
        // Beside the border too.
        let beside =
            |v: &Vec<Bands>| (15 * 32..17 * 32).map(|k| (v[k][0] / truth[k] - 1.0).abs()).fold(0.0, f64::max);
        assert!(beside(&calm) < beside(&value), "{}", beside(&calm));
        let mean = |v: &[Bands]| v.iter().map(|v| v[0]).sum::<f64>();
        assert!((mean(&calm) / mean(&value) - 1.0).abs() < 0.01);
    }

    #[test]
    fn what_is_known_well_is_not_touched() {
        let (patches, value, error, _) = floor(0.04);
        assert_eq!(calmed(&patches, &value, &error), value);
    }
}
