//! The algorithm `Formfact` of the paper: all factors of one voxel with a voxel grid, strip by strip.
//!
//! A strip is a row of voxels along an axis. It is cut into segments; each has a reference voxel whose moments P_0 … P_N serve the
//! voxels on both sides of it (`series.rs`). What decides:
//!
//! * **The ratio follows from tolerance and order.** The truncation error relative to the factor is at most b(p̂) = p̂^{N+1}(N+2+(N+1)p̂),
//!   p̂ = |s|/(distance of the reference); p*(N) solves b = tolerance. The order with the longest reach for its cost is
//!   the plan's: a chain of references at ratio p covers distances in the ratio (1+p)/(1−p), so ln((1+p)/(1−p))/(N + N₀) is made largest.
//! * **References.** From one end: the farthest voxel that still reaches back to the first one not yet served is the reference, and serves as far as
//!   it reaches: no choice needs fewer. A segment then takes the smallest order that its own ratio asks for.
//! * **The axis** whose strips cost least, by a sample of strips.
//! * **Near voxels.** Where no rule is admissible (the boxes touch or nearly do) or the radius exceeds the tolerance, the exact
//!   integral; where a segment is so short that moments cost more than they save, the rule alone, without a series.
//!
//! Attenuation stays out here: e^{−κr} has no three-term recurrence along the strip. `chebyshev.rs` takes it along inside, `proposition1.rs` corrects it outside.

use super::nodes::{LANES, Line, Nodes};
use super::series::{self, MAX_ORDER};
use super::trapezoid::{Ladder, Shape};
use crate::aligned::{Cuboid, geometric_factor};
use zonal_math::{Bounded, Vec3, simd, vec3};
use zonal_scene::Voxmap;

const EPS: f64 = 0.5 * f64::EPSILON;

/// A regular grid of voxels; lengths in metres. Its order is that of [`Voxmap`]: z runs fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Voxels {
    /// Lower corner.
    pub origin: Vec3,
    /// Edges of a voxel.
    pub cell: Vec3,
    /// Voxels along each axis.
    pub dims: [usize; 3],
}

impl Voxels {
    /// The grid of a voxmap.
    pub fn of(map: &Voxmap) -> Voxels {
        Voxels { origin: map.min(), cell: map.cell(), dims: map.dims() }
    }
    /// Number of voxels.
    pub fn len(&self) -> usize {
        self.dims.iter().product()
    }
    /// True when an axis has no voxel.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Index of a voxel.
    pub fn index(&self, c: [usize; 3]) -> usize {
        (c[0] * self.dims[1] + c[1]) * self.dims[2] + c[2]
    }
    /// The voxel as a box.
    pub fn voxel(&self, c: [usize; 3]) -> Cuboid {
        let corner = |d: usize| {
            let at = |k: usize| self.origin[k] + self.cell[k] * (c[k] + d) as f64;
            vec3(at(0), at(1), at(2))
        };
        Cuboid::voxel(corner(0), corner(1))
    }
}

/// What is asked of the strips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ask {
    /// A relative radius for every factor.
    Tolerance(f64),
    /// A fixed order and the largest ratio p̂ < 1 of a reference; the radius is what comes out.
    Order {
        /// N, at most [`MAX_ORDER`].
        order: usize,
        /// p̂.
        ratio: f64,
    },
}

/// How the moments P_n are integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Means {
    /// Three dimensions: Gauss rules of the trapezoid densities, their points chosen by the bound.
    Reduced,
    /// Six dimensions as in the paper: this many Gauss–Legendre points in each direction of both voxels.
    Six(usize),
}

/// How many factors came about how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// By a series.
    pub series: usize,
    /// By the rule alone.
    pub direct: usize,
    /// By the exact integral: touching or too near.
    pub exact: usize,
    /// References whose moments were taken.
    pub references: usize,
}

