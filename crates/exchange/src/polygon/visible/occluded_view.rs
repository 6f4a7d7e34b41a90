//! The projected solid angle of a convex target behind convex obstructions, from a point, in closed form.
//!
//! With x at the origin, the cone over a convex obstruction with silhouette edges o_k → p_k (`convex_body.rs`), taken so that they turn one way, is
//! {y: (p_k × o_k)·y ≥ 0 for all k}. The visible pieces of the target stay in its plane, y = c + s e₁ + t e₂, where each side of the cone is a
//! line a s + b t + d = 0. The difference of a convex piece and the cone: cut at the first line, keep the outer part, continue with
//! the inner part; the part inside all lines is hidden.
//!
//! A target is a polygon, or a cone of directions: then c, e₁ and e₂ do not depend on x (weight 0). All coordinates are those of the target's
//! frame (e₁, e₂, e₁ × e₂). A face of an obstruction that shows itself to all of the viewing polygon, or to none of it, is decided once: an edge
//! between a face of either kind is silhouette from everywhere. The other edges are decided for each point.
//!
//! Cost: a piece that lies outside one of the lines stays where it is; otherwise each line that cuts it makes one more piece.

use super::convex_body::ConvexBody;
use super::convex_polygon::ConvexPolygon;
use zonal_math::{Vec3, vec3};

/// A corner of a piece in the coordinates of the target's plane.
type PlaneCorner = [f64; 2];

/// A line a s + b t + d of the target's plane, positive inside the cone.
type ConeLine = [f64; 3];

fn height([a, b, d]: &ConeLine, [s, t]: &PlaneCorner) -> f64 {
    a * s + b * t + d
}

/// Convex pieces of the target; the corners of all stand in one array, which grows until the next point of view.
#[derive(Clone, Debug, Default)]
struct PieceList {
    corners: Vec<PlaneCorner>,
    /// First corner and end of each visible piece.
    pieces: Vec<[usize; 2]>,
    kept: Vec<[usize; 2]>,
    inside: Vec<PlaneCorner>,
}

impl PieceList {
    fn restart(&mut self, whole: &[PlaneCorner]) {
        self.corners.clear();
        self.corners.extend_from_slice(whole);
        self.pieces.clear();
        self.pieces.push([0, whole.len()]);
    }

    fn of(&self, [from, to]: [usize; 2]) -> &[PlaneCorner] {
        &self.corners[from..to]
    }

    /// Subtracts a cone from the pieces.
    fn subtract(&mut self, cone: &[ConeLine]) {
        self.kept.clear();
        for k in 0..self.pieces.len() {
            let piece = self.pieces[k];
            if cone.iter().any(|line| self.of(piece).iter().all(|p| height(line, p) <= 0.0)) {
                self.kept.push(piece);
                continue;
            }
            let mut rest = piece;
            for line in cone {
                if self.of(rest).iter().any(|p| height(line, p) < 0.0) {
                    rest = self.split(rest, line);
                }
            }
        }
        std::mem::swap(&mut self.pieces, &mut self.kept);
    }

    /// Keeps the part of a piece on the negative side of a line, and returns that on the positive side.
    fn split(&mut self, [from, to]: [usize; 2], line: &ConeLine) -> [usize; 2] {
        self.inside.clear();
        let begin = self.corners.len();
        let mut p = self.corners[to - 1];
        let mut h = height(line, &p);
        for i in from..to {
            let q = self.corners[i];
            let next = height(line, &q);
            if h * next < 0.0 {
                let f = h / (h - next);
                let x = [p[0] + (q[0] - p[0]) * f, p[1] + (q[1] - p[1]) * f];
                self.inside.push(x);
                self.corners.push(x);
            }
            if next >= 0.0 {
                self.inside.push(q);
            }
            if next <= 0.0 {
                self.corners.push(q);
            }
            (p, h) = (q, next);
        }
        let end = self.corners.len();
        self.kept.push([begin, end]);
        self.corners.extend_from_slice(&self.inside);
        [end, self.corners.len()]
    }
}

