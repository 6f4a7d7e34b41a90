//! Light that a medium scatters back to a surface smaller than the cell around it along one axis at least.
//!
//! A disc of radius R and radiosity B sends radiance B/π; where it subtends a solid angle Ω the fluence is BΩ/π. A medium with the scattering
//! coefficient σ_s (1/m) returns, in single scattering,
//!
//! ```text
//!     ∫ σ_s (B Ω / π) · Ω / (4π) dV  ≈  0.6 σ_s R · B πR²  ≈  0.35 σ_s √A · B A
//! ```
//!
//! nearly all of it from within a few R, where Ω is not small. A constant radiosity in a cell of edge h ≫ R distributes that light over h³ and returns
//! almost nothing; so do cells of h/2, and two such solves agree on a wrong result. If H is incident from all directions, only B − H matters: a surface
//! with the radiosity of its surroundings has no such error. The error of a surface in cells of edges h_k is increased by
//!
//! ```text
//!     BACKSCATTERED_SHARE σ_s √A |B − H| · min(1, 2 (1 − Π_k min(1, √A / h_k)))
//! ```
//!
//! since a cell that is long along one axis spreads the light along it. Volumes with prescribed heat emit the power that they absorb, which counts as scattering.

use super::prescribed_temperatures::{RowTemperature, row_temperatures};
use zonal_scene::{
    Bands, DiscretizationError, Fields, HeatRowKind, Report, Scene, ThermalCondition, Zones, thermal,
};

/// Backscattered fraction of the light of a surface over the optical depth σ_s √A: that of a disc (module header), and half as much again for multiple
/// scattering and for bodies that emit to all sides.
const BACKSCATTERED_SHARE: f64 = 0.5;

/// Adds the light scattered back by the medium to the errors of the power absorbed by surfaces that are smaller than their cells.
pub(super) fn add_to_energy(unresolved: &[UnresolvedPower], estimate: &mut DiscretizationError) {
    for (error, more) in estimate.energy.absorbed_surfaces.iter_mut().zip(unresolved) {
        error.1 += more.absorbed;
    }
}

/// Adds that of one block of bands to the errors of temperatures and net powers.
pub(super) fn add_to_heat(
    scene: &Scene,
    unresolved: &[UnresolvedPower],
    report: &Report,
    estimate: &mut DiscretizationError,
) {
    let Some(heat) = &report.heat else { return };
    let rows = heat.rows.iter().zip(row_temperatures(scene, heat)).zip(&mut estimate.heat);
    let surfaces = rows.filter(|((row, _), _)| row.kind == HeatRowKind::Surface);
    for (((row, given), error), more) in surfaces.zip(unresolved) {
        if given == RowTemperature::Prescribed {
            error[1] += more.absorbed.sum();
        } else if let Some(t) = row.temperature {
            let incident = more.incident.sum() / row.size;
            error[0] += incident / (4.0 * thermal::STEFAN_BOLTZMANN * t.powi(3));
        }
    }
}

/// Backscattered power that the cells do not resolve, for one surface, W per band.
#[derive(Clone, Copy, Default)]
pub(super) struct UnresolvedPower {
    incident: Bands,
    absorbed: Bands,
}

/// Those of all surfaces.
pub(super) fn unresolved_powers(scene: &Scene, zones: &Zones, fields: &Fields) -> Vec<UnresolvedPower> {
    let mut out = vec![UnresolvedPower::default(); scene.surfaces().len()];
    let Some(grid) = scene.voxel_grid() else { return out };
    let mut area = vec![0.0; out.len()];
    zones.patches.iter().for_each(|p| area[p.surface] += p.area);
    let edges = || (0..3).filter(|&k| !scene.endless_axes()[k]).map(|k| grid.cell()[k]);
    for (i, p) in zones.patches.iter().enumerate() {
        let across = area[p.surface].sqrt();
        let resolved: f64 = edges().map(|h| (across / h).min(1.0)).product();
        let unresolved = (2.0 * (1.0 - resolved)).min(1.0);
        if unresolved == 0.0 {
            continue;
        }
        let Some(cell) = grid.cell_at(p.plate.centre() + p.normal * (1e-6 * across)) else { continue };
        let cell = grid.index(cell);
        let reemits = grid.heat(cell).is_some_and(|k| !matches!(k, ThermalCondition::Temperature(_)));
        let scattering = grid.extinction(cell) * if reemits { Bands::ONE } else { grid.albedo(cell) };
        let h = fields.incident[i] + fields.direct_light(i);
        let share = unresolved * (BACKSCATTERED_SHARE * scattering * across).min(Bands::ONE);
        // The radiosity of a direct emitter does not include its emission.
        let surface = &scene.surfaces()[p.surface];
        let emission = if scene.is_direct_emitter(p.surface) { surface.emission } else { Bands::ZERO };
        let more = share * (emission + fields.radiosity[i] - h).abs() * p.area;
        let own = &mut out[p.surface];
        own.incident += more;
        own.absorbed += (1.0 - p.reflectance - zones.sheets.transmittance(i)) * more;
    }
    out
}
