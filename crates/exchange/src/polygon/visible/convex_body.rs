//! Convex obstructions: flat plates, and closed solids that nothing sees through.
//!
//! A face (n, c) with n·y ≤ c inside shows itself to x if n·x > c. The silhouette from x consists of the edges between a face that shows itself and
//! one that does not. A ray from x outside the body meets it if and only if it lies inside all planes through x and an edge of the silhouette.
//! A plate has two faces in one plane, so that all its edges are silhouette from either side.

use super::convex_polygon::ConvexPolygon;
use std::borrow::Cow;
use std::collections::HashMap;
use zonal_math::Vec3;

/// Offsets of the cutting plane in contact distances that are tried in turn: corners within rounding of the first may leave no closed cut.
const CUT_OFFSETS: [f64; 4] = [0.0, 2.0, 5.0, 11.0];
/// Faces of a plate.
const PLATE_FACES: usize = 2;

/// An edge from the first end to the second is counter-clockwise in the first face and clockwise in the second, seen from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BodyEdge {
    pub ends: [u32; 2],
    pub faces: [u32; 2],
}

/// A convex plate or solid that hides what is behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexBody {
    corners: Vec<Vec3>,
    planes: Vec<(Vec3, f64)>,
    edges: Vec<BodyEdge>,
    is_plate: bool,
}

impl ConvexBody {
    /// A plate without thickness, which hides from both sides.
    pub fn plate(polygon: &ConvexPolygon) -> ConvexBody {
        let (corners, n) = (polygon.corners.clone(), polygon.normal);
        let (count, offset) = (corners.len() as u32, n.dot(corners[0]));
        let edge = |k: u32| BodyEdge { ends: [k, (k + 1) % count], faces: [0, 1] };
        let planes = vec![(n, offset), (-n, -offset)];
        ConvexBody { planes, edges: (0..count).map(edge).collect(), corners, is_plate: true }
    }

    /// A closed solid from the loops of its faces, counter-clockwise from outside. None unless every edge joins two faces and all corners lie
    /// behind all faces, to `contact` (m).
    pub fn solid(corners: Vec<Vec3>, faces: &[Vec<u32>], contact: f64) -> Option<ConvexBody> {
        let mut face_of_edge: HashMap<[u32; 2], u32> = HashMap::new();
        for (f, outline) in faces.iter().enumerate() {
            for k in 0..outline.len() {
                let ends = [outline[k], outline[(k + 1) % outline.len()]];
                if face_of_edge.insert(ends, f as u32).is_some() {
                    return None;
                }
            }
        }
        let planes: Vec<(Vec3, f64)> = faces.iter().map(|f| plane(&corners, f)).collect();
        let behind = |(n, c): &(Vec3, f64)| corners.iter().all(|x| n.dot(*x) - c <= contact);
        if faces.len() <= PLATE_FACES || !planes.iter().all(behind) {
            return None;
        }
        let mut edges = Vec::with_capacity(face_of_edge.len() / 2);
        for (f, outline) in faces.iter().enumerate() {
            for k in 0..outline.len() {
                let [a, b] = [outline[k], outline[(k + 1) % outline.len()]];
                let other = *face_of_edge.get(&[b, a])?;
                if a < b {
                    edges.push(BodyEdge { ends: [a, b], faces: [f as u32, other] });
                }
            }
        }
        Some(ConvexBody { corners, planes, edges, is_plate: false })
    }

    /// The corners, m.
    pub fn corners(&self) -> &[Vec3] {
        &self.corners
    }

    /// The planes (n, c) of the faces, n·x ≤ c inside; two of opposite direction for a plate.
    pub fn planes(&self) -> &[(Vec3, f64)] {
        &self.planes
    }

    pub(super) fn edges(&self) -> &[BodyEdge] {
        &self.edges
    }

    /// True for a plate without thickness.
    pub fn is_plate(&self) -> bool {
        self.is_plate
    }

    /// The body displaced.
    pub fn translated(&self, by: Vec3) -> ConvexBody {
        ConvexBody {
            corners: self.corners.iter().map(|c| *c + by).collect(),
            planes: self.planes.iter().map(|(n, c)| (*n, c + n.dot(by))).collect(),
            ..self.clone()
        }
    }

