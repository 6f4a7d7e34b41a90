//! Dispatch of two zone shapes to the proved methods, without obstructions, with a uniform medium between them or none.
//!
//! | pair | selection | methods by increasing cost |
//! |---|---|---|
//! | boxes and rectangles along the axes | `aligned/method_selection.rs`, `select_method` | moments, closed form, Gauss rules of the densities, reduced integral in cells |
//! | two plates, no medium | `polygon/plate_pair.rs` | tensor rules, contours |
//! | two plates in a medium, plate and box | `polygon/cell_rules.rs` | tensor rules on cells, cut within the limit of evaluations |
//!
//! Each selects the first method whose **proved** bound meets the requested accuracy. A plate that is exactly an axis-aligned rectangle is treated
//! as one.

use crate::aligned::{Cuboid, geometric_factor};
use crate::polygon::{plate_cuboid, plate_plate};
use crate::{AccuracyRequest, Factor};
use zonal_math::Vec3;
use zonal_scene::{Plate, PlateKind};

/// The shape of a zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ZoneShape {
    /// A voxel, or a rectangle along the axes that faces one way.
    Box(Cuboid),
    /// A triangle or parallelogram in any position; its front is where its normal points.
    Plate(Plate),
}

/// The geometric factor (1/π) ∬ e^{−κr} cosines/r² of two shapes with at most a uniform medium of extinction `kappa` (1/m) between them: m⁴ (two
/// voxels), m³ (voxel and patch), m² (two patches). Grade proved.
///
/// The radius is at most `accuracy.tolerance` · value. It is larger where rounding or the limit of evaluations forbids, and for boxes that touch
/// or straddle the plane of a plate in a general position.
///
/// ```
/// use zonal_exchange::aligned::Cuboid;
/// use zonal_exchange::{AccuracyRequest, ZoneShape, factor};
/// use zonal_math::vec3;
/// use zonal_scene::Plate;
/// let voxel = ZoneShape::Box(Cuboid::voxel(vec3(0.0, 0.0, 2.0), vec3(1.0, 1.0, 3.0)));
/// let plate = ZoneShape::Plate(Plate::triangle(vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.2), vec3(0.0, 1.0, 0.1)));
/// let f = factor(&plate, &voxel, 0.5, AccuracyRequest::relative(1e-9));
/// assert!(f.bounded.radius <= 1e-9 * f.bounded.value);
/// ```
///
/// # Panics
/// On shapes without extent or with numbers that are not finite, a negative or infinite `kappa`, a tolerance that is not positive.
pub fn factor(a: &ZoneShape, b: &ZoneShape, kappa: f64, accuracy: AccuracyRequest) -> Factor {
    match (as_aligned_box(a), as_aligned_box(b)) {
        // One canonical order makes 𝓕_ab and 𝓕_ba identical to the bit.
        (ZoneShape::Box(a), ZoneShape::Box(b)) if is_canonical_order(&b, &a) => {
            geometric_factor(&b, &a, kappa, accuracy.tolerance)
        }
        (ZoneShape::Box(a), ZoneShape::Box(b)) => geometric_factor(&a, &b, kappa, accuracy.tolerance),
        (ZoneShape::Plate(a), ZoneShape::Plate(b)) => plate_plate(&a, &b, kappa, accuracy),
        (ZoneShape::Plate(p), ZoneShape::Box(b)) | (ZoneShape::Box(b), ZoneShape::Plate(p)) => {
            match rectangle_plate(&b) {
                Some(q) => plate_plate(&p, &q, kappa, accuracy),
                None => plate_cuboid(&p, b.lo, b.hi, kappa, accuracy),
            }
        }
    }
}

fn is_canonical_order(a: &Cuboid, b: &Cuboid) -> bool {
    let corners = |c: &Cuboid| [c.lo.array(), c.hi.array()];
    let (p, q) = (corners(a), corners(b));
    let pairs = p.as_flattened().iter().zip(q.as_flattened());
    pairs.map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).is_some_and(|o| o.is_lt())
}

/// A plate that is exactly a rectangle along the axes as a box.
fn as_aligned_box(s: &ZoneShape) -> ZoneShape {
    match s {
        ZoneShape::Plate(p) => aligned_rectangle(p).map_or(*s, ZoneShape::Box),
        ZoneShape::Box(_) => *s,
    }
}

