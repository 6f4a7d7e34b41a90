//! The algorithm `Formfact` of the paper: the factors of one voxel with every voxel of a grid, strip by strip.
//!
//! A strip is a row of voxels along an axis. It is cut into segments; each has a reference voxel whose moments P_0 … P_N serve the
//! voxels on both sides of it (`gegenbauer.rs`). The plan:
//!
//! * **The ratio follows from tolerance and order.** The truncation error relative to the factor is at most b(p̂) = p̂^{N+1}(N+2+(N+1)p̂),
//!   p̂ = |s|/(distance of the reference); p*(N) solves b = tolerance. The plan takes the order with the longest reach for its cost: a chain of references at ratio p covers distances in the ratio (1+p)/(1−p), so ln((1+p)/(1−p))/(N + N₀) is made largest.
//! * **References.** From one end, the farthest voxel that reaches back to the first unserved voxel is the reference and serves as far as
//!   it reaches; no choice needs fewer references. A segment takes the smallest order for its own ratio.
//! * **Axis.** The one whose strips cost least, by a sample of strips.
//! * **Near voxels.** Where no rule is admissible (the boxes touch or nearly do) or the radius exceeds the tolerance, the exact
//!   integral; where a segment is so short that moments cost more than they save, the rule alone, without a series.
//!
//! Attenuation is outside: e^{−κr} has no three-term recurrence along the strip. `chebyshev.rs` includes it, `proposition1.rs` corrects it.

use super::gegenbauer_series::{self, GegenbauerMoments, MAX_ORDER};
use super::strip_plan::{DIVISION_COST, MIN_TOLERANCE, Strip, StripFrame, StripSegment, strip_limits};
pub use super::strip_plan::{MomentQuadrature, StripAccuracy};
use super::tensor_nodes::{AxisRule, LANES, TensorNodes};
pub use super::uniform_grid::UniformGrid;
use crate::rounding::UNIT_ROUNDOFF;
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_math::{Bounded, simd, vec3};

/// Number of factors by method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StripCounts {
    /// Factors by a series.
    pub series: usize,
    /// Factors by the rule alone.
    pub direct: usize,
    /// Factors by the exact integral: touching or too near.
    pub exact: usize,
    /// References.
    pub references: usize,
}

/// All factors of one voxel with a grid.
#[derive(Clone, Debug)]
pub struct StripFactors {
    /// Geometric factors in m⁴ in the grid's order.
    pub values: Vec<f64>,
    /// Their radii, proved.
    pub radii: Vec<f64>,
    /// By method.
    pub counts: StripCounts,
    /// The axis along which the strips ran.
    pub axis: usize,
    /// Evaluations of a kernel: nodes, times orders where there are any.
    pub evaluations: u64,
}

impl StripFactors {
    fn new(len: usize, axis: usize, radius: f64) -> StripFactors {
        let counts = StripCounts::default();
        StripFactors { values: vec![0.0; len], radii: vec![radius; len], counts, axis, evaluations: 0 }
    }
    /// One of the factors.
    pub fn get(&self, i: usize) -> Bounded {
        Bounded::proved(self.values[i], self.radii[i])
    }
}

/// Returns the factors of voxel `v` with every voxel of the grid, m⁴.
///
/// # Panics
/// On invalid boxes, a tolerance that is not positive, an order above [`MAX_ORDER`], a ratio outside (0, 1), six-dimensional
/// rules without points.
pub fn formfact(v: &Cuboid, grid: &UniformGrid, ask: StripAccuracy, means: MomentQuadrature) -> StripFactors {
    assert!(v.normal.is_none() && v.is_valid(), "not a voxel: {v:?}");
    assert!(grid.is_empty() || grid.voxel([0; 3]).is_valid(), "not a grid: {grid:?}");
    let limits = strip_limits(ask);
    // An axis with one voxel has no strips, unless they all have.
    let alone = grid.dims.iter().all(|&n| n <= 1);
    let frame = |axis: usize| StripFrame::new(v, grid, axis, ask, means, limits);
    let mut frames: Vec<StripFrame> =
        (0..3).filter(|&k| grid.dims[k] > 1 || (alone && k == 0)).map(frame).collect();
    let costs: Vec<f64> =
        if frames.len() > 1 { frames.iter().map(StripFrame::sampled_cost).collect() } else { vec![0.0] };
    let best = (0..costs.len()).fold(0, |best, k| if costs[k] < costs[best] { k } else { best });
    run_strips(v, grid, frames.swap_remove(best))
}

/// As [`formfact`], with strips along a given axis.
///
/// # Panics
/// As [`formfact`].
pub fn formfact_along(
    v: &Cuboid,
    grid: &UniformGrid,
    axis: usize,
    ask: StripAccuracy,
    means: MomentQuadrature,
) -> StripFactors {
    assert!(axis < 3, "axis {axis}");
    run_strips(v, grid, StripFrame::new(v, grid, axis, ask, means, strip_limits(ask)))
}

