//! The discretization error of light that diffuses through thick cells, without a second solve.
//!
//! A zone spreads light evenly over its cell in every scattering. Light that diffuses through cells of optical depth Δ so travels too far: in a medium of
//! parallel layers that absorbs nothing the mean square of the path between two scatterings is, along the normal,
//!
//! ```text
//!     ⟨n²⟩ Δ² = Δ (1/2 + 2 Σ_{m ≥ 1} E₃(mΔ))      in place of 2/3,       R = (3Δ/2) (1/2 + 2 Σ_{m ≥ 1} E₃(mΔ)) ≈ 1 + Δ²/4,
//! ```
//!
//! n: number of layers between the two. Light that crosses the medium is R times too strong. Where the medium absorbs the fraction 1 − ω in each
//! collision, the length of decay grows by √R, and light that crosses the depth τ is too strong by exp((1 − 1/√R) √(3(1−ω)) τ) in addition. With
//! both factors f, the true power is at least P/f:
//!
//! ```text
//!     error of a power P = (1 − 1/f) · min(P, L) · (B_max − B_min)/B_max
//! ```
//!
//! L: power that leaves the thick cells through their common boundary, Σ A B over its faces; it bounds what a small cloud does to a room. B_max, B_min: largest
//! and smallest mean radiance of the cells; where all are equal, there is no diffusion and no error. Surfaces smaller than their cells add the light of
//! `near_surface_scattering`. A second solve measures the error; this estimate states it where none was requested.

use super::near_surface_scattering;
use crate::distribution::sum_order::SharedZones;
use zonal_math::exponential_integral::e3;
use zonal_math::parallel;
use zonal_scene::{
    Band, Bands, Diagnostic, DiscretizationError, EnergyBalance, Fields, Report, Scene, VoxelGrid,
};

/// Scattering depth across a cell above which its error is stated; below, the factor R differs from 1 by 2 %.
const MIN_SCATTERING_DEPTH: f64 = 0.3;
/// Argument of E₃ beyond which its terms are negligible.
const MAX_E3_ARGUMENT: f64 = 40.0;

/// The estimate for one block of bands; `None` if no cell scatters over more than [`MIN_SCATTERING_DEPTH`].
pub(super) fn estimate(
    scene: &Scene,
    zones: SharedZones,
    fields: &Fields,
    report: &Report,
) -> Option<DiscretizationError> {
    let grid = scene.voxel_grid()?;
    let is_thick = |cell: usize| scattering_depth(grid, cell) > MIN_SCATTERING_DEPTH;
    if !parallel::any(grid.len(), is_thick) {
        return None;
    }
    let thick: Vec<bool> = parallel::collect(grid.len(), is_thick);
    let excess = largest_excess(grid, zones, &thick);
    let (leaving, contrast) = (leaving_power(grid, zones, fields, &thick), contrast(zones, fields, &thick));
    let share = (1.0 - 1.0 / excess) * contrast;
    let error = |power: Bands| share * power.abs().min(leaving);
    let energy = &report.energy;
    let mut estimate = DiscretizationError {
        ratio: f64::INFINITY,
        energy: EnergyBalance {
            absorbed_surfaces: energy.absorbed_surfaces.iter().map(|s| (s.0.clone(), error(s.1))).collect(),
            absorbed_volumes: error(energy.absorbed_volumes),
            absorbed_panes: error(energy.absorbed_panes),
            absorbed_backfaces: error(energy.absorbed_backfaces),
            escaped: error(energy.escaped),
            ..EnergyBalance::default()
        },
        ..DiscretizationError::default()
    };
    let unresolved = near_surface_scattering::unresolved_powers(scene, &zones, fields);
    near_surface_scattering::add_to_energy(&unresolved, &mut estimate);
    let most = (0..grid.len()).map(|cell| scattering_depth(grid, cell)).fold(0.0, f64::max);
    estimate.notes.push(Diagnostic::note("thick-scattering", format!(
        "light diffuses through cells that scatter over up to {most:.2} optical depths with one radiosity each: the discretization error is an estimate from the diffusion between such cells; a second solve measures it (discretization_error = true), and smaller cells reduce it"
    )));
    Some(estimate)
}

