//! Occluders whose images adjoin: one plate as long as all represented images, in place of the images.
//!
//! A parallelogram with edges along a period, at least as long, covers with its images the parallelogram that is stretched by K periods to both sides. Other
//! occluders keep their images.

use crate::geometry::occluders::MergedOccluder;
use crate::periods::PeriodicImages;
use zonal_exchange::polygon::visible::{ConvexBody, ConvexPolygon};
use zonal_math::Vec3;

/// An occluder for all represented images along some axes, and these axes as bits.
pub(crate) fn stretched(
    occluder: &MergedOccluder,
    images: &PeriodicImages,
    contact: f64,
) -> (MergedOccluder, u8) {
    let mut made = (occluder.clone(), 0);
    for k in 0..2 {
        if images.periods[k] > 0.0
            && let Some(body) = stretched_along(&made.0.body, images, k, contact)
        {
            made = (MergedOccluder { body, has_opening: false }, made.1 | 1 << k);
        }
    }
    made
}

/// The corners of a parallelogram from one that begins an edge along an axis: the first and the third edge are along it.
pub(crate) fn sides_along(corners: &[Vec3], axis: usize, contact: f64) -> Option<[Vec3; 4]> {
    let [a, b, c, d] = *corners else { return None };
    let quads = [[a, b, c, d], [b, c, d, a]];
    quads.into_iter().find(|q| {
        let (e, f) = (q[1] - q[0], q[2] - q[3]);
        let mut rest = e.array();
        rest[axis] = 0.0;
        Vec3::from_array(rest).max_abs() <= contact && (e - f).max_abs() <= 2.0 * contact
    })
}

fn stretched_along(body: &ConvexBody, images: &PeriodicImages, k: usize, contact: f64) -> Option<ConvexBody> {
    if !body.is_plate() {
        return None;
    }
    let axis = images.axes[k];
    let [a, b, _, d] = sides_along(body.corners(), axis, contact)?;
    let length = (b - a).array()[axis];
    if length.abs() < images.periods[k] - contact {
        return None;
    }
    let more = length.signum() * f64::from(images.counts[k]) * images.periods[k];
    let moved = |p: Vec3, by: f64| {
        let mut x = p.array();
        x[axis] += by;
        Vec3::from_array(x)
    };
    let corners = [moved(a, -more), moved(a, length + more), moved(d, length + more), moved(d, -more)];
    ConvexPolygon::new(corners.to_vec()).map(|p| ConvexBody::plate(&p))
}
