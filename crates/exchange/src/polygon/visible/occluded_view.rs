//! The projected solid angle of a convex polygon behind convex obstructions, from a point, in closed form.
//!
//! With x at the origin, the cone over a convex obstruction with corners o_k, taken so that its edges turn one way, is
//! {y: (o_k × o_{k+1})·y ≥ 0 for all k}. The difference of a convex polygon and the cone: cut at the first plane, keep the outer part, continue
//! with the inner part; the part inside all planes is hidden.

use super::convex_polygon::ConvexPolygon;
use zonal_math::Vec3;

/// Corners of an obstruction at most.
pub(super) const MAX_OBSTRUCTION_CORNERS: usize = 6;
/// Corners of a piece that a cone is taken from, at most: one with more is divided.
const MAX_ENTERING_CORNERS: usize = 10;
/// Corners of a piece at most: each plane of a cone adds one.
const MAX_PIECE_CORNERS: usize = MAX_ENTERING_CORNERS + MAX_OBSTRUCTION_CORNERS;

/// A convex polygon relative to the point of view.
#[derive(Clone, Copy)]
struct ConvexPiece {
    n: usize,
    p: [Vec3; MAX_PIECE_CORNERS],
}

impl ConvexPiece {
    const WITHOUT_CORNERS: ConvexPiece = ConvexPiece { n: 0, p: [Vec3::ZERO; MAX_PIECE_CORNERS] };

    fn push(&mut self, x: Vec3) {
        self.p[self.n] = x;
        self.n += 1;
    }

    /// The parts on the positive and on the negative side of the plane m·y = 0; `h` are the heights of the corners.
    fn split(&self, h: &[f64; MAX_PIECE_CORNERS]) -> (ConvexPiece, ConvexPiece) {
        let (mut inside, mut outside) = (ConvexPiece::WITHOUT_CORNERS, ConvexPiece::WITHOUT_CORNERS);
        for i in 0..self.n {
            let j = if i + 1 == self.n { 0 } else { i + 1 };
            if h[i] >= 0.0 {
                inside.push(self.p[i]);
            }
            if h[i] <= 0.0 {
                outside.push(self.p[i]);
            }
            if h[i] * h[j] < 0.0 {
                let x = self.p[i] + (self.p[j] - self.p[i]) * (h[i] / (h[i] - h[j]));
                inside.push(x);
                outside.push(x);
            }
        }
        (inside, outside)
    }

    /// Two pieces of a piece with many corners.
    fn split_in_two(&self) -> [ConvexPiece; 2] {
        let mut parts = [ConvexPiece::WITHOUT_CORNERS; 2];
        let middle = self.n / 2;
        (0..=middle).for_each(|k| parts[0].push(self.p[k]));
        (middle..=self.n).for_each(|k| parts[1].push(self.p[k % self.n]));
        parts
    }

    /// Lambert's sum, sr: positive for a piece that shows its front to the origin.
    fn projected_solid_angle(&self, normal: Vec3) -> f64 {
        let mut sum = 0.0;
        for i in 0..self.n {
            let (a, b) = (self.p[i], self.p[if i + 1 == self.n { 0 } else { i + 1 }]);
            let c = a.cross(b);
            let s = c.length();
            if s > 0.0 {
                sum += s.atan2(a.dot(b)) / s * normal.dot(c);
            }
        }
        -0.5 * sum
    }
}

/// A target and its obstructions, evaluated from many points.
pub(super) struct OccludedView<'a> {
    normal: Vec3,
    target: &'a ConvexPolygon,
    obstructions: &'a [ConvexPolygon],
    pieces: Vec<ConvexPiece>,
    spare: Vec<ConvexPiece>,
    cone: Vec<Vec3>,
}

impl<'a> OccludedView<'a> {
    /// A view along `normal` of `target`, which lies in front; the obstructions lie in front of both.
    pub(super) fn new(
        normal: Vec3,
        target: &'a ConvexPolygon,
        obstructions: &'a [ConvexPolygon],
    ) -> OccludedView<'a> {
        OccludedView { normal, target, obstructions, pieces: Vec::new(), spare: Vec::new(), cone: Vec::new() }
    }

    /// The area of the target, the scale of rounding errors, m².
    pub(super) fn scale(&self) -> f64 {
        self.target.area
    }

    /// ω⊥ of the part of the target visible from `x`, sr.
    pub(super) fn seen_from(&mut self, x: Vec3) -> f64 {
        self.pieces.clear();
        self.target.fan(MAX_ENTERING_CORNERS).for_each(|part| {
            let mut piece = ConvexPiece::WITHOUT_CORNERS;
            part.for_each(|c| piece.push(c - x));
            self.pieces.push(piece);
        });
        for k in 0..self.obstructions.len() {
            if self.set_cone(k, x) {
                self.subtract_cone();
            }
        }
        self.pieces.iter().map(|p| p.projected_solid_angle(self.normal)).sum::<f64>().max(0.0)
    }

    /// The planes of the cone over an obstruction; false if it occludes nothing of the target.
    fn set_cone(&mut self, k: usize, x: Vec3) -> bool {
        let (o, target) = (&self.obstructions[k], &self.target.corners);
        let height = o.height(x);
        if height == 0.0 {
            return false;
        }
        self.cone.clear();
        for i in 0..o.corners.len() {
            let (a, b) = (o.corners[i] - x, o.corners[(i + 1) % o.corners.len()] - x);
            // The front sees the corners counter-clockwise, the back clockwise.
            let plane = if height > 0.0 { b.cross(a) } else { a.cross(b) };
            if target.iter().all(|t| plane.dot(*t - x) <= 0.0) {
                return false;
            }
            self.cone.push(plane);
        }
        true
    }

    /// Subtracts the cone from the pieces.
    fn subtract_cone(&mut self) {
        self.spare.clear();
        while let Some(piece) = self.pieces.pop() {
            if piece.n > MAX_ENTERING_CORNERS {
                self.pieces.extend(piece.split_in_two());
                continue;
            }
            let (mut rest, done) = (piece, self.spare.len());
            for plane in &self.cone {
                let h: [f64; MAX_PIECE_CORNERS] =
                    std::array::from_fn(|k| if k < rest.n { plane.dot(rest.p[k]) } else { 0.0 });
                if h[..rest.n].iter().all(|x| *x <= 0.0) {
                    // The piece lies outside the cone and stays whole.
                    self.spare.truncate(done);
                    self.spare.push(piece);
                    break;
                }
                if h[..rest.n].iter().any(|x| *x < 0.0) {
                    let (inside, outside) = rest.split(&h);
                    self.spare.push(outside);
                    rest = inside;
                }
            }
        }
        std::mem::swap(&mut self.pieces, &mut self.spare);
    }
}
