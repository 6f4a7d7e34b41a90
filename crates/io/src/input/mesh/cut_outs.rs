//! Faces cut along the levels of the alpha of a picture, into flat pieces of one class of alpha each.
//!
//! A face is divided into quarters until a cell has one class ([`crate::input::images::alpha_map`]) or the smallest size. A smallest cell is two triangles, or one. Each is
//! split where alpha passes a threshold c: the roots of α − c on the edges between corners on different sides are joined by a line (*marching triangles*;
//! A. Doi, A. Koide, IEICE Trans. E74, 1991). The corners of the line lie on the contour; its distance from the contour is at most about h²/(8 r) for cells of size h and a contour
//! of radius r. Where a triangle has details that its edges miss, so that the share of a class differs from that of samples, a corner of
//! the triangle with the sampled area takes the place of the details: the area of each class is kept, not its shape.

use crate::input::images::alpha_map::AlphaClasses;
use zonal_math::{Vec3, low_discrepancy, vec3};
use zonal_scene::{Plate, PlateKind};

/// Samples of a smallest triangle.
const SAMPLES: usize = 128;
/// Difference between the share of the pieces and of the samples beyond which a triangle has details that its edges miss.
const MAX_SHARE_DIFFERENCE: f64 = 0.1;
/// Smallest area of a piece over that of its triangle; smaller ones are left out.
const MIN_PIECE_SHARE: f64 = 1e-3;
/// Halvings of a face that is smaller than a patch.
const MIN_HALVINGS: u32 = 4;
/// Steps of bisection: a root is known to 10⁻⁹ of an edge.
const BISECTIONS: usize = 30;

/// A piece of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CutPiece {
    /// Geometry.
    pub(crate) plate: Plate,
    /// Texture coordinates at (0, 0), (1, 0) and (0, 1) of the plate.
    pub(crate) uv: [[f64; 2]; 3],
    /// Class of alpha.
    pub(crate) class: usize,
}

impl CutPiece {
    /// Texture coordinates of the centre.
    pub(crate) fn centre_uv(&self) -> [f64; 2] {
        let t = if self.plate.kind == PlateKind::Triangle { 1.0 / 3.0 } else { 0.5 };
        TexturedPlate { plate: self.plate, uv: self.uv }.uv_at([t, t])
    }
}

/// A face with texture coordinates.
#[derive(Clone, Copy)]
pub(crate) struct TexturedPlate {
    pub(crate) plate: Plate,
    pub(crate) uv: [[f64; 2]; 3],
}

/// A corner of a cell: the parameters (u, v) of the face.
type Parameters = [f64; 2];
type Triangle = [Parameters; 3];

impl TexturedPlate {
    /// Texture coordinates at parameters of the plate.
    fn uv_at(&self, [u, v]: Parameters) -> [f64; 2] {
        [0, 1].map(|k| {
            self.uv[0][k] + u * (self.uv[1][k] - self.uv[0][k]) + v * (self.uv[2][k] - self.uv[0][k])
        })
    }
    /// The part of the face on a plate of its parameters.
    fn piece(&self, part: &Plate, class: usize) -> CutPiece {
        let along = |d: Vec3| self.plate.e1 * d.x + self.plate.e2 * d.y;
        let corner = |p: Vec3| self.uv_at([p.x, p.y]);
        let plate = Plate {
            origin: self.plate.at(part.origin.x, part.origin.y),
            e1: along(part.e1),
            e2: along(part.e2),
            kind: part.kind,
        };
        let uv = [part.origin, part.origin + part.e1, part.origin + part.e2].map(corner);
        CutPiece { plate, uv, class }
    }
    /// Halvings after which the cells are at most `cell` metres, a few of them cover the face, and they are not smaller than about `pixels_per_cell` pixels.
    pub(crate) fn halvings(&self, cell: f64, pixels_per_cell: f64, classes: &AlphaClasses<'_>) -> u32 {
        let edge = self.plate.e1.length().max(self.plate.e2.length());
        let [o, a, b] = self.uv.map(|uv| classes.map().pixel_place(uv));
        let pixels = [a, b].map(|p| (p[0] - o[0]).hypot(p[1] - o[1]));
        let halvings = |ratio: f64| ratio.log2().ceil().clamp(0.0, 30.0) as u32;
        let limit = halvings(pixels[0].max(pixels[1]) / pixels_per_cell);
        halvings(edge / cell).max(MIN_HALVINGS).min(limit)
    }
}

