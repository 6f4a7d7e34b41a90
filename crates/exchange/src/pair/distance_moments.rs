//! Geometric factors of zones without attenuation and visibility, with the moments of their distance.

use super::exchange::Exchange;
use super::prepared_zone::{PreparedShape, PreparedZone, aligned_rectangle};
use crate::aligned::Cuboid;
use crate::solid_angle_quadrature::{self, DistanceMoments};
use zonal_math::Vec3;
use zonal_scene::{Plate, Sides};

/// Radius of a plate factor that suffices in any case, relative to the smaller area.
pub(super) const PLATE_ERROR_OVER_AREA: f64 = 1e-12;
/// Thickness of a cuboid's part on one side of a pane, relative to the cuboid, below which the part is left out.
const MIN_RELATIVE_THICKNESS: f64 = 1e-12;

impl Exchange<'_> {
    /// The unattenuated factor of two zones other than cut voxels.
    pub(super) fn distance_moments(&self, a: &PreparedZone, b: &PreparedZone) -> DistanceMoments {
        if let (Some(p), Some(q)) = (&a.aligned, &b.aligned)
            && !matches!(a.shape, PreparedShape::Plate { pane: Some(_), .. })
            && !matches!(b.shape, PreparedShape::Plate { pane: Some(_), .. })
        {
            return self.cache.get_cumulants(p, q).into();
        }
        let tolerance = self.tolerance;
        match (&a.shape, &b.shape) {
            (PreparedShape::Plate { plate: p, pane: u }, PreparedShape::Plate { plate: q, pane: v }) => {
                solid_angle_quadrature::plate_plate(
                    p,
                    q,
                    [solid_angle_quadrature::sides_of_pane(*u), solid_angle_quadrature::sides_of_pane(*v)],
                    tolerance,
                )
            }
            (PreparedShape::Plate { plate, pane }, _) => {
                self.plate_and_cuboid(plate, solid_angle_quadrature::sides_of_pane(*pane), b)
            }
            (_, PreparedShape::Plate { plate, pane }) => {
                self.plate_and_cuboid(plate, solid_angle_quadrature::sides_of_pane(*pane), a)
            }
            _ => unreachable!("two cuboids are aligned"),
        }
    }

    /// The unattenuated factor of the `sides` of a plate and a cuboid. The sides of an axis-aligned pane are two axis-aligned patches, each in
    /// front of its part of the cuboid.
    fn plate_and_cuboid(&self, plate: &Plate, sides: Sides, b: &PreparedZone) -> DistanceMoments {
        let Some(rectangle) =
            (if sides == Sides::Both { aligned_rectangle(plate, plate.normal()) } else { None })
        else {
            return solid_angle_quadrature::plate_cuboid(plate, b.lo, b.hi, sides, self.tolerance);
        };
        let axis = rectangle.normal.map_or(0, |(axis, _)| axis);
        let level = rectangle.lo[axis];
        let side = |sign: i8| {
            let (mut lo, mut hi) = (b.lo.array(), b.hi.array());
            if sign > 0 {
                lo[axis] = lo[axis].max(level);
            } else {
                hi[axis] = hi[axis].min(level);
            }
            if hi[axis] - lo[axis] <= MIN_RELATIVE_THICKNESS * (b.hi[axis] - b.lo[axis]) {
                return DistanceMoments::ZERO;
            }
            let part = Cuboid { lo: Vec3::from_array(lo), hi: Vec3::from_array(hi), normal: None };
            self.cache.get_cumulants(&Cuboid { normal: Some((axis, sign)), ..rectangle }, &part).into()
        };
        side(1).union(&side(-1))
    }
}
