//! The projected solid angle of a convex target behind convex obstructions, from a point, in closed form.
//!
//! With x at the origin, the cone over a convex obstruction with corners o_k, taken so that its edges turn one way, is
//! {y: (o_k × o_{k+1})·y ≥ 0 for all k}. The visible pieces of the target stay in its plane, y = c + s e₁ + t e₂, where each side of the cone is a
//! line a s + b t + d = 0. The difference of a convex piece and the cone: cut at the first line, keep the outer part, continue with
//! the inner part; the part inside all lines is hidden.
//!
//! A target is a polygon, or a cone of directions: then c, e₁ and e₂ do not depend on x (weight 0).
//!
//! Cost: a piece that lies outside one of the lines stays where it is; otherwise each line that cuts it makes one more piece.

use super::convex_polygon::ConvexPolygon;
use zonal_math::Vec3;

/// A corner of a piece in the coordinates of the target's plane.
type PlaneCorner = [f64; 2];

/// A line a s + b t + d of the target's plane, positive inside the cone.
type ConeLine = [f64; 3];

fn height([a, b, d]: &ConeLine, [s, t]: &PlaneCorner) -> f64 {
    a * s + b * t + d
}

/// Convex pieces of the target; the corners of all stand in one array, which grows until the next point of view.
#[derive(Default)]
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

/// A target's corners in homogeneous coordinates: seen from x along corner − `weight` x. The weight is 1 for points and 0 for directions, which are
/// points at infinity.
#[derive(Clone, Debug)]
pub(super) struct Target {
    corners: Vec<Vec3>,
    weight: f64,
}

impl Target {
    /// A polygon by its corners, m.
    pub(super) fn polygon(corners: Vec<Vec3>) -> Target {
        Target { corners, weight: 1.0 }
    }
    /// The cone between directions that lie in one plane.
    pub(super) fn directions(corners: Vec<Vec3>) -> Target {
        Target { corners, weight: 0.0 }
    }
}

/// A convex target and its obstructions, evaluated from many points.
pub(super) struct OccludedView<'a> {
    normal: Vec3,
    target: Target,
    /// Frame of the target's plane at its first corner.
    frame: [Vec3; 2],
    /// The target in its frame.
    whole: Vec<PlaneCorner>,
    obstructions: &'a [ConvexPolygon],
    visible: PieceList,
    cone: Vec<ConeLine>,
}

impl<'a> OccludedView<'a> {
    /// A view along `normal` of `target`, which lies in front and has an area; the obstructions lie in front of both.
    pub(super) fn new(normal: Vec3, target: Target, obstructions: &'a [ConvexPolygon]) -> OccludedView<'a> {
        let c = &target.corners;
        let twice = (2..c.len()).fold(Vec3::ZERO, |s, k| s + (c[k - 1] - c[0]).cross(c[k] - c[0]));
        let (e, f) = twice.normalized().frame();
        let whole = c.iter().map(|p| [e.dot(*p - c[0]), f.dot(*p - c[0])]).collect();
        let visible = PieceList::default();
        OccludedView { normal, target, frame: [e, f], whole, obstructions, visible, cone: Vec::new() }
    }

    /// ω⊥ of the part of the target visible from `x`, sr.
    pub(super) fn seen_from(&mut self, x: Vec3) -> f64 {
        self.visible.restart(&self.whole);
        for k in 0..self.obstructions.len() {
            if self.set_cone(k, x) {
                self.visible.subtract(&self.cone);
                if self.visible.pieces.is_empty() {
                    return 0.0;
                }
            }
        }
        self.sum_of_pieces(x)
    }

    /// ω⊥ of the whole target from `x`, sr.
    pub(super) fn unobstructed_from(&mut self, x: Vec3) -> f64 {
        self.visible.restart(&self.whole);
        self.sum_of_pieces(x)
    }

    fn sum_of_pieces(&self, x: Vec3) -> f64 {
        let origin = self.target.corners[0] - x * self.target.weight;
        let pieces = self.visible.pieces.iter().map(|p| self.visible.of(*p));
        pieces.map(|p| self.projected_solid_angle(p, origin)).sum::<f64>().max(0.0)
    }

    /// The lines of the cone over an obstruction; false if it occludes nothing of the target.
    fn set_cone(&mut self, k: usize, x: Vec3) -> bool {
        let (o, target) = (&self.obstructions[k], &self.target);
        let height = o.height(x);
        if height == 0.0 {
            return false;
        }
        self.cone.clear();
        let origin = target.corners[0] - x * target.weight;
        let corners = &o.corners;
        let mut a = corners[0] - x;
        for i in 0..corners.len() {
            let b = corners[if i + 1 == corners.len() { 0 } else { i + 1 }] - x;
            // The front sees the corners counter-clockwise, the back clockwise.
            let plane = if height > 0.0 { b.cross(a) } else { a.cross(b) };
            let line = [plane.dot(self.frame[0]), plane.dot(self.frame[1]), plane.dot(origin)];
            if self.whole.iter().all(|p| self::height(&line, p) <= 0.0) {
                return false;
            }
            self.cone.push(line);
            a = b;
        }
        true
    }

    /// Lambert's sum over the edges of a piece, sr: positive for one that shows its front to the origin.
    fn projected_solid_angle(&self, piece: &[PlaneCorner], origin: Vec3) -> f64 {
        let [e, f] = self.frame;
        let at = |p: &PlaneCorner| origin + e * p[0] + f * p[1];
        let Some(last) = piece.last() else { return 0.0 };
        let (mut sum, mut a) = (0.0, at(last));
        for p in piece {
            let b = at(p);
            let c = a.cross(b);
            let s = c.length();
            if s > 0.0 {
                sum += s.atan2(a.dot(b)) / s * self.normal.dot(c);
            }
            a = b;
        }
        -0.5 * sum
    }
}
