//! The judge of two shapes alone, with a uniform medium between them or none: one entry for whatever the crate can prove.
//!
//! | pair | who decides | methods, from cheap to dear |
//! |---|---|---|
//! | boxes and rectangles along the axes | `aligned/judge.rs`, `admissible` | moments, closed form, Gauss rules of the densities, reduced integral in cells |
//! | two plates, no medium | `polygon/plates.rs` | tensor rules, contours |
//! | two plates in a medium, plate and box | `polygon/oblique.rs` | tensor rules on cells, cut as far as the budget goes |
//!
//! Each takes the first of its methods whose **proven** bound meets the demand. A plate that is exactly a rectangle along the axes is taken as one.

use crate::aligned::{Cuboid, geometric_factor};
use crate::polygon::{plate_cuboid, plate_plate};
use crate::{Demand, Factor};
use zonal_math::{Bounded, Vec3};
use zonal_scene::{Plate, PlateKind};

/// A zone's shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A voxel, or a rectangle along the axes that faces one way.
    Box(Cuboid),
    /// A triangle or parallelogram in any position; its front is where its normal points.
    Plate(Plate),
}

/// The geometric factor (1/π) ∬ e^{−κr} cosines/r² of two shapes with nothing but a uniform medium of extinction `kappa` (1/m) between them: m⁴ (two
/// voxels), m³ (voxel and patch), m² (two patches). Grade proved.
///
/// The radius is at most `demand.tolerance` · value, or says by how much that was missed: where rounding or the budget forbids, and for boxes that touch
/// or straddle the plane of a plate in a general position.
///
/// ```
/// use zonal_exchange::aligned::Cuboid;
/// use zonal_exchange::{Demand, Shape, factor};
/// use zonal_math::vec3;
/// use zonal_scene::Plate;
/// let voxel = Shape::Box(Cuboid::voxel(vec3(0.0, 0.0, 2.0), vec3(1.0, 1.0, 3.0)));
/// let plate = Shape::Plate(Plate::triangle(vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.2), vec3(0.0, 1.0, 0.1)));
/// let f = factor(&plate, &voxel, 0.5, Demand::relative(1e-9));
/// assert!(f.bounded.radius <= 1e-9 * f.bounded.value);
/// ```
///
/// # Panics
/// On shapes without extent or with numbers that are not finite, a negative or infinite `kappa`, a tolerance that is not positive.
pub fn factor(a: &Shape, b: &Shape, kappa: f64, demand: Demand) -> Factor {
    match (exact(a), exact(b)) {
        // In one fixed order: 𝓕_ab and 𝓕_ba are the same bits.
        (Shape::Box(a), Shape::Box(b)) if comes_first(&b, &a) => {
            geometric_factor(&b, &a, kappa, demand.tolerance)
        }
        (Shape::Box(a), Shape::Box(b)) => geometric_factor(&a, &b, kappa, demand.tolerance),
        (Shape::Plate(a), Shape::Plate(b)) => plate_plate(&a, &b, kappa, demand),
        (Shape::Plate(p), Shape::Box(b)) | (Shape::Box(b), Shape::Plate(p)) => match rectangle(&b) {
            Some(q) => plate_plate(&p, &q, kappa, demand),
            None => plate_cuboid(&p, b.lo, b.hi, kappa, demand),
        },
    }
}

fn comes_first(a: &Cuboid, b: &Cuboid) -> bool {
    let corners = |c: &Cuboid| [c.lo.array(), c.hi.array()];
    let (p, q) = (corners(a), corners(b));
    let pairs = p.as_flattened().iter().zip(q.as_flattened());
    pairs.map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).is_some_and(|o| o.is_lt())
}

/// A plate that is exactly a rectangle along the axes as a box.
fn exact(s: &Shape) -> Shape {
    match s {
        Shape::Plate(p) => aligned(p).map_or(*s, Shape::Box),
        Shape::Box(_) => *s,
    }
}

fn aligned(p: &Plate) -> Option<Cuboid> {
    let axis_of = |e: Vec3| {
        let along: Vec<usize> = (0..3).filter(|&k| e[k] != 0.0).collect();
        if let [k] = along[..] { Some(k) } else { None }
    };
    let (i, j) = (axis_of(p.e1)?, axis_of(p.e2)?);
    if p.kind != PlateKind::Parallelogram || i == j {
        return None;
    }
    let (mut lo, mut hi) = (p.origin.array(), p.origin.array());
    for (k, e) in [(i, p.e1[i]), (j, p.e2[j])] {
        let end = exact_sum(p.origin[k], e)?;
        (lo[k], hi[k]) = (p.origin[k].min(end), p.origin[k].max(end));
    }
    let axis = 3 - i - j;
    let sign = if p.e1.cross(p.e2)[axis] > 0.0 { 1 } else { -1 };
    Some(Cuboid::patch(Vec3::from_array(lo), Vec3::from_array(hi), axis, sign))
}

