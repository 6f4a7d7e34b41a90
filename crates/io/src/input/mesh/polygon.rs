//! Polygons of mesh files as plates.

use super::model::{MeshData, MeshFace};
use zonal_math::Vec3;
use zonal_scene::Plate;

/// A corner: its position and its texture coordinates.
pub(crate) type PolygonCorner = (Vec3, [f64; 2]);

/// Largest gap of a parallelogram relative to its diagonal, and of its texture coordinates.
const PARALLELOGRAM_TOLERANCE: f64 = 1e-6;
const PARALLELOGRAM_UV_TOLERANCE: f64 = 1e-5;
/// Largest difference of the unit normals of corners from that of their face below which they are left out.
const FLAT_TOLERANCE: f64 = 1e-4;

/// Half the sum of the cross products: the normal with the polygon's area as its length.
pub(crate) fn area_vector(p: &[Vec3]) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for i in 1..p.len().saturating_sub(1) {
        sum += (p[i] - p[0]).cross(p[i + 1] - p[0]) * 0.5;
    }
    sum
}

/// Appends a polygon: a parallelogram stays one plate; a convex polygon becomes a fan of triangles; others are triangulated by ear
/// clipping. Returns false if the polygon crosses itself and became a fan.
pub(crate) fn push_polygon(
    faces: &mut Vec<MeshFace>,
    template: &MeshFace,
    corners: &[PolygonCorner],
) -> bool {
    cut_polygon(template, corners, |face, _| faces.push(face))
}

/// As [`push_polygon`], with the normals of the corners, of any length; none for a flat polygon.
pub(crate) fn push_smooth_polygon(
    mesh: &mut MeshData,
    template: &MeshFace,
    corners: &[PolygonCorner],
    normals: &[Vec3],
) -> bool {
    if normals.len() != corners.len() {
        return push_polygon(&mut mesh.faces, template, corners);
    }
    let MeshData { faces, normals: list, .. } = mesh;
    cut_polygon(template, corners, |mut face, places| {
        let own = places.map(|k| normals[k].normalized());
        let flat = face.plate.normal();
        if own.iter().any(|n| (*n - flat).length() > FLAT_TOLERANCE) {
            face.normals = u32::try_from(list.len()).ok();
            list.push(own.map(|n| n.array().map(|x| x as f32)));
        }
        faces.push(face);
    })
}

/// Hands out the plates of a polygon, each with the indices of its corners; the fourth of a triangle is the third. False as in [`push_polygon`].
fn cut_polygon(
    template: &MeshFace,
    corners: &[PolygonCorner],
    mut take: impl FnMut(MeshFace, [usize; 4]),
) -> bool {
    if let Some(face) = parallelogram(template, corners) {
        take(face, [0, 1, 2, 3]);
        return true;
    }
    let (triangles, simple) = triangulate(corners);
    for [a, b, c] in triangles {
        let face = MeshFace {
            plate: Plate::triangle(corners[a].0, corners[b].0, corners[c].0),
            uv: [corners[a].1, corners[b].1, corners[c].1],
            ..*template
        };
        take(face, [a, b, c, c]);
    }
    simple
}

fn parallelogram(template: &MeshFace, corners: &[PolygonCorner]) -> Option<MeshFace> {
    let [a, b, c, d] = corners else { return None };
    let size = (c.0 - a.0).length().max((d.0 - b.0).length());
    let closes = (a.0 + c.0 - b.0 - d.0).length() <= PARALLELOGRAM_TOLERANCE * size;
    let linear = (0..2).all(|k| (a.1[k] + c.1[k] - b.1[k] - d.1[k]).abs() <= PARALLELOGRAM_UV_TOLERANCE);
    (closes && linear).then(|| MeshFace {
        plate: Plate::parallelogram(a.0, b.0 - a.0, d.0 - a.0),
        uv: [a.1, b.1, d.1],
        ..*template
    })
}