/// Limits of the cut of a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CutLimits {
    /// Most pieces.
    pub(crate) pieces: usize,
    /// Most work: a visited cell is 1, the split of a triangle [`SPLIT_WORK`].
    pub(crate) work: u64,
}

/// The pieces of a face, or the fraction of the face that was cut when a limit was met; and the work done.
pub(crate) struct CutFace {
    pub(crate) pieces: Result<Vec<CutPiece>, f64>,
    pub(crate) work: u64,
}

/// Work of the split of a triangle at a threshold, whose samples take a hundred times as long as the class of a cell.
const SPLIT_WORK: u64 = 100;

/// The pieces of a face in cells of `halvings` halvings.
pub(crate) fn cut(
    face: &TexturedPlate,
    classes: &AlphaClasses<'_>,
    halvings: u32,
    limits: CutLimits,
) -> CutFace {
    let mut cutter = Cutter { face, classes, limits, pieces: Vec::new(), work: 0, done: 0.0 };
    let whole =
        Plate { origin: Vec3::ZERO, e1: vec3(1.0, 0.0, 0.0), e2: vec3(0.0, 1.0, 0.0), kind: face.plate.kind };
    cutter.visit(&whole, halvings);
    let pieces = if cutter.is_over() {
        Err(cutter.done / whole.area())
    } else {
        Ok(cutter.pieces.iter().map(|(part, class)| face.piece(part, *class)).collect())
    };
    CutFace { pieces, work: cutter.work }
}

/// A face while it is cut.
struct Cutter<'a> {
    face: &'a TexturedPlate,
    classes: &'a AlphaClasses<'a>,
    limits: CutLimits,
    /// Pieces in the parameters of the face, with their classes.
    pieces: Vec<(Plate, usize)>,
    work: u64,
    /// Area of the cells that are cut, in the parameters of the face.
    done: f64,
}

