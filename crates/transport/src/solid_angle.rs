//! Solid angle and projected solid angle of a plate seen from a point, in closed form.
//!
//! **Solid angle** of the triangle abc from the origin (van Oosterom and Strackee 1983):
//! tan(ω/2) = a·(b×c) / (|a||b||c| + (a·b)|c| + (a·c)|b| + (b·c)|a|).
//!
//! **Projected solid angle** of a polygon on a plane with normal n at the origin (Lambert 1760):
//! ∫ cosθ dω = ½ Σ_k γ_k n·ν_k, with γ_k the angle that edge k spans and ν_k the unit normal of the plane through the edge and the
//! origin. The polygon is first clipped to the half-space n·x ≥ 0.

use zonal_math::Vec3;
use zonal_scene::{Plate, PlateKind};

/// Signed solid angle of a triangle, sr: positive where the normal of (a, b, c) points **away** from the origin.
fn triangle(a: Vec3, b: Vec3, c: Vec3) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let numerator = a.dot(b.cross(c));
    let denominator = la * lb * lc + a.dot(b) * lc + a.dot(c) * lb + b.dot(c) * la;
    2.0 * numerator.atan2(denominator)
}

/// Solid angle of the plate seen from `p`, sr; negative where `p` is behind the plate, zero in its plane.
///
/// ```
/// use std::f64::consts::PI;
/// use zonal_math::{Vec3, vec3};
/// use zonal_scene::Plate;
/// use zonal_transport::solid_angle::{projected_solid_angle, solid_angle};
///
/// // A face of a cube seen from its centre: one sixth of the sphere.
/// let face = Plate::parallelogram(vec3(-1.0, -1.0, 1.0), vec3(0.0, 2.0, 0.0), vec3(2.0, 0.0, 0.0));
/// assert!((solid_angle(&face, Vec3::ZERO) - 4.0 * PI / 6.0).abs() < 1e-14);
/// // The view factor from an element at the centre to the face opposite.
/// let view_factor = projected_solid_angle(&face, Vec3::ZERO, vec3(0.0, 0.0, 1.0)) / PI;
/// assert!((view_factor - 0.554_126_4).abs() < 1e-6);
/// ```
pub fn solid_angle(plate: &Plate, p: Vec3) -> f64 {
    let a = plate.origin - p;
    let (b, d) = (a + plate.e1, a + plate.e2);
    // A point in front sees the corners counter-clockwise, with the normal towards it.
    match plate.kind {
        PlateKind::Triangle => -triangle(a, b, d),
        PlateKind::Parallelogram => parallelogram(a, b, b + plate.e2, d),
    }
}

