//! Random pairs of aligned boxes and two checks: the interval contains the oracle's value, and the intervals of the parts
//! meet the interval of the whole. Shared by the test and the campaign.

use std::time::Instant;
use zonal_exchange::AccuracyRequest;
use zonal_exchange::aligned::lattice::voxel_block;
use zonal_exchange::aligned::{Cuboid, FactorCache, geometric_factor};
use zonal_math::{Bounded, Vec3, low_discrepancy, vec3};
use zonal_paper::voxel_strips::{self, MomentQuadrature, StripAccuracy, UniformGrid};
use zonal_paper::{gauss_6d, point};
use zonal_reference::Rng;
use zonal_reference::closed_form::rectangles;
use zonal_reference::factors::{AlignedBox, FactorValue, factor_to};

/// Geometric strata of the pairs.
pub(crate) const STRATA: [&str; 8] = [
    "touching",
    "nearly touching",
    "overlapping",
    "self",
    "sizes to 1:64",
    "aspect to 1:1000",
    "far to 1e4",
    "lattice",
];

/// Two voxels, voxel and patch, two patches.
pub(crate) const KINDS: [&str; 3] = ["vv", "sv", "ss"];

/// The methods that are asked.
pub(crate) const METHODS: [&str; 6] =
    ["geometric_factor", "cache", "lattice block", "paper point", "paper gauss-6d", "paper series"];

/// Methods whose radius must meet the tolerance.
const METHODS_MEETING_TOLERANCE: [&str; 3] = ["geometric_factor", "cache", "lattice block"];

/// Evaluations that the six-dimensional rule may take.
const MAX_EVALUATIONS: u64 = 100_000;

/// A pair with extinction and tolerance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairCase {
    pub stratum: usize,
    pub kind: usize,
    pub a: Cuboid,
    pub b: Cuboid,
    pub kappa: f64,
    pub tolerance: f64,
}

/// The case of an index: strata and kinds take turns, the rest is random.
pub(crate) fn case(seed: u64, index: u64) -> PairCase {
    let mut rng = Rng::new(low_discrepancy::split_mix64(seed) ^ low_discrepancy::split_mix64(!index));
    let stratum = (index % STRATA.len() as u64) as usize;
    let kind = (index / STRATA.len() as u64 % 3) as usize;
    let kind = if stratum == 3 && kind == 2 { 0 } else { kind };
    let (a, b) = boxes(stratum, &mut rng);
    let (a, b) = flattened(a, b, kind, stratum, &mut rng);
    let kappa = extinction(&a, &b, &mut rng);
    let tolerance = 10f64.powf(rng.uniform_in(-12.0, -3.0));
    PairCase { stratum, kind, a, b, kappa, tolerance }
}

type BoxCorners = ([f64; 3], [f64; 3]);

/// Two boxes as a stratum has them.
fn boxes(stratum: usize, rng: &mut Rng) -> (BoxCorners, BoxCorners) {
    let style = rng.uniform();
    let extent = |rng: &mut Rng| match stratum {
        5 => 10f64.powf(rng.uniform_in(-3.0, 0.0)),
        7 => 2f64.powi(rng.uniform_in(-2.0, 2.0) as i32),
        _ if style < 0.3 => 1.0,
        _ => rng.uniform_in(0.2, 1.8),
    };
    let (mut la, mut lb) = ([0.0; 3], [0.0; 3]);
    let shrink = if stratum == 4 { 64f64.powf(-rng.uniform()) } else { 1.0 };
    for k in 0..3 {
        la[k] = extent(rng);
        lb[k] = if stratum == 7 { la[k] } else { extent(rng) * shrink };
    }
    let start = if rng.uniform() < 0.5 { 0.0 } else { rng.uniform_in(-3.0, 3.0) };
    let mut a = ([0.0; 3], [0.0; 3]);
    let mut b = a;
    let pushed = (3.0 * rng.uniform()) as usize;
    for k in 0..3 {
        let origin = if stratum == 7 { 0.0 } else { start };
        (a.0[k], a.1[k]) = (origin, origin + la[k]);
        b.0[k] = match stratum {
            7 => origin + la[k] * (7.0 * rng.uniform()).floor(),
            _ => a.0[k] + place(stratum, k == pushed, la[k], lb[k], rng),
        };
        // Faces that touch share a coordinate to the bit.
        let touches = stratum == 0 && (k == pushed || rng.uniform() < 0.3);
        if touches || stratum == 1 && k == pushed {
            b.0[k] = a.1[k];
        }
        if stratum == 1 && k == pushed {
            b.0[k] = a.1[k] + 10f64.powf(rng.uniform_in(-12.0, -2.0));
        }
        b.1[k] = b.0[k] + lb[k];
        if stratum == 3 {
            (b.0[k], b.1[k]) = (a.0[k], a.1[k]);
        }
    }
    if rng.uniform() < 0.5 { (a, b) } else { (b, a) }
}

