//! Whether a cell of a surface and a plate see all of each other, nothing, or a part; and how far apart they are.

use super::taylor::EPS;
use super::{DATA, SLACK, Surface};
use zonal_math::Vec3;
use zonal_scene::Plate;

/// How often a cell is quartered to tell whether it is seen.
pub(super) const HORIZON_DEPTH: u32 = 5;

/// Smallest distance of a point to a plate, m, rounded down.
pub(super) fn distance(plate: &Plate, x: Vec3) -> f64 {
    let (corners, n) = plate.corners();
    let [u, v] = plate.parameters(x);
    let inside = u >= 0.0 && v >= 0.0 && if n == 3 { u + v <= 1.0 } else { u <= 1.0 && v <= 1.0 };
    let to_edge = |k: usize| {
        let (a, e) = (corners[k], corners[(k + 1) % n] - corners[k]);
        let t = ((x - a).dot(e) / e.length2()).clamp(0.0, 1.0);
        (x - a - e * t).length()
    };
    let flat = if inside { plate.normal().dot(x - plate.origin).abs() } else { f64::INFINITY };
    (0..n).map(to_edge).fold(flat, f64::min) / SLACK
}

/// Largest distance of a point to a plate, m.
pub(super) fn farthest(plate: &Plate, x: Vec3) -> f64 {
    let (corners, n) = plate.corners();
    corners[..n].iter().fold(0.0f64, |s, c| s.max((x - *c).length())) * SLACK
}

/// What a cell and a plate see of each other.
pub(super) enum Sight {
    Whole,
    Part,
    Nothing,
}

/// Whether all points of a cell and all points of B are in front of each other.
pub(super) fn seen(surface: &Surface, cell: [[f64; 2]; 2], plate: &Plate, shake: f64, depth: u32) -> Sight {
    let [u, v] = cell.map(|e| 0.5 * (e[0] + e[1]));
    let half = cell.map(|e| 0.5 * (e[1] - e[0]) * SLACK);
    let (s, m) = (surface.at(u, v), surface.local(u, v).majorant(half));
    let height = plate.normal().dot(s - plate.origin);
    let (reach, normal) = (m.reach * SLACK, surface.normal(u, v));
    let (corners, n) = plate.corners();
    let facing = corners[..n].iter().map(|c| normal.dot(*c - s));
    let (least, most) = facing.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    let far = farthest(plate, s) + reach;
    let turn = (m.bend * far + normal.length() * m.rest) * SLACK;
    let tilt = graze(m.normal, shake, far);
    if height <= -reach - shake || most <= -turn - tilt {
        return Sight::Nothing;
    }
    if height >= reach - shake && least >= turn - tilt {
        return Sight::Whole;
    }
    if depth == HORIZON_DEPTH {
        return Sight::Part;
    }
    let (mut whole, mut nothing) = (true, true);
    for k in 0..4 {
        let part = |e: [f64; 2], c: f64, high: bool| if high { [c, e[1]] } else { [e[0], c] };
        match seen(surface, [part(cell[0], u, k & 1 > 0), part(cell[1], v, k > 1)], plate, shake, depth + 1) {
            Sight::Whole => nothing = false,
            Sight::Nothing => whole = false,
            Sight::Part => return Sight::Part,
        }
        if !whole && !nothing {
            return Sight::Part;
        }
    }
    if whole { Sight::Whole } else { Sight::Nothing }
}

/// What rounding can do to N·d.
pub(super) fn graze(normal: f64, shake: f64, far: f64) -> f64 {
    normal * (shake + DATA * EPS * far)
}

/// Lengths that a plate's points are summed from, m.
pub(super) fn size(plate: &Plate) -> f64 {
    plate.origin.length() + plate.e1.length() + plate.e2.length()
}

/// How much more than its edges' roundings those of a plate's normal and area are: 1 for a rectangle.
pub(super) fn skew(plate: &Plate) -> f64 {
    plate.e1.length() * plate.e2.length() / plate.e1.cross(plate.e2).length()
}
