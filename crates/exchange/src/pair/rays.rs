//! Pairs by rays: visibility, attenuation that varies, panes.
//!
//! Points of both zones come from a six-dimensional low-discrepancy sequence shifted by a hash of the pair. A few rays first; where they
//! disagree, more, the more the closer the zones and the larger the share of power they exchange.
//!
//! Where that leaves more of a zone's power open than the tolerance allows a pair, as many follow as bring it down to that: errors fall
//! with the root of the rays at least.
//!
//! Where no facet reaches into the hull of a pair, all of it is seen, and no ray is asked. Where one does and yet n rays agree, they may
//! have missed a part: with nothing known before, the share on the other side is 1/(n + 2) in the mean, and as large is its standard
//! deviation (Laplace's rule of succession), of pairs that are seen in part at all: how many are, [`super::agree`] tells. A pane
//! between may dim a part that no ray met in the same way; where one reaches into the hull, rays are as many as make that share small.

use super::agree::{Outer, missed};
use super::zone::{Shape, Zone, is_close, plate_zone, share};
use super::{Counts, Exchange, PairFactor};
use crate::general::Moments;
use zonal_math::{Vec3, sequence, special, vec3};
use zonal_scene::{Bands, bands};
use zonal_transport::End;

/// Rays of the first look at a pair.
pub(super) const FIRST_RAYS: usize = 4;

/// Rays of a pair that is partly visible.
pub(super) const MORE_RAYS: usize = 16;

/// Rays of a pair that is partly visible and carries a large share of a zone's power.
pub(super) const MOST_RAYS: usize = 64;

/// Optical depth along a voxel's diagonal beyond which cumulants of the distance no longer serve.
pub(super) const THICK: f64 = 1.7;

/// Optical depth beyond which the ratio of a pair's rays to a uniform medium says nothing: their mean depth, and the uniform medium's depth
/// along any of them beyond its own.
pub(super) const MOST_DEPTH: f64 = 20.0;

/// How often a pane and a zone close to it are quartered; a patch, which may share an edge with it, where the tolerance is finer.
const PANE_SPLITS: u32 = 2;
const EDGE_SPLITS: u32 = 4;
const FINE: f64 = 0.01;

/// Rays of a pair that nearly touches, is partly visible and carries a large share of a zone's power.
pub(super) const CLOSE_RAYS: usize = 256;

/// The share of a zone's power over the tolerance that the rays of a pair may leave open, and the largest number of rays for that.
const OPEN: f64 = 0.1;
const FINE_RAYS: usize = 4096;
/// Times that more rays are asked for.
const ROUNDS: usize = 2;

/// What the rule of succession adds to the number of rays: one on each side.
pub const SUCCESSION: f64 = 2.0;

/// Rays of a voxel with a sheet in its middle, to itself.
pub(super) const OWN_RAYS: usize = 2048;