/// Where the second box begins, relative to the first one's beginning.
fn place(stratum: usize, pushed: bool, la: f64, lb: f64, rng: &mut Rng) -> f64 {
    match (stratum, pushed) {
        // Flush, or sliding past each other.
        (0 | 1, _) if rng.uniform() < 0.4 => 0.0,
        (2, _) => rng.uniform_in(-0.9 * lb, 0.9 * la),
        (4 | 5, true) if rng.uniform() < 0.5 => la + 10f64.powf(rng.uniform_in(-4.0, 0.5)) * lb,
        (6, _) => 10f64.powf(rng.uniform_in(0.0, 4.0)) * if rng.uniform() < 0.5 { 1.0 } else { -1.0 },
        _ => rng.uniform_in(-lb, la),
    }
}

/// Makes patches of one box or both, mostly looking at the other.
fn flattened(a: BoxCorners, b: BoxCorners, kind: usize, stratum: usize, rng: &mut Rng) -> (Cuboid, Cuboid) {
    let solid = |c: BoxCorners| Cuboid::voxel(Vec3::from_array(c.0), Vec3::from_array(c.1));
    if stratum == 3 && kind == 1 {
        let wall = (6.0 * rng.uniform()) as usize;
        return (solid(a).walls()[wall], solid(a));
    }
    let flat = |c: BoxCorners, other: BoxCorners, rng: &mut Rng| {
        let axis = (3.0 * rng.uniform()) as usize;
        let upper = rng.uniform() < 0.5;
        let (mut lo, mut hi) = c;
        if upper {
            lo[axis] = hi[axis]
        } else {
            hi[axis] = lo[axis]
        }
        let ahead = other.1[axis] - lo[axis] > lo[axis] - other.0[axis];
        let sign = if ahead == (rng.uniform() < 0.95) { 1 } else { -1 };
        Cuboid::patch(Vec3::from_array(lo), Vec3::from_array(hi), axis, sign)
    };
    match kind {
        0 => (solid(a), solid(b)),
        1 => (flat(a, b, rng), solid(b)),
        _ => (flat(a, b, rng), flat(b, a, rng)),
    }
}

/// κ, a third of the time none; κℓ up to 50 for the longest edge ℓ, and not so much that nothing arrives at all.
fn extinction(a: &Cuboid, b: &Cuboid, rng: &mut Rng) -> f64 {
    let kind = rng.uniform();
    let longest = |c: &Cuboid| c.extent().array().into_iter().fold(0.0, f64::max);
    let size = longest(a).max(longest(b));
    let gap = (0..3).map(|k| (b.lo[k] - a.hi[k]).max(a.lo[k] - b.hi[k]).max(0.0).powi(2)).sum::<f64>().sqrt();
    let depth = match kind {
        k if k < 0.35 => 0.0,
        k if k < 0.45 => 50.0,
        _ => 10f64.powf(rng.uniform_in(-3.0, 50f64.log10())),
    };
    (depth / size).min(rng.uniform_in(0.0, 600.0) / gap.max(1e-300))
}

/// The oracle's view of a box.
pub(crate) fn reference(c: &Cuboid) -> AlignedBox {
    AlignedBox { lo: c.lo.array(), hi: c.hi.array(), normal: c.normal }
}

