//! The cross-section of an extruded geometry: pieces of lines between numbered vertices, which do not cross each other, in one period.
//!
//! Lines are cut where they cross, where an end of another one lies on them, and at the limits of the period. Ends within the contact distance of
//! each other, also as images, are one vertex: images that adjoin leave no gap.

/// Cross-section of a facet, front to the left of a → b, or of an obstruction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub a: [f64; 2],
    pub b: [f64; 2],
    pub facet: Option<u32>,
}

/// A vertex in an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct VertexImage {
    pub vertex: u32,
    pub image: i32,
}

/// A part of one line, or of two lines with opposite fronts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SectionPiece {
    /// Images 0, or 1 at the end of the period.
    pub ends: [VertexImage; 2],
    /// Facets with the front to the left and to the right.
    pub facets: [Option<u32>; 2],
}

/// Periods that a line may cross.
const MAX_PERIODS_OF_LINE: f64 = 64.0;
/// Vertices, at most.
const MAX_VERTICES: usize = 400;

/// Pieces in one period.
#[derive(Clone, Debug)]
pub(crate) struct Section {
    pub vertices: Vec<[f64; 2]>,
    pub pieces: Vec<SectionPiece>,
    pub period: Option<f64>,
    /// Where the period begins, m.
    pub start: f64,
    /// Largest displacement of an end, m.
    pub moved: f64,
    contact: f64,
}

