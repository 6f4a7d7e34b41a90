//! Convex polygons prepared for factors without a medium: triangles and parallelograms as they are, others as fans of triangles.
//!
//! 𝓕 of two polygons is the sum over their parts; each part takes the cheapest method that is proved to meet its share of the request
//! (`plate_pair.rs`).

use super::plate_geometry::PlateGeometry;
use super::plate_pair::{self, RadiusGoal};
use super::visible::ConvexPolygon;
use zonal_math::{Bounded, Vec3};
use zonal_scene::Plate;

/// Distance of the fourth corner from that of a parallelogram, relative to the longest diagonal.
const PARALLELOGRAM_SLACK: f64 = 1e-13;

/// A convex polygon and its parts.
#[derive(Clone, Debug)]
pub struct PreparedPolygon {
    polygon: ConvexPolygon,
    parts: Vec<PlateGeometry>,
}

impl PreparedPolygon {
    /// Prepares a polygon.
    pub fn new(polygon: ConvexPolygon) -> PreparedPolygon {
        let parts = plates(polygon.corners()).iter().map(PlateGeometry::new).collect();
        PreparedPolygon { polygon, parts }
    }

    /// The polygon.
    pub fn polygon(&self) -> &ConvexPolygon {
        &self.polygon
    }

    /// 𝓕 of the fronts of two polygons with nothing between them, m², to a radius of max(`relative` 𝓕, `absolute`) where rounding
    /// allows. Grade proved.
    pub fn exchange(&self, other: &PreparedPolygon, relative: f64, absolute: f64) -> Bounded {
        let share = absolute / (self.parts.len() * other.parts.len()) as f64;
        let goal = RadiusGoal { relative, absolute: share.max(1e-300) };
        let pairs = self.parts.iter().flat_map(|a| other.parts.iter().map(move |b| (a, b)));
        pairs.fold(Bounded::ZERO, |sum, (a, b)| sum + plate_pair::factor_without_medium(a, b, goal).bounded)
    }
}

fn plates(c: &[Vec3]) -> Vec<Plate> {
    if let [a, b, _, d] = c {
        let size = (c[2] - *a).length().max((*d - *b).length());
        if (*a + (c[2] - *a) - *b - (*d - *a)).max_abs() <= PARALLELOGRAM_SLACK * size {
            return vec![Plate::parallelogram(*a, *b - *a, *d - *a)];
        }
    }
    let triangles = (2..c.len()).map(|k| Plate::triangle(c[0], c[k - 1], c[k]));
    triangles.filter(|p| p.area() > 0.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    #[test]
    fn parts_of_a_quadrilateral_sum_to_the_whole() {
        let top = |z: f64| {
            ConvexPolygon::new(vec![
                vec3(0.0, 0.0, z),
                vec3(0.0, 1.0, z),
                vec3(1.0, 1.0, z),
                vec3(1.0, 0.0, z),
            ])
        };
        let top = PreparedPolygon::new(top(1.0).expect("a square"));
        let square = PreparedPolygon::new(
            ConvexPolygon::new(
                [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| vec3(x, y, 0.0)).to_vec(),
            )
            .expect("a square"),
        );
        assert_eq!((top.parts.len(), square.parts.len()), (1, 1));
        // The square as two quadrilaterals that are no parallelograms.
        let piece = |c: [[f64; 2]; 4]| {
            let p = ConvexPolygon::new(c.map(|[x, y]| vec3(x, y, 0.0)).to_vec()).expect("a quadrilateral");
            PreparedPolygon::new(p)
        };
        let left = piece([[0.0, 0.0], [0.3, 0.0], [0.6, 1.0], [0.0, 1.0]]);
        let right = piece([[0.3, 0.0], [1.0, 0.0], [1.0, 1.0], [0.6, 1.0]]);
        assert_eq!(left.parts.len(), 2);
        let whole = top.exchange(&square, 1e-9, 0.0);
        let sum = left.exchange(&top, 1e-9, 0.0) + top.exchange(&right, 1e-9, 0.0);
        assert!((whole.value - sum.value).abs() <= whole.radius + sum.radius, "{whole:?} {sum:?}");
        assert!((whole.value - 0.199_824_895_698).abs() < 1e-9);
    }
}