impl Exchange<'_> {
    pub(super) fn times_visibility(
        &self,
        a: &Zone,
        b: &Zone,
        base: PairFactor,
        seed: u64,
        counts: &mut Counts,
    ) -> PairFactor {
        let share = share(base.value[0], a, b);
        let v = self.visibility(a, b, seed, share, counts);
        PairFactor {
            value: bands(|k| base.value[k] * v[k].0),
            radius: bands(|k| base.radius[k] * v[k].0 + base.value[k] * v[k].1),
        }
    }

    /// Visible share of the exchange of two zones in one uniform medium, and its standard error, a band.
    pub(super) fn visibility(
        &self,
        a: &Zone,
        b: &Zone,
        seed: u64,
        share: f64,
        counts: &mut Counts,
    ) -> [(f64, f64); 3] {
        if !self.may_divide(a, b) {
            return [(1.0, 0.0); 3];
        }
        let (mut tally, points) = ([Tally::default(); 3], Points::new(seed));
        let kappa = self.uniform.unwrap_or([0.0; 3]);
        let shoot = |from: usize, to: usize, tally: &mut [Tally; 3]| {
            for k in from..to {
                let (x, y) = points.both(a, b, k);
                let w = kernel(a, b, x, y);
                let seen = if self.transport.blocked_inside(x, y) { 0.0 } else { 1.0 };
                if kappa == [0.0; 3] {
                    tally[0].add(w, seen);
                } else {
                    let r = (y - x).length();
                    (0..3).for_each(|k| tally[k].add(w * (-kappa[k] * r).exp(), seen));
                }
            }
        };
        let close = is_close(a, b);
        let first = if close { MORE_RAYS } else { FIRST_RAYS };
        shoot(0, first, &mut tally);
        let outer = if share > self.tolerance * 0.1 { self.outer_rays(a, b) } else { Outer::default() };
        counts.rays += outer.rays;
        if tally[0].mixed() || outer.disagrees(tally[0].blocked > 0.0) {
            counts.partial += 1;
            let n = match share > self.tolerance * 0.1 {
                true if std::ptr::eq(a, b) => OWN_RAYS,
                true if close => CLOSE_RAYS,
                true => MOST_RAYS,
                false => MORE_RAYS,
            };
            shoot(first, n, &mut tally);
        }
        for _ in 0..ROUNDS {
            let error = tally.iter().fold(0.0f64, |m, t| m.max(t.mean_and_error().1));
            let (have, want) = (tally[0].n as usize, self.fine(tally[0].n as usize, share * error));
            if !tally[0].mixed() || want <= have {
                break;
            }
            shoot(have, want, &mut tally);
        }
        counts.rays += tally[0].n as u64;
        let blocked = tally[0].blocked > 0.0;
        let doubt = self.agreement.doubt(a, b, blocked);
        let missed = if tally[0].mixed() { 0.0 } else { doubt * missed(tally[0].n, outer, blocked) };
        let judged = |t: Tally| {
            let (mean, error) = t.mean_and_error();
            (mean, error.hypot(missed))
        };
        if kappa == [0.0; 3] { [judged(tally[0]); 3] } else { tally.map(judged) }
    }

    /// Rays of a pair of whose zones' power `open` is left open by `n` of them.
    fn fine(&self, n: usize, open: f64) -> usize {
        let over = open / (OPEN * self.tolerance);
        if over > 1.0 { ((n as f64 * over * over) as usize).min(FINE_RAYS) } else { n }
    }

    /// False where no facet can hide anything of a pair.
    pub(super) fn may_divide(&self, a: &Zone, b: &Zone) -> bool {
        let (mut p, mut q) = (Vec::new(), Vec::new());
        self.occluders && self.transport.may_divide([end(a, &mut p), end(b, &mut q)])
    }

    /// False where no pane can dim a part of a pair.
    fn may_dim(&self, a: &Zone, b: &Zone) -> bool {
        let (mut p, mut q) = (Vec::new(), Vec::new());
        self.panes_between && self.transport.pane_may_divide([end(a, &mut p), end(b, &mut q)])
    }

    /// How often a pane and another zone that is close to it are quartered.
    pub(super) fn pane_splits(&self, a: &Zone, b: &Zone) -> u32 {
        let plates = [a, b].iter().all(|z| matches!(z.shape, Shape::Plate { .. }));
        if plates && self.tolerance < FINE { EDGE_SPLITS } else { PANE_SPLITS }
    }

    /// A pane and anything not cut. Close to each other their larger plate is quartered: grazing paths through the pane differ much.
    pub(super) fn pane_pair(
        &self,
        a: &Zone,
        b: &Zone,
        seed: u64,
        splits: u32,
        counts: &mut Counts,
    ) -> PairFactor {
        let close = (a.centre - b.centre).length() < a.size.max(b.size);
        let first = matches!(a.shape, Shape::Plate { .. })
            && (a.size >= b.size || !matches!(b.shape, Shape::Plate { .. }));
        let (large, small) = if first { (a, b) } else { (b, a) };
        let Shape::Plate { plate, pane } = &large.shape else {
            unreachable!("a pane is a plate");
        };
        if !close || splits == 0 {
            let m = self.moments(a, b);
            return self.by_rays(a, b, m, seed, counts);
        }
        let mut sum = PairFactor::default();
        for (k, quarter) in plate.quarters().into_iter().enumerate() {
            let part = plate_zone(quarter, *pane);
            let f = self.pane_pair(&part, small, sequence::hash(seed + k as u64), splits - 1, counts);
            sum.value = bands(|b| sum.value[b] + f.value[b]);
            sum.radius = bands(|b| sum.radius[b].hypot(f.radius[b]));
        }
        sum
    }

    /// Attenuated and visible exchange by rays, as many as the pair deserves.
    pub(super) fn by_rays(
        &self,
        a: &Zone,
        b: &Zone,
        m: Moments,
        seed: u64,
        counts: &mut Counts,
    ) -> PairFactor {
        let distance = (a.centre - b.centre).length();
        let near = distance < 2.0 * (a.size + b.size);
        let pane = [a, b].iter().any(|z| matches!(z.shape, Shape::Plate { pane: Some(_), .. }));
        let rays = if near && (pane || self.is_thick(a, b))
            || self.uniform.is_none() && distance < a.size.max(b.size)
        {
            MOST_RAYS
        } else if near && self.varied || self.occluders && is_close(a, b) {
            MORE_RAYS
        } else if self.occluders || self.varied || near {
            // In a medium that varies e^{−δ} between the centres is no mean of the pair's.
            FIRST_RAYS
        } else {
            1
        };
        self.average(a, b, m, seed, rays, counts)
    }

    /// m's factor times the mean over rays of visibility, attenuation and the panes' own share.
    ///
    /// With the mean extinction κ of the rays, what the moments say of ⟨e^{−κr}⟩ is corrected by the ratio Σ w τ/Σ w e^{−κr} of the
    /// same rays: exact where the medium is uniform, and right where what is dimmed or hidden lies nearer or farther than the rest.
    pub(super) fn average(
        &self,
        a: &Zone,
        b: &Zone,
        m: Moments,
        seed: u64,
        rays: usize,
        counts: &mut Counts,
    ) -> PairFactor {
        if m.factor.value <= 0.0 {
            return PairFactor { value: [0.0; 3], radius: [m.factor.radius; 3] };
        }
        let divided = self.may_divide(a, b);
        let distance = (a.centre - b.centre).length();
        let scale = self.pane_scale(a) * self.pane_scale(b);
        let points = Points::new(seed);
        let mut shot: Vec<Ray> = Vec::with_capacity(rays.max(MORE_RAYS));
        let shoot = |from: usize, to: usize, shot: &mut Vec<Ray>| {
            for k in from..to {
                let (x, y) = if rays == 1 { (a.centre, b.centre) } else { points.both(a, b, k) };
                shot.push(self.along(a, b, x, y, divided));
            }
        };
        shoot(0, rays, &mut shot);
        let blocked = shot.iter().filter(|r| r.is_dark()).count();
        let share = share(m.factor.value, a, b);
        let undecided = divided && rays > 1 && rays < MOST_RAYS;
        let outer =
            if undecided && share > self.tolerance * 0.1 { self.outer_rays(a, b) } else { Outer::default() };
        counts.rays += outer.rays;
        if undecided && (blocked > 0 && blocked < rays || outer.disagrees(blocked > 0)) {
            counts.partial += 1;
            let n = if share > self.tolerance * 0.1 { MOST_RAYS } else { MORE_RAYS.max(rays) };
            shoot(rays, n, &mut shot);
        }
        let dimmed = rays > 1 && self.may_dim(a, b);
        if dimmed {
            // So many that a pane which none of them met could not matter.
            let n = (share / (OPEN * self.tolerance)) as usize;
            shoot(shot.len(), n.min(FINE_RAYS).max(shot.len()), &mut shot);
        }
        let mut seen = self.judged(a, b, &shot);
        for _ in 0..if rays > 1 { ROUNDS } else { 0 } {
            let open = seen.iter().fold(0.0f64, |m, s| m.max(scale * s.error * (-s.kappa * distance).exp()));
            let want = self.fine(shot.len(), share * open);
            if want <= shot.len() {
                break;
            }
            shoot(shot.len(), want, &mut shot);
            seen = self.judged(a, b, &shot);
        }
        counts.rays += shot.len() as u64;
        let blocked = shot.iter().filter(|r| r.hidden).count();
        let n = shot.len();
        let mut unmet = 0.0f64;
        if divided && (blocked == 0 || blocked == n) {
            unmet = self.agreement.doubt(a, b, blocked > 0) * missed(n as f64, outer, blocked > 0);
        }
        let behind = shot.iter().filter(|r| r.dimmed).count();
        if dimmed && (behind == 0 || behind == n) {
            unmet = unmet.hypot(missed(n as f64, Outer::default(), behind > 0));
        }
        let mut out = PairFactor::default();
        for (k, Judged { kappa, mean, error, open }) in seen.into_iter().enumerate() {
            let error = error.hypot(unmet * open);
            let base = m.transmittance(kappa);
            let value = m.factor.value * base * mean;
            let radius = base * (m.factor.radius * mean + m.factor.value * error);
            // No medium passes more than all. (What comes out of a pane's own depth is a length.)
            let (most, widest) = match scale == 1.0 {
                true => (m.factor.value, m.factor.value + m.factor.radius),
                false => (f64::INFINITY, f64::INFINITY),
            };
            (out.value[k], out.radius[k]) = (value.min(most), radius.min(widest));
        }
        out
    }

    /// What the rays of a pair say in each band.
    fn judged(&self, a: &Zone, b: &Zone, shot: &[Ray]) -> [Judged; 3] {
        let thick = self.is_thick(a, b);
        let length: f64 = shot.iter().map(|r| r.w * r.r).sum();
        let weights: f64 = shot.iter().map(|r| r.w).sum();
        std::array::from_fn(|k| {
            let chords = thick && a.thickness[k].max(b.thickness[k]) > THICK;
            let depth: f64 = shot.iter().map(|r| r.w * r.depth[k]).sum();
            let mean = depth / length;
            // Rays that are much longer than what dims them would have ratios beyond all bounds.
            let excess = shot.iter().fold(0.0f64, |m, r| m.max(mean * r.r - r.depth[k]));
            let told = length > 0.0 && depth <= MOST_DEPTH * weights && excess <= MOST_DEPTH;
            let kappa = if told && !chords { mean } else { 0.0 };
            let (mut tally, mut open) = (Tally::default(), Tally::default());
            for r in shot {
                let reference = (-kappa * r.r).exp();
                let tau = if chords && !r.hidden { r.chords[k] } else { (-r.depth[k]).exp() };
                let x = if reference > 0.0 { r.through[k] * tau / reference } else { 0.0 };
                tally.add(r.w * reference, if r.hidden { 0.0 } else { x });
                open.add(r.w * reference, x);
            }
            let (mean, error) = tally.mean_and_error();
            Judged { kappa, mean, error, open: open.mean_and_error().0 }
        })
    }

    /// What a ray from x to y meets; facets are asked where the pair may be `divided`.
    fn along(&self, a: &Zone, b: &Zone, x: Vec3, y: Vec3, divided: bool) -> Ray {
        let d = y - x;
        let r = d.length();
        let w = kernel(a, b, x, y);
        let depth = match self.uniform {
            Some(k) => k.map(|k| k * r),
            None => self.transport.medium_depth(x, y),
        };
        let (pa, pb) = (self.pane_share(a, d / r), self.pane_share(b, d / r));
        let through = bands(|k| pa[k] * pb[k]);
        let mut ray = Ray { w, r, depth, chords: [0.0; 3], through, dimmed: false, hidden: false };
        ray.hidden = divided && self.transport.blocked_inside(x, y);
        if ray.hidden {
            return ray;
        }
        if self.is_thick(a, b) {
            ray.chords = self.chords(a, b, x, y);
        }
        if self.panes_between {
            let all = self.transport.optical_depth_inside(x, y);
            ray.through = bands(|k| ray.through[k] * (depth[k] - all[k]).min(0.0).exp());
            ray.dimmed = (0..3).any(|k| all[k] > depth[k]);
        }
        ray
    }

    pub(super) fn is_thick(&self, a: &Zone, b: &Zone) -> bool {
        let cut = a.samples().or(b.samples()).is_some();
        !cut && (0..3).any(|k| a.thickness[k].max(b.thickness[k]) > THICK)
    }

    /// Attenuation along the line through x and y, averaged over its chords in both zones: for a given line the points of a pair
    /// are uniform on them (dV dV'/r² = dA⊥ dω ds ds'), so each voxel gives (1 − e^{−κℓ})/(κℓ), and what lies between e^{−δ}.
    pub(super) fn chords(&self, a: &Zone, b: &Zone, x: Vec3, y: Vec3) -> Bands {
        let w = (y - x).normalized();
        let r = (y - x).length();
        let (from, share_a) = chord(a, x, w, r);
        let (to, share_b) = chord(b, y, -w, r);
        let between = match self.uniform {
            Some(k) => k.map(|k| k * (to - from).dot(w).max(0.0)),
            None if (to - from).dot(w) > 0.0 => self.transport.medium_depth(from, to),
            None => [0.0; 3],
        };
        bands(|k| (-between[k]).exp() * share_a[k] * share_b[k])
    }

    /// (1 − e^{−κt/c})/κ of a pane in direction `w`; 1 for any other zone.
    pub(super) fn pane_share(&self, z: &Zone, w: Vec3) -> Bands {
        let Shape::Plate { pane: Some(k), .. } = z.shape else {
            return [1.0; 3];
        };
        self.zones.panes[k].effective_path(w)
    }

    /// What makes a pane's own share, a length, part of its power: one over its thickness; 1 for any other zone.
    fn pane_scale(&self, z: &Zone) -> f64 {
        match z.shape {
            Shape::Plate { pane: Some(k), .. } => 1.0 / self.zones.panes[k].thickness,
            _ => 1.0,
        }
    }
}