/// The interval of a method, where it applies. Cache, block and series serve lattices only.
pub(crate) fn method_factor(method: usize, c: &PairCase) -> Option<Bounded> {
    let demand = AccuracyRequest { tolerance: c.tolerance, max_evaluations: MAX_EVALUATIONS };
    let lattice = STRATA[c.stratum] == "lattice";
    let voxels = KINDS[c.kind] == "vv";
    match METHODS[method] {
        "geometric_factor" => Some(geometric_factor(&c.a, &c.b, c.kappa, c.tolerance).bounded),
        "cache" if lattice => Some(FactorCache::new(c.tolerance).get(&c.a, &c.b, c.kappa)),
        "lattice block" if lattice && voxels => {
            let edges = c.a.extent().array();
            let first = std::array::from_fn(|k| (c.b.lo[k] - c.a.lo[k]) / edges[k]);
            let b = voxel_block(edges, first, [1; 3], c.kappa, c.tolerance);
            Some(Bounded::proved(b.values[0], b.radii[0]))
        }
        "paper point" => Some(point::factor(&c.a, &c.b, c.kappa).bounded),
        "paper gauss-6d" => Some(gauss_6d::factor(&c.a, &c.b, c.kappa, &demand).bounded),
        "paper series" if lattice && voxels && c.kappa == 0.0 => {
            // The box is the fourth of a strip of seven.
            let (axis, at) = ((c.b.lo.x.abs() as usize) % 3, 3);
            let (cell, mut dims, mut shift) = (c.b.extent(), [1; 3], [0.0; 3]);
            (dims[axis], shift[axis]) = (7, at as f64);
            let origin = c.b.lo - cell.scale(Vec3::from_array(shift));
            let grid = UniformGrid { origin, cell, dims };
            let f = voxel_strips::formfact_along(
                &c.a,
                &grid,
                axis,
                StripAccuracy::Tolerance(c.tolerance),
                MomentQuadrature::Reduced,
            );
            Some(f.get(at))
        }
        _ => None,
    }
}

/// One method's answer to one case.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MethodVerdict {
    pub index: u64,
    pub stratum: usize,
    pub kind: usize,
    pub method: usize,
    /// Does the value differ from zero?
    pub seen: bool,
    /// |value − oracle| > radius + oracle's error.
    pub miss: bool,
    /// radius > max(tolerance·|value|, 1e−300).
    pub wide: bool,
    /// Does the tolerance ask for more than rounding allows at this κr?
    pub deep: bool,
    /// The oracle's own error exceeds the radius: the case has no teeth.
    pub blunt: bool,
    /// (|value − oracle| − oracle's error)/radius.
    pub ratio: f64,
    /// Two oracles disagree.
    pub quarrel: bool,
    /// Oracle's and method's time, s.
    pub seconds: [f64; 2],
}

/// The oracle's error relative to the radius that is checked, where rounding lets it.
const ORACLE_ERROR_SHARE: f64 = 0.03;

/// The oracle to a relative tolerance, and whether the corner sums (where they apply) disagree with it.
pub(crate) fn oracle(c: &PairCase, tolerance: f64) -> (FactorValue, bool) {
    let (a, b) = (reference(&c.a), reference(&c.b));
    let rays = factor_to(&a, &b, c.kappa, tolerance);
    if c.kappa > 0.0 {
        return (rays, false);
    }
    match rectangles(&a, &b) {
        Some(sums) => (
            if sums.error < rays.error { sums } else { rays },
            (sums.value - rays.value).abs() > sums.error + rays.error,
        ),
        None => (rays, false),
    }
}

/// Every method against the oracle.
pub(crate) fn compare_with_oracle(seed: u64, index: u64) -> Vec<MethodVerdict> {
    let c = case(seed, index);
    let answers: Vec<(usize, Bounded, f64)> = (0..METHODS.len())
        .filter_map(|method| {
            let clock = Instant::now();
            Some((method, method_factor(method, &c)?, clock.elapsed().as_secs_f64()))
        })
        .collect();
    let sharpest = answers
        .iter()
        .map(|(_, f, _)| if f.value > 0.0 { f.radius / f.value } else { c.tolerance })
        .fold(c.tolerance, f64::min);
    let clock = Instant::now();
    let (truth, quarrel) = oracle(&c, ORACLE_ERROR_SHARE * sharpest);
    let slow = clock.elapsed().as_secs_f64();
    let verdict = |&(method, f, fast): &(usize, Bounded, f64)| {
        let off = (f.value - truth.value).abs();
        MethodVerdict {
            index,
            stratum: c.stratum,
            kind: c.kind,
            method,
            seen: truth.value > 0.0,
            miss: exceeds(off, f.radius + truth.error),
            wide: METHODS_MEETING_TOLERANCE.contains(&METHODS[method]) && is_wide(&c, &f),
            deep: is_deep(&c),
            blunt: truth.error > f.radius && truth.value > 0.0,
            ratio: (off - truth.error).max(0.0) / f.radius.max(1e-300),
            quarrel,
            seconds: [slow, fast],
        }
    };
    answers.iter().map(verdict).collect()
}

/// x > limit; a NaN is as bad.
fn exceeds(x: f64, limit: f64) -> bool {
    x > limit || x.is_nan() || limit.is_nan()
}

