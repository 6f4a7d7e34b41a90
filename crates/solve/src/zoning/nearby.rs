//! What a medium scatters back to a surface that is smaller than the cell around it.
//!
//! A disc of radius R and radiosity B sends radiance B/π; where it fills a solid angle Ω the fluence is BΩ/π. A medium that scatters with σ_s
//! (1/m) gives back, in single scattering,
//!
//! ```text
//!     ∫ σ_s (B Ω / π) · Ω / (4π) dV  ≈  0.6 σ_s R · B πR²  ≈  0.35 σ_s √A · B A
//! ```
//!
//! nearly all of it from within a few R, where Ω is not small. One radiosity for a cell of edge h ≫ R spreads that light over h³ and gives back
//! next to nothing; so do cells of h/2, and two such solves agree on a wrong answer. Where H arrives from all around, only B − H matters: a surface
//! as bright as what surrounds it changes nothing. The error of a surface with √A < h has [`SCATTERED_BACK`] σ_s √A |B − H| of what it receives
//! added; volumes whose heat is given emit what they absorb, which counts as scattering.

use super::are_given;
use zonal_scene::{Bands, Fields, HeatKind, Known, Report, Scene, Zones, Zoning, bands, thermal};

/// The share of a surface's light that comes back, over the optical depth σ_s √A: of a disc (header), and half as much again for later
/// scattering and for bodies that shine to all sides.
const SCATTERED_BACK: f64 = 0.5;

/// Adds to the errors of surfaces that are smaller than the cells that they lie in what the medium scatters back to them.
pub(super) fn add(scene: &Scene, zones: &Zones, fields: &Fields, report: &Report, zoning: &mut Zoning) {
    let missed = missed(scene, zones, fields);
    for (error, more) in zoning.energy.absorbed_surfaces.iter_mut().zip(&missed) {
        error.1 = bands(|b| error.1[b] + more.absorbed[b]);
    }
    let Some(heat) = &report.heat else { return };
    let rows = heat.rows.iter().zip(are_given(scene, heat)).zip(&mut zoning.heat);
    let surfaces = rows.filter(|((row, _), _)| row.kind == HeatKind::Surface);
    for (((row, given), error), more) in surfaces.zip(&missed) {
        if given {
            error[1] += more.absorbed.iter().sum::<f64>();
        } else if let Some(t) = row.temperature {
            let arriving = more.arriving.iter().sum::<f64>() / row.size;
            error[0] += arriving / (4.0 * thermal::STEFAN_BOLTZMANN * t.powi(3));
        }
    }
}

/// Power that a surface does not get, W a band.
#[derive(Clone, Copy, Default)]
struct Missed {
    arriving: Bands,
    absorbed: Bands,
}

fn missed(scene: &Scene, zones: &Zones, fields: &Fields) -> Vec<Missed> {
    let mut out = vec![Missed::default(); scene.surfaces().len()];
    let Some(map) = scene.voxmap() else { return out };
    let mut area = vec![0.0; out.len()];
    zones.patches.iter().for_each(|p| area[p.surface] += p.area);
    let edge = (0..3).filter(|&k| !scene.periodic()[k]).map(|k| map.cell()[k]).fold(f64::INFINITY, f64::min);
    for (i, p) in zones.patches.iter().enumerate() {
        let across = area[p.surface].sqrt();
        if across >= edge {
            continue;
        }
        let Some(cell) = map.cell_at(p.plate.centre() + p.normal * (1e-6 * across)) else { continue };
        let cell = map.index(cell);
        let exchanged = map.heat(cell).is_some_and(|k| !matches!(k, Known::Temperature(_)));
        let scattering =
            bands(|b| map.extinction(cell)[b] * if exchanged { 1.0 } else { map.albedo(cell)[b] });
        let h = bands(|b| fields.incident[i][b] + fields.direct.get(i).map_or(0.0, |d| d[b]));
        let share = bands(|b| (SCATTERED_BACK * scattering[b] * across).min(1.0));
        // The radiosity of what is a direct light has its emission not in it.
        let surface = &scene.surfaces()[p.surface];
        let emission = if scene.is_direct_emitter(p.surface) { surface.emission } else { [0.0; 3] };
        let more = bands(|b| share[b] * (emission[b] + fields.radiosity[i][b] - h[b]).abs() * p.area);
        let own = &mut out[p.surface];
        own.arriving = bands(|b| own.arriving[b] + more[b]);
        own.absorbed = bands(|b| own.absorbed[b] + (1.0 - p.reflectance[b]) * more[b]);
    }
    out
}
