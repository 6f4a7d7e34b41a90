//! Random pairs of aligned boxes and the two questions that are asked of them: does the interval hold the oracle's value, and do
//! the intervals of the parts meet the interval of the whole. Shared by the test and the long command.

use std::time::Instant;
use zonal_exchange::Demand;
use zonal_exchange::aligned::lattice::block;
use zonal_exchange::aligned::{Cuboid, FactorCache, geometric_factor};
use zonal_exchange::paper::strip::{self, Ask, Means, Voxels};
use zonal_exchange::paper::{gauss6, point};
use zonal_math::{Bounded, Vec3, sequence, vec3};
use zonal_reference::Dice;
use zonal_reference::closed::rectangles;
use zonal_reference::factors::{Answer, Block, factor_to};

/// What a pair is like.
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

/// Those that promise a radius within the tolerance; of the others it may be as large as it is.
const PROMISED: [&str; 3] = ["geometric_factor", "cache", "lattice block"];

/// Evaluations that the six-dimensional rule may take.
const BUDGET: u64 = 100_000;

/// A pair and what is asked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Case {
    pub stratum: usize,
    pub kind: usize,
    pub a: Cuboid,
    pub b: Cuboid,
    pub kappa: f64,
    pub tolerance: f64,
}

/// The case of an index: strata and kinds take turns, the rest is random.
pub(crate) fn case(seed: u64, index: u64) -> Case {
    let mut dice = Dice::new(sequence::hash(seed) ^ sequence::hash(!index));
    let stratum = (index % STRATA.len() as u64) as usize;
    let kind = (index / STRATA.len() as u64 % 3) as usize;
    let kind = if stratum == 3 && kind == 2 { 0 } else { kind };
    let (a, b) = boxes(stratum, &mut dice);
    let (a, b) = flattened(a, b, kind, stratum, &mut dice);
    let kappa = extinction(&a, &b, &mut dice);
    let tolerance = 10f64.powf(dice.between(-12.0, -3.0));
    Case { stratum, kind, a, b, kappa, tolerance }
}

type Corners = ([f64; 3], [f64; 3]);

/// Two boxes as a stratum has them.
fn boxes(stratum: usize, dice: &mut Dice) -> (Corners, Corners) {
    let style = dice.roll();
    let extent = |dice: &mut Dice| match stratum {
        5 => 10f64.powf(dice.between(-3.0, 0.0)),
        7 => 2f64.powi(dice.between(-2.0, 2.0) as i32),
        _ if style < 0.3 => 1.0,
        _ => dice.between(0.2, 1.8),
    };
    let (mut la, mut lb) = ([0.0; 3], [0.0; 3]);
    let shrink = if stratum == 4 { 64f64.powf(-dice.roll()) } else { 1.0 };
    for k in 0..3 {
        la[k] = extent(dice);
        lb[k] = if stratum == 7 { la[k] } else { extent(dice) * shrink };
    }
    let start = if dice.roll() < 0.5 { 0.0 } else { dice.between(-3.0, 3.0) };
    let mut a = ([0.0; 3], [0.0; 3]);
    let mut b = a;
    let pushed = (3.0 * dice.roll()) as usize;
    for k in 0..3 {
        let origin = if stratum == 7 { 0.0 } else { start };
        (a.0[k], a.1[k]) = (origin, origin + la[k]);
        b.0[k] = match stratum {
            7 => origin + la[k] * (7.0 * dice.roll()).floor(),
            _ => a.0[k] + place(stratum, k == pushed, la[k], lb[k], dice),
        };
        // Faces that touch share a coordinate to the bit.
        let touches = stratum == 0 && (k == pushed || dice.roll() < 0.3);
        if touches || stratum == 1 && k == pushed {
            b.0[k] = a.1[k];
        }
        if stratum == 1 && k == pushed {
            b.0[k] = a.1[k] + 10f64.powf(dice.between(-12.0, -2.0));
        }
        b.1[k] = b.0[k] + lb[k];
        if stratum == 3 {
            (b.0[k], b.1[k]) = (a.0[k], a.1[k]);
        }
    }
    if dice.roll() < 0.5 { (a, b) } else { (b, a) }
}