/// All factors of one voxel with a grid.
#[derive(Clone, Debug)]
pub struct Formfact {
    /// Geometric factors in m⁴ in the grid's order.
    pub values: Vec<f64>,
    /// Their radii, proved.
    pub radii: Vec<f64>,
    /// By method.
    pub counts: Counts,
    /// The axis along which the strips ran.
    pub axis: usize,
    /// Evaluations of a kernel: nodes, times orders where there are any.
    pub evaluations: u64,
}

impl Formfact {
    /// One of the factors.
    pub fn get(&self, i: usize) -> Bounded {
        Bounded::proved(self.values[i], self.radii[i])
    }
}

/// The factors of voxel `v` with every voxel of the grid.
///
/// # Panics
/// On boxes that are none, a tolerance that is not positive, an order above [`MAX_ORDER`], a ratio outside (0, 1), six-dimensional
/// rules without points.
pub fn formfact(v: &Cuboid, voxels: &Voxels, ask: Ask, means: Means) -> Formfact {
    assert!(v.normal.is_none() && v.is_valid(), "not a voxel: {v:?}");
    assert!(voxels.is_empty() || voxels.voxel([0; 3]).is_valid(), "not a grid: {voxels:?}");
    let limits = limits(ask);
    // An axis with one voxel has no strips, unless they all have.
    let alone = voxels.dims.iter().all(|&n| n <= 1);
    let frame = |axis: usize| Frame::new(v, voxels, axis, ask, means, limits);
    let mut frames: Vec<Frame> =
        (0..3).filter(|&k| voxels.dims[k] > 1 || (alone && k == 0)).map(frame).collect();
    let costs: Vec<f64> =
        if frames.len() > 1 { frames.iter().map(Frame::sampled_cost).collect() } else { vec![0.0] };
    let best = (0..costs.len()).fold(0, |best, k| if costs[k] < costs[best] { k } else { best });
    work(v, voxels, frames.swap_remove(best))
}

/// The same with strips along a given axis.
///
/// # Panics
/// As [`formfact`].
pub fn along(v: &Cuboid, voxels: &Voxels, axis: usize, ask: Ask, means: Means) -> Formfact {
    assert!(axis < 3, "axis {axis}");
    work(v, voxels, Frame::new(v, voxels, axis, ask, means, limits(ask)))
}

fn work(v: &Cuboid, voxels: &Voxels, frame: Frame) -> Formfact {
    let (n, axis) = (voxels.len(), frame.axes[0]);
    let mut run = Run {
        frame,
        stock: Vec::new(),
        out: Formfact {
            values: vec![0.0; n],
            radii: vec![0.0; n],
            counts: Counts::default(),
            axis,
            evaluations: 0,
        },
    };
    simd::dispatch(
        #[inline(always)]
        || run.all(v, voxels),
    );
    run.out
}

/// The strip about one reference: `back` voxels before and `forth` after it along `axis`, all by its series of a given order,
/// whatever the ratio: where it is too large the radius says so. The exact integral for all where one is too near `v` for any rule.
///
/// # Panics
/// On boxes that are no voxels, an order above [`MAX_ORDER`].
pub fn about(
    v: &Cuboid,
    reference: &Cuboid,
    axis: usize,
    back: usize,
    forth: usize,
    order: usize,
) -> Formfact {
    assert!(v.normal.is_none() && v.is_valid() && reference.normal.is_none() && reference.is_valid());
    let (mut origin, mut dims) = (reference.lo.array(), [1; 3]);
    origin[axis] -= back as f64 * reference.extent()[axis];
    dims[axis] = back + 1 + forth;
    let origin = vec3(origin[0], origin[1], origin[2]);
    let voxels = Voxels { origin, cell: reference.extent(), dims };
    let ask = Ask::Order { order, ratio: 0.5 };
    let n = voxels.len();
    let out = Formfact {
        values: vec![0.0; n],
        radii: vec![f64::INFINITY; n],
        counts: Counts::default(),
        axis,
        evaluations: 0,
    };
    let mut run =
        Run { frame: Frame::new(v, &voxels, axis, ask, Means::Reduced, limits(ask)), stock: Vec::new(), out };
    let start = run.frame.centre(0, 0, 0);
    let aside = run.frame.aside(start);
    let whole = Segment { from: 0, reference: back, to: n - 1 };
    simd::dispatch(
        #[inline(always)]
        || run.serve(v, &voxels, [0, 0], start, aside, whole),
    );
    run.out
}