/// A zone as the end of its rays: they start at the samples of a cut voxel, anywhere in any other zone.
fn end<'a>(z: &Zone, points: &'a mut Vec<Vec3>) -> End<'a> {
    let mut front = None;
    match &z.shape {
        Shape::Plate { plate, pane } => {
            let (c, n) = plate.corners();
            points.extend(&c[..n]);
            front = pane.is_none().then_some(z.normal);
        }
        Shape::Cuboid => points.extend((0..8).map(|k| {
            let pick = |bit: usize, l: f64, h: f64| if k >> bit & 1 == 1 { h } else { l };
            vec3(pick(0, z.lo.x, z.hi.x), pick(1, z.lo.y, z.hi.y), pick(2, z.lo.z, z.hi.z))
        })),
        Shape::Part(samples) => points.extend(samples.iter().map(|s| s.point)),
    }
    End { points, front }
}

/// What the rays of a pair say in a band.
struct Judged {
    /// The extinction of a uniform medium that dims as much, 1/m.
    kappa: f64,
    /// What passes relative to that medium alone, and its error.
    mean: f64,
    error: f64,
    /// The same without facets.
    open: f64,
}

/// A ray between two zones.
pub(super) struct Ray {
    /// Weight: the kernel.
    pub(super) w: f64,
    /// Length, m.
    pub(super) r: f64,
    /// Optical depth of the medium.
    pub(super) depth: Bands,
    /// Attenuation by the medium as [`Exchange::chords`] has it, where a zone is thick.
    pub(super) chords: Bands,
    /// The share of panes at the ends, and what the panes between let pass where no facet blocks.
    pub(super) through: Bands,
    /// A pane stands between.
    pub(super) dimmed: bool,
    /// A facet blocks.
    pub(super) hidden: bool,
}