/// Where the second box begins, relative to the first one's beginning.
fn place(stratum: usize, pushed: bool, la: f64, lb: f64, dice: &mut Dice) -> f64 {
    match (stratum, pushed) {
        // Flush, or sliding past each other.
        (0 | 1, _) if dice.roll() < 0.4 => 0.0,
        (2, _) => dice.between(-0.9 * lb, 0.9 * la),
        (4 | 5, true) if dice.roll() < 0.5 => la + 10f64.powf(dice.between(-4.0, 0.5)) * lb,
        (6, _) => 10f64.powf(dice.between(0.0, 4.0)) * if dice.roll() < 0.5 { 1.0 } else { -1.0 },
        _ => dice.between(-lb, la),
    }
}

/// Makes patches of one box or both, mostly looking at the other.
fn flattened(a: Corners, b: Corners, kind: usize, stratum: usize, dice: &mut Dice) -> (Cuboid, Cuboid) {
    let solid = |c: Corners| Cuboid::voxel(Vec3::from_array(c.0), Vec3::from_array(c.1));
    if stratum == 3 && kind == 1 {
        let wall = (6.0 * dice.roll()) as usize;
        return (solid(a).walls()[wall], solid(a));
    }
    let flat = |c: Corners, other: Corners, dice: &mut Dice| {
        let axis = (3.0 * dice.roll()) as usize;
        let upper = dice.roll() < 0.5;
        let (mut lo, mut hi) = c;
        if upper {
            lo[axis] = hi[axis]
        } else {
            hi[axis] = lo[axis]
        }
        let ahead = other.1[axis] - lo[axis] > lo[axis] - other.0[axis];
        let sign = if ahead == (dice.roll() < 0.95) { 1 } else { -1 };
        Cuboid::patch(Vec3::from_array(lo), Vec3::from_array(hi), axis, sign)
    };
    match kind {
        0 => (solid(a), solid(b)),
        1 => (flat(a, b, dice), solid(b)),
        _ => (flat(a, b, dice), flat(b, a, dice)),
    }
}

/// κ, a third of the time none; κℓ up to 50 for the longest edge ℓ, and not so much that nothing arrives at all.
fn extinction(a: &Cuboid, b: &Cuboid, dice: &mut Dice) -> f64 {
    let kind = dice.roll();
    let longest = |c: &Cuboid| c.extent().array().into_iter().fold(0.0, f64::max);
    let size = longest(a).max(longest(b));
    let gap = (0..3).map(|k| (b.lo[k] - a.hi[k]).max(a.lo[k] - b.hi[k]).max(0.0).powi(2)).sum::<f64>().sqrt();
    let depth = match kind {
        k if k < 0.35 => 0.0,
        k if k < 0.45 => 50.0,
        _ => 10f64.powf(dice.between(-3.0, 50f64.log10())),
    };
    (depth / size).min(dice.between(0.0, 600.0) / gap.max(1e-300))
}

/// The oracle's view of a box.
pub(crate) fn reference(c: &Cuboid) -> Block {
    Block { lo: c.lo.array(), hi: c.hi.array(), normal: c.normal }
}

/// What a method says of a case, where it applies. Cache, block and series answer for lattices: the others' boxes are not on one.
pub(crate) fn ask(method: usize, c: &Case) -> Option<Bounded> {
    let demand = Demand { tolerance: c.tolerance, budget: BUDGET };
    let lattice = STRATA[c.stratum] == "lattice";
    let voxels = KINDS[c.kind] == "vv";
    match METHODS[method] {
        "geometric_factor" => Some(geometric_factor(&c.a, &c.b, c.kappa, c.tolerance).bounded),
        "cache" if lattice => Some(FactorCache::new(c.tolerance).get(&c.a, &c.b, c.kappa)),
        "lattice block" if lattice && voxels => {
            let edges = c.a.extent().array();
            let first = std::array::from_fn(|k| (c.b.lo[k] - c.a.lo[k]) / edges[k]);
            let b = block(edges, first, [1; 3], c.kappa, c.tolerance);
            Some(Bounded::proved(b.values[0], b.radii[0]))
        }
        "paper point" => Some(point::factor(&c.a, &c.b, c.kappa).bounded),
        "paper gauss-6d" => Some(gauss6::factor(&c.a, &c.b, c.kappa, &demand).bounded),
        "paper series" if lattice && voxels && c.kappa == 0.0 => {
            // The box lies somewhere in a strip of seven.
            let (axis, at) = ((c.b.lo.x.abs() as usize) % 3, 3);
            let (cell, mut dims, mut shift) = (c.b.extent(), [1; 3], [0.0; 3]);
            (dims[axis], shift[axis]) = (7, at as f64);
            let origin = c.b.lo - cell.scale(Vec3::from_array(shift));
            let grid = Voxels { origin, cell, dims };
            let f = strip::along(&c.a, &grid, axis, Ask::Tolerance(c.tolerance), Means::Reduced);
            Some(f.get(at))
        }
        _ => None,
    }
}

