//! Inline geometry: rectangles, triangles, boxes, rooms and polygons.
//!
//! A texture on a rectangle has its bottom along edge1 and its left side along edge2, seen from the front; on walls of rooms and boxes
//! it is upright.

use crate::input::mesh::polygon::area_vector;
use crate::input::reading::error::InputError;
use crate::input::toml::medium_keys::PANE;
use crate::input::toml::node::{TomlNode, TomlTable};
use crate::input::toml::surface_keys::{
    BOUNDS, BOX, Bounds, Box as BoxKeys, RECTANGLE, Rectangle, TRIANGLE, Triangle,
};
use zonal_math::{Vec3, vec3};
use zonal_scene::Plate;

/// Smallest area of a shape relative to the square of its size.
const MIN_RELATIVE_AREA: f64 = 1e-12;
/// Largest distance of a polygon's corner from its plane, relative to its size.
const PLANARITY_TOLERANCE: f64 = 1e-5;
/// Largest rounding of a convex corner and of a parallelogram, relative to the polygon's size (squared for areas).
const CORNER_TOLERANCE: f64 = 1e-9;

/// Side from which the faces of a box are seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Facing {
    /// Normals into the box: a room.
    Inward,
    /// Normals out of the box: a solid.
    Outward,
}

/// The faces of a box, in the order in which they are made.
pub(crate) const FACE_NAMES: [&str; 6] = ["x0", "x1", "y0", "y1", "z0", "z1"];

/// Texture coordinates at (u, v) = (0,0), (1,0), (0,1) of a plate with a whole upright texture; v runs down.
pub(crate) const UPRIGHT_UV: [[f64; 2]; 3] = [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]];

/// `rectangle = { origin, edge1, edge2 }`.
pub(crate) fn read_rectangle(node: &TomlNode<'_>) -> Result<Plate, InputError> {
    let t = node.table(Rectangle::TABLE)?;
    let (e1, e2) = (t.required(&RECTANGLE.edge1)?, t.required(&RECTANGLE.edge2)?);
    with_area(node, Plate::parallelogram(t.required(&RECTANGLE.origin)?, e1, e2))
}

/// `triangle = { corners = [a, b, c] }`.
pub(crate) fn read_triangle(node: &TomlNode<'_>) -> Result<Plate, InputError> {
    let t = node.table(Triangle::TABLE)?;
    let corners = t.require(&TRIANGLE.corners)?;
    let points = TRIANGLE.corners.read(&corners)?;
    let [a, b, c] = points.as_slice() else {
        let n = points.len();
        return Err(corners.error(format!("a triangle has three corners, not {n}; give three points")));
    };
    with_area(node, Plate::triangle(*a, *b, *c))
}

fn with_area(node: &TomlNode<'_>, plate: Plate) -> Result<Plate, InputError> {
    let (e1, e2) = (plate.e1.length(), plate.e2.length());
    if plate.area() > MIN_RELATIVE_AREA * e1 * e2 && plate.area().is_finite() {
        return Ok(plate);
    }
    Err(node.error("this shape has no area; move its corners apart, off one line"))
}

/// `{ min, max }` and no other keys.
pub(crate) fn read_box_bounds(node: &TomlNode<'_>) -> Result<(Vec3, Vec3), InputError> {
    read_bounds(&node.table(Bounds::TABLE)?)
}

/// `min` and `max` of a table, min below max along each axis.
pub(crate) fn read_bounds(t: &TomlTable<'_>) -> Result<(Vec3, Vec3), InputError> {
    let min = t.required(&BOUNDS.min)?;
    let max_node = t.require(&BOUNDS.max)?;
    let max = max_node.vector()?;
    for axis in 0..3 {
        let edge = max[axis] - min[axis];
        if !(edge > 0.0 && edge.is_finite()) {
            return Err(max_node.error(format!(
                "max is not above min along {}; exchange them or move them apart",
                ["x", "y", "z"][axis]
            )));
        }
    }
    Ok((min, max))
}

/// The six faces of a box in the order of [`FACE_NAMES`].
pub(crate) fn box_faces(min: Vec3, max: Vec3, facing: Facing) -> [Plate; 6] {
    let inside = facing == Facing::Inward;
    std::array::from_fn(|i| {
        let (axis, high) = (i / 2, i % 2 == 1);
        // The normal points away from the face's own end of the axis when seen from inside.
        let sign = if high == inside { -1.0 } else { 1.0 };
        let up = vec3(0.0, 0.0, 1.0);
        let (d1, d2) = match axis {
            0 => (up.cross(vec3(sign, 0.0, 0.0)), up),
            1 => (up.cross(vec3(0.0, sign, 0.0)), up),
            _ => (vec3(sign, 0.0, 0.0), vec3(0.0, 1.0, 0.0)),
        };
        let size = max - min;
        // The corner from which both edges run into the face.
        let corner = |k: usize| {
            if k == axis {
                if high { max[k] } else { min[k] }
            } else if d1[k] + d2[k] < 0.0 {
                max[k]
            } else {
                min[k]
            }
        };
        let origin = vec3(corner(0), corner(1), corner(2));
        Plate::parallelogram(origin, d1.scale(size), d2.scale(size))
    })
}