impl Ray {
    fn is_dark(&self) -> bool {
        self.hidden || self.through == [0.0; 3]
    }
}

/// Where the line leaves a whole voxel from `x` along `w`, at most `reach` away, with (1 − e^{−κℓ})/(κℓ) of its chord there; of any
/// other zone, `x` and 1.
pub(super) fn chord(z: &Zone, x: Vec3, w: Vec3, reach: f64) -> (Vec3, Bands) {
    if !matches!(z.shape, Shape::Cuboid) {
        return (x, [1.0; 3]);
    }
    let (mut ahead, mut behind) = (reach, f64::INFINITY);
    for axis in (0..3).filter(|&k| w[k] != 0.0) {
        let (p, q) = ((z.lo[axis] - x[axis]) / w[axis], (z.hi[axis] - x[axis]) / w[axis]);
        ahead = ahead.min(p.max(q).max(0.0));
        behind = behind.min(-p.min(q).min(0.0));
    }
    let length = ahead + behind;
    let mean = |depth: f64| if depth > 1e-9 { -(-depth).exp_m1() / depth } else { 1.0 };
    (x + w * ahead, z.thickness.map(|t| mean(t / z.size * length)))
}

/// F of a pane with itself per area and κ²: (4κt − 2 (1 − 2 E_3(κt)))/κ², what its faces do not let out.
pub(super) fn pane_own(kappa: f64, thickness: f64) -> f64 {
    let tau = kappa * thickness;
    ((4.0 * tau - 2.0 * (1.0 - 2.0 * special::e3(tau))) / (kappa * kappa)).max(0.0)
}