impl Cutter<'_> {
    fn is_over(&self) -> bool {
        self.pieces.len() > self.limits.pieces || self.work > self.limits.work
    }
    /// Cuts a cell; returns its class if it has one.
    fn visit(&mut self, cell: &Plate, halvings: u32) -> Option<usize> {
        if self.is_over() {
            return None;
        }
        self.work += 1;
        let (corners, n) = cell.corners();
        let corners = corners.map(|c| [c.x, c.y]);
        let uniform = self.uniform_class(&corners[..n]);
        if let Some(class) = uniform {
            self.pieces.push((*cell, class));
            self.done += cell.area();
            return uniform;
        }
        if halvings == 0 {
            self.done += cell.area();
            let [a, b, c, d] = corners;
            self.split_levels([a, b, c]);
            if cell.kind == PlateKind::Parallelogram {
                self.split_levels([a, c, d]);
            }
            return None;
        }
        // Four quarters of one class are one cell.
        let first = self.pieces.len();
        let quarters = cell.quarters().map(|q| self.visit(&q, halvings - 1));
        if self.is_over() {
            return None;
        }
        if quarters[0].is_some() && quarters.iter().all(|class| *class == quarters[0]) {
            self.pieces.truncate(first);
            self.pieces.extend(quarters[0].map(|class| (*cell, class)));
            return quarters[0];
        }
        None
    }
    fn uniform_class(&self, corners: &[Parameters]) -> Option<usize> {
        let mut uv = [[0.0; 2]; 4];
        corners.iter().zip(&mut uv).for_each(|(p, uv)| *uv = self.face.uv_at(*p));
        self.classes.uniform_class(&uv[..corners.len()])
    }
    /// Splits a smallest triangle at the thresholds that its corners span: at the middle one alone where alpha rises from the lowest class to the
    /// highest, as at the edge of a hole.
    fn split_levels(&mut self, triangle: Triangle) {
        if let Some(class) = self.uniform_class(&triangle) {
            return self.add(triangle, class, triangle);
        }
        let top = self.classes.top();
        let of_corners = triangle.map(|p| self.classes.class(self.face.uv_at(p)));
        let spans_all = of_corners.contains(&0) && of_corners.contains(&top);
        let levels: Vec<[usize; 3]> = if spans_all {
            vec![[top.div_ceil(2), 0, top]]
        } else {
            (1..=top).map(|k| [k, k - 1, k]).collect()
        };
        let mut remaining = vec![triangle];
        let mut class_above = 0;
        for [k, below, above] in levels {
            self.work += SPLIT_WORK * remaining.len() as u64;
            let split = remaining.iter().map(|t| self.split(*t, self.classes.threshold(k)));
            let (low, high): (Vec<Vec<Triangle>>, Vec<Vec<Triangle>>) = split.unzip();
            low.into_iter().flatten().for_each(|t| self.add(t, below, triangle));
            remaining = high.into_iter().flatten().collect();
            class_above = above;
        }
        remaining.into_iter().for_each(|t| self.add(t, class_above, triangle));
    }
    fn add(&mut self, [a, b, c]: Triangle, class: usize, of: Triangle) {
        if area(&[a, b, c]) >= MIN_PIECE_SHARE * area(&of) {
            let point = |p: Parameters| vec3(p[0], p[1], 0.0);
            self.pieces.push((Plate::triangle(point(a), point(b), point(c)), class));
        }
    }
    /// The triangles of the parts below and above a threshold.
    fn split(&self, triangle: Triangle, threshold: f64) -> (Vec<Triangle>, Vec<Triangle>) {
        let rises = |p: &Parameters| self.classes.alpha(self.face.uv_at(*p)) >= threshold;
        let (low, high) = self.march(triangle, &rises);
        let inside: Vec<[f64; 3]> = samples().filter(|w| rises(&weighted(&triangle, *w))).collect();
        let share = inside.len() as f64 / SAMPLES as f64;
        let area_above: f64 = high.iter().map(area).sum();
        if (area_above - share * area(&triangle)).abs() <= MAX_SHARE_DIFFERENCE * area(&triangle) {
            return (low, high);
        }
        // The smaller part becomes the corner to which its samples are nearest.
        let sum = |k: usize| inside.iter().map(|w| w[k] - 1.0 / 3.0).sum::<f64>();
        let toward = |k: usize| if share < 0.5 { sum(k) } else { -sum(k) };
        let k = (1..3).fold(0, |best, k| if toward(k) > toward(best) { k } else { best });
        let (corner, rest) = corner_and_rest(&triangle, k, share.min(1.0 - share).sqrt());
        if share < 0.5 { (rest, vec![corner]) } else { (vec![corner], rest) }
    }
    /// [`Cutter::split`] by the roots on the edges.
    fn march(&self, t: Triangle, rises: &impl Fn(&Parameters) -> bool) -> (Vec<Triangle>, Vec<Triangle>) {
        let above = t.map(|p| rises(&p));
        let count = above.iter().filter(|a| **a).count();
        if count == 0 {
            return (vec![t], Vec::new());
        }
        if count == 3 {
            return (Vec::new(), vec![t]);
        }
        // Turn the corner that is alone to the front.
        let alone = count == 1;
        let k = above.iter().position(|a| *a == alone).unwrap_or(0);
        let [a, b, c] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
        let root = |p: Parameters, q: Parameters| {
            let (mut low, mut high) = if alone { (q, p) } else { (p, q) };
            for _ in 0..BISECTIONS {
                let middle = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
                if rises(&middle) { high = middle } else { low = middle }
            }
            high
        };
        let (p, q) = (root(a, b), root(a, c));
        let (corner, rest) = (vec![[a, p, q]], vec![[p, b, c], [p, c, q]]);
        if alone { (rest, corner) } else { (corner, rest) }
    }
}

fn area([a, b, c]: &Triangle) -> f64 {
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
}

/// The point with barycentric weights.
fn weighted(t: &Triangle, w: [f64; 3]) -> Parameters {
    [0, 1].map(|k| w[0] * t[0][k] + w[1] * t[1][k] + w[2] * t[2][k])
}

/// Barycentric weights of evenly distributed points (the R₂ sequence folded into the triangle), which no pattern of a texture repeats.
fn samples() -> impl Iterator<Item = [f64; 3]> {
    (0..SAMPLES).map(|k| {
        let [u, v] = low_discrepancy::r2(k, [0.5; 2]);
        let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
        [1.0 - u - v, u, v]
    })
}

