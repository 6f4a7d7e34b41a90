//! Images of squares and cubes: triangles, parallelograms and boxes, with their points, distances and halves.
//!
//! A triangle o + u e₁ + (1 − u) v e₂ has the Jacobian 2A (1 − u); along u its edge is e₁ − v e₂, along v it is (1 − u) e₂.

use zonal_math::{Vec3, gauss_legendre};
use zonal_scene::{Plate, PlateKind};

/// Checks that a plate has an area and finite coordinates.
///
/// # Panics
/// Otherwise.
pub(super) fn assert_valid_plate(p: &Plate) {
    let finite = p.origin.is_finite() && p.e1.is_finite() && p.e2.is_finite();
    assert!(finite && p.area() > 0.0, "not a plate: {p:?}");
}

/// The parameter domain of a zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MappedShape {
    Triangle,
    Parallelogram,
    Box,
}

/// A triangle, parallelogram or box in a frame near the pair, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct MappedZone {
    pub corner: Vec3,
    edges: [Vec3; 3],
    kind: MappedShape,
    /// Unit normal of a plate.
    pub normal: Option<Vec3>,
    /// Area or volume.
    pub measure: f64,
}

/// One parameter of a zone, with the largest length of the edge along which a point moves.
pub(super) struct ParameterDirection {
    pub length: f64,
    /// The extreme edges.
    edges: [Vec3; 2],
    jacobian: Jacobian,
}

enum Jacobian {
    One,
    /// 2 (1 − u) along u.
    Falling,
    /// ∫ 2 (1 − u) du beside it.
    Mean,
}

impl ParameterDirection {
    /// Largest change of the height over a plane with that normal.
    pub(super) fn change(&self, normal: Vec3) -> f64 {
        self.edges.iter().fold(0.0f64, |m, e| m.max(normal.dot(*e).abs()))
    }
    /// The largest modulus of the Jacobian over the measure, on an ellipse with the semi-axis `long`.
    pub(super) fn weight(&self, long: f64) -> f64 {
        match self.jacobian {
            Jacobian::One | Jacobian::Mean => 1.0,
            Jacobian::Falling => 2.0 * (0.5 + long),
        }
    }
}

impl MappedZone {
    pub(super) fn plate(p: &Plate, corner: Vec3) -> MappedZone {
        let kind = match p.kind {
            PlateKind::Triangle => MappedShape::Triangle,
            PlateKind::Parallelogram => MappedShape::Parallelogram,
        };
        MappedZone {
            corner,
            edges: [p.e1, p.e2, Vec3::ZERO],
            kind,
            normal: Some(p.normal()),
            measure: p.area(),
        }
    }

    pub(super) fn cuboid(corner: Vec3, e: Vec3) -> MappedZone {
        let axis = |k: usize| {
            let mut v = [0.0; 3];
            v[k] = e[k];
            Vec3::from_array(v)
        };
        MappedZone {
            corner,
            edges: [axis(0), axis(1), axis(2)],
            kind: MappedShape::Box,
            normal: None,
            measure: e.product(),
        }
    }

    fn dimensions(&self) -> usize {
        if self.kind == MappedShape::Box { 3 } else { 2 }
    }

    pub(super) fn corners(&self) -> Vec<Vec3> {
        let [e, f, g] = self.edges;
        let flat: &[Vec3] = &match self.kind {
            MappedShape::Triangle => vec![Vec3::ZERO, e, f],
            MappedShape::Parallelogram => vec![Vec3::ZERO, e, e + f, f],
            MappedShape::Box => vec![Vec3::ZERO, e, f, g, e + f, e + g, f + g, e + f + g],
        };
        flat.iter().map(|v| self.corner + *v).collect()
    }

    pub(super) fn centre(&self) -> Vec3 {
        let all = self.edges[0] + self.edges[1] + self.edges[2];
        self.corner + if self.kind == MappedShape::Triangle { all / 3.0 } else { all * 0.5 }
    }

    /// Sum of the edges' lengths, an upper bound of the distance from the corner.
    pub(super) fn reach(&self) -> f64 {
        self.edges.iter().map(|e| e.length()).sum()
    }

    pub(super) fn diameter(&self) -> f64 {
        if self.kind == MappedShape::Box {
            (self.edges[0] + self.edges[1] + self.edges[2]).length()
        } else {
            self.reach()
        }
    }

    pub(super) fn longest(&self) -> f64 {
        let [e, f, g] = self.edges;
        let third = if self.kind == MappedShape::Triangle { (e - f).length() } else { g.length() };
        e.length().max(f.length()).max(third)
    }