fn run_strips(v: &Cuboid, grid: &UniformGrid, frame: StripFrame) -> StripFactors {
    let out = StripFactors::new(grid.len(), frame.axes[0], 0.0);
    let mut run = StripRun { voxel: *v, frame, node_cache: Vec::new(), out };
    simd::dispatch(
        #[inline(always)]
        || run.serve_grid(grid),
    );
    run.out
}

/// Returns the strip about one reference: `back` voxels before and `forth` after it along `axis`, all by its series of a given order
/// at any ratio; a ratio too large gives a large radius. All are exact integrals where one is too near `v` for any rule.
///
/// # Panics
/// On boxes other than voxels, an order above [`MAX_ORDER`].
pub fn single_reference_strip(
    v: &Cuboid,
    reference: &Cuboid,
    axis: usize,
    back: usize,
    forth: usize,
    order: usize,
) -> StripFactors {
    assert!(v.normal.is_none() && v.is_valid() && reference.normal.is_none() && reference.is_valid());
    let (mut origin, mut dims) = (reference.lo.array(), [1; 3]);
    origin[axis] -= back as f64 * reference.extent()[axis];
    dims[axis] = back + 1 + forth;
    let origin = vec3(origin[0], origin[1], origin[2]);
    let grid = UniformGrid { origin, cell: reference.extent(), dims };
    let ask = StripAccuracy::Order { order, ratio: 0.5 };
    let n = grid.len();
    let out = StripFactors::new(n, axis, f64::INFINITY);
    let frame = StripFrame::new(v, &grid, axis, ask, MomentQuadrature::Reduced, strip_limits(ask));
    let mut run = StripRun { voxel: *v, frame, node_cache: Vec::new(), out };
    let strip = run.frame.strip(0, 0);
    let whole = StripSegment { from: 0, reference: back, to: n - 1 };
    simd::dispatch(
        #[inline(always)]
        || run.serve_segment(&grid, &strip, whole),
    );
    run.out
}

/// A segment with the nodes that serve it.
#[derive(Clone, Copy)]
struct ServedSegment {
    s: StripSegment,
    /// The place of its nodes in the cache.
    at: usize,
    /// Relative error of every factor apart from the truncation.
    relative: f64,
    tolerance: f64,
}

/// The factors in progress.
struct StripRun {
    /// V_i.
    voxel: Cuboid,
    frame: StripFrame,
    /// Grids of nodes made so far, by their points.
    node_cache: Vec<([usize; 3], TensorNodes)>,
    out: StripFactors,
}

impl StripRun {
    /// Serves every strip of the grid, segment by segment.
    #[inline(always)]
    fn serve_grid(&mut self, grid: &UniformGrid) {
        let [n, nj, nk] = self.frame.count;
        for j in 0..nj {
            for k in 0..nk {
                let strip = self.frame.strip(j, k);
                let mut from = 0;
                while from < n {
                    let segment = self.frame.segment(strip.lateral, strip.start[0], from, n);
                    self.serve_segment(grid, &strip, segment);
                    from = segment.to + 1;
                }
            }
        }
    }

    /// Serves a segment: by a series about its reference, by the rule alone where it is short, by the exact integral where no rule is admissible.
    #[inline(always)]
    fn serve_segment(&mut self, grid: &UniformGrid, strip: &Strip, s: StripSegment) {
        // Choose the rules by the least distance of the segment's boxes.
        let g = self.frame.segment_distance(strip.lateral, strip.start[0], &s);
        let Some((points, error, factors)) = self.frame.rules(g) else {
            return self.integrate_exactly(grid, strip.at, s.from..=s.to);
        };
        let found = self.node_cache.iter().position(|x| x.0 == points);
        let at = found.unwrap_or_else(|| self.make_nodes(points));
        let nodes = &self.node_cache[at].1;
        // Sum the relative errors: quadrature, displaced nodes and the common factor.
        let defect: f64 = (0..3).map(|k| nodes.defect[k] * factors[k]).sum();
        let relative =
            error + defect + 2.0 * self.frame.node_error / g + self.frame.volume_error + 16.0 * UNIT_ROUNDOFF;
        // Choose the order by the segment's ratio.
        let mut centre = strip.start;
        centre[0] += s.reference as f64;
        let reach = (s.reference - s.from).max(s.to - s.reference) as f64;
        let order = self.frame.order(reach / nodes.min_distance(centre));
        let served = s.to + 1 - s.from;
        let tolerance = match self.frame.ask {
            StripAccuracy::Tolerance(t) => t,
            StripAccuracy::Order { .. } => f64::INFINITY,
        };
        let short = tolerance.is_finite() && DIVISION_COST * served <= DIVISION_COST + order;
        let segment = ServedSegment { s, at, relative, tolerance };
        let missed = if short || order > MAX_ORDER {
            self.serve_by_rule(grid, strip, &segment)
        } else {
            let m = gegenbauer_series::gegenbauer_moments(nodes, centre, order, reach);
            self.serve_by_series(grid, strip, &segment, centre, &m)
        };
        if missed {
            self.replace_missed(grid, strip.at, s);
        }
    }

