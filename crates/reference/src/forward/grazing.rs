//! The part of the light of a medium that walks do not sample in a scene that is periodic in two axes.
//!
//! A medium of thickness L that sends out P watts above a base A sends P/2A dμ of them in directions of cosine μ with the third axis, which stay
//! in it for L/μ or until they are extinguished. What arrives in it is the mean length of its light:
//!
//! ```text
//!     G ≈ P/2A (ln 1/κL + 1)     of which directions below μ_c bring   P/2A (ln μ_c/κL + 1)   as long as κL < μ_c
//! ```
//!
//! Of n walks hardly one is more grazing than μ_c = 1/n: where the medium is thinner than that, the mean of the walks lacks this part, and their
//! spread does not show it. It is counted as an error.

use super::Answer;
use super::sources::Sources;
use zonal_scene::{Bands, Scene, Zones};

/// What walks lack of G for each band, W/m²: `walks` of each of the `sources`.
pub(super) fn unsampled(scene: &Scene, sources: &[Sources], walks: usize) -> Bands {
    let periodic = scene.periodic();
    let (Some(map), Some(axis), 2) =
        (scene.voxmap(), (0..3).find(|&k| !periodic[k]), periodic.iter().filter(|p| **p).count())
    else {
        return [0.0; 3];
    };
    let length = |k: usize| map.cell()[k] * map.dims()[k] as f64;
    let base: f64 = (0..3).filter(|&k| k != axis).map(length).product();
    let one = |(b, s): (usize, &Sources)| {
        let n = (walks as f64 * s.medium / s.power).max(1.0);
        let missing = (1.0 - (n * map.extinction(0)[b] * length(axis)).ln()).max(0.0);
        if s.medium > 0.0 { s.medium / (2.0 * base) * missing } else { 0.0 }
    };
    let all: Vec<f64> = sources.iter().enumerate().map(one).collect();
    [0, 1, 2].map(|b| all.get(b).or(all.first()).copied().unwrap_or(0.0))
}

/// Adds what walks lack of G to the standard errors of an answer.
pub(super) fn widen(answer: &mut Answer, lacking: Bands, scene: &Scene, zones: Option<&Zones>) {
    let Some(map) = scene.voxmap().filter(|_| lacking != [0.0; 3]) else { return };
    let volume = map.cell().product();
    let taken = |b: usize| -> f64 {
        (0..map.len()).map(|c| map.extinction(c)[b] * (1.0 - map.albedo(c)[b]) * volume * lacking[b]).sum()
    };
    let power = [0, 1, 2].map(taken);
    let all = |x: Bands| x.iter().sum::<f64>();
    (0..3).for_each(|b| answer.medium[b].error = answer.medium[b].error.hypot(power[b]));
    let voxels = zones.map_or(0..0, |z| z.voxel_offset()..z.pane_offset());
    for i in voxels.clone() {
        (0..3).for_each(|b| answer.zones[i][b].error = answer.zones[i][b].error.hypot(lacking[b]));
    }
    let own = answer.heat.get_mut(scene.surfaces().len()).into_iter().map(|h| (h, 1.0));
    let share = 1.0 / voxels.len().max(1) as f64;
    let of_zones = answer.zone_heat.iter_mut().enumerate().filter(|(i, _)| voxels.contains(i));
    for (heat, share) in own.chain(of_zones.map(|(_, h)| (h, share))) {
        heat.power.error = heat.power.error.hypot(share * all(power));
        if let Some(e) = &mut heat.emissive {
            e.error = e.error.hypot(0.25 * all(lacking));
        }
    }
}
