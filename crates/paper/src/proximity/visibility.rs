//! Mutual visibility of a cell of a surface and a plate: whole, partial or none, by bounds on the cell and on its quarters.

use super::error_constants::{POINT_ROUNDINGS, RADIUS_SLACK};
use super::plate_geometry::farthest;
use super::surface::SmoothSurface;
use crate::rounding::UNIT_ROUNDOFF;
use zonal_scene::Plate;

/// How often a cell is quartered to decide its visibility.
pub(super) const HORIZON_DEPTH: u32 = 5;

/// Mutual visibility of a cell and a plate.
pub(super) enum Visibility {
    Whole,
    Part,
    Nothing,
}

/// Decides whether all points of a cell and all points of B are in front of each other.
pub(super) fn cell_visibility(
    surface: &SmoothSurface,
    cell: [[f64; 2]; 2],
    plate: &Plate,
    shake: f64,
    depth: u32,
) -> Visibility {
    let [u, v] = cell.map(|e| 0.5 * (e[0] + e[1]));
    let half = cell.map(|e| 0.5 * (e[1] - e[0]) * RADIUS_SLACK);
    let (s, m) = (surface.at(u, v), surface.local(u, v).majorant(half));
    let height = plate.normal().dot(s - plate.origin);
    let (reach, normal) = (m.displacement * RADIUS_SLACK, surface.normal(u, v));
    let (corners, n) = plate.corners();
    let facing = corners[..n].iter().map(|c| normal.dot(*c - s));
    let (least, most) = facing.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    let far = farthest(plate, s) + reach;
    let turn = (m.normal_change * far + normal.length() * m.rest) * RADIUS_SLACK;
    let tilt = grazing_error(m.normal, shake, far);
    if height <= -reach - shake || most <= -turn - tilt {
        return Visibility::Nothing;
    }
    if height >= reach - shake && least >= turn - tilt {
        return Visibility::Whole;
    }
    if depth == HORIZON_DEPTH {
        return Visibility::Part;
    }
    let (mut whole, mut nothing) = (true, true);
    for k in 0..4 {
        let part = |e: [f64; 2], c: f64, high: bool| if high { [c, e[1]] } else { [e[0], c] };
        match cell_visibility(
            surface,
            [part(cell[0], u, k & 1 > 0), part(cell[1], v, k > 1)],
            plate,
            shake,
            depth + 1,
        ) {
            Visibility::Whole => nothing = false,
            Visibility::Nothing => whole = false,
            Visibility::Part => return Visibility::Part,
        }
        if !whole && !nothing {
            return Visibility::Part;
        }
    }
    if whole { Visibility::Whole } else { Visibility::Nothing }
}

/// Bound of the rounding error of N·d.
pub(super) fn grazing_error(normal: f64, shake: f64, far: f64) -> f64 {
    normal * (shake + POINT_ROUNDINGS * UNIT_ROUNDOFF * far)
}