/// radius > max(tolerance·|value|, 1e−300).
fn is_wide(c: &PairCase, f: &Bounded) -> bool {
    exceeds(f.radius, (c.tolerance * f.value.abs()).max(1e-300))
}

/// True where the tolerance is below what rounding lets e^{−κr} have: r is known to a few ulp, so that e^{−κr} carries as many times κr.
fn is_deep(c: &PairCase) -> bool {
    const ULPS_OF_DISTANCE: f64 = 32.0;
    let gap = |k: usize| (c.b.lo[k] - c.a.hi[k]).max(c.a.lo[k] - c.b.hi[k]).max(0.0);
    let r = gap(0).hypot(gap(1)).hypot(gap(2));
    c.tolerance < ULPS_OF_DISTANCE * 0.5 * f64::EPSILON * c.kappa * r
}

/// The law of additivity for a case: its second box cut at random in two or eight.
pub(crate) fn check_additivity(seed: u64, index: u64) -> Vec<MethodVerdict> {
    let c = case(seed, index);
    let mut rng = Rng::new(low_discrepancy::split_mix64(!seed) ^ low_discrepancy::split_mix64(index));
    let parts = split(&c.b, &mut rng);
    (0..METHODS.len())
        .filter_map(|method| {
            // Parts are off the lattice that some methods need; the six-dimensional rule is tested by the oracle.
            if !["geometric_factor", "paper point"].contains(&METHODS[method]) {
                return None;
            }
            let clock = Instant::now();
            let whole = method_factor(method, &c)?;
            let of = |b: &Cuboid| method_factor(method, &PairCase { b: *b, ..c });
            let sum = parts.iter().filter_map(of).fold(Bounded::ZERO, |s, f| s + f);
            let fast = clock.elapsed().as_secs_f64();
            let (off, room) = ((sum.value - whole.value).abs(), sum.radius + whole.radius);
            Some(MethodVerdict {
                index,
                stratum: c.stratum,
                kind: c.kind,
                method,
                seen: whole.value > 0.0,
                miss: exceeds(off, room),
                wide: METHODS_MEETING_TOLERANCE.contains(&METHODS[method]) && is_wide(&c, &whole),
                deep: is_deep(&c),
                blunt: false,
                ratio: off / room.max(1e-300),
                quarrel: false,
                seconds: [0.0, fast],
            })
        })
        .collect()
}

/// A box in two along one of its axes, or in up to eight along all of them.
fn split(b: &Cuboid, rng: &mut Rng) -> Vec<Cuboid> {
    let only = (rng.uniform() < 0.5).then(|| (3.0 * rng.uniform()) as usize);
    let mut parts = vec![*b];
    for k in 0..3 {
        let at = b.lo[k] + (b.hi[k] - b.lo[k]) * rng.uniform_in(0.05, 0.95);
        if only.is_some_and(|o| o != k) || !(b.lo[k] < at && at < b.hi[k]) {
            continue;
        }
        let set = |v: Vec3, x: f64| {
            let mut c = v.array();
            c[k] = x;
            vec3(c[0], c[1], c[2])
        };
        parts = parts
            .iter()
            .flat_map(|p| [Cuboid { hi: set(p.hi, at), ..*p }, Cuboid { lo: set(p.lo, at), ..*p }])
            .collect();
    }
    parts
}

/// Counts over many verdicts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct VerdictCounts {
    pub pairs: u64,
    pub seen: u64,
    pub misses: u64,
    pub wide: u64,
    /// Too wide where rounding forbids better.
    pub deep: u64,
    pub blunt: u64,
    pub quarrels: u64,
    /// The worst |difference|/radius and the index of its case.
    pub worst: (f64, u64),
    /// The slowest oracle, s, and its index.
    pub slowest: (f64, u64),
    /// Sums of the oracle's and the method's seconds.
    pub seconds: [f64; 2],
}

impl VerdictCounts {
    pub(crate) fn add(&mut self, v: &MethodVerdict) {
        self.pairs += 1;
        self.seen += v.seen as u64;
        self.misses += v.miss as u64;
        self.wide += (v.wide && !v.deep) as u64;
        self.deep += (v.wide && v.deep) as u64;
        self.blunt += v.blunt as u64;
        self.quarrels += v.quarrel as u64;
        if v.ratio > self.worst.0 {
            self.worst = (v.ratio, v.index);
        }
        if v.seconds[0] > self.slowest.0 {
            self.slowest = (v.seconds[0], v.index);
        }
        self.seconds = [self.seconds[0] + v.seconds[0], self.seconds[1] + v.seconds[1]];
    }
}