    /// Least and largest height of the corners over a plane.
    pub(super) fn heights(&self, normal: Vec3, at: Vec3) -> [f64; 2] {
        let h = self.corners().into_iter().map(|c| normal.dot(c - at));
        h.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], h| [a.min(h), b.max(h)])
    }

    /// A lower bound of the least distance of two zones (gaps of their projections on a few axes, not positive where these overlap), and an
    /// upper bound of
    /// the largest.
    pub(super) fn distances(&self, o: &MappedZone) -> (f64, f64) {
        let (p, q) = (self.corners(), o.corners());
        let line = o.centre() - self.centre();
        let far = {
            let radius = |c: &[Vec3], at: Vec3| c.iter().fold(0.0f64, |m, x| m.max((*x - at).length()));
            line.length() + radius(&p, self.centre()) + radius(&q, o.centre())
        };
        let mut axes = vec![line];
        axes.extend(self.normal.iter().chain(&o.normal).copied());
        for b in [self, o] {
            if b.kind == MappedShape::Box {
                axes.extend(b.edges);
            }
        }
        let shadow = |c: &[Vec3], n: Vec3| {
            let h = c.iter().map(|x| n.dot(*x));
            h.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(h), b.max(h)))
        };
        let gap = |axis: Vec3| {
            let length = axis.length();
            if length == 0.0 {
                return 0.0;
            }
            let n = axis / length;
            let ((a, b), (c, d)) = (shadow(&p, n), shadow(&q, n));
            (c - b).max(a - d)
        };
        (axes.into_iter().map(gap).fold(0.0, f64::max), far)
    }

    pub(super) fn directions(&self) -> Vec<ParameterDirection> {
        let [e, f, _] = self.edges;
        if self.kind == MappedShape::Triangle {
            let (first, last) = (e.length(), (e - f).length());
            return vec![
                ParameterDirection {
                    length: first.max(last),
                    edges: [e, e - f],
                    jacobian: Jacobian::Falling,
                },
                ParameterDirection { length: f.length(), edges: [f, f], jacobian: Jacobian::Mean },
            ];
        }
        let straight =
            |e: &Vec3| ParameterDirection { length: e.length(), edges: [*e, *e], jacobian: Jacobian::One };
        self.edges[..self.dimensions()].iter().map(straight).collect()
    }

    /// The points of a tensor rule with weights that sum to one.
    pub(super) fn points(&self, counts: &[usize]) -> Vec<(Vec3, f64)> {
        let mut out = vec![(self.corner, 1.0)];
        if self.kind == MappedShape::Triangle {
            let (ru, rv) = (gauss_legendre::rule(counts[0]), gauss_legendre::rule(counts[1]));
            out.clear();
            for (i, u) in ru.nodes.iter().enumerate() {
                let rest = ru.nodes[ru.nodes.len() - 1 - i];
                for (v, wv) in rv.nodes.iter().zip(&rv.weights) {
                    let p = self.corner + self.edges[0] * *u + self.edges[1] * (rest * v);
                    out.push((p, ru.weights[i] * wv * 2.0 * rest));
                }
            }
            return out;
        }
        for (edge, n) in self.edges.iter().zip(counts) {
            let rule = gauss_legendre::rule(*n);
            let line = |(p, w): &(Vec3, f64)| {
                let (p, w) = (*p, *w);
                rule.nodes.iter().zip(&rule.weights).map(move |(s, v)| (p + *edge * *s, w * v))
            };
            out = out.iter().flat_map(line).collect();
        }
        out
    }

    /// Two zones of half the measure: the longest edge is cut.
    pub(super) fn halves(&self) -> [MappedZone; 2] {
        let [e, f, _] = self.edges;
        let with = |corner, edges| MappedZone { corner, edges, measure: 0.5 * self.measure, ..*self };
        if self.kind == MappedShape::Triangle {
            let [a, b, c] = [self.corner, self.corner + e, self.corner + f];
            let lengths = [e.length(), (f - e).length(), f.length()];
            // The apex across the longest side stays in both.
            let (apex, p, q) = if lengths[0] >= lengths[1] && lengths[0] >= lengths[2] {
                (c, a, b)
            } else if lengths[1] >= lengths[2] {
                (a, b, c)
            } else {
                (b, c, a)
            };
            let middle = (p + q) * 0.5;
            return [
                with(apex, [p - apex, middle - apex, Vec3::ZERO]),
                with(apex, [middle - apex, q - apex, Vec3::ZERO]),
            ];
        }
        let lengths = self.edges.map(|e| e.length());
        let longest = (0..3).fold(0, |m, k| if lengths[k] > lengths[m] { k } else { m });
        let mut edges = self.edges;
        edges[longest] = edges[longest] * 0.5;
        [with(self.corner, edges), with(self.corner + edges[longest], edges)]
    }
}