/// Orders that a plan considers.
const ORDERS: std::ops::RangeInclusive<usize> = 4..=40;
/// Strips along each of two axes by which the axis is chosen.
const SAMPLE: usize = 4;
/// What a reference costs beside its orders, in orders.
const SET_UP: f64 = 6.0;
/// A division, in orders: what a direct evaluation costs a node.
const DIVISION: usize = 5;
/// Shares of the tolerance for truncation and for quadrature; rounding gets the rest.
const TRUNCATION: f64 = 0.7;
const QUADRATURE: f64 = 0.2;
/// The relative tolerance of the rules, and of the exact integral, where an order is asked for.
const FINE: f64 = 1e-15;
const FINEST: f64 = 1e-13;
/// Coordinates so large against the distance that a factor moves by more than this: exact integral.
const SHAKY: f64 = 1e-9;

/// What is common to all strips along an axis. Lengths in steps; axes in the order strip, the next, the one after.
struct Frame {
    axes: [usize; 3],
    /// Centre of the first voxel minus centre of V_i.
    start: [f64; 3],
    /// Steps of the grid along the three axes (the first is 1).
    step: [f64; 3],
    count: [usize; 3],
    shapes: [Shape; 3],
    extents: [[f64; 2]; 3],
    ladders: [Ladder; 3],
    /// Which ladder an axis uses: equal ones share.
    like: [usize; 3],
    means: Means,
    ask: Ask,
    ratio: f64,
    truncation: f64,
    /// V_iV_j/(π d²), m⁴.
    front: f64,
    /// Error of a node in units of the step.
    shake: f64,
    /// Relative error of a voxel's volume by the rounding of its corners.
    grain: f64,
}

/// A reference and the voxels that it serves, both ends inside.
#[derive(Clone, Copy, Debug)]
struct Segment {
    from: usize,
    reference: usize,
    to: usize,
}

impl Frame {
    fn new(v: &Cuboid, voxels: &Voxels, axis: usize, ask: Ask, means: Means, limits: Limits) -> Frame {
        let axes = [axis, (axis + 1) % 3, (axis + 2) % 3];
        let d = voxels.cell[axis];
        let e = v.extent();
        let start = axes.map(|k| {
            let first = voxels.origin[k] + 0.5 * voxels.cell[k];
            (first - 0.5 * (v.lo[k] + v.hi[k])) / d
        });
        let extents = axes.map(|k| [e[k] / d, voxels.cell[k] / d]);
        let shapes = extents.map(|[a, b]| Shape::new(a, b));
        let h2 = shapes.iter().map(|s| s.half * s.half).sum();
        let (ratio, truncation, quadrature) = limits;
        let ladder = |k: usize| match means {
            Means::Reduced => Ladder::new(shapes[k].half, h2, quadrature / 3.0),
            Means::Six(m) => Ladder::fixed(extents[k], h2, m),
        };
        let far = voxels.voxel(voxels.dims.map(|n| n.max(1) - 1)).hi;
        let corners = [v.lo, v.hi, voxels.origin, far];
        let size = corners.iter().flat_map(|c| c.array()).fold(0.0f64, |m, x| m.max(x.abs()));
        Frame {
            axes,
            start,
            step: axes.map(|k| voxels.cell[k] / d),
            count: axes.map(|k| voxels.dims[k]),
            shapes,
            extents,
            ladders: [ladder(0), ladder(1), ladder(2)],
            like: [0, 1, 2].map(|k| if extents[k] == extents[0] { 0 } else { k }),
            means,
            ask,
            ratio,
            truncation,
            front: v.measure() * voxels.cell.product() / (std::f64::consts::PI * d * d),
            // Each coordinate of a node: at most eight roundings of numbers up to twice the largest coordinate.
            shake: 3f64.sqrt() * 16.0 * EPS * size / d,
            // Two corners, each within two roundings, on three axes.
            grain: 16.0 * EPS * size / axes.iter().fold(f64::INFINITY, |m, &k| m.min(voxels.cell[k])),
        }
    }