/// One method's answer to one case.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Verdict {
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
const TEETH: f64 = 0.03;

/// The oracle to a relative tolerance, and whether the corner sums (where they apply) disagree with it.
pub(crate) fn oracle(c: &Case, tolerance: f64) -> (Answer, bool) {
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
pub(crate) fn judge(seed: u64, index: u64) -> Vec<Verdict> {
    let c = case(seed, index);
    let answers: Vec<(usize, Bounded, f64)> = (0..METHODS.len())
        .filter_map(|method| {
            let clock = Instant::now();
            Some((method, ask(method, &c)?, clock.elapsed().as_secs_f64()))
        })
        .collect();
    let sharpest = answers
        .iter()
        .map(|(_, f, _)| if f.value > 0.0 { f.radius / f.value } else { c.tolerance })
        .fold(c.tolerance, f64::min);
    let clock = Instant::now();
    let (truth, quarrel) = oracle(&c, TEETH * sharpest);
    let slow = clock.elapsed().as_secs_f64();
    let verdict = |&(method, f, fast): &(usize, Bounded, f64)| {
        let off = (f.value - truth.value).abs();
        Verdict {
            index,
            stratum: c.stratum,
            kind: c.kind,
            method,
            seen: truth.value > 0.0,
            miss: exceeds(off, f.radius + truth.error),
            wide: PROMISED.contains(&METHODS[method]) && is_wide(&c, &f),
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
fn is_wide(c: &Case, f: &Bounded) -> bool {
    exceeds(f.radius, (c.tolerance * f.value.abs()).max(1e-300))
}

/// True where the tolerance is below what rounding lets e^{−κr} have: r is known to a few ulp, so that e^{−κr} carries as many times κr.
fn is_deep(c: &Case) -> bool {
    const ULPS: f64 = 32.0;
    let gap = |k: usize| (c.b.lo[k] - c.a.hi[k]).max(c.a.lo[k] - c.b.hi[k]).max(0.0);
    let r = gap(0).hypot(gap(1)).hypot(gap(2));
    c.tolerance < ULPS * 0.5 * f64::EPSILON * c.kappa * r
}

/// The law of additivity for a case: its second box cut at random in two or eight.
pub(crate) fn additive(seed: u64, index: u64) -> Vec<Verdict> {
    let c = case(seed, index);
    let mut dice = Dice::new(sequence::hash(!seed) ^ sequence::hash(index));
    let parts = split(&c.b, &mut dice);
    (0..METHODS.len())
        .filter_map(|method| {
            // Parts lie off the lattice that some methods want; the six-dimensional rule has its share of pairs as it is.
            if !["geometric_factor", "paper point"].contains(&METHODS[method]) {
                return None;
            }
            let clock = Instant::now();
            let whole = ask(method, &c)?;
            let of = |b: &Cuboid| ask(method, &Case { b: *b, ..c });
            let sum = parts.iter().filter_map(of).fold(Bounded::ZERO, |s, f| s + f);
            let fast = clock.elapsed().as_secs_f64();
            let (off, room) = ((sum.value - whole.value).abs(), sum.radius + whole.radius);
            Some(Verdict {
                index,
                stratum: c.stratum,
                kind: c.kind,
                method,
                seen: whole.value > 0.0,
                miss: exceeds(off, room),
                wide: PROMISED.contains(&METHODS[method]) && is_wide(&c, &whole),
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
fn split(b: &Cuboid, dice: &mut Dice) -> Vec<Cuboid> {
    let only = (dice.roll() < 0.5).then(|| (3.0 * dice.roll()) as usize);
    let mut parts = vec![*b];
    for k in 0..3 {
        let at = b.lo[k] + (b.hi[k] - b.lo[k]) * dice.between(0.05, 0.95);
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

/// What is kept of many verdicts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Tally {
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

impl Tally {
    pub(crate) fn add(&mut self, v: &Verdict) {
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