/// The sum of two numbers where it is one without rounding (Knuth's error term vanishes).
fn exact_sum(a: f64, b: f64) -> Option<f64> {
    let s = a + b;
    let v = s - a;
    let error = (a - (s - v)) + (b - v);
    (error == 0.0).then_some(s)
}

/// A patch along the axes as a plate; its edges, differences of its corners, carry half an ulp each. None for a voxel.
fn rectangle(c: &Cuboid) -> Option<Plate> {
    let (axis, sign) = c.normal?;
    let edge = |k: usize| {
        let mut e = [0.0; 3];
        e[k] = c.hi[k] - c.lo[k];
        Vec3::from_array(e)
    };
    let (e, f) = (edge((axis + 1) % 3), edge((axis + 2) % 3));
    Some(if sign > 0 { Plate::parallelogram(c.lo, e, f) } else { Plate::parallelogram(c.lo, f, e) })
}

/// The sum of the parts of a zone: what additivity demands of [`factor`].
pub fn sum<'s>(parts: impl IntoIterator<Item = &'s Shape>, b: &Shape, kappa: f64, demand: Demand) -> Bounded {
    parts.into_iter().map(|p| factor(p, b, kappa, demand).bounded).fold(Bounded::ZERO, |s, f| s + f)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Method;
    use zonal_math::vec3;

    const DEMAND: Demand = Demand { tolerance: 1e-8, budget: 1_000_000 };

    fn floor() -> Plate {
        Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0))
    }

    #[test]
    fn a_rectangle_is_one_however_it_is_given() {
        let boxed = Cuboid::patch(Vec3::ZERO, vec3(1.0, 2.0, 0.0), 2, 1);
        assert_eq!(aligned(&floor()), Some(boxed));
        assert_eq!(aligned(&floor().flipped()).and_then(|c| c.normal), Some((2, -1)));
        assert_eq!(
            rectangle(&boxed).map(|p| (p.centre(), p.normal())),
            Some((floor().centre(), floor().normal()))
        );
        let voxel = Shape::Box(Cuboid::voxel(vec3(0.5, 0.0, 1.0), vec3(1.5, 1.0, 2.0)));
        let (f, g) = (Shape::Plate(floor()), Shape::Box(boxed));
        assert_eq!(factor(&f, &voxel, 0.7, DEMAND), factor(&g, &voxel, 0.7, DEMAND));
        // A sum that rounds is not taken for exact: 0.1 + 0.2.
        let rounded = Plate::parallelogram(vec3(0.1, 0.0, 0.0), vec3(0.2, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        assert_eq!(aligned(&rounded), None);
    }

    #[test]
    fn triangles_add_up_to_their_rectangle_for_every_partner() {
        let (o, e, f) = (floor().origin, floor().e1, floor().e2);
        let halves =
            [Plate::triangle(o, o + e, o + e + f), Plate::triangle(o, o + e + f, o + f)].map(Shape::Plate);
        let tilted = Plate::triangle(vec3(0.0, 0.0, 1.0), vec3(1.0, 0.2, 1.4), vec3(0.1, 1.0, 1.2)).flipped();
        let partners = [
            Shape::Plate(tilted),
            Shape::Box(Cuboid::patch(vec3(-1.0, 0.0, 0.5), vec3(-1.0, 1.0, 1.5), 0, 1)),
            Shape::Box(Cuboid::voxel(vec3(0.5, 0.5, 1.0), vec3(1.5, 1.5, 1.75))),
        ];
        // A plate and a voxel take rules in five dimensions.
        let five = Demand { tolerance: 1e-5, ..DEMAND };
        for (partner, demand) in partners.iter().zip([DEMAND, DEMAND, five]) {
            for kappa in [0.0, 0.8] {
                let whole = factor(&Shape::Plate(floor()), partner, kappa, demand);
                let parts = sum(&halves, partner, kappa, demand);
                let off = (whole.bounded.value - parts.value).abs();
                assert!(whole.bounded.value > 0.0 && off <= whole.bounded.radius + parts.radius, "{off:e}");
                assert!(
                    parts.radius <= 1.01 * demand.tolerance * parts.value,
                    "{partner:?} {kappa} {parts:?}"
                );
                assert_eq!(factor(partner, &Shape::Plate(floor()), kappa, demand), whole);
            }
        }
        assert_eq!(factor(&halves[0], &halves[1], 0.0, DEMAND).method, Method::Unseen);
    }
}