    /// The direct integral of every voxel; true where a radius misses the tolerance.
    #[inline(always)]
    fn serve_by_rule(&mut self, grid: &UniformGrid, strip: &Strip, segment: &ServedSegment) -> bool {
        let ServedSegment { s, at, relative, tolerance } = *segment;
        let nodes = &self.node_cache[at].1;
        let mut missed = false;
        for i in s.from..=s.to {
            let mut centre = strip.start;
            centre[0] += i as f64;
            let value = nodes.mean_inverse_square(centre);
            let radius =
                (relative + UNIT_ROUNDOFF * (nodes.blocks() as f64 + 12.0)) * value / (1.0 - relative);
            missed |= radius > tolerance * value;
            let index = grid.index(self.frame.cell(i, strip.at));
            self.out.values[index] = self.frame.factor_scale * value;
            self.out.radii[index] = 1.000_001 * self.frame.factor_scale * radius;
        }
        let served = s.to + 1 - s.from;
        self.out.counts.direct += served;
        self.out.evaluations += (served * nodes.count) as u64;
        missed
    }

    /// The series with moments `m` about the reference at `centre`; true where a radius misses the tolerance.
    #[inline(always)]
    fn serve_by_series(
        &mut self,
        grid: &UniformGrid,
        strip: &Strip,
        segment: &ServedSegment,
        centre: [f64; 3],
        m: &GegenbauerMoments,
    ) -> bool {
        let ServedSegment { s, at, relative, tolerance } = *segment;
        let nodes = &self.node_cache[at].1;
        let mut missed = false;
        let side = |k: usize| (centre[k].abs() - nodes.half_extents[k]).max(0.0);
        let lateral = (side(1) * side(1) + side(2) * side(2)) * (1.0 - 1e-14);
        let half = nodes.half_extents[0];
        for first in (s.from..=s.to).step_by(LANES) {
            let shift: [f64; LANES] =
                std::array::from_fn(|l| (first + l).min(s.to) as f64 - s.reference as f64);
            let max_inverse_square = shift.map(|s| {
                let gap = ((centre[0] + s).abs() - half).max(0.0);
                1.0 / (lateral + gap * gap)
            });
            let (value, bound) = gegenbauer_series::evaluate_series(m, shift, max_inverse_square);
            for l in 0..LANES.min(s.to + 1 - first) {
                let radius = (bound[l] + m.rounding + relative * value[l].abs()) / (1.0 - relative);
                missed |= radius.is_nan() || radius > tolerance * value[l];
                let index = grid.index(self.frame.cell(first + l, strip.at));
                self.out.values[index] = self.frame.factor_scale * value[l];
                self.out.radii[index] = 1.000_001 * self.frame.factor_scale * radius;
            }
        }
        self.out.counts.series += s.to + 1 - s.from;
        self.out.counts.references += 1;
        self.out.evaluations += (nodes.count * (m.order + 1)) as u64;
        missed
    }

    /// The nodes for these points.
    #[inline(never)]
    fn make_nodes(&mut self, points: [usize; 3]) -> usize {
        let f = &self.frame;
        let line = |k: usize| match f.means {
            MomentQuadrature::Reduced => AxisRule::trapezoid(&f.densities[k], points[k]),
            MomentQuadrature::SixDimensional(m) => {
                AxisRule::gauss_differences(f.extents[k][0], f.extents[k][1], m)
            }
        };
        let first = line(0);
        let other = |k: usize| (f.extents[k] != f.extents[0] || points[k] != points[0]).then(|| line(k));
        let (second, third) = (other(1), other(2));
        let nodes = TensorNodes::tensor([
            &first,
            second.as_ref().unwrap_or(&first),
            third.as_ref().unwrap_or(&first),
        ]);
        self.node_cache.push((points, nodes));
        self.node_cache.len() - 1
    }

    /// Replaces factors of a segment that miss the tolerance by exact integrals.
    #[cold]
    fn replace_missed(&mut self, grid: &UniformGrid, strip: [usize; 2], s: StripSegment) {
        let StripAccuracy::Tolerance(tolerance) = self.frame.ask else { return };
        for i in s.from..=s.to {
            let index = grid.index(self.frame.cell(i, strip));
            let radius = self.out.radii[index];
            if radius.is_nan() || radius > tolerance * self.out.values[index] {
                self.integrate_exactly(grid, strip, i..=i);
            }
        }
    }

    #[cold]
    fn integrate_exactly(
        &mut self,
        grid: &UniformGrid,
        strip: [usize; 2],
        range: std::ops::RangeInclusive<usize>,
    ) {
        let tolerance = match self.frame.ask {
            StripAccuracy::Tolerance(t) => t,
            StripAccuracy::Order { .. } => MIN_TOLERANCE,
        };
        for i in range {
            let cell = self.frame.cell(i, strip);
            let f = geometric_factor(&self.voxel, &grid.voxel(cell), 0.0, tolerance);
            let index = grid.index(cell);
            self.out.values[index] = f.bounded.value;
            self.out.radii[index] = f.bounded.radius;
            self.out.counts.exact += 1;
            self.out.evaluations += f.evaluations;
        }
    }
}
