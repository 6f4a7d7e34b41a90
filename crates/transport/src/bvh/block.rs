//! Up to eight plates of a leaf in single precision: which of them a segment cannot cross, and which it surely crosses.
//!
//! With the symbols of [`crate::meet`], m = −d·N and lengths in units of the scene's half size R about its centre, a crossing needs
//!
//! ```text
//! N·s ≷ 0 ≷ N·(s + d)      0 ≤ m q·e₂      0 ≤ −m q·e₁      m (q·e₂ − q·e₁) ≤ m²
//! ```
//!
//! (for a parallelogram the last with each term alone). Rounding to single precision, with |s| ≤ 2 and |d| ≤ D ≤ 2 a component, E
//! the longest edge and u = 2⁻²⁴: N is off by less than 10u E² a component, the heights N·s and N·(s + d) by less than 180u E²,
//! m by less than 45u D E², q·e by less than 80u D E. Where the plate is met, |q·e| ≤ |m|; the last inequality, the worst, is then
//! off by less than D E |m| (160u + 180u E), and, where m is so small that its sign is not known, by 10⁴u² D² E³ more. So with
//! slacks of 2·10⁻⁵ E² for the heights and D E |m| 2·10⁻⁵ (1 + E) + 10⁻⁹ D² E³ for the edges, a plate that fails is not crossed,
//! and one that holds with the slack to spare is: the tolerances of [`crate::meet`] are below 10⁻⁸. What lies between is decided in
//! double precision: no answer hangs on this sieve.
//!
//! **Flat blocks.** Walls are meshes of coplanar plates, and a segment in a wall, or from one, would be in doubt at all of them. The
//! plates of a flat block have one plane to 10⁻¹¹ R, far below the length ε at which an end counts as lying in it. So none is
//! crossed where the ends are not on both sides of it by 0.9 ε: [`Plane`], which is asked before the block is fetched.

use super::node::LANES;
use crate::meet::Line;
use zonal_math::Vec3;
use zonal_math::wide::{Lanes, Wide};
use zonal_scene::{Plate, PlateKind};

/// Slack of the heights, a unit of E².
const PLANE: f32 = 2e-5;
/// Slack of the edges' inequalities, a unit of D E (1 + E) |m|, and a unit of D² E³.
const EDGE: f32 = 2e-5;
const SIGN: f32 = 1e-9;
/// Below this D E² the products may underflow, and everything is in doubt.
const SMALL: f32 = 1e-15;

/// Plates side by side, and where they stand in the list of plates.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Block {
    origin: [Lanes; 3],
    e1: [Lanes; 3],
    e2: [Lanes; 3],
    reach: f32,
    parallelograms: u32,
    first: u32,
    count: u32,
}

/// The plane in which all plates of a block lie, m; not a number where there is none.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Plane {
    origin: Vec3,
    normal: Vec3,
}

/// How far the planes of a flat block may differ, in units of R.
const FLAT: f64 = 1e-11;
/// The share of ε within which an end lies in the plane of a flat block for certain.
const CERTAIN: f64 = 0.9;

/// A segment as the blocks see it.
pub(super) struct Segment {
    a: [f32; 3],
    d: [f32; 3],
    /// D
    size: f32,
}

impl Segment {
    #[inline(always)]
    pub(super) fn new(a: Vec3, d: Vec3) -> Segment {
        let size = d.max_abs() as f32;
        Segment { a: a.array().map(|x| x as f32), d: d.array().map(|x| x as f32), size }
    }
}

impl Block {
    /// Plates `first` … of the list; `place` takes a point, and `scale` a length, to the tree's coordinates.
    pub(super) fn new(plates: &[Plate], first: u32, place: impl Fn(Vec3) -> Vec3, scale: f64) -> Block {
        let lanes = |f: &dyn Fn(&Plate) -> f64| -> Lanes {
            std::array::from_fn(|l| plates.get(l).map_or(0.0, |p| f(p) as f32))
        };
        let vectors = |f: &dyn Fn(&Plate) -> Vec3| [0, 1, 2].map(|k| lanes(&|p| f(p)[k]));
        let reach = |p: &Plate| {
            p.e1.length().max(p.e2.length()).max((p.e2 - p.e1).length()).max((p.e1 + p.e2).length())
        };
        let longest = plates.iter().map(reach).fold(0.0, f64::max) * scale;
        let flags = plates.iter().enumerate();
        let flags = flags.filter(|(_, p)| p.kind == PlateKind::Parallelogram).map(|(l, _)| 1 << l);
        Block {
            origin: vectors(&|p| place(p.origin)),
            e1: vectors(&|p| p.e1 * scale),
            e2: vectors(&|p| p.e2 * scale),
            reach: (longest as f32).next_up(),
            parallelograms: flags.sum(),
            first,
            count: plates.len().min(LANES) as u32,
        }
    }

