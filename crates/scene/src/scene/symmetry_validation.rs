//! Validation of the boundary box: periodic axes and symmetry planes.

use crate::base::limits::MAX_COORDINATE;
use crate::base::scene_error::{SceneError, invalid};
use crate::geometry::plate::{Plate, PlateKind};
use crate::model::surface::Surface;
use crate::scene::scene_parts::{SceneParts, endless_axes};
use zonal_math::Vec3;

/// Deviation from a symmetry plane that counts as rounding, in diagonals of the scene.
const PLANE_TOLERANCE: f64 = 1e-9;
/// Relative deviation of a wall from a strip along a period that counts as rounding.
const STRIP_TOLERANCE: f64 = 1e-9;
/// The names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Validates periodic axes, symmetry planes and the boundary box.
pub(crate) fn check_boundary(parts: &SceneParts) -> Result<(), SceneError> {
    check_box(parts)?;
    check_periodic(parts)?;
    let Some((axis, end)) = first_plane(parts) else { return Ok(()) };
    if let Some(k) = (0..3).find(|&k| parts.periodic[k] && parts.symmetry_planes[k] != [false; 2]) {
        return invalid(axis_key(k), "a periodic axis has no ends for symmetry planes; choose one of both");
    }
    let Some((min, max)) = parts.boundary_box() else {
        return invalid(
            plane_key(parts, axis, end),
            "symmetry planes are ends of the medium's extent; without a medium give their box: boundary.min and boundary.max",
        );
    };
    check_suns(parts)?;
    check_skies(parts)?;
    let (lo, hi) = parts.bounds();
    let slack = PLANE_TOLERANCE * (hi.max(max) - lo.min(min)).length();
    check_point_lights(parts, min, max, slack)?;
    let walls = parts.facets.iter().map(|f| (&f.plate, parts.surfaces.get(f.surface)));
    let panes = parts.panes.iter().flat_map(|p| p.plates.iter().map(|q| (q, None)));
    walls.chain(panes).try_for_each(|(plate, surface)| check_plate(parts, plate, surface, [min, max], slack))
}

fn axis_key(axis: usize) -> String {
    format!("boundary.{}", AXES[axis])
}

/// The key of a symmetry plane: that of its axis if both ends are symmetry planes.
fn plane_key(parts: &SceneParts, axis: usize, end: usize) -> String {
    if parts.symmetry_planes[axis] == [true; 2] { axis_key(axis) } else { format!("{}{end}", axis_key(axis)) }
}

fn first_plane(parts: &SceneParts) -> Option<(usize, usize)> {
    (0..3).flat_map(|k| [(k, 0), (k, 1)]).find(|&(k, e)| parts.symmetry_planes[k][e])
}

/// Validates the box of a scene without a medium.
fn check_box(parts: &SceneParts) -> Result<(), SceneError> {
    let Some((min, max)) = parts.boundary_box else { return Ok(()) };
    let ordered = (0..3).all(|k| min[k] < max[k]);
    if !(min.is_finite() && max.is_finite() && min.max_abs().max(max.max_abs()) <= MAX_COORDINATE && ordered)
    {
        let what = format!("give a box within {MAX_COORDINATE:e} m, with min below max on each axis");
        return invalid("boundary.max", what);
    }
    if parts.voxel_grid.is_some() {
        return invalid("boundary.min", "the boundary is the extent of the medium; remove min and max");
    }
    if parts.symmetry_planes == [[false; 2]; 3] && parts.periodic == [false; 3] {
        return invalid(
            "boundary.min",
            "no axis is periodic and no end is a symmetry plane; remove min and max",
        );
    }
    Ok(())
}

/// Validates axes without ends: they need a medium of uniform extinction, or of layers across the third axis, whose extent is the period, and no direct light.
fn check_periodic(parts: &SceneParts) -> Result<(), SceneError> {
    let endless = endless_axes(parts.periodic, parts.symmetry_planes);
    let Some(axis) = (0..3).find(|&k| endless[k]) else { return Ok(()) };
    // Two symmetry planes face each other where the axis is not periodic itself.
    let [period, images, scene] = if parts.periodic[axis] {
        ["the period is the extent of the medium", "periodic images", "a periodic scene"]
    } else {
        [
            "between two symmetry planes the scene repeats with the extent of the medium",
            "images between two symmetry planes",
            "a scene between two symmetry planes",
        ]
    };
    let Some(grid) = &parts.voxel_grid else {
        return match (endless.iter().filter(|e| **e).count(), parts.periodic[axis], parts.boundary_box) {
            (1, true, Some((min, max))) => check_strips(parts, axis, [min[axis], max[axis]]),
            (1, true, None) => invalid(
                axis_key(axis),
                format!("{period}; without a medium give the box of a period: boundary.min and boundary.max"),
            ),
            _ => invalid(
                axis_key(axis),
                format!(
                    "{period}; add a [medium], whose extinction may be 0: without a medium one axis can be periodic"
                ),
            ),
        };
    };
    if endless == [true; 3] {
        let what = "no more than two axes can be periodic or between two symmetry_planes: light has to end somewhere";
        return invalid(axis_key(2), what);
    }
    if let Some(l) = parts.lights.first() {
        let what = format!("direct light has no {images}; {}", remedy_of_lights(parts));
        return invalid(l.key(), what);
    }
    if !grid.has_extinction_of_layers(endless) {
        let message =
            "needs one extinction everywhere or, with two periodic axes, in each layer across the third";
        return invalid(axis_key(axis), format!("{scene} {message}"));
    }
    Ok(())
}