    fn centre(&self, i: usize, j: usize, k: usize) -> [f64; 3] {
        let at = |axis: usize, n: usize| self.start[axis] + self.step[axis] * n as f64;
        [at(0, i), at(1, j), at(2, k)]
    }

    /// Squared distance of the strip's line of boxes.
    #[inline(always)]
    fn aside(&self, centre: [f64; 3]) -> f64 {
        let gap = |k: usize| (centre[k].abs() - self.shapes[k].half).max(0.0);
        gap(1) * gap(1) + gap(2) * gap(2)
    }

    /// Distance of the boxes for a coordinate `x` of the centre along the strip.
    #[inline(always)]
    fn distance(&self, aside: f64, x: f64) -> f64 {
        let gap = (x.abs() - self.shapes[0].half).max(0.0);
        (aside + gap * gap).sqrt() * (1.0 - 1e-14) - self.shake
    }

    /// The segment that begins at voxel `from` of a strip of `n`.
    #[inline(always)]
    fn segment(&self, aside: f64, x0: f64, from: usize, n: usize) -> Segment {
        let reach = |i: usize| self.ratio * self.distance(aside, x0 + i as f64);
        let mut reference = from;
        while reference + 1 < n && (reference + 1 - from) as f64 <= reach(reference + 1) {
            reference += 1;
        }
        let forth = reach(reference).max(0.0) as usize;
        Segment { from, reference, to: (reference + forth).min(n - 1) }
    }

    /// The least distance of a segment's boxes.
    #[inline(always)]
    fn least(&self, aside: f64, x0: f64, s: &Segment) -> f64 {
        let (a, b) = (x0 + s.from as f64, x0 + s.to as f64);
        let x = if a * b <= 0.0 { 0.0 } else { a.abs().min(b.abs()) };
        self.distance(aside, x)
    }

    /// Points of the three rules at a distance, the relative error of the three together, and the factors of their defects.
    #[inline(always)]
    fn rules(&self, g: f64) -> Option<([usize; 3], f64, [f64; 3])> {
        if 2.0 * self.shake > SHAKY * g {
            return None;
        }
        let [a, b, c] = self.like.map(|k| self.ladders[k].at(g));
        let (a, b, c) = (a?, b?, c?);
        let error = a.error + b.error + c.error;
        Some(([a.points, b.points, c.points], error, [a.factor, b.factor, c.factor]))
    }

    fn order(&self, ratio: f64) -> usize {
        match self.ask {
            Ask::Order { order, .. } => order,
            Ask::Tolerance(_) => series::order_for(ratio, self.truncation),
        }
    }

    /// A guess of what all strips cost, by a sample of at most [`SAMPLE`]² of them.
    fn sampled_cost(&self) -> f64 {
        let [_, n, m] = self.count;
        let some = |n: usize| (0..n.min(SAMPLE)).map(move |i| (2 * i + 1) * n / (2 * n.min(SAMPLE)));
        let sum: f64 = some(n).flat_map(|j| some(m).map(move |k| (j, k))).map(|(j, k)| self.cost(j, k)).sum();
        sum * (n * m) as f64 / (n.min(SAMPLE) * m.min(SAMPLE)).max(1) as f64
    }

    /// A guess of what a strip costs.
    fn cost(&self, j: usize, k: usize) -> f64 {
        let centre = self.centre(0, j, k);
        let (aside, n) = (self.aside(centre), self.count[0]);
        let (mut from, mut cost) = (0, 0.0);
        while from < n {
            let s = self.segment(aside, centre[0], from, n);
            let voxels = s.to + 1 - s.from;
            let nodes = match self.rules(self.least(aside, centre[0], &s)) {
                Some((p, ..)) if self.means == Means::Reduced => p.iter().product::<usize>() as f64,
                Some((p, ..)) => p.iter().map(|m| m * m).product::<usize>() as f64,
                None => 20_000.0,
            };
            let ratio = (s.reference - s.from).max(s.to - s.reference) as f64
                / self.distance(aside, centre[0] + s.reference as f64);
            let orders = (DIVISION * voxels).min(DIVISION + self.order(ratio.min(self.ratio)));
            cost += nodes * orders as f64 + 40.0 * voxels as f64;
            from = s.to + 1;
        }
        cost
    }
}