fn aligned_rectangle(p: &Plate) -> Option<Cuboid> {
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
fn rectangle_plate(c: &Cuboid) -> Option<Plate> {
    let (axis, sign) = c.normal?;
    let edge = |k: usize| {
        let mut e = [0.0; 3];
        e[k] = c.hi[k] - c.lo[k];
        Vec3::from_array(e)
    };
    let (e, f) = (edge((axis + 1) % 3), edge((axis + 2) % 3));
    Some(if sign > 0 { Plate::parallelogram(c.lo, e, f) } else { Plate::parallelogram(c.lo, f, e) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Method;
    use zonal_math::{Bounded, vec3};

    const DEMAND: AccuracyRequest = AccuracyRequest { tolerance: 1e-8, max_evaluations: 1_000_000 };

    fn floor() -> Plate {
        Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0))
    }

    #[test]
    fn rectangle_as_plate_and_as_box_has_one_factor() {
        let boxed = Cuboid::patch(Vec3::ZERO, vec3(1.0, 2.0, 0.0), 2, 1);
        assert_eq!(aligned_rectangle(&floor()), Some(boxed));
        assert_eq!(aligned_rectangle(&floor().flipped()).and_then(|c| c.normal), Some((2, -1)));
        assert_eq!(
            rectangle_plate(&boxed).map(|p| (p.centre(), p.normal())),
            Some((floor().centre(), floor().normal()))
        );
        let voxel = ZoneShape::Box(Cuboid::voxel(vec3(0.5, 0.0, 1.0), vec3(1.5, 1.0, 2.0)));
        let (f, g) = (ZoneShape::Plate(floor()), ZoneShape::Box(boxed));
        assert_eq!(factor(&f, &voxel, 0.7, DEMAND), factor(&g, &voxel, 0.7, DEMAND));
        // A sum that rounds is not taken for exact: 0.1 + 0.2.
        let rounded = Plate::parallelogram(vec3(0.1, 0.0, 0.0), vec3(0.2, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        assert_eq!(aligned_rectangle(&rounded), None);
    }

    #[test]
    fn triangles_sum_to_rectangle_for_every_shape() {
        let (o, e, f) = (floor().origin, floor().e1, floor().e2);
        let halves = [Plate::triangle(o, o + e, o + e + f), Plate::triangle(o, o + e + f, o + f)]
            .map(ZoneShape::Plate);
        let tilted = Plate::triangle(vec3(0.0, 0.0, 1.0), vec3(1.0, 0.2, 1.4), vec3(0.1, 1.0, 1.2)).flipped();
        let partners = [
            ZoneShape::Plate(tilted),
            ZoneShape::Box(Cuboid::patch(vec3(-1.0, 0.0, 0.5), vec3(-1.0, 1.0, 1.5), 0, 1)),
            ZoneShape::Box(Cuboid::voxel(vec3(0.5, 0.5, 1.0), vec3(1.5, 1.5, 1.75))),
        ];
        // A plate and a voxel take rules in five dimensions.
        let five = AccuracyRequest { tolerance: 1e-5, ..DEMAND };
        for (partner, accuracy) in partners.iter().zip([DEMAND, DEMAND, five]) {
            for kappa in [0.0, 0.8] {
                let whole = factor(&ZoneShape::Plate(floor()), partner, kappa, accuracy);
                let parts = halves.map(|h| factor(&h, partner, kappa, accuracy).bounded);
                let parts = parts.into_iter().fold(Bounded::ZERO, |s, f| s + f);
                let off = (whole.bounded.value - parts.value).abs();
                assert!(whole.bounded.value > 0.0 && off <= whole.bounded.radius + parts.radius, "{off:e}");
                assert!(
                    parts.radius <= 1.01 * accuracy.tolerance * parts.value,
                    "{partner:?} {kappa} {parts:?}"
                );
                assert_eq!(factor(partner, &ZoneShape::Plate(floor()), kappa, accuracy), whole);
            }
        }
        assert_eq!(factor(&halves[0], &halves[1], 0.0, DEMAND).method, Method::NotVisible);
    }
}