/// The points of a pair: a six-dimensional sequence shifted by a hash of the pair, three coordinates for each zone.
pub(super) struct Points {
    pub(super) shift: [f64; 6],
}

impl Points {
    pub(super) fn new(seed: u64) -> Points {
        Points { shift: sequence::shift(seed) }
    }
    /// The `k`-th points on both zones.
    pub(super) fn both(&self, a: &Zone, b: &Zone, k: usize) -> (Vec3, Vec3) {
        let u = sequence::r6(k, self.shift);
        (point(a, [u[0], u[1], u[2]]), point(b, [u[3], u[4], u[5]]))
    }
}

/// The point of a zone at coordinates in the unit cube.
pub(super) fn point(z: &Zone, u: [f64; 3]) -> Vec3 {
    match &z.shape {
        Shape::Plate { plate, .. } => {
            let [s, t] = plate.warp([u[0], u[1]]);
            plate.at(s, t)
        }
        Shape::Cuboid => z.lo + (z.hi - z.lo).scale(Vec3::from_array(u)),
        Shape::Part(samples) => {
            let mut target = u[0] * z.measure;
            for s in samples.iter() {
                target -= s.volume;
                if target <= 0.0 {
                    return s.point;
                }
            }
            samples[samples.len() - 1].point
        }
    }
}

