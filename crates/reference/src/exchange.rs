//! g_ij = F_ij/(c_i c_j) of two bodies by random samples, with c = κ for volumes and panes and 1 for patches.
//!
//! **By rays**: origins and directions have the density of the kernel of body a (cosine on a patch, uniform in a volume, |cosine|
//! times (1 − e^{−κt/c})/κ on a pane). The score on b is τ (patch), ∫ τ ds inside (volume), τ (1 − e^{−κt/c})/κ (pane). Scores are
//! bounded, so touching and overlapping bodies are as accurate as others.
//!
//! **By points**: the definition (1/π) ∬ τ V cosθ_a cosθ_b/r², for bodies that are apart.

use crate::brute_force::{self, BruteForceScene};
use crate::estimate::{SampleEstimate, SampleStatistics, add_sample};
use crate::rng::Rng;
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::{Band, Bands, PerBand, Plate, Scene, ZoneRef, Zones};

/// A body that exchanges radiation.
#[derive(Clone, Debug)]
pub enum ExchangeBody {
    /// The front of a plate.
    Patch(Plate),
    /// A box clipped to the half-spaces n·x ≥ c.
    Volume {
        /// Lower corner, m.
        lo: Vec3,
        /// Upper corner, m.
        hi: Vec3,
        /// Half-spaces (n, c).
        planes: Vec<(Vec3, f64)>,
    },
    /// A pane.
    Pane {
        /// Middle plane.
        plate: Plate,
        /// Thickness, m.
        thickness: f64,
        /// Extinction, 1/m.
        extinction: Bands,
    },
}

/// (1 − e^{−κt/c})/κ for the path t/c, m.
fn absorbed_length(extinction: Bands, path: f64) -> Bands {
    extinction.map(|k| if k * path < 1e-9 { path } else { (1.0 - (-k * path).exp()) / k })
}

/// True when `x` lies in all half-spaces.
fn in_half_spaces(planes: &[(Vec3, f64)], x: Vec3) -> bool {
    planes.iter().all(|(n, c)| n.dot(x) >= *c)
}

impl ExchangeBody {
    /// An unclipped box.
    pub fn cuboid(lo: Vec3, hi: Vec3) -> ExchangeBody {
        ExchangeBody::Volume { lo, hi, planes: Vec::new() }
    }

    /// The body of zone `i`; of a volume zone its whole cell.
    pub fn of(scene: &Scene, zones: &Zones, i: usize) -> ExchangeBody {
        match zones.zone(i) {
            ZoneRef::Patch(p) => ExchangeBody::Patch(p.plate),
            ZoneRef::Voxel(_, z) => {
                let grid = scene.voxel_grid().expect("volume zones come from a grid");
                let lo = grid.corner(grid.coordinates(z.cell));
                ExchangeBody::cuboid(lo, lo + grid.cell())
            }
            ZoneRef::Pane(_, p) => {
                ExchangeBody::Pane { plate: p.plate, thickness: p.thickness, extinction: p.extinction }
            }
        }
    }

    /// A ray of the body's density and its weight per band: area, 4 × volume, or that of the pane.
    fn emit(&self, rng: &mut Rng) -> (Vec3, Vec3, Bands) {
        match self {
            ExchangeBody::Patch(p) => {
                (rng.point_on_plate(p), rng.cosine_direction(p.normal()), Bands::splat(p.area()))
            }
            ExchangeBody::Volume { lo, hi, planes } => {
                let x = rng.point_in_box(*lo, *hi);
                let w = if in_half_spaces(planes, x) { 4.0 * (*hi - *lo).product() } else { 0.0 };
                (x, rng.unit_vector(), Bands::splat(w))
            }
            ExchangeBody::Pane { plate, thickness, extinction } => {
                let n = plate.normal();
                let n = if rng.uniform() < 0.5 { n } else { -n };
                let (x, d) = (rng.point_on_plate(plate), rng.cosine_direction(n));
                let path = thickness / n.dot(d).max(1e-9);
                (x, d, 2.0 * plate.area() * absorbed_length(*extinction, path))
            }
        }
    }

