//! Classification in single precision of the up to eight plates of a leaf: those that a segment cannot cross, and those that it
//! crosses for certain.
//!
//! With the symbols of [`crate::intersect`], m = −d·N and lengths in units of the scene's half size R about its centre, a crossing
//! needs
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
//! and one that holds with the slack to spare is: the tolerances of [`crate::intersect`] are below 10⁻⁸. Double precision decides
//! the plates in between, so no result depends on this classification.

use super::node::NODE_WIDTH;
use zonal_math::Vec3;
use zonal_math::simd::f32x8::{F32x8, F32x8Ops};
use zonal_scene::{Plate, PlateKind};

/// Slack of the heights, in units of E².
const HEIGHT_SLACK: f32 = 2e-5;
/// Slack of the edge inequalities, in units of D E (1 + E) |m|.
const EDGE_SLACK: f32 = 2e-5;
/// Slack of the edge inequalities where the sign of m is unknown, in units of D² E³.
const SIGN_SLACK: f32 = 1e-9;
/// D E² below which products may underflow and every plate is undecided.
const UNDERFLOW_LIMIT: f32 = 1e-15;

/// Up to eight plates side by side, and their range in the list of plates: five cache lines.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct LeafBlock {
    reach: f32,
    parallelograms: u32,
    first: u32,
    count: u32,
    origin: [F32x8; 3],
    e1: [F32x8; 3],
    e2: [F32x8; 3],
}

/// A segment in the tree's coordinates and in single precision.
pub(super) struct BlockSegment {
    a: [f32; 3],
    d: [f32; 3],
    /// D, the largest component of d.
    size: f32,
}

impl BlockSegment {
    #[inline(always)]
    pub(super) fn new(a: Vec3, d: Vec3) -> BlockSegment {
        let size = d.max_abs() as f32;
        BlockSegment { a: a.array().map(|x| x as f32), d: d.array().map(|x| x as f32), size }
    }
}

impl LeafBlock {
    /// The block of `plates`, the first of which is number `first` of the list. `place` maps a point, and `scale` a length, to the
    /// tree's coordinates.
    pub(super) fn new(plates: &[Plate], first: u32, place: impl Fn(Vec3) -> Vec3, scale: f64) -> LeafBlock {
        let lanes = |f: &dyn Fn(&Plate) -> f64| -> F32x8 {
            std::array::from_fn(|l| plates.get(l).map_or(0.0, |p| f(p) as f32))
        };
        let vectors = |f: &dyn Fn(&Plate) -> Vec3| [0, 1, 2].map(|k| lanes(&|p| f(p)[k]));
        let reach = |p: &Plate| {
            p.e1.length().max(p.e2.length()).max((p.e2 - p.e1).length()).max((p.e1 + p.e2).length())
        };
        let longest = plates.iter().map(reach).fold(0.0, f64::max) * scale;
        let flags = plates.iter().enumerate();
        let flags = flags.filter(|(_, p)| p.kind == PlateKind::Parallelogram).map(|(l, _)| 1 << l);
        LeafBlock {
            origin: vectors(&|p| place(p.origin)),
            e1: vectors(&|p| p.e1 * scale),
            e2: vectors(&|p| p.e2 * scale),
            reach: (longest as f32).next_up(),
            parallelograms: flags.sum(),
            first,
            count: plates.len().min(NODE_WIDTH) as u32,
        }
    }

    /// Starts to load the block.
    #[inline(always)]
    pub(super) fn prefetch<W: F32x8Ops>(&self, w: W) {
        w.prefetch(&self.reach);
        w.prefetch(&self.origin[2]);
        w.prefetch(&self.e1[1]);
        w.prefetch(&self.e2[0]);
        w.prefetch(&self.e2[2]);
    }

