//! Planes and convexity of surfaces; bases and combinations.

use super::model::{View3dSurface, View3dSurfaceKind};
use crate::input::reading::error::FileFault;
use zonal_math::Vec3;

/// Largest distance of a corner from the plane of its surface, relative to the surface's radius.
const MAX_WARP: f64 = 3e-5;
/// Smallest area vector of a corner relative to the square of the longest distance of two corners.
const MIN_RELATIVE_AREA: f64 = 1e-12;
/// Largest distance of a corner of a part from the plane of its base, relative to the part's radius.
const MAX_DISTANCE_FROM_BASE: f64 = 1e-5;
/// Largest distance of a corner of a part outside its base, relative to the base's radius.
const MAX_DISTANCE_OUTSIDE: f64 = 1e-5;
/// Smallest cosine of the angle between normals that are parallel.
const MIN_PARALLEL_COSINE: f64 = 0.999;

/// A surface with its line and plane; base and combination are numbers from 1, 0 for none.
pub(super) struct NumberedSurface {
    pub(super) surface: View3dSurface,
    pub(super) line: usize,
    pub(super) plane: SurfacePlane,
    pub(super) base: usize,
    pub(super) combined_with: usize,
}

/// The plane of a surface.
pub(super) struct SurfacePlane {
    normal: Vec3,
    centre: Vec3,
    /// Largest distance of a corner from the centre.
    radius: f64,
    /// Largest distance of a corner from the plane relative to the radius.
    pub(super) warp: f64,
}

/// The plane of three or four corners; an error states the defect and the remedy.
pub(super) fn surface_plane(corners: &[Vec3]) -> Result<SurfacePlane, String> {
    let n = corners.len();
    let centre = corners.iter().fold(Vec3::ZERO, |sum, p| sum + *p) / n as f64;
    let radius = corners.iter().map(|p| (*p - centre).length()).fold(0.0, f64::max);
    let corner_vectors: Vec<Vec3> = (0..n)
        .map(|k| (corners[(k + 1) % n] - corners[k]).cross(corners[(k + n - 1) % n] - corners[k]))
        .collect();
    let sum = corner_vectors.iter().fold(Vec3::ZERO, |sum, v| sum + *v);
    let least = MIN_RELATIVE_AREA * 4.0 * radius * radius;
    if !(corner_vectors.iter().all(|v| v.length() > least) && sum.length() > least && sum.is_finite()) {
        return Err(
            "three of its corners lie on a line, or cross; mend its vertices, or write 0 for the fourth of a triangle".into(),
        );
    }
    let normal = sum / sum.length();
    let distances = corners.iter().map(|p| (*p - centre).dot(normal).abs());
    let warp = distances.fold(0.0, f64::max) / radius;
    if warp > MAX_WARP {
        return Err("its four corners are not in a plane; cut it into two triangles".into());
    }
    // The corner vectors of a triangle are equal but for rounding.
    if n > 3 && corner_vectors.iter().any(|v| v.dot(normal) < MIN_PARALLEL_COSINE * v.length()) {
        return Err("it is not convex; order its corners around it, or cut it into two triangles".into());
    }
    Ok(SurfacePlane { normal, centre, radius, warp })
}

/// Checks bases and combinations.
pub(super) fn check_references(file: &str, surfaces: &[NumberedSurface]) -> Result<(), FileFault> {
    for (i, s) in surfaces.iter().enumerate() {
        check_combination(i + 1, s, surfaces)
            .and_then(|()| check_base(i + 1, s, surfaces))
            .map_err(|message| FileFault::new(file, s.line, format!("surface {}: {message}", i + 1)))?;
    }
    Ok(())
}

fn check_combination(number: usize, s: &NumberedSurface, surfaces: &[NumberedSurface]) -> Result<(), String> {
    let with = s.combined_with;
    if with == 0 {
        return Ok(());
    }
    if s.surface.kind != View3dSurfaceKind::Radiating {
        return Err("masks and null surfaces are not combined; write 0 as its combination".into());
    }
    if with >= number {
        return Err(format!(
            "it is combined with surface {with}, which does not precede it; combine it with an earlier one"
        ));
    }
    let other = &surfaces[with - 1];
    if other.surface.kind != View3dSurfaceKind::Radiating {
        return Err(format!(
            "it is combined with surface {with}, which does not radiate; combine it with an S surface"
        ));
    }
    if other.combined_with != 0 {
        return Err(format!(
            "it is combined with surface {with}, which is combined itself; combine both with surface {}",
            other.combined_with
        ));
    }
    Ok(())
}

fn check_base(number: usize, s: &NumberedSurface, surfaces: &[NumberedSurface]) -> Result<(), String> {
    use View3dSurfaceKind::{Mask, Null, Obstruction};
    let covers = matches!(s.surface.kind, Mask | Null);
    if s.base == 0 {
        return if covers {
            Err("a mask or null surface has a base; write the number of the surface that it covers".into())
        } else {
            Ok(())
        };
    }
    let Some(base) = surfaces.get(s.base - 1) else {
        return Err(format!("base {} is none of the {} surfaces; mend its number", s.base, surfaces.len()));
    };
    let precedes = s.base < number || (!covers && base.surface.kind == Obstruction);
    if !precedes {
        return Err(format!("base {} does not precede it; put the base first", s.base));
    }
    let distance = |p: &Vec3| (*p - base.plane.centre).dot(base.plane.normal).abs();
    if s.surface.corners.iter().any(|p| distance(p) > MAX_DISTANCE_FROM_BASE * s.plane.radius) {
        return Err(format!("it is not in the plane of its base {}; mend its vertices", s.base));
    }
    let cosine = s.plane.normal.dot(base.plane.normal);
    if !covers && cosine < MIN_PARALLEL_COSINE {
        return Err(format!("it faces away from its base {}; reverse the order of its vertices", s.base));
    }
    if covers && cosine > -MIN_PARALLEL_COSINE {
        return Err(format!(
            "a mask or null surface faces its base {}; reverse the order of its vertices",
            s.base
        ));
    }
    if !s.surface.corners.iter().all(|p| is_inside(*p, base)) {
        return Err(format!("it reaches beyond its base {}; mend its vertices", s.base));
    }
    Ok(())
}

/// True if a point of the plane of a surface lies within the surface.
fn is_inside(p: Vec3, base: &NumberedSurface) -> bool {
    let corners = &base.surface.corners;
    (0..corners.len()).all(|k| {
        let edge = corners[(k + 1) % corners.len()] - corners[k];
        let distance = edge.cross(p - corners[k]).dot(base.plane.normal) / edge.length();
        distance >= -MAX_DISTANCE_OUTSIDE * base.plane.radius
    })
}
