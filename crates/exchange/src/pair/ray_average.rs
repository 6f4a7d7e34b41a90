//! Pairs by rays: visibility, varying attenuation, panes.
//!
//! The points of both zones come from a six-dimensional low-discrepancy sequence shifted by a hash of the pair. The first rays are few. Where they
//! disagree, more follow: the number grows with the closeness of the zones and with the share of power that they exchange. Where the error still
//! leaves more of a zone's power open than the tolerance allows per pair, more rays reduce it to that share; errors fall at least with the root
//! of the number of rays.
//!
//! A pair is fully visible, and takes no ray, where no facet reaches into its hull. Where one does and n rays agree, they may miss a part: without
//! prior knowledge the mean of the other fraction is 1/(n + 2), and its standard deviation is as large (Laplace's rule of succession). The fraction
//! of pairs that are partly visible is estimated by [`crate::pair::visibility::visibility_uncertainty`]. A pane between two zones may dim an undetected part in the
//! same way; where one reaches into the hull, the number of rays makes that part small.

use super::exchange::Exchange;
use super::pair_factor::{PairCounts, PairFactor};
use super::prepared_zone::{PreparedShape, PreparedZone, is_close, power_share};
use crate::pair::visibility::occlusion::{RayConsensus, RimVisibility, shaft_end};
use crate::pair::visibility::ray_samples::{
    AGREEING_RAYS, CLOSE_RAYS, FIRST_RAYS, IMPORTANT_RAYS, IMPORTANT_SHARE, MAX_CUMULANT_DEPTH, MAX_RAYS,
    MAX_REFERENCE_DEPTH, MAX_ROUNDS, OPEN_SHARE, PARTIAL_RAYS, PairPoints, SELF_PAIR_RAYS, UNIMPORTANT_RAYS,
    WeightedMean, pair_kernel,
};
use crate::pair::visibility::visibility_uncertainty::succession_bound;
use crate::solid_angle_quadrature::DistanceMoments;
use std::ops::Range;
use zonal_math::{Vec3, exponential_integral};
use zonal_scene::{Band, Bands, PerBand};

/// Two zones, the seed of their sample points, and the medium between them.
#[derive(Clone, Copy)]
pub(super) struct ZonePair<'z> {
    pub a: &'z PreparedZone,
    pub b: &'z PreparedZone,
    pub seed: u64,
    /// κ of the medium on all paths between the zones, 1/m; `None` where it varies or a pane may stand between.
    pub uniform: Option<Bands>,
}

impl ZonePair<'_> {
    fn is_close(&self) -> bool {
        is_close(self.a, self.b)
    }
    /// Number of first rays, `important` for a pair that carries an important share of power.
    fn first_rays(&self, important: bool) -> usize {
        if self.is_close() {
            PARTIAL_RAYS
        } else if important {
            FIRST_RAYS
        } else {
            UNIMPORTANT_RAYS
        }
    }
    /// Number of rays if the pair is partly visible and carries an important share of power.
    fn important_rays(&self) -> usize {
        if std::ptr::eq(self.a, self.b) {
            SELF_PAIR_RAYS
        } else if self.is_close() {
            CLOSE_RAYS
        } else {
            IMPORTANT_RAYS
        }
    }
    /// κ of the uniform medium, 1/m; zero where there is none.
    fn uniform_extinction(&self) -> Bands {
        self.uniform.unwrap_or_default()
    }
    /// True where a few rays do not determine the attenuation.
    fn is_varied(&self) -> bool {
        self.uniform.is_none()
    }
    /// Distance of the centres, m.
    fn distance(&self) -> f64 {
        (self.a.centre - self.b.centre).length()
    }
}

/// The rays of a pair and their means.
struct RaySample {
    rays: Vec<PairRay>,
    rim: RimVisibility,
    /// Facets, panes may divide the pair.
    divided: bool,
    dimmed: bool,
    /// Product of the zones' pane scales: 1 without panes.
    scale: f64,
    means: PerBand<BandMean>,
}

/// The mean over the rays of a pair in one band.
struct BandMean {
    /// The extinction of the uniform medium with the same mean depth, 1/m.
    kappa: f64,
    /// Transmittance relative to that medium, and its standard error.
    mean: f64,
    error: f64,
    /// The same mean without facets.
    open: f64,
}

/// A ray between two zones.
struct PairRay {
    /// The kernel.
    weight: f64,
    /// m.
    length: f64,
    /// Optical depth of the medium.
    depth: Bands,
    /// Attenuation by the medium as in [`Exchange::chord_transmittance`], where a zone is optically thick.
    chords: Bands,
    /// Transmittance of the panes between, times the path factors of panes at the ends.
    panes: Bands,
    /// A pane stands between.
    dimmed: bool,
    /// A facet blocks.
    blocked: bool,
}