/// The largest ratio, and the tolerances of truncation and quadrature.
type Limits = (f64, f64, f64);

/// What a demand leads to.
fn limits(ask: Ask) -> Limits {
    match ask {
        Ask::Order { order, ratio } => {
            assert!(order <= MAX_ORDER && ratio > 0.0 && ratio < 1.0, "order {order}, ratio {ratio}");
            (ratio, f64::INFINITY, FINE)
        }
        Ask::Tolerance(tolerance) => {
            assert!(tolerance > 0.0, "tolerance {tolerance}");
            let truncation = TRUNCATION * tolerance.clamp(FINEST, 0.1);
            let gain = |order: usize| {
                let p = series::ratio_for(order, truncation);
                (((1.0 + p) / (1.0 - p)).ln() / (order as f64 + SET_UP), p)
            };
            let best = ORDERS.step_by(3).map(gain).fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
            (best.1, truncation, QUADRATURE * tolerance.clamp(FINEST, 0.1))
        }
    }
}

struct Run {
    frame: Frame,
    /// Grids of nodes made so far, by their points.
    stock: Vec<([usize; 3], Nodes)>,
    out: Formfact,
}

impl Run {
    #[inline(always)]
    fn all(&mut self, v: &Cuboid, voxels: &Voxels) {
        let [n, nj, nk] = self.frame.count;
        for j in 0..nj {
            for k in 0..nk {
                let centre = self.frame.centre(0, j, k);
                let aside = self.frame.aside(centre);
                let mut from = 0;
                while from < n {
                    let segment = self.frame.segment(aside, centre[0], from, n);
                    self.serve(v, voxels, [j, k], centre, aside, segment);
                    from = segment.to + 1;
                }
            }
        }
    }

    fn cell(&self, i: usize, [j, k]: [usize; 2]) -> [usize; 3] {
        let mut c = [0; 3];
        (c[self.frame.axes[0]], c[self.frame.axes[1]], c[self.frame.axes[2]]) = (i, j, k);
        c
    }