fn difference(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

impl Section {
    /// None if facets overlap, or if there are too many vertices or images.
    pub(crate) fn new(lines: &[Line], period: Option<f64>, contact: f64) -> Option<Section> {
        let start = lines.iter().flat_map(|l| [l.a[0], l.b[0]]).fold(f64::INFINITY, f64::min);
        let mut section =
            Section { vertices: Vec::new(), pieces: Vec::new(), period, start, moved: 0.0, contact };
        let long = |l: &Line| period.is_some_and(|q| (l.a[0] - l.b[0]).abs() > MAX_PERIODS_OF_LINE * q);
        if lines.iter().any(long) {
            return None;
        }
        for l in lines {
            section.vertex(l.a);
            section.vertex(l.b);
            if section.vertices.len() > MAX_VERTICES {
                return None;
            }
        }
        section.add_crossings(lines)?;
        lines.iter().try_for_each(|l| section.add_pieces(l))?;
        Some(section)
    }

    /// The place of a vertex in an image, m.
    pub(crate) fn at(&self, v: VertexImage) -> [f64; 2] {
        let [u, z] = self.vertices[v.vertex as usize];
        [u + f64::from(v.image) * self.period.unwrap_or(0.0), z]
    }

    /// Lowest and highest vertex, m.
    pub(crate) fn heights(&self) -> [f64; 2] {
        self.vertices
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], v| [lo.min(v[1]), hi.max(v[1])])
    }

    fn image_of(&self, u: f64) -> i32 {
        self.period.map_or(0, |q| ((u - self.start + self.contact) / q).floor() as i32)
    }

    fn vertex(&mut self, p: [f64; 2]) -> VertexImage {
        let image = self.image_of(p[0]);
        let beside: &[i32] = if self.period.is_some() { &[0, -1, 1] } else { &[0] };
        for k in 0..self.vertices.len() as u32 {
            for by in beside {
                let v = VertexImage { vertex: k, image: image + by };
                let off = difference(self.at(v), p);
                let off = off[0].abs().max(off[1].abs());
                if off <= self.contact {
                    self.moved = self.moved.max(off);
                    return v;
                }
            }
        }
        self.vertices.push([p[0] - f64::from(image) * self.period.unwrap_or(0.0), p[1]]);
        VertexImage { vertex: self.vertices.len() as u32 - 1, image }
    }

    /// Vertices where lines cross each other and the limits of periods.
    fn add_crossings(&mut self, lines: &[Line]) -> Option<()> {
        for (k, l) in lines.iter().enumerate() {
            let e = difference(l.b, l.a);
            if let Some(q) = self.period {
                let [first, last] = [l.a[0].min(l.b[0]), l.a[0].max(l.b[0])].map(|u| self.image_of(u));
                for n in first + 1..=last {
                    let u = self.start + f64::from(n) * q;
                    self.vertex([u, l.a[1] + e[1] * ((u - l.a[0]) / e[0])]);
                }
            }
            for other in &lines[k + 1..] {
                for n in self.images_between(l, other) {
                    let by = f64::from(n) * self.period.unwrap_or(0.0);
                    let (c, f) = ([other.a[0] + by, other.a[1]], difference(other.b, other.a));
                    let det = cross(e, f);
                    let d = difference(c, l.a);
                    let (s, t) = (cross(d, f) / det, cross(d, e) / det);
                    if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
                        self.vertex([l.a[0] + s * e[0], l.a[1] + s * e[1]]);
                    }
                }
            }
            if self.vertices.len() > MAX_VERTICES {
                return None;
            }
        }
        Some(())
    }

    /// Images of the second line that may meet the first.
    fn images_between(&self, l: &Line, other: &Line) -> std::ops::RangeInclusive<i32> {
        let Some(q) = self.period else { return 0..=0 };
        let range = |l: &Line| [l.a[0].min(l.b[0]), l.a[0].max(l.b[0])];
        let ([a, b], [c, d]) = (range(l), range(other));
        ((a - d) / q).floor() as i32..=((b - c) / q).ceil() as i32
    }

    /// The pieces of a line between all vertices that lie on it.
    fn add_pieces(&mut self, l: &Line) -> Option<()> {
        let e = difference(l.b, l.a);
        let length = e[0].hypot(e[1]);
        let [first, last] = [l.a[0].min(l.b[0]), l.a[0].max(l.b[0])].map(|u| self.image_of(u));
        let mut on: Vec<(f64, VertexImage)> = Vec::new();
        for vertex in 0..self.vertices.len() as u32 {
            for image in first - 1..=last + 1 {
                let v = VertexImage { vertex, image };
                let d = difference(self.at(v), l.a);
                let along = (d[0] * e[0] + d[1] * e[1]) / length;
                let off = (cross(e, d) / length).abs();
                if off <= self.contact && (-self.contact..=length + self.contact).contains(&along) {
                    self.moved = self.moved.max(off);
                    on.push((along, v));
                }
                if self.period.is_none() {
                    break;
                }
            }
        }
        if self.period.is_none() {
            on.iter_mut().for_each(|(_, v)| v.image = 0);
        }
        on.sort_by(|a, b| a.0.total_cmp(&b.0));
        on.windows(2).try_for_each(|w| self.add_piece([w[0].1, w[1].1], l.facet))
    }

    fn add_piece(&mut self, mut ends: [VertexImage; 2], facet: Option<u32>) -> Option<()> {
        let middle = 0.5 * (self.at(ends[0])[0] + self.at(ends[1])[0]);
        let by = self.image_of(middle);
        ends.iter_mut().for_each(|v| v.image -= by);
        if ends.iter().any(|v| !(0..=1).contains(&v.image)) {
            return None;
        }
        let reversed = [ends[1], ends[0]];
        let side = match self.pieces.iter().position(|p| p.ends == ends || p.ends == reversed) {
            Some(k) => {
                let turned = usize::from(self.pieces[k].ends != ends);
                &mut self.pieces[k].facets[turned]
            }
            None => {
                self.pieces.push(SectionPiece { ends, facets: [None; 2] });
                &mut self.pieces.last_mut()?.facets[0]
            }
        };
        match (facet, *side) {
            (Some(_), Some(_)) => return None,
            (Some(f), None) => *side = Some(f),
            (None, _) => {}
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_cut_where_they_meet_and_at_the_period() {
        let line = |a, b, facet| Line { a, b, facet: Some(facet) };
        // A ground across two periods with a wall on it, and both sides of a sheet through the ground.
        let lines = [
            line([0.5, 0.0], [2.5, 0.0], 0),
            line([1.0, 0.0], [1.0, 1.0], 1),
            line([1.5, -1.0], [1.5, 1.0], 2),
            line([1.5, 1.0], [1.5, -1.0], 3),
        ];
        let made = Section::new(&lines, Some(2.0), 1e-9).expect("a section");
        let of = |f: u32| made.pieces.iter().filter(|p| p.facets.contains(&Some(f))).count();
        assert_eq!([of(0), of(1), of(2), of(3)], [3, 1, 2, 2]);
        assert_eq!(made.pieces.len(), 6);
        // Ground twice.
        let twice = [line([0.0, 0.0], [2.0, 0.0], 0), line([1.0, 0.0], [1.5, 0.0], 1)];
        assert!(Section::new(&twice, None, 1e-9).is_none());
        let period = [line([0.0, 0.0], [2.0, 0.0], 0), line([3.0, 0.0], [3.5, 0.0], 1)];
        assert!(Section::new(&period, Some(2.0), 1e-9).is_none());
    }
}