/// Whether a face shows itself to the points of the viewing polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FaceSide {
    /// To all of them.
    Front,
    /// To none of them.
    Back,
    /// It depends: the face by its number among the undecided ones of its body.
    Undecided(u32),
}

/// An edge in the target's frame, counter-clockwise in the first face seen from outside.
#[derive(Clone, Copy, Debug)]
struct ViewEdge {
    from: Vec3,
    to: Vec3,
    faces: [FaceSide; 2],
}

/// The edges and the undecided faces of one obstruction, as ends of ranges.
#[derive(Clone, Copy, Debug)]
struct ViewBody {
    /// End of the edges that are silhouette from everywhere, end of the others.
    edges: [usize; 2],
    planes: usize,
    is_plate: bool,
}

/// What an obstruction hides of a target.
enum Hidden {
    Nothing,
    Everything,
    /// The inside of the cone.
    Cone,
}

/// A convex target and its obstructions, evaluated from many points of a viewing polygon.
#[derive(Clone, Debug)]
pub struct OccludedView {
    /// Corners of the viewing polygon.
    viewer: Vec<Vec3>,
    /// Origin and axes of the target's frame.
    base: Vec3,
    axes: [Vec3; 3],
    /// Normal of the viewing polygon in the frame.
    normal: Vec3,
    /// The target's first corner in the frame.
    anchor: Vec3,
    /// 1 for points; 0 for directions, which are points at infinity.
    weight: f64,
    /// The target's corners in its plane.
    whole: Vec<PlaneCorner>,
    bodies: Vec<ViewBody>,
    edges: Vec<ViewEdge>,
    planes: Vec<(Vec3, f64)>,
    /// Scratch: pieces, lines, faces that show themselves.
    visible: PieceList,
    cone: Vec<ConeLine>,
    fronts: Vec<bool>,
    sides: Vec<FaceSide>,
}

impl Default for OccludedView {
    /// A view of nothing, to be set ([`OccludedView::set_polygon`]).
    fn default() -> OccludedView {
        OccludedView {
            viewer: Vec::new(),
            base: Vec3::ZERO,
            axes: [Vec3::ZERO; 3],
            normal: Vec3::ZERO,
            anchor: Vec3::ZERO,
            weight: 1.0,
            whole: Vec::new(),
            bodies: Vec::new(),
            edges: Vec::new(),
            planes: Vec::new(),
            visible: PieceList::default(),
            cone: Vec::new(),
            fronts: Vec::new(),
            sides: Vec::new(),
        }
    }
}

impl OccludedView {
    /// The view from `viewer` of a cone between directions that lie in one plane, counter-clockwise for an observer at its apex. None if no direction
    /// lies in front of the viewer.
    pub fn of_directions(viewer: &ConvexPolygon, corners: &[Vec3]) -> Option<OccludedView> {
        let visible = directions_in_front(corners, viewer.normal);
        (visible.len() >= 3).then(|| {
            let mut view = OccludedView::default();
            view.set_target(viewer, &visible, 0.0);
            view
        })
    }

    /// Makes this the view of another pair without obstructions; memory is kept.
    pub fn set_polygon(&mut self, viewer: &ConvexPolygon, target: &ConvexPolygon) {
        self.set_target(viewer, &target.corners, 1.0);
    }

    fn set_target(&mut self, viewer: &ConvexPolygon, c: &[Vec3], weight: f64) {
        self.viewer.clear();
        self.viewer.extend_from_slice(&viewer.corners);
        let twice = (2..c.len()).fold(Vec3::ZERO, |s, k| s + (c[k - 1] - c[0]).cross(c[k] - c[0]));
        let n = twice.normalized();
        let (e, f) = n.frame();
        self.axes = [e, f, n];
        self.weight = weight;
        self.base = c[0] * weight;
        self.anchor = self.turned(c[0] - self.base);
        self.normal = self.turned(viewer.normal);
        self.whole.clear();
        self.whole.extend(c.iter().map(|p| [e.dot(*p - c[0]), f.dot(*p - c[0])]));
        self.bodies.clear();
        self.edges.clear();
        self.planes.clear();
    }