    #[inline(always)]
    fn serve(
        &mut self,
        v: &Cuboid,
        voxels: &Voxels,
        strip: [usize; 2],
        start: [f64; 3],
        aside: f64,
        s: Segment,
    ) {
        let g = self.frame.least(aside, start[0], &s);
        let Some((points, error, factors)) = self.frame.rules(g) else {
            return self.exactly(v, voxels, strip, s.from..=s.to);
        };
        let found = self.stock.iter().position(|x| x.0 == points);
        let at = found.unwrap_or_else(|| self.make(points));
        let nodes = &self.stock[at].1;
        let defect: f64 = (0..3).map(|k| nodes.defect[k] * factors[k]).sum();
        // Relative errors: quadrature, shaken nodes and the common factor.
        let relative = error + defect + 2.0 * self.frame.shake / g + self.frame.grain + 16.0 * EPS;
        let mut centre = start;
        centre[0] += s.reference as f64;
        let reach = (s.reference - s.from).max(s.to - s.reference) as f64;
        let order = self.frame.order(reach / nodes.nearest(centre));
        let voxels_served = s.to + 1 - s.from;
        let mut doubtful = false;
        let tolerance = match self.frame.ask {
            Ask::Tolerance(t) => t,
            Ask::Order { .. } => f64::INFINITY,
        };
        let short = tolerance.is_finite() && DIVISION * voxels_served <= DIVISION + order;
        if short || order > MAX_ORDER {
            for i in s.from..=s.to {
                let mut centre = start;
                centre[0] += i as f64;
                let value = nodes.direct(centre);
                let radius = (relative + EPS * (nodes.blocks() as f64 + 12.0)) * value / (1.0 - relative);
                doubtful |= radius > tolerance * value;
                let index = voxels.index(self.cell(i, strip));
                self.out.values[index] = self.frame.front * value;
                self.out.radii[index] = 1.000_001 * self.frame.front * radius;
            }
            self.out.counts.direct += voxels_served;
            self.out.evaluations += (voxels_served * nodes.count) as u64;
        } else {
            let m = series::moments(nodes, centre, order, reach);
            let side = |k: usize| (centre[k].abs() - nodes.half[k]).max(0.0);
            let aside = (side(1) * side(1) + side(2) * side(2)) * (1.0 - 1e-14);
            let half = nodes.half[0];
            for first in (s.from..=s.to).step_by(LANES) {
                let shift: [f64; LANES] =
                    std::array::from_fn(|l| (first + l).min(s.to) as f64 - s.reference as f64);
                let fold = shift.map(|s| {
                    let gap = ((centre[0] + s).abs() - half).max(0.0);
                    1.0 / (aside + gap * gap)
                });
                let (value, bound) = series::evaluate(&m, shift, fold);
                for l in 0..LANES.min(s.to + 1 - first) {
                    let radius = (bound[l] + m.rounding + relative * value[l].abs()) / (1.0 - relative);
                    doubtful |= radius.is_nan() || radius > tolerance * value[l];
                    let index = voxels.index(self.cell(first + l, strip));
                    self.out.values[index] = self.frame.front * value[l];
                    self.out.radii[index] = 1.000_001 * self.frame.front * radius;
                }
            }
            self.out.counts.series += voxels_served;
            self.out.counts.references += 1;
            self.out.evaluations += (nodes.count * (order + 1)) as u64;
        }
        if doubtful {
            self.mend(v, voxels, strip, s);
        }
    }

    /// The nodes for these points.
    #[inline(never)]
    fn make(&mut self, points: [usize; 3]) -> usize {
        let f = &self.frame;
        let line = |k: usize| match f.means {
            Means::Reduced => Line::reduced(&f.shapes[k], points[k]),
            Means::Six(m) => Line::product(f.extents[k][0], f.extents[k][1], m),
        };
        let first = line(0);
        let other = |k: usize| (f.extents[k] != f.extents[0] || points[k] != points[0]).then(|| line(k));
        let (second, third) = (other(1), other(2));
        let nodes =
            Nodes::tensor([&first, second.as_ref().unwrap_or(&first), third.as_ref().unwrap_or(&first)]);
        self.stock.push((points, nodes));
        self.stock.len() - 1
    }

    /// The exact integral for those of a segment that missed the tolerance.
    #[cold]
    fn mend(&mut self, v: &Cuboid, voxels: &Voxels, strip: [usize; 2], s: Segment) {
        let Ask::Tolerance(tolerance) = self.frame.ask else { return };
        for i in s.from..=s.to {
            let index = voxels.index(self.cell(i, strip));
            let radius = self.out.radii[index];
            if radius.is_nan() || radius > tolerance * self.out.values[index] {
                self.exactly(v, voxels, strip, i..=i);
            }
        }
    }

    #[cold]
    fn exactly(
        &mut self,
        v: &Cuboid,
        voxels: &Voxels,
        strip: [usize; 2],
        range: std::ops::RangeInclusive<usize>,
    ) {
        let tolerance = match self.frame.ask {
            Ask::Tolerance(t) => t,
            Ask::Order { .. } => FINEST,
        };
        for i in range {
            let cell = self.cell(i, strip);
            let f = geometric_factor(v, &voxels.voxel(cell), 0.0, tolerance);
            let index = voxels.index(cell);
            self.out.values[index] = f.bounded.value;
            self.out.radii[index] = f.bounded.radius;
            self.out.counts.exact += 1;
            self.out.evaluations += f.evaluations;
        }
    }
}