/// −(a, b, d) − (b, c, d) of [`triangle`]. Half of each angle is the argument of a complex number; the argument of their product is
/// the sum, which is less than π.
fn parallelogram(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> f64 {
    let (la, lb, lc, ld) = (a.length(), b.length(), c.length(), d.length());
    let (across, bd) = (b.cross(d), b.dot(d));
    let y = [-a.dot(across), c.dot(across)];
    let x = [
        la * lb * ld + a.dot(b) * ld + a.dot(d) * lb + bd * la,
        lb * lc * ld + b.dot(c) * ld + bd * lc + c.dot(d) * lb,
    ];
    2.0 * (x[0] * y[1] + x[1] * y[0]).atan2(x[0] * x[1] - y[0] * y[1])
}

/// The part of a polygon of at most five corners in the half-space n·x ≥ 0, and the number of its corners, at most one more than
/// before.
pub(crate) fn clip_to_half_space(corners: &[Vec3], n: Vec3) -> ([Vec3; 6], usize) {
    let (mut poly, mut m) = ([Vec3::ZERO; 6], 0);
    for (k, &a) in corners.iter().enumerate() {
        let b = corners[(k + 1) % corners.len()];
        let (ha, hb) = (n.dot(a), n.dot(b));
        if ha >= 0.0 {
            poly[m] = a;
            m += 1;
        }
        if (ha > 0.0 && hb < 0.0) || (ha < 0.0 && hb > 0.0) {
            poly[m] = a + (b - a) * (ha / (ha - hb));
            m += 1;
        }
    }
    (poly, m)
}

/// ∫ max(0, cosθ) dω over the plate seen from `p` on a plane with unit normal `n`, sr: at most π. Both sides of the plate count.
pub fn projected_solid_angle(plate: &Plate, p: Vec3, n: Vec3) -> f64 {
    let (corners, count) = plate.corners();
    let (poly, m) = clip_to_half_space(&corners.map(|c| c - p)[..count], n);
    if m < 3 {
        return 0.0;
    }
    let mut sum = 0.0;
    for k in 0..m {
        let (a, b) = (poly[k], poly[(k + 1) % m]);
        let c = a.cross(b);
        let s = c.length();
        if s > 0.0 {
            sum += s.atan2(a.dot(b)) / s * n.dot(c);
        }
    }
    (0.5 * sum).abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use zonal_math::{low_discrepancy, vec3};

    #[test]
    fn cube_face_subtends_a_sixth_of_the_sphere() {
        let face = Plate::parallelogram(vec3(-1.0, -1.0, 1.0), vec3(0.0, 2.0, 0.0), vec3(2.0, 0.0, 0.0));
        assert!((solid_angle(&face, Vec3::ZERO) - 4.0 * PI / 6.0).abs() < 1e-14);
        assert!((solid_angle(&face.flipped(), Vec3::ZERO) + 4.0 * PI / 6.0).abs() < 1e-14);
    }

    #[test]
    fn projected_solid_angles_of_a_closed_room_sum_to_pi() {
        // The six faces of a cube, clipped to the front of a tilted element at its centre, fill the hemisphere.
        let n = vec3(0.3, -0.5, 0.8).normalized();
        let mut sum = 0.0;
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let mut o = [-1.0; 3];
                o[axis] = sign;
                let mut e = [[0.0; 3]; 2];
                e[0][(axis + 1) % 3] = 2.0;
                e[1][(axis + 2) % 3] = 2.0;
                let face =
                    Plate::parallelogram(Vec3::from_array(o), Vec3::from_array(e[0]), Vec3::from_array(e[1]));
                sum += projected_solid_angle(&face, Vec3::ZERO, n);
            }
        }
        assert!((sum - PI).abs() < 1e-13, "{sum}");
    }

    #[test]
    fn parallelogram_equals_the_sum_of_its_two_triangles() {
        let p = Plate::parallelogram(vec3(0.1, 0.2, 0.0), vec3(1.0, 0.3, 0.0), vec3(-0.4, 0.9, 0.0));
        let (b, d) = (p.origin + p.e1, p.origin + p.e2);
        let halves = [Plate::triangle(p.origin, b, d), Plate::triangle(b, b + p.e2, d)];
        for k in 0..200 {
            let ([u, v], w) =
                (low_discrepancy::sobol_2d(k, [0, 0]), low_discrepancy::sobol_third_dimension(k, 0));
            // From far away down to 1e-9 above it, on both sides.
            let height = 10f64.powf(3.0 - 12.0 * w) * if k % 2 == 0 { 1.0 } else { -1.0 };
            let at = p.at(1.4 * u - 0.2, 1.4 * v - 0.2) + vec3(0.0, 0.0, height);
            let (whole, sum) = (solid_angle(&p, at), halves.iter().map(|t| solid_angle(t, at)).sum::<f64>());
            // Near the diagonal the rounding of the triangles grows with the inverse of the height.
            let rounding = 1e-13 * sum.abs() + 2e-15 / height.abs();
            assert!((whole - sum).abs() < rounding, "{at:?}: {whole} {sum}");
        }
    }

    #[test]
    fn distant_plates_follow_the_point_formula() {
        let t = Plate::triangle(vec3(0.0, 0.0, 100.0), vec3(0.0, 1.0, 100.0), vec3(1.0, 0.0, 100.0));
        let d = t.centre();
        let point = t.area() * (d.z / d.length()) / d.length2();
        assert!((solid_angle(&t, Vec3::ZERO) / point - 1.0).abs() < 1e-4);
        let n = vec3(0.6, 0.0, 0.8);
        let want = point * n.dot(d) / d.length();
        assert!((projected_solid_angle(&t, Vec3::ZERO, n) / want - 1.0).abs() < 1e-4);
    }
}