    /// Score of a ray of length `limit` on this body, per band.
    fn score(&self, w: &BruteForceScene, o: Vec3, d: Vec3, limit: f64) -> Bands {
        let none = Bands::ZERO;
        match self {
            ExchangeBody::Patch(p) => match brute_force::intersect_plate(p, o, d) {
                Some((t, _)) if t > w.near && t <= limit + w.near && d.dot(p.normal()) < 0.0 => {
                    (-w.optical_depth(o, d, t)).exp()
                }
                _ => none,
            },
            ExchangeBody::Pane { plate, thickness, extinction } => {
                match brute_force::intersect_plate(plate, o, d) {
                    Some((t, _)) if t > w.near && t < limit => {
                        let tau = (-w.optical_depth(o, d, t)).exp();
                        let s = absorbed_length(*extinction, thickness / d.dot(plate.normal()).abs());
                        tau * s
                    }
                    _ => none,
                }
            }
            ExchangeBody::Volume { lo, hi, planes } => {
                let (mut t0, mut t1) = (0.0f64, limit);
                let mut sides: Vec<(Vec3, f64)> = planes.clone();
                for axis in 0..3 {
                    let mut e = [0.0; 3];
                    e[axis] = 1.0;
                    let e = Vec3::from_array(e);
                    sides.extend([(e, lo[axis]), (-e, -hi[axis])]);
                }
                for (n, c) in sides {
                    let (h, g) = (n.dot(o) - c, n.dot(d));
                    if g > 0.0 {
                        t0 = t0.max(-h / g);
                    } else if g < 0.0 {
                        t1 = t1.min(-h / g);
                    } else if h < 0.0 {
                        return none;
                    }
                }
                if t1 <= t0 { none } else { transmittance_integral(w, o, d, t0, t1) }
            }
        }
    }
}

/// ∫ τ ds from t0 to t1, per band.
fn transmittance_integral(w: &BruteForceScene, o: Vec3, d: Vec3, t0: f64, t1: f64) -> Bands {
    let (mut depth, mut sum) = (Bands::ZERO, Bands::ZERO);
    for segment in w.segments(o, d, t1) {
        let kappa = w.extinction(&segment);
        let (a, b) = (segment.from.max(t0), segment.to.min(t1));
        for k in Band::all() {
            depth[k] += segment.pane.map_or(0.0, |p| p.1[k]);
            if b > a {
                let tau = (-(depth[k] + kappa[k] * (a - segment.from))).exp();
                let x = kappa[k] * (b - a);
                sum[k] += tau * if x < 1e-9 { b - a } else { (1.0 - (-x).exp()) / kappa[k] };
            }
            depth[k] += kappa[k] * (segment.to - segment.from);
        }
    }
    sum
}

/// g_ab per band by `n` rays from a.
pub fn exchange_by_rays(
    w: &BruteForceScene,
    a: &ExchangeBody,
    b: &ExchangeBody,
    n: usize,
    seed: u64,
) -> PerBand<SampleEstimate> {
    let (mut rng, mut statistics) = (Rng::new(seed), PerBand::<SampleStatistics>::default());
    for _ in 0..n {
        let (o, d, weight) = a.emit(&mut rng);
        let limit = w.first_hit(o, d).map_or(w.far, |s| s.t);
        let s = if weight == Bands::ZERO { Bands::ZERO } else { b.score(w, o, d, limit) };
        add_sample(&mut statistics, weight * s);
    }
    statistics.map(|t| t.estimate(1.0))
}

/// g_ab per band of patches or volumes by `n` pairs of points.
///
/// # Panics
///
/// When a body is a pane.
pub fn exchange_by_points(
    w: &BruteForceScene,
    a: &ExchangeBody,
    b: &ExchangeBody,
    n: usize,
    seed: u64,
) -> PerBand<SampleEstimate> {
    let (mut rng, mut statistics) = (Rng::new(seed), PerBand::<SampleStatistics>::default());
    let point = |z: &ExchangeBody, rng: &mut Rng| match z {
        ExchangeBody::Patch(p) => (rng.point_on_plate(p), p.area()),
        ExchangeBody::Volume { lo, hi, planes } => {
            let x = rng.point_in_box(*lo, *hi);
            (x, if in_half_spaces(planes, x) { (*hi - *lo).product() } else { 0.0 })
        }
        ExchangeBody::Pane { .. } => panic!("a pane has no thickness for points; use rays"),
    };
    let cosine = |z: &ExchangeBody, d: Vec3| {
        if let ExchangeBody::Patch(p) = z { p.normal().dot(d).max(0.0) } else { 1.0 }
    };
    for _ in 0..n {
        let ((x, ma), (y, mb)) = (point(a, &mut rng), point(b, &mut rng));
        let r = (y - x).length();
        let d = (y - x) / r;
        let kernel = cosine(a, d) * cosine(b, -d) * ma * mb / (PI * r * r);
        let tau =
            if kernel > 0.0 && w.visible(x, y) { (-w.optical_depth(x, d, r)).exp() } else { Bands::ZERO };
        add_sample(&mut statistics, kernel * tau);
    }
    statistics.map(|t| t.estimate(1.0))
}