/// Triangles as indices of corners, and whether the polygon is simple. Cost of ear clipping: the cube of the corners at worst.
fn triangulate(corners: &[PolygonCorner]) -> (Vec<[usize; 3]>, bool) {
    let p: Vec<Vec3> = corners.iter().map(|c| c.0).collect();
    let n = p.len();
    let fan =
        |first: usize| (1..n.saturating_sub(1)).map(move |i| [first, (first + i) % n, (first + i + 1) % n]);
    if n <= 3 {
        return (fan(0).collect(), true);
    }
    // Project along the largest component of the normal, keeping the orientation.
    let normal = area_vector(&p);
    let axis = (0..3).max_by(|a, b| normal[*a].abs().total_cmp(&normal[*b].abs())).unwrap_or(2);
    let (i, j) =
        if normal[axis] >= 0.0 { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
    let flat: Vec<[f64; 2]> = p.iter().map(|q| [q[i], q[j]]).collect();
    if (0..n).all(|k| signed_area(&flat, k, (k + 1) % n, (k + 2) % n) >= 0.0) {
        return (fan(0).collect(), true);
    }
    match clip_ears(&flat) {
        Some(triangles) => (triangles, true),
        None => (fan(0).collect(), false),
    }
}

/// Twice the signed area of a triangle of projected corners.
fn signed_area(flat: &[[f64; 2]], a: usize, b: usize, c: usize) -> f64 {
    (flat[b][0] - flat[a][0]) * (flat[c][1] - flat[b][1])
        - (flat[b][1] - flat[a][1]) * (flat[c][0] - flat[b][0])
}

/// Ear clipping of a polygon of positive orientation; none if it crosses itself.
fn clip_ears(flat: &[[f64; 2]]) -> Option<Vec<[usize; 3]>> {
    let n = flat.len();
    let turn = |a: usize, b: usize, c: usize| signed_area(flat, a, b, c);
    let mut left: Vec<usize> = (0..n).collect();
    let mut out = Vec::with_capacity(n - 2);
    while left.len() > 3 {
        let m = left.len();
        let corner = |k: usize| (left[(k + m - 1) % m], left[k], left[(k + 1) % m]);
        let is_ear = |k: &usize| {
            let (a, b, c) = corner(*k);
            turn(a, b, c) > 0.0
                && left.iter().all(|&q| {
                    [a, b, c].contains(&q)
                        || flat[q] == flat[a]
                        || flat[q] == flat[b]
                        || flat[q] == flat[c]
                        || !(turn(a, b, q) >= 0.0 && turn(b, c, q) >= 0.0 && turn(c, a, q) >= 0.0)
                })
        };
        // Without an ear, cut a straight or doubled corner: its triangle has no area.
        let ear = (0..m).find(is_ear).or_else(|| {
            (0..m).find(|k| {
                let (a, b, c) = corner(*k);
                turn(a, b, c) == 0.0
            })
        });
        let k = ear?;
        let (a, b, c) = corner(k);
        out.push([a, b, c]);
        left.remove(k);
    }
    out.push([left[0], left[1], left[2]]);
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    fn area(points: &[[f64; 2]]) -> (usize, f64, bool) {
        let corners: Vec<PolygonCorner> = points.iter().map(|q| (vec3(1.0, q[0], q[1]), [0.0; 2])).collect();
        let (triangles, simple) = triangulate(&corners);
        let sum = triangles.iter().map(|t| area_vector(&t.map(|k| corners[k].0)).x).sum();
        (triangles.len(), sum, simple)
    }

    #[test]
    fn concave_polygons_keep_their_area() {
        let l = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        assert_eq!(area(&l), (4, 3.0, true));
        let mut back = l;
        back.reverse();
        assert_eq!(area(&back), (4, -3.0, true));
        let arrow = [[0.0, 0.0], [2.0, -1.0], [0.0, 2.0], [-2.0, -1.0]];
        assert_eq!(area(&arrow), (2, 4.0, true));
        let (n, _, _) = area(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.5]]);
        assert_eq!(n, 2);
    }
}