    /// A vector in the target's frame.
    fn turned(&self, v: Vec3) -> Vec3 {
        let [e, f, n] = self.axes;
        vec3(e.dot(v), f.dot(v), n.dot(v))
    }

    /// Number of obstructions.
    pub fn obstructions(&self) -> usize {
        self.bodies.len()
    }

    /// Adds an obstruction. All of it that lies in a cone from a point of the viewer lies before the target ([`ConvexBody::in_front_of`]).
    pub fn add(&mut self, body: &ConvexBody) {
        let first = self.planes.len();
        self.sides.clear();
        for (n, c) in body.planes() {
            let heights = || self.viewer.iter().map(|x| n.dot(*x) - c);
            let side = if heights().all(|h| h <= 0.0) {
                FaceSide::Back
            } else if heights().all(|h| h > 0.0) {
                FaceSide::Front
            } else {
                let number = (self.planes.len() - first) as u32;
                let plane = (self.turned(*n), c - n.dot(self.base));
                self.planes.push(plane);
                FaceSide::Undecided(number)
            };
            self.sides.push(side);
        }
        let corner = |view: &OccludedView, k: u32| view.turned(body.corners()[k as usize] - view.base);
        for decided in [true, false] {
            for edge in body.edges() {
                let faces = edge.faces.map(|f| self.sides[f as usize]);
                let is_decided = !faces.iter().any(|f| matches!(f, FaceSide::Undecided(_)));
                if is_decided != decided || faces[0] == faces[1] {
                    continue;
                }
                let [from, to] = edge.ends.map(|k| corner(self, k));
                let turned = is_decided && faces[0] == FaceSide::Back;
                self.edges.push(if turned {
                    ViewEdge { from: to, to: from, faces: [faces[1], faces[0]] }
                } else {
                    ViewEdge { from, to, faces }
                });
            }
            if decided {
                let end = self.edges.len();
                self.bodies.push(ViewBody { edges: [end; 2], planes: 0, is_plate: body.is_plate() });
            }
        }
        let (edges, planes) = (self.edges.len(), self.planes.len());
        if let Some(made) = self.bodies.last_mut() {
            (made.edges[1], made.planes) = (edges, planes);
        }
    }

    /// ω⊥ of the part of the target visible from `x`, sr.
    pub(super) fn seen_from(&mut self, x: Vec3) -> f64 {
        let x = self.turned(x - self.base);
        let origin = self.anchor - x * self.weight;
        self.visible.restart(&self.whole);
        let (mut edge, mut plane) = (0, 0);
        for k in 0..self.bodies.len() {
            match self.set_cone(k, [edge, plane], x, origin) {
                Hidden::Nothing => {}
                Hidden::Everything => return 0.0,
                Hidden::Cone => {
                    self.visible.subtract(&self.cone);
                    if self.visible.pieces.is_empty() {
                        return 0.0;
                    }
                }
            }
            (edge, plane) = (self.bodies[k].edges[1], self.bodies[k].planes);
        }
        self.sum_of_pieces(origin)
    }

