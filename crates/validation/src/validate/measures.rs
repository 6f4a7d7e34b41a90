//! Quantities that cases compare: means over walls, values of voxels, root mean squares.

use zonal_scene::{Bands, Solution};

/// Means over a wall, weighted by area: irradiance and radiosity, W/m².
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallMeans {
    /// Irradiance H.
    pub incident: f64,
    /// Radiosity B.
    pub radiosity: f64,
}

impl WallMeans {
    /// The mean over the surfaces whose name ends in `face`, in the first band.
    pub(crate) fn of(s: &Solution, face: &str) -> WallMeans {
        let (mut area, mut h, mut b) = (0.0, 0.0, 0.0);
        for (i, p) in s.zones.patches.iter().enumerate() {
            if s.scene.surfaces()[p.surface].name.ends_with(face) {
                area += p.area;
                h += p.area * s.fields.incident[i].first();
                b += p.area * s.fields.radiosity[i].first();
            }
        }
        WallMeans { incident: h / area, radiosity: b / area }
    }

    /// Net flux out of the wall, W/m².
    pub(crate) fn net(&self) -> f64 {
        self.radiosity - self.incident
    }
}

/// Net flux out of the walls whose name ends in `face`, of a solution in thermal mode, W/m².
pub(crate) fn net_flux(s: &Solution, face: &str) -> f64 {
    let rows = s.report.heat.iter().flat_map(|h| &h.rows).filter(|r| r.name.ends_with(face));
    let (power, size) = rows.fold((0.0, 0.0), |(p, a), r| (p + r.power, a + r.size));
    power / size
}

/// The temperature of a voxel, K, of a solution in thermal mode.
pub(crate) fn voxel_temperature(s: &Solution, c: [usize; 3]) -> f64 {
    let index = s.scene.voxel_grid().map_or(0, |m| m.index(c));
    let heat = s.fields.heat.as_ref();
    heat.and_then(|h| h.temperature.get(s.zones.voxel_offset() + index)).map_or(f64::NAN, |t| *t)
}

/// The values of a field of voxels, by the coordinates of the cell, in the first band.
pub(crate) fn voxel_value(s: &Solution, field: &[Bands], c: [usize; 3]) -> f64 {
    let index = s.scene.voxel_grid().map_or(0, |m| m.index(c));
    field.get(s.zones.voxel_offset() + index).map_or(f64::NAN, |v| v.first())
}

/// Root mean square.
pub(crate) fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (n, sum) = values.fold((0usize, 0.0), |(n, s), x| (n + 1, s + x * x));
    (sum / n.max(1) as f64).sqrt()
}