    /// The part of the body in front of a polygon's plane; none if no corner rises above `contact`, m. A cut-off part adds a face.
    pub fn in_front_of(&self, polygon: &ConvexPolygon, contact: f64) -> Option<Cow<'_, ConvexBody>> {
        let heights: Vec<f64> = self.corners.iter().map(|c| polygon.height(*c)).collect();
        if heights.iter().all(|h| *h <= contact) {
            return None;
        }
        if heights.iter().all(|h| *h >= -contact) {
            return Some(Cow::Borrowed(self));
        }
        let cut = |offset: f64| self.cut(&heights, polygon, offset * contact);
        // Without a closed cut the whole body stands for its part.
        Some(CUT_OFFSETS.into_iter().find_map(cut).map_or(Cow::Borrowed(self), Cow::Owned))
    }

    /// The part at heights of `level` or more over a plane. None if rounding leaves no closed cut.
    fn cut(&self, heights: &[f64], polygon: &ConvexPolygon, level: f64) -> Option<ConvexBody> {
        let cap = self.planes.len() as u32;
        let is_kept = |k: u32| heights[k as usize] >= level;
        let mut body = ConvexBody { corners: Vec::new(), edges: Vec::new(), ..self.clone() };
        let mut number = vec![u32::MAX; heights.len()];
        for (k, corner) in self.corners.iter().enumerate().filter(|(k, _)| is_kept(*k as u32)) {
            number[k] = body.corners.len() as u32;
            body.corners.push(*corner);
        }
        // Where the loop of each face leaves the kept part, and where it comes back.
        let mut crossings = vec![[u32::MAX; 2]; self.planes.len()];
        for edge in &self.edges {
            let [a, b] = edge.ends;
            let leaves = is_kept(a);
            if !leaves && !is_kept(b) {
                continue;
            }
            let mut ends = [a, b].map(|k| number[k as usize]);
            if leaves != is_kept(b) {
                let (from, to) = (self.corners[a as usize], self.corners[b as usize]);
                let (h, k) = (heights[a as usize] - level, heights[b as usize] - level);
                let made = body.corners.len() as u32;
                body.corners.push(from + (to - from) * (h / (h - k)));
                for (side, face) in edge.faces.iter().enumerate() {
                    // The second face runs along the edge in the other direction.
                    let slot = usize::from(leaves == (side == 1));
                    let crossing = &mut crossings[*face as usize][slot];
                    if *crossing != u32::MAX {
                        return None;
                    }
                    *crossing = made;
                }
                ends[usize::from(leaves)] = made;
            }
            body.edges.push(BodyEdge { ends, ..*edge });
        }
        for (face, [left, back]) in crossings.iter().enumerate() {
            if (*left == u32::MAX) != (*back == u32::MAX) {
                return None;
            }
            if *left != u32::MAX {
                body.edges.push(BodyEdge { ends: [*left, *back], faces: [face as u32, cap] });
            }
        }
        let n = -polygon.normal;
        body.planes.push((n, n.dot(polygon.corners[0]) - level));
        Some(body)
    }
}

/// The plane of a loop.
fn plane(corners: &[Vec3], outline: &[u32]) -> (Vec3, f64) {
    let at = |k: usize| corners[outline[k] as usize];
    let twice = (2..outline.len()).fold(Vec3::ZERO, |s, k| s + (at(k - 1) - at(0)).cross(at(k) - at(0)));
    let n = twice.normalized();
    let offset = outline.iter().fold(f64::NEG_INFINITY, |s, k| s.max(n.dot(corners[*k as usize])));
    (n, offset)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    /// The unit cube; corner k has the bits of k as coordinates.
    fn cube() -> ConvexBody {
        let corners =
            (0..8).map(|k| vec3(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2))).collect();
        let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        ConvexBody::solid(corners, &faces.map(|f| f.to_vec()), 1e-12).expect("a cube")
    }

    fn square(z: f64, normal: Vec3) -> ConvexPolygon {
        let (e, f) = normal.frame();
        let at = vec3(0.5, 0.5, z);
        ConvexPolygon::new(vec![at - e - f, at + e - f, at + e + f, at - e + f]).expect("a square")
    }

    #[test]
    fn solids_are_closed_and_convex() {
        let c = cube();
        assert_eq!((c.corners().len(), c.edges().len(), c.planes().len()), (8, 12, 6));
        assert!(c.planes().iter().all(|(n, c)| (n.dot(Vec3::splat(0.5)) - c + 0.5).abs() < 1e-15));
        let faces = |f: &[[u32; 3]]| f.iter().map(|f| f.to_vec()).collect::<Vec<_>>();
        let tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let points = vec![Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)];
        assert!(ConvexBody::solid(points.clone(), &faces(&tetrahedron), 1e-12).is_some());
        assert!(ConvexBody::solid(points.clone(), &faces(&tetrahedron[..3]), 1e-12).is_none(), "open");
        let inwards = tetrahedron.map(|[a, b, c]| [a, c, b]);
        assert!(ConvexBody::solid(points, &faces(&inwards), 1e-12).is_none(), "turned inside out");
    }

    #[test]
    fn a_cut_body_is_closed() {
        let body = cube();
        let tilted = square(0.4, vec3(0.3, -0.2, 1.0).normalized());
        for plane in [square(0.25, vec3(0.0, 0.0, 1.0)), tilted] {
            let part = body.in_front_of(&plane, 1e-9).expect("a part").into_owned();
            assert_eq!((part.corners().len(), part.edges().len(), part.planes().len()), (8, 12, 7));
            assert!(part.corners().iter().all(|c| plane.height(*c) >= -1e-12));
            for (n, c) in part.planes().iter().skip(1) {
                assert!(part.corners().iter().all(|x| n.dot(*x) - c < 1e-12));
            }
            // Every face's edges close: each corner begins as many as it ends.
            for face in 0..7u32 {
                let mut turns = [0i32; 8];
                for e in part.edges() {
                    for side in (0..2).filter(|s| e.faces[*s] == face) {
                        turns[e.ends[side] as usize] += 1;
                        turns[e.ends[1 - side] as usize] -= 1;
                    }
                }
                assert_eq!(turns, [0; 8]);
            }
        }
        assert!(matches!(body.in_front_of(&square(0.0, vec3(0.0, 0.0, 1.0)), 1e-9), Some(Cow::Borrowed(_))));
        assert!(body.in_front_of(&square(1.0, vec3(0.0, 0.0, 1.0)), 1e-9).is_none());
    }

    #[test]
    fn a_cut_plate_keeps_its_outline() {
        let plate = ConvexBody::plate(&square(0.0, vec3(0.0, 0.0, 1.0)));
        let half = plate.in_front_of(&square(0.0, vec3(1.0, 0.0, 0.0)), 1e-9).expect("half").into_owned();
        assert_eq!((half.corners().len(), half.planes().len()), (4, 3));
        let of_front = half.edges().iter().filter(|e| e.faces.contains(&0)).count();
        assert_eq!(of_front, 4);
    }
}