    /// An upper bound of 𝓕 of `a`, a part of the viewing polygon, and a target polygon, m²:
    ///
    /// ```text
    /// 𝓕 ≤ A_a A_b c_a c_b/(π d²),      c = min(1, h/d)
    /// ```
    ///
    /// with d at most the least distance, h the largest height of the one over the plane of the other; infinite for polygons that touch.
    pub(super) fn exchange_limit(&self, a: &ConvexPolygon) -> f64 {
        let [e, f, n] = self.axes;
        let target: Vec<Vec3> = self.whole.iter().map(|[s, t]| self.base + e * *s + f * *t).collect();
        let distance = least_distance(&a.corners, &target);
        if distance <= 0.0 {
            return f64::INFINITY;
        }
        let over_viewer = target.iter().fold(0.0f64, |h, p| h.max(a.height(*p)));
        let over_target = a.corners.iter().fold(0.0f64, |h, p| h.max(n.dot(*p - self.base)));
        let cosines = (over_viewer / distance).min(1.0) * (over_target / distance).min(1.0);
        let w = &self.whole;
        let twice = (2..w.len()).fold(0.0, |sum, k| {
            let [p, q] = [k - 1, k].map(|k| [w[k][0] - w[0][0], w[k][1] - w[0][1]]);
            sum + p[0] * q[1] - p[1] * q[0]
        });
        a.area * 0.5 * twice * cosines / (std::f64::consts::PI * distance * distance)
    }

    /// ω⊥ of the whole target from `x`, sr.
    pub(super) fn unobstructed_from(&mut self, x: Vec3) -> f64 {
        self.visible.restart(&self.whole);
        self.sum_of_pieces(self.anchor - self.turned(x - self.base) * self.weight)
    }

    fn sum_of_pieces(&self, origin: Vec3) -> f64 {
        let pieces = self.visible.pieces.iter().map(|p| self.visible.of(*p));
        pieces.map(|p| projected_solid_angle(p, origin, self.normal)).sum::<f64>().max(0.0)
    }

    /// The lines of the cone over obstruction `k`, whose edges and undecided faces begin at `first`.
    fn set_cone(&mut self, k: usize, first: [usize; 2], x: Vec3, origin: Vec3) -> Hidden {
        let body = self.bodies[k];
        self.cone.clear();
        for edge in &self.edges[first[0]..body.edges[0]] {
            if !push_line(&mut self.cone, &self.whole, [edge.from - x, edge.to - x], origin) {
                return Hidden::Nothing;
            }
        }
        if body.edges[0] < body.edges[1] {
            self.fronts.clear();
            self.fronts.extend(self.planes[first[1]..body.planes].iter().map(|(n, c)| n.dot(x) > *c));
            let shows = |side: FaceSide| match side {
                FaceSide::Front => true,
                FaceSide::Back => false,
                FaceSide::Undecided(n) => self.fronts[n as usize],
            };
            for edge in &self.edges[body.edges[0]..body.edges[1]] {
                let ends = match edge.faces.map(shows) {
                    [true, false] => [edge.from - x, edge.to - x],
                    [false, true] => [edge.to - x, edge.from - x],
                    _ => continue,
                };
                if !push_line(&mut self.cone, &self.whole, ends, origin) {
                    return Hidden::Nothing;
                }
            }
        }
        // Without lines a plate is seen edge-on; a point that no face of a solid shows itself to lies inside.
        if !self.cone.is_empty() {
            Hidden::Cone
        } else if body.is_plate {
            Hidden::Nothing
        } else {
            Hidden::Everything
        }
    }
}

/// At most the least distance between two hulls of points: that of their boxes, and that of balls about their means, m.
fn least_distance(p: &[Vec3], q: &[Vec3]) -> f64 {
    let of = |points: &[Vec3]| {
        let mean = points.iter().fold(Vec3::ZERO, |s, x| s + *x) / points.len() as f64;
        let radius = points.iter().fold(0.0f64, |s, x| s.max((*x - mean).length()));
        let lo = points.iter().fold(points[0], |s, x| s.min(*x));
        let hi = points.iter().fold(points[0], |s, x| s.max(*x));
        (mean, radius, lo, hi)
    };
    let ((a, r, lo, hi), (b, s, low, high)) = (of(p), of(q));
    let apart = (low - hi).max(lo - high).max(Vec3::ZERO);
    apart.length().max((a - b).length() - r - s)
}