    /// Range of the plates in the list.
    #[inline(always)]
    pub(super) fn slots(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// Bit masks of the plates that the segment may cross, and of those that it crosses for certain.
    #[inline(always)]
    pub(super) fn classify<W: F32x8Ops>(&self, w: W, s: &BlockSegment) -> (u32, u32) {
        let (o, e1, e2) = (load(w, &self.origin), load(w, &self.e1), load(w, &self.e2));
        let d = [w.splat(s.d[0]), w.splat(s.d[1]), w.splat(s.d[2])];
        let p = [w.sub(w.splat(s.a[0]), o[0]), w.sub(w.splat(s.a[1]), o[1]), w.sub(w.splat(s.a[2]), o[2])];
        let normal = cross(w, &e1, &e2);
        let (start, along) = (dot(w, &p, &normal), dot(w, &d, &normal));
        let end = w.add(start, along);
        // Test the heights of both ends.
        let (lower, upper) = (w.min(start, end), w.max(start, end));
        let reach2 = self.reach * self.reach;
        let (high, low) = (w.splat(HEIGHT_SLACK * reach2), w.splat(-HEIGHT_SLACK * reach2));
        let straddling = w.le(lower, high) & w.le(low, upper) & ((1 << self.count) - 1);
        // Test the edges, with the slack against and in favour of a crossing.
        let q = cross(w, &p, &d);
        let zero = w.splat(0.0);
        let m = w.sub(zero, along);
        let (u, v) = (w.mul(m, dot(w, &q, &e2)), w.mul(along, dot(w, &q, &e1)));
        let (edge, edge2) = (s.size * self.reach, s.size * reach2);
        let sign = if edge2 < UNDERFLOW_LIMIT { f32::INFINITY } else { SIGN_SLACK * edge * edge2 };
        let steep = w.mul(w.splat(EDGE_SLACK * edge * (1.0 + self.reach)), w.max(m, along));
        let slack = w.add(steep, w.splat(sign));
        let (top, smaller, larger, sum) = (w.mul(m, m), w.min(u, v), w.max(u, v), w.add(u, v));
        let wide = w.add(top, slack);
        let may = w.le(w.sub(zero, slack), smaller) & w.le(larger, wide);
        let may = may & straddling & (w.le(sum, wide) | self.parallelograms);
        let narrow = w.sub(top, slack);
        let certain = w.le(lower, low) & w.le(high, upper) & w.le(slack, smaller) & w.le(larger, narrow);
        (may, certain & may & (w.le(sum, narrow) | self.parallelograms))
    }
}

// These are functions because closures do not inherit the target features of the SIMD kernel.

#[inline(always)]
fn load<W: F32x8Ops>(w: W, x: &[F32x8; 3]) -> [W::Vector; 3] {
    [w.load(&x[0]), w.load(&x[1]), w.load(&x[2])]
}

#[inline(always)]
fn dot<W: F32x8Ops>(w: W, a: &[W::Vector; 3], b: &[W::Vector; 3]) -> W::Vector {
    w.add(w.add(w.mul(a[0], b[0]), w.mul(a[1], b[1])), w.mul(a[2], b[2]))
}

#[inline(always)]
fn cross<W: F32x8Ops>(w: W, a: &[W::Vector; 3], b: &[W::Vector; 3]) -> [W::Vector; 3] {
    [minor(w, a, b, 1, 2), minor(w, a, b, 2, 0), minor(w, a, b, 0, 1)]
}

/// a_i b_j − a_j b_i
#[inline(always)]
fn minor<W: F32x8Ops>(w: W, a: &[W::Vector; 3], b: &[W::Vector; 3], i: usize, j: usize) -> W::Vector {
    w.sub(w.mul(a[i], b[j]), w.mul(a[j], b[i]))
}

#[cfg(test)]
mod tests {
    use super::super::common_plane::CommonPlane;
    use super::*;
    use crate::intersect::{PreparedLine, PreparedPlate, Tolerance};
    use zonal_math::low_discrepancy::hash_to_unit;
    use zonal_math::simd::f32x8::{F32x8Dispatch, F32x8Kernel};