impl PairRay {
    fn is_dark(&self) -> bool {
        self.blocked || self.panes == Bands::ZERO
    }
}

impl Exchange<'_> {
    /// A factor in a uniform medium times the visible fraction.
    pub(super) fn times_visibility(
        &self,
        pair: ZonePair,
        base: PairFactor,
        counts: &mut PairCounts,
    ) -> PairFactor {
        let share = power_share(base.value.first(), pair.a, pair.b);
        let v = self.visible_fraction(pair, share, counts);
        let (mean, error) = (v.map(|v| v.0), v.map(|v| v.1));
        PairFactor { value: base.value * mean, radius: base.radius * mean + base.value * error }
    }

    /// Visible fraction of the exchange of two zones in one uniform medium, and its standard error in each band.
    fn visible_fraction(&self, pair: ZonePair, share: f64, counts: &mut PairCounts) -> PerBand<(f64, f64)> {
        let ZonePair { a, b, .. } = pair;
        if !self.occlusion.may_divide(a, b) {
            return PerBand::splat((1.0, 0.0));
        }
        // The first band stands for all in vacuum, and decides the number of rays in a medium.
        let grey = Band::first();
        let important = self.is_important(share);
        let first = pair.first_rays(important);
        let (start, rim) = if important { self.unweighted_rays(pair, first) } else { Default::default() };
        let partial = start.is_mixed() || rim.disagrees(RayConsensus::of(start.blocked as u64));
        let start = start.n as usize;
        counts.rays += start as u64 + rim.rays;
        counts.partial += u64::from(partial);
        // Trace the rays of the mean.
        let rays = if important && partial {
            pair.important_rays()
        } else if important {
            first.max(AGREEING_RAYS)
        } else {
            first
        };
        let mut tally: PerBand<WeightedMean> = PerBand::default();
        self.trace_visibility(pair, start..start + rays, &mut tally);
        if partial {
            self.add_rays_by_error(pair, start, share, &mut tally);
        }
        counts.rays += tally[grey].n as u64;
        // Add the undetected occlusion of rays that all agree.
        let consensus = RayConsensus::of(tally[grey].blocked as u64);
        let deviation = self.uncertainty.deviation(a, b, consensus);
        let missed = if tally[grey].is_mixed() {
            0.0
        } else {
            deviation * succession_bound(tally[grey].n, rim, consensus)
        };
        let with_missed = |t: WeightedMean| {
            let (mean, error) = t.mean_and_error();
            (mean, error.hypot(missed))
        };
        if pair.uniform_extinction() == Bands::ZERO {
            PerBand::splat(with_missed(tally[grey]))
        } else {
            tally.map(with_missed)
        }
    }

    /// What `n` rays without weight in the mean, and rays between the rims, say of an important pair.
    ///
    /// They show whether the pair is partly visible. If the rays of the mean decided that, pairs of which few points are hidden would appear free.
    fn unweighted_rays(&self, pair: ZonePair, n: usize) -> (WeightedMean, RimVisibility) {
        let mut seen: PerBand<WeightedMean> = PerBand::default();
        self.trace_visibility(pair, 0..n, &mut seen);
        (seen[Band::first()], self.occlusion.rim_visibility(pair.a, pair.b))
    }

    /// Adds rays to a partly visible pair, from ray `start` on, until the error leaves an admissible share of power open.
    fn add_rays_by_error(&self, pair: ZonePair, start: usize, share: f64, tally: &mut PerBand<WeightedMean>) {
        for _ in 0..MAX_ROUNDS {
            let first = tally[Band::first()];
            let error = tally.iter().fold(0.0f64, |m, t| m.max(t.mean_and_error().1));
            let (have, want) = (first.n as usize, self.rays_for(first.n as usize, share * error));
            if !first.is_mixed() || want <= have {
                break;
            }
            self.trace_visibility(pair, start + have..start + want, tally);
        }
    }

    /// True for a pair that carries an important share of a zone's power.
    fn is_important(&self, share: f64) -> bool {
        share > self.tolerance * IMPORTANT_SHARE
    }

    fn trace_visibility(&self, pair: ZonePair, range: Range<usize>, tally: &mut PerBand<WeightedMean>) {
        let (points, kappa) = (PairPoints::new(pair.seed), pair.uniform_extinction());
        for k in range {
            let (x, y) = points.both(pair.a, pair.b, k);
            let w = pair_kernel(pair.a, pair.b, x, y);
            let seen = if self.occlusion.is_blocked(x, y) { 0.0 } else { 1.0 };
            if kappa == Bands::ZERO {
                tally[Band::first()].add(w, seen);
            } else {
                let r = (y - x).length();
                let weights = w * (-kappa * r).exp();
                tally.iter_mut().zip(weights).for_each(|(t, w)| t.add(w, seen));
            }
        }
    }

    /// The number of rays of a pair whose `n` rays leave the share `open` of a zone's power open.
    fn rays_for(&self, n: usize, open: f64) -> usize {
        let over = open / (OPEN_SHARE * self.tolerance);
        if over > 1.0 { ((n as f64 * over * over) as usize).min(MAX_RAYS) } else { n }
    }

    /// False where no pane can dim a part of a pair.
    fn may_dim(&self, a: &PreparedZone, b: &PreparedZone) -> bool {
        let (mut p, mut q) = (Vec::new(), Vec::new());
        self.panes_between && self.transport.pane_may_intersect([shaft_end(a, &mut p), shaft_end(b, &mut q)])
    }

    /// Attenuated and visible exchange of two zones by rays; the number follows from distance, occluders and medium.
    pub(super) fn attenuated_along_rays(
        &self,
        pair: ZonePair,
        m: DistanceMoments,
        counts: &mut PairCounts,
    ) -> PairFactor {
        let ZonePair { a, b, .. } = pair;
        let distance = pair.distance();
        let near = distance < 2.0 * (a.diameter + b.diameter);
        let pane = [a, b].iter().any(|z| matches!(z.shape, PreparedShape::Plate { pane: Some(_), .. }));
        let rays = if near && (pane || self.is_thick(a, b))
            || pair.is_varied() && distance < a.diameter.max(b.diameter)
        {
            IMPORTANT_RAYS
        } else if near && pair.is_varied() || self.occlusion.has_occluders && pair.is_close() {
            PARTIAL_RAYS
        } else if self.occlusion.has_occluders || pair.is_varied() || near {
            // In a varying medium e^{−δ} between the centres is no mean over the pair.
            FIRST_RAYS
        } else {
            1
        };
        self.ray_average(pair, m, rays, counts)
    }

    /// The factor of `m` times the mean over rays of visibility, attenuation and the path factors of panes.
    ///
    /// With the mean extinction κ of the rays, ⟨e^{−κr}⟩ by the moments is corrected by the ratio Σ w τ/Σ w e^{−κr} of the same rays: exact in a
    /// uniform medium, and correct where the dimmed or hidden part lies nearer or farther than the rest.
    pub(super) fn ray_average(
        &self,
        pair: ZonePair,
        m: DistanceMoments,
        rays: usize,
        counts: &mut PairCounts,
    ) -> PairFactor {
        if m.factor.value <= 0.0 {
            return PairFactor { value: Bands::ZERO, radius: Bands::splat(m.factor.radius) };
        }
        let sample = self.sample_rays(pair, &m, rays, counts);
        let undetected = self.undetected_fraction(pair, &sample);
        let mut out = PairFactor::default();
        for (k, BandMean { kappa, mean, error, open }) in Band::all().zip(sample.means) {
            let error = error.hypot(undetected * open);
            let base = m.transmittance(kappa);
            let value = m.factor.value * base * mean;
            let radius = base * (m.factor.radius * mean + m.factor.value * error);
            // No medium transmits more than all. (The path factor of a pane is a length.)
            let (most, widest) = if sample.scale == 1.0 {
                (m.factor.value, m.factor.value + m.factor.radius)
            } else {
                (f64::INFINITY, f64::INFINITY)
            };
            (out.value[k], out.radius[k]) = (value.min(most), radius.min(widest));
        }
        out
    }

    /// Traces the rays of a pair, at least `rays`.
    fn sample_rays(
        &self,
        pair: ZonePair,
        m: &DistanceMoments,
        rays: usize,
        counts: &mut PairCounts,
    ) -> RaySample {
        let ZonePair { a, b, seed, .. } = pair;
        let divided = self.occlusion.may_divide(a, b);
        let distance = pair.distance();
        let scale = self.pane_scale(a) * self.pane_scale(b);
        let points = PairPoints::new(seed);
        let mut traced: Vec<PairRay> = Vec::with_capacity(rays.max(PARTIAL_RAYS));
        let share = power_share(m.factor.value, a, b);
        let undecided = divided && rays > 1 && rays < IMPORTANT_RAYS;
        let important = undecided && self.is_important(share);
        // Rays without weight show whether an important pair is partly visible.
        let start = if important { rays } else { 0 };
        let trace = |to: usize, traced: &mut Vec<PairRay>| {
            for k in traced.len()..to {
                let (x, y) = if rays == 1 { (a.centre, b.centre) } else { points.both(a, b, start + k) };
                traced.push(self.trace_ray(pair, x, y, divided));
            }
        };
        let (mut rim, mut n) = (RimVisibility::default(), rays);
        if important {
            let hidden = |&k: &usize| {
                let (x, y) = points.both(a, b, k);
                self.trace_ray(pair, x, y, divided).is_dark()
            };
            let blocked = (0..rays).filter(hidden).count();
            rim = self.occlusion.rim_visibility(a, b);
            counts.rays += rays as u64 + rim.rays;
            if blocked > 0 && blocked < rays || rim.disagrees(RayConsensus::of(blocked as u64)) {
                counts.partial += 1;
                n = IMPORTANT_RAYS;
            }
        } else if undecided {
            n = rays.max(UNIMPORTANT_RAYS);
        }
        // Trace the rays of the mean.
        trace(n, &mut traced);
        // Trace enough rays that an undetected pane is unimportant.
        let dimmed = rays > 1 && self.may_dim(a, b);
        if dimmed {
            let n = (share / (OPEN_SHARE * self.tolerance)) as usize;
            trace(n.min(MAX_RAYS).max(traced.len()), &mut traced);
        }
        // Add rays until the error leaves an admissible share of power open.
        let mut means = self.band_means(a, b, &traced);
        for _ in 0..if rays > 1 { MAX_ROUNDS } else { 0 } {
            let open = means.iter().fold(0.0f64, |m, s| m.max(scale * s.error * (-s.kappa * distance).exp()));
            let want = self.rays_for(traced.len(), share * open);
            if want <= traced.len() {
                break;
            }
            trace(want, &mut traced);
            means = self.band_means(a, b, &traced);
        }
        counts.rays += traced.len() as u64;
        RaySample { rays: traced, rim, divided, dimmed, scale, means }
    }

    /// The fraction of a pair that rays which all agree may leave undetected behind facets or panes.
    fn undetected_fraction(&self, pair: ZonePair, sample: &RaySample) -> f64 {
        let n = sample.rays.len();
        let mut undetected = 0.0f64;
        let blocked = sample.rays.iter().filter(|r| r.blocked).count();
        if sample.divided && (blocked == 0 || blocked == n) {
            let consensus = RayConsensus::of(blocked as u64);
            undetected = self.uncertainty.deviation(pair.a, pair.b, consensus)
                * succession_bound(n as f64, sample.rim, consensus);
        }
        let behind = sample.rays.iter().filter(|r| r.dimmed).count();
        if sample.dimmed && (behind == 0 || behind == n) {
            let consensus = RayConsensus::of(behind as u64);
            undetected = undetected.hypot(succession_bound(n as f64, RimVisibility::default(), consensus));
        }
        undetected
    }

    /// The means over the rays of a pair in each band.
    fn band_means(&self, a: &PreparedZone, b: &PreparedZone, rays: &[PairRay]) -> PerBand<BandMean> {
        let thick = self.is_thick(a, b);
        let length: f64 = rays.iter().map(|r| r.weight * r.length).sum();
        let weights: f64 = rays.iter().map(|r| r.weight).sum();
        PerBand::from_fn(|k| {
            let chords = thick && a.optical_thickness[k].max(b.optical_thickness[k]) > MAX_CUMULANT_DEPTH;
            let depth: f64 = rays.iter().map(|r| r.weight * r.depth[k]).sum();
            let mean = depth / length;
            // Rays much longer than the medium that dims them would have unbounded ratios.
            let excess = rays.iter().fold(0.0f64, |m, r| m.max(mean * r.length - r.depth[k]));
            let usable =
                length > 0.0 && depth <= MAX_REFERENCE_DEPTH * weights && excess <= MAX_REFERENCE_DEPTH;
            let kappa = if usable && !chords { mean } else { 0.0 };
            let (mut all, mut open) = (WeightedMean::default(), WeightedMean::default());
            for r in rays {
                let reference = (-kappa * r.length).exp();
                let tau = if chords && !r.blocked { r.chords[k] } else { (-r.depth[k]).exp() };
                let x = if reference > 0.0 { r.panes[k] * tau / reference } else { 0.0 };
                all.add(r.weight * reference, if r.blocked { 0.0 } else { x });
                open.add(r.weight * reference, x);
            }
            let (mean, error) = all.mean_and_error();
            BandMean { kappa, mean, error, open: open.mean_and_error().0 }
        })
    }

    /// The ray from x to y; facets are tested where the pair may be `divided`.
    fn trace_ray(&self, pair: ZonePair, x: Vec3, y: Vec3, divided: bool) -> PairRay {
        let ZonePair { a, b, .. } = pair;
        let d = y - x;
        let r = d.length();
        let weight = pair_kernel(a, b, x, y);
        let depth = match pair.uniform {
            Some(kappa) => kappa * r,
            None => self.transport.medium_depth(x, y),
        };
        let panes = self.pane_path_factor(a, d / r) * self.pane_path_factor(b, d / r);
        let mut ray =
            PairRay { weight, length: r, depth, chords: Bands::ZERO, panes, dimmed: false, blocked: false };
        ray.blocked = divided && self.occlusion.is_blocked(x, y);
        if ray.blocked {
            return ray;
        }
        if self.is_thick(a, b) {
            ray.chords = self.chord_transmittance(pair, x, y);
        }
        if self.panes_between && pair.is_varied() {
            let all = self.transport.optical_depth_inside(x, y);
            ray.panes *= (depth - all).min(Bands::ZERO).exp();
            ray.dimmed = Band::all().any(|k| all[k] > depth[k]);
        }
        ray
    }

    /// True where the cumulants of the distance do not determine the attenuation.
    pub(super) fn is_thick(&self, a: &PreparedZone, b: &PreparedZone) -> bool {
        let cut = a.samples().or(b.samples()).is_some();
        !cut && a.optical_thickness.max(b.optical_thickness).any(|depth| depth > MAX_CUMULANT_DEPTH)
    }

    /// Attenuation along the line through x and y, averaged over its chords in both zones: on a given line the points of a pair
    /// are uniform (dV dV'/r² = dA⊥ dω ds ds'), so each voxel gives (1 − e^{−κℓ})/(κℓ), and the space between e^{−δ}.
    fn chord_transmittance(&self, pair: ZonePair, x: Vec3, y: Vec3) -> Bands {
        let ZonePair { a, b, uniform, .. } = pair;
        let w = (y - x).normalized();
        let r = (y - x).length();
        let (from, share_a) = chord(a, x, w, r);
        let (to, share_b) = chord(b, y, -w, r);
        let between = match uniform {
            Some(kappa) => kappa * (to - from).dot(w).max(0.0),
            None if (to - from).dot(w) > 0.0 => self.transport.medium_depth(from, to),
            None => Bands::ZERO,
        };
        (-between).exp() * share_a * share_b
    }

    /// (1 − e^{−κt/c})/κ of a pane in direction `w`, m; 1 of any other zone.
    fn pane_path_factor(&self, z: &PreparedZone, w: Vec3) -> Bands {
        let PreparedShape::Plate { pane: Some(k), .. } = z.shape else {
            return Bands::ONE;
        };
        self.zones.panes[k].effective_path(w)
    }

    /// The inverse thickness of a pane, 1/m, which makes its path factor a share of its power; 1 of any other zone.
    fn pane_scale(&self, z: &PreparedZone) -> f64 {
        match z.shape {
            PreparedShape::Plate { pane: Some(k), .. } => 1.0 / self.zones.panes[k].thickness,
            _ => 1.0,
        }
    }
}