/// Longest edge of a cell, m.
fn longest_edge(grid: &VoxelGrid) -> f64 {
    grid.cell().max_abs()
}

/// Scattering depth across a cell, of the worst band.
fn scattering_depth(grid: &VoxelGrid, cell: usize) -> f64 {
    (grid.extinction(cell) * grid.albedo(cell)).max_element() * longest_edge(grid)
}

/// R of the module header.
fn diffusion_excess(depth: f64) -> f64 {
    let terms = (1..).map(|m| f64::from(m) * depth).take_while(|x| *x < MAX_E3_ARGUMENT);
    1.5 * depth * (0.5 + 2.0 * terms.map(e3).sum::<f64>())
}

/// f of the module header, largest over the thick cells.
fn largest_excess(grid: &VoxelGrid, zones: SharedZones, thick: &[bool]) -> Bands {
    let (edge, sides) = (longest_edge(grid), (grid.max() - grid.min()).array());
    let across = sides.into_iter().fold(f64::INFINITY, f64::min);
    let mut out = Bands::ONE;
    for z in zones.voxels.distinct_media().filter(|z| thick[z.cell]) {
        let of_band = |b: Band| {
            let (kappa, albedo) = (z.extinction[b], z.albedo[b]);
            if kappa * albedo * edge <= MIN_SCATTERING_DEPTH {
                return 1.0;
            }
            let ratio = diffusion_excess(kappa * edge).max(1.0);
            let decay = (3.0 * (1.0 - albedo)).sqrt() * kappa * across;
            ratio * ((1.0 - ratio.sqrt().recip()) * decay).exp()
        };
        out = out.max(Bands::from_fn(of_band));
    }
    zones.order().over_processes(out, Bands::max)
}

/// Power that leaves the thick cells through the boundary of all of them, W.
fn leaving_power(grid: &VoxelGrid, zones: SharedZones, fields: &Fields, thick: &[bool]) -> Bands {
    let (dims, edges) = (grid.dims(), grid.cell().array());
    let of_zone = |k: usize| {
        let cell = zones.voxels.at(k).cell;
        if !thick[cell] {
            return Bands::ZERO;
        }
        let at = grid.coordinates(cell);
        let mut area = 0.0;
        for (axis, up) in (0..6).map(|s| (s / 2, s % 2 == 1)) {
            let mut next = at;
            let inside = if up { at[axis] + 1 < dims[axis] } else { at[axis] > 0 };
            if inside {
                next[axis] = if up { at[axis] + 1 } else { at[axis] - 1 };
            }
            if !inside || !thick[grid.index(next)] {
                area += edges[(axis + 1) % 3] * edges[(axis + 2) % 3];
            }
        }
        fields.radiosity[zones.voxel_index(k)].abs() * area
    };
    zones.sum_voxels(of_zone)
}

/// (B_max − B_min)/B_max of the fluence of the thick cells.
fn contrast(zones: SharedZones, fields: &Fields, thick: &[bool]) -> Bands {
    let fluence = |k: usize| {
        let i = zones.voxel_index(k);
        fields.incident[i] + fields.direct_light(i)
    };
    let cells = zones.voxels.iter().enumerate().filter(|(_, z)| thick[z.cell]).map(|(k, _)| fluence(k));
    let none = [Bands::splat(f64::INFINITY), Bands::ZERO];
    let [least, most] = cells.fold(none, |[least, most], g| [least.min(g), most.max(g)]);
    let [least, most] =
        [zones.order().over_processes(least, Bands::min), zones.order().over_processes(most, Bands::max)];
    least.zip_map(most, |least, most| if most > 0.0 { (1.0 - least / most).clamp(0.0, 1.0) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_diffuses_too_far_by_a_quarter_of_the_squared_depth() {
        for depth in [0.02, 0.1, 0.3] {
            let excess = diffusion_excess(depth) - 1.0;
            assert!((excess / (0.25 * depth * depth) - 1.0).abs() < 0.4 * depth, "{depth}: {excess}");
        }
        // Only neighbours exchange: 3Δ/4.
        assert!((diffusion_excess(20.0) / 15.0 - 1.0).abs() < 1e-6);
    }
}