/// The corner number `k` of a triangle, whose edges are the fraction `scale` of the triangle's, and the rest.
fn corner_and_rest(t: &Triangle, k: usize, scale: f64) -> (Triangle, Vec<Triangle>) {
    let [a, b, c] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
    let towards = |q: Parameters| [0, 1].map(|k| a[k] + scale * (q[k] - a[k]));
    let (p, q) = (towards(b), towards(c));
    ([a, p, q], vec![[p, b, c], [p, c, q]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::images::alpha_map::AlphaMap;
    use std::f64::consts::PI;

    fn unit_square(repeats: f64) -> TexturedPlate {
        TexturedPlate {
            plate: Plate::parallelogram(Vec3::ZERO, vec3(2.0, 0.0, 0.0), vec3(0.0, 0.0, 3.0)),
            uv: [[0.0, 0.0], [repeats, 0.0], [0.0, repeats]],
        }
    }

    fn pieces(face: &TexturedPlate, classes: &AlphaClasses<'_>, halvings: u32) -> Result<Vec<CutPiece>, f64> {
        cut(face, classes, halvings, CutLimits { pieces: 1 << 20, work: u64::MAX }).pieces
    }

    #[test]
    fn work_is_bounded_where_a_picture_repeats_without_end() {
        let map = disc(64);
        let classes = AlphaClasses::new(&map, 1.0, vec![0.5]);
        let face = unit_square(1000.0);
        let limits = CutLimits { pieces: 400_000, work: 100_000 };
        let found = cut(&face, &classes, 16, limits);
        assert!(found.work <= limits.work + 10 * SPLIT_WORK, "{}", found.work);
        assert!(found.pieces.is_err_and(|done| done < 0.01));
    }

    /// A disc of radius 0.3 with a rim of one pixel.
    fn disc(n: usize) -> AlphaMap {
        let value = |i: usize| {
            let place = |k: usize| (k as f64 + 0.5) / n as f64 - 0.5;
            let r = place(i % n).hypot(place(i / n));
            (255.0 * (0.5 + (0.3 - r) * n as f64).clamp(0.0, 1.0)).round() as u8
        };
        AlphaMap::new(n, n, (0..n * n).map(value).collect())
    }

    fn area_of(pieces: &[CutPiece], class: usize) -> f64 {
        pieces.iter().filter(|p| p.class == class).map(|p| p.plate.area()).sum()
    }

    #[test]
    fn areas_of_a_disc_converge_and_orientation_is_kept() {
        let map = disc(256);
        let classes = AlphaClasses::new(&map, 1.0, vec![0.5]);
        let face = unit_square(1.0);
        for (halvings, tolerance) in [(3, 0.03), (5, 2e-3), (7, 3e-4)] {
            let pieces = pieces(&face, &classes, halvings).expect("few pieces");
            let (disc, rest) = (area_of(&pieces, 1), area_of(&pieces, 0));
            assert!((disc / (6.0 * PI * 0.09) - 1.0).abs() < tolerance, "{halvings}: {disc}");
            assert!((disc + rest - 6.0).abs() < 2e-3, "{}", disc + rest);
            assert!(pieces.iter().all(|p| p.plate.normal() == face.plate.normal()));
        }
        let few = CutLimits { pieces: 10, work: u64::MAX };
        assert!(cut(&face, &classes, 7, few).pieces.is_err_and(|done| (0.0..0.2).contains(&done)));
    }

    #[test]
    fn details_below_the_cells_keep_their_area() {
        let map = disc(64);
        let classes = AlphaClasses::new(&map, 1.0, vec![0.5]);
        let face = unit_square(40.0);
        let pieces = pieces(&face, &classes, 2).expect("few pieces");
        assert!(pieces.len() < 100);
        let share = area_of(&pieces, 1) / 6.0;
        assert!((share / (PI * 0.09) - 1.0).abs() < 0.1, "{share}");
    }

    #[test]
    fn levels_of_a_ramp_have_their_shares() {
        let map = AlphaMap::new(256, 1, (0..256).map(|i| i as u8).collect());
        let classes = AlphaClasses::new(&map, 1.0, vec![0.2, 0.4, 0.9]);
        let face = unit_square(1.0);
        let pieces = pieces(&face, &classes, 6).expect("few pieces");
        for (class, share) in [0.2, 0.2, 0.5, 0.1].into_iter().enumerate() {
            let got = area_of(&pieces, class) / 6.0;
            assert!((got - share).abs() < 0.01, "{class}: {got}");
        }
        // A piece has the texture coordinates of its place.
        for p in &pieces {
            let [s, t] = p.uv[0];
            assert!((face.plate.at(s, t) - p.plate.origin).length() < 1e-12);
        }
    }
}