/// Adds the line through an edge of a silhouette; false if all of the target lies outside it.
fn push_line(cone: &mut Vec<ConeLine>, whole: &[PlaneCorner], [from, to]: [Vec3; 2], origin: Vec3) -> bool {
    let plane = to.cross(from);
    let line = [plane.x, plane.y, plane.dot(origin)];
    if whole.iter().all(|p| height(&line, p) <= 0.0) {
        return false;
    }
    cone.push(line);
    true
}

/// The part of a convex cone of directions on the positive side of a plane through its apex.
pub(super) fn directions_in_front(cell: &[Vec3], normal: Vec3) -> Vec<Vec3> {
    let mut kept = Vec::with_capacity(cell.len() + 1);
    for (i, d) in cell.iter().enumerate() {
        let e = cell[(i + 1) % cell.len()];
        let (h, k) = (normal.dot(*d), normal.dot(e));
        if h >= 0.0 {
            kept.push(*d);
        }
        if h * k < 0.0 {
            kept.push(*d + (e - *d) * (h / (h - k)));
        }
    }
    kept
}

/// Square of the tangent of an angle below which the series of the arc tangent holds to rounding with [`ARC_SERIES`].
const MAX_SERIES_TANGENT2: f64 = 0.01;
/// Coefficients of −u², u⁴, … in arctan(u)/u.
const ARC_SERIES: [f64; 7] = [1.0 / 3.0, 1.0 / 5.0, 1.0 / 7.0, 1.0 / 9.0, 1.0 / 11.0, 1.0 / 13.0, 1.0 / 15.0];

/// The angle between two vectors over the length of their cross product, from the square of that and their scalar product.
fn angle_over_sine(sine2: f64, cosine: f64) -> f64 {
    if cosine > 0.0 && sine2 < MAX_SERIES_TANGENT2 * cosine * cosine {
        let u2 = sine2 / (cosine * cosine);
        // Horner's rule for 1 − u²/3 + u⁴/5 − …
        return (1.0 - u2 * ARC_SERIES.iter().rev().fold(0.0, |s, c| c - u2 * s)) / cosine;
    }
    let sine = sine2.sqrt();
    sine.atan2(cosine) / sine
}