    /// The plates' numbers in the list.
    #[inline(always)]
    pub(super) fn run(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// A bit for each plate that the segment may cross, and for each that it surely crosses.
    #[inline(always)]
    pub(super) fn sieve<W: Wide>(&self, w: W, s: &Segment) -> (u32, u32) {
        let (o, e1, e2) = (load(w, &self.origin), load(w, &self.e1), load(w, &self.e2));
        let d = [w.splat(s.d[0]), w.splat(s.d[1]), w.splat(s.d[2])];
        let p = [w.sub(w.splat(s.a[0]), o[0]), w.sub(w.splat(s.a[1]), o[1]), w.sub(w.splat(s.a[2]), o[2])];
        let normal = cross(w, &e1, &e2);
        let (start, along) = (dot(w, &p, &normal), dot(w, &d, &normal));
        let end = w.add(start, along);
        let (least, most) = (w.min(start, end), w.max(start, end));
        let reach2 = self.reach * self.reach;
        let (high, low) = (w.splat(PLANE * reach2), w.splat(-PLANE * reach2));
        let parted = w.le(least, high) & w.le(low, most) & ((1 << self.count) - 1);
        if parted == 0 {
            return (0, 0);
        }
        let q = cross(w, &p, &d);
        let zero = w.splat(0.0);
        let m = w.sub(zero, along);
        let (u, v) = (w.mul(m, dot(w, &q, &e2)), w.mul(along, dot(w, &q, &e1)));
        let (edge, whole) = (s.size * self.reach, s.size * reach2);
        let sign = if whole < SMALL { f32::INFINITY } else { SIGN * edge * whole };
        let steep = w.mul(w.splat(EDGE * edge * (1.0 + self.reach)), w.max(m, along));
        let slack = w.add(steep, w.splat(sign));
        let (top, less, more, sum) = (w.mul(m, m), w.min(u, v), w.max(u, v), w.add(u, v));
        let wide = w.add(top, slack);
        let may = w.le(w.sub(zero, slack), less) & w.le(more, wide);
        let may = may & parted & (w.le(sum, wide) | self.parallelograms);
        if may == 0 {
            return (0, 0);
        }
        let narrow = w.sub(top, slack);
        let sure = w.le(least, low) & w.le(high, most) & w.le(slack, less) & w.le(more, narrow);
        (may, sure & may & (w.le(sum, narrow) | self.parallelograms))
    }
}

impl Plane {
    /// The common plane of plates, `scale` as for [`Block::new`].
    pub(super) fn new(plates: &[Plate], scale: f64) -> Plane {
        let Some(first) = plates.first() else {
            return NO_PLANE;
        };
        let (origin, normal) = (first.origin, first.normal());
        let level = |p: &Plate| {
            let (n, height) = (p.normal(), (p.origin - origin).dot(normal));
            let turn = (n - normal).max_abs().min((n + normal).max_abs());
            turn <= 0.1 * FLAT && height.abs() * scale <= FLAT
        };
        if plates.iter().all(level) { Plane { origin, normal } } else { NO_PLANE }
    }

