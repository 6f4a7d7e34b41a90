//! What a solution says of its own errors: the one place that knows where reports keep them.

use zonal::scene::solution::{Energy, Report};
use zonal::scene::{Bands, Solution};

/// True where escaped power has a stated error.
pub const ESCAPED: bool = false;

/// True where the report warns.
pub fn warned(report: &Report) -> bool {
    !report.warnings.is_empty()
}

/// Stated errors of temperature (K) and net power (W) of each row of heat: of the exchange and of the zones.
pub fn heat(s: &Solution) -> Vec<[f64; 2]> {
    let Some(heat) = &s.report.heat else { return Vec::new() };
    let zoning = s.report.zoning.as_ref();
    let own = |k: usize, q: usize| zoning.and_then(|z| z.heat.get(k)).map_or(f64::INFINITY, |e| e[q]);
    (heat.rows.iter().enumerate())
        .map(|(k, r)| [r.temperature_error.unwrap_or(0.0) + own(k, 0), r.power_error + own(k, 1)])
        .collect()
}

/// Stated errors of the powers by name in light mode, W: of the exchange, added up as if they had one sign, and of the zones.
pub fn energy(s: &Solution) -> Energy {
    let unknown = [f64::INFINITY; 3];
    let mut out = match &s.report.zoning {
        Some(z) => z.energy.clone(),
        None => Energy {
            absorbed_surfaces: s.scene.surfaces().iter().map(|x| (x.name.clone(), unknown)).collect(),
            absorbed_volumes: unknown,
            absorbed_panes: unknown,
            escaped: unknown,
            ..Energy::default()
        },
    };
    let (z, error) = (&s.zones, &s.fields.error);
    let add = |to: &mut Bands, measure: f64, absorbs: [f64; 3], e: Bands| {
        (0..3).for_each(|b| to[b] += measure * absorbs[b] * e[b]);
    };
    for (i, p) in z.patches.iter().enumerate() {
        add(&mut out.absorbed_surfaces[p.surface].1, p.area, p.reflectance.map(|r| 1.0 - r), error[i]);
    }
    for (k, v) in z.voxels.iter().enumerate() {
        let a = [0, 1, 2].map(|b| v.extinction[b] * (1.0 - v.albedo[b]));
        add(&mut out.absorbed_volumes, v.volume, a, error[z.voxel_offset() + k]);
    }
    for (k, p) in z.panes.iter().enumerate() {
        let a = [0, 1, 2].map(|b| p.extinction[b] * (1.0 - p.albedo[b]));
        add(&mut out.absorbed_panes, p.area * p.thickness, a, error[z.pane_offset() + k]);
    }
    out
}