/// Lambert's sum over the edges of a piece, sr: positive for one that shows its front to the origin.
fn projected_solid_angle(piece: &[PlaneCorner], origin: Vec3, normal: Vec3) -> f64 {
    let at = |p: &PlaneCorner| vec3(origin.x + p[0], origin.y + p[1], origin.z);
    let Some(last) = piece.last() else { return 0.0 };
    let (mut sum, mut a) = (0.0, at(last));
    for p in piece {
        let b = at(p);
        let c = a.cross(b);
        let sine2 = c.length2();
        if sine2 > 0.0 {
            sum += angle_over_sine(sine2, a.dot(b)) * normal.dot(c);
        }
        a = b;
    }
    -0.5 * sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_reference::Rng;

    /// The faces of a body as plates.
    fn faces(body: &ConvexBody) -> Vec<ConvexBody> {
        let face = |f: u32| {
            let of_face = |e: &super::super::convex_body::BodyEdge| match e.faces {
                [a, _] if a == f => Some(e.ends),
                [_, b] if b == f => Some([e.ends[1], e.ends[0]]),
                _ => None,
            };
            let edges: Vec<[u32; 2]> = body.edges().iter().filter_map(of_face).collect();
            let mut outline = vec![edges[0][0]];
            while outline.len() < edges.len() {
                let last = outline[outline.len() - 1];
                outline.push(edges.iter().find(|e| e[0] == last).expect("a closed face")[1]);
            }
            let corners = outline.iter().map(|k| body.corners()[*k as usize]).collect();
            ConvexBody::plate(&ConvexPolygon::new(corners).expect("a face"))
        };
        (0..body.planes().len() as u32).map(face).collect()
    }

    /// A box with edges along a random frame.
    fn block(random: &mut Rng, middle: Vec3, size: f64) -> ConvexBody {
        let mut number = || 2.0 * random.uniform() - 1.0;
        let n = vec3(number(), number(), number()).normalized();
        let (e, f) = n.frame();
        let (e, f, n) = (e * size, f * (0.3 * size), n * (0.6 * size));
        let sign = |bit: usize, k: usize| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let corners = (0..8).map(|k| middle + e * sign(0, k) + f * sign(1, k) + n * sign(2, k)).collect();
        let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        ConvexBody::solid(corners, &faces.map(|f| f.to_vec()), 1e-12).expect("a box")
    }

    fn square(z: f64, size: f64) -> ConvexPolygon {
        let s = if z > 0.0 { -size } else { size };
        let corners = [[-size, -s], [size, -s], [size, s], [-size, s]].map(|[x, y]| vec3(x, y, z));
        ConvexPolygon::new(corners.to_vec()).expect("a square")
    }

    fn view_of(viewer: &ConvexPolygon, target: &ConvexPolygon) -> OccludedView {
        let mut view = OccludedView::default();
        view.set_polygon(viewer, target);
        view
    }

    /// A solid hides what its faces hide, also where the target's plane cuts it or where a face shows itself to a part of the viewer.
    #[test]
    fn silhouettes_hide_what_faces_hide() {
        let (viewer, target) = (square(0.0, 1.0), square(2.0, 1.5));
        let mut random = Rng::new(7);
        let (mut partial, mut cut) = (0, 0);
        for _ in 0..300 {
            let mut at = |low: f64, high: f64| low + (high - low) * random.uniform();
            let (middle, size) = (vec3(at(-1.5, 1.5), at(-1.5, 1.5), at(-0.3, 2.2)), at(0.1, 0.6));
            let body = block(&mut random, middle, size);
            let Some(part) = body.in_front_of(&target, 1e-12) else { continue };
            cut += usize::from(part.planes().len() > body.planes().len());
            let mut solid = view_of(&viewer, &target);
            let mut sheets = solid.clone();
            solid.add(&part);
            for face in faces(&body) {
                face.in_front_of(&target, 1e-12).iter().for_each(|f| sheets.add(f));
            }
            for _ in 0..8 {
                let mut at = || 2.0 * random.uniform() - 1.0;
                let x = vec3(at(), at(), 0.0);
                let (one, other) = (solid.seen_from(x), sheets.seen_from(x));
                assert!((one - other).abs() < 1e-12, "{one} {other} {body:?} {x:?}");
                partial += usize::from(one > 0.0 && one < solid.unobstructed_from(x) - 1e-12);
            }
        }
        assert!(partial > 500 && cut > 50, "{partial} {cut}");
    }

    #[test]
    fn a_point_inside_a_solid_sees_nothing() {
        let (viewer, target) = (square(0.0, 1.0), square(2.0, 1.5));
        let mut view = view_of(&viewer, &target);
        view.add(&block(&mut Rng::new(1), vec3(0.0, 0.0, 0.1), 0.5));
        assert_eq!(view.seen_from(Vec3::ZERO), 0.0);
        assert!(view.seen_from(vec3(0.99, 0.99, 0.0)) > 0.0);
    }

    #[test]
    fn the_series_of_the_angle_meets_the_arc_tangent() {
        for k in 0..200 {
            let angle = 1e-6 + 0.001 * f64::from(k);
            let (sine, cosine) = (3.0 * angle.sin(), 3.0 * angle.cos());
            let ours = angle_over_sine(sine * sine, cosine);
            assert!((ours * sine - angle).abs() < 4.0 * f64::EPSILON * angle, "{angle}");
        }
    }
}