/// The kernel between two points, tamed where they come close: only ratios of it are used.
pub(super) fn kernel(a: &Zone, b: &Zone, x: Vec3, y: Vec3) -> f64 {
    let d = y - x;
    let r2 = d.length2();
    let floor = 0.0025 * (a.size * a.size).min(b.size * b.size);
    let d = d / r2.sqrt().max(1e-300);
    let side = |z: &Zone, c: f64| match &z.shape {
        Shape::Plate { pane: None, .. } => c.max(0.0),
        Shape::Plate { .. } => c.abs(),
        _ => 1.0,
    };
    side(a, a.normal.dot(d)) * side(b, -b.normal.dot(d)) / r2.max(floor)
}

/// Weighted mean of a few samples.
#[derive(Clone, Copy, Default)]
pub(super) struct Tally {
    pub(super) w: f64,
    pub(super) wx: f64,
    pub(super) wxx: f64,
    pub(super) ww: f64,
    pub(super) n: f64,
    pub(super) blocked: f64,
}

impl Tally {
    pub(super) fn add(&mut self, w: f64, x: f64) {
        self.w += w;
        self.wx += w * x;
        self.wxx += w * x * x;
        self.ww += w * w;
        self.n += 1.0;
        self.blocked += if x == 0.0 { 1.0 } else { 0.0 };
    }
    pub(super) fn mixed(&self) -> bool {
        self.blocked > 0.0 && self.blocked < self.n
    }
    pub(super) fn mean_and_error(self) -> (f64, f64) {
        if self.w <= 0.0 {
            // No ray carried weight: what remains is a sliver of exchange across an edge.
            return ((self.n - self.blocked) / self.n.max(1.0), 0.5);
        }
        let mean = self.wx / self.w;
        let variance = (self.wxx / self.w - mean * mean).max(0.0);
        (mean, (variance * self.ww).sqrt() / self.w)
    }
}
