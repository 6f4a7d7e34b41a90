//! Periodic geometry: displacements of images, and the directions whose rays may pass all of them unseen.
//!
//! Images up to K periods away in each direction are represented. A ray that rises by more than the height H of the geometry over K periods
//! has left it; a ray of smaller slope that meets nothing is unresolved. Its share is part of the sky factor and, as a whole, of its
//! radius.

use crate::bounds::Bounds;
use crate::settings::ViewFactorSettings;
use zonal_math::Vec3;

/// Largest slope of unresolved directions that the number of images aims at.
const GRAZING_SLOPE: f64 = 0.05;
/// Images on each side along one axis, at most.
const MAX_IMAGES: i32 = 24;

/// Displacements, the first of them zero, and the slope of unresolved directions along each axis.
#[derive(Clone, Debug)]
pub(crate) struct PeriodicImages {
    pub shifts: Vec<Vec3>,
    /// |rise|/|run| below which a ray along this axis is unresolved; zero along axes without a period.
    pub grazing_slope: [f64; 3],
}

impl PeriodicImages {
    pub(crate) fn new(settings: &ViewFactorSettings, extent: &Bounds) -> PeriodicImages {
        let axes = settings.horizontal_axes();
        let size = (extent.hi - extent.lo).array();
        let rise = size[settings.up];
        let mut counts = [0; 2];
        let mut grazing_slope = [0.0; 3];
        for k in 0..2 {
            let Some(period) = settings.periods[k] else { continue };
            // The other axis: without a period, rays leave it after its extent at the latest.
            let across = if settings.periods[1 - k].is_none() { size[axes[1 - k]] } else { 0.0 };
            let reach = (rise / GRAZING_SLOPE).max(across);
            counts[k] = ((reach / period).ceil().max(1.0) as i32).min(MAX_IMAGES);
            grazing_slope[axes[k]] = rise / (f64::from(counts[k]) * period);
        }
        let mut shifts = vec![Vec3::ZERO];
        for i in -counts[0]..=counts[0] {
            for j in -counts[1]..=counts[1] {
                let mut by = [0.0; 3];
                by[axes[0]] = f64::from(i) * settings.periods[0].unwrap_or(0.0);
                by[axes[1]] = f64::from(j) * settings.periods[1].unwrap_or(0.0);
                if (i, j) != (0, 0) {
                    shifts.push(Vec3::from_array(by));
                }
            }
        }
        PeriodicImages { shifts, grazing_slope }
    }

    /// The displacements of one of each two opposite images, by index; zero comes first.
    pub(crate) fn half(&self) -> impl Iterator<Item = u32> + '_ {
        let positive = |v: &Vec3| v.array().iter().find(|x| **x != 0.0).is_none_or(|x| *x > 0.0);
        self.shifts.iter().enumerate().filter(move |(_, v)| positive(v)).map(|(k, _)| k as u32)
    }
}