/// The point where a line leaves a whole voxel from `x` along `w`, at most `reach` away, with (1 − e^{−κℓ})/(κℓ) of its chord there; of any
/// other zone, `x` and 1.
fn chord(z: &PreparedZone, x: Vec3, w: Vec3, reach: f64) -> (Vec3, Bands) {
    if !matches!(z.shape, PreparedShape::Voxel) {
        return (x, Bands::ONE);
    }
    let (mut ahead, mut behind) = (reach, f64::INFINITY);
    for axis in (0..3).filter(|&k| w[k] != 0.0) {
        let (p, q) = ((z.lo[axis] - x[axis]) / w[axis], (z.hi[axis] - x[axis]) / w[axis]);
        ahead = ahead.min(p.max(q).max(0.0));
        behind = behind.min(-p.min(q).min(0.0));
    }
    let length = ahead + behind;
    let mean = |depth: f64| if depth > 1e-9 { -(-depth).exp_m1() / depth } else { 1.0 };
    (x + w * ahead, z.optical_thickness.map(|t| mean(t / z.diameter * length)))
}

/// F of a pane with itself per area and κ²: (4κt − 2 (1 − 2 E_3(κt)))/κ², the emission that its faces do not transmit.
pub fn pane_self_exchange(kappa: f64, thickness: f64) -> f64 {
    let tau = kappa * thickness;
    ((4.0 * tau - 2.0 * (1.0 - 2.0 * exponential_integral::e3(tau))) / (kappa * kappa)).max(0.0)
}