    /// True when there is a plane and the segment a → a + d does not cross it for certain. Both ends must lie in the scene's bounds.
    #[inline(always)]
    pub(super) fn apart(&self, line: &Line) -> bool {
        let start = (line.a - self.origin).dot(self.normal);
        let end = start + line.d.dot(self.normal);
        let limit = CERTAIN * line.plane;
        // Not a number is no.
        (start >= -limit && end >= -limit) || (start <= limit && end <= limit)
    }
}

const NO_PLANE: Plane =
    Plane { origin: Vec3 { x: f64::NAN, y: f64::NAN, z: f64::NAN }, normal: Vec3 { x: 0.0, y: 0.0, z: 0.0 } };

// Functions, not closures: these would miss the wide instructions.

#[inline(always)]
fn load<W: Wide>(w: W, x: &[Lanes; 3]) -> [W::F; 3] {
    [w.load(&x[0]), w.load(&x[1]), w.load(&x[2])]
}

#[inline(always)]
fn dot<W: Wide>(w: W, a: &[W::F; 3], b: &[W::F; 3]) -> W::F {
    w.add(w.add(w.mul(a[0], b[0]), w.mul(a[1], b[1])), w.mul(a[2], b[2]))
}

#[inline(always)]
fn cross<W: Wide>(w: W, a: &[W::F; 3], b: &[W::F; 3]) -> [W::F; 3] {
    [minor(w, a, b, 1, 2), minor(w, a, b, 2, 0), minor(w, a, b, 0, 1)]
}

/// a_i b_j − a_j b_i
#[inline(always)]
fn minor<W: Wide>(w: W, a: &[W::F; 3], b: &[W::F; 3], i: usize, j: usize) -> W::F {
    w.sub(w.mul(a[i], b[j]), w.mul(a[j], b[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::meet::{Prepared, Tolerance};
    use zonal_math::sequence::unit;
    use zonal_math::wide::{Machine, Task};

    struct Sieve<'a>(&'a Block, &'a Segment);

    impl Task for Sieve<'_> {
        type Output = (u32, u32);
        #[inline(always)]
        fn go<W: Wide>(self, w: W) -> (u32, u32) {
            self.0.sieve(w, self.1)
        }
    }

    /// Numbers in [−1, 1).
    struct Dice(u64);

    impl Dice {
        fn roll(&mut self) -> f64 {
            self.0 += 1;
            2.0 * unit(self.0) - 1.0
        }
        fn point(&mut self) -> Vec3 {
            Vec3::from_array([self.roll(), self.roll(), self.roll()])
        }
    }

    /// Segments of all lengths that aim at insides, edges and corners, or run along the plane, of plates of all sizes.
    #[test]
    fn what_is_left_out_is_not_crossed_and_what_is_sure_is() {
        let tol = Tolerance { plane: 3e-9, rounding: 3e-12, edge: 3e-13 };
        let mut dice = Dice(0);
        let (mut sure, mut out, mut doubt) = (0, 0, 0);
        for k in 0..60_000 {
            let size = 10f64.powf(-2.0 + 2.0 * dice.roll());
            let slim = 10f64.powi(-(k % 3));
            let kind = if k % 3 == 0 { PlateKind::Parallelogram } else { PlateKind::Triangle };
            let (e1, e2) = (dice.point() * size, dice.point() * size);
            let e2 = if k % 5 == 0 { e1 + e2 * slim } else { e2 * slim };
            let plate = Plate { origin: dice.point() * 0.5, e1, e2, kind };
            let block = Block::new(&[plate], 0, |x| x, 1.0);
            let prepared = Prepared::new(&plate);
            for turn in 0..6 {
                let (u, v) = match turn % 3 {
                    0 => (0.5 + 0.5 * dice.roll(), 0.5 + 0.5 * dice.roll()),
                    1 => (dice.roll() * 1e-6, 0.5 + 0.5 * dice.roll()),
                    _ => (1.0 + dice.roll() * 1e-5, dice.roll() * 1e-5),
                };
                let aim = plate.at(u, v);
                let length = 10f64.powf(-2.0 + 2.0 * dice.roll());
                let mut way = dice.point() * length;
                if turn > 2 {
                    // Nearly along the plane.
                    let n = plate.normal();
                    way = way - n * (way.dot(n) * (1.0 - 10f64.powf(-5.0 + 5.0 * dice.roll())));
                }
                let inside = |x: f64| x.clamp(-1.0, 1.0);
                let a = Vec3::from_array((aim - way).array().map(inside));
                let b = Vec3::from_array((aim + way * dice.roll().abs()).array().map(inside));
                let line = Line::new(a, b - a, &tol);
                let crossed = prepared.crosses(&line);
                let s = Segment::new(a, b - a);
                let got = Machine::detect().run(Sieve(&block, &s));
                assert_eq!(got, Machine::plain().run(Sieve(&block, &s)));
                assert!(got.0 == 1 || !crossed, "{plate:?} {a:?} {b:?}");
                assert!(got.1 == 0 || crossed, "{plate:?} {a:?} {b:?}");
                assert!(!(Plane::new(&[plate], 1.0).apart(&line) && crossed), "{plate:?} {a:?} {b:?}");
                match got {
                    (0, _) => out += 1,
                    (_, 0) => doubt += 1,
                    _ => sure += 1,
                }
            }
        }
        assert!(sure > 10_000 && out > 10_000 && doubt > 10_000, "{sure} {out} {doubt}");
    }

    #[test]
    fn the_plates_of_a_wall_share_a_plane() {
        let at = |x: f64, y: f64| Vec3::from_array([x, y, 0.25 + 0.5 * x - 0.1 * y]);
        let triangle = |k: f64| Plate::triangle(at(k, 0.0), at(k + 1.0, 0.0), at(k, 1.0));
        let mut plates = vec![triangle(0.0), triangle(1.0), triangle(2.0)];
        let line = |a, b: Vec3| Line::new(a, b - a, &Tolerance { plane: 1e-9, rounding: 0.0, edge: 0.0 });
        let up = Vec3::from_array([0.1, 0.2, 9.0]);
        let rests = |plates: &[Plate], l: &Line| Plane::new(plates, 0.1).apart(l);
        assert!(rests(&plates, &line(at(0.3, 0.3), at(5.0, 8.0))));
        assert!(rests(&plates, &line(at(0.3, 0.3), up)));
        assert!(rests(&plates, &line(at(0.3, 0.3) + up * 1e-6, up)));
        assert!(!rests(&plates, &line(at(0.3, 0.3) - up * 1e-6, up)));
        plates.push(Plate::triangle(at(0.0, 0.0), at(1.0, 0.0), up));
        assert!(!rests(&plates, &line(at(0.3, 0.3), at(0.4, 0.4))));
    }
}
