//! Points of surfaces that receive light in pictures: flat, or on the curved surface for which a facet stands.
//!
//! On a curved surface ([`zonal_scene::ShadingNormals`]) the normal n between those of the corners takes the place of that of the facet, n_f, and the point lies on the
//! surface through the corners. Light from below the facet, n_f·ω < 0, reaches that point only where no surface stands between, and the point is above the facet: no
//! light comes through a wall. A gather turns such directions up, ω − 2(n_f·ω) n_f, so that a uniform surrounding gives the same irradiance for every n. Where something
//! stands between facet and curved surface, as at a contact, the facet is shaded as it is.

use zonal_math::Vec3;
use zonal_scene::{ShadedPoint, SidedFacet};
use zonal_transport::Transport;

/// Least height of a point of a curved surface above its facet, over the diameter of the facet.
const LIFT_SHARE: f64 = 1e-4;
/// The same over the diagonal of the scene: well above the distance within which a ray counts as on a facet.
const LIFT_OF_DIAGONAL: f64 = 1e-7;

/// A point that receives light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReceiverPoint {
    /// Position, m.
    pub point: Vec3,
    /// Unit normal for shading.
    pub normal: Vec3,
    /// Unit normal of the facet, on the same side.
    pub facet_normal: Vec3,
}

impl ReceiverPoint {
    /// A point of a flat surface.
    pub(crate) fn flat(point: Vec3, normal: Vec3) -> ReceiverPoint {
        ReceiverPoint { point, normal, facet_normal: normal }
    }

    /// The point `point` at parameters `uv` of a facet, of the side with the unit normal `facet_normal`, with the normal map of the surface.
    pub(crate) fn on_facet(
        transport: &Transport,
        facet: usize,
        uv: [f64; 2],
        point: Vec3,
        facet_normal: Vec3,
    ) -> ReceiverPoint {
        let shaded = |side, lift| transport.scene().shaded_point(side, uv, lift);
        ReceiverPoint::raised(transport, facet, point, facet_normal, shaded)
    }

    /// The point `point` of a facet, of the side with the unit normal `facet_normal`, without normal maps: values at nodes and vertices stand for all the surface
    /// about them.
    pub(crate) fn without_map(
        transport: &Transport,
        facet: usize,
        point: Vec3,
        facet_normal: Vec3,
    ) -> ReceiverPoint {
        let curved = |side, lift| {
            let uv = transport.scene().facets()[facet].plate.parameters(point);
            transport.scene().curved_point(side, uv, lift)
        };
        ReceiverPoint::raised(transport, facet, point, facet_normal, curved)
    }

    /// The point that `shaded` gives for a side of a facet and a height above it, m.
    fn raised(
        transport: &Transport,
        facet: usize,
        point: Vec3,
        facet_normal: Vec3,
        shaded: impl Fn(SidedFacet, f64) -> Option<ShadedPoint>,
    ) -> ReceiverPoint {
        let scene = transport.scene();
        let flat = ReceiverPoint::flat(point, facet_normal);
        if scene.shading().is_empty() {
            return flat;
        }
        let plate = &scene.facets()[facet].plate;
        let front = plate.normal().dot(facet_normal) > 0.0;
        let lift = LIFT_SHARE * plate.diameter() + LIFT_OF_DIAGONAL * scene.diagonal();
        match shaded(SidedFacet { facet, front }, lift) {
            Some(at) if !transport.occluded(point, at.point) => {
                ReceiverPoint { point: at.point, normal: at.normal, facet_normal }
            }
            _ => flat,
        }
    }

    /// A direction of the hemisphere about the normal, turned up where it points below the facet.
    pub(crate) fn above_facet(&self, direction: Vec3) -> Vec3 {
        let cos = direction.dot(self.facet_normal);
        if cos >= 0.0 || self.normal == self.facet_normal {
            return direction;
        }
        direction - self.facet_normal * (2.0 * cos)
    }
}