    struct ClassifyKernel<'a>(&'a LeafBlock, &'a BlockSegment);

    impl F32x8Kernel for ClassifyKernel<'_> {
        type Output = (u32, u32);
        #[inline(always)]
        fn evaluate<W: F32x8Ops>(self, w: W) -> (u32, u32) {
            self.0.classify(w, self.1)
        }
    }

    /// Random numbers in [−1, 1).
    struct TestRng(u64);

    impl TestRng {
        fn signed_uniform(&mut self) -> f64 {
            self.0 += 1;
            2.0 * hash_to_unit(self.0) - 1.0
        }
        fn point(&mut self) -> Vec3 {
            Vec3::from_array([self.signed_uniform(), self.signed_uniform(), self.signed_uniform()])
        }
    }

    /// Segments of all lengths towards interiors, edges and corners of plates of all sizes, or along their planes.
    #[test]
    fn classification_agrees_with_double_precision() {
        let tol = Tolerance { plane: 3e-9, rounding: 3e-12, edge: 3e-13 };
        let mut rng = TestRng(0);
        let (mut certain, mut rejected, mut undecided) = (0, 0, 0);
        for k in 0..60_000 {
            let size = 10f64.powf(-2.0 + 2.0 * rng.signed_uniform());
            let slim = 10f64.powi(-(k % 3));
            let kind = if k % 3 == 0 { PlateKind::Parallelogram } else { PlateKind::Triangle };
            let (e1, e2) = (rng.point() * size, rng.point() * size);
            let e2 = if k % 5 == 0 { e1 + e2 * slim } else { e2 * slim };
            let plate = Plate { origin: rng.point() * 0.5, e1, e2, kind };
            let block = LeafBlock::new(&[plate], 0, |x| x, 1.0);
            let prepared = PreparedPlate::new(&plate);
            for turn in 0..6 {
                let (u, v) = match turn % 3 {
                    0 => (0.5 + 0.5 * rng.signed_uniform(), 0.5 + 0.5 * rng.signed_uniform()),
                    1 => (rng.signed_uniform() * 1e-6, 0.5 + 0.5 * rng.signed_uniform()),
                    _ => (1.0 + rng.signed_uniform() * 1e-5, rng.signed_uniform() * 1e-5),
                };
                let aim = plate.at(u, v);
                let length = 10f64.powf(-2.0 + 2.0 * rng.signed_uniform());
                let mut path = rng.point() * length;
                if turn > 2 {
                    // Nearly along the plane.
                    let n = plate.normal();
                    path = path - n * (path.dot(n) * (1.0 - 10f64.powf(-5.0 + 5.0 * rng.signed_uniform())));
                }
                let clamped = |x: f64| x.clamp(-1.0, 1.0);
                let a = Vec3::from_array((aim - path).array().map(clamped));
                let b = Vec3::from_array((aim + path * rng.signed_uniform().abs()).array().map(clamped));
                let line = PreparedLine::new(a, b - a, &tol);
                let crossed = prepared.crosses(&line);
                let s = BlockSegment::new(a, b - a);
                let got = F32x8Dispatch::detect().run(ClassifyKernel(&block, &s));
                assert_eq!(got, F32x8Dispatch::scalar().run(ClassifyKernel(&block, &s)));
                assert!(got.0 == 1 || !crossed, "{plate:?} {a:?} {b:?}");
                assert!(got.1 == 0 || crossed, "{plate:?} {a:?} {b:?}");
                let plane = CommonPlane::of(&[plate], 1.0).expect("one plate has a plane");
                assert!(!(plane.never_crossed(&line) && crossed), "{plate:?} {a:?} {b:?}");
                match got {
                    (0, _) => rejected += 1,
                    (_, 0) => undecided += 1,
                    _ => certain += 1,
                }
            }
        }
        assert!(
            certain > 10_000 && rejected > 10_000 && undecided > 10_000,
            "{certain} {rejected} {undecided}"
        );
    }
}