/// Validates a periodic scene without a medium: walls that extend along the whole period as strips.
fn check_strips(parts: &SceneParts, axis: usize, [low, high]: [f64; 2]) -> Result<(), SceneError> {
    if let Some(light) = parts.lights.first() {
        let what = format!("direct light has no periodic images; {}", remedy_of_lights(parts));
        return invalid(light.key(), what);
    }
    if let Some(pane) = parts.panes.first() {
        return invalid(
            format!("pane '{}'", pane.name),
            "a periodic scene has no panes; remove them or the period",
        );
    }
    let period = high - low;
    let slack = STRIP_TOLERANCE * period;
    for f in &parts.facets {
        let p = &f.plate;
        let along = |e: Vec3| (e.length() - e[axis].abs()) <= STRIP_TOLERANCE * e.length();
        let across = |e: Vec3| e[axis].abs() <= STRIP_TOLERANCE * e.length();
        let edges = along(p.e1) && across(p.e2) || along(p.e2) && across(p.e1);
        let (lo, hi) = p.bounds();
        let spans = (lo[axis] - low).abs() <= slack && (hi[axis] - low - period).abs() <= slack;
        if p.kind == PlateKind::Parallelogram && edges && spans {
            continue;
        }
        let name = parts.surfaces.get(f.surface).map_or("", |s| s.name.as_str());
        let what = format!(
            "without a medium every wall of a periodic scene is a rectangle along the whole period, from {low} m to {high} m in {}; extend it, leave it out, or add a [medium]",
            AXES[axis]
        );
        return invalid(format!("surface '{name}'"), what);
    }
    Ok(())
}

/// Refuses suns behind a symmetry plane, which has no end, and their light never arrives.
fn check_suns(parts: &SceneParts) -> Result<(), SceneError> {
    for light in &parts.lights {
        let Some((direction, _)) = light.distant_disc() else { continue };
        // Light that travels upwards along an axis comes from its low end.
        let behind = |k: usize| {
            parts.symmetry_planes[k][0] && direction[k] > 0.0
                || parts.symmetry_planes[k][1] && direction[k] < 0.0
        };
        if let Some(k) = (0..3).find(|&k| behind(k)) {
            let end = usize::from(direction[k] < 0.0);
            let what = format!(
                "this sun stands behind the symmetry plane {}; reverse the {} of its direction, which gives its mirror image",
                plane_key(parts, k, end),
                AXES[k]
            );
            return invalid(light.key(), what);
        }
    }
    Ok(())
}

/// Refuses skies that are not uniform: the sky of the extension would have another radiance in each direction.
fn check_skies(parts: &SceneParts) -> Result<(), SceneError> {
    match parts.lights.iter().find(|l| l.is_varying_sky()) {
        Some(light) => invalid(
            light.key(),
            "in a scene with symmetry planes a sky is uniform; remove the symmetry planes, or give kind = \"sky\"",
        ),
        None => Ok(()),
    }
}

/// Refuses point lights behind or in a symmetry plane: an image must be a light of its own.
fn check_point_lights(parts: &SceneParts, min: Vec3, max: Vec3, slack: f64) -> Result<(), SceneError> {
    for light in &parts.lights {
        let Some((position, ..)) = light.point() else { continue };
        for k in 0..3 {
            for (end, plane) in [min[k], max[k]].into_iter().enumerate() {
                let before = if end == 0 { position[k] - plane } else { plane - position[k] };
                if parts.symmetry_planes[k][end] && before <= slack {
                    let what = format!(
                        "this light stands in or behind the symmetry plane {}; move it in front of the plane",
                        plane_key(parts, k, end)
                    );
                    return invalid(light.key(), what);
                }
            }
        }
    }
    Ok(())
}

/// Refuses plates beyond a symmetry plane, and plates in it unless they close a solid whose image continues behind the symmetry plane.
fn check_plate(
    parts: &SceneParts,
    plate: &Plate,
    surface: Option<&Surface>,
    bounds: [Vec3; 2],
    slack: f64,
) -> Result<(), SceneError> {
    let (lo, hi) = plate.bounds();
    for k in 0..3 {
        for (end, plane) in bounds.map(|b| b[k]).into_iter().enumerate() {
            if !parts.symmetry_planes[k][end] {
                continue;
            }
            let name = || surface.map_or_else(|| "a pane".to_string(), |s| format!("surface '{}'", s.name));
            let beyond = if end == 0 { plane - lo[k] } else { hi[k] - plane };
            if beyond > slack {
                let what = format!(
                    "it reaches beyond the symmetry plane {}; cut it off at the plane",
                    plane_key(parts, k, end)
                );
                return invalid(name(), what);
            }
            let in_plane = (lo[k] - plane).abs() <= slack && (hi[k] - plane).abs() <= slack;
            let outward = if end == 0 { -plate.normal()[k] } else { plate.normal()[k] };
            let closes_solid = surface.is_some_and(|s| s.solid) && outward > 0.0;
            if in_plane && !closes_solid {
                let what = format!(
                    "it lies in the symmetry plane {}; leave it out (omit), or remove the symmetry plane",
                    plane_key(parts, k, end)
                );
                return invalid(name(), what);
            }
        }
    }
    Ok(())
}

/// What to do without direct light.
fn remedy_of_lights(parts: &SceneParts) -> &'static str {
    match parts.thermal {
        Some(_) => "give the scene two or three periods without this boundary instead",
        None => "let a surface emit as zones instead",
    }
}
