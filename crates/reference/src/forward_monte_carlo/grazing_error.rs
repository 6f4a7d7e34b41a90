//! Error of unsampled grazing directions in a scene that is periodic on two axes.
//!
//! A medium of thickness L that emits P watts above a base A emits P/2A dμ of them in directions of cosine μ with the third axis.
//! They stay in it for L/μ or until they are extinguished. The fluence in the medium is the mean length of its own light:
//!
//! ```text
//!     G ≈ P/2A (ln 1/κL + 1)     of which directions below μ_c contribute   P/2A (ln μ_c/κL + 1)   as long as κL < μ_c
//! ```
//!
//! Of n walks hardly one is more grazing than μ_c = 1/n. Where the medium is thinner than that, the mean of the walks lacks this
//! part, and their spread does not show it. It is added to the standard errors.

use super::emission_sampling::EmissionTable;
use super::solution::ForwardSolution;
use crate::estimate::SampleEstimate;
use zonal_scene::{Band, Bands, PerBand, Scene, Zones};

/// The fluence G that `walks` walks from each of the `sources` do not sample, W/m² per band.
pub(super) fn unsampled_fluence(scene: &Scene, sources: &[EmissionTable], walks: usize) -> Bands {
    let periodic = scene.periodic();
    let (Some(grid), Some(axis), 2) =
        (scene.voxel_grid(), (0..3).find(|&k| !periodic[k]), periodic.iter().filter(|p| **p).count())
    else {
        return Bands::ZERO;
    };
    let length = |k: usize| grid.cell()[k] * grid.dims()[k] as f64;
    let base: f64 = (0..3).filter(|&k| k != axis).map(length).product();
    let of_band = |(b, s): (Band, &EmissionTable)| {
        let n = (walks as f64 * s.medium / s.power).max(1.0);
        let missing = (1.0 - (n * grid.extinction(0)[b] * length(axis)).ln()).max(0.0);
        if s.medium > 0.0 { s.medium / (2.0 * base) * missing } else { 0.0 }
    };
    let all: Vec<f64> = Band::all().zip(sources).map(of_band).collect();
    Bands::from_fn(|b| all.get(b.index()).or(all.first()).copied().unwrap_or(0.0))
}

/// Adds the unsampled fluence `missing` to the standard errors of a solution.
pub(super) fn widen_errors(
    solution: &mut ForwardSolution,
    missing: Bands,
    scene: &Scene,
    zones: Option<&Zones>,
) {
    let Some(grid) = scene.voxel_grid().filter(|_| missing != Bands::ZERO) else { return };
    // Errors of the absorbed power and of the fluence.
    let volume = grid.cell().product();
    let absorbed = |b: Band| -> f64 {
        (0..grid.len()).map(|c| grid.extinction(c)[b] * (1.0 - grid.albedo(c)[b]) * volume * missing[b]).sum()
    };
    let power = Bands::from_fn(absorbed);
    let widen = |estimates: &mut PerBand<SampleEstimate>, by: Bands| {
        estimates.iter_mut().zip(by).for_each(|(e, by)| e.error = e.error.hypot(by));
    };
    widen(&mut solution.medium, power);
    let voxels = zones.map_or(0..0, |z| z.voxel_offset()..z.pane_offset());
    for i in voxels.clone() {
        widen(&mut solution.zones[i], missing);
    }
    // Errors of net powers and temperatures.
    let medium = solution.heat.get_mut(scene.surfaces().len()).into_iter().map(|h| (h, 1.0));
    let share = 1.0 / voxels.len().max(1) as f64;
    let of_zones = solution.zone_heat.iter_mut().enumerate().filter(|(i, _)| voxels.contains(i));
    for (heat, share) in medium.chain(of_zones.map(|(_, h)| (h, share))) {
        heat.power.error = heat.power.error.hypot(share * power.sum());
        if let Some(e) = &mut heat.emissive {
            e.error = e.error.hypot(0.25 * missing.sum());
        }
    }
}