/// `box = { min, max, rotate_z_degrees }`, rotated about the vertical through its centre; outward normals.
pub(crate) fn read_solid_box(node: &TomlNode<'_>) -> Result<[Plate; 6], InputError> {
    let t = node.table(BoxKeys::TABLE)?;
    let (min, max) = read_bounds(&t)?;
    let turn = t.or_default(&BOX.rotate_z_degrees)?;
    let plates = box_faces(min, max, Facing::Outward);
    if turn == 0.0 {
        return Ok(plates);
    }
    let (sin, cos) = turn.to_radians().sin_cos();
    let rotate = |v: Vec3| vec3(cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z);
    let centre = (min + max) * 0.5;
    Ok(plates.map(|p| Plate {
        origin: centre + rotate(p.origin - centre),
        e1: rotate(p.e1),
        e2: rotate(p.e2),
        kind: p.kind,
    }))
}

/// A plane convex polygon as plates: one parallelogram if it is one, else a fan of triangles.
pub(crate) fn read_polygon(node: &TomlNode<'_>) -> Result<Vec<Plate>, InputError> {
    let p = PANE.polygon.read(node)?;
    if p.len() < 3 {
        return Err(node.error(format!("a polygon needs at least three corners, not {}; add some", p.len())));
    }
    let normal = area_vector(&p);
    let size = p.iter().map(|q| (*q - p[0]).length()).fold(0.0, f64::max);
    if !(normal.length() > MIN_RELATIVE_AREA * size * size && normal.is_finite()) {
        return Err(node.error("this polygon has no area; move its corners apart, off one line"));
    }
    let unit = normal.normalized();
    for (i, q) in p.iter().enumerate() {
        let off = (*q - p[0]).dot(unit);
        if off.abs() > PLANARITY_TOLERANCE * size {
            return Err(node.error(format!(
                "corner {} lies {:.3e} m off the plane of the others; move it into the plane",
                i + 1,
                off.abs()
            )));
        }
    }
    let n = p.len();
    for i in 0..n {
        let (a, b, c) = (p[i], p[(i + 1) % n], p[(i + 2) % n]);
        if (b - a).cross(c - b).dot(unit) < -CORNER_TOLERANCE * size * size {
            return Err(node.error(format!(
                "the polygon is not convex at corner {}; split it into convex panes",
                (i + 1) % n + 1
            )));
        }
    }
    if !winds_once(&p) {
        return Err(node.error("the polygon runs around more than once; list each corner once, in order"));
    }
    if n == 4 && (p[0] + p[2] - p[1] - p[3]).length() <= CORNER_TOLERANCE * size {
        return Ok(vec![Plate::parallelogram(p[0], p[1] - p[0], p[3] - p[0])]);
    }
    let fan = (1..n - 1).map(|i| Plate::triangle(p[0], p[i], p[i + 1]));
    Ok(fan.filter(|t| t.area() > MIN_RELATIVE_AREA * size * size).collect())
}

/// True if the exterior angles of a convex polygon sum to one circle (those of a pentagram sum to two).
fn winds_once(p: &[Vec3]) -> bool {
    let n = p.len();
    let mut edges: Vec<Vec3> = (0..n).map(|i| p[(i + 1) % n] - p[i]).collect();
    edges.retain(|e| e.length() > 0.0);
    let m = edges.len();
    let turn = |i: usize| {
        let (a, b) = (edges[i], edges[(i + 1) % m]);
        a.cross(b).length().atan2(a.dot(b))
    };
    let total: f64 = (0..m).map(turn).sum();
    total < 3.0 * std::f64::consts::PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn box_faces_lie_on_the_box_and_face_as_stated() {
        let (min, max) = (vec3(-1.0, 2.0, 3.0), vec3(4.0, 4.0, 9.0));
        let centre = (min + max) * 0.5;
        for facing in [Facing::Inward, Facing::Outward] {
            let faces = box_faces(min, max, facing);
            let area: f64 = faces.iter().map(Plate::area).sum();
            assert!((area - 2.0 * (10.0 + 12.0 + 30.0)).abs() < 1e-12);
            for (i, f) in faces.iter().enumerate() {
                assert_eq!(
                    (centre - f.centre()).dot(f.normal()) > 0.0,
                    facing == Facing::Inward,
                    "{}",
                    FACE_NAMES[i]
                );
                let (lo, hi) = f.bounds();
                assert!((lo - lo.max(min)).length() < 1e-12 && (hi - hi.min(max)).length() < 1e-12);
                let end = if i % 2 == 0 { min } else { max };
                assert_eq!(f.centre()[i / 2], end[i / 2]);
            }
        }
    }
}
